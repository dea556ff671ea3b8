"""Toasters: bread goes down between their walls, on racks that a lever at one end pushes."""

from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import SIDE, board, corners, profiled
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import finished, scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import tube

FOOT: Final = 0.008
FLOOR: Final = 0.012
# How far the lever and the dial stand out at the right end, metres.
_OUT: Final = 0.022
_DIAL: Final = 0.012
# The racks go down by this part of the height.
_TRAVEL: Final = 0.3


def _arc(y: float, z: float, radius: float, start: float, end: float) -> Array:
    turn = np.radians(np.linspace(start, end, 7))
    return np.stack([y + radius * np.cos(turn), z + radius * np.sin(turn)], axis=1)


def _wall(outer: float, inner: float, top: float) -> Array:
    """The section of a long wall, round above its outer side; metres in y and z."""
    radius, way = 0.8 * abs(outer - inner), np.sign(inner - outer)
    arc = _arc(0.0, top - radius, radius, 180.0, 90.0) * [way, 1.0] + [outer + way * radius, 0.0]
    return np.concatenate([[[inner, FOOT], [outer, FOOT]], arc, [[inner, top]]])


def _end(depth: float, top: float, radius: float) -> Array:
    """The outline of an end, round above; metres in y and z."""
    half = 0.5 * depth
    left = _arc(radius - half, top - radius, radius, 180.0, 90.0)
    right = _arc(half - radius, top - radius, radius, 90.0, 0.0)
    return np.concatenate([[[half, FOOT], [-half, FOOT]], left, right])


def _guards(span: tuple[float, float], middle: float, slot: float, top: float) -> Mesh:
    """The wires on both sides of a slot that keep bread off the walls."""
    x = np.linspace(span[0], span[1], max(4, round((span[1] - span[0]) / 0.02)))[1:-1]
    return joined(
        [
            tube(
                [
                    (a, middle + side * (0.5 * slot - 0.0015), FOOT + FLOOR),
                    (a, middle + side * (0.5 * slot - 0.0015), top - 0.006),
                ],
                0.0008,
                segments=5,
            )
            for a in x.tolist()
            for side in (-1.0, 1.0)
        ]
    )


def build(size: Size, rng: np.random.Generator, slots: int, levers: int) -> Furniture:
    """A toaster with some slots along its width, and levers at its right end."""
    width, depth, height = size
    made = Assembly()
    slot, between = min(0.034, 0.5 * depth / slots), min(0.026, 0.22 * depth / slots)
    wall = 0.5 * (depth - slots * slot - (slots - 1) * between)
    left, right = -0.5 * width, 0.5 * width - _OUT
    cap = float(np.clip(0.11 * width, 0.015, 0.035))
    inside = (left + cap, right - cap)
    half, center = 0.5 * depth, 0.5 * (left + right)

    walls = [
        profiled(_wall(side * half, side * (half - wall), height), inside[1] - inside[0], SIDE, 0.0)
        for side in (-1.0, 1.0)
    ]
    # Middles of the slots, and the walls between them.
    middles = [wall - half + 0.5 * slot + i * (slot + between) for i in range(slots)]
    inner = [
        board(
            (inside[0], y + 0.5 * slot, FOOT), (inside[1], y + 0.5 * slot + between, height - 0.001)
        )
        for y in middles[:-1]
    ]
    made.add("frame", *(mesh.moved((center, 0.0, 0.0)) for mesh in walls), *inner)
    ends = profiled(_end(depth, height, 0.8 * wall), cap, SIDE, 0.0015)
    made.add("side", *(ends.moved((x, 0.0, 0.0)) for x in (left + 0.5 * cap, right - 0.5 * cap)))
    floors = [
        board((inside[0], y - 0.5 * slot, FOOT), (inside[1], y + 0.5 * slot, FOOT + FLOOR), 0.0)
        for y in middles
    ]
    made.add("base", *floors)
    foot = cylinder(0.011, FOOT + 0.001, bevel=0.002, segments=12)
    places = corners(0.5 * (right - left) - 0.02, half - 0.02)
    made.add("foot", *(foot.moved((center + x, y, 0.0)) for x, y in places))
    made.add("wire", *(_guards(inside, y, slot, height) for y in middles))
    racks = [
        board(
            (inside[0] + 0.006, y - 0.5 * slot + 0.006, 0.5 * height),
            (inside[1] - 0.006, y + 0.5 * slot - 0.006, 0.5 * height + 0.004),
            0.001,
        )
        for y in middles
    ]
    each = slots // levers
    for k in range(levers):
        own = racks[k * each : (k + 1) * each]
        _controls(
            made,
            size,
            right,
            float(np.mean(middles[k * each : (k + 1) * each])),
            own,
            min(0.2 * depth / levers, 0.035),
            float(rng.uniform(-60.0, 60.0)),
        )
    return made.furniture()


