"""Armchairs: boxy, with a wooden frame, with wings, a round tub, and one of bent wood."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.categories.sofa import modern, wooden
from openrooms_usd.furniture.construction import SEAT_ROWS
from openrooms_usd.furniture.joinery.boards import (
    SIDE,
    board,
    corners,
    profiled,
    round_leg,
    splayed,
    square_leg,
    strip,
)
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import HIDE, scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.lofts import loft
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cushion
from openrooms_usd.geometry.sweeps import extrude
from openrooms_usd.geometry.vectors import unit


def _seat(height: float) -> float:
    return min(0.45, 0.56 * height)


def wing(size: Size, rng: np.random.Generator) -> Parts:
    """A high back with wings that grow out of its arms."""
    width, depth, height = size
    seat, foot, arm = _seat(height), 0.13, min(0.11, 0.16 * width)
    arm_top = seat + min(0.19, 0.5 * (height - seat))
    front, back = -0.5 * depth, 0.5 * depth
    tip = float(rng.uniform(0.02, 0.12)) * depth
    outline = [
        (front + 0.05, foot),
        (front + 0.03, arm_top),
        (tip, arm_top),
        (tip + 0.02, 0.6 * height + 0.4 * arm_top),
        (tip + 0.09, height - 0.02),
        (back - 0.02, height - 0.03),
        (back - 0.1, foot),
    ]
    side = profiled(filleted(outline, 0.07, closed=True, segments=5), arm, SIDE, 0.03)
    x = 0.5 * (width - arm)
    inner = width - 2.0 * arm
    lean = 0.09
    thick = 0.15
    rest = cushion((inner + 0.01, thick, height - seat + 0.04), crown=(0.0, 0.025, 0.012))
    shear = np.eye(3)
    shear[1, 2] = lean / (height - seat)
    pad_depth = depth - 0.2
    pad = cushion((inner - 0.006, pad_depth, 0.15), radius=0.045, crown=(0.004, 0.014, 0.025))
    legs = _legs(0.5 * width - 0.06, 0.5 * depth - 0.09, foot + 0.02, bool(rng.integers(2)))
    return {
        **numbered("arm", [side.moved((s * x, 0.0, 0.0)) for s in (-1.0, 1.0)]),
        "back_cushion": rest.transformed(shear).moved(
            (0.0, back - 0.06 - 0.5 * lean - 0.5 * thick, 0.5 * (height + seat) - 0.02)
        ),
        "seat_cushion": pad.moved((0.0, front + 0.5 * pad_depth, seat - 0.075)),
        "frame": board(
            (-0.5 * inner - 0.02, front + 0.055, foot),
            (0.5 * inner + 0.02, back - 0.09, seat - 0.12),
            0.015,
        ),
        "back": board(
            (-0.5 * inner - 0.02, back - 0.12, seat - 0.13),
            (0.5 * inner + 0.02, back - 0.03, height - 0.08),
            0.02,
        ),
        **numbered("leg", legs),
    }


def _legs(x: float, y: float, height: float, tapered: bool) -> list[Mesh]:
    leg = square_leg(0.042, 0.026, height) if tapered else round_leg(0.022, 0.013, height)
    return [splayed(leg, (1.02 * a, 1.06 * b), (a, b)) for a, b in corners(x, y)]


def tub(size: Size, rng: np.random.Generator) -> Parts:
    """One padded wall around a round seat, falling from the back to the arms."""
    width, depth, height = size
    seat, foot, thick = _seat(height), float(rng.uniform(0.06, 0.14)), 0.09
    arm_top = seat + float(rng.uniform(0.45, 0.75)) * min(0.3, height - seat)
    path = _horseshoe(width - thick, depth - 0.5 * thick, 0.25 * thick)
    behind = 0.5 * (1.0 + np.cos(np.linspace(-np.pi, np.pi, len(path))))
    top = arm_top + (height - arm_top) * behind**1.3
    floor = _horseshoe(width - 1.7 * thick, depth - 0.9 * thick, 0.0)
    bend = float(np.ptp(floor[:, 1])) ** 2 / width
    pad = extrude(floor, 0.16, bevel=min(0.045, 0.1 * bend), base=seat - 0.16)
    deck = extrude(
        _horseshoe(width - 1.2 * thick, depth - 0.65 * thick, 0.0),
        seat - 0.14 - foot,
        bevel=0.01,
        base=foot,
    )
    legs = _legs(0.33 * width, 0.33 * depth, foot + 0.02, False)
    return {
        "back": _wall(path, thick, foot, top),
        "seat_cushion": pad.moved((0.0, -0.012, 0.0)),
        "frame": deck,
        **numbered("leg", legs),
    }


def _horseshoe(width: float, depth: float, shift: float) -> Array:
    """(N, 2) from the front right around the back to the front left, open to the front."""
    angle = np.linspace(0.0, np.pi, 25)
    round_y = 0.5 * min(width, 1.3 * depth)
    arc = np.stack([0.5 * width * np.cos(angle), round_y * np.sin(angle)], axis=1)
    arc[:, 1] += 0.5 * depth - round_y - shift
    straight = np.linspace(-0.5 * depth, arc[0, 1], 6)[:-1]
    right = np.stack([np.full(5, 0.5 * width), straight], axis=1)
    return np.concatenate([right, arc, right[::-1] * [-1.0, 1.0]])


def _wall(path: Array, thick: float, low: float, top: Array) -> Mesh:
    """A rounded wall along a path in plan, its top at a height for each point."""
    along = np.gradient(path, axis=0)
    side = unit(np.stack([along[:, 1], -along[:, 0]], axis=1))
    angle = np.linspace(0.0, np.pi, 9)
    across = 0.5 * thick * np.concatenate([[1.0], np.cos(angle), [-1.0]])
    rise = 0.5 * thick * (np.concatenate([[0.0], np.sin(angle), [0.0]]) - 1.0)
    plan = path[:, None] + across[None, :, None] * side[:, None]
    z = top[:, None] + rise
    z[:, [0, -1]] = low
    return loft(np.concatenate([plan, z[..., None]], axis=-1)[:, ::-1], crease=60.0)


def bentwood(size: Size, rng: np.random.Generator) -> Parts:
    """Springy frames of laminated wood at both sides, and one long cushion between them."""
    width, depth, height = size
    seat = _seat(height) - 0.02
    t, wide = 0.028, 0.055
    front, back = -0.5 * depth, 0.5 * depth
    arm_top = min(seat + 0.2, 0.8 * height)
    runner = [
        (back - 0.1, 0.5 * t),
        (front - 0.012, 0.5 * t),
        (front + 0.09, arm_top - 0.5 * t),
        (back - 0.3 * depth, arm_top - 0.5 * t),
    ]
    foot = profiled(strip(filleted(runner, 0.11, segments=8), t), wide, SIDE, 0.004)
    hip = 0.16 * depth
    line = filleted(
        [(front + 0.05, seat - 0.06), (hip, seat - 0.14), (back - t, height - 0.065)],
        0.14,
        segments=8,
    )
    rib = profiled(strip(line, t), wide, SIDE, 0.004)
    x = 0.5 * (width - wide)
    inner = width - 2.0 * wide - 0.02
    ribs = [rib.moved((s * (x - wide - 0.002), 0.0, 0.0)) for s in (-1.0, 1.0)]
    tilt = (line[-1] - line[-2]) / np.linalg.norm(line[-1] - line[-2])
    end = line[-1] + 0.03 * tilt + [-0.075, 0.02]
    pad = filleted([(front + 0.03, seat - 0.01), (hip - 0.07, seat - 0.09), end], 0.14, segments=10)
    pads = profiled(strip(pad, 0.1, 0.08), inner - 0.02, SIDE, 0.03)
    bars = [
        board((-x, y - 0.02, z - 0.011), (x, y + 0.02, z + 0.011), 0.004)
        for y, z in ((back - 0.14, 0.5 * t), (line[1, 0] + 0.05, line[1, 1] - 0.02))
    ]
    slats = max(3, int(rng.integers(4, 7)))
    picks = np.linspace(0.25, 0.95, slats) * (len(line) - 1)
    for pick in picks.astype(int):
        y, z = line[pick]
        bars.append(
            board((-0.5 * inner, y - 0.012, z - 0.012), (0.5 * inner, y + 0.012, z + 0.012), 0.004)
        )
    return {
        **numbered("arm", [foot.moved((s * x, 0.0, 0.0)) for s in (-1.0, 1.0)]),
        **numbered("frame", ribs),
        **numbered("rail", bars),
        "seat_cushion": pads,
    }


CATEGORY: Final = BuiltCategory(
    description="a padded seat for one, with arms",
    size=(0.85, 0.86, 0.82),
    min_size=(0.55, 0.55, 0.55),
    max_size=(1.35, 1.25, 1.3),
    styles={
        "modern": Style(modern),
        "wooden": Style(wooden),
        "wing": Style(wing, lambda size: size[2] > 0.9, (0.78, 0.84, 1.06)),
        "tub": Style(tub, lambda size: size[2] < 0.95, (0.76, 0.74, 0.76)),
        "bentwood": Style(bentwood, lambda size: size[2] > 0.8, (0.68, 0.8, 0.98)),
    },
    mass_range=(7, 35),
    words="arm_chair recliner club_chair lounge_chair easy_chair sofa_chair poltrone massage_chair",
    classes=Classes("chair", "chair", "armchair", "chair"),
    schemes=(
        scheme("upholstery", wood="leg", weight=2.0),
        scheme("upholstery", metal="leg"),
        scheme("hide", HIDE, wood="leg", needs="seat_cushion", weight=0.7),
        scheme("wood", needs="rail", weight=100.0),
    ),
    construction=SEAT_ROWS,
    offers_surfaces=("armchair_seat", "chair_back"),
    view_importance=1.5,
)
