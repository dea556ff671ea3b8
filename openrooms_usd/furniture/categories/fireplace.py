"""Fireplaces: a mantelpiece, a chimney breast with a low opening, and an iron stove."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import board, corners, square_leg
from openrooms_usd.furniture.joinery.pieces import Furniture, Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.sweeps import extrude, tube


def _logs(
    width: float, span: tuple[float, float], z: float, rng: np.random.Generator
) -> list[Mesh]:
    """A pile of three or four logs; none where it is too shallow between front and back."""
    y, long = 0.5 * (span[0] + span[1]) + 0.02, min(0.45, 0.8 * width)
    made = []
    for i in range(int(rng.integers(3, 5)) if span[1] - span[0] > 0.24 else 0):
        r = float(rng.uniform(0.028, 0.04))
        turn = float(rng.uniform(-0.35, 0.35))
        c, s = 0.5 * long * np.cos(turn), 0.25 * long * np.sin(turn)
        level = z + r + 0.05 * (i // 2)
        x, offset = float(rng.uniform(-0.03, 0.03)), (i % 2 - 0.5) * 0.09
        path = [
            (x - c, y + offset - s, level),
            (x, y + offset, level + 0.004),
            (x + c, y + offset + s, level),
        ]
        made.append(tube(path, r, segments=10))
    return made


def _firebox(width: float, front: float, back: float, low: float, high: float) -> list[Mesh]:
    """The dark lining of a hearth: back, top, floor and slanting cheeks."""
    t, half, taper = 0.02, 0.5 * width, 0.2 * width
    cheek = np.array([(half, front), (half + t, front), (half + t, back), (half - taper, back)])
    return [
        board((-half, back - t, low), (half, back, high), 0.001),
        board((-half, front, high - t), (half, back - t, high), 0.001),
        board((-half, front, low), (half, back - t, low + t), 0.001),
        extrude(cheek, high - low, base=low),
        extrude(cheek * [-1.0, 1.0], high - low, base=low),
    ]


def _pillar(
    edges: list[float], depth: tuple[float, float], heights: tuple[float, float, float], wide: float
) -> list[Mesh]:
    """A pillar with a foot, a head beside the opening, and a panel between them."""
    (front, back), (hearth, opening, top) = depth, heights
    frames = [board((edges[0], front, hearth), (edges[1], back, top), 0.006)]
    for low, high, out in ((hearth, hearth + 0.11, 0.018), (opening, opening + 0.05, 0.012)):
        frames.append(
            board(
                (edges[0] - 0.4 * out, front - out, low),
                (edges[1] + 0.4 * out, front + 0.02, high),
                0.006,
            )
        )
    panel = 0.2 * wide
    if opening - hearth > 0.3:
        low, high = hearth + 0.16, opening - 0.05
        least, most = (edges[0] + panel, front - 0.009, low), (edges[1] - panel, front + 0.01, high)
        frames.append(board(least, most, 0.006))
    return frames


def mantel(size: Size, rng: np.random.Generator) -> Parts:
    """Two pillars with feet and heads, a lintel, a moulded shelf, and a hearthstone."""
    width, depth, height = size
    x, back = 0.5 * width, 0.5 * depth
    hearth = 0.05 if depth > 0.3 else 0.03
    front = back - 0.72 * depth
    shelf, pillar = min(0.045, 0.08 * height), float(rng.uniform(0.13, 0.18)) * width
    inset = 0.05 * width
    outer, opening = x - inset, hearth + 0.66 * (height - hearth)
    inner, top = outer - pillar, height - shelf
    frames = []
    for s in (-1.0, 1.0):
        edges = sorted((s * inner, s * outer))
        frames += _pillar(edges, (front, back), (hearth, opening, top - 0.05), pillar)
    frames.append(board((-inner, front + 0.012, opening), (inner, back, top - 0.05), 0.004))
    if top - opening > 0.2:
        frames.append(
            board(
                (-0.6 * inner, front - 0.002, opening + 0.06),
                (0.6 * inner, front + 0.02, top - 0.09),
                0.006,
            )
        )
    steps = ((0.05, 0.02), (0.03, 0.045), (0.014, 0.07))
    for drop, out in steps:
        reach = min(out, 0.5 * (front + 0.5 * depth))
        frames.append(
            board(
                (-outer - 0.4 * out, front - reach, top - drop),
                (outer + 0.4 * out, back, top - drop + 0.022),
                0.005,
            )
        )
    slip = min(0.09 * width, 0.14)
    return {
        **numbered("frame", frames),
        "shelf": board((-x, back - depth + 0.1 * depth, top), (x, back, height), 0.01),
        "hearth": board((-x, -0.5 * depth, 0.0), (x, back, hearth), 0.008),
        **numbered(
            "slip",
            [
                board(
                    (min(s * inner, s * (inner - slip)), front + 0.03, hearth),
                    (max(s * inner, s * (inner - slip)), front + 0.06, opening),
                )
                for s in (-1.0, 1.0)
            ],
        ),
        "lintel": board((-inner, front + 0.03, opening - slip), (inner, front + 0.06, opening)),
        **numbered(
            "firebox",
            _firebox(
                2.0 * (inner - slip), front + 0.06, back - 0.005, hearth, opening - slip + 0.02
            ),
        ),
        **numbered("log", _logs(inner, (front, back), hearth + 0.02, rng)),
    }


def breast(size: Size, rng: np.random.Generator) -> Parts:
    """A plain chimney breast with a long low opening in a metal frame."""
    width, depth, height = size
    x, front, back = 0.5 * width, -0.5 * depth, 0.5 * depth
    wide = float(rng.uniform(0.6, 0.78)) * width
    low = min(0.45, 0.22 * height)
    high = min(low + 0.45 * wide, 0.8 * height)
    half, rim = 0.5 * wide, 0.03
    frames = [
        board((-x, front, 0.0), (-half, back, height), 0.003),
        board((half, front, 0.0), (x, back, height), 0.003),
        board((-half, front, 0.0), (half, back, low), 0.003),
        board((-half, front, high), (half, back, height), 0.003),
    ]
    metal = [
        board((-half, front - 0.008, low), (half, front + 0.03, low + rim)),
        board((-half, front - 0.008, high - rim), (half, front + 0.03, high)),
        board((-half, front - 0.008, low + rim), (rim - half, front + 0.03, high - rim)),
        board((half - rim, front - 0.008, low + rim), (half, front + 0.03, high - rim)),
    ]
    return {
        **numbered("frame", frames),
        **numbered("surround", metal),
        **numbered("firebox", _firebox(wide - 0.06, front + 0.03, back - 0.01, low, high)),
        **numbered("log", _logs(wide, (front, back), low + 0.02, rng)),
    }


def _stove_door(
    made: Assembly, x: float, span: tuple[float, float], front: float, side: float
) -> None:
    """A door with a window between ``-x`` and ``x``, its hinge away from ``side``."""
    door_low, door_high = span
    rim = 0.06
    y = front - 0.004
    frame = [
        (-x, door_low, x, door_low + rim),
        (-x, door_high - rim, x, door_high),
        (-x, door_low + rim, rim - x, door_high - rim),
        (x - rim, door_low + rim, x, door_high - rim),
    ]
    names = made.add("door", *(board((a, y - 0.022, b), (c, y, d), 0.003) for a, b, c, d in frame))
    names += made.board(
        "glass", (rim - x, y - 0.014, door_low + rim), (x - rim, y - 0.008, door_high - rim), 0.001
    )
    z = 0.5 * (door_low + door_high)
    bow = [(y - 0.02, z - 0.05), (y - 0.05, z - 0.05), (y - 0.05, z + 0.05), (y - 0.02, z + 0.05)]
    grip = filleted([(side * (x - 0.03), *point) for point in bow], 0.015)
    names += made.add("handle", tube(grip, 0.006, segments=8))
    made.hinge("door", names, (-side * x, y - 0.022, door_low), "left" if side > 0 else "right")


def stove(size: Size, rng: np.random.Generator) -> Furniture:
    """An iron stove on legs: a hollow body, a door with a window, and a pipe to the top."""
    width, depth, height = size
    made = Assembly()
    top = min(0.62 * height, 1.0)
    t, foot, back = 0.025, min(0.16, 0.2 * top), 0.5 * depth
    half, front = 0.5 * width - 0.015, -0.5 * depth + 0.06
    low, high, rear = foot, top - 0.03, back - 0.04
    made.add(
        "leg",
        *(
            square_leg(0.045, 0.03, foot + 0.01).moved((*p, 0.0))
            for p in corners(half - 0.05, 0.5 * depth - 0.1)
        ),
    )
    made.add(
        "frame",
        board((-half, front, low), (t - half, rear, high)),
        board((half - t, front, low), (half, rear, high)),
        board((t - half, rear - t, low), (half - t, rear, high)),
        board((t - half, front, low), (half - t, rear - t, low + 0.08)),
        board((t - half, front, high - 0.06), (half - t, rear - t, high)),
    )
    made.board(
        "tabletop", (-0.5 * width, front - 0.012, high), (0.5 * width, rear + 0.01, top), 0.006
    )
    inner = (low + 0.07, high - 0.05)
    made.board(
        "firebox",
        (t - half + 0.005, rear - t - 0.012, inner[0]),
        (half - t - 0.005, rear - t + 0.002, inner[1]),
    )
    door_low, door_high, x = low + 0.05, high - 0.035, half - 0.02
    side = 1.0 if rng.integers(2) else -1.0
    _stove_door(made, x, (door_low, door_high), front, side)
    pipe = min(0.075, 0.16 * width)
    at = (0.0, rear - pipe - 0.06, top - 0.002)
    made.add(
        "pipe",
        cylinder(pipe, height - top + 0.002, segments=28, base=at),
        cylinder(1.2 * pipe, 0.03, bevel=0.004, segments=28, base=at),
    )
    made.board("hearth", (-0.5 * width, -0.5 * depth, 0.0), (0.5 * width, back, 0.012))
    made.add("log", *_logs(2 * (half - t), (front, rear), low + 0.08, rng))
    return made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a place for a fire",
    size=(1.3, 0.4, 1.1),
    min_size=(0.45, 0.25, 0.6),
    max_size=(3.5, 1.2, 4.0),
    styles={
        "mantel": Style(mantel, lambda size: size[0] > 0.8 * size[2]),
        "breast": Style(breast, lambda size: size[2] > 1.2, (1.6, 0.45, 2.4)),
        "stove": Style(stove, lambda size: size[0] < 0.9 and size[2] > 1.0, (0.6, 0.62, 1.7)),
    },
    alternative_supports=("wall",),
    fixed=True,
    classes=Classes(nyu40="otherstructure", ade20k="fireplace"),
    schemes=(
        scheme("white", masonry="hearth", weight=2.0),
        scheme("masonry"),
        scheme("black", masonry="hearth", needs="pipe", weight=100.0),
    ),
    offers_surfaces=("mantel",),
    view_importance=2.0,
)
