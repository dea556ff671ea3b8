"""Plants: pots with soil, leaves, and those of window sills and corners."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.joinery.pieces import Parts, Size
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import sheet, tube
from openrooms_usd.geometry.vectors import points_at

_THICK: Final = 0.0014
# Leaves bend by this share of the plant's span, along waves of that share of it.
_SWAY_SHARE, _BENDS_SHARE = 0.028, 0.8
_PHASES: Final = np.array([0.4, 2.1, 4.0])


def potted(radius: float, height: float, rng: np.random.Generator, lift: float = 0.0) -> Parts:
    """A tapered pot with a rim, filled with soil almost to its edge."""
    low = float(rng.uniform(0.68, 0.86)) * radius
    wall = float(np.clip(0.06 * radius, 0.003, 0.012))
    edge = float(rng.choice([0.0, 0.16])) * height
    outer = [(low, 0.0), (low + 0.004, 0.006)]
    if edge:
        shoulder = 0.92 * radius
        outer += [(shoulder, height - edge), (radius, height - edge), (radius, height)]
    else:
        outer += [(radius, height)]
    soil = height - max(0.1 * height, 0.012)
    inside = [(radius - 1.2 * wall - 0.08 * radius * bool(edge), soil - 0.01), (0.0, soil - 0.01)]
    pot = lathe([(0.0, 0.0), *outer, (radius - wall, height), *inside], segments=40, crease=50.0)
    mound = 0.97 * inside[0][0]
    earth = lathe(
        [
            (0.0, soil - 0.014),
            (mound, soil - 0.014),
            (mound, soil - 0.002),
            (0.5 * mound, soil + 0.003),
            (0.0, soil + 0.005),
        ],
        segments=28,
    )
    move = (0.0, 0.0, lift)
    return {"pot": pot.moved(move), "soil": earth.moved(move)}


def _spine(long: float, bend: Array) -> tuple[Array, Array]:
    """X and z along a leaf that bends down by some angles on its way, radians."""
    step = long / (len(bend) - 1)
    ahead = np.concatenate([[0.0], np.cumsum(step * np.cos(bend[:-1]))])
    return ahead, -np.concatenate([[0.0], np.cumsum(step * np.sin(bend[:-1]))])


def pointed_leaf(
    long: float, wide: float, *, droop: float, fold: float, widest: float = 0.4, rows: int = 7
) -> Mesh:
    """A pointed leaf along +X from the origin, its upper side up.

    Args:
        long: Its length, metres.
        wide: Its greatest width, metres.
        droop: Degrees by which its tip hangs below its foot.
        fold: How far its sides rise above its midrib, in parts of their width.
        widest: Where along it that is, 0 to 1.
        rows: Points along it.
    """
    t = np.linspace(0.0, 1.0, rows)
    power = np.log(0.5) / np.log(widest)
    half = 0.5 * wide * np.sin(np.pi * np.clip(t, 0.012, 0.988) ** power)
    bend = np.radians(droop) * t
    x, z = _spine(long, bend)
    u = np.array([-1.0, 0.0, 1.0])
    grid = points_at(x[:, None], -half[:, None] * u, z[:, None] + fold * half[:, None] * np.abs(u))
    return sheet(grid[:, ::-1].transpose(1, 0, 2), _THICK)


def held(leaf: Mesh, pitch: float, heading: float, at: Array) -> Mesh:
    """A leaf raised by ``pitch`` and turned to ``heading`` (degrees), its foot at a point."""
    return turned(turned(leaf, "y", -pitch), "z", heading).moved(at)


def grown_over(parts: Parts, plant: dict[str, list[Mesh]], size: Size, pot: float) -> Parts:
    """Fit what grows into the box above the pot's rim, without touching the pot."""
    bent = {name: _bent(joined(meshes), size, pot) for name, meshes in plant.items()}
    low, high = joined(list(bent.values())).extent
    middle = 0.5 * (low + high)
    scale = np.array([size[0], size[1], size[2] - pot]) / [*(high - low)[:2], high[2] - pot]
    offset = np.array([-middle[0] * scale[0], -middle[1] * scale[1], pot * (1.0 - scale[2])])
    fit = np.column_stack([np.diag(scale), offset])
    # Stems are thin enough to keep their place in the soil.
    return {**parts, **{name: mesh.transformed(fit) for name, mesh in bent.items()}}


