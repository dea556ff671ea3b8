"""Rooms that are hard to scan or to find, each built so that its truth is known."""

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from benchmarks.scan.built import Hole, Placed, built
from benchmarks.scan.corridors import with_corridors
from benchmarks.scan.rooms import GLASS, MIRROR, SimulatedRoom
from benchmarks.scan.scanner import Scan, Scanner, simulate
from benchmarks.scan.truth import Truth
from openrooms_usd.scan.points.cloud import Cloud

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


def rectangle(width: float, depth: float) -> Outline:
    """From the origin on."""
    return ((0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth))


DOOR: Final = Hole(0, 0.5, 0.9, 0.0, 2.0, "door")
WINDOW: Final = Hole(2, 1.0, 1.4, 0.9, 2.1, "window")
BAY: Final[Outline] = (
    (0, 0), (5, 0), (5, 1.2), (5.8, 1.8), (5.8, 2.8), (5, 3.4), (5, 4), (0, 4)
)  # fmt: skip
NICHES: Final[Outline] = (
    (0, 0), (5, 0), (5, 1.5), (4.6, 1.5), (4.6, 1.9), (5, 1.9), (5, 4),
    (3.5, 4), (3.5, 4.4), (2.0, 4.4), (2.0, 4), (0, 4),
)  # fmt: skip
LIVING: Final = (
    Placed("sofa", (2.5, 0.45, 0), 180), Placed("table", (2.5, 2.0, 0), 0),
    Placed("chair", (1.2, 3.0, 0), 30), Placed("cabinet", (4.2, 3.78, 0), 0),
)  # fmt: skip


def plain(*things: Placed) -> SimulatedRoom:
    """5 x 4 m with a door and a window."""
    return built(rectangle(5, 4), holes=(DOOR, WINDOW), things=things or LIVING)


def scanned(room: SimulatedRoom, seed: int, **how: Any) -> Scan:
    """A quick scan, but for some options."""
    return simulate(room, seed, replace(QUICK, **how))


def corridor(seed: int) -> HardCase:
    """12 x 1.5 m with two doors."""
    doors = (Hole(0, 3.0, 0.9, 0.0, 2.0), Hole(2, 5.0, 0.9, 0.0, 2.0))
    return HardCase(scanned(built(rectangle(12, 1.5), holes=doors), seed))


def bathroom(seed: int) -> HardCase:
    """2 x 2 m, with a mirror."""
    holes = (Hole(0, 0.4, 0.8, 0.0, 2.0), Hole(2, 0.6, 0.8, 1.1, 1.9, "window", MIRROR))
    room = built(rectangle(2, 2), holes=holes, things=(Placed("cabinet", (1.0, 1.78, 0)),))
    return HardCase(scanned(room, seed))


def hall(seed: int) -> HardCase:
    """15 x 12 m and 5 m high, far walls at the end of the sensor's reach."""
    room = built(rectangle(15, 12), 5.0, (DOOR, WINDOW), LIVING)
    return HardCase(scanned(room, seed, frames=80))


def bay(seed: int) -> HardCase:
    """A bay with slanted sides."""
    return HardCase(scanned(built(BAY, holes=(DOOR, Hole(4, 0.2, 0.6, 0.8, 2.0, "window"))), seed))


def mirrors_and_glass(seed: int) -> HardCase:
    """A wall that is mostly mirror, and one that is mostly glass."""
    holes = (
        DOOR, Hole(1, 0.5, 3.0, 0.2, 2.3, "window", GLASS),
        Hole(3, 0.5, 2.5, 0.3, 2.2, "window", MIRROR),
    )  # fmt: skip
    return HardCase(scanned(built(rectangle(5, 4), holes=holes, things=LIVING), seed))


def missing_wall(seed: int) -> HardCase:
    """One wall was not seen, nor what is behind it."""
    return HardCase(scanned(plain(), seed, missing_walls=1))


def blind_wall(seed: int) -> HardCase:
    """One wall was not seen, nor anything within 10 cm before it."""
    return HardCase(scanned(plain(), seed, missing_walls=1, blind=0.1))


def drifting(seed: int) -> HardCase:
    """Poses that drift by up to 8 cm and 0.8 degrees."""
    return HardCase(scanned(plain(), seed, drift=0.08, drift_degrees=0.8, frames=80))


def open_door(seed: int) -> HardCase:
    """A wide open door, and a corridor behind it."""
    room = built(rectangle(5, 4), holes=(Hole(0, 1.5, 1.4, 0.0, 2.1), WINDOW), things=LIVING)
    return HardCase(scanned(with_corridors(room), seed))


def several_rooms(seed: int) -> HardCase:
    """Two rooms beside each other with a door between them."""
    first = scanned(built(rectangle(5, 4), holes=(Hole(1, 1.0, 0.9, 0.0, 2.0),)), seed)
    second = scanned(built(rectangle(3, 4), holes=(Hole(3, 2.1, 0.9, 0.0, 2.0),)), seed)
    beside = np.eye(4)
    beside[0, 3] = 5.0 + 0.2
    parts = [first, second.moved(beside)]
    joined = {
        name: np.concatenate([getattr(part.cloud, name) for part in parts])
        for name in ("points", "normals", "label", "instance", "confidence", "sensor_origins")
    }
    rooms = tuple(room for part in parts for room in part.truth.rooms)
    return HardCase(Scan(Cloud(**joined), Truth(rooms, (), {})))


def columns(seed: int) -> HardCase:
    """A pier, a niche, and a column that stands free."""
    column = Placed("cube", (2.2, 2.0, 0), 0, (0.6, 0.6, 2.5 / 0.6))
    return HardCase(scanned(built(NICHES, holes=(DOOR,), things=(column,)), seed))


def one_sided(seed: int) -> HardCase:
    """One view: everything is seen from one side."""
    return HardCase(scanned(plain(), seed, single=True, reduce=2, fewest=1))


def symmetric(seed: int) -> HardCase:
    """Furniture that looks alike after a turn."""
    things = (
        Placed("cube", (1.5, 1.5, 0), 20), Placed("cabinet", (4.2, 3.75, 0)),
        Placed("table", (3.0, 2.0, 0), 65), Placed("cube", (4.0, 0.8, 0), 45),
    )  # fmt: skip
    return HardCase(scanned(plain(*things), seed))


def pushed_under(seed: int) -> HardCase:
    """Chairs that are pushed under a table."""
    things = (
        Placed("table", (2.5, 2.0, 0)), Placed("chair", (2.2, 1.75, 0), 180),
        Placed("chair", (2.8, 2.25, 0), 0), Placed("chair", (1.5, 2.0, 0), 90),
    )  # fmt: skip
    return HardCase(scanned(plain(*things), seed))


def stacked(seed: int) -> HardCase:
    """Two shelves, one upon the other, and a third beside them."""
    things = (
        Placed("shelf", (2.5, 3.85, 0)), Placed("shelf", (2.5, 3.85, 1.0)),
        Placed("shelf", (3.3, 3.85, 0)), Placed("chair", (1.5, 1.5, 0), 200),
    )  # fmt: skip
    return HardCase(scanned(plain(*things), seed))


def through_a_wall(seed: int) -> HardCase:
    """A table that the scan itself shows 6 cm inside a wall."""
    things = (
        Placed("table", (2.5, 3.66, 0)),
        Placed("chair", (2.5, 2.9, 0), 180),
    )
    return HardCase(scanned(plain(*things), seed))
