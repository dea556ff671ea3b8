"""Toilets: with a tank on the bowl, in one piece, hung on a wall."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.construction import ANY, CHINA, filled, row, walls
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import FRONT
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes, JointDamping
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft, ring, superellipse
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cylinder, lathe, rounded_box
from openrooms_usd.geometry.sweeps import tube

SEGMENTS: Final = 48
SEAT: Final = 0.018


def egg(width: float, front: float, back: float, square: float = 2.6) -> Array:
    """(N, 2) an outline that is an ellipse before its middle and squarer behind it.

    Args:
        width: Metres.
        front: From its middle to its front, metres.
        back: From its middle to its back, metres.
        square: Power of the superellipse behind the middle.
    """
    fore = superellipse(width, 2 * front, 2.1, SEGMENTS)
    rear = superellipse(width, 2 * back, square, SEGMENTS)
    return np.where(fore[:, 1:] < 0.0, fore, rear)


class _Plan:
    """Where things are, metres: the middle of the bowl, its reach, the hinge, the tank."""

    def __init__(self, size: Size, tank: float) -> None:
        width, depth, height = size
        self.width, self.depth, self.height = size
        self.tank = 0.5 * depth - tank
        self.hinge = self.tank - 0.05
        self.middle = -0.5 * depth + 0.56 * (self.hinge + 0.5 * depth)
        self.front = self.middle + 0.5 * depth
        self.back = self.hinge - self.middle
        self.broad = min(width, 0.37)
        self.rim = min(0.4, 0.6 * height)


def _bowl(plan: _Plan, stack: list[Array]) -> Mesh:
    """What is given from below, then over the rim into the bowl."""
    opening = egg(plan.broad - 0.1, plan.front - 0.055, plan.back - 0.06)
    rings = [ring(flat[:, :2], float(flat[0, 2]), (0.0, plan.middle)) for flat in stack]
    deep = min(0.2, 0.5 * plan.rim)
    for u, s in (
        (0.0, 1.03),
        (0.03, 1.0),
        (0.1, 1.03),
        (0.3, 1.0),
        (0.55, 0.86),
        (0.75, 0.66),
        (0.9, 0.44),
        (1.0, 0.3),
    ):
        rings.append(ring(opening * s, plan.rim - deep * u, (0.0, plan.middle + 0.03 * u)))
    return loft(rings, crease=50.0)


def _stack(
    plan: _Plan, foot: Array, deck: Array, shares: tuple[tuple[float, float], ...]
) -> list[Array]:
    """The outside from the foot to the rim: height and how far it has become the rim's outline."""
    rings = [ring((1.0 - s) * foot + s * deck, u * plan.rim) for u, s in shares]
    return [*rings, ring(deck, plan.rim - 0.008), ring(deck * 0.985, plan.rim)]


def _seat(made: Assembly, plan: _Plan) -> None:
    """A seat and a lid over it, both hung behind the bowl."""
    low = plan.rim + 0.003
    wide, front, back = plan.broad - 0.004, plan.front, plan.back - 0.012
    outer = egg(wide, front, back, 3.2)
    hole = egg(wide - 0.13, front - 0.075, back - 0.09)
    at = (0.0, plan.middle)
    seat = loft(
        [
            ring(outer * 0.985, low, at),
            ring(outer, low + 0.004, at),
            ring(outer, low + SEAT - 0.006, at),
            ring(outer * 0.97, low + SEAT, at),
            ring(hole * 1.06, low + SEAT - 0.002, at),
            ring(hole, low + SEAT - 0.008, at),
            ring(hole, low, at),
        ],
        closed=True,
    )
    over = low + SEAT + 0.002
    lid = loft(
        [
            ring(outer * 0.99, over, at),
            ring(outer, over + 0.003, at),
            ring(outer, over + 0.01, at),
            ring(outer * 0.97, over + 0.016, at),
            ring(outer * 0.8, over + 0.0195, at),
            ring(outer * 0.4, over + 0.021, at),
        ],
        crease=50.0,
    )
    y, z = plan.hinge, low + 0.012
    made.hinge("seat", made.add("seat", seat), (0.0, y, z), "top", 82.0)
    made.hinge("lid", made.add("lid", lid), (0.0, y, z), "top", 86.0)
    for x in (-0.075, 0.075):
        made.add("hinge", tube([(x - 0.02, y, z), (x + 0.02, y, z)], 0.01))


