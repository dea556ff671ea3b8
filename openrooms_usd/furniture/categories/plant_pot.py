"""Plants in pots: broad leaves, swords, a palm, a cactus, succulents, a fern, an ivy."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row, solid
from openrooms_usd.furniture.joinery.foliage import (
    fern,
    grown_over,
    held,
    ivy,
    monstera,
    pointed_leaf,
    potted,
    succulent,
)
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import WIDE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.vectors import points_at


def leafy(size: Size, rng: np.random.Generator) -> Parts:
    """A rubber plant: a few woody stems with broad leaves in a spiral."""
    width, depth, height = size
    radius = 0.5 * min(width, depth)
    rim = min(0.28 * height, 1.3 * radius)
    pot = potted(min(0.62 * radius, rim), rim, rng)
    tall = 0.9 * (height - rim)
    plant: dict[str, list[Mesh]] = {"stem": [], "leaf": []}
    for k in range(int(rng.integers(2, 4))):
        heading, lean = float(rng.uniform(0, 2 * np.pi)), float(rng.uniform(0.02, 0.22)) * radius
        reach = tall * float(rng.uniform(0.75, 1.0)) if k else tall
        t = np.linspace(0.0, 1.0, 6)[:, None]
        foot = 0.18 * radius * np.array([np.cos(heading), np.sin(heading)])
        way = foot * (1.0 - t) + (foot + lean * np.array([np.cos(heading), np.sin(heading)])) * t**2
        stem = np.column_stack([way, rim - 0.03 * height + (reach + 0.03 * height) * t])
        plant["stem"].append(tube(stem, np.linspace(0.008, 0.004, 6).tolist(), segments=8))
        count = int(np.clip(round(reach / 0.042), 9, 20))
        for i in range(count):
            share = 0.16 + 0.84 * (i + 0.5) / count
            at = np.array([np.interp(share, t[:, 0], stem[:, j]) for j in range(3)])
            long = radius * float(rng.uniform(0.62, 0.9)) * (1.1 - 0.45 * share)
            leaf = pointed_leaf(long, 0.5 * long, droop=float(rng.uniform(20, 60)), fold=0.18)
            plant["leaf"].append(
                held(
                    leaf,
                    18.0 + 45.0 * share,
                    137.5 * i + 40.0 * k + float(rng.uniform(-15, 15)),
                    at,
                )
            )
    return grown_over(pot, plant, size, rim)


def swords(size: Size, rng: np.random.Generator) -> Parts:
    """A snake plant: stiff upright blades."""
    width, depth, height = size
    radius = 0.5 * min(width, depth)
    rim = min(0.34 * height, 1.5 * radius)
    base = min(0.95 * radius, rim)
    pot = potted(base, rim, rng)
    blades = []
    for i in range(int(rng.integers(11, 17))):
        away = 0.62 * base * np.sqrt((i + 0.5) / 16.0)
        heading = np.radians(137.5 * i)
        long = (height - rim) * float(rng.uniform(0.62, 1.0)) * (1.05 - 0.4 * away / base)
        wide = float(rng.uniform(0.1, 0.14)) * (height - rim)
        blade = pointed_leaf(long, wide, droop=-4.0, fold=0.35, widest=0.45, rows=8)
        at = np.array([away * np.cos(heading), away * np.sin(heading), rim - 0.02])
        tilt = 86.0 - 16.0 * away / base
        spun = turned(blade, "x", float(rng.uniform(-80, 80)))
        blades.append(held(spun, tilt, float(np.degrees(heading)), at))
    # Blades widen the box only above the pot.
    return grown_over(pot, {"leaf": blades}, size, rim)


def palm(size: Size, rng: np.random.Generator) -> Parts:
    """A palm: arching fronds with leaflets on both sides."""
    width, depth, height = size
    radius = 0.5 * min(width, depth)
    rim = min(0.24 * height, 0.9 * radius)
    pot = potted(min(0.5 * radius, rim), rim, rng)
    plant: dict[str, list[Mesh]] = {"stem": [], "leaf": []}
    count = int(rng.integers(9, 12))
    for i in range(count):
        heading = 137.5 * i + float(rng.uniform(-12, 12))
        rise = float(rng.uniform(0.7, 1.0)) * (height - rim) * (1.0 - 0.35 * i / count)
        out = radius * (0.45 + 0.55 * i / count)
        t = np.linspace(0.0, 1.0, 9)
        arch = points_at(
            0.03 * radius + out * t**1.8, 0.0, rim - 0.02 + rise * (1.55 * t - 0.55 * t**2.6)
        )
        frond = [tube(arch, np.linspace(0.006, 0.0018, 9).tolist(), segments=6)]
        plant["stem"] += [turned(mesh, "z", heading) for mesh in frond]
        for s in np.linspace(0.42, 0.97, 8).tolist():
            at = np.array([np.interp(s, t, arch[:, j]) for j in range(3)])
            long = radius * (0.5 - 1.2 * (s - 0.6) ** 2)
            for side in (-1.0, 1.0):
                wide = 0.06 * radius + 0.006
                leaf = pointed_leaf(max(long, 0.1 * radius), wide, droop=38.0, fold=0.3, rows=4)
                spread = side * (62.0 - 30.0 * s) + float(rng.uniform(-6, 6))
                posed = held(leaf, 22.0, spread, at)
                plant["leaf"].append(turned(posed, "z", heading))
    return grown_over(pot, plant, size, rim)


def cactus(size: Size, rng: np.random.Generator) -> Parts:
    """A ribbed column with an arm, on pebbles."""
    width, depth, height = size
    radius = 0.5 * min(width, depth)
    rim = min(0.36 * height, 1.1 * radius)
    pot = potted(radius, rim, rng)
    ribs = int(rng.integers(8, 12))
    thick = 0.42 * radius
    column = _ribbed(thick, height - rim + 0.03, ribs).moved((0.0, 0.0, rim - 0.03))
    arms = []
    for side in (1.0, -1.0)[: int(rng.integers(1, 3))]:
        z = rim + float(rng.uniform(0.2, 0.36)) * (height - rim)
        arm = 0.55 * thick
        path = [
            (0.5 * thick * side, 0.0, z),
            (side * (thick + 0.55 * arm), 0.0, z + 0.2 * arm),
            (side * (thick + arm), 0.0, z + 1.3 * arm),
        ]
        tall = float(rng.uniform(0.2, 0.3)) * (height - rim)
        arms.append(tube(path, 0.62 * arm))
        tip = _ribbed(0.72 * arm, tall, 8).moved((side * (thick + arm), 0.0, z + 0.9 * arm))
        arms.append(tip)
    pebbles = [
        cylinder(
            0.05 * radius,
            0.04 * radius,
            bevel=0.018 * radius,
            segments=7,
            base=(0.72 * radius * np.cos(a), 0.72 * radius * np.sin(a), rim - 0.1 * rim - 0.012),
        )
        for a in rng.uniform(0.0, 2.0 * np.pi, 14).tolist()
    ]
    return {**pot, "plant": joined([column, *arms]), **numbered("stone", [joined(pebbles)])}


def _ribbed(radius: float, height: float, ribs: int) -> Mesh:
    """A round-headed column whose radius follows its ribs."""
    t = np.linspace(0.0, 0.5 * np.pi, 7)
    shape = [(0.9 * radius, 0.0), (radius, 0.5 * height)]
    head = points_at(radius * np.cos(t), height - radius + radius * np.sin(t))
    head[-1, 0] = 0.0
    plain = lathe([(0.0, 0.0), *shape, *head], segments=4 * ribs, crease=60.0)
    around = np.arctan2(plain.points[:, 1], plain.points[:, 0])
    scale = 0.9 + 0.1 * np.cos(ribs * around)
    points = plain.points * np.column_stack([scale, scale, np.ones(len(scale))])
    return with_normals(replace(plain, points=points), crease=50.0)


CATEGORY: Final = BuiltCategory(
    description="a plant in a pot",
    size=(0.5, 0.5, 0.9),
    min_size=(0.06, 0.06, 0.06),
    max_size=(1.6, 1.6, 2.6),
    styles={
        "leafy": Style(leafy),
        "swords": Style(swords, size=(0.34, 0.34, 0.72)),
        "palm": Style(palm, lambda size: size[2] > 0.6, (0.9, 0.9, 1.4)),
        "cactus": Style(cactus, lambda size: size[2] < 0.7, (0.15, 0.15, 0.28)),
        "succulent": Style(
            succulent, lambda size: size[2] < 0.25, (0.13, 0.13, 0.115), mass_range=(0.1, 2)
        ),
        "monstera": Style(monstera, lambda size: size[2] > 0.4, (0.75, 0.75, 0.85)),
        "fern": Style(fern, lambda size: size[2] < 0.9, (0.55, 0.55, 0.45)),
        "ivy": Style(ivy, lambda size: size[2] < 0.4, (0.3, 0.3, 0.17), mass_range=(0.3, 6)),
        "small_cactus": Style(
            cactus, lambda size: size[0] < 0.13, (0.085, 0.085, 0.15), mass_range=(0.1, 2)
        ),
        "small_succulent": Style(
            succulent, lambda size: size[0] < 0.13, (0.09, 0.09, 0.085), mass_range=(0.1, 2)
        ),
    },
    size_variation=WIDE,
    round=True,
    mass_range=(0.5, 60),
    words="plant plants flowerpot flower_pot potted_plant houseplant flower flowers tree",
    classes=Classes("flowerpot", "otherprop", "plant", "potted_plant"),
    synsets=("03991062",),
    schemes=(scheme("glaze", pebble="stone", weight=2.0), scheme("terracotta", pebble="stone")),
    construction=(
        row(f"pot {ANY}", filled(900), "weight"),
        row("soil", solid(1200), "common"),
        row("plant leaf stem", solid(800), "common"),
    ),
    collision_softness=0.05,
    placements=(
        on(
            "shelf cabinet_top dresser_top mantel media_top side_table",
            styles="cactus succulent ivy fern",
            weight=0.7,
            max_variants=3,
        ),
        on("desk coffee_table dining_table worktop basin_edge", styles="cactus", weight=0.3),
        on(
            "window_sill",
            styles="small_cactus small_succulent",
            weight=1.6,
            count=(1, 2),
            pose="flat",
            max_variants=4,
            max_groups=6,
        ),
        on(
            "floor_corner floor_by_wall",
            styles="leafy swords palm monstera fern",
            weight=0.8,
            max_variants=3,
        ),
    ),
    view_importance=0.3,
)
