"""Cloth that lies, hangs and is rolled: towels, blankets, napkins, as sheets of some thickness."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.joinery.cloth import ripples
from openrooms_usd.furniture.joinery.pieces import Size
from openrooms_usd.furniture.placements import DRAPED_WALL_M, LOOP_BACK_M, LOOP_M, LOOP_RISE_M
from openrooms_usd.geometry.lofts import loft
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.normals import with_normals
from openrooms_usd.geometry.sweeps import sheet, tube
from openrooms_usd.geometry.uv import metric
from openrooms_usd.geometry.vectors import points_at, unit

# The share of a roll's height by which it is pressed flat below.
_PRESSED: Final = 0.06


def between(front: Array, back: Array) -> Mesh:
    """The solid between two grids of points (R, C, 3), the first seen as in `sweeps.sheet`."""
    plain = sheet(front, 0.001)
    points = np.concatenate([front.reshape(-1, 3), back.reshape(-1, 3)])
    return metric(with_normals(replace(plain, points=points), crease=60.0))[0]


def boxed(mesh: Mesh, size: Size) -> Mesh:
    """A mesh stretched to its box, its base on the ground."""
    low, high = mesh.extent
    scale = np.asarray(size) / (high - low)
    middle = np.array([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]])
    placed = replace(mesh, points=(mesh.points - middle) * scale)
    return metric(with_normals(placed, crease=60.0))[0]


def _along(line: Array, thick: float, x: Array) -> tuple[Array, Array]:
    """Two grids, a sheet's thickness apart, about a line (R, 2) in Y and Z, drawn out along X."""
    side = np.gradient(line, axis=0)
    normal = unit(points_at(-side[:, 1], side[:, 0]))
    left, right = line + 0.5 * thick * normal, line - 0.5 * thick * normal
    grids = [points_at(x, edge[:, :1], edge[:, 1:]) for edge in (left, right)]
    return grids[0], grids[1]


def folded_pile(size: Size, layers: int, rng: np.random.Generator) -> Mesh:
    """A cloth folded in ``layers``, its folds to the front and the back, lying flat."""
    width, depth, height = size
    pitch = height / layers
    thick, reach = 0.94 * pitch, 0.5 * (depth - pitch)
    line: list[tuple[float, float]] = []
    for k in range(layers):
        side = 1.0 if k % 2 else -1.0
        z = (k + 0.5) * pitch
        inner = 0.96 if k == layers - 1 else 1.0
        ends = np.linspace(-side * reach, side * reach * inner, 5)
        line += [(-float(y), z) for y in ends]
        if k < layers - 1:
            turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 5)[1:-1]
            line += [
                (-side * (reach + 0.5 * pitch * np.cos(a)), z + 0.5 * pitch * (1 + np.sin(a)))
                for a in turn.tolist()
            ]
    x = np.linspace(-0.5 * width, 0.5 * width, 7)
    front, back = _along(np.array(line), thick, x)
    sag = 1.0 - 0.07 * (0.5 + 0.5 * ripples(front[..., 0], front[..., 1], 0.3, rng))
    bow = 1.0 + 0.01 * ripples(front[..., 0], front[..., 2], 0.2, rng)
    made = [
        points_at(grid[..., 0], grid[..., 1] * bow, grid[..., 2] * sag) for grid in (front, back)
    ]
    return boxed(between(made[1][:, ::-1], made[0][:, ::-1]), size)


def rolled(size: Size, rng: np.random.Generator, columns: int = 3) -> Mesh:
    """A cloth rolled up along X, of so many columns of points."""
    width, depth, height = size
    turns = 3.25
    angle = np.linspace(0.0, 2.0 * np.pi * turns, 44)
    thick = 0.5 * height / (turns + 0.6) * 0.92
    radius = 0.6 * thick + (0.5 * height - 1.1 * thick) * angle / angle[-1]
    start = float(rng.uniform(0.0, 2.0 * np.pi))
    # The loose end lies at the back, below the middle.
    a = angle - angle[-1] - 0.1 * start
    line = points_at(radius * np.cos(a) * depth / height, 0.5 * height + radius * np.sin(a))
    x = np.linspace(-0.5 * width, 0.5 * width, columns)
    front, back = _along(line, thick, x)
    # Its weight presses it flat where it lies.
    flat = min(front[..., 2].min(), back[..., 2].min()) + _PRESSED * height
    for side in (front, back):
        np.maximum(side[..., 2], flat, out=side[..., 2])
    return boxed(between(back[:, ::-1], front[:, ::-1]), size)


