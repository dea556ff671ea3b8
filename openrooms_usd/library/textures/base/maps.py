"""A material as arrays: physical quantities first, then the integers that files hold."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Bytes
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.library.textures.base.noise import Field

Words = NDArray[np.uint16]

# Nothing in a room is blacker than soot velvet or whiter than fresh plaster, but for bare metal.
ALBEDO_RANGE: Final = (0.02, 0.9)
ROUGHNESS_RANGE: Final = (0.02, 1.0)


@dataclass(frozen=True)
class Maps:
    """What a family makes, rows downwards, before it is stored.

    Attributes:
        albedo: (N, N, 3) scene-linear Rec.709; of metals the reflectance at normal incidence.
        height: (N, N) metres.
        roughness: (N, N) perceptual.
        metallic: (N, N), or one value for all.
    """

    albedo: Field
    height: Field
    roughness: Field
    metallic: Field | float = 0.0


@dataclass(frozen=True)
class TextureSet:
    """A tileable material as stored; the first row is the upper edge (t = 1).

    Attributes:
        albedo: (N, N, 3) sRGB-encoded base colour.
        normal: (N, N, 3) tangent-space normal, (n + 1) / 2, green towards +t (OpenGL).
        roughness: (N, N) perceptual roughness.
        metallic: (N, N) metalness.
        height: (N, N) sixteen bits of ``height_range``.
        height_range: Heights that 0 and 65535 stand for, metres; the mean height is 0.
        size: Physical length of each side, metres.
    """

    albedo: Bytes
    normal: Bytes
    roughness: Bytes
    metallic: Bytes
    height: Words
    height_range: tuple[float, float]
    size: float


def encoded(maps: Maps, size: float) -> TextureSet:
    """Store a material in eight bits, its height in sixteen.

    Args:
        maps: The material.
        size: Physical length of each side, metres.
    """
    texel = size / len(maps.height)
    height, height_range = _levels(maps.height)
    return TextureSet(
        albedo=quantized(srgb_from_linear(_plausible(maps))),
        normal=quantized(normals(maps.height, texel) * 0.5 + 0.5),
        roughness=quantized(np.clip(maps.roughness, *ROUGHNESS_RANGE)),
        metallic=quantized(np.broadcast_to(maps.metallic, maps.height.shape)),
        height=height,
        height_range=height_range,
        size=size,
    )


def quantized(values: Field) -> Bytes:
    """The nearest of 256 steps of values in 0..1."""
    return np.rint(np.clip(values, 0.0, 1.0) * 255.0).astype(np.uint8)


def _plausible(maps: Maps) -> Field:
    """Base colours within what rooms have; bare metal may reflect all (silver: 0.97)."""
    low, high = ALBEDO_RANGE
    metallic = np.broadcast_to(maps.metallic, maps.height.shape)[..., None]
    return np.clip(maps.albedo, low, high + (1.0 - high) * metallic)


def _levels(height: Field) -> tuple[Words, tuple[float, float]]:
    """Heights above their mean as sixteen bits, and what the ends stand for, metres."""
    # Rounded to a tenth of a nanometre, so that the range is the same number on all machines.
    relative = height - height.mean()
    low, high = (round(float(end), 10) for end in (relative.min(), relative.max()))
    span = max(high - low, 1e-10)
    share = np.clip((relative - low) / span, 0.0, 1.0)
    return np.rint(share * 65535.0).astype(np.uint16), (low, low + span)


def normals(height: Field, texel: float) -> Field:
    """(N, N, 3) unit normals of a periodic height field in the frame (s, t, out).

    Args:
        height: (N, N) metres, rows downwards.
        texel: Length of a texel, metres.
    """
    slope_s = (np.roll(height, -1, axis=1) - np.roll(height, 1, axis=1)) / (2.0 * texel)
    # Rows run against t.
    slope_t = (np.roll(height, 1, axis=0) - np.roll(height, -1, axis=0)) / (2.0 * texel)
    length = np.sqrt(slope_s**2 + slope_t**2 + 1.0)
    return np.stack([-slope_s / length, -slope_t / length, 1.0 / length], axis=-1)


def with_mean(field: Field, mean: float | Array) -> Field:
    """A field scaled so that it has a given mean (over the first two axes)."""
    scale: Field = np.asarray(mean) / np.mean(field, axis=(0, 1))
    return field * scale
