"""Printers: a flat one with a scanner, a laser printer, a copier for an office."""

from typing import Final, TypeAlias

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.boards import SIDE, board, corners, profiled
from openrooms_usd.furniture.joinery.pieces import Furniture, Joint, Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box, cylinder
from openrooms_usd.geometry.sweeps import tube

_PAPER: Final = 0.21  # metres, the width of a sheet


def _panel(x: float, width: float, front: float, z: float, keys: int) -> dict[str, Mesh]:
    """A tilted control panel: a display, keys beside it."""
    pivot = (x, front, z)
    plate = board((x - 0.5 * width, front, z - 0.004), (x + 0.5 * width, front + 0.05, z + 0.004))
    glass = board(
        (x - 0.42 * width, front + 0.008, z), (x - 0.02 * width, front + 0.042, z + 0.0046), 0.0005
    )
    dots = [
        cylinder(0.0045, 0.006, bevel=0.001, segments=12, base=(px, front + 0.025, z))
        for px in (x + width * np.linspace(0.08, 0.4, keys)).tolist()
    ]
    return {
        name: turned(mesh, "x", 24.0, pivot)
        for name, mesh in (("panel", plate), ("screen", glass), ("button", joined(dots)))
    }


def _sheets(
    width: float, low: tuple[float, float], high: tuple[float, float], thick: float
) -> Mesh:
    """A stack of paper seen from the side as a slanted strip, from (y, z) to (y, z)."""
    a, b = np.asarray(low), np.asarray(high)
    normal = np.array([a[1] - b[1], b[0] - a[0]]) / np.linalg.norm(b - a)
    strip = [a, b, b + thick * normal, a + thick * normal]
    return profiled(strip, width, SIDE, 0.0004)


_Point: TypeAlias = tuple[float, float, float]


def _lid(origin: _Point, degrees: float) -> Joint:
    return Joint("lid_0", "hinge", ("lid",), origin, (-1.0, 0.0, 0.0), (0.0, degrees))


def _drawer(name: str, meshes: tuple[str, ...], origin: _Point, travel: float) -> Joint:
    return Joint(name, "rail", meshes, origin, (0.0, -1.0, 0.0), (0.0, travel))


def inkjet(size: Size, rng: np.random.Generator) -> Furniture:
    """A low one: paper leans at its back, pictures come out in front, the lid is a scanner's."""
    width, depth, height = size
    back, front = 0.5 * depth - 0.05, -0.5 * depth + min(0.11, 0.28 * depth)
    body, paper = 0.62 * height, min(_PAPER, 0.6 * width)
    slot = 0.3 * body
    half = 0.5 * width
    shell = [
        board((-half, front, 0.0), (half, back, slot - 0.03), 0.006),
        board((-half, front, slot + 0.03), (half, back, body), 0.006),
        board((-half, front, slot - 0.032), (-0.55 * paper, back, slot + 0.032), 0.004),
        board((0.55 * paper, front, slot - 0.032), (half, back, slot + 0.032), 0.004),
        board((-half, front + 0.14, slot - 0.032), (half, back, slot + 0.032), 0.004),
    ]
    lid = board(
        (-half + 0.003, front + 0.004, body + 0.0015),
        (half - 0.003, back - 0.024, body + 0.026),
        0.008,
    )
    rest = profiled(
        [
            (back - 0.018, body - 0.01),
            (back - 0.008, body - 0.01),
            (0.5 * depth, height - 0.004),
            (0.5 * depth - 0.012, height - 0.004),
        ],
        paper + 0.03,
        SIDE,
        0.002,
    )
    feed = board(
        (-0.5 * paper - 0.025, back - 0.004, 0.03), (0.5 * paper + 0.025, back + 0.02, body - 0.01)
    )
    tray = board(
        (-0.52 * paper, -0.5 * depth, slot - 0.026), (0.52 * paper, front + 0.12, slot - 0.02)
    )
    stack = _sheets(paper, (back - 0.004, body), (0.5 * depth - 0.016, height), 0.006)
    lip = _sheets(
        0.9 * paper, (front + 0.1, slot - 0.0185), (-0.5 * depth + 0.02, slot - 0.0185), -0.001
    )
    knob = _panel(0.28 * width, 0.34 * width, front - 0.012, slot + 0.06, int(rng.integers(3, 6)))
    return Furniture(
        {
            "body": joined(shell),
            "lid": lid,
            "tray_0": rest,
            "frame": feed,
            "tray_1": tray,
            "paper_0": stack,
            "paper_1": lip,
            **knob,
        },
        (_lid((0.0, back - 0.024, body + 0.026), 75.0),),
    )