def _controls(
    made: Assembly, size: Size, face: float, y: float, racks: list[Mesh], aside: float, turn: float
) -> None:
    """A lever in its guide with the racks that go down with it, a dial and two buttons."""
    height = size[2]
    up, thick = 0.72 * height, min(0.014, 0.08 * height)
    guide = board(
        (face - 0.001, y - 0.004, up - _TRAVEL * height - 0.01),
        (face + 0.0006, y + 0.004, up + thick + 0.006),
        0.0,
    )
    made.add("guide", guide)
    wide = min(0.02, 0.8 * aside)
    grip = board((face + 0.0006, y - wide, up), (face + _OUT, y + wide, up + thick), 0.4 * thick)
    made.rail(
        "lever",
        (*made.add("lever", grip), *made.add("rack", *racks)),
        _TRAVEL * height,
        (0.0, 0.0, -1.0),
    )
    low, radius = 0.24 * height, min(0.1 * height, 0.017)
    profile = [(0.0, 0.0), (radius, 0.0), (0.86 * radius, _DIAL), (0.0, _DIAL)]
    notch = board((-0.001, -0.8 * radius, _DIAL - 0.001), (0.001, 0.0, _DIAL + 0.0008), 0.0)
    dial, mark = (
        turned(turned(mesh, "z", turn), "y", 90.0).moved((face, y, low))
        for mesh in (lathe(profile, segments=24), notch)
    )
    made.turn(
        "knob",
        (*made.add("knob", dial), *made.add("mark", mark)),
        (face, y, low),
        (1.0, 0.0, 0.0),
        (-90.0, 90.0),
    )
    button = turned(cylinder(0.32 * radius, 0.003, bevel=0.0006, segments=12), "y", 90.0)
    made.add(
        "button",
        *(
            button.moved((face - 0.0005, y + side * (aside + 0.4 * radius), low))
            for side in (-1.0, 1.0)
        ),
    )


def _is_long(size: Size) -> bool:
    return size[0] > 2.3 * size[1]


_DARK: Final = finished(black_plastic="side base foot guide", steel="wire", white="mark")

CATEGORY: Final = BuiltCategory(
    description="a toaster; its lever slides, its dial turns",
    size=(0.29, 0.17, 0.19),
    min_size=(0.18, 0.1, 0.13),
    max_size=(0.55, 0.45, 0.32),
    styles={
        "two_slots": Style(
            partial(build, slots=2, levers=1), lambda size: size[1] < 0.24 and not _is_long(size)
        ),
        "four_slots": Style(
            partial(build, slots=4, levers=2),
            lambda size: size[1] >= 0.24,
            (0.31, 0.28, 0.2),
            mass_range=(2, 4.5),
        ),
        "long_slot": Style(partial(build, slots=1, levers=1), _is_long, (0.4, 0.13, 0.19)),
    },
    size_variation=STANDARD,
    one_variant_per_room=True,
    support="surface",
    mass_range=(1, 3),
    on_worktop_probability=0.2,
    classes=Classes(coco="toaster"),
    schemes=(
        scheme("steel", _DARK, black_plastic="lever knob", weight=2.0),
        scheme("enamel", _DARK, enamel="side", chrome="knob"),
        scheme("black_plastic", _DARK, steel="knob lever"),
    ),
    construction=(row(ANY, filled(300), "weight"),),
)
