"""Plain shapes for what scanners recognise and the library has no category for.

They fill the captured box with something that reads as the right thing from across the room.
"""

from typing import Final

import numpy as np

from openrooms_usd.geometry.solids import cushion, cylinder, lathe
from openrooms_usd.library.furniture import cabinet
from openrooms_usd.library.furniture.joinery import (
    FRONT,
    Build,
    CategorySpec,
    Parts,
    Size,
    Style,
    board,
    corners,
    numbered,
    square_leg,
)


def bed(size: Size, rng: np.random.Generator) -> Parts:
    """A frame with a headboard, a mattress, pillows and a cover; its head is at the back."""
    width, depth, height = size
    level = min(0.5, 0.8 * height)
    foot, thick = 0.12, min(0.22, 0.5 * level)
    half, front, back = 0.5 * width, -0.5 * depth, 0.5 * depth
    inner = back - 0.05
    frame = [
        board((-half, front, foot), (half, inner, level - thick + 0.03), 0.01),
        board((-half, inner, foot), (half, back, height), 0.012),
    ]
    mattress = cushion((width - 0.04, inner - front - 0.03, thick), radius=0.05,
                       crown=(0.004, 0.004, 0.012))  # fmt: skip
    count = 1 if width < 1.2 else 2
    pitch = (width - 0.12) / count
    pillow = cushion((pitch - 0.06, 0.42, 0.14), radius=0.05, crown=(0.01, 0.01, 0.045))
    cover = cushion(
        (width, 0.66 * (inner - front), 0.05), radius=0.022, crown=(0.002, 0.004, 0.008)
    )
    drape = level - 0.5 * thick
    return {
        **numbered("frame", frame),
        **numbered("leg", [square_leg(0.05, 0.04, foot + 0.01).moved((*p, 0.0))
                           for p in corners(half - 0.08, 0.5 * depth - 0.08)]),
        "mattress": mattress.moved((0.0, 0.5 * (front + inner) - 0.01, drape)),
        **numbered("pillow", [
            pillow.moved((-0.5 * width + 0.06 + (i + 0.5) * pitch, inner - 0.24, level + 0.06))
            for i in range(count)
        ]),
        "blanket": cover.moved((0.0, front + 0.35 * (inner - front), level + 0.008)),
    }  # fmt: skip


def _body(size: Size, rows: tuple[float, ...]) -> Parts:
    """A rounded body with doors stacked over its front and a bar handle on each."""
    width, depth, height = size
    front = -0.5 * depth + cabinet.HANDLE + 0.025
    low = min(0.06, 0.1 * height)
    edges = low + (height - low) * np.concatenate([[0.0], np.cumsum(rows) / np.sum(rows)])
    doors, handles = [], []
    for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        doors.append(
            board((-0.5 * width, front - 0.025, a + 0.003), (0.5 * width, front - 0.001, b - 0.003),
                  0.006)
        )  # fmt: skip
        bar = cabinet.bar(min(0.5 * width, 0.4))
        handles.append(bar.moved((0.0, front - 0.025, b - min(0.06, 0.3 * (b - a)))))
    body = board((-0.5 * width, front, low), (0.5 * width, 0.5 * depth, height), 0.006)
    plinth = board((-0.48 * width, front + 0.04, 0.0), (0.48 * width, 0.48 * depth, low))
    return {"frame": body, "base": plinth, **numbered("door", doors), **numbered("handle", handles)}


def fridge(size: Size, rng: np.random.Generator) -> Parts:
    """Two doors above each other, or one where it is low."""
    return _body(size, (0.62, 0.38) if size[2] > 1.2 else (1.0,))


def oven(size: Size, rng: np.random.Generator) -> Parts:
    """A door below a panel."""
    return _body(size, (0.8, 0.2))


def washer(size: Size, rng: np.random.Generator) -> Parts:
    """A box with a round door."""
    width, depth, height = size
    front = -0.5 * depth + 0.03
    radius = min(0.19, 0.36 * width, 0.3 * height)
    ring = lathe([(radius, 0.0), (radius - 0.004, 0.026), (radius - 0.04, 0.03),
                  (radius - 0.045, 0.0)], segments=40)  # fmt: skip
    middle = (0.0, front, 0.5 * height)
    return {
        "frame": board((-0.5 * width, front, 0.0), (0.5 * width, 0.5 * depth, height), 0.01),
        "door": ring.transformed(FRONT).moved(middle),
        "glass": cylinder(radius - 0.045, 0.012, bevel=0.003, segments=32).transformed(FRONT)
        .moved(middle),
    }  # fmt: skip


def basin(size: Size, rng: np.random.Generator) -> Parts:
    """A tub or a sink: four thick rounded walls and a bottom."""
    width, depth, height = size
    t = min(0.07, 0.18 * min(width, depth))
    x, y, edge = 0.5 * width, 0.5 * depth, min(0.02, 0.3 * t)
    walls = [
        board((-x, -y, 0.0), (x, t - y, height), edge),
        board((-x, y - t, 0.0), (x, y, height), edge),
        board((-x, -y, 0.0), (t - x, y, height), edge),
        board((x - t, -y, 0.0), (x, y, height), edge),
    ]
    bottom = board((0.5 * t - x, 0.5 * t - y, 0.0), (x - 0.5 * t, y - 0.5 * t, 0.3 * height), edge)
    return {**numbered("frame", walls), "basin": bottom}


