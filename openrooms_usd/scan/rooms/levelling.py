"""The level frame of a scan, from gravity, the floor and the prevailing wall directions.

In the *level frame* the floor is z = 0, Z points up, the x axis is the strongest wall direction,
and the origin is near the middle of the scan. All later steps work in it.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import SparseScanError
from openrooms_usd.geometry.rotations import about_z, inverse, pose
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import Surfels, surfels
from openrooms_usd.scan.rooms.ceilings import ceiling_height
from openrooms_usd.scan.rooms.directions import wall_directions
from openrooms_usd.scan.rooms.ground import LEVEL_DEG, MIN_PIECES, UPRIGHT_DEG, Ground, find_ground

Array = NDArray[np.float64]

# Largest error of a given up direction, and of Z where none is given, degrees.
_MAX_GIVEN_TILT_DEG: Final = 8.0
_MAX_FREE_TILT_DEG: Final = 15.0
# A floor with a larger residual was bent by drift, metres.
_BENT_FLOOR_M: Final = 0.01


@dataclass(frozen=True, eq=False)
class Level:
    """The level frame of a scan.

    Attributes:
        level_from_scan: (4, 4) rigid, to the level frame.
        normal: (3,) unit, of the floor, upwards, in the scan's frame.
        point: (3,) of the floor, in the scan's frame.
        residual: Root mean squared distance of the floor's surfels to its plane, metres; NaN where
            no floor was scanned.
        floor_seen: Whether the floor was scanned; else it is put at the walls' lowest points.
        ceiling: Height of a level ceiling above the floor, metres; None where none was scanned.
        directions: Of the walls, degrees from the level frame's x axis modulo 90, strongest
            first; empty where no direction prevails.
        coverage: The part of the azimuths around the middle in which a wall was scanned.
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
        """(4, 4) rigid, from the level frame."""
        return inverse(self.level_from_scan)


def level(cloud: Cloud, up: NDArray[np.float64] | None = None) -> Level:
    """Find the floor and the walls' directions of a scan.

    Args:
        cloud: N finite points, metres, anywhere.
        up: (3,) roughly upwards, up to 5 degrees off; None: Z, up to 10 degrees off.

    Returns:
        The level frame.

    Raises:
        SparseScanError: There are too few points, or they show too little of a room.
    """
    if len(cloud) < MIN_PIECES:
        raise _too_little(f"the scan has {len(cloud)} points")
    middle = np.median(cloud.points, axis=0)
    guess = np.array([0.0, 0.0, 1.0]) if up is None else np.asarray(up, float)
    guess = guess / np.linalg.norm(guess)
    pieces = surfels(_shifted(cloud, middle))
    if len(pieces) < MIN_PIECES:
        raise _too_little("the scan shows hardly any surface")
    ground = find_ground(pieces, guess, _MAX_FREE_TILT_DEG if up is None else _MAX_GIVEN_TILT_DEG)
    gravity_aligned = _upright(ground.normal, ground.point)
    upright = pieces.moved(gravity_aligned)
    directions = wall_directions(upright)
    frame = _turned(directions[0] if directions else 0.0) @ gravity_aligned
    frame[:2, 3] -= np.median(pieces.moved(frame).points[:, :2], axis=0)
    still = pieces.moved(frame)
    coverage = _coverage(still)
    frame[:3, 3] -= frame[:3, :3] @ middle
    return Level(
        level_from_scan=frame,
        normal=ground.normal,
        point=ground.point + middle,
        residual=ground.residual,
        floor_seen=ground.seen,
        ceiling=ceiling_height(still),
        directions=tuple((angle - directions[0]) % 90.0 for angle in directions),
        coverage=coverage,
        notes=_notes(ground),
    )


def _too_little(message: str) -> SparseScanError:
    return SparseScanError(
        message,
        remedy="scan the whole room: its floor, and every wall from end to end; if that was done,"
        " say its unit (`unit`, `--unit`)",
    )


def _notes(ground: Ground) -> tuple[str, ...]:
    if not ground.seen:
        return ("the floor was not seen: it is put where the walls end",)
    if ground.trust < 1.0 and ground.residual > _BENT_FLOOR_M:
        bent = f"{100.0 * ground.residual:.0f} cm"
        return (f"the floor is bent by {bent}: it is put level at its mean height",)
    return ()


def _shifted(cloud: Cloud, middle: Array) -> Cloud:
    return Cloud(cloud.points - middle, label=cloud.label, confidence=cloud.confidence)


def _coverage(pieces: Surfels) -> float:
    """The part of 72 azimuths around the middle of the level surfaces that have walls."""
    slope = np.abs(pieces.normals[:, 2])
    flat = pieces.points[slope > np.cos(np.deg2rad(LEVEL_DEG)), :2]
    walls = pieces.points[slope < np.sin(np.deg2rad(UPRIGHT_DEG)), :2]
    away = walls - np.median(flat if len(flat) else walls, axis=0)
    sectors = (np.arctan2(away[:, 1], away[:, 0]) / np.pi * 36.0).astype(int) % 72
    return float((np.bincount(sectors, minlength=72) > 5).mean())


def _upright(normal: Array, point: Array) -> Array:
    """(4, 4) the least rotation that makes a normal vertical, the point at height zero."""
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
    """(4, 4) the yaw that aligns a direction with the x axis or its normal, at most 45 degrees."""
    return pose(about_z(np.deg2rad(-((degrees + 45.0) % 90.0 - 45.0))))
