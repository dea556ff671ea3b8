"""How long a flat of many labelled things takes, and how far they are from the truth.

`python -m benchmarks.scan.flat`: four rooms of sixteen things, which the library builds, in a scan
of 1.5 million points.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Final, TypeVar, cast

import click
import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.description.furniture import ScanFurniture
from openrooms_usd.draws import generator
from openrooms_usd.furniture import make, styles
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.rotations import about_z
from openrooms_usd.library.assets import model_of
from openrooms_usd.library.models.cads import merged
from openrooms_usd.scan.artefact import FoundScan
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.reconstruction import find_furniture, find_rooms
from openrooms_usd.steps.alignment.shelf import CadCandidates

# A word, width, depth and height, the middle in the room and the heading in degrees.
THINGS: Final = (
    ("bed", (1.6, 2.0, 0.9), (1.5, 4.0), 0),
    ("night stand", (0.45, 0.4, 0.55), (0.4, 4.8), 0),
    ("night stand", (0.45, 0.4, 0.55), (2.6, 4.8), 0),
    ("wardrobe", (1.2, 0.6, 2.0), (4.0, 4.7), 0),
    ("cabinet", (0.8, 0.45, 0.9), (5.3, 4.775), 0),
    ("desk", (1.4, 0.7, 0.75), (5.65, 3.0), -90),
    ("office chair", (0.6, 0.6, 1.0), (4.9, 3.0), 90),
    ("bookshelf", (0.8, 0.3, 1.9), (5.85, 1.2), -90),
    ("sofa", (1.9, 0.9, 0.85), (0.45, 1.6), 90),
    ("coffee table", (1.0, 0.55, 0.42), (1.6, 1.6), 90),
    ("armchair", (0.8, 0.8, 0.85), (1.6, 0.4), 180),
    ("table", (1.4, 0.8, 0.74), (3.6, 1.6), 0),
    *(
        ("chair", (0.45, 0.5, 0.9), (x, y), h)
        for x in (3.3, 3.9)
        for y, h in ((0.9, 180), (2.3, 0))
    ),
)
ROOM: Final = np.array([6.0, 5.0, 2.6])
WALL: Final = 0.12
SENSORS: Final = ((1.0, 2.6), (2.6, 3.0), (4.2, 3.6), (2.5, 0.6), (4.6, 0.8), (2.6, 2.2))
NOISE: Final = 0.005
# Degrees after which a thing of each symmetry looks the same.
TURNS: Final = {"none": 360.0, "2": 180.0, "4": 90.0, "inf": 1e-9}
_Made = TypeVar("_Made")


@dataclass(frozen=True, eq=False)
class Thing:
    """What is true of a thing: its word, size, middle of the base and heading, metres, degrees."""

    word: str
    size: Array
    base: Array
    heading: float


def flat(points: int, rooms: int) -> tuple[Cloud, dict[int, Thing]]:
    """A scan of rooms in two rows, with an instance for each thing, and what is true of it."""
    clouds, true = [], {}
    for number in range(rooms):
        corner = np.array([number // 2, number % 2]) * (ROOM[:2] + WALL)
        things = dict(enumerate(_things(number, corner), 1 + number * len(THINGS)))
        true |= things
        clouds.append(_scanned(corner, things, points // rooms, number))
    return Cloud(
        np.concatenate([cloud.points for cloud in clouds]),
        instance=np.concatenate([cloud.instance for cloud in clouds if cloud.instance is not None]),
        sensor_origins=np.concatenate(
            [c.sensor_origins for c in clouds if c.sensor_origins is not None]
        ),
        words={instance: (thing.word,) for instance, thing in true.items()},
    ), true


def _things(number: int, corner: Array) -> Iterator[Thing]:
    random = generator(number, "flat")
    for word, size, middle, heading in THINGS:
        # Backs stay where they are: at their walls.
        own = np.array(size) * [*np.exp(random.uniform(-0.06, 0.06, 2)), 1.0]
        back = about_z(np.radians(heading)) @ [0.0, 0.5 * (size[1] - own[1]), 0.0]
        yield Thing(word, own, np.array([*(corner + middle), 0.0]) + back, heading)


def _scanned(corner: Array, things: dict[int, Thing], count: int, seed: int) -> Cloud:
    parts = [_shell(corner), *(_mesh(thing, number) for number, thing in things.items())]
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = np.concatenate([f + n for (_, f), n in zip(parts, starts, strict=False)])
    owner = np.repeat([0, *things], [len(f) for _, f in parts])
    caster = RayCaster(np.concatenate([vertices for vertices, _ in parts]), faces)
    random = generator(seed, "flat", "rays")
    origins = np.array([[*(corner + place), 1.5] for place in SENSORS])
    points, instance = [], []
    for origin in origins:
        ways = random.normal(size=(count // len(origins), 3))
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        hits = caster.first_hit(origin, ways)
        far = hits.distance + NOISE * random.normal(size=len(ways))
        hit = hits.triangle >= 0
        points.append((origin + ways * far[:, None])[hit])
        instance.append(owner[hits.triangle[hit]])
    return Cloud(
        np.concatenate(points),
        instance=np.concatenate(instance).astype(np.int32),
        sensor_origins=origins,
    )


def _shell(corner: Array) -> tuple[Array, Ints]:
    bits = np.array([[i >> 2, i >> 1 & 1, i & 1] for i in range(8)])
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    faces = [each for a, b, c, d in quads for each in ((a, b, c), (a, c, d))]
    return bits * ROOM + [*corner, 0.0], np.array(faces)


def _mesh(thing: Thing, number: int) -> tuple[Array, Ints]:
    name, (width, depth, height) = thing.word.replace(" ", "_"), thing.size.tolist()
    choices = styles(name, (width, depth, height))
    made = make(name, (width, depth, height), choices[number % len(choices)], generator(number))
    vertices, faces = merged(model_of(made), np.eye(4))
    return vertices @ about_z(np.radians(thing.heading)).T + thing.base, faces


@click.command()
@click.option("--points", default=1_500_000, show_default=True)
@click.option("--rooms", default=4, show_default=True)
@click.option("--workers", default=1, show_default=True)
def main(points: int, rooms: int, workers: int) -> None:
    """Print seconds and errors."""
    cloud, true = flat(points, rooms)
    click.echo(f"{len(true)} things, {len(cloud):,} points")
    layout = _timed("layout", lambda: find_rooms(cloud))
    scan = FoundScan("flat", layout.cloud, layout.rooms, tuple(range(len(layout.rooms))), np.eye(4))
    context = cast(Any, SimpleNamespace(source=Path()))
    shelf = CadCandidates(context, ScanFurniture(**{"from": "scan"}), scan)
    models = _timed("models", lambda: shelf.models)
    found = _timed(
        "alignment and placement",
        lambda: find_furniture(
            scan.cloud, scan.composed, models, shelf.hints, unresolved="leave_out", workers=workers
        ),
    )
    by_id = {model.id: model for model in models}
    rows = []
    for item in found.objects:
        for pose in (item.pose, item.placed or item.pose):
            matrix = layout.level.scan_from_level @ pose.matrix
            corners = by_id[item.cad].extent[
                [[i >> 2, i >> 1 & 1, i & 1] for i in range(8)], [0, 1, 2]
            ]
            rows.append(_error(true[item.instance], matrix, corners, TURNS[item.symmetry]))
    errors = np.array(rows).reshape(-1, 2, 3)
    for name, each in (("measured", errors[:, 0]), ("placed", errors[:, 1])):
        away, turn, size = np.moveaxis(each, 1, 0)
        tight = (away < 0.05) & (turn < 5.0) & (size < 0.05)
        click.echo(
            f"{name}: median {100 * np.median(away):.2f} cm {np.median(turn):.2f} degrees "
            f"{100 * np.median(size):.2f} %, within 5 cm, 5 degrees, 5 %: {tight.sum()}, within "
            f"20: {((away < 0.2) & (turn < 20) & (size < 0.2)).sum()} of {len(true)}"
        )
    left = [f"{one.word} {one.instance}: {one.reason}" for one in found.left_out]
    click.echo("\n".join([*left, *map(str, found.rejected)]) or "none left out")


def _timed(what: str, work: Callable[[], _Made]) -> _Made:
    cpu, clock = time.process_time(), time.perf_counter()
    made = work()
    cpu, clock = time.process_time() - cpu, time.perf_counter() - clock
    click.echo(f"{what}: {cpu:.1f} s of processor, {clock:.1f} s")
    return made


def _error(
    thing: Thing, matrix: Array, corners: Array, period: float
) -> tuple[float, float, float]:
    """Metres between the middles of the bases, degrees, and the largest share of a size."""
    middle = corners.mean(axis=0)
    middle[2] = corners[:, 2].min()
    away = float(np.linalg.norm(matrix[:3, :3] @ middle + matrix[:3, 3] - thing.base))
    heading = float(np.degrees(np.arctan2(matrix[1, 0], matrix[0, 0])))
    turn = abs((heading - thing.heading + 0.5 * period) % period - 0.5 * period)
    size = np.linalg.norm(matrix[:3, :3], axis=0) * np.ptp(corners, axis=0)
    return away, turn, float(np.abs(size / thing.size - 1.0).max())


if __name__ == "__main__":
    main()