def toilet(size: Size, rng: np.random.Generator) -> Parts:
    """An oval bowl with a lid, and a cistern behind it."""
    width, depth, height = size
    level = min(0.41, 0.62 * height)
    back = 0.3 * depth
    long = 0.5 * (depth - back) + 0.04
    foot, bulge = 0.55, 0.86
    profile = [(0.0, 0.0), (foot, 0.0), (0.9 * foot, 0.25 * level), (bulge, 0.75 * level),
               (1.0, level - 0.03), (1.0, level), (0.0, level)]  # fmt: skip
    oval = np.diag([0.46 * width, long, 1.0])
    y = -0.5 * depth + long
    lid = lathe([(0.0, 0.0), (1.0, 0.0), (1.0, 0.012), (0.94, 0.025), (0.0, 0.03)], segments=40)
    return {
        "base": lathe(profile, segments=40, crease=50.0).transformed(oval).moved((0.0, y, 0.0)),
        "seat": lid.transformed(oval).moved((0.0, y, level + 0.002)),
        "cistern": board((-0.5 * width, 0.5 * depth - 0.6 * back, level - 0.02),
                         (0.5 * width, 0.5 * depth, height), 0.025),
    }  # fmt: skip


def screen(size: Size, rng: np.random.Generator) -> Parts:
    """A flat screen in a slim frame."""
    width, depth, height = size
    thick = min(0.04, 0.6 * depth)
    back = -0.5 * depth + thick
    return {
        "frame": board((-0.5 * width, 0.004 - 0.5 * depth, 0.0), (0.5 * width, back, height),
                       0.004),
        "screen": board((0.012 - 0.5 * width, -0.5 * depth, 0.018),
                        (0.5 * width - 0.012, -0.5 * depth + 0.01, height - 0.012), 0.002),
        "base": board((-0.2 * width, back - 0.01, 0.3 * height),
                      (0.2 * width, 0.5 * depth, 0.7 * height), 0.004),
    }  # fmt: skip


def stairs(size: Size, rng: np.random.Generator) -> Parts:
    """Steps that rise towards the back."""
    width, depth, height = size
    count = max(1, round(height / 0.175))
    run, rise = depth / count, height / count
    steps = [
        board((-0.5 * width, -0.5 * depth + i * run, 0.0),
              (0.5 * width, -0.5 * depth + (i + 1) * run, (i + 1) * rise), 0.004)
        for i in range(count)
    ]  # fmt: skip
    return numbered("step", steps)


def fireplace(size: Size, rng: np.random.Generator) -> Parts:
    """Two pillars, a lintel and a mantel shelf around a dark hollow."""
    width, depth, height = size
    x, y, pillar, shelf = 0.5 * width, 0.5 * depth, 0.2 * width, min(0.05, 0.1 * height)
    front = -y + 0.04
    opening = 0.68 * height
    return {
        **numbered("frame", [
            board((0.02 - x, front, 0.0), (pillar - x, y, height - shelf), 0.005),
            board((x - pillar, front, 0.0), (x - 0.02, y, height - shelf), 0.005),
            board((pillar - x, front, opening), (x - pillar, y, height - shelf), 0.005),
            board((pillar - x, y - 0.03, 0.0), (x - pillar, y, opening), 0.002),
        ]),
        "shelf": board((-x, -y, height - shelf), (x, y, height), 0.006),
    }  # fmt: skip


def _spec(build: Build, size: Size, least: Size, description: str) -> CategorySpec:
    return CategorySpec(size, least, (4.0, 4.0, 4.0), {"plain": Style(build)}, description)


STAND_INS: Final = {
    "basin": _spec(basin, (1.7, 0.75, 0.55), (0.3, 0.2, 0.08), "a tub or a sink"),
    "bed": _spec(bed, (1.6, 2.05, 1.0), (0.7, 1.2, 0.35), "a bed with its head at the back"),
    "fireplace": _spec(fireplace, (1.3, 0.4, 1.1), (0.5, 0.2, 0.5), "a fireplace"),
    "fridge": _spec(fridge, (0.6, 0.65, 1.85), (0.3, 0.2, 0.4), "a refrigerator or dishwasher"),
    "oven": _spec(oven, (0.6, 0.6, 0.85), (0.3, 0.2, 0.4), "an oven or a stove"),
    "screen": _spec(screen, (1.2, 0.1, 0.7), (0.3, 0.06, 0.2), "a flat screen"),
    "stairs": _spec(stairs, (1.0, 2.5, 2.2), (0.3, 0.3, 0.2), "stairs up to the back"),
    "toilet": _spec(toilet, (0.38, 0.66, 0.8), (0.3, 0.4, 0.5), "a toilet"),
    "washer": _spec(washer, (0.6, 0.6, 0.85), (0.3, 0.2, 0.4), "a washing machine or dryer"),
}
