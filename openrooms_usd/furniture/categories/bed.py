"""Beds: a platform, slatted ends, a padded headboard, two bunks, four posts."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import SEAT_ROWS, filled, row, walls
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import board, corners, round_leg, square_leg
from openrooms_usd.furniture.joinery.cloth import cover, pillow
from openrooms_usd.furniture.joinery.pieces import Furniture, Size, Style
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted
from openrooms_usd.geometry.solids import cushion, rounded_box
from openrooms_usd.geometry.sweeps import tube

# Thickness of a cover, metres.
COVER: Final = 0.024
# Top of the mattress, and how thick mattresses are, metres.
LEVEL: Final = 0.52
MATTRESS: Final = 0.2


def bedding(
    made: Assembly,
    half: float,
    span: tuple[float, float],
    level: float,
    thick: float,
    drop: tuple[float, float],
    rng: np.random.Generator,
) -> None:
    """A mattress, pillows at its head, and a cover that is turned down before them.

    Args:
        made: Gets the parts.
        half: Half the width of the mattress, metres.
        span: Y of its foot and of its head, metres.
        level: Z of its top, metres.
        thick: Its thickness, metres.
        drop: How far the cover hangs down at the sides and at the foot, metres.
        rng: Draws creases.
    """
    foot, head = span
    pad = cushion((2.0 * half, head - foot, thick), radius=0.04, crown=(0.004, 0.004, 0.006))
    made.add("mattress", pad.moved((0.0, 0.5 * (foot + head), level - 0.5 * thick)))
    count = 1 if half < 0.6 else 2
    pitch = 2.0 * half / count
    deep = min(0.44, 0.24 * (head - foot))
    wide = min(0.72, pitch - 0.06)
    for i in range(count):
        x = -half + (i + 0.5) * pitch
        shape = pillow(wide, deep, 0.15, rng, divisions=10)
        tilt = np.eye(3)
        tilt[2, 1] = 0.12 + float(rng.uniform(-0.04, 0.04))
        y = head - 0.5 * deep - 0.02
        made.add("pillow", shape.transformed(tilt).moved((x, y, level + 0.07)))
    edge = half - 0.024 if drop[0] > 0.0 else half - 0.03
    end = head - deep - 0.06
    near = foot + (0.024 if drop[1] > 0.0 else 0.01)
    top = level + COVER + 0.012
    made.add("blanket", cover(edge, (near, end), top, drop, COVER, rng))
    fold = (end - 0.26, end + 0.02)
    hang = (max(0.0, drop[0] - 0.05), 0.0)
    made.add("sheet", cover(edge + 0.003, fold, top + 0.016, hang, 0.012, rng, puff=0.003))


def _level(height: float) -> float:
    """The top of the mattress in a bed of a height that leaves room for its pillows, metres."""
    return min(LEVEL, height - 0.13)


def platform(size: Size, rng: np.random.Generator) -> Furniture:
    """A wide low platform on a set-back base, and a plain headboard."""
    width, depth, height = size
    made = Assembly()
    level, thick = _level(height), min(MATTRESS, 0.5 * _level(height))
    half, foot, head = 0.5 * width, -0.5 * depth, 0.5 * depth
    deck, slab = level - thick + 0.03, 0.09
    panel = 0.04
    made.board("frame", (-half, foot, deck - slab), (half, head - panel, deck), 0.008)
    made.board("base", (0.12 - half, foot + 0.15, 0.0), (half - 0.12, head - 0.1, deck - slab))
    _headboard(made, size, head, panel, bool(rng.integers(2)))
    span = (foot + 0.055, head - panel - 0.01)
    bedding(made, half - 0.055, span, level, thick, (min(0.2, thick), 0.16), rng)
    return made.furniture()


def _headboard(made: Assembly, size: Size, head: float, panel: float, planks: bool) -> None:
    """One board, or planks above each other with a shadow gap."""
    width, _, height = size
    half = 0.5 * width
    low = min(0.1, 0.2 * height)
    count = max(2, round((height - low) / 0.16)) if planks else 1
    pitch = (height - low) / count
    for i in range(count):
        gap = 0.006 if i else 0.0
        made.board(
            "headboard",
            (-half, head - panel, low + i * pitch + gap),
            (half, head, low + (i + 1) * pitch),
            0.006,
        )


def slatted(size: Size, rng: np.random.Generator) -> Furniture:
    """Posts with rails and bars between them at head and foot, and slats below the mattress."""
    width, depth, height = size
    made = Assembly()
    level = _level(height)
    thick, t = min(MATTRESS, 0.45 * level), 0.055
    half, y = 0.5 * (width - t), 0.5 * (depth - t)
    deck = level - thick + 0.07
    low_end = min(height, max(level + 0.02, float(rng.uniform(0.55, 0.75)) * height))
    upright = bool(rng.integers(2))
    for side, top in ((-1.0, low_end), (1.0, height)):
        post = square_leg(t, t, top, 0.008)
        made.add("leg", *(post.moved((s * half, side * y, 0.0)) for s in (-1.0, 1.0)))
        part = "headboard" if side > 0 else "footboard"
        crest = board(
            (-half, side * y - 0.015, top - 0.11), (half, side * y + 0.015, top - 0.02), 0.006
        )
        rail = board((-half, side * y - 0.015, deck - 0.14), (half, side * y + 0.015, deck), 0.004)
        made.add(part, crest, rail)
        _bars(made, part, half - 0.5 * t, side * y, (deck, top - 0.11), upright)
    for s in (-1.0, 1.0):
        made.board("rail", (s * half - 0.013, -y, deck - 0.13), (s * half + 0.013, y, deck), 0.004)
    inner = half - 0.013
    count = max(6, round(depth / 0.16))
    base = level - thick
    for p in np.linspace(-y + 0.09, y - 0.09, count).tolist():
        made.board("slat", (-inner, p - 0.035, base - 0.018), (inner, p + 0.035, base), 0.003)
    span = (0.02 - y, y - 0.02)
    bedding(made, inner - 0.012, span, level, thick, (0.0, 0.0), rng)
    return made.furniture()


def _bars(
    made: Assembly, part: str, half: float, y: float, z: tuple[float, float], upright: bool
) -> None:
    """What fills the end of a bed between its rails."""
    if z[1] - z[0] < 0.08:
        return
    if upright:
        for x in np.linspace(-half, half, max(4, round(2.0 * half / 0.11)) + 1)[1:-1].tolist():
            made.board(part, (x - 0.016, y - 0.008, z[0]), (x + 0.016, y + 0.008, z[1]), 0.003)
        return
    count = max(1, round((z[1] - z[0]) / 0.15))
    for a in (z[0] + (z[1] - z[0]) * (np.arange(count) + 0.5) / count).tolist():
        made.board(part, (-half, y - 0.009, a - 0.045), (half, y + 0.009, a + 0.045), 0.004)


def upholstered(size: Size, rng: np.random.Generator) -> Furniture:
    """A padded frame and a headboard of padded channels, upright or lying."""
    width, depth, height = size
    made = Assembly()
    level = _level(height)
    thick, foot_high, board_thick = min(MATTRESS, 0.45 * level), 0.08, 0.11
    half, foot = 0.5 * width, -0.5 * depth
    deck, rear = level - thick + 0.06, 0.5 * depth - board_thick
    side = 0.05
    for s in (-1.0, 1.0):
        shape = rounded_box((side, rear - foot, deck - foot_high), 0.02, segments=2)
        made.add(
            "frame",
            shape.moved((s * (half - 0.5 * side), 0.5 * (foot + rear), 0.5 * (deck + foot_high))),
        )
    end = rounded_box((width - 2.0 * side + 0.02, side, deck - foot_high), 0.02, segments=2)
    made.add("frame", end.moved((0.0, foot + 0.5 * side, 0.5 * (deck + foot_high))))
    made.board(
        "base",
        (side - half, foot + side, foot_high + 0.03),
        (half - side, rear, level - thick + 0.005),
    )
    _channels(made, size, rear, board_thick, foot_high, bool(rng.integers(2)))
    leg = round_leg(0.028, 0.02, foot_high + 0.01)
    made.add("leg", *(leg.moved((*p, 0.0)) for p in corners(half - 0.08, 0.5 * depth - 0.08)))
    made.add("leg", leg.moved((0.0, 0.0, 0.0)))
    span = (foot + side + 0.005, rear - 0.005)
    bedding(made, half - side - 0.005, span, level, thick, (0.0, 0.0), rng)
    return made.furniture()


def _channels(
    made: Assembly, size: Size, y: float, thick: float, low: float, upright: bool
) -> None:
    width, depth, height = size
    rear = 0.035
    least, most = (-0.5 * width, 0.5 * depth - rear, low), (0.5 * width, 0.5 * depth, height - 0.01)
    made.board("headboard", least, most, 0.015)
    length, across = (width, height - low) if upright else (height - low, width)
    count = max(2, round(length / 0.19))
    pitch = length / count
    bulge = (0.004, 0.022, 0.006) if upright else (0.006, 0.022, 0.004)
    pad_size = (
        (pitch, thick - rear + 0.015, across) if upright else (across, thick - rear + 0.015, pitch)
    )
    pad = cushion(pad_size, radius=0.03, crown=bulge, divisions=2)
    for i in range(count):
        at = (i + 0.5) * pitch
        middle = y + 0.5 * (thick - rear + 0.015)
        x, z = (at - 0.5 * width, 0.5 * (height + low)) if upright else (0.0, low + at)
        made.add("headboard_pad", pad.moved((x, middle, z)))


def four_poster(size: Size, rng: np.random.Generator) -> Furniture:
    """Four tall posts joined by a frame at their tops."""
    width, depth, height = size
    made = Assembly()
    level, t = min(0.6, 0.4 * height), 0.065
    thick = min(0.22, 0.4 * level)
    half, y = 0.5 * (width - t), 0.5 * (depth - t)
    post = square_leg(t, t * float(rng.uniform(0.7, 1.0)), height, 0.01)
    made.add("leg", *(post.moved((*p, 0.0)) for p in corners(half, y)))
    for z, tall in ((height - 0.07, 0.055), (level - thick - 0.06, 0.14)):
        made.add(
            "rail",
            *(board((-half, s * y - 0.016, z), (half, s * y + 0.016, z + tall)) for s in (-1, 1)),
            *(board((s * half - 0.016, -y, z), (s * half + 0.016, y, z + tall)) for s in (-1, 1)),
        )
    count = int(rng.integers(1, 4))
    pitch = 2.0 * half / count
    for i in range(count):
        a = -half + i * pitch
        made.board(
            "headboard",
            (a + 0.006, y - 0.018, level - thick),
            (a + pitch - 0.006, y + 0.018, min(level + 0.6, height - 0.2)),
            0.01,
        )
    made.board("base", (-half, -y, level - thick - 0.03), (half, y, level - thick))
    span = (0.02 - y, y - 0.03)
    bedding(made, half - 0.02, span, level, thick, (0.0, 0.0), rng)
    return made.furniture()


# How deep a ladder is, metres.
_LADDER_M: Final = 0.06


def _guards(
    made: Assembly, half: float, y: float, side: float, height: float, decks: tuple[float, float]
) -> None:
    """The rails of the upper bunk, open where the ladder is, and the ends of both."""
    for a in (height - 0.07, 0.5 * (decks[1] + 0.12 + height - 0.07)):
        made.board(
            "rail", (-side * half - 0.011, -y, a - 0.035), (-side * half + 0.011, y, a + 0.035)
        )
        made.board(
            "rail", (side * half - 0.011, 0.38 - y, a - 0.035), (side * half + 0.011, y, a + 0.035)
        )
        made.add(
            "headboard",
            *(
                board((-half, s * y - 0.011, a - 0.035), (half, s * y + 0.011, a + 0.035))
                for s in (-1, 1)
            ),
        )
    made.add(
        "headboard",
        *(
            board((-half, s * y - 0.011, decks[0] + 0.2), (half, s * y + 0.011, decks[0] + 0.28))
            for s in (-1, 1)
        ),
    )


def _ladder(made: Assembly, x: float, y: float, side: float, height: float, deck: float) -> None:
    """Two beams beside the posts at ``x``, and rungs up to a deck."""
    rungs = max(3, round(deck / 0.27))
    rail = filleted([(x + side * 0.03, 0.0, 0.0), (x + side * 0.03, 0.0, height)], 0.0)
    for p in (-y + 0.06, -y + 0.36):
        made.board(
            "ladder",
            (min(x, x + side * _LADDER_M), p - 0.012, 0.0),
            (max(x, x + side * _LADDER_M), p + 0.012, height),
        )
    for k in range(rungs):
        z = deck * (k + 0.7) / rungs
        path = rail[:1] * [1.0, 0.0, 0.0] + [[0.0, 0.06 - y, z], [0.0, 0.36 - y, z]]
        made.add("ladder", tube(path, 0.014, segments=10))


def bunk(size: Size, rng: np.random.Generator) -> Furniture:
    """Two beds above each other with a ladder and a guard rail."""
    width, depth, height = size
    made = Assembly()
    t, thick = 0.06, 0.14
    half, y = 0.5 * (width - _LADDER_M - t), 0.5 * (depth - t)
    side = 1.0 if rng.integers(2) else -1.0
    shift = -0.5 * side * _LADDER_M
    post = square_leg(t, t, height, 0.008)
    made.add("leg", *(post.moved((*p, 0.0)) for p in corners(half, y)))
    decks = (max(0.2, 0.19 * height), 0.74 * height)
    for deck in decks:
        made.add(
            "rail",
            *(
                board((s * half - 0.013, -y, deck), (s * half + 0.013, y, deck + 0.12))
                for s in (-1, 1)
            ),
            *(
                board((-half, s * y - 0.013, deck), (half, s * y + 0.013, deck + 0.12))
                for s in (-1, 1)
            ),
        )
        for p in np.linspace(0.08 - y, y - 0.08, max(6, round(depth / 0.2))).tolist():
            made.board("slat", (-half, p - 0.035, deck + 0.02), (half, p + 0.035, deck + 0.036))
        bedding(
            made, half - 0.028, (0.03 - y, y - 0.03), deck + 0.036 + thick, thick, (0.0, 0.0), rng
        )
    _guards(made, half, y, side, height, decks)
    _ladder(made, side * (half + 0.5 * t), y, side, height, decks[1])
    whole = made.furniture()
    moved = {name: mesh.moved((shift, 0.0, 0.0)) for name, mesh in whole.parts.items()}
    return Furniture(moved, whole.joints)


def _low(size: Size) -> bool:
    return size[2] < 1.4


CATEGORY: Final = BuiltCategory(
    description="a bed with its head at the back",
    size=(1.6, 2.05, 1.0),
    min_size=(0.7, 1.3, 0.4),
    max_size=(2.4, 2.5, 2.4),
    styles={
        "platform": Style(platform, _low),
        "slatted": Style(slatted, _low),
        "upholstered": Style(upholstered, _low, (1.65, 2.1, 1.1)),
        "four_poster": Style(
            four_poster, lambda size: not _low(size) and size[0] > 1.15, (1.7, 2.1, 2.05)
        ),
        "bunk": Style(bunk, lambda size: not _low(size) and size[0] < 1.5, (1.03, 2.04, 1.65)),
    },
    mass_range=(55, 150),
    words="bunk_bed double_bed single_bed mattress bedframe bed_frame bedstead matress",
    classes=Classes("bed", "bed", "bed", "bed"),
    synsets=("02818832",),
    schemes=(
        scheme("wood", weight=3.0),
        scheme("white"),
        scheme("upholstery", wood="leg", black="base", needs="headboard_pad", weight=100.0),
    ),
    construction=(
        row("frame headboard footboard", walls(12), "board", "wood", "paint"),
        row("base", walls(5), "common"),
        row("blanket sheet", filled(45), "foam"),
        *SEAT_ROWS,
    ),
    offers_surfaces=("bed_head", "bed_foot"),
    view_importance=5.0,
)
