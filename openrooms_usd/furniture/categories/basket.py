"""Baskets: of coiled rope, of woven strips, of wooden slats."""

from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board, corners
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import hoop, oval
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import WIDE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted, lengths, rectangle
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.vectors import unit


def basket_rope(size: Size, rng: np.random.Generator) -> Parts:
    """A soft basket of coiled rope with two loops."""
    loop = min(0.05, 0.14 * size[2])
    r, h = 0.5 * min(size[0], size[1]), size[2] - loop
    thick = float(np.clip(0.03 * h + 0.003, 0.005, 0.011))
    count = max(6, round(h / (1.8 * thick)))
    z = np.linspace(thick, h - thick, count)
    belly = float(rng.uniform(0.04, 0.1))
    shape = (r - thick) * (1.0 - belly * (2.0 * z / h - 0.9) ** 2)
    shape *= (r - thick) / shape.max()
    coils = [hoop(float(a), float(b), thick, 32) for a, b in zip(shape, z, strict=True)]
    floor = cylinder(float(shape[0]), 1.6 * thick)
    arch = [
        (-0.055, 0.0, -0.02),
        (-0.055, 0.0, loop - thick),
        (0.055, 0.0, loop - thick),
        (0.055, 0.0, -0.02),
    ]
    grip = tube(arch, thick, bend=0.03, segments=8)
    grips = [grip.moved((0.0, side * float(shape[-1]), h)) for side in (-1.0, 1.0)]
    return {
        "container": oval(joined([*coils, floor]), size),
        **numbered(
            "handle",
            [mesh.transformed(np.diag([1.0, size[1] / min(size[:2]), 1.0])) for mesh in grips],
        ),
    }


def basket_woven(size: Size, rng: np.random.Generator) -> Parts:
    """A rectangular basket: strips woven around stakes, a thick rim."""
    width, depth, h = size
    strip, rim = 0.0045, 0.009
    rows = max(6, round(h / 0.022))
    pitch = (h - 2.0 * rim) / rows
    outline = filleted(rectangle(width - 2 * rim, depth - 2 * rim), 0.045, closed=True)
    around = _dense(outline, 0.022)
    side = np.roll(around, -1, axis=0) - np.roll(around, 1, axis=0)
    normal = unit(np.stack([side[:, 1], -side[:, 0]], axis=1))
    slope = float(rng.uniform(0.86, 0.93))
    weave = []
    for k in range(rows):
        z = rim + (k + 0.5) * pitch
        wave = np.where((np.arange(len(around)) + k) % 2 == 0, 1.0, -1.0)[:, None] * 0.6 * strip
        scale = slope + (1.0 - slope) * z / h
        path = np.column_stack([scale * (around + wave * normal), np.full(len(around), z)])
        ring = tube(path, strip, segments=4, closed=True)
        weave.append(_flat(ring, z, 0.5 * pitch / strip * 1.05))
    rims = [
        tube(
            np.column_stack([(outline if z > rim else slope * outline), np.full(len(outline), z)]),
            rim,
            segments=8,
            closed=True,
        )
        for z in (rim, h - rim)
    ]
    x, y = 0.5 * slope * width - rim, 0.5 * slope * depth - rim
    floor = board((-x, -y, 0.004), (x, y, 0.012))
    return {"container": joined([*weave, floor]), "frame": joined(rims)}


def _dense(outline: Array, step: float) -> Array:
    """An even number of points about ``step`` apart on a closed outline."""
    closed = np.concatenate([outline, outline[:1]])
    run = lengths(closed)
    count = 2 * max(4, round(float(run[-1]) / (2.0 * step)))
    at = run[-1] * np.arange(count) / count
    return np.stack([np.interp(at, run, closed[:, 0]), np.interp(at, run, closed[:, 1])], axis=1)


def _flat(ring: Mesh, z: float, factor: float) -> Mesh:
    """A strip stretched upwards about its own height."""
    matrix = np.eye(4)
    matrix[2, 2], matrix[2, 3] = factor, z * (1.0 - factor)
    return ring.transformed(matrix)


def basket_crate(size: Size, rng: np.random.Generator) -> Parts:
    """A wooden crate of slats with holes to carry it."""
    width, depth, h = size
    t, x, y = 0.011, 0.5 * width, 0.5 * depth
    count = max(2, round(h / float(rng.uniform(0.085, 0.11))))
    gap = 0.16 * h / count
    tall = (h - gap * (count - 1)) / count
    slats: list[Mesh] = []
    for k in range(count):
        a = k * (tall + gap)
        slats += [
            board((-x, s * y - (t if s > 0 else 0), a), (x, s * y + (0 if s > 0 else t), a + tall))
            for s in (-1, 1)
        ]
        ends = (
            [(-y + t, y - t)] if k < count - 1 else [(-y + t, -0.28 * depth), (0.28 * depth, y - t)]
        )
        slats += [
            board((s * x - (t if s > 0 else 0), c, a), (s * x + (0 if s > 0 else t), d, a + tall))
            for s in (-1, 1)
            for c, d in ends
        ]
    grip = 0.3 * tall
    slats += [
        board(
            (s * x - (t if s > 0 else 0), -0.29 * depth, h - grip),
            (s * x + (0 if s > 0 else t), 0.29 * depth, h),
        )
        for s in (-1, 1)
    ]
    posts = [
        board((px - 0.011, py - 0.011, 0.002), (px + 0.011, py + 0.011, h - 0.004))
        for px, py in corners(x - t - 0.011, y - t - 0.011)
    ]
    planks = max(3, round(depth / 0.09))
    edges = np.linspace(-y + t, y - t, planks + 1)
    floor = [
        board((-x + t, a + 0.002, 0.003), (x - t, b - 0.002, 0.012))
        for a, b in pairwise(edges.tolist())
    ]
    return {"container": joined(slats), "frame": joined(posts), "base": joined(floor)}


CATEGORY: Final = BuiltCategory(
    description="a basket to put things in",
    size=(0.42, 0.3, 0.24),
    min_size=(0.16, 0.14, 0.1),
    max_size=(1.0, 0.8, 0.9),
    styles={
        "rope": Style(basket_rope, size=(0.38, 0.38, 0.34)),
        "woven": Style(basket_woven),
        "crate": Style(basket_crate),
    },
    size_variation=WIDE,
    alternative_supports=("surface",),
    mass_range=(0.4, 3),
    words="laundry_basket hamper laundry_hamper storage_basket clothes_basket clothes_hamper "
    "storage_bin plastic_bin laundry_bin",
    classes=Classes("basket", "otherprop", "basket"),
    synsets=("02801938",),
    schemes=(scheme("rope", rope="handle"), scheme("wood", needs="base", weight=100.0)),
    construction=(row(ANY, filled(250), "weight", "fabric"),),
    placements=(
        on("low_shelf wardrobe_shelf appliance_top", weight=0.8),
        on("shelf cabinet_top", weight=0.3),
        on("floor_corner floor_by_wall floor_beside_sofa", weight=0.7, max_groups=1),
    ),
    offers_surfaces=("in_basket",),
    view_importance=0.0,
)
