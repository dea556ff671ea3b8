"""Pots with soil, and leaves: what all plants of the library are made of."""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.furniture.joinery.boards import Parts, Size
from openrooms_usd.furniture.joinery.posing import turned
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.solids import lathe
from openrooms_usd.geometry.sweeps import sheet

Array = NDArray[np.float64]

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
    step = long / (rows - 1)
    x = np.concatenate([[0.0], np.cumsum(step * np.cos(bend[:-1]))])
    z = -np.concatenate([[0.0], np.cumsum(step * np.sin(bend[:-1]))])
    u = np.array([-1.0, 0.0, 1.0])
    grid = np.stack(
        [
            np.broadcast_to(x[:, None], (rows, 3)),
            -half[:, None] * u,
            z[:, None] + fold * half[:, None] * np.abs(u),
        ],
        axis=-1,
    )
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
