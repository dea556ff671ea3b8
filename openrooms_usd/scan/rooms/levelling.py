"""The level frame of a scan, from gravity, the floor and the prevailing wall directions.

In the *level frame* the floor is z = 0, Z points up, the x axis is the strongest wall direction,
and the origin is near the middle of the scan. All later steps work in it.

Pose drift bends the floor by centimetres, and a plane fit to it tilts. Normals suffer less: the
orientation errors of the many poses that saw a surface average out. So gravity is estimated from
normals, parallel to those of level surfaces and perpendicular to those of walls, and the floor's
plane fit counts as far as it agrees.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.errors import SparseScanError
from openrooms_usd.geometry.rotations import about_z, inverse, pose
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import VOXEL_M, Plane, Surfels, fit_plane, surfels
from openrooms_usd.scan.rooms.ceilings import ceiling_height
from openrooms_usd.scan.rooms.directions import wall_directions

# Largest error of a given up direction, and of Z where none is given, degrees.
_MAX_GIVEN_TILT_DEG: Final = 8.0
_MAX_FREE_TILT_DEG: Final = 15.0
# A floor with a larger residual was bent by drift, metres.
_BENT_FLOOR_M: Final = 0.01
MIN_PIECES: Final = 200
# Largest tilt of level surfaces (floors, tops, ceilings) and of walls, degrees.
LEVEL_DEG: Final = 8.0
UPRIGHT_DEG: Final = 15.0
# Normals farther than this from level or upright are outliers: so many times the median angle,
# within limits.
_OUTLIER_MEDIANS: Final = 2.0
_OUTLIER_LIMITS_DEG: Final = (3.0, 10.0)
_REWEIGHTING_ROUNDS: Final = 8
# The floor's plane counts fully up to this angle to gravity, not at all from twice this; or up to
# so many standard errors of gravity. Each point counts in the normals of so many surfels.
_FLOOR_AGREES_DEG: Final = 0.1
_GRAVITY_SIGMAS: Final = 2.0
_SHARED_PIECES: Final = 27.0
# The floor is the lowest level with at least this part of the largest one's area,
_MIN_FLOOR_SHARE: Final = 0.15
# and at least this area,
_MIN_FLOOR_M2: Final = 0.15
# that walls do not exceed downwards by this much.
_WALLS_BELOW_M: Final = 0.35
# Smaller eigenvalues of the normals' scatter are noise of a single wall.
_ONE_WALL_SHARE: Final = 0.05
_HEIGHT_BIN_M: Final = 0.02
_SLAB_M: Final = 0.12
_LEVEL_TOLERANCE_M: Final = 0.03
# NYU40; mats have another label. Least part of a level that is labelled floor, to use it alone.
_FLOOR_LABEL: Final = 2
_BARE_FLOOR_SHARE: Final = 0.1
_PIECE_M2: Final = VOXEL_M**2


@dataclass(frozen=True, eq=False)
class Ground:
    """The floor of a scan.

    Attributes:
        normal: (3,) unit, upwards.
        point: (3,) metres.
        residual: Root mean squared distance of the floor's surfels to it, metres; NaN where no
            floor was scanned.
        seen: Whether the floor was scanned; else it is put at the walls' lowest points.
        trust: Weight of the floor's plane fit against gravity, from 0 (it is bent) to 1.
    """

    normal: Array
    point: Array
    residual: float
    seen: bool
    trust: float


def find_ground(pieces: Surfels, guess: Array, tilt: float) -> Ground:
    """Find gravity and the floor.

    Args:
        pieces: Surfels near the origin.
        guess: (3,) unit, roughly upwards.
        tilt: Its largest error, degrees.
    """
    up, sigma = _refined_gravity(pieces.normals, _gravity(pieces, guess, tilt))
    facing = np.abs(pieces.normals @ up)
    flat = pieces.take(facing > np.cos(np.deg2rad(LEVEL_DEG)))
    foot = _lowest_wall(pieces.points[facing < np.sin(np.deg2rad(UPRIGHT_DEG))] @ up)
    height = _floor_level(flat.points @ up, flat.label)
    if height is not None and height - foot < _WALLS_BELOW_M:
        slab = _bare(flat.take(np.abs(flat.points @ up - height) < _SLAB_M))
        plane = fit_plane(slab, up, _LEVEL_TOLERANCE_M, max_tilt=3.0)
        if plane is not None:
            return _blended(slab, plane, up, max(_FLOOR_AGREES_DEG, _GRAVITY_SIGMAS * sigma))
    middle = np.median(pieces.points, axis=0)
    return Ground(up, middle + (foot - middle @ up) * up, float("nan"), False, 1.0)


def _bare(slab: Surfels) -> Array:
    """(P, 3) the surfels labelled floor, where there are enough; else all."""
    named = np.zeros(len(slab), bool) if slab.label is None else slab.label == _FLOOR_LABEL
    return slab.points[named] if named.mean() > _BARE_FLOOR_SHARE else slab.points


def _blended(slab: Array, plane: Plane, up: Array, agrees: float) -> Ground:
    """The floor's plane fit blended with the level plane at its mean height, by agreement."""
    off = np.rad2deg(np.arccos(min(1.0, float(plane.normal @ up))))
    trust = float(np.clip(2.0 - off / agrees, 0.0, 1.0))
    if trust == 1.0:
        return Ground(plane.normal, plane.point, plane.residual, True, trust)
    normal = trust * plane.normal + (1.0 - trust) * up
    normal /= np.linalg.norm(normal)
    middle = slab.mean(axis=0)
    raised = plane.heights(middle[None])[0] / (plane.normal @ up)
    point = middle - trust * raised * up
    return Ground(normal, point, float(np.std((slab - point) @ normal)), True, trust)


