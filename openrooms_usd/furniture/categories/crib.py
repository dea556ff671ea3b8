"""Cribs: a small bed between barred sides."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import filled, row, solid
from openrooms_usd.furniture.joinery.boards import board, corners
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import cushion, cylinder

_POST_M, _RAIL_M, _BAR_PITCH_M = 0.045, 0.04, 0.07


def barred(size: Size, rng: np.random.Generator) -> Parts:
    """Round bars all around, a mattress half way up."""
    width, depth, height = size
    x, y, t = 0.5 * width, 0.5 * depth, _POST_M
    posts = [
        board((a - 0.5 * t, b - 0.5 * t, 0.0), (a + 0.5 * t, b + 0.5 * t, height), 0.006)
        for a, b in corners(x - 0.5 * t, y - 0.5 * t)
    ]
    low, high = 0.28, height - 0.03
    rails, bars = [], []
    for z in (low, high - _RAIL_M):
        for s in (-1.0, 1.0):
            b = s * (y - 0.5 * t)
            rails.append(board((t - x, b - 0.012, z), (x - t, b + 0.012, z + _RAIL_M)))
            a = s * (x - 0.5 * t)
            rails.append(board((a - 0.012, t - y, z), (a + 0.012, y - t, z + _RAIL_M)))
    bar = cylinder(0.007, high - low - _RAIL_M - 0.01, segments=8, base=(0.0, 0.0, low + 0.03))
    for s in (-1.0, 1.0):
        along = np.arange(t + 0.05 - x, x - t - 0.03, _BAR_PITCH_M)
        bars += [bar.moved((float(a), s * (y - 0.5 * t), 0.0)) for a in along]
        across = np.arange(t + 0.05 - y, y - t - 0.03, _BAR_PITCH_M)
        bars += [bar.moved((s * (x - 0.5 * t), float(b), 0.0)) for b in across]
    base = board((0.02 - x, 0.035 - y, low + 0.02), (x - 0.02, y - 0.035, low + 0.035))
    soft = cushion(
        (width - 0.07, depth - 0.08, 0.11),
        radius=0.03,
        crown=(0.003, 0.003, 0.01),
        center=(0.0, 0.0, low + 0.09),
    )
    return {
        **numbered("leg", posts),
        **numbered("rail", rails),
        "slat": joined(bars),
        "frame": base,
        "mattress": soft,
    }


CATEGORY: Final = BuiltCategory(
    description="a bed with barred sides for a small child",
    size=(1.28, 0.68, 0.9),
    min_size=(0.7, 0.4, 0.6),
    max_size=(1.6, 0.95, 1.25),
    styles={"barred": Style(barred)},
    size_variation=STANDARD,
    mass_range=(14, 40),
    words="baby_bed baby_crib cot cradle bassinet infant_bed",
    classes=Classes("bed", "bed", "cradle", "bed"),
    schemes=(scheme("wood", wood="slat", weight=2.0), scheme("white")),
    construction=(
        row("leg rail slat", solid(), "common", "wood"),
        row("leg rail slat frame", filled(600), "common"),
    ),
    collision_softness=0.02,
)
