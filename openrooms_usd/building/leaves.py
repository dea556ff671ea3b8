"""Leaves of doors and their handles.

Lengths are metres, in the leaf's frame: the hinge's vertical axis in the origin, x from the hinge
to the lock, y outwards, z up, for a leaf that swings in.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.building.windows import EMBED, Span, bar, pane
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, rounded_box

LEAF: Final = 0.04  # thickness of a leaf
GAP: Final = 0.003  # between leaf and lining
PIVOT: Final = 0.02  # the hinge's axis before the leaf: clear of the casing when it is wide open
_STILE, _TOP_RAIL, _LOCK_RAIL, _BOTTOM_RAIL = 0.11, 0.12, 0.14, 0.2
_KICK_RAIL, _GLAZING_BAR = 0.3, 0.026  # of glazed leaves
_PANEL = 0.018  # thickness of the panels between stiles and rails
_HANDLE_REACH = 0.065


@dataclass(frozen=True)
class _Ladder:
    """Stiles and rails of a leaf, and the fields between them.

    Attributes:
        bars: The stiles and rails.
        fields: Left, right, lower and upper edge of each field, metres.
        y: Front and back of the leaf, metres.
    """

    bars: list[Mesh]
    fields: list[tuple[float, float, float, float]]
    y: Span


def _ladder(width: float, z: Span, columns: int, rails: Sequence[Span]) -> _Ladder:
    """Divide a leaf; x runs from the hinge to the lock."""
    y, x = (PIVOT, PIVOT + LEAF), (GAP, GAP + width)
    stile = _small(width, z) * _STILE
    pitch = (width - stile) / columns
    bars = [bar((x[0] + i * pitch, x[0] + i * pitch + stile), y, z) for i in range(columns + 1)]
    fields = []
    for i in range(columns):
        left, right = x[0] + i * pitch + stile, x[0] + (i + 1) * pitch
        bars += [bar((left - EMBED, right + EMBED), y, rail) for rail in rails]
        fields += [(left, right, low[1], high[0]) for low, high in pairwise(rails)]
    return _Ladder(bars, fields, y)


def _small(width: float, z: Span) -> float:
    """By how much the stiles and rails of small leaves are narrower."""
    return min(1.0, width / 0.6, (z[1] - z[0]) / 1.2)


def _panelled(width: float, z: Span) -> Mesh:
    """Stiles, rails and the thinner panels between them."""
    small, lock = _small(width, z), z[0] + 0.45 * (z[1] - z[0])
    rails = [
        (z[0], z[0] + small * _BOTTOM_RAIL),
        (lock - 0.5 * small * _LOCK_RAIL, lock + 0.5 * small * _LOCK_RAIL),
        (z[1] - small * _TOP_RAIL, z[1]),
    ]
    made = _ladder(width, z, max(1, round(width / 0.45)), rails)
    middle = 0.5 * (made.y[0] + made.y[1])
    thin = (middle - 0.5 * _PANEL, middle + 0.5 * _PANEL)
    panels = [
        bar((left - EMBED, right + EMBED), thin, (low - EMBED, high + EMBED))
        for left, right, low, high in made.fields
    ]
    return joined([*made.bars, *panels])


def _flush(width: float, z: Span) -> Mesh:
    """A plain slab."""
    return bar((GAP, GAP + width), (PIVOT, PIVOT + LEAF), z, 0.003)


def _glazed(width: float, z: Span) -> Mesh:
    """Stiles, rails and slim bars around open lights, whose glass is `glass_of`."""
    small, made = _small(width, z), _glazed_ladder(width, z)
    left, right, low, high = made.fields[0]
    half = 0.5 * small * _GLAZING_BAR
    slim = (made.y[0] + 0.006, made.y[1] - 0.006)
    columns, rows = max(1, round((right - left) / 0.3)), max(1, round((high - low) / 0.42))
    places = np.linspace(left, right, columns + 1)[1:-1].tolist()
    levels = np.linspace(low, high, rows + 1)[1:-1].tolist()
    bars = [bar((p - half, p + half), slim, (low - EMBED, high + EMBED)) for p in places]
    slim = (slim[0] + 0.0015, slim[1] - 0.0015)  # no face lies in another
    bars += [bar((left - EMBED, right + EMBED), slim, (p - half, p + half)) for p in levels]
    return joined([*made.bars, *bars])


def _glazed_ladder(width: float, z: Span) -> _Ladder:
    small = _small(width, z)
    rails = [(z[0], z[0] + small * _KICK_RAIL), (z[1] - small * _TOP_RAIL, z[1])]
    return _ladder(width, z, 1, rails)


def glass_of(style: str, width: float, z: Span) -> Mesh | None:
    """The pane of a leaf, a thin box whose edges stand in its stiles and rails; None without.

    Args:
        style: One of `STYLES`.
        width: Of the leaf, metres.
        z: Its lower and upper edge.
    """
    if style != "glazed":
        return None
    made = _glazed_ladder(width, z)
    left, right, low, high = made.fields[0]
    return pane((left, right), made.y, (low, high))


STYLES: Final[dict[str, Callable[[float, Span], Mesh]]] = {
    "panelled": _panelled,
    "flush": _flush,
    "glazed": _glazed,
}


def handle(width: float, z: float) -> Mesh:
    """A rose, a neck and a lever that points to the hinge, on both sides of the leaf."""
    x = GAP + width - min(0.06, 0.1 * width)
    lever = min(0.12, 0.3 * width)
    to_y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # Z to Y
    one_side = joined(
        [
            cylinder(0.026, 0.008, bevel=0.002).transformed(to_y),
            cylinder(0.009, _HANDLE_REACH - 0.01, segments=16).transformed(to_y),
            rounded_box(
                (lever + 0.018, 0.016, 0.018),
                0.006,
                segments=2,
                center=(-0.5 * lever, _HANDLE_REACH - 0.01, 0.0),
            ),
        ]
    )
    inside = one_side.transformed(np.diag([1.0, -1.0, 1.0]))
    return joined([inside.moved([x, PIVOT, z]), one_side.moved([x, PIVOT + LEAF, z])])


def swept(width: float) -> Array:
    """What the leaf and its handles cover in the leaf's x and y."""
    leaf = (GAP, PIVOT, GAP + width, PIVOT + LEAF)
    near, far = PIVOT - _HANDLE_REACH, PIVOT + LEAF + _HANDLE_REACH
    handles = (GAP + 0.6 * width, near, GAP + width, far)
    return np.array([[[a, b], [c, b], [c, d], [a, d]] for a, b, c, d in (leaf, handles)])
