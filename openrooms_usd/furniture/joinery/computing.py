"""Laptops and keyboards; the keys of a row are one mesh, since many small prims cost more."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.boards import SIDE, board, profiled
from openrooms_usd.furniture.joinery.pieces import Furniture, Joint, Parts, Size, numbered
from openrooms_usd.furniture.joinery.posing import tapered, turned
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box
from openrooms_usd.geometry.sweeps import tube

Row = Sequence[float]
# Widths of keys, in units of a letter's; ANSI layout, the rows from the back to the front.
_LETTERS: Final[tuple[Row, ...]] = (
    (15.0 / 13.0,) * 13,
    (*(1.0,) * 13, 2.0),
    (1.5, *(1.0,) * 12, 1.5),
    (1.75, *(1.0,) * 11, 2.25),
    (2.25, *(1.0,) * 10, 2.75),
    (1.25, 1.25, 1.25, 6.25, 1.25, 1.25, 1.25, 1.25),
)
_NUMBERS: Final[tuple[Row, ...]] = ((1.0,) * 4,) * 5 + ((2.0, 1.0, 1.0),)
# A left and a right half, for hands apart.
_LEFT: Final[tuple[Row, ...]] = (
    (1.0,) * 6,
    (1.0,) * 6,
    (1.0,) * 6,
    (1.0,) * 6,
    (1.0,) * 3 + (3.0,),
)
_RIGHT: Final = tuple(tuple(reversed(row)) for row in _LEFT)


def _keys(
    rows: Sequence[Row], low: tuple[float, float], high: tuple[float, float], rise: float
) -> list[Mesh]:
    """Keys that fill a rectangle (x, y), metres; one mesh a row, from the front to the back."""
    pitch = (high[1] - low[1]) / len(rows)
    meshes = []
    for number, row in enumerate(reversed(rows)):
        unit = (high[0] - low[0]) / sum(row)
        edges = low[0] + unit * np.concatenate([[0.0], np.cumsum(row)])
        y = low[1] + (number + 0.5) * pitch
        gap = 0.1 * pitch
        caps = [
            tapered(
                box((b - a - gap, pitch - gap, rise), (0.5 * (a + b), y, 0.5 * rise)),
                "z",
                (0.86, 0.86),
                20.0,
            )
            for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
        ]
        meshes.append(joined(caps))
    return meshes


def _opening(size: Size, thickness: float) -> tuple[float, float]:
    """The depth of base and lid, and how far the lid leans back (degrees), that fill a box.

    depth = D (1 + sin a) and height - thickness = D cos a, so tan(45 - a / 2) is their ratio.
    """
    _, depth, height = size
    lean = 90.0 - 2.0 * np.degrees(np.arctan2(height - thickness, depth))
    return float(depth / (1.0 + max(0.0, np.sin(np.radians(lean))))), float(lean)


def laptop_slim(size: Size, rng: np.random.Generator) -> Furniture:
    """A thin metal slab with a lid on one long hinge."""
    return _clamshell(size, 0.014, 0.0055, 0.006, float(rng.uniform(0.36, 0.46)), False)


def laptop_classic(size: Size, rng: np.random.Generator) -> Furniture:
    """A thick one: two separate hinges, a broad frame around the screen, a pad with buttons."""
    return _clamshell(size, 0.026, 0.009, 0.016, float(rng.uniform(0.26, 0.32)), True)


def _clamshell(
    size: Size, thickness: float, lid: float, bezel: float, pad: float, buttons: bool
) -> Furniture:
    width = size[0]
    half = 0.5 * width
    long, lean = _opening(size, thickness)
    hinge = -0.5 * size[1] + long
    front = hinge - long
    top = thickness - 0.0015
    keys = _keys(
        _LETTERS, (-0.44 * width, front + 0.42 * long), (0.44 * width, hinge - 0.08 * long), 0.0022
    )
    touch = [
        board(
            (-0.5 * pad * width, front + 0.07 * long, top),
            (0.5 * pad * width, front + 0.36 * long, thickness + 0.0002),
            0.0003,
        )
    ]
    if buttons:
        touch = [
            board(
                (a * pad * width, front + y0 * long, top),
                (b * pad * width, front + y1 * long, thickness + rise),
                0.0003,
            )
            for a, b, y0, y1, rise in (
                (-0.5, 0.5, 0.16, 0.37, 0.0002),
                (-0.5, -0.02, 0.09, 0.15, 0.001),
                (0.02, 0.5, 0.09, 0.15, 0.001),
            )
        ]
    closed = {
        "lid": board((-half, front, thickness), (half, hinge, thickness + lid)),
        "screen": board(
            (-half + bezel, front + bezel, thickness - 0.0004),
            (half - bezel, hinge - 1.8 * bezel, thickness + 0.002),
            0.0003,
        ),
    }
    pivot = (0.0, hinge, thickness)
    opened = {name: turned(m, "x", -90.0 - lean, pivot) for name, m in closed.items()}
    spans = [(-0.8, -0.55), (0.55, 0.8)] if buttons else [(-0.8, 0.8)]
    barrels = [
        tube([(a * half, hinge - 0.003, top), (b * half, hinge - 0.003, top)], 0.0035, segments=8)
        for a, b in spans
    ]
    parts: Parts = {
        "base": board((-half, front, 0.0), (half, hinge, thickness), 0.003),
        "touchpad": joined(touch),
        "hinge": joined(barrels),
        **numbered("key", [row.moved((0.0, 0.0, top)) for row in keys]),
        **opened,
    }
    limits = (-min(45.0, 88.0 - lean), 89.0 + lean)
    return Furniture(
        parts, (Joint("lid_0", "hinge", tuple(opened), pivot, (1.0, 0.0, 0.0), limits),)
    )


def laptop_tablet(size: Size, rng: np.random.Generator) -> Furniture:
    """A tablet that leans on a kickstand behind a thin keyboard."""
    width, depth, height = size
    half, slab, cover = 0.5 * width, 0.0085, 0.005
    lean = float(rng.uniform(16.0, 24.0))
    tall = (height - slab * np.sin(np.radians(lean))) / np.cos(np.radians(lean))
    board_depth = min(0.66 * tall, 0.6 * depth)
    foot = -0.5 * depth + board_depth
    shell = board((-half, 0.0, 0.0), (half, slab, tall))
    glass = board((-half + 0.008, -0.0005, 0.008), (half - 0.008, 0.003, tall - 0.008), 0.0004)
    # Rests with its lower edge on the table, the stand's foot at the back of the box.
    upper = 0.46 * tall
    c, s = np.cos(np.radians(lean)), np.sin(np.radians(lean))
    head = (foot + upper * s + slab * c, upper * c)
    heel = (0.5 * depth - 0.002, 0.001)
    rim = [(-half + 0.02, *head), (-half + 0.02, *heel), (half - 0.02, *heel), (half - 0.02, *head)]
    keys = _keys(
        _LETTERS,
        (-0.46 * width, foot - 0.92 * board_depth + 0.36 * board_depth),
        (0.46 * width, foot - 0.08 * board_depth),
        0.0016,
    )
    leaning = {"frame": shell, "screen": glass}
    return Furniture(
        {
            "base": board((-half, -0.5 * depth, 0.0), (half, foot, cover), 0.0015),
            "touchpad": board(
                (-0.2 * width, -0.5 * depth + 0.05 * board_depth, cover - 0.001),
                (0.2 * width, -0.5 * depth + 0.38 * board_depth, cover + 0.0002),
                0.0003,
            ),
            **numbered("key", [row.moved((0.0, 0.0, cover - 0.0006)) for row in keys]),
            **{
                name: turned(mesh, "x", -lean).moved((0.0, foot, slab * s))
                for name, mesh in leaning.items()
            },
            "stand": tube(rim, 0.002, segments=8),
        }
    )


def keyboard_full(size: Size, rng: np.random.Generator) -> Parts:
    """A wedge with letters, arrows and a block of numbers."""
    width, depth, height = size
    half, front, rise = 0.5 * width, -0.5 * depth, 0.33 * height
    slope = float(np.degrees(np.arctan2(0.3 * height, depth)))
    top = 0.42 * height
    outline = [(front, 0.0), (0.5 * depth, 0.0), (0.5 * depth, 0.72 * height), (front, top)]
    unit = width * 0.96 / 22.5
    left = -0.48 * width
    blocks = ((_LETTERS, 0.0, 15.0), (((1.0,) * 3,) * 6, 15.4, 18.0), (_NUMBERS, 18.5, 22.5))
    margin = 0.07 * depth
    rows = [
        _keys(table, (left + a * unit, front + margin), (left + b * unit, -front - margin), rise)
        for table, a, b in blocks
    ]
    whole = [joined(list(row)) for row in zip(*rows, strict=True)]
    keys = [
        turned(row.moved((0.0, 0.0, top - 0.0005)), "x", slope, (0.0, front, top)) for row in whole
    ]
    return {"frame": profiled(outline, 2.0 * half, SIDE, 0.002), **numbered("key", keys)}


def keyboard_slim(size: Size, rng: np.random.Generator) -> Parts:
    """A thin slab with letters alone and a raised back edge."""
    width, depth, height = size
    half, plate = 0.5 * width, 0.45 * height
    rail = float(rng.uniform(0.07, 0.1)) * depth
    keys = _keys(
        _LETTERS,
        (-0.485 * width, -0.46 * depth),
        (0.485 * width, 0.48 * depth - rail),
        0.4 * height,
    )
    back = board((-half, 0.5 * depth - rail, 0.0), (half, 0.5 * depth, height), 0.3 * rail)
    return {
        "frame": joined([board((-half, -0.5 * depth, 0.0), (half, 0.5 * depth, plate)), back]),
        **numbered("key", [row.moved((0.0, 0.0, plate - 0.0004)) for row in keys]),
    }


def keyboard_split(size: Size, rng: np.random.Generator) -> Parts:
    """Two halves, turned to the hands and joined by a cable."""
    width, depth, height = size
    angle = float(rng.uniform(5.0, 9.0))
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    wide = 0.41 * width
    deep = (depth - wide * s) / c
    plate = 0.6 * height
    parts: dict[str, list[Mesh]] = {"frame": [], "key": []}
    reach = 0.5 * (wide * c + deep * s)
    for side, table in ((-1.0, _LEFT), (1.0, _RIGHT)):
        shell = board((-0.5 * wide, -0.5 * deep, 0.0), (0.5 * wide, 0.5 * deep, plate), 0.003)
        keys = _keys(table, (-0.46 * wide, -0.45 * deep), (0.46 * wide, 0.45 * deep), 0.4 * height)
        place = (side * (0.5 * width - reach), 0.0, 0.0)
        parts["frame"].append(turned(shell, "z", -side * angle).moved(place))
        parts["key"] += [
            turned(row, "z", -side * angle).moved(np.add(place, (0.0, 0.0, plate))) for row in keys
        ]
    inner = 0.5 * width - 2.0 * reach + 0.02
    y = 0.3 * depth
    bow = [
        (x, y - 0.1 * depth * (1.0 - (x / inner) ** 2), 0.4 * plate)
        for x in np.linspace(-inner, inner, 9).tolist()
    ]
    cable = tube(bow, 0.0016, segments=6)
    return {**numbered("frame", parts["frame"]), **numbered("key", parts["key"]), "cable": cable}
