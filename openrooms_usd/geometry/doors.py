"""Doors: a lining with stops and casings, a panelled leaf on its hinge, and a handle.

Lengths are metres, in the opening's frame: x to the right seen from inside, y outwards, z up, the
origin in the middle of the opening on the wall's inner face. Everything is built for a leaf that
is hinged on the left and swings in, and is mirrored for the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, rounded_box
from openrooms_usd.geometry.windows import EMBED, bar

Array = NDArray[np.float64]

_LINING = 0.03  # thickness of the boards that line the opening
_LEAF = 0.04  # thickness of the leaf
_STOP = 0.03  # depth of the strip behind the leaf's edges, which keeps the light out
_OVERLAP = 0.012  # how far the stop covers the leaf
_GAP = 0.003  # between leaf and lining
_CASING = (0.07, 0.015)  # width and thickness of the boards around the opening
_PIVOT = 0.02  # the hinge's axis before the leaf: clear of the casing when it is wide open
_STILE, _TOP_RAIL, _LOCK_RAIL, _BOTTOM_RAIL = 0.11, 0.12, 0.14, 0.2
_PANEL = 0.018  # thickness of the panels between stiles and rails
_HANDLE_HEIGHT, _HANDLE_REACH = 1.05, 0.065


@dataclass(frozen=True, eq=False)
class Door:
    """The parts of a door.

    Attributes:
        frame: Lining, stops and casings, in the opening's frame.
        panel: The leaf, in the leaf's frame: closed, moved by the hinge.
        handle: Handles on both sides, in the leaf's frame.
        hinge: (2,) where the leaf's vertical axis stands in the opening's x and y.
        sense: +1 where the leaf opens counter-clockwise seen from above, -1 otherwise.
        swept: (2, 4, 2) rectangles in the leaf's x and y that the leaf and its handles cover.
    """

    frame: Mesh
    panel: Mesh
    handle: Mesh
    hinge: Array
    sense: float
    swept: Array


def door(
    width: float,
    height: float,
    thickness: float,
    *,
    hinge: Literal["left", "right"] = "left",
    swing: Literal["in", "out"] = "in",
) -> Door:
    """Make a door that fills an opening.

    Args:
        width: Of the opening, metres.
        height: Of the opening, metres.
        thickness: Of the wall, metres.
        hinge: On which side the leaf hangs, seen from inside.
        swing: Into the room or out of it.
    """
    lining = min(_LINING, 0.1 * width)
    depth = max(thickness, _LEAF + _STOP)
    leaf_width = width - 2 * (lining + _GAP)
    # The leaf's bottom and top, from the middle of the opening.
    z = (-0.5 * height + 2 * _GAP, 0.5 * height - lining - _GAP)
    frame = _frame(width, height, depth, thickness, lining)
    panel = _panel(leaf_width, z)
    handle = _handle(leaf_width, min(-0.5 * height + _HANDLE_HEIGHT, 0.1 * height))
    pivot = np.array([-0.5 * width + lining, -_PIVOT])
    right, out = hinge == "right", swing == "out"
    mirror = np.diag([-1.0 if right else 1.0, -1.0 if out else 1.0, 1.0])
    across = np.array([0.0, thickness if out else 0.0])  # mirrored about the wall's middle
    return Door(
        frame=frame.transformed(mirror).moved([*across, 0.0]),
        panel=panel.transformed(mirror),
        handle=handle.transformed(mirror),
        hinge=mirror[:2, :2] @ pivot + across,
        sense=-1.0 if right == out else 1.0,
        swept=_swept(leaf_width) @ mirror[:2, :2],
    )


def _frame(width: float, height: float, depth: float, thickness: float, lining: float) -> Mesh:
    x, bottom, top = 0.5 * width, -0.5 * height, 0.5 * height
    clear, upper = x - lining, top - lining
    y = (-EMBED / 5, depth + EMBED / 5)  # just proud of the wall: no face lies in another
    stop = (_LEAF, _LEAF + _STOP)
    parts = [
        bar((-clear, clear), y, (upper, top + EMBED)),
        bar((-clear, clear), stop, (upper - _OVERLAP - _GAP, upper + EMBED)),
        bar((-clear, clear), stop, (bottom - EMBED, bottom + 2 * _GAP + _OVERLAP), 0.004),
    ]
    for side in (-1.0, 1.0):
        parts.append(bar((side * clear, side * (x + EMBED)), y, (bottom, top + EMBED)))
        inner = clear - _OVERLAP - _GAP
        parts.append(bar((side * inner, side * (clear + EMBED)), stop, (bottom, upper + EMBED)))
    parts += _casing(x, (bottom, top), (-_CASING[1], EMBED))
    parts += _casing(x, (bottom, top), (thickness - EMBED, max(thickness, depth) + _CASING[1]))
    return joined(parts)


def _casing(x: float, z: tuple[float, float], y: tuple[float, float]) -> list[Mesh]:
    """Boards on the wall around three sides of the opening."""
    reveal = 0.01  # what stays visible of the lining's edge
    inner, outer = x - reveal, x - reveal + _CASING[0]
    below, above = z[1] - reveal, z[1] - reveal + _CASING[0]
    return [
        bar((-outer, -inner), y, (z[0], below)),
        bar((inner, outer), y, (z[0], below)),
        bar((-outer, outer), y, (below, above)),
    ]


def _panel(width: float, z: tuple[float, float]) -> Mesh:
    """Stiles, rails and the thinner panels between them; x runs from the hinge to the lock."""
    y = (_PIVOT, _PIVOT + _LEAF)
    x = (_GAP, _GAP + width)
    tall = z[1] - z[0]
    small = min(1.0, width / 0.6, tall / 1.2)  # small leaves have narrow stiles and rails
    columns = max(1, round(width / 0.45))
    stile = small * _STILE
    pitch = (width - stile) / columns
    parts = [bar((x[0] + i * pitch, x[0] + i * pitch + stile), y, z) for i in range(columns + 1)]
    lock = z[0] + 0.45 * tall
    rails = [
        (z[0], z[0] + small * _BOTTOM_RAIL),
        (lock - 0.5 * small * _LOCK_RAIL, lock + 0.5 * small * _LOCK_RAIL),
        (z[1] - small * _TOP_RAIL, z[1]),
    ]
    middle = 0.5 * (y[0] + y[1])
    thin = (middle - 0.5 * _PANEL, middle + 0.5 * _PANEL)
    for i in range(columns):
        between = (x[0] + i * pitch + stile - EMBED, x[0] + (i + 1) * pitch + EMBED)
        parts += [bar(between, y, rail) for rail in rails]
        for low, high in pairwise(rails):
            parts.append(bar(between, thin, (low[1] - EMBED, high[0] + EMBED)))
    return joined(parts)


def _handle(width: float, z: float) -> Mesh:
    """A rose, a neck and a lever that points to the hinge, on both sides of the leaf."""
    x = _GAP + width - min(0.06, 0.1 * width)
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
    return joined([inside.moved([x, _PIVOT, z]), one_side.moved([x, _PIVOT + _LEAF, z])])


def _swept(width: float) -> Array:
    """What the leaf and its handles cover in the leaf's x and y."""
    leaf = (_GAP, _PIVOT, _GAP + width, _PIVOT + _LEAF)
    near, far = _PIVOT - _HANDLE_REACH, _PIVOT + _LEAF + _HANDLE_REACH
    handles = (_GAP + 0.6 * width, near, _GAP + width, far)
    return np.array([[[a, b], [c, b], [c, d], [a, d]] for a, b, c, d in (leaf, handles)])


def free_angle(made: Door, wanted: float, obstacles: Sequence[Array]) -> float:
    """How far a leaf can open, from closed, before it or its handles meet something.

    Args:
        made: The door.
        wanted: How far it shall open, degrees.
        obstacles: (K, 2) simple rings in the opening's x and y.

    Returns:
        The angle wanted, or the last whole degree before the leaf is stopped.
    """
    import shapely

    reach = 1.1 * float(np.abs(made.swept).max())
    pivot = shapely.Point(made.hinge)
    solids = [shapely.Polygon(ring) for ring in obstacles]
    near = [solid for solid in solids if solid.distance(pivot) < reach]
    steps = [*np.arange(0.0, wanted), wanted]
    for before, angle in zip([0.0, *steps], steps, strict=False):
        turned = _turned(made.swept, made.sense * angle) + made.hinge
        parts = [shapely.Polygon(ring) for ring in turned]
        if any(part.intersects(solid) for part in parts for solid in near):
            return float(before)
    return wanted


def _turned(points: Array, degrees: float) -> Array:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.asarray(points @ np.array([[c, s], [-s, c]]))
