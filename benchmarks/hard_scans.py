"""Scans that are hard or bad, each built so that its truth is known."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from benchmarks.scan_built import Hole, Thing, built
from benchmarks.scan_labels import spoiled
from benchmarks.scan_rooms import GLASS, MIRROR, SimulatedRoom
from benchmarks.scanner import Scan, Scanner, simulate
from openrooms_usd.draws import generator
from openrooms_usd.scan.cloud import Cloud

Array = NDArray[np.float64]

Outline = tuple[tuple[float, float], ...]

QUICK: Final = Scanner(frames=40, reduce=4, voxel=0.02, wrong_labels=0.05)


@dataclass(frozen=True, eq=False)
class HardCase:
    """A scan and what shall become of it.

    Attributes:
        scan: The points as a file would give them, times ``unit`` metres; its truth in metres.
        usable: Whether a room can be found; else the scan shall be refused with a reason.
        unit: Metres of the points' unit.
    """

    scan: Scan
    usable: bool = True
    unit: float = 1.0


def _rectangle(width: float, depth: float) -> Outline:
    return ((0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth))


DOOR: Final = Hole(0, 0.5, 0.9, 0.0, 2.0, "door")
WINDOW: Final = Hole(2, 1.0, 1.4, 0.9, 2.1, "window")
BAY: Final[Outline] = (
    (0, 0), (5, 0), (5, 1.2), (5.8, 1.8), (5.8, 2.8), (5, 3.4), (5, 4), (0, 4)
)  # fmt: skip
LIVING: Final = (
    Thing("sofa", (2.5, 0.45, 0), 180), Thing("table", (2.5, 2.0, 0), 0),
    Thing("chair", (1.2, 3.0, 0), 30), Thing("cabinet", (4.2, 3.78, 0), 0),
)  # fmt: skip


def _plain(*things: Thing) -> SimulatedRoom:
    return built(_rectangle(5, 4), holes=(DOOR, WINDOW), things=things or LIVING)


def _of(room: SimulatedRoom, seed: int, **how: Any) -> Scan:
    return simulate(room, seed, replace(QUICK, **how))


@lru_cache(maxsize=1)
def _usual(seed: int) -> Scan:
    return _of(_plain(), seed)


def _with_cloud(scan: Scan, cloud: Cloud) -> Scan:
    return replace(scan, cloud=cloud)


def empty(seed: int) -> HardCase:
    """No points at all."""
    scan = _usual(seed)
    return HardCase(_with_cloud(scan, scan.cloud.take(np.zeros(0, np.int64))), usable=False)


def one_wall(seed: int) -> HardCase:
    """Only what lies within 5 cm of one wall."""
    scan = _usual(seed)
    near = scan.cloud.points[:, 1] > 4 - 0.05
    return HardCase(_with_cloud(scan, scan.cloud.take(near)), usable=False)


def corridor(seed: int) -> HardCase:
    """12 x 1.5 m with two doors."""
    doors = (Hole(0, 3.0, 0.9, 0.0, 2.0), Hole(2, 5.0, 0.9, 0.0, 2.0))
    return HardCase(_of(built(_rectangle(12, 1.5), holes=doors), seed))


def bathroom(seed: int) -> HardCase:
    """2 x 2 m, with a mirror."""
    holes = (Hole(0, 0.4, 0.8, 0.0, 2.0), Hole(2, 0.6, 0.8, 1.1, 1.9, "window", MIRROR))
    room = built(_rectangle(2, 2), holes=holes, things=(Thing("cabinet", (1.0, 1.78, 0)),))
    return HardCase(_of(room, seed))


def hall(seed: int) -> HardCase:
    """15 x 12 m and 5 m high, far walls at the end of the sensor's reach."""
    room = built(_rectangle(15, 12), 5.0, (DOOR, WINDOW), LIVING)
    return HardCase(_of(room, seed, frames=80))


def bay(seed: int) -> HardCase:
    """A bay with slanted sides."""
    return HardCase(_of(built(BAY, holes=(DOOR, Hole(4, 0.2, 0.6, 0.8, 2.0, "window"))), seed))


def mirrors_and_glass(seed: int) -> HardCase:
    """A wall that is mostly mirror, and one that is mostly glass."""
    holes = (
        DOOR, Hole(1, 0.5, 3.0, 0.2, 2.3, "window", GLASS),
        Hole(3, 0.5, 2.5, 0.3, 2.2, "window", MIRROR),
    )  # fmt: skip
    return HardCase(_of(built(_rectangle(5, 4), holes=holes, things=LIVING), seed))


def outliers(seed: int) -> HardCase:
    """30 % of the points anywhere in a box that is 1 m larger than the room."""
    scan = _usual(seed)
    random, cloud = generator(seed, "outliers"), scan.cloud
    rows = random.random(len(cloud)) < 0.3
    low, high = cloud.points.min(0) - 1.0, cloud.points.max(0) + 1.0
    points = np.where(rows[:, None], random.uniform(low, high, (len(cloud), 3)), cloud.points)
    return HardCase(_with_cloud(scan, replace(cloud, points=points)))


