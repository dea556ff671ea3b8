"""A hand-held path through the free space of a room, and where the camera looks on it."""

from math import hypot
from typing import Final

import numpy as np

from benchmarks.scan.rooms import Part, SimulatedRoom
from openrooms_usd import names
from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.floorplan import inside, wall_distance
from openrooms_usd.geometry.pinhole import rotations
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.rotations import pose
from openrooms_usd.usd.semantics import number_of

CELL: Final = 0.1
# Metres: how high the camera is held, what a person steps over, how far the body keeps off.
HELD: Final = (1.4, 1.7)
STEP: Final = 0.2
BODY: Final = 0.25
# One place to stand for so many square metres, within these limits.
PLACE_AREA: Final = 1.5
PLACES: Final = (4, 14)
# Degrees: the camera swings up and down about this by so much.
PITCH: Final = (-14.0, 32.0)
LOWERED: Final = (-30.0, 20.0)


def walk(
    room: SimulatedRoom,
    caster: RayCaster,
    frames: int,
    random: np.random.Generator,
    *,
    lowered: bool = False,
) -> Array:
    """(frames, 4, 4) world_from_camera (OpenCV) along a walk with the camera panning.

    Args:
        room: The room.
        caster: Its triangles.
        frames: How many.
        random: Decides the way and the swing.
        lowered: Whether the camera never looks up.
    """
    free, clearance = free_cells(room, caster)
    places = stations(free, clearance, random)
    way = _smooth(_route(free, _tour(places)))
    rounds = max(2.5, 0.6 * len(places))
    sensor_origins = _along(way, frames)
    held = random.uniform(*HELD)
    sway = 0.04 * np.sin(np.linspace(0, 2 * np.pi * 3 * len(places), frames) + random.uniform(0, 6))
    yaw = random.uniform(0, 2 * np.pi) + np.linspace(0, 2 * np.pi * rounds, frames)
    middle, swing = LOWERED if lowered else PITCH
    # The golden ratio: rounds never repeat the same pitch at the same yaw.
    pitch = middle + swing * np.sin(yaw * 2.618 + random.uniform(0, 6))
    ahead = _directions(yaw, np.radians(pitch + random.normal(0, 1.5, frames)))
    z = np.clip(held + sway, *HELD) + room.truth.rooms[0].corners[0, 2]
    return np.stack(
        [
            pose(R, origin)
            for R, origin in zip(
                rotations(ahead), np.column_stack([sensor_origins, z]), strict=True
            )
        ]
    )


def _directions(yaw: Array, pitch: Array) -> Array:
    flat = np.cos(pitch)
    return np.column_stack([flat * np.cos(yaw), flat * np.sin(yaw), np.sin(pitch)])


def free_cells(room: SimulatedRoom, caster: RayCaster) -> tuple[Array, Array]:
    """Where a person can stand: (N, 2) centres of the largest connected area of free cells.

    Returns:
        The centres, and (N,) their distance to whatever is in the way.
    """
    from scipy.ndimage import distance_transform_edt, label

    outline, ground = room.floor, room.truth.rooms[0].corners[0, 2]
    low, high = outline.min(axis=0), outline.max(axis=0)
    shape = np.ceil((high - low) / CELL).astype(int) + 1
    centres = low + CELL * (np.indices(shape).reshape(2, -1).T)
    top = min((room.truth.rooms[0].ceiling or 2.5) - 0.05, 2.1)
    sensor_origins = np.column_stack([centres, np.full(len(centres), ground + top)])
    hits = caster.first_hit(sensor_origins, np.broadcast_to((0.0, 0.0, -1.0), sensor_origins.shape))
    clear = np.isfinite(hits.distance) & (hits.distance > top - STEP)
    clear &= inside(outline, centres) & (wall_distance(outline, centres) > CELL / 2)
    away = CELL * distance_transform_edt(np.pad(clear.reshape(shape), 1))[1:-1, 1:-1]
    for body in (BODY, BODY / 2, 0.0):
        numbers, count = label(away > body)
        if count:
            break
    largest = numbers == 1 + np.argmax(np.bincount(numbers.ravel())[1:])
    return centres[largest.ravel()], away[largest]


def stations(free: Array, clearance: Array, random: np.random.Generator) -> Array:
    """(K,) rows of cells that are far from each other (farthest points, the first by chance)."""
    count = int(np.clip(len(free) * CELL**2 / PLACE_AREA, *PLACES))
    chosen = [int(random.choice(len(free), p=clearance / clearance.sum()))]
    away = np.full(len(free), np.inf)
    while len(chosen) < min(count, len(free)):
        away = np.minimum(away, np.linalg.norm(free - free[chosen[-1]], axis=1))
        chosen.append(int((away * np.sqrt(clearance)).argmax()))
    return np.column_stack([np.array(chosen), free[chosen]])


def _tour(places: Array) -> Ints:
    """Rows of the places, each next to the one before."""
    left, tour = list(range(1, len(places))), [0]
    while left:
        away = np.linalg.norm(places[left, 1:] - places[tour[-1], 1:], axis=1)
        tour.append(left.pop(int(away.argmin())))
    return places[tour, 0].astype(np.int64)


def _route(free: Array, tour: Ints) -> Array:
    """(N, 2) the way over free cells from place to place."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra
    from scipy.spatial import cKDTree

    pairs = cKDTree(free).query_pairs(1.5 * CELL, output_type="ndarray")
    lengths = np.linalg.norm(free[pairs[:, 0]] - free[pairs[:, 1]], axis=1)
    graph = csr_array((lengths, (pairs[:, 0], pairs[:, 1])), shape=(len(free), len(free)))
    _, before = dijkstra(graph, directed=False, indices=tour, return_predecessors=True)
    way: list[int] = [int(tour[0])]
    for row, target in enumerate(tour[1:]):
        leg = [int(target)]
        while leg[-1] != tour[row] and leg[-1] >= 0:
            leg.append(int(before[row, leg[-1]]))
        way += [cell for cell in reversed(leg[:-1]) if cell >= 0]
    return np.asarray(free[way])


def _smooth(way: Array, width: int = 5) -> Array:
    padded = np.pad(way, ((width // 2, width // 2), (0, 0)), mode="edge")
    return np.stack([np.convolve(axis, np.ones(width) / width, "valid") for axis in padded.T], 1)


def _along(way: Array, count: int) -> Array:
    """(count, 2) points at equal steps along a way."""
    steps = np.linalg.norm(np.diff(way, axis=0), axis=1)
    run = np.concatenate([[0.0], np.cumsum(steps)])
    at = np.linspace(0.0, run[-1], count)
    return np.column_stack([np.interp(at, run, axis) for axis in way.T])


# A piece of corridor behind each door, so that open doors show something.

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
