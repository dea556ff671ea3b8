"""Mouldings and wainscot: a section swept along a path in a plane, mitred at its corners.

Everything is in a frame of the path: u and v in its plane, w out of it. The section's first
coordinate points to the left of the path, its second along w.
"""

from collections.abc import Callable
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.building.wallruns import Run
from openrooms_usd.geometry.curves import signed_area
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.normals import with_normals

# Faces of a section that turn by more stay sharp, degrees.
_CREASE_DEG: Final = 35.0
# How far backs reach into what they are fixed to, so that no seam lets light pass, metres.
EMBED_M: Final = 0.002
# Edges are eased by so much, metres: what paint and sandpaper leave of them.
_EASE_M: Final = 0.0015
_STEPS: Final = 5

_BACK_M: Final = 0.003  # of the boards between the frames
_RAIL_M: Final = 0.09  # width of the frames
_FOOT_M: Final = 0.14  # width of the lowest rail, behind the skirting
_CAP_M: Final = 0.03  # height of the rail on top
_PANEL_M: Final = 0.6  # usual width of a panel


def moulding(path: Array, section: Array, *, closed: bool = False) -> Mesh:
    """A closed solid along a path.

    Args:
        path: (N, 2) corners in u and v, metres; consecutive ones differ.
        section: (K, 2) a simple ring: to the left of the path, and along w; metres.
        closed: Whether the last corner joins the first; the ends are cut square otherwise.

    Returns:
        The solid; its texture coordinates run around the section and along the path, metres.
    """
    if signed_area(section) < 0.0:
        section = section[::-1]
    count, ring = len(path), len(section)
    rows = count if closed else count - 1
    along, mitres = _mitres(path, closed)
    points = np.empty((count, ring, 3))
    points[..., :2] = path[:, None] + section[None, :, :1] * mitres[:, None]
    points[..., 2] = section[:, 1]
    i, j = (a.ravel() for a in np.indices((rows, ring)))
    row = np.stack([i, (i + 1) % count, (i + 1) % count, i], axis=1)
    column = np.stack([j, j, (j + 1) % ring, (j + 1) % ring], axis=1)
    around = np.concatenate([[0.0], np.cumsum(_steps(section))])
    starts = np.concatenate([[0.0], np.cumsum(_steps(path))])[:rows]
    # By the projection on each piece: at mitres patterns are cut, not bent.
    ahead = points[row, column][..., :2] - path[i][:, None]
    t = starts[i][:, None] + np.einsum("fcd,fd->fc", ahead, along[i])
    s = around[np.stack([j, j, j + 1, j + 1], axis=1)]
    indices, counts = [(row * ring + column).ravel()], [np.full(len(row), 4)]
    st = [np.stack([s, t], axis=-1).reshape(-1, 2)]
    if not closed:
        first, last = _cap(section), (rows * ring) + _cap(section)[:, ::-1]
        for cap in (first, last):
            indices.append(cap.ravel())
            counts.append(np.full(len(cap), 3))
            st.append(section[cap.ravel() % ring])
    mesh = Mesh(
        points=points.reshape(-1, 3),
        counts=np.concatenate(counts).astype(np.int32),
        indices=np.concatenate(indices).astype(np.int32),
        st=np.concatenate(st).astype(np.float32),
    )
    return with_normals(mesh.flipped(), crease=_CREASE_DEG)


def _steps(ring: Array) -> Array:
    return np.asarray(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1))


def _mitres(path: Array, closed: bool) -> tuple[Array, Array]:
    """(N, 2) directions of the pieces, and (N, 2) where a point one metre to the left goes."""
    ahead = np.roll(path, -1, axis=0) - path
    along = ahead / np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-12)
    if not closed:
        along[-1] = along[-2]
    before = np.roll(along, 1, axis=0)
    if not closed:
        before[0] = along[0]
    left, left_before = (np.stack([-d[:, 1], d[:, 0]], axis=1) for d in (along, before))
    share = 1.0 + np.einsum("ij,ij->i", left, left_before)
    return along, (left + left_before) / np.maximum(share, 0.05)[:, None]


def _cap(section: Array) -> Ints:
    """(M, 3) triangles of a section, counter-clockwise."""
    import mapbox_earcut

    ends = np.array([len(section)], dtype=np.uint32)
    found = mapbox_earcut.triangulate_float64(np.ascontiguousarray(section), ends)
    triangles = found.reshape(-1, 3).astype(np.int64)
    a, b, c = np.moveaxis(section[triangles], 1, 0)
    turned = (b - a)[:, 0] * (c - a)[:, 1] < (b - a)[:, 1] * (c - a)[:, 0]
    return np.asarray(np.where(turned[:, None], triangles[:, ::-1], triangles), dtype=np.int64)


def _arc(
    center: tuple[float, float], radius: tuple[float, float], start: float, end: float
) -> Array:
    """(S, 2) points of an ellipse between two angles, degrees."""
    t = np.radians(np.linspace(start, end, _STEPS + 1))
    return np.asarray(center) + np.stack([radius[0] * np.cos(t), radius[1] * np.sin(t)], axis=1)


def _square(depth: float, height: float) -> Array:
    """A plain board with an eased edge."""
    ease = min(_EASE_M, 0.3 * depth)
    return np.array([[depth, 0.0], [depth, height - ease], [depth - ease, height], [0.0, height]])


