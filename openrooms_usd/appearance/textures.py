"""Pictures of base colours: photographs laid onto surfaces, divided by the light that is there."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import (
    distance_transform_edt,
    gaussian_filter,
    map_coordinates,
    maximum_filter,
    minimum_filter,
)
from scipy.spatial import KDTree

from openrooms_usd.appearance.charts import Chart
from openrooms_usd.appearance.problem import Problem
from openrooms_usd.appearance.solving import BELOW_GLOSS, Solution, gloss_seen, light_at
from openrooms_usd.appearance.transport import Gather
from openrooms_usd.arrays import Array, Bytes
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.rendering.color import quantize
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.first_hits import first_hits
from openrooms_usd.rendering.scene.rays import RayTracer
from openrooms_usd.usd.cameras import PinholeCamera

_LEAST_COSINE: Final = 0.15
# A texel is seen where the picture's depth is as near as this: metres, and of the depth.
_NEAR_M, _NEAR_SHARE = 0.02, 0.01
_BORDER: Final = 5
_DARK, _BRIGHT = 4.0, 248.0
# Views that differ by more than this from the others show a highlight or something in between.
_OUTLIER: Final = 0.35
_ROUNDS: Final = 3
# Light is averaged over so many probes, and so far, metres.
_NEIGHBOURS: Final = 12
_REACH_M: Final = 0.12
# Less detail than this, of the logarithm, is noise: the part has one colour.
_LEAST_DETAIL: Final = 0.07
_AROUND_TEXELS: Final = 12.0
# Texels of which so little is known, of the median, are half the part's colour.
_UNSURE: Final = 0.15
_LEAST_SEEN: Final = 0.2
_FAR_TEXELS: Final = 30.0


@dataclass(frozen=True, eq=False)
class Painted:
    """A picture of a part's base colour.

    Attributes:
        chart: Where it lies.
        pixels: (H, W, 3) sRGB.
        seen: Share of the surface that photographs show.
    """

    chart: Chart
    pixels: Bytes
    seen: float


@dataclass(frozen=True, eq=False)
class _Shot:
    """A photograph as radiance, with what it sees."""

    frame: CapturedFrame
    radiance: Array
    usable: NDArray[np.bool_]
    part: NDArray[np.int64]
    depth: Array


def paint(
    scene: Scene,
    tracer: RayTracer,
    frames: Sequence[CapturedFrame],
    pictures: Sequence[Bytes],
    charts: Sequence[Chart],
    lit: Gather,
    problem: Problem,
    found: Solution,
) -> list[Painted]:
    """Pictures of those charts that are not of one colour.

    Args:
        scene: The arrays.
        tracer: Finds its triangles.
        frames: Cameras.
        pictures: (H, W, 3) of each.
        charts: Of parts.
        lit: What arrives at their probes, chart by chart.
        problem: What was solved.
        found: Its solution.
    """
    shots = [
        _shot(scene, tracer, frame, picture, index, found)
        for index, (frame, picture) in enumerate(zip(frames, pictures, strict=True))
    ]
    light, gloss = light_at(problem, found, lit), gloss_seen(problem, found)
    ends = np.cumsum([0, *(len(chart.probes) for chart in charts)])
    painted = []
    for chart, begin, end in zip(charts, ends[:-1], ends[1:], strict=True):
        if problem.metallic[chart.part] < 0.5:
            one = _painted(chart, light[begin:end], shots, problem, found, gloss)
            painted += [one] if one is not None else []
    return painted


def _shot(
    scene: Scene,
    tracer: RayTracer,
    frame: CapturedFrame,
    picture: Bytes,
    index: int,
    found: Solution,
) -> _Shot:
    height, width = picture.shape[:2]
    hits = first_hits(scene, tracer, PinholeCamera(frame.K, frame.world_from_camera), width, height)
    y, x = np.mgrid[:height, :width] + 0.5
    off = np.hypot(x - frame.K[0, 2], y - frame.K[1, 2]) / frame.K[0, 0]
    camera = found.exposure[index] * found.balance[index]
    falloff = (1.0 + found.vignetting * off**2)[..., None] ** 2
    usable = np.asarray(((picture > _DARK) & (picture < _BRIGHT)).all(axis=-1))
    radiance = found.curve.linear(picture / 255.0) / camera * falloff
    parts = np.array([piece.part for piece in scene.pieces] or [0], dtype=np.int64)
    numbers = parts[scene.triangles.pieces[hits.rows]] + np.ones(len(hits.rows))
    part = hits.image(numbers)[..., 0].astype(np.int64) - 1
    # Beside borders pixels mix two things.
    even = minimum_filter(part, _BORDER) == maximum_filter(part, _BORDER)
    part = np.where(even, part, -1)
    return _Shot(frame, radiance, usable, part, hits.image(hits.depth)[..., 0].astype(float))


def _painted(
    chart: Chart,
    light: Array,
    shots: Sequence[_Shot],
    problem: Problem,
    found: Solution,
    gloss: Array,
) -> Painted | None:
    near = KDTree(chart.position[chart.probes])
    arrived = BELOW_GLOSS * _between(near, light, chart.position)
    obs = problem.observations
    level = arrived.mean(axis=1)
    lit = np.minimum(level / max(float(np.median(level)), 1e-9), 1.0)
    total, weights = [], []
    for index, shot in enumerate(shots):
        rows = np.flatnonzero((obs.part == chart.part) & (obs.photograph == index))
        value, weight = _laid(chart, shot)
        if not weight.any():
            continue
        on = weight > 0.0
        color = np.zeros_like(value)
        mirrored = np.zeros((on.sum(), 3))
        if len(rows):
            middle = obs.places.position[rows, 0]
            mirrored = _between(KDTree(middle), gloss[rows], chart.position[on])
        color[on] = np.clip((value[on] - mirrored) / np.maximum(arrived[on], 1e-9), 0.002, 1.2)
        # What mirrors more than it shows of itself says little, and so does what lies in the dark.
        own = found.base[chart.part] * arrived[on]
        weight[on] *= (own / np.maximum(own + mirrored, 1e-9)).mean(axis=1) ** 2 * lit[on]
        total.append(color)
        weights.append(weight)
    if not total:
        return None
    merged, sure = _merged(np.stack(total), np.stack(weights))
    seen = sure > 0.0
    own = found.base[chart.part]
    if seen.mean() < _LEAST_SEEN or _detail(chart, merged, seen) < _LEAST_DETAIL:
        return None
    merged[seen] *= own / np.average(merged[seen], axis=0, weights=sure[seen])
    share = (sure / (sure + _UNSURE * np.median(sure[seen])))[:, None]
    merged = share * merged + (1.0 - share) * own
    return Painted(chart, _filled(chart, merged, seen, own), float(seen.mean()))


def _laid(chart: Chart, shot: _Shot) -> tuple[Array, Array]:
    """(T, 3) what a photograph shows of texels, and (T,) weights: 0 where it does not see them."""
    camera_from_world = np.linalg.inv(shot.frame.world_from_camera)
    seen = chart.position @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]
    depth = np.maximum(seen[:, 2], 1e-6)
    pixel = seen @ shot.frame.K.T
    x, y = pixel[:, 0] / depth, pixel[:, 1] / depth
    height, width = shot.usable.shape
    eye = shot.frame.world_from_camera[:3, 3] - chart.position
    distance = np.linalg.norm(eye, axis=1)
    cosine = np.einsum("ni,ni->n", eye, chart.normal) / np.maximum(distance, 1e-9)
    ok = (seen[:, 2] > 0.05) & (x >= 1) & (y >= 1) & (x < width - 1) & (y < height - 1)
    ok &= cosine > _LEAST_COSINE
    column, row = np.clip(x, 0, width - 1).astype(int), np.clip(y, 0, height - 1).astype(int)
    ok &= np.abs(shot.depth[row, column] - depth) < _NEAR_M + _NEAR_SHARE * depth
    ok &= shot.usable[row, column] & (shot.part[row, column] == chart.part)
    value = np.stack(
        [map_coordinates(shot.radiance[..., c], [y - 0.5, x - 0.5], order=1) for c in range(3)],
        axis=-1,
    )
    return value, np.where(ok, np.maximum(cosine, 0.0) / np.maximum(distance, 0.3) ** 2, 0.0)


def _between(near: KDTree, values: Array, position: Array) -> Array:
    """Values at places between those of a tree, the near ones first."""
    count = min(_NEIGHBOURS, near.n)
    found = near.query(position, k=list(range(1, count + 1)))
    distance, row = np.asarray(found[0]), np.asarray(found[1])
    weight = np.exp(-0.5 * (distance / _REACH_M) ** 2) + 1e-6
    return np.asarray((weight[..., None] * values[row]).sum(axis=1) / weight.sum(axis=1)[:, None])


def _merged(colors: Array, weights: Array) -> tuple[Array, Array]:
    """(T, 3) the mean over views without those that differ, and (T,) what it is worth."""
    log = np.log(np.maximum(colors.mean(axis=-1), 1e-4))
    kept = weights
    for _ in range(_ROUNDS):
        sum_ = kept.sum(axis=0)
        middle = (kept * log).sum(axis=0) / np.maximum(sum_, 1e-12)
        close = np.abs(log - middle) < _OUTLIER
        kept = np.where(close | (weights.max(axis=0) == weights) & ~close.any(axis=0), weights, 0.0)
    sum_ = kept.sum(axis=0)
    mean = (kept[..., None] * colors).sum(axis=0) / np.maximum(sum_, 1e-12)[:, None]
    return mean, np.asarray(sum_)


def _detail(chart: Chart, colors: Array, seen: NDArray[np.bool_]) -> float:
    """Spread of the logarithm of colours about that of their surroundings.

    Slow changes over a surface are errors of the light that is divided out.
    """
    log, known = np.zeros(chart.size), np.zeros(chart.size)
    rows, columns = chart.texels[seen].T
    log[rows, columns] = np.log(np.maximum(colors[seen].mean(axis=-1), 1e-4))
    known[rows, columns] = 1.0
    around = gaussian_filter(log, _AROUND_TEXELS) / np.maximum(
        gaussian_filter(known, _AROUND_TEXELS), 1e-6
    )
    low, high = np.percentile((log - around)[rows, columns], [10, 90])
    return float(high - low) / 2.56


def _filled(chart: Chart, colors: Array, seen: NDArray[np.bool_], own: Array) -> Bytes:
    """The picture: unseen texels like the nearest ones that were seen, far ones of the mean."""
    picture = np.tile(own, (*chart.size, 1))
    known = np.zeros(chart.size, dtype=bool)
    rows, columns = chart.texels[seen].T
    picture[rows, columns], known[rows, columns] = colors[seen], True
    if not known.any():
        return quantize(srgb_from_linear(picture))
    distance, nearest = distance_transform_edt(~known, return_indices=True)
    share = np.clip(1.0 - distance / _FAR_TEXELS, 0.0, 1.0)[..., None]
    filled = picture[nearest[0], nearest[1]]
    mixed = np.clip(share * filled + (1.0 - share) * own, 0.0, 1.0)
    return quantize(srgb_from_linear(mixed))
