"""Pictures by rules, of a few sheets of colour: landscapes, skylines, plants, shapes.

A landscape's sheets have the kinds ``sky`` (of the canvas), ``light``, ``far``, ``middle``,
``near`` and ``ground``, which the scheme of a picture finishes in one palette: the darker the
nearer, as haze makes it.
"""

from collections.abc import Callable
from typing import Final, TypeAlias

import numpy as np

from openrooms_usd.furniture.joinery.boards import FRONT, profiled
from openrooms_usd.furniture.joinery.pieces import Parts, numbered
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.geometry.lofts import superellipse
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box, cylinder

Rectangle: TypeAlias = tuple[float, float, float, float]
"""Left, right, low, high, metres."""
Painter: TypeAlias = Callable[[Rectangle, float, np.random.Generator], Parts]

_LAYER_M: Final = 0.0003
_DEEP_M: Final = 0.0008


def sheet_of(outline: np.ndarray, front: float, level: int) -> Mesh:
    """A sheet of colour over a polygon (x, z) before a plane y = ``front``; higher ones before."""
    proud = _LAYER_M * (1 + level)
    thick = proud + _DEEP_M
    return profiled(outline, thick, FRONT, 0.0).moved((0.0, front - proud + 0.5 * thick, 0.0))


def canvas_of(inside: Rectangle, front: float) -> Mesh:
    """What is painted on: a sheet whose front is the plane y = ``front``."""
    left, right, low, high = inside
    size = (right - left, 0.003, high - low)
    return box(size, (0.5 * (left + right), front + 0.0015, 0.5 * (low + high)))


def disc_of(at: tuple[float, float], radius: float, front: float, level: int) -> Mesh:
    """A disc of colour about a point (x, z)."""
    proud = _LAYER_M * (1 + level)
    disc = turned(cylinder(radius, proud + _DEEP_M, segments=30), "x", 90.0)
    return disc.moved((at[0], front + _DEEP_M, at[1]))


def _crest(count: int, rough: float, rng: np.random.Generator) -> np.ndarray:
    """Heights between 0 and 1 along a ridge: waves whose amplitude falls with their number."""
    x = np.linspace(0.0, 1.0, count)
    waves = np.arange(1, 9)
    phase, size = rng.uniform(0.0, 2.0 * np.pi, 8), waves ** -(1.9 - rough)
    line = (size * np.sin(np.pi * waves * x[:, None] + phase)).sum(axis=1)
    return np.asarray((line - line.min()) / (line.max() - line.min()))


def _ridge(
    inside: Rectangle, base: float, rise: float, crest: np.ndarray, front: float, level: int
) -> Mesh:
    """Land from the lower edge up to a crest; ``base`` and ``rise`` are shares of the height."""
    left, right, low, high = inside
    x = np.linspace(right, left, len(crest))
    z = low + (high - low) * (base + rise * crest)
    outline = np.concatenate([[(left, low), (right, low)], np.stack([x, z], axis=1)])
    return sheet_of(outline, front, level)


def landscape(inside: Rectangle, front: float, rng: np.random.Generator) -> Parts:
    """Ridges behind each other under a sky with a sun or a moon."""
    left, right, low, high = inside
    wide, tall = right - left, high - low
    horizon = float(rng.uniform(0.36, 0.52))
    names, steps = ("far", "middle", "near", "ground"), (0.0, 0.12, 0.24, 0.34)
    parts = {"canvas": canvas_of(inside, front)}
    r = float(rng.uniform(0.05, 0.1)) * min(wide, tall)
    sun = (left + float(rng.uniform(0.2, 0.8)) * wide, low + float(rng.uniform(0.66, 0.8)) * tall)
    parts["light"] = disc_of(sun, r, front, 0)
    for level, (name, below) in enumerate(zip(names, steps, strict=True)):
        base = max(horizon - below, 0.03)
        rise = float(rng.uniform(0.1, 0.2)) * (1.0 - 0.12 * level)
        rough = 0.55 if level == 2 else 0.15
        crest = _crest(25, rough, rng)
        parts[name] = _ridge(inside, base, rise, crest, front, 1 + level)
    return parts


