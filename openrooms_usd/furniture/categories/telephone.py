"""Telephones: one with keys and a display, one with a dial, one that stands in its charger."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import SIDE, board, corners, profiled
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import tapered, turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes, JointDamping
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe, sphere
from openrooms_usd.geometry.sweeps import tube


def _handset(long: float, thick: float) -> Mesh:
    """A handset along Y, both its shells in z = 0, their faces down."""
    reach = 0.5 * long - thick
    grip = [
        (0.0, -reach, 0.35 * thick),
        (0.0, -0.6 * reach, 1.5 * thick),
        (0.0, 0.6 * reach, 1.5 * thick),
        (0.0, reach, 0.35 * thick),
    ]
    shells = [
        cylinder(thick, 0.75 * thick, bevel=0.25 * thick, segments=24, base=(0.0, y, 0.0))
        for y in (-reach, reach)
    ]
    bent = filleted(grip, 1.2 * thick, segments=5)
    return joined([tube(bent, 0.52 * thick, segments=14), *shells])


def _coil(start: tuple[float, float, float], end: tuple[float, float, float], sag: float) -> Mesh:
    """A cord between two points that lies in a loop to the side."""
    t = np.linspace(0.0, 1.0, 17)[:, None]
    line = np.asarray(start) * (1.0 - t) + np.asarray(end) * t
    line[:, 0] -= sag * np.sin(np.pi * t[:, 0])
    line[:, 2] = np.maximum(line[:, 2] - 0.5 * sag * np.sin(np.pi * t[:, 0]), 0.004)
    return tube(line, 0.003, segments=6)


def desk(size: Size, rng: np.random.Generator) -> Parts:
    """An office telephone: a wedge with a handset at its left, keys and a tilted display."""
    width, depth, height = size
    half, front = 0.5 * width, -0.5 * depth
    crest = 0.8 * height
    outline = [(front, 0.0), (0.5 * depth, 0.0), (0.5 * depth, crest), (front, 0.3 * height)]
    slope = float(np.degrees(np.arctan2(crest - 0.3 * height, depth)))
    pivot = (0.0, front, 0.3 * height)
    # In the plane of the wedge: x, and y from its front edge.
    key = 0.058 * width
    keys = [
        tapered(
            board(
                (x - 0.5 * key, y - 0.4 * key, -0.002),
                (x + 0.5 * key, y + 0.4 * key, 0.003),
                0.0008,
            ),
            "z",
            (0.9, 0.9),
        )
        for x in (0.02 * width, 0.13 * width, 0.24 * width)
        for y in (front + depth * np.array([0.12, 0.21, 0.3, 0.39])).tolist()
    ]
    memory = [
        board((0.38 * width, y - 0.3 * key, -0.002), (0.45 * width, y + 0.3 * key, 0.002), 0.0005)
        for y in (front + depth * np.linspace(0.12, 0.39, int(rng.integers(3, 6)))).tolist()
    ]
    glass = board(
        (-0.02 * width, front + 0.55 * depth, -0.002),
        (0.45 * width, front + 0.88 * depth, 0.0015),
        0.0006,
    )
    long, thick = 0.92 * depth, 0.5 * height * 0.34
    handset = _handset(long, thick).moved((-half + 0.2 * width, 0.0, 0.0))
    rest = turned(handset, "x", slope).moved((0.0, 0.0, 0.5 * (crest + 0.3 * height) - 0.001))

    def laid(mesh: Mesh) -> Mesh:
        return turned(mesh.moved((0.0, 0.0, pivot[2])), "x", slope, pivot)

    return {
        "base": profiled(outline, width, SIDE, 0.004),
        "button": joined([laid(mesh) for mesh in [*keys, *memory]]),
        "screen": laid(glass),
        "handset": rest,
        "cord": _coil(
            (-half + 0.2 * width, front + 0.1 * depth, 0.3 * height),
            (-half + 0.2 * width, 0.42 * depth, 0.5 * height),
            0.14 * width,
        ),
    }


def dial(size: Size, rng: np.random.Generator) -> Parts:
    """An old one with a dial and a handset across its cradle."""
    width, depth, height = size
    thick = 0.12 * height
    body_top = height - 2.3 * thick
    shell = board((-0.4 * width, -0.5 * depth, 0.008), (0.4 * width, 0.5 * depth, body_top), 0.012)
    body = tapered(shell, "z", (0.72, 0.5))
    slope = float(np.degrees(np.arctan2(0.25 * depth, body_top)))
    radius = 0.24 * min(width, 1.4 * body_top)
    plate = lathe(
        [(0.0, 0.0), (radius, 0.0), (radius, 0.004), (0.9 * radius, 0.007), (0.0, 0.007)],
        segments=36,
    )
    holes = [
        cylinder(
            0.13 * radius,
            0.002,
            segments=12,
            base=(0.7 * radius * np.cos(a), 0.7 * radius * np.sin(a), 0.0062),
        )
        for a in np.radians(np.arange(10) * 30.0 + float(rng.uniform(-10.0, 10.0)))
    ]
    knob = sphere(0.34 * radius, segments=20, squash=0.25, center=(0.0, 0.0, 0.007))
    z = 0.44 * body_top
    at = (0.0, -0.5 * depth + 0.25 * depth * z / body_top - 0.002, z)
    poses = [turned(m, "x", 90.0 - slope).moved(at) for m in (joined([plate, knob]), joined(holes))]
    posts = [
        board(
            (x - 0.012, y - 0.01, body_top - 0.01), (x + 0.012, y + 0.01, body_top + 0.75 * thick)
        )
        for x, y in corners(0.24 * width, 0.14 * depth)
    ]
    handset = turned(_handset(width, thick), "z", 90.0).moved((0.0, 0.0, body_top))
    feet = [
        cylinder(0.012, 0.012, segments=14, base=(*at_, 0.0))
        for at_ in corners(0.32 * width, 0.4 * depth)
    ]
    return {
        "base": body,
        "dial": poses[0],
        "button": poses[1],
        **numbered("cradle", posts),
        "handset": handset,
        **numbered("foot", feet),
    }


def cordless(size: Size, rng: np.random.Generator) -> Parts:
    """A slim handset that stands in its charger."""
    width, depth, height = size
    cradle = 0.3 * height
    outline = [
        (-0.5 * depth, 0.0),
        (0.5 * depth, 0.0),
        (0.42 * depth, cradle),
        (-0.05 * depth, 0.72 * cradle),
        (-0.5 * depth, 0.3 * cradle),
    ]
    lean = float(rng.uniform(7.0, 11.0))
    c, s = np.cos(np.radians(lean)), np.sin(np.radians(lean))
    thick = 0.24 * depth
    long = (height - 0.35 * cradle - 0.5 * thick * s) / c
    wide = 0.62 * width
    shell = board((-0.5 * wide, -0.5 * thick, 0.0), (0.5 * wide, 0.5 * thick, long), 0.35 * thick)
    front = -0.5 * thick
    glass = board(
        (-0.38 * wide, front - 0.0006, 0.62 * long),
        (0.38 * wide, front + 0.003, 0.88 * long),
        0.0004,
    )
    key = 0.2 * wide
    keys = [
        board(
            (x - 0.42 * key, front - 0.0012, z - 0.3 * key),
            (x + 0.42 * key, front + 0.002, z + 0.3 * key),
            0.0005,
        )
        for x in (-0.27 * wide, 0.0, 0.27 * wide)
        for z in (long * np.array([0.24, 0.31, 0.38, 0.45, 0.53])).tolist()
    ]
    place = (0.0, 0.02 * depth, 0.35 * cradle)
    parts = {"handset": shell, "screen": glass, "button": joined(keys)}
    return {
        "base": profiled(outline, width, SIDE, 0.004),
        **{name: turned(mesh, "x", -lean).moved(place) for name, mesh in parts.items()},
        "antenna": cylinder(
            0.003, 0.5 * cradle, segments=10, base=(0.42 * wide, 0.3 * depth, 0.8 * cradle)
        ),
    }


CATEGORY: Final = BuiltCategory(
    description="a telephone",
    size=(0.2, 0.2, 0.1),
    min_size=(0.05, 0.06, 0.05),
    max_size=(0.4, 0.4, 0.35),
    styles={
        "desk": Style(desk, lambda size: size[2] < 0.8 * size[0]),
        "dial": Style(dial, lambda size: size[2] < 0.8 * size[0], (0.23, 0.19, 0.15)),
        "cordless": Style(cordless, lambda size: size[2] >= 0.8 * size[0], (0.08, 0.1, 0.19)),
    },
    size_variation=STANDARD,
    one_variant_per_room=True,
    support="surface",
    mass_range=(0.15, 1.5),
    words="phone",
    classes=Classes(openrooms45="telephone"),
    synsets=("02992529", "04401088"),
    schemes=(
        scheme("dark_plastic", pale_plastic="button", weight=2.0),
        scheme("pale_plastic"),
        scheme("black_plastic", steel="dial", needs="dial", weight=100.0),
    ),
    construction=(row(ANY, filled(400), "weight"),),
    joint_damping=JointDamping(0.01, 0.02),
    placements=(on("shop_counter cabinet_top", weight=0.3, max_groups=1),),
)