def _bent(mesh: Mesh, size: Size, pot: float) -> Mesh:
    """What grows, bent to and fro: the more the farther from the pot, leaf by leaf another way."""
    span = 0.5 * (size[0] + size[2] - pot)
    points = mesh.points.copy()
    away = np.linalg.norm(points - [0.0, 0.0, pot], axis=1) / span
    free = np.clip(away - 0.12, 0.0, 1.0)[:, None]
    phase = points[:, [1, 2, 0]] * (2.0 * np.pi / (_BENDS_SHARE * span))
    sway = np.sin(phase + _PHASES) + 0.5 * np.sin(2.3 * phase[:, [2, 0, 1]] + _PHASES[::-1])
    moved = points + _SWAY_SHARE * span * free * sway * [1.0, 1.0, 0.6]
    # Nothing sinks below where it was: it may lie around its pot.
    moved[:, 2] = np.where(points[:, 2] < 0.3 * size[2], points[:, 2], moved[:, 2])
    return with_normals(replace(mesh, points=moved), crease=60.0)


# How thick leaves are, metres.
_LEAF_M: Final = 0.0012


def succulent(size: Size, rng: np.random.Generator) -> Parts:
    """A rosette of thick leaves, steeper towards its middle."""
    width, depth, height = size
    radius = 0.5 * min(width, depth)
    rim = 0.58 * height
    pot = potted(0.8 * radius, rim, rng)
    leaves = []
    for i in range(26):
        share = i / 26.0
        long = 1.2 * radius * (1.0 - 0.72 * share)
        leaf = pointed_leaf(long, 0.46 * long, droop=-35.0, fold=0.35, widest=0.62, rows=5)
        foot = np.array([0.0, 0.0, rim - 0.004 + 0.05 * height * share])
        leaves.append(held(leaf, 12.0 + 66.0 * share, 137.5 * i + float(rng.uniform(-6, 6)), foot))
    return grown_over(pot, {"leaf": leaves}, size, rim)


def _split_leaf(long: float, wide: float, droop: float) -> Mesh:
    """A heart-shaped leaf along +X with slits to both sides."""
    rows = 17
    t = np.linspace(0.0, 1.0, rows)
    half = 0.5 * wide * np.sin(np.pi * np.clip(t, 0.02, 0.985) ** 0.62)
    half[0] = 0.12 * wide
    slits = (np.arange(rows) % 3 == 0) & (t > 0.25) & (t < 0.92)
    half = np.where(slits, 0.42 * half, half)
    bend = np.radians(droop) * t
    x, z = _spine(long, bend)
    u = np.array([-1.0, 0.0, 1.0])
    # Lobes sweep forward, towards the tip.
    ahead = 0.22 * half[:, None] * np.abs(u)
    grid = points_at(
        x[:, None] + ahead, -half[:, None] * u, z[:, None] + 0.12 * half[:, None] * np.abs(u)
    )
    return sheet(grid[:, ::-1].transpose(1, 0, 2), _LEAF_M)


def monstera(size: Size, rng: np.random.Generator) -> Parts:
    """Large split leaves on long stalks."""
    width, depth, height = size
    radius = 0.5 * min(width, depth)
    rim = min(0.3 * height, 0.8 * radius)
    pot = potted(min(0.5 * radius, rim), rim, rng)
    plant: dict[str, list[Mesh]] = {"stem": [], "leaf": []}
    count = int(rng.integers(9, 13))
    for i in range(count):
        heading = 137.5 * i + float(rng.uniform(-15, 15))
        rise = (height - rim) * (0.45 + 0.5 * (i / count)) * float(rng.uniform(0.85, 1.0))
        out = radius * float(rng.uniform(0.3, 0.6)) * (1.15 - 0.5 * i / count)
        t = np.linspace(0.0, 1.0, 6)
        a = np.radians(heading)
        away = 0.06 * radius + out * t**1.6
        path = points_at(away * np.cos(a), away * np.sin(a), rim - 0.02 + (rise + 0.02) * t**0.85)
        plant["stem"].append(tube(path, np.linspace(0.0055, 0.0032, 6).tolist(), segments=6))
        long = radius * float(rng.uniform(0.5, 0.7))
        leaf = _split_leaf(long, 0.85 * long, float(rng.uniform(35, 65)))
        foot = path[-1] - 0.06 * long * np.array([np.cos(a), np.sin(a), 0.0])
        plant["leaf"].append(held(leaf, float(rng.uniform(-5, 25)), heading, foot))
    return grown_over(pot, plant, size, rim)


