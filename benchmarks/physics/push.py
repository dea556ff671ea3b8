"""Sections of the physics benchmark that simulate: push error, and steps a second."""

import time
from pathlib import Path
from typing import Any, Final

import numpy as np

from benchmarks.report import table
from openrooms_usd import adapters
from openrooms_usd.physics.world import World
from openrooms_usd.simulation import pushing

ENGINES: Final = ("pybullet", "mujoco")
_FLOORS: Final = {"carpet": pushing.CARPET, "wax": pushing.WAX}
_GENERATED: Final = ("living_room", "kitchen")
_STEPS: Final = (0.008, 0.004, 0.002, 0.001, 0.0005)


def push(quick: bool, folder: Path) -> tuple[list[dict[str, Any]], str]:
    """How far both engines push the paper's cabinet, against Coulomb's closed form."""
    del folder
    rows = []
    engines = {name: adapters.load(adapters.ENGINES, name) for name in ENGINES}
    for floor, coefficient in _FLOORS.items():
        for effort in (pushing.WEAK, pushing.STRONG):
            case = pushing.Push(coefficient, effort)
            way = pushing.predicted(case)
            for step in _STEPS[1:3] if quick else _STEPS:
                found = {n: pushing.simulated(case, e, step) for n, e in engines.items()}
                errors = {f"{n}, %": 100.0 * (value / way - 1.0) for n, value in found.items()}
                rows.append(
                    {
                        "floor": floor,
                        "motor, N": effort,
                        "Coulomb, m": way,
                        "the paper, m": pushing.PAPER[coefficient],
                        "step, ms": 1e3 * step,
                        **errors,
                    }
                )
    return rows, _table(rows)


def speed(quick: bool, folder: Path) -> tuple[list[dict[str, Any]], str]:
    """Furnished rooms at rest: steps a second, and how far things creep meanwhile."""
    rows = []
    for name, world in _rooms(folder, quick):
        shapes = sum(len(link.shapes) for body in world.bodies for link in body.links)
        free = sum(not body.fixed for body in world.bodies)
        for step in _STEPS[1:3] if quick else _STEPS[:4]:
            row = {"room": name, "free bodies": free, "shapes": shapes, "step, ms": 1e3 * step}
            for engine in ENGINES:
                rate, way = _rate(engine, world, step, quick)
                row |= {f"{engine}, steps/s": rate, f"{engine}, moved mm": 1e3 * way}
            bullet, mujoco = (row[f"{engine}, steps/s"] for engine in ENGINES)
            rows.append({**row, "mujoco / pybullet": mujoco / bullet})
    return rows, _table(rows)


def _rooms(folder: Path, quick: bool) -> list[tuple[str, World]]:
    from openrooms_usd.composing import compose_room
    from openrooms_usd.demo import copy_example
    from openrooms_usd.generation import generate, write
    from openrooms_usd.usd.files.layers import open_stage
    from openrooms_usd.usd.rigid.reading import read_world

    described = {} if quick else {"the bundled example": copy_example(folder / "source")}
    for kind in ("hallway",) if quick else _GENERATED:
        path = folder / f"{kind}.yaml"
        physics = "{shapes: hull}" if quick else "{}"
        text = f"{write(generate(kind, 1))}\nphysics: {physics}\n"
        path.write_text(text, encoding="utf-8")
        described[f"generated {kind}"] = path
    scenes = {
        name: compose_room(path, folder / path.stem).scene for name, path in described.items()
    }
    return [(name, read_world(open_stage(scene))) for name, scene in scenes.items()]


def _rate(engine: str, world: World, step: float, quick: bool) -> tuple[float, float]:
    """Steps a second of the processor, and the farthest way of a body in that time, metres."""
    simulation = adapters.load(adapters.ENGINES, engine).open(world, timestep=step)
    try:
        before = simulation.poses()
        seconds = 0.04 if quick else 2.0
        began = time.process_time()
        simulation.step(seconds)
        spent = time.process_time() - began
        after = simulation.poses()
        ways = [after[name].world_from_body - before[name].world_from_body for name in before]
        return round(seconds / step) / spent, float(np.linalg.norm(ways, axis=1)[:, 3].max())
    finally:
        simulation.close()


def _table(rows: list[dict[str, Any]]) -> str:
    return table(tuple(rows[0]), [list(row.values()) for row in rows])
