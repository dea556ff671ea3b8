"""Bookshelves with their books: a case, a grid of cubes, a ladder frame, a case over doors."""

from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import STORAGE_ROWS
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.books import Book, Shelf, bound
from openrooms_usd.furniture.joinery.carcass import BACK, Carcass, plinth_height
from openrooms_usd.furniture.joinery.cells import BOARD, HANDLE, SEAT, Cell
from openrooms_usd.furniture.joinery.fronts import doors, drawn_look
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.joinery.posing import seated
from openrooms_usd.furniture.record import MADE_TO_MEASURE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import STORAGE
from openrooms_usd.geometry.sweeps import tube


def _stock(
    made: Assembly, cells: list[Cell], front: float, depth: float, rng: np.random.Generator
) -> Furniture:
    """Put books into compartments that begin at ``front`` and are ``depth`` deep."""
    books: list[Book] = []
    fullness = float(rng.uniform(0.72, 0.92))
    for left, right, low, high in cells:
        size = (right - left, depth, high - low)
        if size[2] > 0.15 and depth > 0.1 and rng.uniform() < 0.94:
            books += Shelf((left, front, low), size).filled(rng, fullness)
    covers, pages, prints = bound(books)
    made.add("book", *covers)
    made.add("pages", *pages)
    made.add("spine_print", *prints)
    return made.furniture()


def case(size: Size, rng: np.random.Generator) -> Furniture:
    """Tall sides, a back, a plinth; one bay for every 80 cm."""
    width, depth, height = size
    frame = Carcass(width, -0.5 * depth, 0.5 * depth, plinth_height(height), height).boards()
    frame.plinth()
    pitch = float(rng.uniform(0.31, 0.37))
    cells = [
        cell
        for bay in frame.bays(max(1, round(width / 0.85)))
        for cell in frame.shelves(bay, pitch)
    ]
    return _stock(frame.made, cells, frame.front + 0.006, depth - BACK - 0.006, rng)


def cubes(size: Size, rng: np.random.Generator) -> Furniture:
    """A grid of square compartments with thick outer boards, open to both sides."""
    width, depth, height = size
    made, outer, inner = Assembly(), 0.036, 0.016
    x, y = 0.5 * width, 0.5 * depth
    for side in (-x, x - outer):
        made.board("frame", (side, -y, 0.0), (side + outer, y, height))
    for z in (0.0, height - outer):
        made.board("frame", (outer - x, -y, z), (x - outer, y, z + outer))
    across = max(1, round((width - 2 * outer) / 0.35))
    up = max(1, round((height - 2 * outer) / 0.35))
    xs = np.linspace(outer - x, x - outer, across + 1)
    zs = np.linspace(outer, height - outer, up + 1)
    half = 0.5 * inner
    for z in zs[1:-1]:
        made.board("shelf", (outer - x, 0.003 - y, z - half), (x - outer, y - 0.003, z + half))
    for a in xs[1:-1]:
        low, high = (a - half, 0.004 - y, outer), (a + half, y - 0.004, height - outer)
        made.board("frame", low, high)
    cells = [
        (float(a) + half, float(b) - half, float(low) + (half if i else 0.0), float(high) - half)
        for i, (low, high) in enumerate(pairwise(zs))
        for a, b in pairwise(xs)
        if rng.uniform() < 0.75
    ]
    return _stock(made, cells, 0.004 - y, depth - 0.008, rng)


def ladder(size: Size, rng: np.random.Generator) -> Furniture:
    """Two ladders of steel tube that lean back, boards between them: deeper ones below."""
    width, depth, height = size
    made, r = Assembly(), 0.011
    x, y = 0.5 * width - r, 0.5 * depth - r
    lean = min(0.45 * depth, 0.16)
    count = max(2, round(height / 0.38))
    levels = np.linspace(0.09, height - 0.26, count)
    for side in (-x, x):
        front = [(side, -y, 0.0), (side, lean - y, height)]
        made.add("tube", seated(tube(front, r)), tube([(side, y, 0.0), (side, y, height)], r))
    cells: list[Cell] = []
    for level, above in zip(levels, [*levels[1:], height + 0.04], strict=True):
        edge = lean * float(level) / height - y
        for side in (-x, x):
            made.add("tube", tube([(side, edge, level), (side, y, level)], 0.8 * r))
        low, high = (-x - 0.3 * r, edge, level + 0.006), (x + 0.3 * r, y + 0.3 * r, level + 0.026)
        made.board("shelf", low, high)
        cells.append((r - x, x - r, float(level) + 0.026, float(above) - 0.03))
    # Without a back, books stay clear of the front tubes at the top of the lowest board.
    edge = lean * float(levels[-1] + 0.3) / height - y + 0.02
    return _stock(made, cells, edge, y - edge, rng)


def over_doors(size: Size, rng: np.random.Generator) -> Furniture:
    """Open shelves above, a deeper cabinet with doors below."""
    width, depth, height = size
    waist = min(0.78, 0.42 * height)
    front = -0.5 * depth + HANDLE + BOARD + SEAT
    base = Carcass(width, front, 0.5 * depth, plinth_height(height), waist).boards()
    base.plinth()
    doors(base.made, base.overlay, base.face, drawn_look(rng, 0.7))
    base.shelves(base.inside, 0.4, 0.02)
    top = Carcass(width, front + 0.15 * depth, 0.5 * depth, waist, height, base.made).boards()
    cells = [cell for bay in top.bays(max(1, round(width / 0.85))) for cell in top.shelves(bay)]
    return _stock(top.made, cells, top.front + 0.006, 0.5 * depth - BACK - top.front - 0.006, rng)


CATEGORY: Final = BuiltCategory(
    description="shelves with books",
    size=(0.8, 0.3, 1.9),
    min_size=(0.25, 0.16, 0.35),
    max_size=(4.0, 0.7, 3.2),
    styles={
        "case": Style(case),
        "cubes": Style(cubes, lambda size: size[1] > 0.25, (1.12, 0.36, 1.46)),
        "ladder": Style(ladder, lambda size: size[0] < 1.3 and size[2] > 1.2, (0.8, 0.38, 1.8)),
        "over_doors": Style(
            over_doors, lambda size: size[2] > 1.5 and size[1] > 0.3, (0.9, 0.4, 2.0)
        ),
    },
    size_variation=MADE_TO_MEASURE,
    one_variant_per_room=True,
    mass_range=(40, 140),
    words="bookcase bookshelves book_shelf shelf shelves shelving book_rack kitchen_rack "
    "magazine_rack storage_rack shelve",
    classes=Classes("bookshelf", "bookshelf", "bookcase"),
    synsets=("02871439",),
    schemes=STORAGE,
    construction=STORAGE_ROWS,
    offers_surfaces=("cabinet_top", "shelf", "low_shelf", "cupboard"),
    view_importance=0.8,
)
