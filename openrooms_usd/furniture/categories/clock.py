"""Clocks: round and square ones for a wall, one with rays, one for a mantelpiece."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board, corners
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import facing, turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted, rectangle
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box, cylinder, lathe
from openrooms_usd.geometry.sweeps import extrude


def _hand(long: float, wide: float, turn: float, z: float) -> Mesh:
    """A hand from just behind the axis to the hour, ``turn`` parts of a round clockwise."""
    outline = [
        (-0.5 * wide, -0.18 * long),
        (0.5 * wide, -0.18 * long),
        (0.22 * wide, long),
        (-0.22 * wide, long),
    ]
    return turned(extrude(outline, 0.0012, base=z), "z", -360.0 * turn)


def _works(radius: float, rng: np.random.Generator, *, numerals: bool) -> dict[str, Mesh]:
    """What tells the time, drawn along Z on the plane z = 0: marks and hands."""
    marks = []
    for i in range(60 if numerals else 12):
        hour = i % 5 == 0 or not numerals
        long, wide = (0.15, 0.032) if hour else (0.06, 0.012)
        bar = box((wide * radius, long * radius, 0.0013), (0.0, (0.93 - 0.5 * long) * radius, 0.0))
        marks.append(turned(bar, "z", -360.0 * i / (60 if numerals else 12)))
    minutes = int(rng.integers(0, 60))
    hours = (int(rng.integers(0, 12)) + minutes / 60.0) / 12.0
    hands = [
        _hand(0.52 * radius, 0.075 * radius, hours, 0.003),
        _hand(0.8 * radius, 0.055 * radius, minutes / 60.0, 0.005),
        cylinder(0.05 * radius, 0.0075, segments=18),
    ]
    return {"number": joined(marks), "hand": joined(hands)}


def _dial(radius: float, thick: float) -> Mesh:
    return cylinder(radius, thick, segments=48, base=(0.0, 0.0, -thick))


def round_(size: Size, rng: np.random.Generator) -> Parts:
    """A face in a raised round rim."""
    width, depth, height = size
    r = 0.5 * min(width, height)
    rim = float(rng.uniform(0.05, 0.1)) * r + 0.004
    deep = 0.45 * depth
    profile = [
        (r - rim, 0.0),
        (r, 0.0),
        (r, depth - 0.35 * rim),
        (r - 0.4 * rim, depth),
        (r - rim, depth - 0.25 * rim),
    ]
    parts = {
        "frame": lathe(profile, segments=56),
        "face": _dial(r - 0.8 * rim, deep).moved((0, 0, deep)),
    }
    works = _works(r - rim, rng, numerals=bool(rng.integers(2)))
    parts |= {name: mesh.moved((0.0, 0.0, deep)) for name, mesh in works.items()}
    return _turn_to_front(parts, size, 2.0 * r)


def _turn_to_front(parts: Parts, size: Size, side: float) -> Parts:
    """Turn what lies on z = 0 to the front, its back to the wall, and widen it to the box."""
    shape = np.diag([size[0] / side, 1.0, size[2] / side])
    at = (0.0, 0.5 * size[1], 0.5 * size[2])
    return {
        name: facing(mesh, (0, 0, 0)).transformed(shape).moved(at) for name, mesh in parts.items()
    }


def square(size: Size, rng: np.random.Generator) -> Parts:
    """A block of wood whose face carries the marks itself."""
    width, depth, height = size
    side = min(width, height)
    corner = float(rng.uniform(0.06, 0.16)) * side
    outline = filleted(rectangle(side, side), corner, closed=True, segments=6)
    deep = 0.72 * depth
    body = extrude(outline, deep, bevel=0.004)
    works = {n: m.moved((0, 0, deep)) for n, m in _works(0.47 * side, rng, numerals=False).items()}
    cap = cylinder(0.02 * side, depth - deep - 0.001, segments=18, base=(0.0, 0.0, deep + 0.001))
    works["hand"] = joined([works["hand"], cap])
    return _turn_to_front({"frame": body, **works}, size, side)


def sunburst(size: Size, rng: np.random.Generator) -> Parts:
    """A small face among rays of two lengths."""
    width, depth, height = size
    side = min(width, height)
    r = float(rng.uniform(0.2, 0.26)) * side
    rays = []
    count = 4 * int(rng.integers(6, 9))
    for i in range(count):
        far = 0.5 * side if i % 2 == 0 else 0.4 * side
        base = 1.3 * np.pi * r / count
        ray = extrude(
            [(-0.5 * base, 0.9 * r), (0.5 * base, 0.9 * r), (0.0012, far), (-0.0012, far)],
            0.35 * depth,
            base=0.1 * depth,
        )
        rays.append(turned(ray, "z", 360.0 * i / count))
    rim = lathe(
        [
            (0.86 * r, 0.0),
            (1.06 * r, 0.0),
            (1.06 * r, 0.8 * depth),
            (0.96 * r, depth),
            (0.86 * r, 0.85 * depth),
        ],
        segments=44,
    )
    deep = 0.6 * depth
    works = {n: m.moved((0, 0, deep)) for n, m in _works(0.86 * r, rng, numerals=False).items()}
    face = _dial(0.88 * r, deep).moved((0, 0, deep))
    return _turn_to_front({"ray": joined(rays), "frame": rim, "face": face, **works}, size, side)


def mantel(size: Size, rng: np.random.Generator) -> Parts:
    """A wooden case with an arched top on a plinth, for a shelf."""
    width, depth, height = size
    plinth = max(0.1 * height, 0.024)
    half = 0.44 * width
    body = height - plinth
    angle = np.linspace(0.0, np.pi, 17)
    rise = min(half, 0.62 * body)
    arch = np.stack([half * np.cos(angle), height - rise + rise * np.sin(angle)], axis=1)
    outline = [(-half, plinth - 0.004), (half, plinth - 0.004), *map(tuple, arch)]
    deep = 0.82 * depth
    flat = extrude(np.array(outline)[:, :2], deep, bevel=0.004)
    case = turned(flat, "x", 90.0).moved((0.0, 0.5 * depth - 0.01, 0.0))
    front = 0.5 * depth - 0.01 - deep
    r = 0.72 * half
    middle = (0.0, front, plinth + 0.54 * body)
    rim = lathe(
        [
            (0.92 * r, -0.004),
            (1.08 * r, -0.004),
            (1.08 * r, 0.006),
            (1.0 * r, 0.011),
            (0.92 * r, 0.006),
        ],
        segments=44,
    )
    parts = {
        "bezel": rim,
        "face": _dial(0.96 * r, 0.002).moved((0.0, 0.0, 0.001)),
        **{n: m.moved((0, 0, 0.001)) for n, m in _works(0.9 * r, rng, numerals=True).items()},
    }
    steps = [
        board(
            (-0.5 * width, -0.5 * depth, 0.012), (0.5 * width, 0.5 * depth, 0.65 * plinth), 0.004
        ),
        board(
            (-0.47 * width, front - 0.014, 0.6 * plinth),
            (0.47 * width, 0.5 * depth - 0.004, plinth),
            0.003,
        ),
    ]
    feet = [
        cylinder(0.014, 0.016, bevel=0.004, segments=16, base=(*at, 0.0))
        for at in corners(0.42 * width, 0.5 * depth - 0.02)
    ]
    return {
        "frame": case,
        "base": joined(steps),
        **numbered("foot", feet),
        **{name: facing(mesh, middle) for name, mesh in parts.items()},
    }


def _flat(size: Size) -> bool:
    return size[1] < 0.35 * size[2]


CATEGORY: Final = BuiltCategory(
    description="a clock, for a wall or a shelf",
    size=(0.3, 0.05, 0.3),
    min_size=(0.12, 0.025, 0.12),
    max_size=(1.0, 0.35, 1.0),
    styles={
        "round": Style(round_, _flat),
        "square": Style(square, _flat, (0.28, 0.045, 0.28)),
        "sunburst": Style(sunburst, lambda size: _flat(size) and size[2] > 0.35, (0.6, 0.05, 0.6)),
        "mantel": Style(mantel, lambda size: not _flat(size), (0.24, 0.12, 0.28)),
    },
    support="wall",
    mount_height=1.45,
    max_per_room=1,
    mass_range=(0.3, 3.5),
    words="wall_clock",
    classes=Classes("clock", "otherprop", "clock", "clock"),
    synsets=("03046257",),
    schemes=(
        scheme("black", wood="frame"),
        scheme("black", enamel="face", needs="face", weight=20.0),
        scheme("black", metal="frame", enamel="face", needs="face", weight=20.0),
        scheme(
            "black",
            wood="frame base",
            brass="foot bezel",
            enamel="face",
            needs="bezel",
            weight=500.0,
        ),
        scheme("black", brass="ray frame", enamel="face", needs="ray", weight=500.0),
    ),
    construction=(row(ANY, filled(500), "weight"),),
    placements=(
        on("wall", styles="round square sunburst", weight=0.3, max_groups=1),
        on("mantel cabinet_top", styles="mantel", weight=0.15, max_groups=1),
    ),
)
