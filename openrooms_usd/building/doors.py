"""Doors: a lining with stops and casings, one leaf or two on their hinges, and handles.

Lengths are metres, in the opening's frame: x to the right seen from inside, y outwards, z up, the
origin in the middle of the opening on the wall's inner face. Everything is built for a leaf that
is hinged on the left and swings in, and is mirrored for the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.building.leaves import GAP, LEAF, PIVOT, STYLES, glass_of, handle, swept
from openrooms_usd.building.windows import EMBED, Span, bar
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.rotations import in_plan

# Openings wider than this have two leaves, metres.
TWO_LEAVES_M: Final = 1.3

_LINING = 0.03  # thickness of the boards that line the opening
_STOP = 0.03  # depth of the strip behind the leaf's edges, which keeps the light out
_OVERLAP = 0.012  # how far the stop covers the leaf
_CASING = (0.07, 0.015)  # width and thickness of the boards around the opening
_HANDLE_HEIGHT = 1.05


@dataclass(frozen=True, eq=False)
class Leaf:
    """What moves of a door.

    Attributes:
        panel: The leaf, in its own frame: closed, moved by the hinge.
        handle: Handles on both sides, in the leaf's frame.
        hinge: (2,) where the leaf's vertical axis stands in the opening's x and y.
        sense: +1 where the leaf opens counter-clockwise seen from above, -1 otherwise.
        swept: (2, 4, 2) rectangles in the leaf's x and y that the leaf and its handles cover.
        pane: Its glass, in the leaf's frame; None without.
    """

    panel: Mesh
    handle: Mesh
    hinge: Array
    sense: float
    swept: Array
    pane: Mesh | None = None

    def mirrored(self, x: float, y: float, across: float) -> "Leaf":
        """The leaf mirrored by the signs ``x`` and ``y``, then moved along y, metres."""
        mirror = np.diag([x, y, 1.0])
        return Leaf(
            panel=self.panel.transformed(mirror),
            handle=self.handle.transformed(mirror),
            hinge=self.hinge * [x, y] + [0.0, across],
            sense=self.sense * x * y,
            swept=self.swept @ mirror[:2, :2],
            pane=self.pane.transformed(mirror) if self.pane else None,
        )


@dataclass(frozen=True, eq=False)
class Door:
    """The parts of a door.

    Attributes:
        frame: Lining, stops and casings, in the opening's frame.
        leaves: One, or two that meet in the middle of a wide opening; the first one has the strip
            that covers the seam.
    """

    frame: Mesh
    leaves: tuple[Leaf, ...]


def door(
    width: float,
    height: float,
    thickness: float,
    *,
    hinge: Literal["left", "right"] = "left",
    swing: Literal["in", "out"] = "in",
    style: str = "panelled",
    cased: bool = True,
) -> Door:
    """Make a door that fills an opening.

    Args:
        width: Of the opening, metres; those wider than `TWO_LEAVES_M` have two leaves.
        height: Of the opening, metres.
        thickness: Of the wall, metres.
        hinge: On which side the leaf hangs, seen from inside; the first one where there are two.
        swing: Into the room or out of it.
        style: One of `STYLES`.
        cased: Whether plain casings are of its frame.
    """
    lining = min(_LINING, 0.1 * width)
    depth = max(thickness, LEAF + _STOP)
    # The leaf's bottom and top, from the middle of the opening.
    z = (-0.5 * height + 2 * GAP, 0.5 * height - lining - GAP)
    grip = min(-0.5 * height + _HANDLE_HEIGHT, 0.1 * height)
    double = width > TWO_LEAVES_M
    clear = width - 2 * (lining + GAP)
    leaf_width = 0.5 * (clear - GAP) if double else clear
    panel = STYLES[style](leaf_width, z)
    first = Leaf(
        panel=joined([panel, _seam_strip(leaf_width, z)]) if double else panel,
        handle=handle(leaf_width, grip),
        hinge=np.array([-0.5 * width + lining, -PIVOT]),
        sense=-1.0,
        swept=swept(leaf_width),
        pane=glass_of(style, leaf_width, z),
    )
    leaves = [first]
    if double:
        leaves.append(replace(first, panel=panel).mirrored(-1.0, 1.0, 0.0))
    right, out = hinge == "right", swing == "out"
    signs = (-1.0 if right else 1.0, -1.0 if out else 1.0)
    across = thickness if out else 0.0  # mirrored about the wall's middle
    frame = _frame(width, height, depth, thickness, lining, cased)
    return Door(
        frame=frame.transformed(np.diag([*signs, 1.0])).moved([0.0, across, 0.0]),
        leaves=tuple(leaf.mirrored(*signs, across) for leaf in leaves),
    )


def _seam_strip(width: float, z: Span) -> Mesh:
    """A strip before the seam between two leaves, fixed to the first one's edge."""
    x = GAP + width
    root = bar((x - 0.02, x - 0.001), (PIVOT - 0.01, PIVOT + EMBED), z)
    lip = bar((x - 0.006, x + 0.018), (PIVOT - 0.009, PIVOT - 0.0005), z)
    return joined([root, lip])


def _frame(
    width: float, height: float, depth: float, thickness: float, lining: float, cased: bool
) -> Mesh:
    x, bottom, top = 0.5 * width, -0.5 * height, 0.5 * height
    clear, upper = x - lining, top - lining
    y = (-EMBED / 5, depth + EMBED / 5)  # just proud of the wall: no face lies in another
    stop = (LEAF, LEAF + _STOP)
    parts = [
        bar((-clear, clear), y, (upper, top + EMBED)),
        bar((-clear, clear), stop, (upper - _OVERLAP - GAP, upper + EMBED)),
        bar((-clear, clear), stop, (bottom - EMBED, bottom + 2 * GAP + _OVERLAP), 0.004),
    ]
    for side in (-1.0, 1.0):
        parts.append(bar((side * clear, side * (x + EMBED)), y, (bottom, top + EMBED)))
        inner = clear - _OVERLAP - GAP
        parts.append(bar((side * inner, side * (clear + EMBED)), stop, (bottom, upper + EMBED)))
    if cased:
        far = max(thickness, depth) + _CASING[1]
        parts += _casing(x, (bottom, top), (-_CASING[1], EMBED))
        parts += _casing(x, (bottom, top), (thickness - EMBED, far))
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


def free_angle(made: Leaf, wanted: float, obstacles: Sequence[Array]) -> float:
    """How far a leaf can open, from closed, before it or its handles meet something.

    Args:
        made: The leaf.
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
        turned = made.swept @ in_plan(-np.radians(made.sense * angle)) + made.hinge
        parts = [shapely.Polygon(ring) for ring in turned]
        if any(part.intersects(solid) for part in parts for solid in near):
            return float(before)
    return wanted
