"""Scans that are hard or bad: those of hard rooms, and clouds that were spoilt."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.scan import hard_rooms as rooms
from benchmarks.scan.hard_rooms import HardCase, plain, scanned
from benchmarks.scan.labels import spoiled
from benchmarks.scan.scanner import Scan
from openrooms_usd.draws import generator
from openrooms_usd.scan.points.cloud import Cloud

FLOOR_MAT: Final = 20


@lru_cache(maxsize=1)
def usual(seed: int) -> Scan:
    """The scan that clouds are made worse of."""
    return scanned(plain(), seed)


def _with_cloud(scan: Scan, cloud: Cloud) -> Scan:
    return replace(scan, cloud=cloud)


def empty(seed: int) -> HardCase:
    """No points at all."""
    scan = usual(seed)
    return HardCase(_with_cloud(scan, scan.cloud.take(np.zeros(0, np.int64))), usable=False)


def one_wall(seed: int) -> HardCase:
    """Only what lies within 5 cm of one wall."""
    scan = usual(seed)
    near = scan.cloud.points[:, 1] > 4 - 0.05
    return HardCase(_with_cloud(scan, scan.cloud.take(near)), usable=False)


def outliers(seed: int) -> HardCase:
    """30 % of the points anywhere in a box that is 1 m larger than the room."""
    scan = usual(seed)
    random, cloud = generator(seed, "outliers"), scan.cloud
    rows = random.random(len(cloud)) < 0.3
    low, high = cloud.points.min(0) - 1.0, cloud.points.max(0) + 1.0
    points = np.where(rows[:, None], random.uniform(low, high, (len(cloud), 3)), cloud.points)
    return HardCase(_with_cloud(scan, replace(cloud, points=points)))


def wrong_labels(seed: int) -> HardCase:
    """20 % of the labels wrong."""
    scan = scanned(plain(), seed, wrong_labels=0.0)
    return HardCase(_with_cloud(scan, spoiled(scan.cloud, 0.2, generator(seed, "labels"))))


def no_labels(seed: int) -> HardCase:
    """Points and normals alone."""
    scan = usual(seed)
    return HardCase(_with_cloud(scan, replace(scan.cloud, label=None, instance=None)))


def bare_points(seed: int) -> HardCase:
    """Points alone: no normals, labels, confidence, nor where the scanner stood."""
    scan = usual(seed)
    return HardCase(_with_cloud(scan, Cloud(scan.cloud.points)))


def far_away(seed: int) -> HardCase:
    """Coordinates about 1e6 m."""
    matrix = np.eye(4)
    matrix[:3, 3] = (1.2e6, -0.9e6, 350.0)
    return HardCase(usual(seed).moved(matrix))


def millimetres(seed: int) -> HardCase:
    """Coordinates in millimetres."""
    scan = usual(seed)
    cloud = scan.cloud
    sensor_origins = None if cloud.sensor_origins is None else cloud.sensor_origins * 1000.0
    thousand = replace(cloud, points=cloud.points * 1000.0, sensor_origins=sensor_origins)
    return HardCase(_with_cloud(scan, thousand), unit=0.001)


def uneven(seed: int) -> HardCase:
    """One half of the room has a hundred times the density of the other."""
    scan = scanned(plain(), seed, voxel=0.008, reduce=3)
    sparse = scan.cloud.points[:, 0] > 2.5
    kept = ~sparse | (generator(seed, "density").random(len(scan.cloud)) < 0.01)
    return HardCase(_with_cloud(scan, scan.cloud.take(kept)))


def spoilt_numbers(seed: int) -> HardCase:
    """A fifth of the points twice, and one in a hundred NaN."""
    scan = usual(seed)
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
    return HardCase(usual(seed).moved(matrix))


def carpet(seed: int) -> HardCase:
    """A carpet of 3 cm on two thirds of the floor."""
    scan = usual(seed)
    points, label = scan.cloud.points.copy(), scan.cloud.label.copy()  # type: ignore[union-attr]
    on = (np.abs(points[:, 2]) < 0.02) & (points[:, 0] > 0.4) & (points[:, 0] < 3.9)
    points[on, 2] += 0.03
    label[on] = FLOOR_MAT
    return HardCase(_with_cloud(scan, replace(scan.cloud, points=points, label=label)))


def no_floor(seed: int) -> HardCase:
    """Nothing within 10 cm of the floor."""
    scan = usual(seed)
    return HardCase(_with_cloud(scan, scan.cloud.take(scan.cloud.points[:, 2] > 0.1)))


CASES: Final[Mapping[str, Callable[[int], HardCase]]] = {
    "empty cloud": empty,
    "one wall": one_wall,
    "corridor, 12 x 1.5 m": rooms.corridor,
    "bathroom, 2 m": rooms.bathroom,
    "hall, 15 m": rooms.hall,
    "bay": rooms.bay,
    "mirrors and glass": rooms.mirrors_and_glass,
    "30 % outliers": outliers,
    "labels 20 % wrong": wrong_labels,
    "no labels": no_labels,
    "points alone": bare_points,
    "coordinates at 1e6 m": far_away,
    "millimetres": millimetres,
    "density 100:1": uneven,
    "duplicates and NaN": spoilt_numbers,
    "tilt of 10 degrees": tilted,
    "carpet, 3 cm": carpet,
    "no floor": no_floor,
    "a wall missing": rooms.missing_wall,
    "and 10 cm before it": rooms.blind_wall,
    "drift of 8 cm": rooms.drifting,
    "open door": rooms.open_door,
    "two rooms": rooms.several_rooms,
    "pier, niche, column": rooms.columns,
    "one view": rooms.one_sided,
    "symmetric objects": rooms.symmetric,
    "chairs under a table": rooms.pushed_under,
    "stacked shelves": rooms.stacked,
    "table through a wall": rooms.through_a_wall,
}
