"""Curtains and blinds: drapes on rings, open or drawn, sheers, layers, a roller, and slats."""

from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import SIDE, board
from openrooms_usd.furniture.joinery.cloth import folded
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import METAL, Scheme
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.rotations import about_x
from openrooms_usd.geometry.solids import box, cylinder, sphere
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.vectors import points_at

ROD: Final = 0.0125
RING: Final = 0.024


# How much of the width curtains leave free: those that stand open or half open, and drawn ones.
_APART: Final = (0.35, 0.8)
_DRAWN: Final = (0.0, 0.12)


def _rod(size: Size, y: float) -> Parts:
    """A round rod with a knob at each end, on brackets that reach to the wall."""
    width, depth, height = size
    z, half, knob = height - RING, 0.5 * width, 0.022
    end = half - 2.0 * knob
    brackets = []
    places = np.linspace(0.08 - end, end - 0.08, 3 if width > 2.4 else 2)
    for x in places.tolist():
        brackets.append(board((x - 0.008, y, z - 0.008), (x + 0.008, 0.5 * depth, z + 0.008)))
        brackets.append(
            board((x - 0.02, 0.5 * depth - 0.006, z - 0.045), (x + 0.02, 0.5 * depth, z + RING))
        )
    knobs = [sphere(knob, segments=16, center=(s * (half - knob), y, z)) for s in (-1.0, 1.0)]
    rod = cylinder(ROD, 2.0 * end + 0.03, segments=16).transformed(SIDE)
    return {
        "rod": rod.moved((-end - 0.015, y, z)),
        **numbered("finial", knobs),
        **numbered("bracket", brackets),
    }


def _ring(x: float, y: float, z: float) -> Mesh:
    angle = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    path = points_at(x, y + 0.82 * RING * np.cos(angle), z + 0.82 * RING * np.sin(angle))
    return tube(path, 0.0028, segments=5, closed=True)


def _spans(half: float, open_: float) -> list[tuple[float, float]]:
    """Two curtains drawn to the sides, each over a share of its half."""
    inner = half * open_
    return [(-half, -inner), (inner, half)]


def drapes(size: Size, rng: np.random.Generator, apart: tuple[float, float] = _APART) -> Parts:
    """Heavy curtains drawn apart, on rings that slide on a rod."""
    width, depth, height = size
    deep = min(0.13, 0.8 * depth)
    y = -0.5 * depth + 0.5 * deep
    half = 0.5 * width - 0.03
    spans = _spans(half, float(rng.uniform(*apart)))
    top = height - 2.0 * RING
    pitch = float(rng.uniform(0.07, 0.1))
    cloths = [folded(span, (0.0, top), y, deep, pitch, 0.004, rng) for span in spans]
    rings = []
    for a, b in spans:
        count = min(12, max(3, round((b - a) / 0.1)))
        rings += [_ring(x, y, height - RING) for x in np.linspace(a + 0.01, b - 0.01, count)]
    return {**numbered("curtain", cloths), **_rod(size, y), **numbered("ring", rings)}


def _track(size: Size, y: float) -> Parts:
    """A slim rail with blocks that carry it from the wall."""
    width, depth, height = size
    half = 0.5 * width
    blocks = [
        board((x - 0.02, y, height - 0.022), (x + 0.02, 0.5 * depth, height - 0.004))
        for x in (0.1 - half, half - 0.1)
    ]
    return {
        "rod": board((-half, y - 0.012, height - 0.022), (half, y + 0.012, height), 0.003),
        **numbered("bracket", blocks),
    }


def sheer(size: Size, rng: np.random.Generator) -> Parts:
    """One thin curtain in fine folds over the whole width, on a rail."""
    width, depth, height = size
    deep = min(0.09, 0.8 * depth)
    y = -0.5 * depth + 0.5 * deep
    half = 0.5 * width - 0.01
    cloth = folded(
        (-half, half), (0.0, height - 0.018), y, deep, float(rng.uniform(0.085, 0.11)), 0.0015, rng
    )
    return {"sheer": cloth, **_track(size, y)}


def sheers(size: Size, rng: np.random.Generator) -> Parts:
    """Two thin curtains in fine folds, drawn apart on a rail."""
    width, depth, height = size
    deep = min(0.09, 0.8 * depth)
    y, half = -0.5 * depth + 0.5 * deep, 0.5 * width - 0.01
    pitch = float(rng.uniform(0.07, 0.09))
    cloths = [
        folded(span, (0.0, height - 0.018), y, deep, pitch, 0.0015, rng)
        for span in _spans(half, float(rng.uniform(*_APART)))
    ]
    return {**numbered("sheer", cloths), **_track(size, y)}


def layered(size: Size, rng: np.random.Generator) -> Parts:
    """Heavy curtains on a rod at the sides, and a sheer behind them."""
    width, depth, height = size
    front = 0.5 * depth
    parts = drapes((width, front, height), rng)
    parts = {name: mesh.moved((0.0, 0.5 * (front - depth), 0.0)) for name, mesh in parts.items()}
    deep = 0.24 * depth
    # Clear of the casing of the window and of its sill, which stands out 4 cm.
    y, half, top = 0.25 * depth - 0.5 * deep, 0.5 * width - 0.06, height - 0.06
    cloth = folded((-half, half), (0.01, top), y, deep, 0.1, 0.0015, rng)
    rail = board((-half, y - 0.01, top - 0.004), (half, y + 0.01, top + 0.014), 0.003)
    arms = [
        board(
            (x - 0.012, -0.5 * depth + 0.4 * front, height - RING - 0.012),
            (x + 0.012, 0.5 * depth, height - RING + 0.012),
            0.003,
        )
        for x in (0.16 - half, half - 0.16)
    ]
    count = sum(name.startswith("bracket") for name in parts)
    return {
        **parts,
        "sheer": cloth,
        "rail": rail,
        **{f"bracket_{count + i}": arm for i, arm in enumerate(arms)},
    }


