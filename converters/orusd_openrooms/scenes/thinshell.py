"""A room's shell as the release has it: thin faces with true holes, Z up, and a second one around.

The inner faces of our walls become the layout; ``container.obj`` lies where their outer faces are,
with the same holes, so that light from outside comes in by these alone.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.triangulation import triangulate
from orusd_openrooms.scenes.objtext import Faces

Array = NDArray[np.float64]

# How far an opening's middle may lie from the side that it is cut into, metres.
_REACH_M: Final = 0.3
_LEAST_M: Final = 1e-6


@dataclass(frozen=True, eq=False)
class Opening:
    """A rectangle that is cut into the walls.

    Attributes:
        center: (3,) metres.
        along: (3,) unit vector along its width.
        width: Metres.
        height: Metres.
    """

    center: Array
    along: Array
    width: float
    height: float


def shell_faces(
    floor: Array,
    bottom: float,
    top: float,
    openings: Sequence[Opening],
    materials: Mapping[str, tuple[str, Array]],
) -> list[Faces]:
    """The faces of a shell, which look inwards; the ceiling's look up, as in the release.

    Args:
        floor: (N, 2) corners, counter-clockwise.
        bottom: Height of the floor, metres.
        top: Height of the ceiling.
        openings: What is cut into the walls.
        materials: By ``wall``, ``ceiling`` and ``floor``: the name, and the (3, 3) way from metres
            on the face to its texture coordinates.
    """
    walls = [
        quad
        for start, end in zip(floor, np.roll(floor, -1, axis=0), strict=True)
        for quad in _wall(start, end, bottom, top, openings)
    ]
    level = np.column_stack([floor, np.full(len(floor), bottom)])
    indices = np.arange(len(floor), dtype=np.int32)
    corners, _ = triangulate(level, np.array([len(floor)], dtype=np.int32), indices)
    below = level[corners]
    above = below + np.array([0.0, 0.0, top - bottom])
    found = {"wall": np.concatenate(walls), "ceiling": above, "floor": below}
    return [_faces(part, found[part], *materials[part]) for part in ("wall", "ceiling", "floor")]


def outside(floor: Array, thickness: float) -> Array:
    """(N, 2) the outline moved outwards, its corners kept."""
    before, after = floor - np.roll(floor, 1, axis=0), np.roll(floor, -1, axis=0) - floor
    a, b = (side / np.linalg.norm(side, axis=1, keepdims=True) for side in (before, after))
    normal_a, normal_b = (np.column_stack([side[:, 1], -side[:, 0]]) for side in (a, b))
    share = 1.0 + (normal_a * normal_b).sum(axis=1, keepdims=True)
    return np.asarray(floor + thickness * (normal_a + normal_b) / np.maximum(share, 0.1))


def _wall(
    start: Array, end: Array, bottom: float, top: float, openings: Sequence[Opening]
) -> Iterator[Array]:
    """(2, 3, 3) triangles of each rectangle that the openings leave of a wall."""
    length = float(np.linalg.norm(end - start))
    along = (end - start) / length
    holes = [hole for one in openings if (hole := _hole(one, start, along, length)) is not None]
    xs = _cuts([0.0, length], [x for hole in holes for x in hole[:2]])
    zs = _cuts([bottom, top], [z for hole in holes for z in hole[2:]])
    for x0, x1 in pairwise(xs):
        for z0, z1 in pairwise(zs):
            x, z = 0.5 * (x0 + x1), 0.5 * (z0 + z1)
            if any(left < x < right and low < z < high for left, right, low, high in holes):
                continue
            a, b = start + along * x0, start + along * x1
            quad = np.array([[*a, z0], [*b, z0], [*b, z1], [*a, z1]])
            yield quad[[[0, 2, 1], [0, 3, 2]]]


def _hole(
    one: Opening, start: Array, along: Array, length: float
) -> tuple[float, float, float, float] | None:
    away = one.center[:2] - start
    across = np.array([-along[1], along[0]])
    middle = float(away @ along)
    if abs(away @ across) > _REACH_M or abs(one.along[:2] @ along) < 0.99:
        return None
    if not 0.0 < middle < length:
        return None
    low, high = one.center[2] - 0.5 * one.height, one.center[2] + 0.5 * one.height
    return middle - 0.5 * one.width, middle + 0.5 * one.width, float(low), float(high)


def _cuts(ends: list[float], inner: list[float]) -> list[float]:
    """Ascending, without those that are beyond the ends or equal."""
    low, high = ends
    kept = sorted(x for x in inner if low + _LEAST_M < x < high - _LEAST_M)
    return [low, *(x for i, x in enumerate(kept) if i == 0 or x - kept[i - 1] > _LEAST_M), high]


def _faces(part: str, corners: Array, material: str, uv: Array) -> Faces:
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    if part == "wall":
        # Along the wall, and up.
        along = np.column_stack([-normals[:, 1], normals[:, 0]])
        flat = np.stack(
            [np.einsum("mij,mj->mi", corners[..., :2], along), corners[..., 2]], axis=-1
        )
    else:
        flat = corners[..., :2]
    st = flat @ uv[:2, :2].T + uv[:2, 2]
    return Faces(material, corners, np.repeat(normals[:, None], 3, axis=1), st)
