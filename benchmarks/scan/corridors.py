"""A piece of corridor behind each door, so that open doors show something."""

from math import hypot
from typing import Final

import numpy as np

from benchmarks.scan.rooms import Part, SimulatedRoom
from openrooms_usd import names
from openrooms_usd.arrays import Array, Ints
from openrooms_usd.usd.semantics import number_of

# How deep a corridor is, and how far it goes on to the sides of its door, metres.
CORRIDOR: Final = (1.4, 1.6)
THICKNESS: Final = 0.2


def with_corridors(room: SimulatedRoom) -> SimulatedRoom:
    """The room with a piece of corridor behind each of its doors that has the place for one."""
    from shapely.geometry import Polygon

    truth = room.truth.rooms[0]
    height = truth.ceiling or 2.5
    walls = Polygon(room.floor).buffer(THICKNESS - 0.01, join_style="mitre")
    taken = [walls]
    points, triangles, part, parts = [room.points], [room.triangles], [room.part], [*room.parts]
    count = len(room.points)
    for hole in truth.openings:
        ring = corridor_plan(hole.corners)
        if hole.type == "window" or any(Polygon(ring).intersects(other) for other in taken):
            continue
        taken.append(Polygon(ring))
        corners, faces = corridor(ring, truth.corners[0, 2], height)
        points.append(corners)
        triangles.append(faces + count)
        count += len(corners)
        first = len(parts)
        parts += [Part(number_of(name, names.NYU40), 0) for name in ("floor", "ceiling", "wall")]
        part.append(first + np.array([0, 0, 1, 1] + [2] * (len(faces) - 4)))
    return SimulatedRoom(
        np.concatenate(points),
        np.concatenate(triangles),
        np.concatenate(part),
        tuple(parts),
        room.truth,
    )


def corridor_plan(hole: Array) -> Array:
    """(4, 2) outline of the corridor behind a hole: right along the wall, then outwards."""
    left, right = hole[0, :2], hole[1, :2]
    along = (right - left) / hypot(*(right - left))
    outward = np.array([-along[1], along[0]])
    depth, side = CORRIDOR
    near, far = outward * THICKNESS, outward * (THICKNESS + depth)
    a, b = left - side * along, right + side * along
    return np.array([a + near, b + near, b + far, a + far])


def corridor(ring: Array, floor: float, height: float) -> tuple[Array, Ints]:
    """The floor, the ceiling and the three far walls of a corridor.

    Returns:
        (8, 3) points; (10, 3) triangles: two of the floor, two of the ceiling, six of walls.
    """
    low = np.column_stack([ring, np.full(4, floor)])
    points = np.concatenate([low, low + np.array([0.0, 0.0, height])])
    faces = [(0, 1, 2), (0, 2, 3), (4, 6, 5), (4, 7, 6)]
    for i, j in ((1, 2), (2, 3), (3, 0)):
        faces += [(i, j, j + 4), (i, j + 4, i + 4)]
    return points, np.array(faces, dtype=np.int64)
