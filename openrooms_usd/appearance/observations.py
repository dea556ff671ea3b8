"""Pixels of photographs, with the surfaces that they see."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter, uniform_filter

from openrooms_usd.appearance.places import Places
from openrooms_usd.arrays import Array
from openrooms_usd.arrays import Ints as Rows
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.first_hits import Hits, first_hits
from openrooms_usd.rendering.scene.rays import RayTracer
from openrooms_usd.usd.cameras import PinholeCamera

# Pixels that say nothing: of 255.
_DARK, _BRIGHT = 4, 248
# Points of a place: the corners and the middle of the pixels that are averaged.
_AROUND: Final = np.array([[0, 0], [-1, -1], [1, -1], [-1, 1], [1, 1]])
_MOST_OF_A_PART: Final = 32
_MOST_OF_SKY: Final = 60
# A triangle that fewer pixels show does not count as seen.
_LEAST_PIXELS: Final = 20
_LEAST_OF_A_PART: Final = 4
# Seen flatter than this, a pixel covers too much.
_LEAST_COSINE: Final = 0.12


@dataclass(frozen=True, eq=False)
class SkyPixels:
    """What pixels show that see past all surfaces.

    Attributes:
        photograph: (N,) and
        value: (N, 3) and
        radius: (N,) as of `Observations`.
        direction: (N, 3) unit, in the world.
    """

    photograph: Rows
    value: Array
    radius: Array
    direction: Array


@dataclass(frozen=True, eq=False)
class Observations:
    """What pixels show.

    Attributes:
        photograph: (N,) number of the photograph.
        part: (N,) number of the part, as in the channel ``part``.
        value: (N, 3) 0 to 1, as the photograph's file has it, the mean over some pixels.
        usable: (N, 3) whether a primary is neither dark nor saturated.
        radius: (N,) distance from the principal point over the focal length.
        weight: (N,) how many pixels of the part it stands for, at most about 1.
        places: What they see.
        sky: Pixels that see the surroundings.
        triangles: Rows of the scene's triangles that pixels see.
    """

    photograph: Rows
    part: Rows
    value: Array
    usable: NDArray[np.bool_]
    radius: Array
    weight: Array
    places: Places
    sky: "SkyPixels"
    triangles: Rows

    def __len__(self) -> int:
        return len(self.part)


def observe(
    scene: Scene,
    tracer: RayTracer,
    frames: Sequence[CapturedFrame],
    pictures: Sequence[NDArray[np.uint8]],
    seed: int = 0,
) -> Observations:
    """Pick pixels of photographs.

    Args:
        scene: The arrays.
        tracer: Finds its triangles.
        frames: The cameras, without distortion.
        pictures: (H, W, 3) of each.
        seed: Of the choice.
    """
    rng = np.random.default_rng(seed)
    parts = np.array([piece.part for piece in scene.pieces] or [0], dtype=np.int64)
    emits = np.array([patch.radiance is not None for patch in scene.patches])
    rows = [
        _picked(index, frame, picture, scene, tracer, parts, emits, rng)
        for index, (frame, picture) in enumerate(zip(frames, pictures, strict=True))
    ]
    joined = [np.concatenate(some) for some in zip(*(own for own, _, _ in rows), strict=True)]
    photograph, part, value, usable, radius, weight, position, normal, view = joined
    sky = SkyPixels(
        *(np.concatenate(some) for some in zip(*(sky for _, sky, _ in rows), strict=True))
    )
    seen, counts = np.unique(np.concatenate([met for _, _, met in rows]), return_counts=True)
    return Observations(
        photograph,
        part,
        value,
        usable,
        radius,
        weight,
        Places(position, normal, view),
        sky,
        seen[counts >= _LEAST_PIXELS],
    )


def _picked(
    index: int,
    frame: CapturedFrame,
    picture: NDArray[np.uint8],
    scene: Scene,
    tracer: RayTracer,
    parts: Rows,
    emits: NDArray[np.bool_],
    rng: np.random.Generator,
) -> tuple[list[Array], list[Array], Rows]:
    height, width = picture.shape[:2]
    camera = PinholeCamera(frame.K, frame.world_from_camera)
    hits = first_hits(scene, tracer, camera, width, height)
    numbers = parts[scene.triangles.pieces[hits.rows]] + 1
    numbers = np.where(emits[hits.patches], 0, numbers)
    labels_of_all = np.zeros(height * width, np.int64)
    labels_of_all[hits.pixels] = 1
    labels_of_all = labels_of_all.reshape(height, width)
    labels = np.zeros(height * width, np.int64)
    labels[hits.pixels] = numbers
    labels = labels.reshape(height, width)
    row_of = np.full(height * width, -1)
    row_of[hits.pixels] = np.arange(len(hits.pixels))
    level, reach = np.zeros_like(labels), {3: 1, 5: 2}
    for size in (3, 5):
        low, high = (f(labels, size, mode="constant") for f in (minimum_filter, maximum_filter))
        even = low == high
        level = np.where(even & (labels > 0), reach[size], level)
    view = -hits.directions / np.linalg.norm(hits.directions, axis=1, keepdims=True)
    normal = _shading_normals(scene, hits, view)
    ok = np.zeros(height * width, bool)
    ok[hits.pixels] = np.einsum("ni,ni->n", normal, view) > _LEAST_COSINE
    chosen: list[Rows] = []
    weights: list[Array] = []
    flat_level = level.ravel()
    for part in np.unique(labels[labels > 0]):
        here = np.flatnonzero((labels.ravel() == part) & (flat_level > 0) & ok)
        if len(here) < _LEAST_OF_A_PART:
            continue
        few = rng.permutation(here)[:_MOST_OF_A_PART]
        chosen.append(few)
        weights.append(np.full(len(few), min(1.0, len(here) / (25.0 * len(few)))))
    picks = np.concatenate([np.zeros(0, np.int64), *chosen])
    values = picture.astype(float)
    smooth = {1: _mean(values, 3), 2: _mean(values, 5)}
    low, high = (f(picture, size=(3, 3, 1)) for f in (minimum_filter, maximum_filter))
    both = np.where((flat_level == 2)[:, None], smooth[2].reshape(-1, 3), smooth[1].reshape(-1, 3))
    usable = (low > _DARK).reshape(-1, 3) & (high < _BRIGHT).reshape(-1, 3)
    y, x = np.divmod(picks, width)
    off = _radius(frame, picks, width)
    reach = flat_level[picks][:, None]
    outside = maximum_filter(labels, 5) + maximum_filter(labels_of_all, 5) == 0
    empty = rng.permutation(np.flatnonzero(outside.ravel()))[:_MOST_OF_SKY]
    rows = row_of[(y[:, None] + _AROUND[:, 1] * reach) * width + x[:, None] + _AROUND[:, 0] * reach]
    _, directions = camera.rays(width, height)
    ahead = directions[empty] / np.linalg.norm(directions[empty], axis=1, keepdims=True)
    sky = [
        np.full(len(empty), index),
        smooth[2].reshape(-1, 3)[empty] / 255.0,
        _radius(frame, empty, width),
        ahead,
    ]
    own = [
        np.full(len(picks), index),
        labels.ravel()[picks] - 1,
        both[picks] / 255.0,
        usable[picks],
        off,
        np.concatenate([np.zeros(0), *weights]),
        hits.position[rows],
        normal[rows],
        view[rows],
    ]
    return own, sky, hits.rows


def _radius(frame: CapturedFrame, pixels: Rows, width: int) -> Array:
    y, x = np.divmod(pixels, width)
    off = np.hypot(x + 0.5 - frame.K[0, 2], y + 0.5 - frame.K[1, 2])
    return np.asarray(off / frame.K[0, 0])


def _mean(values: Array, size: int) -> Array:
    return np.stack([uniform_filter(values[..., c], size) for c in range(3)], axis=-1)


def _shading_normals(scene: Scene, hits: Hits, view: Array) -> Array:
    corners = scene.triangles.normals[hits.rows].astype(float)
    normal = np.einsum("ni,nij->nj", hits.weights, corners)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.where(length > 1e-6, normal / np.maximum(length, 1e-6), hits.geometric)
    flip = np.where(np.einsum("ni,ni->n", hits.geometric, view) < 0.0, -1.0, 1.0)[:, None]
    return np.asarray(flip * normal)