def _rounded(depth: float, height: float) -> Array:
    """A board whose upper edge is a quarter of an ellipse."""
    across, up = 0.75 * depth, min(1.1 * depth, 0.4 * height)
    arc = _arc((depth - across, height - up), (across, up), 0.0, 90.0)
    return np.concatenate([[[depth, 0.0]], arc, [[0.0, height]]])


def _ogee(depth: float, height: float) -> Array:
    """A board with a fillet, a hollow and a round above it: a cyma recta, as old houses have."""
    low, up = 0.62 * height, 0.38 * height
    fillet, half = 0.14 * up, 0.43 * up
    reach = 0.42 * depth
    round_ = _arc((0.9 * depth - reach, low + fillet), (reach, half), 0.0, 90.0)
    hollow = _arc(
        (0.9 * depth - reach, height), (0.9 * depth - reach - 0.25 * depth, half), -90.0, -180.0
    )
    return np.concatenate(
        [[[depth, 0.0], [depth, low], [0.9 * depth, low]], round_, hollow, [[0.0, height]]]
    )


def _torus(depth: float, height: float) -> Array:
    """A board with a half round bead along its upper edge."""
    bead = min(0.5 * depth, 0.2 * height)
    low = height - 2.0 * bead
    half = _arc((depth - bead, low + bead), (bead, bead), -90.0, 90.0)
    return np.concatenate([[[depth - bead, 0.0], [depth - bead, low]], half[1:], [[0.0, height]]])


def _cove(depth: float, height: float) -> Array:
    """A hollow quarter between two fillets; its height hangs down from the ceiling."""
    lip, foot = 0.1 * height, 0.1 * depth
    arc = _arc((depth, height), (depth - foot, height - lip), -90.0, -180.0)
    return np.concatenate(
        [[[depth, 0.0]], [[depth, lip]], arc[1:-1], [[foot, height], [0.0, height]]]
    )


def _stepped(depth: float, height: float) -> Array:
    """Three plain steps."""
    x, y = depth / 3.0, height / 3.0
    corners = [
        [3 * x, 0],
        [3 * x, y],
        [2 * x, y],
        [2 * x, 2 * y],
        [x, 2 * y],
        [x, 3 * y],
        [0, 3 * y],
    ]
    return np.array(corners, dtype=np.float64)


PROFILES: Final[dict[str, Callable[[float, float], Array]]] = {
    "square": _square,
    "rounded": _rounded,
    "ogee": _ogee,
    "torus": _torus,
    "cove": _cove,
    "stepped": _stepped,
}


def section(profile: str, depth: float, height: float) -> Array:
    """The section of a board on a wall: out of the wall from 0 to its depth, up to its height.

    Args:
        profile: One of `PROFILES`.
        depth: Metres, out of the wall.
        height: Metres.

    Returns:
        (K, 2) counter-clockwise; its back reaches `EMBED_M` into the wall.
    """
    face = PROFILES[profile](depth, height)
    distinct = face[np.concatenate([[True], _apart(face)])]
    return np.concatenate([[[-EMBED_M, 0.0]], distinct[:-1], [[-EMBED_M, height]]])


def _apart(points: Array) -> Mask:
    return np.asarray(np.linalg.norm(np.diff(points, axis=0), axis=1) > 1e-6)


def panelling(run: Run, height: float, depth: float) -> Mesh:
    """Panels along a run of walls.

    Args:
        run: Where.
        height: Of the whole, metres.
        depth: How far the frames stand out, metres.
    """
    rows = [
        ("square", _BACK_M, 0.0, height - 0.5 * _CAP_M),
        ("square", depth, 0.0, _FOOT_M),
        ("square", depth, height - _CAP_M - _RAIL_M, height - 0.5 * _CAP_M),
        ("torus", depth + 0.002, height - _CAP_M, height),
    ]
    made = [
        moulding(run.path, section(name, out, high - low), closed=run.closed).moved((0, 0, low))
        for name, out, low, high in rows
    ]
    ends = np.roll(run.path, -1, axis=0) if run.closed else run.path[1:]
    for a, b in zip(run.path[: len(ends)], ends, strict=True):
        made += _stiles(a, b, height, depth)
    return joined(made)


def _stiles(a: Array, b: Array, height: float, depth: float) -> list[Mesh]:
    """Upright boards between the rails, one at each end of a wall."""
    length = float(np.linalg.norm(b - a))
    if length < 3.0 * _RAIL_M:
        return []
    along = (b - a) / length
    count = max(1, round((length - _RAIL_M) / _PANEL_M))
    low, high = _FOOT_M - EMBED_M, height - _CAP_M - _RAIL_M + EMBED_M
    # Upwards along each: the wall is on its right, so the board is swept on its left.
    shape = section("square", depth - 0.0005, _RAIL_M)[:, ::-1] - [0.5 * _RAIL_M, 0.0]
    upright = np.array([[0.0, low], [0.0, high]])
    turn = np.column_stack(
        [[-along[0], -along[1], 0.0], [0.0, 0.0, 1.0], [-along[1], along[0], 0.0]]
    )
    places = np.linspace(0.5 * _RAIL_M, length - 0.5 * _RAIL_M, count + 1).tolist()
    board = moulding(upright, shape)
    return [board.transformed(np.column_stack([turn, [*(a + at * along), 0.0]])) for at in places]
