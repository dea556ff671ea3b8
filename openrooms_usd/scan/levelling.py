"""Where down is: the floor, gravity and the walls' directions of a scan, and the level frame.

In the *level frame* the floor is z = 0, Z points up, the x axis runs along the strongest wall
direction, and the origin lies near the middle of what was scanned. Everything else that reads a
scan works there.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.scan.ceilings import ceiling_height
from openrooms_usd.scan.cloud import Cloud
from openrooms_usd.scan.directions import wall_directions
from openrooms_usd.scan.planes import Plane, fit_plane
from openrooms_usd.scan.surfels import VOXEL, Surfels, surfels

Array = NDArray[np.float64]

# How far the given up direction may be off, degrees, and the same where none is given.
_GIVEN_TILT: Final = 8.0
_FREE_TILT: Final = 15.0
# Normals this near to the vertical, degrees, are of floors, tops and ceilings.
_FLAT: Final = 8.0
_UPRIGHT: Final = 15.0
# The floor is the lowest level with this part of the largest one's area,
_LOWEST: Final = 0.15
# and with this area, square metres;
_LEAST_AREA: Final = 0.15
# walls do not go on for this much below it, metres.
# Less than this part of the normals' spread is noise of a single wall.
_ONE_WALL: Final = 0.05
_BELOW: Final = 0.35
_BIN: Final = 0.02
_SLAB: Final = 0.12
_TOLERANCE: Final = 0.03
_FEWEST: Final = 200
_FLOOR_LABELS: Final = (2, 20)
_PIECE: Final = VOXEL**2


@dataclass(frozen=True, eq=False)
class Level:
    """How a scan stands.

    Attributes:
        level_from_scan: (4, 4) rigid, to the level frame.
        normal: (3,) unit, of the floor, upwards, in the scan's frame.
        point: (3,) of the floor, in the scan's frame.
        residual: Root of the mean squared distance of the floor's pieces to its plane, metres;
            NaN where no floor was seen.
        floor_seen: Whether the floor itself was seen; else it is at the walls' lowest points.
        ceiling: Height of a level ceiling above the floor, metres; None where none was seen.
        directions: Of the walls, degrees from the level frame's x axis modulo 90, strongest
            first; empty where no direction prevails.
        coverage: The part of the directions around the middle in which a wall was seen.
        notes: What people should know.
    """

    level_from_scan: Array
    normal: Array
    point: Array
    residual: float
    floor_seen: bool
    ceiling: float | None
    directions: tuple[float, ...]
    coverage: float
    notes: tuple[str, ...] = ()

    @property
    def scan_from_level(self) -> Array:
        """(4, 4) the way back."""
        inverse = np.eye(4)
        turn = self.level_from_scan[:3, :3].T
        inverse[:3, :3] = turn
        inverse[:3, 3] = -turn @ self.level_from_scan[:3, 3]
        return inverse


def level(cloud: Cloud, up: NDArray[np.float64] | None = None) -> Level:
    """Find the floor and the walls' directions of a scan.

    Args:
        cloud: N finite points, metres, anywhere.
        up: (3,) roughly upwards, up to 5 degrees off; None: Z, up to 10 degrees off.

    Returns:
        The level frame and what is known of it.

    Raises:
        InputError: There are too few points, or they show too little of a room.
    """
    if len(cloud) < _FEWEST:
        raise _too_little(f"the scan has {len(cloud)} points")
    middle = np.median(cloud.points, axis=0)
    guess = np.array([0.0, 0.0, 1.0]) if up is None else np.asarray(up, float)
    guess = guess / np.linalg.norm(guess)
    pieces = surfels(_shifted(cloud, middle))
    if len(pieces) < _FEWEST:
        raise _too_little("the scan shows hardly any surface")
    gravity = _gravity(pieces, guess, _FREE_TILT if up is None else _GIVEN_TILT)
    plane, seen = _floor(pieces, gravity)
    upright = pieces.moved(_upright(plane.normal, plane.point))
    directions = wall_directions(upright)
    frame = _turned(directions[0] if directions else 0.0) @ _upright(plane.normal, plane.point)
    frame[:2, 3] -= np.median(pieces.moved(frame).points[:, :2], axis=0)
    still = pieces.moved(frame)
    coverage = _coverage(still)
    frame[:3, 3] -= frame[:3, :3] @ middle
    return Level(
        level_from_scan=frame,
        normal=plane.normal,
        point=plane.point + middle,
        residual=plane.residual if seen else float("nan"),
        floor_seen=seen,
        ceiling=ceiling_height(still),
        directions=tuple((angle - directions[0]) % 90.0 for angle in directions),
        coverage=coverage,
        notes=() if seen else ("the floor was not seen: it is put where the walls end",),
    )


def _too_little(message: str) -> InputError:
    return InputError(
        message,
        remedy="scan the whole room: its floor, and every wall from end to end",
    )


def _shifted(cloud: Cloud, middle: Array) -> Cloud:
    return Cloud(cloud.points - middle, label=cloud.label, confidence=cloud.confidence)


def _gravity(pieces: Surfels, guess: Array, tilt: float) -> Array:
    """(3,) the direction that most level surfaces face, or that all walls are upright to."""
    toward = pieces.normals * np.sign(pieces.normals @ guess)[:, None]
    near = toward @ guess > np.cos(np.deg2rad(tilt + 2.0))
    flat = toward[near]
    up = guess
    if len(flat) > _LEAST_AREA / _PIECE:
        some = flat[:: max(1, len(flat) // 1500)]
        up = some[(some @ some.T > np.cos(np.deg2rad(3.0))).sum(axis=1).argmax()]
        for width in (6.0, 4.0, 3.0, 3.0):
            up = flat[flat @ up > np.cos(np.deg2rad(width))].mean(axis=0)
            up = up / np.linalg.norm(up)
        return np.asarray(up)
    for width in (tilt, 8.0, 5.0, 5.0):
        walls = pieces.normals[np.abs(pieces.normals @ up) < np.sin(np.deg2rad(width))]
        if len(walls) < _FEWEST:
            break
        up = _square_to(walls, guess)
    return up


def _square_to(walls: Array, guess: Array) -> Array:
    """(3,) the direction that is upright to walls' normals (N, 3); one wall leaves it half open."""
    values, axes = np.linalg.eigh(walls.T @ walls / len(walls))
    free = axes[:, values < _ONE_WALL]
    up = free @ (free.T @ guess) if free.shape[1] > 1 else free[:, 0] * np.sign(free[:, 0] @ guess)
    return np.asarray(up / np.linalg.norm(up))