def _paper_drawer(half: float, span: tuple[float, float], tray: float, wide: float) -> Parts:
    """A front with a box behind it, and a ream of paper in the box."""
    front, rear = span
    face = board((-half + 0.021, front, 0.009), (half - 0.021, front + 0.02, tray - 0.003), 0.004)
    inner = (wide + 0.01) / 2
    walls = [
        board((-inner, front + 0.018, 0.009), (inner, rear - 0.06, 0.013), 0.001),
        board((-inner, front + 0.018, 0.012), (-inner + 0.004, rear - 0.06, 0.6 * tray), 0.001),
        board((inner - 0.004, front + 0.018, 0.012), (inner, rear - 0.06, 0.6 * tray), 0.001),
        board((-inner, rear - 0.064, 0.012), (inner, rear - 0.06, 0.6 * tray), 0.001),
    ]
    ream = board(
        (-inner + 0.006, front + 0.03, 0.0125), (inner - 0.006, rear - 0.07, 0.45 * tray), 0.0004
    )
    return {"drawer_front_0": face, "drawer_box_0": joined(walls), "paper_0": ream}


def laser(size: Size, rng: np.random.Generator) -> Furniture:
    """A tall one: a drawer of paper below, sheets lie in a hollow on its top."""
    width, depth, height = size
    half, front, rear = 0.5 * width, -0.5 * depth, 0.5 * depth
    tray = min(0.09, 0.3 * height)
    hollow, wide = 0.1 * height, min(_PAPER, 0.55 * width) + 0.03
    side = [
        (front + 0.012, tray),
        (rear, tray),
        (rear, height),
        (front + 0.3 * depth, height),
        (front + 0.012, height - 0.45 * hollow),
    ]
    core = [
        (front + 0.012, tray),
        (rear, tray),
        (rear, height - 0.02),
        (rear - 0.12 * depth, height - 0.012),
        (rear - 0.14 * depth, height - hollow),
        (front + 0.2 * depth, height - 0.45 * hollow),
        (front + 0.012, height - 0.5 * hollow),
    ]
    cheek = 0.5 * (width - wide)
    flank = profiled(side, cheek, SIDE, 0.006)
    offset = 0.5 * (wide + cheek)
    middle = profiled(core, wide + 0.012, SIDE, 0.001)
    base = [
        board((-half, front + 0.012, 0.0), (-half + 0.018, rear, tray + 0.004), 0.003),
        board((half - 0.018, front + 0.012, 0.0), (half, rear, tray + 0.004), 0.003),
        board((-half, rear - 0.02, 0.0), (half, rear, tray + 0.004), 0.003),
        board((-half + 0.01, front + 0.02, 0.0), (half - 0.01, rear, 0.006)),
    ]
    paper = _paper_drawer(half, (front, rear), tray, wide)
    out = _sheets(
        wide - 0.03,
        (rear - 0.15 * depth, height - hollow + 0.001),
        (front + 0.21 * depth, height - 0.45 * hollow + 0.001),
        -0.003,
    )
    panel = _panel(
        -0.5 * width + 0.5 * cheek,
        0.84 * cheek,
        front + 0.06 * depth,
        height - 0.016,
        int(rng.integers(2, 4)),
    )
    return Furniture(
        {
            "body": joined(
                [flank.moved((-offset, 0, 0)), flank.moved((offset, 0, 0)), middle, *base]
            ),
            **paper,
            "paper_1": out,
            **panel,
        },
        (_drawer("drawer_0", tuple(paper), (0.0, front + 0.01, 0.5 * tray), 0.6 * depth),),
    )


def _copier_drawer(
    half: float, depth: tuple[float, float], height: tuple[float, float], step: float
) -> tuple[Mesh, Mesh, Mesh]:
    """The front of a drawer of paper, its handle, and the box behind them."""
    (front, rear), (a, b) = depth, height
    inner, deep = half - 0.03, rear - 0.04
    walls = [
        box((2 * inner, deep - front - 0.02, 0.006), (0.0, 0.5 * (deep + front + 0.02), a + 0.004)),
        *(
            box(
                (0.006, deep - front - 0.02, 0.5 * step),
                (x, 0.5 * (deep + front + 0.02), a + 0.25 * step),
            )
            for x in (-inner + 0.003, inner - 0.003)
        ),
        box((2 * inner, 0.006, 0.5 * step), (0.0, deep - 0.003, a + 0.25 * step)),
    ]
    face = board((-half + 0.002, front + 0.004, a), (half - 0.002, front + 0.022, b), 0.003)
    grip = board(
        (-0.4 * half, front, 0.5 * (a + b) - 0.012),
        (0.4 * half, front + 0.006, 0.5 * (a + b) + 0.012),
    )
    return face, grip, joined(walls)