def roller(size: Size, rng: np.random.Generator) -> Parts:
    """A cloth that comes down flat from a roll, with a bar at its hem and a chain."""
    width, depth, height = size
    r = min(0.024, 0.3 * depth)
    y, z = -0.5 * depth + r, height - r
    half, inner = 0.5 * width, 0.5 * width - 0.02
    side = 1.0 if rng.integers(2) else -1.0
    behind = y + r - 0.003 if rng.integers(2) else y - r + 0.003
    long = float(rng.uniform(0.4, 0.6)) * height
    x = side * (half - 0.006)
    chain = [
        (x, y - r + 0.004, z),
        (x, y - r + 0.004, z - long),
        (x, y + r - 0.004, z - long),
        (x, y + r - 0.004, z),
    ]
    brackets = [
        board(
            (min(s * inner, s * half), y - r, z - r),
            (max(s * inner, s * half), 0.5 * depth, height),
            0.004,
        )
        for s in (-1.0, 1.0)
    ]
    return {
        "blind": board(
            (0.004 - inner, behind - 0.0008, 0.012), (inner - 0.004, behind + 0.0008, z), 0.0004
        ),
        "rod": cylinder(r - 0.002, 2.0 * inner, segments=24)
        .transformed(SIDE)
        .moved((-inner, y, z)),
        "weight": board((-inner, behind - 0.006, 0.0), (inner, behind + 0.006, 0.026), 0.004),
        "chain": tube(chain, 0.0018, bend=0.012, segments=5, closed=True),
        **numbered("bracket", brackets),
    }


def venetian(size: Size, rng: np.random.Generator) -> Parts:
    """Slats that hang in cords below a head rail, turned by chance."""
    width, depth, height = size
    wide = min(0.05, 0.8 * depth)
    y, half, head = -0.5 * depth + 0.5 * wide, 0.5 * width, 0.045
    tilt = np.radians(float(rng.uniform(-65.0, 65.0)))
    pitch = 0.84 * wide
    count = max(2, int((height - head - 0.05) / pitch))
    slat = box((width - 0.012, wide - 0.001, 0.0022)).transformed(about_x(tilt))
    top = height - head - 0.5 * pitch
    levels = np.linspace(top, 0.05, count)
    places = np.linspace(0.15 - half, half - 0.15, max(2, round(width / 0.7)))
    cords = [
        tube([(x, y + o, 0.01), (x, y + o, height - 0.01)], 0.0009, segments=4)
        for x in places.tolist()
        for o in (-0.47 * wide, 0.47 * wide)
    ]
    return {
        **numbered("slat", [slat.moved((0.0, y, z)) for z in levels.tolist()]),
        "rod": board((-half, y - 0.5 * wide, height - head), (half, y + 0.5 * wide, height), 0.004),
        "weight": board((-half, y - 0.45 * wide, 0.0), (half, y + 0.45 * wide, 0.016), 0.004),
        **numbered("cord", cords),
        **numbered(
            "bracket",
            [
                board(
                    (x - 0.015, y, height - head + 0.002), (x + 0.015, 0.5 * depth, height - 0.002)
                )
                for x in (0.1 - half, half - 0.1)
            ],
        ),
    }


def _thin(size: Size) -> bool:
    return size[1] < 0.12


CATEGORY: Final = BuiltCategory(
    description="a curtain or a blind before a window",
    size=(2.0, 0.16, 2.3),
    min_size=(0.4, 0.05, 0.4),
    max_size=(8.0, 0.4, 5.0),
    styles={
        "drapes": Style(drapes, lambda size: not _thin(size)),
        "drawn": Style(partial(drapes, apart=_DRAWN), lambda size: not _thin(size)),
        "sheers": Style(sheers, lambda size: size[1] > 0.06),
        "sheer": Style(sheer, lambda size: size[1] > 0.06),
        "layered": Style(layered, lambda size: size[1] > 0.15 and size[0] > 1.2),
        "roller": Style(roller, _thin),
        "venetian": Style(venetian, _thin),
    },
    support="wall",
    mount_height=0.05,
    fixed=True,
    mass_range=(1.0, 12),
    words="curtains shower_curtain blinds drapes drapery blind "
    "roller_blind window_blind window_shade",
    classes=Classes("curtain", "curtain", "curtain"),
    schemes=(
        Scheme(
            {
                ANY: "drape",
                "sheer": "sheer",
                "blind": "blind",
                "rod": METAL,
                "ring": METAL,
                "finial": METAL,
                "slat": "white",
                "weight": "white",
                "rail": "white",
                "chain": "white",
            }
        ),
    ),
    construction=(
        row("sheer", filled(60), "common"),
        row(f"curtain blind cord {ANY}", filled(80), "common", "fabric"),
        row("slat", filled(400), "common"),
    ),
    collision_softness=0.05,
    view_importance=0.0,
)
