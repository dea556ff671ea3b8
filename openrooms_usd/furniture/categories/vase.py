"""Vases: with flowers, with dry grasses, and empty ones."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.construction import ANY, filled, row, walls
from openrooms_usd.furniture.joinery.foliage import held, pointed_leaf
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.furniture.joinery.vessel import hollow, smooth_line
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import WIDE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.uv import metric
from openrooms_usd.geometry.vectors import unit

_SHAPES: Final = (
    ((0.7, 0.0), (0.95, 0.25), (1.0, 0.5), (0.62, 0.82), (0.5, 0.93), (0.62, 1.0)),
    ((0.62, 0.0), (0.72, 0.2), (0.8, 0.6), (0.94, 0.9), (1.0, 1.0)),
    ((0.5, 0.0), (0.85, 0.15), (1.0, 0.32), (0.75, 0.58), (0.36, 0.75), (0.34, 0.92), (0.44, 1.0)),
    ((0.85, 0.0), (1.0, 0.05), (0.98, 0.6), (0.88, 0.85), (0.8, 1.0)),
)

# Radius and height of blossoms, in parts of their height.
_TULIP: Final = (
    (0.0, 0.0),
    (0.55, 0.1),
    (0.7, 0.5),
    (0.5, 0.9),
    (0.3, 1.0),
    (0.34, 0.7),
    (0.0, 0.4),
)
_ROUND: Final = ((0.0, 0.15), (0.4, 0.2), (0.75, 0.45), (0.68, 0.8), (0.35, 1.0), (0.0, 0.95))


def _body(r: float, h: float, rng: np.random.Generator, narrow: bool) -> Mesh:
    shape = _SHAPES[2 if narrow else int(rng.integers(len(_SHAPES)))]
    line = smooth_line([(a * r, z * h) for a, z in shape], 14)
    peak = max(a for a, _ in line)
    return hollow([(a * r / peak, z) for a, z in line], 0.0035, 0.06 * h, 0.0, 32)


def empty(size: Size, rng: np.random.Generator) -> Parts:
    """A vase with nothing in it."""
    return {"vase": _body(0.5 * min(size[0], size[1]), size[2], rng, narrow=False)}


def _stalks(size: Size, r: float, tall: float, count: int, rng: np.random.Generator) -> list[Array]:
    """Paths of stalks from inside a vase to points spread within the top of the box."""
    width, depth, height = size
    found = []
    for k in range(count):
        a = 2.0 * np.pi * k / count + float(rng.uniform(-0.25, 0.25))
        out = 0.0 if k == 0 else float(rng.uniform(0.55, 1.0))
        # The outermost reach the sides of the box.
        out = 1.0 if k in (1, 1 + count // 2) else out
        a = 0.0 if k == 1 else np.pi if k == 1 + count // 2 else a
        top = height * (1.0 if k == 0 else float(rng.uniform(0.8, 0.97)))
        end = np.array([0.5 * width * out * np.cos(a), 0.5 * depth * out * np.sin(a)])
        t = np.linspace(0.0, 1.0, 6)
        way = np.interp(t, [0.0, tall / top, 1.0], [0.0, 0.0, 1.0])[:, None] ** 1.3 * end
        foot = 0.4 * r * np.array([np.cos(a), np.sin(a)]) * (1.0 - t[:, None])
        found.append(np.column_stack([way - 0.5 * foot, 0.1 * tall + (top - 0.1 * tall) * t]))
    return found


def flowers(size: Size, rng: np.random.Generator) -> Parts:
    """A bunch of tulips or of round blossoms."""
    width, depth, height = size
    r, tall = 0.27 * min(width, depth), 0.5 * height
    bud = 0.075 * height
    inner = (width - 1.4 * bud, depth - 1.4 * bud, height - bud)
    stems: list[Mesh] = []
    heads: list[Mesh] = []
    leaves: list[Mesh] = []
    tulip = bool(rng.integers(2))
    profile = _TULIP if tulip else _ROUND
    for k, path in enumerate(_stalks(inner, r, tall, 9, rng)):
        stems.append(tube(path, 0.0021, segments=6))
        along = unit((path[-1] - path[-2])[None])[0]
        lean = float(np.degrees(np.arccos(np.clip(along[2], -1.0, 1.0))))
        heading = float(np.degrees(np.arctan2(along[1], along[0])))
        head = lathe([(a * bud, z * bud) for a, z in profile], segments=10, crease=60.0)
        posed = turned(turned(head, "y", lean), "z", heading)
        heads.append(posed.moved(path[-1]))
        if k % 2:
            leaf = pointed_leaf(0.3 * height, 0.05 * height, droop=40.0, fold=0.4, rows=5)
            leaves.append(held(leaf, 65.0, heading + 40.0, path[2]))
    whole = {
        "vase": _body(r, tall, rng, narrow=False),
        "stem": joined(stems),
        "petal": joined(heads),
        "leaf": joined(leaves),
    }
    return _stretch_plant(whole, size)


def _stretch_plant(parts: Parts, size: Size) -> Parts:
    """What grows out of the vase, stretched over the box; the vase as it is."""
    grown = joined([mesh for name, mesh in parts.items() if name != "vase"])
    low, high = grown.extent
    scale = np.array([size[0], size[1], size[2]]) / [*(high - low)[:2], high[2]]
    middle = 0.5 * (low + high)
    fit = np.column_stack([np.diag(scale), [-middle[0] * scale[0], -middle[1] * scale[1], 0.0]])
    stretched = {name: metric(mesh.transformed(fit))[0] for name, mesh in parts.items()}
    return {**stretched, "vase": parts["vase"]}


def grasses(size: Size, rng: np.random.Generator) -> Parts:
    """Dry grasses with feathery heads in a slim vase."""
    width, depth, height = size
    r, tall = 0.24 * min(width, depth), 0.4 * height
    stems: list[Mesh] = []
    heads: list[Mesh] = []
    for path in _stalks((0.8 * width, 0.8 * depth, 0.84 * height), 0.3 * r, tall, 8, rng):
        stems.append(tube(path, 0.0014, segments=5))
        along = unit((path[-1] - path[-2])[None])[0]
        t = np.linspace(0.0, 1.0, 7)
        droop = np.stack([along[0] * t, along[1] * t, along[2] * t - 0.25 * t**2], axis=1)
        plume = path[-1] + 0.2 * height * droop
        thick = 0.016 * np.sin(np.pi * np.clip(t, 0.06, 0.96)) ** 0.7 + 0.001
        heads.append(tube(plume, thick.tolist(), segments=7))
    whole = {
        "vase": _body(r, tall, rng, narrow=True),
        "stalk": joined(stems),
        "plume": joined(heads),
    }
    return _stretch_plant(whole, size)


CATEGORY: Final = BuiltCategory(
    description="a vase, also with flowers",
    size=(0.14, 0.14, 0.25),
    min_size=(0.05, 0.05, 0.08),
    max_size=(0.9, 0.9, 1.4),
    styles={
        "empty": Style(empty, lambda size: size[0] < 0.35),
        "flowers": Style(flowers, lambda size: size[2] < 3.0 * size[0], (0.28, 0.28, 0.42)),
        "grasses": Style(grasses, lambda size: size[2] > 1.4 * size[0], (0.34, 0.34, 0.72)),
    },
    size_variation=WIDE,
    round=True,
    support="surface",
    mass_range=(0.2, 4),
    words="vases flower_vase bouquet flower_arrangement",
    classes=Classes("jar", "otherprop", "vase", "vase"),
    schemes=(
        scheme("glaze", petal="petal", dried_grass="stalk plume", weight=2.0),
        scheme("terracotta", petal="petal", dried_grass="stalk plume"),
    ),
    construction=(
        row("vase", walls(3.5), "common", "specular_stone", "rough_stone"),
        row(ANY, filled(300), "common"),
    ),
    placements=(
        on("dining_table coffee_table", styles="flowers", weight=0.5, max_groups=1, pose="flat"),
        on("cabinet_top dresser_top mantel side_table media_top", weight=0.5, pose="flat"),
        on("shelf window_sill", styles="empty", weight=0.4, pose="flat"),
        on("bedside worktop", styles="flowers", weight=0.15, max_groups=1, pose="flat"),
    ),
)