def _frond(long: float, wide: float, droop: float) -> Mesh:
    """A feathered blade along +X: leaflets as teeth of one sheet."""
    rows = 19
    t = np.linspace(0.0, 1.0, rows)
    half = 0.5 * wide * np.sin(np.pi * np.clip(t, 0.03, 0.985) ** 0.7)
    half = np.where(np.arange(rows) % 2 == 1, half, 0.3 * half)
    bend = np.radians(droop) * t**1.3
    x, z = _spine(long, bend)
    u = np.array([-1.0, 0.0, 1.0])
    ahead = 0.5 * long / (rows - 1) * np.abs(u) * np.ones((rows, 1))
    grid = points_at(
        x[:, None] + ahead, -half[:, None] * u, z[:, None] + 0.15 * half[:, None] * np.abs(u)
    )
    return sheet(grid[:, ::-1].transpose(1, 0, 2), _LEAF_M)


def fern(size: Size, rng: np.random.Generator) -> Parts:
    """Arching feathered fronds all round."""
    width, depth, height = size
    radius = 0.5 * min(width, depth)
    rim = 0.4 * height
    pot = potted(min(0.42 * radius, rim), rim, rng)
    fronds = []
    count = int(rng.integers(20, 26))
    for i in range(count):
        share = i / count
        long = radius * (1.25 - 0.4 * share) * float(rng.uniform(0.85, 1.0))
        frond = _frond(long, 0.2 * radius, float(rng.uniform(75, 115)) - 45.0 * share)
        foot = np.array([0.0, 0.0, rim - 0.008])
        pitch = 28.0 + 50.0 * share
        fronds.append(held(frond, pitch, 137.5 * i + float(rng.uniform(-10, 10)), foot))
    return grown_over(pot, {"leaf": fronds}, size, rim)


def ivy(size: Size, rng: np.random.Generator) -> Parts:
    """Trails of small leaves that spill over the rim and lie around the pot."""
    width, depth, height = size
    radius = 0.5 * min(width, depth)
    rim = 0.62 * height
    base = 0.46 * radius
    pot = potted(base, rim, rng)
    plant: dict[str, list[Mesh]] = {"stem": [], "leaf": []}
    for k in range(9):
        heading = 360.0 * k / 9.0 + float(rng.uniform(-14, 14))
        a = np.radians(heading)
        reach = radius * (1.0 if k % 3 == 0 else float(rng.uniform(0.65, 0.92)))
        low = rim * (0.12 if k % 3 == 0 else float(rng.uniform(0.2, 0.75)))
        line = np.array(
            [
                (0.3 * base, rim - 0.01),
                (0.75 * base, height * 0.86),
                (1.12 * base, rim + 0.02),
                (0.5 * (base + reach), 0.5 * (rim + low)),
                (0.93 * reach, low),
            ]
        )
        t = np.linspace(0.0, 4.0, 10)
        away, z = (np.interp(t, np.arange(5), line[:, j]) for j in (0, 1))
        sway = 0.05 * radius * np.sin(2.0 * t + k)
        path = points_at(
            away * np.cos(a) - sway * np.sin(a), away * np.sin(a) + sway * np.cos(a), z
        )
        plant["stem"].append(tube(path, 0.0012, segments=5))
        for i, at in enumerate(path[1:]):
            long = float(rng.uniform(0.16, 0.24)) * radius
            # Near the ground leaves lie flatter.
            high = at[2] > 0.4 * rim
            droop, pitch = (40.0, rng.uniform(-20, 35)) if high else (15.0, rng.uniform(8, 35))
            leaf = pointed_leaf(long, 0.85 * long, droop=droop, fold=0.2, widest=0.36, rows=4)
            side = heading + (-1.0) ** i * float(rng.uniform(30, 80))
            plant["leaf"].append(held(leaf, float(pitch), side, at))
    return grown_over(pot, plant, size, 0.0)
