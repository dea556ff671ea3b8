"""Benches: a plank on side boards, slats on bent steel, padded, and a chest with a lid."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import SEAT_ROWS
from openrooms_usd.furniture.joinery.assembly import Assembly
from openrooms_usd.furniture.joinery.boards import SIDE, board, corners, profiled, square_leg
from openrooms_usd.furniture.joinery.pieces import Furniture, Parts, Size, Style, numbered
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import CHAIRS, scheme
from openrooms_usd.geometry.solids import cushion
from openrooms_usd.geometry.sweeps import tube


def plank(size: Size, rng: np.random.Generator) -> Parts:
    """A thick plank on two side boards, tied by a stretcher."""
    width, depth, height = size
    thick = float(rng.uniform(0.032, 0.045))
    under, x = height - thick, 0.5 * width - max(0.09, 0.1 * width)
    cut, half = 0.22 * depth, 0.46 * depth
    # Each side board has an arch cut out of its foot.
    arch = [(cut * np.cos(t), 0.5 * cut * np.sin(t)) for t in np.linspace(np.pi, 0.0, 9)]
    outline = [(-half, 0.0), *arch, (half, 0.0), (0.42 * depth, under), (-0.42 * depth, under)]
    side = profiled(outline, 0.036, SIDE, 0.002)
    rail = board((-x, -0.014, 0.4 * under), (x, 0.014, 0.4 * under + 0.09), 0.003)
    return {
        "seat": board(
            (-0.5 * width, -0.5 * depth, under), (0.5 * width, 0.5 * depth, height), 0.006
        ),
        **numbered("leg", [side.moved((s * x, 0.0, 0.0)) for s in (-1.0, 1.0)]),
        "bar_stretcher": rail,
    }


def slatted(size: Size, rng: np.random.Generator) -> Parts:
    """Long slats side by side on frames of square steel."""
    width, depth, height = size
    thick = 0.028
    count = max(3, round(depth / float(rng.uniform(0.065, 0.09))))
    pitch, gap = (depth + 0.008) / count, 0.008
    slats = [
        board(
            (-0.5 * width, -0.5 * depth + i * pitch, height - thick),
            (0.5 * width, -0.5 * depth + (i + 1) * pitch - gap, height),
            0.004,
        )
        for i in range(count)
    ]
    t, half = 0.03, 0.5 * depth - 0.015
    places = np.linspace(-0.5 * width + 0.12, 0.5 * width - 0.12, max(2, round(width / 1.3) + 1))
    under = height - thick
    sections = (
        (-half, t - half, 0.0, under),
        (half - t, half, 0.0, under),
        (t - half, half - t, under - t, under),
        (t - half, half - t, 0.0, 0.5 * t),
    )
    bars = [
        board((x - 0.02, a, low), (x + 0.02, b, high))
        for x in places.tolist()
        for a, b, low, high in sections
    ]
    return {**numbered("seat", slats), **numbered("leg", bars)}


def padded(size: Size, rng: np.random.Generator) -> Parts:
    """One long cushion or several on a frame with slim legs."""
    width, depth, height = size
    thick = min(0.12, 0.3 * height)
    under = height - thick
    pads = max(1, round(width / 0.9)) if rng.integers(2) else 1
    pitch = width / pads
    pad = cushion(
        (pitch - (0.006 if pads > 1 else 0.0), depth, thick),
        radius=0.04,
        crown=(0.006, 0.006, 0.015),
    )
    places = -0.5 * width + pitch * (np.arange(pads) + 0.5)
    x, y = 0.5 * width - 0.04, 0.5 * depth - 0.035
    leg = square_leg(0.036, float(rng.uniform(0.022, 0.036)), under)
    rails = [
        board((-x, s * y - 0.011, under - 0.05), (x, s * y + 0.011, under + 0.01))
        for s in (-1.0, 1.0)
    ]
    rails += [
        board((s * x - 0.011, -y, under - 0.05), (s * x + 0.011, y, under + 0.01))
        for s in (-1.0, 1.0)
    ]
    return {
        **numbered("seat_cushion", [pad.moved((p, 0.0, height - 0.5 * thick)) for p in places]),
        **numbered("frame", rails),
        **numbered("leg", [leg.moved((*corner, 0.0)) for corner in corners(x, y)]),
    }


def hoop(size: Size, rng: np.random.Generator) -> Parts:
    """Two thick planks across hoops of round steel."""
    width, depth, height = size
    r, thick = 0.012, 0.036
    x, y = 0.5 * width - 0.14, 0.5 * depth - r
    path = [(0.0, -y, height - thick - r), (0.0, -y, r), (0.0, y, r), (0.0, y, height - thick - r)]
    frame = tube(path, r, bend=0.06, bend_segments=6, segments=10, closed=True)
    gap = float(rng.uniform(0.004, 0.02))
    planks = [
        board(
            (-0.5 * width, min(s * 0.5 * gap, s * 0.5 * depth), height - thick),
            (0.5 * width, max(s * 0.5 * gap, s * 0.5 * depth), height),
            0.006,
        )
        for s in (-1.0, 1.0)
    ]
    return {
        **numbered("seat", planks),
        **numbered("leg", [frame.moved((s * x, 0.0, 0.0)) for s in (-1.0, 1.0)]),
    }


def chest(size: Size, rng: np.random.Generator) -> Furniture:
    """A box to keep things in, with a lid on a hinge at its back."""
    width, depth, height = size
    t, foot = 0.018, 0.04
    half, y, top = 0.5 * width, 0.5 * depth, height - 0.024
    made = Assembly()
    x, front = half - 0.01, 0.012 - y
    made.add(
        "frame",
        board((-x, front, foot), (x, front + t, top)),
        board((-x, y - t, foot), (x, y, top)),
        *(
            board((min(s * x, s * (x - t)), front + t, foot), (max(s * x, s * (x - t)), y - t, top))
            for s in (-1.0, 1.0)
        ),
        board((t - x, front + t, foot), (x - t, y - t, foot + t)),
    )
    made.board("base", (0.02 - x, front + 0.02, 0.0), (x - 0.02, y - 0.02, foot))
    count = max(1, round(width / 0.5))
    pitch = (2.0 * x - 0.04) / count
    panel = float(rng.uniform(0.05, 0.08))
    # Mouldings that frame panels on the front.
    for i in range(count):
        a, b = -x + 0.02 + i * pitch, -x + 0.02 + (i + 1) * pitch
        made.board(
            "panel",
            (a + 0.3 * panel, front - 0.006, foot + panel),
            (b - 0.3 * panel, front + 0.001, top - panel),
            0.004,
        )
    lid = made.board("lid", (-half, -y, top + 0.001), (half, y, height), 0.006)
    made.hinge("lid", lid, (0.0, y, top), "top", 90.0)
    return made.furniture()


CATEGORY: Final = BuiltCategory(
    description="a long seat without a back",
    size=(1.2, 0.38, 0.46),
    min_size=(0.5, 0.22, 0.3),
    max_size=(3.0, 0.7, 0.75),
    styles={
        "plank": Style(plank),
        "slatted": Style(slatted, lambda size: size[0] > 0.8),
        "padded": Style(padded),
        "hoop": Style(hoop),
        "chest": Style(chest, lambda size: size[2] < 0.6 and size[1] > 0.32),
    },
    one_variant_per_room=True,
    mass_range=(4, 35),
    words="piano_bench",
    classes=Classes("bench", "otherfurniture", "bench", "bench"),
    synsets=("02828884",),
    schemes=(*CHAIRS, scheme("wood", metal="leg")),
    construction=SEAT_ROWS,
    offers_surfaces=("cabinet_top",),
    view_importance=0.7,
)