def _floor(pieces: Surfels, up: Array) -> tuple[Plane, bool]:
    """The plane of the floor and whether it was seen."""
    facing = np.abs(pieces.normals @ up)
    flat = pieces.take(facing > np.cos(np.deg2rad(_FLAT)))
    walls = pieces.points[facing < np.sin(np.deg2rad(_UPRIGHT))] @ up
    foot = _foot(walls)
    height = _floor_level(flat.points @ up, flat.label)
    if height is not None and height - foot < _BELOW:
        slab = flat.points[np.abs(flat.points @ up - height) < _SLAB]
        plane = fit_plane(slab, up, _TOLERANCE, max_tilt=3.0)
        if plane is not None:
            return plane, True
    middle = np.median(pieces.points, axis=0)
    place = middle + (foot - middle @ up) * up
    return Plane(up, place, 0.0, np.zeros(0, bool)), False


def _foot(heights: Array) -> float:
    """Where walls end below: the lowest height at which they are a tenth as dense as usual."""
    if len(heights) < _FEWEST:
        return float("inf")
    low = np.quantile(heights, 0.001)
    counts = np.bincount(((heights - low).clip(0.0) / 0.05).astype(int))
    dense = np.flatnonzero(counts >= 0.15 * np.quantile(counts[counts > 0], 0.8))
    return float(low + 0.05 * dense[0])


def _floor_level(heights: Array, label: NDArray[np.int32] | None) -> float | None:
    if not len(heights):
        return None
    weight = np.ones(len(heights))
    if label is not None:
        weight[np.isin(label, _FLOOR_LABELS)] = 4.0
    low = heights.min() - 5 * _BIN
    counts = np.bincount(((heights - low) / _BIN).astype(int), weight)
    area = np.convolve(np.append(counts, np.zeros(5)), np.ones(5), "same")
    strong = area > max(_LOWEST * area.max(), _LEAST_AREA / _PIECE)
    if not strong.any():
        return None
    first = int(np.flatnonzero(strong)[0])
    peak = first + int(area[first : first + 8].argmax())
    return float(low + (peak + 0.5) * _BIN)


def _coverage(pieces: Surfels) -> float:
    """The part of 72 directions around the middle of the level surfaces that walls stand in."""
    slope = np.abs(pieces.normals[:, 2])
    flat = pieces.points[slope > np.cos(np.deg2rad(_FLAT)), :2]
    walls = pieces.points[slope < np.sin(np.deg2rad(_UPRIGHT)), :2]
    away = walls - np.median(flat if len(flat) else walls, axis=0)
    sectors = (np.arctan2(away[:, 1], away[:, 0]) / np.pi * 36.0).astype(int) % 72
    return float((np.bincount(sectors, minlength=72) > 5).mean())


def _upright(normal: Array, point: Array) -> Array:
    """(4, 4) the least turn that makes a normal vertical, the point at height zero."""
    matrix = np.eye(4)
    axis = np.array([normal[1], -normal[0], 0.0])
    skew = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    if normal[2] > -0.999999:
        matrix[:3, :3] += skew + skew @ skew / (1.0 + normal[2])
    else:
        matrix[:3, :3] = np.diag([1.0, -1.0, -1.0])
    matrix[:3, 3] = -matrix[:3, :3] @ point
    return matrix


def _turned(degrees: float) -> Array:
    """(4, 4) that brings a direction in the plan to the x axis by less than 45 degrees."""
    angle = np.deg2rad(-((degrees + 45.0) % 90.0 - 45.0))
    matrix = np.eye(4)
    matrix[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return matrix
