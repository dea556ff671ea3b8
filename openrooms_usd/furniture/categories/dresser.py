"""Chests of drawers for bedrooms: wide on legs, tall and narrow, with a door, with a mirror."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import STORAGE_ROWS
from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.carcass import Carcass, closed, plinth_height
from openrooms_usd.furniture.joinery.cells import BOARD, columns, rows
from openrooms_usd.furniture.joinery.fronts import doors, drawer, drawers, drawn_look, leaf
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import STORAGE
from openrooms_usd.geometry.lofts import ring, rounded_rectangle
from openrooms_usd.geometry.sweeps import tube

BEHIND: Final = 0.03


def _column(cabinet: Carcass, x: float) -> None:
    cabinet.divider(x, cabinet.low + BOARD, cabinet.high - BOARD)


def double(size: Size, rng: np.random.Generator) -> Furniture:
    """A wide chest on legs: small drawers above, two columns of deep ones below."""
    cabinet = closed(size, min(0.15, 0.2 * size[2]))
    cabinet.legs()
    _chest(cabinet, rng)
    return cabinet.made.furniture()


def _chest(cabinet: Carcass, rng: np.random.Generator) -> None:
    look, back = drawn_look(rng, 0.5), cabinet.back - BEHIND
    small = float(rng.uniform(0.14, 0.17))
    left, right, low, high = cabinet.overlay
    count = max(1, round((right - left) / 0.6))
    lower, upper = rows((left, right, low, high), [high - low - small, small])
    for i, column in enumerate(columns(lower, count)):
        if i:
            _column(cabinet, column[0])
        drawers(cabinet.made, column, cabinet.face, back, look, 0.23)
    for column in columns(upper, count):
        drawer(cabinet.made, column, cabinet.face, back, look)


def tallboy(size: Size, rng: np.random.Generator) -> Furniture:
    """One column of drawers on a plinth, the top overhanging."""
    width, depth, height = size
    cabinet = closed((width - 0.03, depth, height), plinth_height(height), high=height - 0.02)
    cabinet.plinth()
    drawers(
        cabinet.made,
        cabinet.overlay,
        cabinet.face,
        cabinet.back - BEHIND,
        drawn_look(rng, 0.5),
        0.21,
    )
    front = cabinet.front - BOARD - 0.012
    top = board((-0.5 * width, front, height - 0.022), (0.5 * width, 0.5 * depth, height), 0.006)
    cabinet.made.add("tabletop", top)
    return cabinet.made.furniture()


def combined(size: Size, rng: np.random.Generator) -> Furniture:
    """A column of drawers beside a door with shelves behind it."""
    cabinet = closed(size, plinth_height(size[2]))
    cabinet.plinth()
    look = drawn_look(rng, 0.5)
    left, right, low, high = cabinet.overlay
    share = float(rng.uniform(0.52, 0.62))
    middle = left + share * (right - left)
    _column(cabinet, middle)
    drawers(cabinet.made, (left, middle, low, high), cabinet.face, cabinet.back - BEHIND, look)
    doors(cabinet.made, (middle, right, low, high), cabinet.face, look, 0.6)
    inside = cabinet.inside
    cabinet.shelves((middle + 0.5 * BOARD, inside[1], inside[2], inside[3]), setback=0.02)
    return cabinet.made.furniture()


def mirrored(size: Size, rng: np.random.Generator) -> Furniture:
    """A low chest with a mirror standing on its back edge."""
    width, depth, height = size
    top = min(0.85, 0.58 * height)
    cabinet = closed((width, depth, top), min(0.12, 0.2 * top))
    cabinet.legs()
    _chest(cabinet, rng)
    wide, tall = 0.8 * width, height - top - 0.015
    y, corner = cabinet.back - 0.03, float(rng.choice([0.02, 0.12, 0.24]))
    corner = min(corner, 0.45 * tall)
    outline = rounded_rectangle(wide - 0.03, tall - 0.03, corner, 6)
    frame = tube(ring(outline, 0.0)[:, [0, 2, 1]], 0.015, segments=10, closed=True)
    glass = leaf(wide - 0.028, tall - 0.028, 0.006, corner=corner)
    cabinet.made.add("frame", frame.moved((0.0, y, top + 0.015 + 0.5 * tall)))
    cabinet.made.add("mirror", glass.moved((0.0, y + 0.003, top + 0.029)))
    stand = max(0.04, min(0.3 * wide, 0.5 * wide - 0.02 - corner))
    for x in (-stand, stand):
        cabinet.made.add("frame", tube([(x, y, top - 0.01), (x, y, top + 0.02)], 0.012))
    return cabinet.made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a chest of drawers for a bedroom",
    size=(1.1, 0.48, 0.85),
    min_size=(0.35, 0.3, 0.45),
    max_size=(2.6, 0.8, 2.2),
    styles={
        "double": Style(double, lambda size: size[0] > 0.7 and size[2] < 1.15),
        "tallboy": Style(tallboy, lambda size: size[0] < 1.0, (0.6, 0.48, 1.2)),
        "combined": Style(combined, lambda size: size[0] > 0.75 and size[2] < 1.3),
        "mirrored": Style(
            mirrored, lambda size: size[2] > 1.2 and size[0] > 0.7, (1.1, 0.48, 1.65)
        ),
    },
    mass_range=(35, 95),
    words="chest_of_drawers commode drawers drawer bureau",
    classes=Classes("cabinet", "dresser", "chest_of_drawers"),
    schemes=STORAGE,
    construction=STORAGE_ROWS,
    offers_surfaces=("dresser_top", "drawer", "cupboard"),
    view_importance=0.8,
)