def copier(size: Size, rng: np.random.Generator) -> Furniture:
    """An office machine on castors: drawers of paper, a gap where copies lie, a feeder on top."""
    width, depth, height = size
    half, front, rear = 0.5 * width, -0.5 * depth, 0.5 * depth
    feeder = min(0.16, 0.16 * height)
    scanner, foot = height - feeder, 0.06
    low = 0.55 * scanner
    count = int(rng.integers(3, 5))
    shell = [
        board((-half, front + 0.02, low), (half, rear, low + 0.05 * height), 0.004),
        board((-half, rear - 0.3 * depth, low), (half, rear, scanner - 0.05), 0.004),
        board((half - 0.14 * width, front + 0.02, low), (half, rear, scanner - 0.05), 0.004),
        board((-half, front + 0.02, scanner - 0.1), (half, rear, scanner), 0.006),
        board((-half, front + 0.022, foot), (-half + 0.02, rear, low), 0.003),
        board((half - 0.02, front + 0.022, foot), (half, rear, low), 0.003),
        board((-half, rear - 0.02, foot), (half, rear, low), 0.003),
        board((-half, front + 0.022, foot), (half, rear, foot + 0.02), 0.003),
    ]
    parts = {"body": joined(shell)}
    joints = []
    step = (low - foot - 0.022) / count
    for i in range(count):
        a, b = foot + 0.022 + i * step, foot + 0.022 + (i + 1) * step - 0.004
        names = (f"drawer_front_{i}", f"handle_{i}", f"drawer_box_{i}")
        drawer = _copier_drawer(half, (front, rear), (a, b), step)
        parts |= zip(names, drawer, strict=True)
        joints.append(
            _drawer(f"drawer_{i}", names, (0.0, front + 0.012, 0.5 * (a + b)), 0.7 * depth)
        )
    lid = [
        board(
            (-half + 0.01, front + 0.04, scanner + 0.002),
            (half - 0.01, rear - 0.01, scanner + 0.035),
            0.006,
        ),
        board(
            (-half + 0.02, front + 0.1, scanner + 0.03), (-0.05 * width, rear - 0.03, height), 0.02
        ),
    ]
    ramp = _sheets(
        0.5 * depth, (0.02 * width, scanner + 0.04), (0.42 * width, height - 0.03), 0.006
    )
    # Drawn along the depth; the feeder's tray runs along the width.
    parts["lid"] = joined([*lid, turned(ramp, "z", -90.0).moved((0.0, 0.03, 0.0))])
    joints.append(_lid((0.0, rear - 0.01, scanner + 0.002), 60.0))
    parts |= _panel(0.22 * width, 0.4 * width, front, scanner - 0.02, 5)
    wheel = tube([(-0.011, 0.0, 0.0), (0.011, 0.0, 0.0)], 0.026, segments=18)
    forks = corners(half - 0.05, 0.5 * depth - 0.07)
    parts |= numbered("wheel", [wheel.moved((x, y, 0.026)) for x, y in forks])
    parts["base"] = joined(
        [
            board((x - 0.012, y - 0.012, 0.03), (x + 0.012, y + 0.012, foot + 0.002))
            for x, y in forks
        ]
    )
    return Furniture(parts, tuple(joints))


CATEGORY: Final = BuiltCategory(
    description="a printer; a copier where it is tall",
    size=(0.45, 0.4, 0.24),
    min_size=(0.32, 0.28, 0.19),
    max_size=(1.2, 0.9, 1.4),
    styles={
        "inkjet": Style(inkjet, lambda size: size[2] < 0.5),
        "laser": Style(laser, lambda size: 0.2 < size[2] < 0.6, (0.4, 0.4, 0.32)),
        "copier": Style(
            copier, lambda size: size[2] > 0.8, (0.62, 0.66, 1.15), mass_range=(35, 90)
        ),
    },
    one_variant_per_room=True,
    support="surface",
    mass_range=(4, 18),
    words="copier photocopier copy_machine duplicator",
    classes=Classes(openrooms45="printer"),
    synsets=("04004475",),
    schemes=(
        scheme(
            "pale_plastic",
            black_plastic="panel handle base",
            pale_plastic="button",
            dark_plastic="frame tray",
            white_paper="paper",
            weight=2.0,
        ),
        scheme("dark_plastic", pale_plastic="button handle", white_paper="paper"),
    ),
    construction=(row("paper", solid(750), "common"), row(ANY, filled(330), "weight")),
)
