"""Parts whose texture coordinates can carry a picture of their own: its texels in the room."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.appearance.places import Places
from openrooms_usd.arrays import Array
from openrooms_usd.arrays import Ints as Rows
from openrooms_usd.rendering.scene.arrays import Scene

_TEXEL_M: Final = 0.01
_MOST_TEXELS: Final = 1024
_LEAST_AREA_M2: Final = 0.1
_MOST_TRIANGLES: Final = 2000
# Texels that two triangles claim, of all: more means that the coordinates repeat.
_MOST_SHARED: Final = 0.05
_PROBE_M: Final = 0.1
_MOST_PROBES: Final = 1200


@dataclass(frozen=True, eq=False)
class Chart:
    """A part's surface over its own texture coordinates.

    Attributes:
        part: Its number.
        primvar: Name of the coordinates.
        scale: (2,) factor of the coordinates, then
        offset: (2,) added: from the primvar to 0..1 of the picture.
        texels: (T, 2) row and column of those that the surface covers, the first row on top.
        size: Height and width.
        position: (T, 3) world, metres.
        normal: (T, 3) unit, of the front side.
        probes: Which of them light is sampled at.
    """

    part: int
    primvar: str
    scale: Array
    offset: Array
    texels: Rows
    size: tuple[int, int]
    position: Array
    normal: Array
    probes: Rows


def charts_of(scene: Scene, seen: Rows, rng: np.random.Generator) -> list[Chart]:
    """The charts of all parts that have one.

    Args:
        scene: The arrays.
        seen: Rows of its triangles that matter: the back of a wall shares coordinates with its
            front.
        rng: Chooses where light is sampled.
    """
    parts = np.array([piece.part for piece in scene.pieces] or [0], dtype=np.int64)
    part_of = parts[scene.triangles.pieces]
    found = []
    for part in np.unique(part_of[seen]):
        rows = seen[part_of[seen] == part]
        patches = np.unique(np.searchsorted(scene.offsets, rows, side="right") - 1)
        shares = [scene.patches[patch] for patch in patches]
        if len(rows) > _MOST_TRIANGLES or any(one.radiance is not None for one in shares):
            continue
        surface = shares[0].surface
        if any(one.surface is not surface for one in shares):
            continue
        chart = _chart(int(part), scene, rows, np.linalg.inv(surface.uv), surface.primvar, rng)
        if chart is not None:
            found.append(chart)
    return found


def probes_of(charts: list[Chart]) -> Places:
    """Where light is sampled, chart by chart."""
    position = np.concatenate([np.zeros((0, 3)), *(c.position[c.probes] for c in charts)])
    normal = np.concatenate([np.zeros((0, 3)), *(c.normal[c.probes] for c in charts)])
    return Places(position[:, None], normal[:, None], normal[:, None])


def _chart(
    part: int, scene: Scene, rows: Rows, inverse: Array, primvar: str, rng: np.random.Generator
) -> Chart | None:
    corners = scene.triangles.corners[rows]
    st = scene.triangles.st[rows].astype(float)
    st = st @ inverse[:2, :2].T + inverse[:2, 2]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(cross, axis=1)
    first, second = st[:, 1] - st[:, 0], st[:, 2] - st[:, 0]
    flat = 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    if area.sum() < _LEAST_AREA_M2 or flat.sum() <= 1e-12:
        return None
    low, high = st.reshape(-1, 2).min(axis=0), st.reshape(-1, 2).max(axis=0)
    extent = np.maximum(high - low, 1e-9)
    metres = extent * np.sqrt(area.sum() / flat.sum())
    size = np.clip(np.ceil(metres / _TEXEL_M), 4, _MOST_TEXELS).astype(int)
    owner, weights, shared = _rasterised((st - low) / extent * size, size)
    covered = np.flatnonzero(owner >= 0)
    if not len(covered) or shared > _MOST_SHARED * len(covered):
        return None
    triangle, weight = owner[covered], weights[covered]
    y, x = np.divmod(covered, size[0])
    position = np.einsum("nj,nji->ni", weight, corners[triangle])
    normal = cross[triangle] / np.maximum(2.0 * area[triangle], 1e-30)[:, None]
    texels = np.stack([size[1] - 1 - y, x], axis=-1)
    step = max(1, round(_PROBE_M / float(np.median(metres / size))))
    grid = np.flatnonzero((y % step == 0) & (x % step == 0))
    probes = np.sort(rng.permutation(grid)[:_MOST_PROBES])
    if not len(probes):
        return None
    scale = 1.0 / extent
    return Chart(
        part,
        primvar,
        scale,
        -low * scale,
        texels,
        (int(size[1]), int(size[0])),
        position,
        normal,
        probes,
    )


def _rasterised(points: Array, size: NDArray[np.int64]) -> tuple[Rows, Array, int]:
    """The triangle of each texel, its weights, and how many texels have several.

    Args:
        points: (M, 3, 2) in texels.
        size: Width and height.
    """
    width, height = (int(one) for one in size)
    owner = np.full(width * height, -1, dtype=np.int64)
    weights = np.zeros((width * height, 3))
    shared = 0
    for number, triangle in enumerate(points):
        (x0, y0), (x1, y1) = np.floor(triangle.min(axis=0)), np.ceil(triangle.max(axis=0))
        columns = np.arange(max(int(x0), 0), min(int(x1) + 1, width))
        lines = np.arange(max(int(y0), 0), min(int(y1) + 1, height))
        if not len(columns) or not len(lines):
            continue
        x, y = np.meshgrid(columns + 0.5, lines + 0.5)
        (ax, ay), (bx, by), (cx, cy) = triangle
        double = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if abs(double) < 1e-9:
            continue
        second = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / double
        third = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / double
        first = 1.0 - second - third
        inside = np.minimum(np.minimum(first, second), third) >= 0.0
        row = (np.floor(y[inside]) * width + np.floor(x[inside])).astype(np.int64)
        shared += int((owner[row] >= 0).sum())
        owner[row] = number
        weights[row] = np.stack([first[inside], second[inside], third[inside]], axis=-1)
    return owner, weights, shared
