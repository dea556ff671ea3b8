"""Wainscot: boards on the lower part of walls, framed in panels below a rail."""

from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.mouldings import EMBED_M, moulding, section
from openrooms_usd.geometry.wallruns import Run

Array: TypeAlias = NDArray[np.float64]

_BACK_M: Final = 0.003  # of the boards between the frames
_RAIL_M: Final = 0.09  # width of the frames
_FOOT_M: Final = 0.14  # width of the lowest rail, behind the skirting
_CAP_M: Final = 0.03  # height of the rail on top
_PANEL_M: Final = 0.6  # usual width of a panel


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
