"""The fronts of carcass furniture: doors on hinges, drawers with boxes on rails, handles."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.joinery.assembly import Assembly, Side
from openrooms_usd.furniture.joinery.boards import FRONT, SIDE
from openrooms_usd.furniture.joinery.cells import BOARD, GAP, HANDLE, Cell, columns, rows
from openrooms_usd.furniture.joinery.pieces import FitOptions, Fronts
from openrooms_usd.geometry.lofts import loft, ring, rounded_rectangle, vessel
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import extrude, tube

# Side of the steel or wooden box of a drawer, and what its runner takes on either side, metres.
WALL: Final = 0.012
RUNNER: Final = 0.013
_UPRIGHT: Final = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])


def bar(length: float) -> Mesh:
    """A bent bar handle along X, 28 mm before the front at y = 0."""
    half = 0.5 * length
    path = [(-half, 0.0, 0.0), (-half, -0.0235, 0.0), (half, -0.0235, 0.0), (half, 0.0, 0.0)]
    return tube(path, 0.0045, bend=0.01, segments=10)


def knob(length: float = 0.0) -> Mesh:
    """A turned knob, 28 mm before the front at y = 0."""
    profile = [
        (0.0, 0.0),
        (0.006, 0.0),
        (0.005, 0.012),
        (0.011, 0.017),
        (0.0135, 0.021),
        (0.012, 0.026),
        (0.007, 0.028),
        (0.0, 0.028),
    ]
    return lathe(profile, segments=20, crease=70.0).transformed(FRONT)


def rod(length: float) -> Mesh:
    """A straight rod along X on two posts, 28 mm before the front at y = 0."""
    half, inset = 0.5 * length, 0.36 * length
    posts = [tube([(x, 0.0, 0.0), (x, -0.022, 0.0)], 0.004, segments=8) for x in (-inset, inset)]
    grip = tube([(-half, -0.022, 0.0), (half, -0.022, 0.0)], 0.006, segments=10)
    return joined([grip, *posts])


def grip(length: float) -> Mesh:
    """A flat strip along X bent to a hook in its section, 28 mm before the front at y = 0."""
    section = [
        (0.0, -0.01),
        (0.0, 0.01),
        (-0.028, 0.01),
        (-0.028, -0.004),
        (-0.025, -0.004),
        (-0.025, 0.007),
        (-0.003, 0.007),
        (-0.003, -0.01),
    ]
    return extrude(section, length, base=-0.5 * length).transformed(SIDE)


HANDLES: Final[dict[str, Callable[[float], Mesh]]] = {
    "bar": bar,
    "grip": grip,
    "knob": knob,
    "rod": rod,
}


@dataclass(frozen=True)
class FrontDesign:
    """How all fronts of one object look.

    Attributes:
        handle: One of `HANDLES`; empty for fronts without any.
        frame: Width of the frame around a recessed panel, metres; 0 for a plain board.
        glass: Whether doors hold a pane in place of the panel.
    """

    handle: str = "bar"
    frame: float = 0.0
    glass: bool = False


def drawn_look(rng: np.random.Generator, frames: float = 0.4) -> FrontDesign:
    """A look by chance; ``frames`` is the share of those with framed panels."""
    handle = sorted(HANDLES)[int(rng.integers(len(HANDLES)))]
    framed = rng.uniform() < frames
    return FrontDesign(handle, float(rng.uniform(0.045, 0.07)) if framed else 0.0)


# Equal on all units of a kitchen, as they are bought together.
_ORDERED: Final[dict[Fronts, FrontDesign]] = {
    "slab": FrontDesign("bar"),
    "shaker": FrontDesign("knob", 0.06),
    "handleless": FrontDesign(""),
}


def ordered_look(order: FitOptions, rng: np.random.Generator) -> FrontDesign:
    """The look that was ordered; any of them where none was."""
    drawn = sorted(_ORDERED)[int(rng.integers(len(_ORDERED)))]
    return _ORDERED[order.fronts or drawn]


def reach(look: FrontDesign) -> float:
    """How far handles stand out before the fronts, metres."""
    return HANDLE if look.handle else 0.0


def leaf(
    width: float,
    height: float,
    thickness: float = BOARD,
    *,
    frame: float = 0.0,
    recess: float = 0.006,
    corner: float = 0.0,
) -> Mesh:
    """A front standing on the origin's level, its back at y = 0; framed where ``frame`` > 0."""
    edge = min(0.002, 0.2 * thickness)

    def outline(inset: float, z: float) -> Array:
        flat = rounded_rectangle(
            width - 2 * inset, height - 2 * inset, corner - inset, segments=6 if corner > 0.0 else 0
        )
        return ring(flat, z, (0.0, 0.5 * height))

    rings = [
        outline(edge, 0.0),
        outline(0.0, edge),
        outline(0.0, thickness - edge),
        outline(edge, thickness),
    ]
    if 0.0 < frame < 0.3 * min(width, height):
        # The frame's inner edge is eased, too.
        rings += [
            outline(frame, thickness),
            outline(frame + edge, thickness - 0.6 * edge),
            outline(frame + edge + 0.5 * recess, thickness - recess),
        ]
    return loft(rings).transformed(FRONT)


