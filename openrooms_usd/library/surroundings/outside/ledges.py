"""What is outside at a window: its sill, a rail, a box of flowers, a screen against insects.

In the frame of the window's outer face: its middle is the origin, x along it, y up, z outwards.
"""

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box

# Of the sill: beside the window, outwards, thick.
_SILL_M: Final = (0.03, 0.07, 0.025)
# Where people could fall out: from a sill so low, up to a rail so high above the floor.
_LOW_SILL_M: Final = 0.6
_RAIL_M: Final = 1.0
_BAR_M: Final = (0.014, 0.11)
_RAIL_OFF_M: Final = 0.06
_BOX_M: Final = (0.16, 0.15)
# Of a wider window one part alone has a screen, so wide; how far that stands back in the wall.
_SCREEN_M: Final = 0.75
_SCREEN_BACK_M: Final = 0.02


class Ledge(NamedTuple):
    """A part of it.

    Attributes:
        name: Unique at the window.
        category: What it is.
        mesh: In the frame of the window's outer face.
        look: One of `LOOKS`, or `NET`.
    """

    name: str
    category: str
    mesh: Mesh
    look: str


LOOKS: Final = {
    "Slate": (0.12, 0.12, 0.125),
    "Metal": (0.05, 0.052, 0.055),
    "Clay": (0.3, 0.13, 0.075),
}
"""Their reflectances."""

NET: Final = "Net"
"""The look of insect screens: too fine to be visible, so that it only dims."""
NET_PASSES: Final = (0.66, 0.66, 0.67)
"""What a screen lets through: threads of 0.23 mm, 1.2 mm apart."""


def ledges(
    width: float, height: float, sill: float, *, high: bool, flowers: bool, screen: bool
) -> Iterator[Ledge]:
    """What is at a window.

    Args:
        width: Of the opening, metres.
        height: The same.
        sill: Its height above the floor, metres.
        high: Whether it is above the lowest storey.
        flowers: Whether there is a box, where there is no rail.
        screen: Whether there is a screen against insects.
    """
    beside, out, thick = _SILL_M
    foot = -0.5 * height
    board = box((width + 2.0 * beside, thick, out), (0.0, foot - 0.5 * thick, 0.5 * out))
    yield Ledge("Sill", "windowsill", board, "Slate")
    if screen:
        wide = width if width < 2.0 * _SCREEN_M else _SCREEN_M
        yield Ledge("Screen", "insect_screen", _screen(wide, height, 0.5 * (wide - width)), NET)
    if high and sill < _LOW_SILL_M:
        yield Ledge("Rail", "railing", _rail(width, foot, foot - sill + _RAIL_M), "Metal")
    elif flowers:
        deep, tall = _BOX_M
        trough = box((0.86 * width, tall, deep), (0.0, foot - 0.6 * tall, out + 0.5 * deep + 0.01))
        yield Ledge("Box", "flowerpot", trough, "Clay")


def flower_places(width: float, height: float) -> Iterator[Array]:
    """(4, 4) where bushes one unit high stand in the box, from their frame to the window's."""
    deep, tall = _BOX_M
    count = max(2, round(0.86 * width / 0.2))
    upright = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
    for number in range(count):
        x = 0.86 * width * ((number + 0.5) / count - 0.5)
        size = 0.2 + 0.03 * (number % 3)
        place = upright @ np.diag([0.8 * size, 0.7 * size, size, 1.0])
        place[:3, 3] = x, -0.5 * height - 0.12 * tall, _SILL_M[1] + 0.5 * deep + 0.01
        yield place


def _screen(width: float, height: float, x: float) -> Mesh:
    """A sheet that is seen from both sides."""
    side = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    flat = side * [width, height] + [x, 0.0]
    points = np.column_stack([flat, np.full(4, -_SCREEN_BACK_M)])
    normals = np.tile(np.array([0, 0, 1], np.float32), (4, 1))
    return Mesh(points, np.array([4], np.int32), np.arange(4, dtype=np.int32), normals)


def _rail(width: float, foot: float, top: float) -> Mesh:
    """Upright bars between two rails, before the opening."""
    thick, apart = _BAR_M
    parts = [
        box((width + 0.1, 0.03, 0.03), (0.0, at, _RAIL_OFF_M)) for at in (foot + 0.06, top - 0.015)
    ]
    count = max(2, round(width / apart))
    for x in (np.linspace(-0.5, 0.5, count + 1) * (width + 0.06)).tolist():
        middle = 0.5 * (foot + 0.06 + top)
        parts.append(box((thick, top - foot - 0.06, thick), (x, middle, _RAIL_OFF_M)))
    return joined(parts)
