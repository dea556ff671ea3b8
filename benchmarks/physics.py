"""Physics: collision shapes, pushes and speed.

shapes: seconds and hulls of every way to collision shapes, against how far they stick out and in.
push: how far both engines push the paper's cabinet, against Coulomb's closed form, by step.
speed: steps a second of furnished rooms at rest, and how far things creep in two seconds; both
engines in one run.
"""

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from benchmarks.report import publish, table
from openrooms_usd import adapters
from openrooms_usd.furniture import make
from openrooms_usd.physics.collision_error import collision_error, volumes
from openrooms_usd.physics.components import Part, components
from openrooms_usd.physics.decomposition import METHODS, Method, collision_shapes
from openrooms_usd.physics.solid import Solid
from openrooms_usd.physics.world import World
from openrooms_usd.showroom.exhibits import Exhibit, exhibits
from openrooms_usd.simulation import pushing

# Sections of the physics benchmark that simulate: push error, and steps a second.

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


Section = tuple[list[dict[str, Any]], str]


def shapes(quick: bool, folder: Path) -> Section:
    """What the physics step takes, one hull, and one box."""
    del folder
    rows = shape_rows(QUICK if quick else ORDINARY + HARD)
    return rows, table(tuple(rows[0]), [list(row.values()) for row in rows])


SECTIONS: Final[dict[str, Callable[[bool, Path], Section]]] = {
    "shapes": shapes,
    "push": push,
    "speed": speed,
}


@click.command(help=__doc__)
@click.option("--section", "chosen", multiple=True, help="Repeatable; all by default.")
@click.option("--quick", is_flag=True, help="Few objects, few steps.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(chosen: tuple[str, ...], quick: bool, target: Path | None) -> None:
    with tempfile.TemporaryDirectory() as folder:
        found = {name: SECTIONS[name](quick, Path(folder)) for name in chosen or SECTIONS}
    text = "\n\n".join(f"## {name}\n\n{markdown}" for name, (_, markdown) in found.items())
    publish("physics", {name: rows for name, (rows, _) in found.items()}, text, target)


# Collision shapes: seconds, shapes and corners against the error, by every method, side by side.
#
# Distances are upper bounds: how far the shapes stick out of the object, and how far its surface
# lies outside of them. The volume is that of the union of the shapes by that of the object.

# Ordinary objects, and some that are hard: shells, curved ones, and many parts.
ORDINARY: Final = ("table", "chair", "stool", "cabinet", "monitor")
HARD: Final = ("bowl", "trash_bin", "bathtub")
QUICK: Final = ("table", "chair", "bowl")


@dataclass(frozen=True)
class Result:
    """One method on one object."""

    object: str
    method: str
    seconds: float
    shapes: int
    boxes: int
    corners: int
    protrusion_mm: float
    uncovered_mm: float
    volume_ratio: float


def parts_of(exhibit: Exhibit) -> list[Part]:
    """The object in its closed pose, as one link of one contact material."""
    made = make(exhibit.category, exhibit.size, exhibit.style, np.random.default_rng(0))
    found = []
    for name, mesh in made.parts.items():
        corners, _ = mesh.triangles()
        found.append(Part(name, mesh.points, mesh.indices[corners]))
    return found


def measured(exhibit: Exhibit, method: Method, tolerance: float) -> Result:
    """One row of the table."""
    parts = parts_of(exhibit)
    start = time.perf_counter()
    found = collision_shapes(parts, method, tolerance)
    seconds = time.perf_counter() - start
    meshes, thing = [shape.mesh for shape in found.shapes], Solid(components(parts))
    error, filled = collision_error(meshes, thing), volumes(meshes, thing)
    return Result(
        exhibit.name,
        method,
        seconds,
        len(meshes),
        sum(shape.box for shape in found.shapes),
        sum(len(mesh.points) for mesh in meshes),
        1000.0 * error.protrusion,
        1000.0 * error.uncovered,
        filled.shapes / filled.thing if filled.thing > 0 else float("nan"),
    )


def shape_rows(
    categories: tuple[str, ...] = ORDINARY + HARD,
    methods: tuple[Method, ...] = METHODS,
    tolerance: float = 0.01,
) -> list[dict[str, Any]]:
    """The rows of the table: every object by every method."""
    return [
        vars(measured(exhibit, method, tolerance))
        for exhibit in exhibits(categories)
        for method in methods
    ]


if __name__ == "__main__":
    main()
