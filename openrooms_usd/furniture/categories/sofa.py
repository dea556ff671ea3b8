"""Sofas: boxy with loose cushions, with rolled arms, with a wooden frame, and with a chaise."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import SEAT_ROWS
from openrooms_usd.furniture.joinery.boards import (
    FRONT,
    SIDE,
    board,
    corners,
    profiled,
    round_leg,
    splayed,
    square_leg,
)
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import HIDE, scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import cushion, rounded_box
from openrooms_usd.geometry.vectors import points_at

SEAT_HEIGHT: Final = 0.44
CORNER_DEPTH: Final = 1.2


def seats(width: float) -> int:
    """How many seat cushions fill a width, metres: each some 55 to 85 cm."""
    return max(1, round(width / 0.72))


def _seat_cushions(
    width: float, front: float, back: float, top: float, thick: float, rng: np.random.Generator
) -> list[Mesh]:
    """Cushions side by side, touching, each a little unlike the next."""
    count = seats(width)
    pitch = width / count
    made = []
    for i in range(count):
        crown = float(rng.uniform(0.016, 0.026))
        pad = cushion(
            (pitch - 0.006, back - front, thick), radius=0.045, crown=(0.006, 0.008, crown)
        )
        x = -0.5 * width + (i + 0.5) * pitch
        made.append(pad.moved((x, 0.5 * (front + back), top - 0.5 * thick)))
    return made


def _back_cushions(
    width: float, back: float, low: float, high: float, rng: np.random.Generator
) -> list[Mesh]:
    """Cushions that stand on the seat and lean against the back."""
    count = seats(width)
    pitch, tall, thick = width / count, high - low, 0.17
    made = []
    for i in range(count):
        pad = cushion(
            (pitch - 0.012, thick, tall),
            radius=0.06,
            crown=(0.008, 0.035, float(rng.uniform(0.012, 0.024))),
        )
        lean = np.eye(3)
        lean[1, 2] = 0.16 + float(rng.uniform(-0.02, 0.02))
        x = -0.5 * width + (i + 0.5) * pitch
        y = back - 0.5 * thick - lean[1, 2] * 0.5 * tall
        made.append(pad.transformed(lean).moved((x, y, 0.5 * (low + high))))
    return made


def _levels(height: float) -> tuple[float, float]:
    """Seat height and cushion thickness in a sofa of a given height, metres."""
    seat = min(SEAT_HEIGHT, 0.56 * height)
    return seat, min(0.17, 0.4 * seat)


def modern(size: Size, rng: np.random.Generator) -> Parts:
    """Straight padded arms and back on short legs, loose cushions."""
    width, depth, height = size
    seat, thick = _levels(height)
    arm = min(float(rng.uniform(0.13, 0.2)), 0.2 * width)
    rest, foot = 0.16, 0.1
    arm_top = seat + 0.6 * min(0.3, height - seat)
    inner = width - 2.0 * arm
    front, back = -0.5 * depth, 0.5 * depth - rest
    deck = seat - thick
    arm_pad = cushion((arm, depth - 0.01, arm_top - foot), radius=0.04, crown=(0.008, 0.006, 0.01))
    arms = [
        arm_pad.moved((side * 0.5 * (width - arm), -0.005, 0.5 * (arm_top + foot)))
        for side in (-1, 1)
    ]
    top = height - 0.06
    spine = cushion((inner + 0.06, rest, top - foot), crown=(0.0, 0.008, 0.012))
    leg = round_leg(0.022, 0.015, foot + 0.02)
    x, y = 0.5 * width - 0.09, 0.5 * depth - 0.08
    legs = [splayed(leg, (1.03 * a, 1.03 * b), (a, b)) for a, b in corners(x, y)]
    return {
        "frame": rounded_box(
            (inner + 0.02, depth - rest - 0.03, deck - foot),
            0.02,
            segments=2,
            center=(0.0, 0.5 * (front + 0.03 + back), 0.5 * (deck + foot)),
        ),
        "back": spine.moved((0.0, 0.5 * (depth - rest), 0.5 * (top + foot))),
        **numbered("arm", arms),
        **numbered("seat_cushion", _seat_cushions(inner, front, back - 0.01, seat, thick, rng)),
        **numbered("back_cushion", _back_cushions(inner, back + 0.015, seat - 0.015, height, rng)),
        **numbered("leg", legs),
    }


def rolled(size: Size, rng: np.random.Generator) -> Parts:
    """A classic: arms that roll outwards, a high padded back, turned feet."""
    width, depth, height = size
    seat, thick = _levels(height)
    arm = min(0.2, 0.2 * width)
    rest, foot = 0.18, 0.08
    inner = width - 2.0 * arm
    front, back = -0.5 * depth, 0.5 * depth - rest
    deck = seat - thick
    arm_top = seat + 0.62 * min(0.3, height - seat)
    roll = 0.5 * arm
    angle = np.linspace(-0.35 * np.pi, 1.0 * np.pi, 16)
    scroll = points_at(roll + 0.98 * roll * np.cos(angle), arm_top - roll + roll * np.sin(angle))
    outline = np.concatenate([[(0.03, foot), (0.78 * arm, foot)], scroll, [(0.03, arm_top - arm)]])
    arms = [
        profiled(outline * [side, 1.0], depth - 0.05, FRONT, 0.015).moved(
            (side * 0.5 * inner - side * 0.03, 0.02, 0.0)
        )
        for side in (-1, 1)
    ]
    spine = cushion((inner + 0.08, rest, height - foot), radius=0.07, crown=(0.0, 0.012, 0.03))
    leg = round_leg(0.032, 0.02, foot + 0.01)
    x, y = 0.5 * inner + 0.02, 0.5 * depth - 0.09
    return {
        "frame": rounded_box(
            (inner + 0.02, depth - rest - 0.04, deck - foot),
            0.025,
            segments=2,
            center=(0.0, 0.5 * (front + 0.04 + back), 0.5 * (deck + foot)),
        ),
        "back": spine.moved((0.0, 0.5 * (depth - rest), 0.5 * (height + foot))),
        **numbered("arm", arms),
        **numbered("seat_cushion", _seat_cushions(inner, front, back - 0.01, seat, thick, rng)),
        **numbered(
            "back_cushion", _back_cushions(inner, back + 0.015, seat - 0.015, height - 0.07, rng)
        ),
        **numbered("leg", [leg.moved((*corner, 0.0)) for corner in corners(x, y)]),
    }


def wooden(size: Size, rng: np.random.Generator) -> Parts:
    """A slim wooden frame with open arms and loose cushions."""
    width, depth, height = size
    seat, thick = min(SEAT_HEIGHT, 0.56 * height), 0.13
    post = 0.04
    deck = seat - thick
    x, y = 0.5 * (width - post), 0.5 * (depth - post)
    arm_top = seat + 0.6 * min(0.32, height - seat)
    lean = 0.1
    leg = square_leg(post, 0.6 * post, arm_top - 0.022)
    legs = [leg.moved((a, b if b < 0 else b - lean, 0.0)) for a, b in corners(x, y)]
    arms = [
        profiled(
            filleted(
                [
                    (-0.5 * depth, arm_top - 0.022),
                    (-0.5 * depth, arm_top),
                    (0.5 * depth - lean, arm_top - 0.012),
                    (0.5 * depth - lean, arm_top - 0.034),
                ],
                0.01,
                closed=True,
            ),
            0.065,
            SIDE,
            0.005,
        ).moved((side * (0.5 * width - 0.0325), 0.0, 0.0))
        for side in (-1, 1)
    ]
    rails = [
        board((-x, sy - 0.014, deck - 0.055), (x, sy + 0.014, deck + 0.012), 0.004)
        for sy in (-y, y - lean)
    ] + [
        board((side * x - 0.014, -y, deck - 0.055), (side * x + 0.014, y - lean, deck), 0.004)
        for side in (-1, 1)
    ]
    base = board((-x, -y + 0.02, deck - 0.012), (x, y - lean, deck), 0.003)
    slope = lean / (height - deck)
    upright = square_leg(0.032, 0.032, height - deck)
    count = max(2, round(width / 0.35))
    places = np.linspace(-x, x, count)
    bars = [splayed(upright, (px, y - lean), (px, y)).moved((0.0, 0.0, deck)) for px in places]
    crest = board((-x - 0.02, y - 0.018, height - 0.06), (x + 0.02, y + 0.02, height), 0.006)
    inner = width - 2.0 * post - 0.02
    rear = y - lean - 0.01
    cushions = _back_cushions(inner, rear + slope * 0.2, seat - 0.015, height - 0.01, rng)
    return {
        "frame": base,
        **numbered("rail", [*rails, *bars, crest]),
        **numbered("arm", arms),
        **numbered("leg", legs),
        **numbered(
            "seat_cushion", _seat_cushions(inner, -0.5 * depth + 0.005, rear, seat, thick, rng)
        ),
        **numbered("back_cushion", cushions),
    }


def chaise(size: Size, rng: np.random.Generator) -> Parts:
    """A corner sofa: a row of seats and a long seat on one side."""
    width, depth, height = size
    seat, thick = _levels(height)
    body = 0.95 if depth > 1.1 else 0.62 * depth
    long = float(np.clip(0.36 * width, 0.7, 0.95)) if width > 1.5 else 0.45 * width
    side = 1.0 if rng.integers(2) else -1.0
    row = {
        name: mesh.moved((0.0, 0.5 * (depth - body), 0.0))
        for name, mesh in modern((width, body, height), rng).items()
    }
    count = sum(name.startswith("seat_cushion") for name in row)
    deck, foot, arm = seat - thick, 0.1, 0.16
    x0, x1 = 0.5 * width - long, 0.5 * width
    front, back = -0.5 * depth, 0.5 * depth - body + 0.08
    x = side * 0.5 * (x0 + x1 - arm)
    wide = x1 - x0 - arm
    pad = cushion((wide, back - front, thick), radius=0.045, crown=(0.006, 0.008, 0.016))
    y = 0.5 * (front + back)
    leg = round_leg(0.022, 0.015, foot + 0.02)
    feet = [(x + s * (0.5 * wide - 0.08), front + 0.08) for s in (-1, 1)]
    return {
        **row,
        "frame_1": rounded_box(
            (wide, back - front - 0.03, deck - foot),
            0.02,
            segments=2,
            center=(x, y + 0.015, 0.5 * (deck + foot)),
        ),
        f"seat_cushion_{count}": pad.moved((x, y, seat - 0.5 * thick)),
        **{f"leg_{4 + i}": leg.moved((*p, 0.0)) for i, p in enumerate(feet)},
    }


def _straight(size: Size) -> bool:
    return size[1] < CORNER_DEPTH


CATEGORY: Final = BuiltCategory(
    description="a padded seat for several",
    size=(2.0, 0.92, 0.82),
    min_size=(0.6, 0.6, 0.55),
    max_size=(4.5, 2.6, 1.3),
    styles={
        "modern": Style(modern, _straight),
        "rolled": Style(rolled, _straight),
        "wooden": Style(wooden, _straight),
        "chaise": Style(chaise, lambda size: not _straight(size)),
    },
    mass_range=(30, 90),
    words="couch loveseat love_seat settee futon sectional sofa_bed sofa_set",
    classes=Classes("sofa", "sofa", "sofa", "couch"),
    synsets=("04256520",),
    schemes=(
        scheme("upholstery", wood="leg", weight=2.0),
        scheme("upholstery", metal="leg"),
        scheme("hide", HIDE, wood="leg", weight=0.7),
        scheme("hide", HIDE, metal="leg", weight=0.5),
        scheme("wood", needs="rail", weight=100.0),
    ),
    construction=SEAT_ROWS,
    offers_surfaces=("sofa_seat", "sofa_arm"),
    view_importance=4.0,
)
