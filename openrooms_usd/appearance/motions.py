"""Small rigid motions of cameras."""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.rotations import about_point, inverse

# Motions nearer to each other than this are one.
_SAME_M: Final = 0.15
_SAME_DEG: Final = 4.0
# How sure a photograph's own pose is.
_PRIOR_M: Final = 0.02
_PRIOR_DEG: Final = 1.0
# Without a prior: so that what nothing tells stays as it is.
_FREE: Final = 1e-3
# Steps end below this, metres or radians.
_ENOUGH: Final = 1e-4


def motion(values: ArrayLike, pivot: Array) -> Array:
    """(4, 4) a turn about a point and a shift.

    Args:
        values: (6,) shift in metres, then the turn as axis times radians.
        pivot: (3,) what the turn leaves where it is.
    """
    from scipy.spatial.transform import Rotation

    six = np.asarray(values, dtype=np.float64)
    turned = about_point(Rotation.from_rotvec(six[3:]).as_matrix(), pivot)
    turned[:3, 3] += six[:3]
    return turned


def motion_size(rigid: Array, at: Array) -> tuple[float, float]:
    """How far a motion (4, 4) moves a point (3,), metres, and how far it turns, degrees."""
    shift = rigid[:3, :3] @ at + rigid[:3, 3] - at
    cosine = np.clip(0.5 * (np.trace(rigid[:3, :3]) - 1.0), -1.0, 1.0)
    return float(np.linalg.norm(shift)), float(np.degrees(np.arccos(cosine)))


def in_camera(points: Array, world_from_camera: Array) -> Array:
    """(..., 3) points of the world in a camera's frame."""
    back = inverse(world_from_camera)
    return np.asarray(points @ back[:3, :3].T + back[:3, 3])


def moved(points: Array, rigid: Array) -> Array:
    """(..., 3) points after a rigid motion (4, 4)."""
    return np.asarray(points @ rigid[:3, :3].T + rigid[:3, 3])


def distinct(motions: Sequence[Array], scores: Array, pivot: Array, count: int) -> list[Array]:
    """The best motions, best first, of those alike only one."""
    kept: list[Array] = []
    for index in np.argsort(-scores, kind="stable"):
        one = motions[index]
        apart = [motion_size(one @ inverse(other), pivot) for other in kept]
        if all(shift > _SAME_M or turn > _SAME_DEG for shift, turn in apart):
            kept.append(one)
        if len(kept) == count:
            break
    return kept


def descended(
    evidence: Callable[[Array], tuple[Array, Array]],
    start: Array,
    pivot: Array,
    steps: int,
    origin: Array | None = None,
) -> Array:
    """A motion (4, 4) near another one, by steps of least squares.

    Args:
        evidence: For a motion, the normal equations of a further small one: (6, 6) and (6,).
        start: (4, 4) the motion to begin with.
        pivot: (3,) what small motions turn about.
        steps: At most so many.
        origin: (4, 4) the motion that it is drawn to, as a photograph's own pose is; None if free.
    """
    from scipy.spatial.transform import Rotation

    now = start
    for _ in range(steps):
        normal, right = evidence(now)
        if origin is None:
            normal = normal + _FREE * np.eye(6)
        else:
            gone = now @ inverse(origin)
            turn = Rotation.from_matrix(gone[:3, :3]).as_rotvec()
            certainty = np.repeat([_PRIOR_M, np.radians(_PRIOR_DEG)], 3) ** -2.0
            right = right - certainty * np.concatenate([moved(pivot, gone) - pivot, turn])
            normal = normal + np.diag(certainty)
        step = np.linalg.solve(normal, right)
        now = motion(step, pivot) @ now
        if np.abs(step).max() < _ENOUGH:
            break
    return now
