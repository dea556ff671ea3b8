"""Pictures of another size.

What a channel is says how its pixels are made:

- Light is the mean over the new pixel's area, so that what sums keeps its sums; `visibility_i` is
  weighted by `unoccluded_i` where that is there, and stays their ratio.
- Labels, materials, masks and normals are those of the nearest pixel: of one surface, never a
  blend of two.
- ``depth``, ``distance`` and ``position`` are of the nearest pixel too, but brought to the new
  pixel's own ray along the plane of the surface (`normal_geometric`, where that is there). So they
  agree with each other, with ``K`` and with the pose, and no depth lies between two surfaces.

Grids of hemispheres cover the picture and stay.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Ints
from openrooms_usd.channels import CHANNELS, Channel, definition
from openrooms_usd.errors import InputError
from openrooms_usd.loading.sample import Array, Floats, Sample, is_in_picture, is_light

_GEOMETRY: Final = ("depth", "distance", "position")
# A surface that is seen so flat that its depth changes more than this within half a pixel keeps
# the depth of its pixel.
_MOST_CHANGE: Final = 1.1


@dataclass(frozen=True)
class Resize:
    """The same view with other pixels.

    Attributes:
        width: Pixels.
        height: Pixels.
        averaged: Channels besides light that are means over the pixels' areas, such as
            ``base_color``; no labels, and nothing along axes.
    """

    width: int
    height: int
    averaged: Collection[str] = ()

    def __call__(self, sample: Sample, rng: np.random.Generator, /) -> Sample:
        """The resized sample.

        Raises:
            InputError: A size below 1, or a channel that has no mean.
        """
        if self.width < 1 or self.height < 1:
            raise InputError(f"{self.width}x{self.height} is not a valid size of a picture")
        for name in self.averaged:
            row = CHANNELS.get(name)
            if row is None or row.unit in ("id", "m") or row.frame:
                raise InputError(f"pixels of {name!r} have no mean", place="averaged")
        if (self.width, self.height) == sample.size:
            return sample
        wide, high = sample.size
        rows, columns = _nearest(high, self.height), _nearest(wide, self.width)
        pixel_scale = np.array([self.width / wide, self.height / high], np.float32)

        def change(channel: Channel, pixels: Array) -> Array:
            if is_light(channel) or channel.name in self.averaged:
                return area_mean(area_mean(pixels, self.height, -3), self.width, -2)
            nearest = pixels[..., rows[:, None], columns, :]
            return nearest * pixel_scale if is_in_picture(channel) else nearest

        scale = np.array([[self.width / wide], [self.height / high], [1.0]])
        resized = replace(
            _weighted(sample, change), size=(self.width, self.height), K=sample.K * scale
        )
        geometry = _geometry(sample, resized, sample.rays[rows[:, None], columns])
        return replace(resized, images={**resized.images, **geometry})


def area_mean(pixels: Array, count: int, axis: int) -> Array:
    """Means over the areas of new pixels along one axis.

    Args:
        pixels: Any array.
        count: How many there shall be.
        axis: Which axis.
    """
    there = pixels.shape[axis]
    edges = np.arange(count + 1) * (there / count)
    first = np.floor(edges[:-1]).astype(np.int64)
    taps = int((np.ceil(edges[1:] - 1e-9).astype(np.int64) - first).max())
    shape = [1] * pixels.ndim
    shape[axis] = count
    total: Array | None = None
    for tap in range(taps):
        place = np.minimum(first + tap, there - 1)
        # Of the pixel first + tap, the part that lies in the new one.
        inside = np.minimum(edges[1:], first + tap + 1.0) - np.maximum(edges[:-1], first + tap)
        share = (np.maximum(inside, 0.0) * (count / there)).astype(pixels.dtype)
        part = pixels.take(place, axis) * share.reshape(shape)
        total = part if total is None else total + part
    assert total is not None
    return total


def _nearest(there: int, count: int) -> Ints:
    """The pixels that hold the centres of the new ones."""
    return np.asarray(((np.arange(count) + 0.5) * there / count).astype(np.int64))


def _weighted(sample: Sample, change: Callable[[Channel, Array], Array]) -> Sample:
    """The new pixels; shares of light with the light for a weight."""
    changed = sample.each(change)
    if not {"visibility_i", "unoccluded_i"} <= set(sample.lights):
        return changed
    part, whole = sample.lights["visibility_i"], sample.lights["unoccluded_i"]
    row = definition("visibility_i")
    light, weight = change(row, part * whole), change(row, whole)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(weight > 0.0, light / weight, np.float32(0.0))
    return replace(changed, lights={**changed.lights, "visibility_i": share})


def _geometry(old: Sample, new: Sample, rays: Floats) -> dict[str, Array]:
    """Depth, distance and position on the new rays.

    Args:
        old: The sample.
        new: With the pixels that are nearest.
        rays: (height, width, 3) of these pixels, camera frame, z = 1.
    """
    names = [name for name in _GEOMETRY if name in new.images]
    if not names:
        return {}
    depth = _depth(new, names[0], rays)
    if "normal_geometric" in new.images:
        normals = new.images["normal_geometric"] @ new.world_from_camera[:3, :3]
        with np.errstate(divide="ignore", invalid="ignore"):
            along = (normals * rays).sum(axis=-1) / (normals * new.rays).sum(axis=-1)
            steady = (along < _MOST_CHANGE) & (along > 1.0 / _MOST_CHANGE)
        depth = depth * np.where(steady, along, 1.0)
    # What is stored is what all of them are made of.
    stored = depth.astype(np.float32)[..., None]
    points = new.rays * stored
    turn, shift = new.world_from_camera[:3, :3], new.world_from_camera[:3, 3]
    made: dict[str, Array] = {
        "depth": stored,
        "distance": np.linalg.norm(points, axis=-1, keepdims=True),
        "position": np.where(stored > 0.0, points @ turn.T + shift, 0.0),
    }
    return {name: made[name].astype(np.float32) for name in names}


def _depth(sample: Sample, name: str, rays: Floats) -> Floats:
    """(height, width) planar depth of pixels on some rays, of a channel that tells it."""
    pixels = sample.images[name].astype(np.float64)
    if name == "position":
        turn, shift = sample.world_from_camera[:3, :3], sample.world_from_camera[:3, 3]
        there = (pixels != 0.0).any(axis=-1)
        return np.where(there, ((pixels - shift) @ turn)[..., 2], 0.0)
    return np.asarray(
        pixels[..., 0] / (np.linalg.norm(rays, axis=-1) if name == "distance" else 1.0)
    )