def _gravity(pieces: Surfels, guess: Array, tilt: float) -> Array:
    """(3,) the mode of level surfaces' normals; without any, the direction square to walls'."""
    toward = pieces.normals * np.sign(pieces.normals @ guess)[:, None]
    near = toward @ guess > np.cos(np.deg2rad(tilt + 2.0))
    flat = toward[near]
    up = guess
    if len(flat) > _MIN_FLOOR_M2 / _PIECE_M2:
        some = flat[:: max(1, len(flat) // 1500)]
        up = some[(some @ some.T > np.cos(np.deg2rad(3.0))).sum(axis=1).argmax()]
        for width in (6.0, 4.0, 3.0, 3.0):
            up = flat[flat @ up > np.cos(np.deg2rad(width))].mean(axis=0)
            up = up / np.linalg.norm(up)
        return np.asarray(up)
    for width in (tilt, 8.0, 5.0, 5.0):
        walls = pieces.normals[np.abs(pieces.normals @ up) < np.sin(np.deg2rad(width))]
        if len(walls) < MIN_PIECES:
            break
        up = _square_to(walls, guess)
    return up


def _square_to(walls: Array, guess: Array) -> Array:
    """(3,) the direction perpendicular to walls' normals (N, 3); of one wall, nearest the guess."""
    values, axes = np.linalg.eigh(walls.T @ walls / len(walls))
    free = axes[:, values < _ONE_WALL_SHARE]
    up = free @ (free.T @ guess) if free.shape[1] > 1 else free[:, 0] * np.sign(free[:, 0] @ guess)
    return np.asarray(up / np.linalg.norm(up))


def _refined_gravity(normals: Array, up: Array) -> tuple[Array, float]:
    """(3,) gravity from the normals (N, 3) of level surfaces and walls, and its error, degrees.

    Iteratively reweighted least squares: the sum of the squared sines of level normals to it and
    of the squared cosines of walls' is least for the largest eigenvector of the difference of
    their scatter matrices.
    """
    off = np.rad2deg(np.arccos(np.minimum(np.abs(normals @ up), 1.0)))
    usual = float(np.median(off[off < UPRIGHT_DEG])) if (off < UPRIGHT_DEG).any() else 0.0
    width = np.sin(np.deg2rad(np.clip(_OUTLIER_MEDIANS * usual, *_OUTLIER_LIMITS_DEG)))
    kernel = np.zeros(len(normals))
    for _ in range(_REWEIGHTING_ROUNDS):
        cosine = normals @ up
        sine = np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
        level, upright = (np.clip(1.0 - (v / width) ** 2, 0.0, None) ** 2 for v in (sine, cosine))
        kernel = level + upright
        if not level.any():
            break
        spread = (normals * (level - upright)[:, None]).T @ normals
        axis = np.linalg.eigh(spread)[1][:, 2]
        up = axis * np.sign(axis @ up)
    off = np.minimum(np.abs(normals @ up), np.linalg.norm(np.cross(normals, up), axis=1))
    mean = float((kernel * off**2).sum()) / max(float(kernel.sum()), 1e-9)
    return up, float(np.rad2deg(np.sqrt(mean * _SHARED_PIECES / max(float(kernel.sum()), 1.0))))


def _lowest_wall(heights: Array) -> float:
    """The lowest height at which walls have 15 % of their usual density."""
    if len(heights) < MIN_PIECES:
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
        weight[label == _FLOOR_LABEL] = 4.0
    low = heights.min() - 5 * _HEIGHT_BIN_M
    counts = np.bincount(((heights - low) / _HEIGHT_BIN_M).astype(int), weight)
    area = np.convolve(np.append(counts, np.zeros(5)), np.ones(5), "same")
    strong = area > max(_MIN_FLOOR_SHARE * area.max(), _MIN_FLOOR_M2 / _PIECE_M2)
    if not strong.any():
        return None
    first = int(np.flatnonzero(strong)[0])
    peak = first + int(area[first : first + 8].argmax())
    return float(low + (peak + 0.5) * _HEIGHT_BIN_M)


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


def level(cloud: Cloud, up: Array | None = None) -> Level:
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
        remedy="scan the whole room: its floor, and every wall from end to end; if that was "
        "done, give its unit (`unit`, `--unit`)",
    )


def _notes(ground: Ground) -> tuple[str, ...]:
    if not ground.seen:
        return ("the floor was not seen: it is placed where the walls end",)
    if ground.trust < 1.0 and ground.residual > _BENT_FLOOR_M:
        bent = f"{100.0 * ground.residual:.0f} cm"
        return (f"the floor is uneven by {bent}: it is made level at its mean height",)
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
