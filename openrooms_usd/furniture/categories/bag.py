"""Bags: a tote that stands, one that hangs, a paper bag, a handbag."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, walls
from openrooms_usd.furniture.joinery.boards import FRONT
from openrooms_usd.furniture.joinery.cloth import pillow, ripples
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.placements import LOOP_BACK_M, LOOP_M, on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.lofts import loft, ring, superellipse, vessel
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.uv import metric


def _open_bag(size: Size, sag: float, rng: np.random.Generator) -> Mesh:
    """A soft bag, open above, its middle a little drawn in."""
    width, depth, height = size
    rows = [(0.94, 0.0), (1.0, 0.06), (1.0, 0.35), (0.97, 0.7), (0.98, 1.0)]
    outer = []
    for a, z in rows:
        flat = superellipse(a * width, depth * a * (1.0 - sag * z), 4.0, 32)
        wave = 1.0 - 0.05 * sag * np.abs(ripples(flat[:, 0], flat[:, 1] + z, 0.15, rng))
        outer.append(ring(flat * wave[:, None], z * height))
    thin = 1.0 - 2 * 0.003 / depth
    inner = [row * [1.0 - 0.006 / width, thin, 1.0] for row in outer[:0:-1]]
    floor = ring(superellipse(0.9 * width, 0.86 * depth, 4.0, 32), 0.004)
    return metric(loft(np.array([*outer, *inner, floor]), crease=60.0))[0]


def _loop(half: float, y: float, low: float, top: float, thick: float) -> Mesh:
    t = np.linspace(np.pi, 0.0, 11)
    z = low + (top - thick - low) * np.sin(t) ** 0.8
    arch = np.stack([half * np.cos(t), np.full(11, y), z], axis=1)
    return tube(arch, thick, segments=8)


def tote(size: Size, rng: np.random.Generator) -> Parts:
    """A bag of cloth that stands, its loops FRONT."""
    width, depth, height = size
    tall = 0.7 * height
    loops = [_loop(0.24 * width, s * 0.36 * depth, 0.9 * tall, height, 0.005) for s in (-1, 1)]
    return {"bag": _open_bag((width, depth, tall), 0.25, rng), **numbered("handle", loops)}


def hung(size: Size, rng: np.random.Generator) -> Parts:
    """A flat bag that hangs from its loops."""
    width, depth, height = size
    tall = 0.58 * height
    # Both straps lie on the hook, one before the other.
    y = 0.5 * depth - LOOP_BACK_M
    loops = [
        _loop(0.26 * width, y + s * 0.45 * LOOP_M, 0.92 * tall, height, 0.5 * LOOP_M)
        for s in (-1.0, 1.0)
    ]
    body = filled_case(width, tall, depth, rng)
    return {"bag": body.moved((0.0, 0.0, 0.5 * tall)), **numbered("handle", loops)}


def filled_case(width: float, tall: float, depth: float, rng: np.random.Generator) -> Mesh:
    """A soft case that stands on its edge, about the origin."""
    case = pillow(width, tall, depth, rng, divisions=12)
    return metric(case.transformed(FRONT))[0]


def paper(size: Size, rng: np.random.Generator) -> Parts:
    """A bag of paper with cords."""
    width, depth, height = size
    tall = 0.8 * height
    x, y = 0.5 * width, 0.5 * depth
    w = 0.0015
    body = vessel(
        (-x, -y, 0.0, x, y, tall), (-x + w, -y + w, 0.002, x - w, y - w), wall_edge=0.0004
    )
    loops = [_loop(0.2 * width, s * (y - 0.004), 0.9 * tall, height, 0.0025) for s in (-1, 1)]
    return {"sack": body, **numbered("cord", loops)}


CATEGORY: Final = BuiltCategory(
    description="a bag to carry things",
    size=(0.38, 0.16, 0.5),
    min_size=(0.12, 0.05, 0.15),
    max_size=(0.9, 0.5, 1.0),
    styles={
        "tote": Style(tote),
        "hung": Style(hung, lambda size: size[2] > 1.5 * size[0], (0.36, 0.11, 0.68)),
        "paper": Style(paper, size=(0.32, 0.16, 0.42)),
    },
    alternative_supports=("surface", "wall"),
    mass_range=(0.05, 4),
    words="handbag tote purse shopping_bag bags paper_bag tote_bag",
    classes=Classes("bag", "bag", "bag", "handbag"),
    synsets=("02773838",),
    schemes=(
        scheme("bag_cloth", bag_cloth="handle", weight=2.0),
        scheme("hide", hide="handle"),
        scheme("cardboard", white_paper="cord", needs="sack", weight=100.0),
    ),
    construction=(
        row("sack", walls(0.3, 800), "common"),
        row("bag", filled(120), "common"),
        row(ANY, filled(300), "common"),
    ),
    placements=(
        on(
            "hook",
            "hallway closet bedroom living_room apartment office hotel kitchen classroom stairs",
            styles="hung",
            pose="hung",
            weight=0.6,
        ),
        on("floor_by_door floor_by_wall", styles="tote paper", weight=0.5),
        on("floor_under_desk floor_beside_sofa", styles="tote", weight=0.3, max_groups=1),
        on("chair_seat", styles="tote", clutter=2, weight=0.3, max_groups=1),
        on("worktop", "kitchen", styles="paper", clutter=3, weight=0.25, max_groups=1),
    ),
)
