"""Sections of the physics benchmark that simulate: push error, and steps a second."""

import time
from pathlib import Path
from typing import Any, Final

from benchmarks.report import table
from openrooms_usd import adapters
from openrooms_usd.physics.world import World
from openrooms_usd.simulation import pushing

ENGINES: Final = ("pybullet", "mujoco")
_FLOORS: Final = {"carpet": pushing.CARPET, "wax": pushing.WAX}
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
                rows.append({"floor": floor, "motor, N": effort, "Coulomb, m": way,
                             "the paper, m": pushing.PAPER[coefficient],
                             "step, ms": 1e3 * step, **errors})  # fmt: skip
    return rows, _table(rows)


def speed(quick: bool, folder: Path) -> tuple[list[dict[str, Any]], str]:
    """Steps a second of furnished rooms that rest, in one run."""
    rows = []
    for name, world in _rooms(folder):
        shapes = sum(len(link.shapes) for body in world.bodies for link in body.links)
        free = sum(not body.fixed for body in world.bodies)
        rates = {f"{engine}, steps/s": _rate(engine, world, quick) for engine in ENGINES}
        first, second = rates.values()
        rows.append({"room": name, "free bodies": free, "shapes": shapes, **rates,
                     "mujoco / pybullet": second / first})  # fmt: skip
    return rows, _table(rows)


def _rooms(folder: Path) -> list[tuple[str, World]]:
    from openrooms_usd.cli.composing import copy_example
    from openrooms_usd.compose import compose_room
    from openrooms_usd.usd.layers import open_stage
    from openrooms_usd.usd.rigid import read_world

    scene = compose_room(copy_example(folder / "source"), folder / "demo").scene
    return [("the bundled example", read_world(open_stage(scene)))]


def _rate(engine: str, world: World, quick: bool) -> float:
    """Steps a second of the processor, after what falls has fallen."""
    simulation = adapters.load(adapters.ENGINES, engine).open(world)
    try:
        simulation.step(0.02 if quick else 0.2)
        seconds = 0.02 if quick else 1.0
        began = time.perf_counter()
        simulation.step(seconds)
        return round(seconds / simulation.timestep) / (time.perf_counter() - began)
    finally:
        simulation.close()


def _table(rows: list[dict[str, Any]]) -> str:
    return table(tuple(rows[0]), [list(row.values()) for row in rows])