def skyline(inside: Rectangle, front: float, rng: np.random.Generator) -> Parts:
    """Houses and towers in two rows before a pale sky, over water."""
    parts = {"canvas": canvas_of(inside, front)}
    for level, (name, base, rise) in enumerate((("far", 0.34, 0.34), ("near", 0.3, 0.26))):
        # So many points to a roof that walls are all but upright.
        roofs = np.repeat(rng.uniform(0.15, 1.0, 9 - 2 * level), 14)
        parts[name] = _ridge(inside, base, rise, roofs, front, 1 + level)
    flat = np.zeros(3)
    parts["ground"] = _ridge(inside, 0.3, 0.0, flat, front, 3)
    return parts


def botanical(inside: Rectangle, front: float, rng: np.random.Generator) -> Parts:
    """A twig with leaves, as in a herbarium."""
    left, right, low, high = inside
    wide, tall = right - left, high - low
    t = np.linspace(0.0, 1.0, 15)
    sway = float(rng.uniform(-0.12, 0.12)) * wide
    x = 0.5 * (left + right) + sway * np.sin(0.5 * np.pi * t) * t
    z = low + tall * (0.08 + 0.8 * t)
    half = 0.004 * tall * (1.25 - t)
    stem = np.concatenate([np.stack([x - half, z], 1), np.stack([x + half, z], 1)[::-1]])
    leaves = []
    pairs = int(rng.integers(5, 8))
    long = float(rng.uniform(0.2, 0.26)) * tall
    slim = float(rng.uniform(0.28, 0.5))
    for i in range(2 * pairs + 1):
        share = 0.3 + 0.7 * (i // 2) / pairs
        size = long * (1.0 - 0.45 * (share - 0.3))
        size = min(size, 0.42 * wide)
        u = np.linspace(0.0, 1.0, 8)
        edge = 0.5 * slim * size * np.sin(np.pi * u) ** 0.9
        upper = np.stack([u * size, edge], axis=1)
        shape = np.concatenate([upper, (upper * [1.0, -1.0])[-2:0:-1]])
        side = 1.0 if i % 2 else -1.0
        turn = np.pi / 2 - side * np.radians(float(rng.uniform(42, 58))) * (i < 2 * pairs)
        c, s = np.cos(turn), np.sin(turn)
        at = np.array([np.interp(share, t, x), np.interp(share, t, z)])
        leaves.append(sheet_of(shape @ np.array([[c, s], [-s, c]]) + at, front, 1))
    return {
        "canvas": canvas_of(inside, front),
        "stem": sheet_of(stem, front, 0),
        "leaf": joined(leaves),
    }


def shapes(inside: Rectangle, front: float, rng: np.random.Generator) -> Parts:
    """An abstract print: a few large soft shapes, an arch, a line."""
    left, right, low, high = inside
    wide, tall = right - left, high - low
    fields = []
    for k in range(int(rng.integers(3, 5))):
        a, b = rng.uniform(0.28, 0.5, 2) * [wide, tall]
        blob = superellipse(float(a), float(b), float(rng.uniform(1.8, 3.5)), 26)
        room = np.array([wide - a, tall - b]) * 0.44
        at = np.array([0.5 * (left + right), 0.5 * (low + high)]) + rng.uniform(-1.0, 1.0, 2) * room
        fields.append(sheet_of(blob + at, front, k))
    t = np.linspace(0.0, np.pi, 13)
    r, x = float(rng.uniform(0.14, 0.2)) * wide, left + float(rng.uniform(0.3, 0.7)) * wide
    z, thick = low + float(rng.uniform(0.1, 0.3)) * tall, 0.035 * wide
    around = np.stack([np.cos(t), np.sin(t)], axis=1)
    arch = np.concatenate([r * around, ((r - thick) * around)[::-1]]) + np.array([x, z])
    return {
        "canvas": canvas_of(inside, front),
        **numbered("field", fields),
        "accent": sheet_of(arch, front, 5),
    }


def any_of(*painters: Painter) -> Painter:
    """One of several, drawn for each picture."""

    def paint(inside: Rectangle, front: float, rng: np.random.Generator) -> Parts:
        return painters[int(rng.integers(len(painters)))](inside, front, rng)

    return paint