def wrong_labels(seed: int) -> HardCase:
    """20 % of the labels wrong."""
    scan = _of(_plain(), seed, wrong_labels=0.0)
    return HardCase(_with_cloud(scan, spoiled(scan.cloud, 0.2, generator(seed, "labels"))))


def no_labels(seed: int) -> HardCase:
    """Points and normals alone."""
    scan = _usual(seed)
    return HardCase(_with_cloud(scan, replace(scan.cloud, label=None, instance=None)))


def bare_points(seed: int) -> HardCase:
    """Points alone: no normals, labels, confidence, nor where the scanner stood."""
    scan = _usual(seed)
    return HardCase(_with_cloud(scan, Cloud(scan.cloud.points)))


def far_away(seed: int) -> HardCase:
    """Coordinates about 1e6 m."""
    matrix = np.eye(4)
    matrix[:3, 3] = (1.2e6, -0.9e6, 350.0)
    return HardCase(_usual(seed).moved(matrix))


def millimetres(seed: int) -> HardCase:
    """Coordinates in millimetres."""
    scan = _usual(seed)
    cloud = scan.cloud
    eyes = None if cloud.eyes is None else cloud.eyes * 1000.0
    thousand = replace(cloud, points=cloud.points * 1000.0, eyes=eyes)
    return HardCase(_with_cloud(scan, thousand), unit=0.001)


def uneven(seed: int) -> HardCase:
    """One half of the room has a hundred times the density of the other."""
    scan = _of(_plain(), seed, voxel=0.008, reduce=3)
    sparse = scan.cloud.points[:, 0] > 2.5
    kept = ~sparse | (generator(seed, "density").random(len(scan.cloud)) < 0.01)
    return HardCase(_with_cloud(scan, scan.cloud.take(kept)))


def spoilt_numbers(seed: int) -> HardCase:
    """A fifth of the points twice, and one in a hundred NaN."""
    scan = _usual(seed)
    random, count = generator(seed, "numbers"), len(scan.cloud)
    rows = np.concatenate([np.arange(count), random.integers(count, size=count // 5)])
    cloud = scan.cloud.take(rows)
    points = cloud.points.copy()
    points[random.random(len(points)) < 0.01] = np.nan
    return HardCase(_with_cloud(scan, replace(cloud, points=points)))


def tilted(seed: int) -> HardCase:
    """The whole scan leans by 10 degrees, and is turned by 33."""
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_euler("xz", [10, 33], degrees=True).as_matrix()
    return HardCase(_usual(seed).moved(matrix))


def one_sided(seed: int) -> HardCase:
    """One view: everything is seen from one side."""
    return HardCase(_of(_plain(), seed, single=True, reduce=2, fewest=1))


def symmetric(seed: int) -> HardCase:
    """Furniture that looks alike after a turn."""
    things = (
        Thing("cube", (1.5, 1.5, 0), 20), Thing("cabinet", (4.2, 3.75, 0)),
        Thing("table", (3.0, 2.0, 0), 65), Thing("cube", (4.0, 0.8, 0), 45),
    )  # fmt: skip
    return HardCase(_of(_plain(*things), seed))


def pushed_under(seed: int) -> HardCase:
    """Chairs that are pushed under a table."""
    things = (
        Thing("table", (2.5, 2.0, 0)), Thing("chair", (2.2, 1.75, 0), 180),
        Thing("chair", (2.8, 2.25, 0), 0), Thing("chair", (1.5, 2.0, 0), 90),
    )  # fmt: skip
    return HardCase(_of(_plain(*things), seed))


def stacked(seed: int) -> HardCase:
    """Two shelves, one upon the other, and a third beside them."""
    things = (
        Thing("shelf", (2.5, 3.85, 0)), Thing("shelf", (2.5, 3.85, 1.0)),
        Thing("shelf", (3.3, 3.85, 0)), Thing("chair", (1.5, 1.5, 0), 200),
    )  # fmt: skip
    return HardCase(_of(_plain(*things), seed))


def through_a_wall(seed: int) -> HardCase:
    """A table that the scan itself shows 6 cm inside a wall."""
    things = (Thing("table", (2.5, 3.66, 0)), Thing("chair", (2.5, 2.9, 0), 180))
    return HardCase(_of(_plain(*things), seed))


CASES: Final[Mapping[str, Callable[[int], HardCase]]] = {
    "empty cloud": empty,
    "one wall": one_wall,
    "corridor, 12 x 1.5 m": corridor,
    "bathroom, 2 m": bathroom,
    "hall, 15 m": hall,
    "bay": bay,
    "mirrors and glass": mirrors_and_glass,
    "30 % outliers": outliers,
    "labels 20 % wrong": wrong_labels,
    "no labels": no_labels,
    "points alone": bare_points,
    "coordinates at 1e6 m": far_away,
    "millimetres": millimetres,
    "density 100:1": uneven,
    "duplicates and NaN": spoilt_numbers,
    "tilt of 10 degrees": tilted,
    "one view": one_sided,
    "symmetric objects": symmetric,
    "chairs under a table": pushed_under,
    "stacked shelves": stacked,
    "table through a wall": through_a_wall,
}