def hang_door(
    made: Assembly,
    cell: Cell,
    y: float,
    side: Side,
    look: FrontDesign,
    *,
    thickness: float = BOARD,
    handle: tuple[float, float] | None = None,
    length: float = 0.16,
    upper: float = 110.0,
    riders: tuple[str, ...] = (),
) -> None:
    """A door before the plane ``y``, hung so that its front edge is the axis.

    Turning about its front edge, it stays within its own opening until it stands square to it.

    Args:
        made: Gets the door.
        cell: What it covers, the gap around it included.
        y: Where its back is, metres.
        side: Where its hinge is.
        look: Of the object.
        thickness: Metres.
        handle: X and Z of its handle; none where not given.
        length: Of the handle, metres.
        upper: How far it opens, degrees.
        riders: Parts made before that move with it.
    """
    left, right, low, high = cell
    half = 0.5 * GAP
    width, height, x = right - left - GAP, high - low - GAP, 0.5 * (left + right)
    at = (x, y, low + half)
    if look.glass:
        names = made.add("door", _sash(width, height, thickness).moved(at))
        inset = 0.055
        names += made.board(
            "pane",
            (left + inset, y - 0.7 * thickness, low + inset),
            (right - inset, y - 0.4 * thickness, high - inset),
            0.001,
        )
    else:
        names = made.add("door", leaf(width, height, thickness, frame=look.frame).moved(at))
    front = y - thickness
    if handle is not None and look.handle:
        mesh = HANDLES[look.handle](length)
        upright = mesh.transformed(_UPRIGHT) if side in ("left", "right") else mesh
        names += made.add("handle", upright.moved((handle[0], front, handle[1])))
    axis = {
        "left": (left + half, front, low),
        "right": (right - half, front, low),
        "bottom": (x, front, low + half),
        "top": (x, front, high - half),
    }[side]
    made.hinge("door", names + riders, axis, side, upper)


def _sash(width: float, height: float, thickness: float) -> Mesh:
    """An open frame for a pane: a ring, its back at y = 0."""
    rail = 0.06

    def outline(inset: float, z: float) -> Array:
        flat = rounded_rectangle(width - 2 * inset, height - 2 * inset, 0.0, segments=0)
        return ring(flat, z, (0.0, 0.5 * height))

    section = [
        outline(0.0, 0.0),
        outline(0.0, thickness - 0.002),
        outline(0.002, thickness),
        outline(rail - 0.002, thickness),
        outline(rail, thickness - 0.002),
        outline(rail, 0.0),
    ]
    return loft(section, closed=True).transformed(FRONT)


def doors(made: Assembly, cell: Cell, y: float, look: FrontDesign, pitch: float = 0.45) -> None:
    """Doors side by side, in pairs that open from their middle."""
    left, right, low, high = cell
    tall = high - low
    z = low + 0.5 * tall if tall > 0.9 else high - min(0.14, 0.3 * tall)
    if low > 1.2:
        z = low + min(0.14, 0.3 * tall)
    for i, part in enumerate(columns(cell, max(1, round((right - left) / pitch)))):
        side: Side = "left" if i % 2 == 0 else "right"
        x = part[1] - 0.04 if side == "left" else part[0] + 0.04
        hang_door(made, part, y, side, look, handle=(x, z), length=min(0.16, 0.4 * tall))


def drawer(
    made: Assembly,
    cell: Cell,
    y: float,
    back: float,
    look: FrontDesign,
    *,
    margin: float = BOARD,
    thickness: float = BOARD,
    riders: tuple[str, ...] = (),
) -> None:
    """A drawer: a front before the plane ``y``, a box behind it, and its handles.

    Args:
        made: Gets the drawer.
        cell: What its front covers, the gap around it included.
        y: Where the back of its front is, metres.
        back: How far its box reaches, metres.
        look: Of the object.
        margin: What stands behind the front at its sides and below it, metres.
        thickness: Of the front, metres.
        riders: Parts made before that move with it.
    """
    left, right, low, high = cell
    wide, tall, middle = right - left, high - low, 0.5 * (left + right)
    front = leaf(wide - GAP, tall - GAP, thickness, frame=look.frame)
    names = made.add("drawer_front", front.moved((middle, y, low + 0.5 * GAP))) + riders
    x = 0.5 * wide - margin - RUNNER
    base, top = low + margin + 0.006, high - max(0.03, 0.25 * tall)
    if x > 3 * WALL and top - base > 0.02 and back - y > 0.06:
        names += made.add(
            "drawer_box",
            vessel(
                (middle - x, y, base, middle + x, back, top),
                (middle - x + WALL, y + WALL, base + 0.01, middle + x - WALL, back - WALL),
                wall_edge=0.001,
            ),
        )
    spread = 0.27 * wide if look.handle == "knob" and wide > 0.55 else 0.0
    for offset in (-spread, spread) if spread else (0.0,) if look.handle else ():
        mesh = HANDLES[look.handle](min(0.2, 0.4 * wide))
        names += made.add(
            "handle", mesh.moved((middle + offset, y - thickness, 0.5 * (low + high)))
        )
    made.rail("drawer", names, 0.8 * (back - y))


def drawers(
    made: Assembly, cell: Cell, y: float, back: float, look: FrontDesign, pitch: float = 0.2
) -> None:
    """Drawers above each other, lower ones taller."""
    count = max(1, round((cell[3] - cell[2]) / pitch))
    for part in rows(cell, np.linspace(1.18, 0.86, count).tolist()):
        drawer(made, part, y, back, look)