def _tank(made: Assembly, plan: _Plan, low: float, wide: float, lever: bool) -> None:
    """A tank with its lid, and a lever or a button."""
    back = 0.5 * plan.depth
    deep, middle = back - plan.tank, 0.5 * (back + plan.tank)
    top = plan.height - (0.0 if lever else 0.004)
    tall = top - low - 0.03
    body = [(0.9, 0.0), (0.95, 0.04), (1.0, 1.0)]
    flat = superellipse(wide - 0.016, deep - 0.012, 8.0, SEGMENTS)
    made.add("tank", loft([ring(flat * s, low + u * tall, (0.0, middle)) for s, u in body]))
    cover = superellipse(wide, deep, 8.0, SEGMENTS)
    made.add(
        "tank_lid",
        loft(
            [
                ring(cover, top - 0.032, (0.0, middle)),
                ring(cover, top - 0.01, (0.0, middle)),
                ring(cover * 0.985, top - 0.002, (0.0, middle)),
                ring(cover * 0.95, top, (0.0, middle)),
            ],
            crease=60.0,
        ),
    )
    if lever:
        x, y, z = -0.34 * wide, plan.tank + 0.008, top - 0.075
        made.add(
            "lever",
            tube(
                [(x, y, z), (x, y - 0.018, z), (x + 0.07, y - 0.018, z - 0.012)], 0.006, segments=10
            ),
        )
    else:
        button = cylinder(0.024, 0.008, bevel=0.002, segments=24)
        made.add("button", button.moved((0.0, middle, top - 0.004)))


def close_coupled(size: Size, rng: np.random.Generator) -> Furniture:
    """A bowl on a waisted foot, its tank standing on it."""
    made, plan = Assembly(), _Plan(size, min(0.2, 0.3 * size[1]))
    rear = 0.5 * plan.depth - plan.middle - 0.01
    deck = egg(plan.broad, plan.front, rear, 7.0)
    foot = egg(0.62 * plan.broad, 0.5 * plan.front, rear - 0.02, 5.0)
    shares = ((0.0, 0.06), (0.03, 0.02), (0.3, 0.02), (0.55, 0.3), (0.75, 0.72), (0.9, 0.95))
    made.add("base", _bowl(plan, _stack(plan, foot, deck, shares)))
    _seat(made, plan)
    _tank(made, plan, plan.rim - 0.004, size[0], bool(rng.integers(2)))
    return made.furniture()


def one_piece(size: Size, rng: np.random.Generator) -> Furniture:
    """Bowl, skirt and a low tank drawn in one line."""
    made, plan = Assembly(), _Plan(size, min(0.19, 0.28 * size[1]))
    rear = 0.5 * plan.depth - plan.middle
    deck = egg(plan.broad, plan.front, rear, 9.0)
    foot = egg(0.8 * plan.broad, 0.82 * plan.front, rear, 9.0)
    shares = ((0.0, 0.0), (0.02, 0.04), (0.4, 0.2), (0.7, 0.6), (0.9, 0.94))
    made.add("base", _bowl(plan, _stack(plan, foot, deck, shares)))
    _seat(made, plan)
    _tank(made, plan, plan.rim - 0.004, plan.broad, False)
    return made.furniture()


def wall_hung(size: Size, rng: np.random.Generator) -> Furniture:
    """A bowl that hangs free before a boxed wall with a plate for the flush."""
    width, depth, height = size
    made, box = Assembly(), min(0.15, 0.25 * depth)
    plan = _Plan(size, box)
    rear = plan.tank - plan.middle + 0.004
    deck = egg(plan.broad, plan.front, rear, 6.0)
    foot = egg(0.7 * plan.broad, 0.35 * plan.front, rear, 6.0)
    shares = ((0.24, 0.0), (0.27, 0.1), (0.45, 0.42), (0.65, 0.76), (0.85, 0.97))
    made.add("base", _bowl(plan, _stack(plan, foot, deck, shares)))
    _seat(made, plan)
    made.add(
        "panel",
        rounded_box((width, box, height), 0.004, center=(0.0, 0.5 * (depth - box), 0.5 * height)),
    )
    z = min(height - 0.1, plan.rim + 0.6)
    made.add("button", rounded_box((0.24, 0.016, 0.16), 0.004, center=(0.0, plan.tank, z)))
    ring_ = lathe([(0.0, 0.0), (0.045, 0.0), (0.042, 0.012), (0.0, 0.012)], segments=28)
    made.add("button", ring_.transformed(FRONT).moved((-0.04, plan.tank - 0.006, z)))
    return made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a toilet",
    size=(0.38, 0.68, 0.8),
    min_size=(0.3, 0.45, 0.55),
    max_size=(0.7, 0.95, 1.4),
    styles={
        "close_coupled": Style(close_coupled, lambda size: size[2] < 1.0),
        "one_piece": Style(
            one_piece, lambda size: size[2] < 0.9 and size[0] < 0.39, (0.37, 0.7, 0.7)
        ),
        "wall_hung": Style(wall_hung, lambda size: size[2] > 0.9, (0.5, 0.7, 1.12)),
    },
    size_variation=STANDARD,
    alternative_supports=("wall",),
    fixed=True,
    mass_range=(25, 50),
    words="lavatory",
    classes=Classes(nyu40="toilet", ade20k="toilet", coco="toilet"),
    schemes=(scheme("sanitary", chrome="button", white="panel"),),
    construction=(
        row("seat lid", filled(900), "weight"),
        row(ANY, walls(10, CHINA), "china", "specular_stone"),
    ),
    joint_damping=JointDamping(1.5, 0.1),
    offers_surfaces=("cistern",),
    view_importance=1.8,
)