def over_bar(size: Size, rng: np.random.Generator) -> Mesh:
    """A cloth over an edge along X: the longer flap to the front, all folds on the outside.

    The space that it hangs over is free and flat: twice `DRAPED_WALL_M` less deep than the box.
    """
    width, depth, height = size
    half, wall = 0.5 * depth - DRAPED_WALL_M, DRAPED_WALL_M
    top, hem = height - wall, 0.4 * height
    arc = np.radians([0.0, 45.0, 90.0, 135.0, 180.0])
    round_ = min(half, 0.01)
    corner = points_at(-np.cos(arc), np.sin(arc)) * round_
    spread = np.where(np.arange(5) < 2, -1.0, np.where(np.arange(5) > 2, 1.0, 0.0))
    ridge = corner + points_at(spread * (half - round_), top - round_)
    front = points_at(-half, np.linspace(0.0, top - round_, 7))[:-1]
    rear = points_at(half, np.linspace(top - round_, hem, 6))[1:]
    inner = np.concatenate([front, ridge, rear])
    out = np.concatenate(
        [
            np.tile([[-1.0, 0.0]], (len(front), 1)),
            points_at(-np.cos(arc), np.sin(arc)),
            np.tile([[1.0, 0.0]], (len(rear), 1)),
        ]
    )
    x = np.linspace(-0.5 * width, 0.5 * width, 15)
    low = np.concatenate([1.0 - front[:, 1] / top, np.zeros(5), np.linspace(0.2, 1.0, len(rear))])
    share = []
    for side in (slice(0, len(front) + 3), slice(len(front) + 3, len(inner))):
        wave = 0.5 + 0.7 * ripples(
            x[None, :] + 0.0 * low[side, None], 0.1 * low[side, None], 0.12, rng
        )
        depth_of = 0.3 + 0.7 * low[side, None] ** 0.4 * np.clip(wave, 0.0, 1.0)
        share.append(depth_of / depth_of.max())
    thick = np.clip(np.concatenate(share), 0.2, 1.0) * wall
    thick[len(front) + 2] = wall
    base = np.insert(np.broadcast_to(inner[:, None], (len(inner), 15, 2)), 0, x, axis=2)
    for row in (0, -1):
        hang = ripples(x, 0.0 * x + row, 0.25, rng)
        base[row, :, 2] += 0.012 * (hang - hang.min())
    away = np.insert(np.broadcast_to(out[:, None], (len(out), 15, 2)), 0, 0.0, axis=2)
    return between(base + thick[..., None] * away, base)


def hung_cloth(size: Size, rng: np.random.Generator, folds: int = 5) -> Mesh:
    """A cloth that hangs from one point at its top, its back to the wall."""
    height = size[2]
    count = 12 * folds // 2
    angle = 2.0 * np.pi * np.arange(count) / count
    phase = rng.uniform(0.0, 2.0 * np.pi, 2)
    rings = []
    for share in (1.0, 0.985, 0.93, 0.8, 0.55, 0.3, 0.1, 0.0):
        fall = 1.0 - share
        wide = 0.14 + 0.86 * fall**0.38
        wave = min(1.0, 3.0 * fall) * (
            0.16 * np.cos(folds * angle + phase[0] + 0.8 * fall)
            + 0.07 * np.cos((folds + 2) * angle + phase[1])
        )
        r = wide * (1.0 + wave) / 1.2
        hem = 0.03 * height * np.cos(2.0 * angle + phase[1]) * fall**3 * (share < 0.2)
        rings.append((r * np.cos(angle), r * np.sin(angle), share * height + hem))
    inside = 0.02
    rings += [
        (0.5 * rings[-1][0], 0.5 * rings[-1][1], np.full(count, inside * height + 0.03)),
        (0.03 * np.cos(angle), 0.03 * np.sin(angle), np.full(count, inside * height + 0.06)),
    ]
    points = np.array([np.stack(ring, axis=1) for ring in rings])
    shell = backed(points[:-2])
    hem = np.concatenate([shell, points[-2:] + (shell[-1] - points[-3])])
    return boxed(loft(hem[::-1], crease=70.0), size)


def backed(rings: Array) -> Array:
    """Rings (R, N, 3) moved so that all touch one plane with their backs, as at a wall."""
    moved = rings.copy()
    moved[..., 1] -= rings[..., 1].max(axis=1, keepdims=True)
    return moved


def with_loop(build: Callable[[Size], Mesh], size: Size) -> Mesh:
    """What hangs on a hook: a body with a flat back, and a loop of tape on its top."""
    width, depth, height = size
    body = build((width, depth, height - LOOP_RISE_M - LOOP_M))
    r = 0.5 * LOOP_M
    half, y, top = 0.009, 0.5 * depth - LOOP_BACK_M, height - r
    t = np.radians([180.0, 135.0, 90.0, 45.0, 0.0])
    arch = points_at(half * np.cos(t), y, top - half * (1.0 - np.sin(t)))
    low = height - LOOP_RISE_M - LOOP_M - 0.03
    path = np.array([(-half, y, low), *arch, (half, y, low)])
    return joined([body, tube(path, r, segments=8)])
