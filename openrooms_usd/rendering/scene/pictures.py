"""Textures as linear arrays, and their lookup: bilinear between the centres of texels.

All colour decoding happens here, once, so that every backend and the ground-truth channels see
the same numbers.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.scene.wrapping import framed
from openrooms_usd.usd.shading.surfaces import BLACK, Texture, chosen, taken
from openrooms_usd.usd.shading.textures import read_texture, report_line

Limits = tuple[float, float]

# Half precision keeps 11 bits: better than the 8 of most pictures, at half the memory.
_HALF_MAX: Final = 6e4
# The longest side of a picture that is kept as it is; longer ones are halved until they fit.
MAX_SIDE: Final = 4096


@dataclass(frozen=True, eq=False)
class Picture:
    """A texture whose values are ready to use.

    Attributes:
        texels: (H, W, C) values in half or float32, or the rows of ``coding`` in 8 bits; C = 1 or
            3, the first row at v = 0 (the bottom).
        wrap: ``repeat``, ``mirror`` or ``clamp`` in both directions; ``repeat clamp`` or
            ``clamp repeat`` where u and v differ.
        uv: (3, 3) from the mesh's texture coordinates to the picture's.
        losses: What could not be kept, in words.
        coding: What texels of 8 bits mean; None where they are values.
    """

    texels: NDArray[Any]
    wrap: str = "repeat"
    uv: Array = field(default_factory=lambda: np.eye(3))
    losses: tuple[str, ...] = ()
    coding: "Coding | None" = None

    @cached_property
    def pixels(self) -> NDArray[np.floating]:
        """(H, W, C) values in half or float32."""
        return self._values(self.texels)

    def halves(self) -> NDArray[np.floating]:
        """The same, in half precision where that holds them; not kept."""
        if self.coding is None or np.abs(self.coding.levels).max() >= _HALF_MAX:
            return self._values(self.texels)
        return self._values(self.texels).astype(np.float16)

    @property
    def channels(self) -> int:
        """1 or 3."""
        return int(self.texels.shape[2])

    @property
    def ways(self) -> tuple[str, str]:
        """Its wrap modes in u and in v."""
        across, _, up = self.wrap.partition(" ")
        return across, up or across

    @property
    def is_plain(self) -> bool:
        """Whether it takes the mesh's texture coordinates as they are."""
        return np.array_equal(self.uv, np.eye(3))

    def lookup(self, st: Array) -> Array:
        """Bilinear values at texture coordinates.

        Args:
            st: (..., 2) the mesh's texture coordinates.

        Returns:
            (..., C) values.
        """
        height, width, _ = self.texels.shape
        uv = st @ self.uv[:2, :2].T + self.uv[:2, 2]
        x, y = uv[..., 0] * width - 0.5, uv[..., 1] * height - 0.5
        x0, y0 = np.floor(x), np.floor(y)
        fx, fy = (x - x0)[..., None], (y - y0)[..., None]
        across, up = self.ways
        columns = [_wrapped(x0 + step, width, across) for step in (0, 1)]
        rows = [_wrapped(y0 + step, height, up) for step in (0, 1)]
        low, high = (
            self._values(self.texels[row, columns[0]]) * (1 - fx)
            + self._values(self.texels[row, columns[1]]) * fx
            for row in rows
        )
        return np.asarray(low * (1 - fy) + high * fy, dtype=np.float64)

    def _values(self, texels: NDArray[Any]) -> NDArray[np.floating]:
        if self.coding is None:
            return texels
        levels = self.coding.levels
        values = [levels[texels[..., channel], channel] for channel in range(self.channels)]
        return np.stack(values, axis=-1)


@dataclass(frozen=True)
class Coding:
    """What the 256 codes of a picture of 8 bits mean: decoded, scaled, offset and clipped.

    Attributes:
        srgb: Whether the codes are decoded as sRGB.
        scale: Factor of each channel.
        bias: Offset of each channel.
        limits: The least and the greatest value.
    """

    srgb: bool
    scale: tuple[float, ...]
    bias: tuple[float, ...]
    limits: tuple[float, float]

    @cached_property
    def levels(self) -> Floats:
        """(256, C) values."""
        codes = np.arange(256, dtype=np.float32) / np.float32(255.0)
        linear = linear_from_srgb(codes) if self.srgb else codes
        scaled = linear[:, None] * np.array(self.scale, np.float32)
        return np.asarray(np.clip(scaled + np.array(self.bias, np.float32), *self.limits))


Value = float | tuple[float, float, float] | Picture


def evaluate(value: Value, st: Array, channels: int) -> Array:
    """A constant or a picture at texture coordinates.

    Args:
        value: What a surface says.
        st: (..., 2) the mesh's texture coordinates.
        channels: 1 or 3.

    Returns:
        (..., channels) values.
    """
    if isinstance(value, Picture):
        return np.broadcast_to(value.lookup(st), (*st.shape[:-1], channels))
    return np.broadcast_to(np.asarray(value, dtype=np.float64), (*st.shape[:-1], channels))


def times(color: Value, share: Value) -> Value:
    """A colour where it is there in part, as large as the finer of both pictures.

    Args:
        color: Of three channels.
        share: Of one channel. Where both are pictures it says how these go on.
    """
    if share == 1.0:
        return color
    if not isinstance(share, Picture):
        if not isinstance(color, Picture):
            red, green, blue = (np.asarray(color) * share).tolist()
            return red, green, blue
        pixels = (color.pixels * share).astype(color.pixels.dtype)
        return Picture(pixels, color.wrap, color.uv, color.losses)
    sizes = [one.texels.shape[:2] for one in (color, share) if isinstance(one, Picture)]
    height, width = np.max(sizes, axis=0).tolist()
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    st = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(share.uv).T
    pixels = evaluate(color, st[..., :2], 3) * share.lookup(st[..., :2])
    losses: tuple[str, ...] = share.losses
    if isinstance(color, Picture):
        losses = (*color.losses, *losses)
        if color.wrap != share.wrap or not np.array_equal(color.uv, share.uv):
            losses = (*losses, "emissiveColor wraps beyond the picture as opacity does")
    return Picture(pixels.astype(np.float32), share.wrap, share.uv, losses)


def load(
    texture: Texture, channels: int, limits: tuple[float, float], uv: Array, side: int = MAX_SIDE
) -> Picture:
    """Read a texture and apply its colour space, scale, bias and channel.

    Args:
        texture: What the material says; a file that cannot be read gives its fallback.
        channels: 1 or 3: what the input needs.
        limits: The least and the greatest value that make sense.
        uv: (3, 3) from the mesh's texture coordinates to the picture's.
        side: The longest side that is kept as it is, pixels.
    """
    losses: list[str] = []
    try:
        stored = read_texture(texture.file)
    except InputError as error:
        losses.append(report_line(error))
        instead = taken(texture, texture.fallback or BLACK, channels)
        picked = np.array(instead, dtype=np.float32).reshape(1, 1, channels)
    else:
        if max(stored.shape[:2]) > side:
            losses.append(made_smaller(texture.file, side))
        stored, damaged = mended(stored)
        if damaged:
            losses.append(
                f"{texture.file}: {damaged} texels are not numbers; replaced by their neighbours"
            )
        rgba = _rgba(within(stored, side))
        if texture.color_space == "sRGB":
            rgba[..., :3] = linear_from_srgb(rgba[..., :3])
        scale, bias = (
            np.array(taken(texture, numbers, channels), np.float32)
            for numbers in (texture.scale, texture.bias)
        )
        picked = rgba[..., list(chosen(texture.channel, channels))] * scale + bias
    if not np.isfinite(picked).all():
        least = max(limits[0], 0.0)
        losses.append(f"{texture.file}: pixels that are not numbers are replaced by {least:g}")
        picked = np.nan_to_num(picked, nan=least, posinf=least, neginf=least)
    directed = are_directions(channels, limits)
    if directed:
        picked, reason = _directed(picked)
        losses += [f"{texture.file}: {reason}"] if reason else []
    pixels = np.clip(picked, *limits)[::-1]
    kind = np.float16 if np.abs(pixels).max() < _HALF_MAX else np.float32
    beyond = np.array(taken(texture, texture.bias, channels), np.float32)
    black = np.clip(beyond, *limits)
    pixels, wrap, where, found = framed(pixels, texture, None if directed else black)
    texels = np.ascontiguousarray(pixels, dtype=kind)
    return Picture(texels, wrap, placed(where, uv), (*losses, *found))


def are_directions(channels: int, limits: Limits) -> bool:
    """Whether values are those of a normal map."""
    return channels == 3 and limits[0] < 0.0


def placed(where: Array, uv: Array) -> Array:
    """The product ``where @ uv``; exactly ``uv`` if ``where`` is the identity."""
    return uv if np.array_equal(where, np.eye(3)) else where @ uv


def mended(stored: Floats) -> tuple[Floats, int]:
    """Replace values that are not finite.

    Each becomes the mean of the finite ones among its eight neighbours (the picture repeats), or of
    the whole channel where there is none, or 0.

    Args:
        stored: (H, W, C) values.

    Returns:
        The values, and how many texels were mended.
    """
    good = np.isfinite(stored)
    if good.all():
        return stored, 0
    values, weights = np.where(good, stored, 0.0).astype(np.float64), good.astype(np.float64)
    around, count = np.zeros_like(values), np.zeros_like(weights)
    for step in ((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)):
        around += np.roll(values, step, axis=(0, 1))
        count += np.roll(weights, step, axis=(0, 1))
    channel = values.sum(axis=(0, 1)) / np.maximum(weights.sum(axis=(0, 1)), 1.0)
    mean = np.where(count > 0, around / np.maximum(count, 1.0), channel)
    damaged = int((~good).any(axis=2).sum())
    return np.where(good, stored, mean).astype(np.float32), damaged


def _directed(normals: Floats) -> tuple[Floats, str]:
    """Normals that are directions, and what was lost: a picture without hue holds none."""
    flat = np.array([0.0, 0.0, 1.0], dtype=np.float32)
    if np.ptp(normals, axis=2).max(initial=0.0) < 1e-3:
        return flat.reshape(1, 1, 3), "a grey-scale picture cannot be a normal map; left out"
    nowhere = np.linalg.norm(normals, axis=2, keepdims=True) < 1e-3
    if not nowhere.any():
        return normals, ""
    return np.where(nowhere, flat, normals), "normals of length zero point outwards"


def _rgba(stored: Floats) -> Floats:
    count = stored.shape[2]
    color = stored[..., :3] if count >= 3 else np.repeat(stored[..., :1], 3, axis=2)
    alpha = stored[..., -1:] if count in (2, 4) else np.ones_like(stored[..., :1])
    return np.concatenate([color, alpha], axis=2)


def made_smaller(file: str, side: int) -> str:
    """What is lost of a picture that is longer than is kept."""
    return f"{file}: larger than {side} pixels, resized"


def within(stored: Floats, side: int = MAX_SIDE) -> Floats:
    """Halve a picture until its longer side fits."""
    while max(stored.shape[:2]) > side:
        height, width = (length // 2 * 2 for length in stored.shape[:2])
        even = stored[: max(height, 1), : max(width, 1)]
        rows = even if height == 0 else (even[::2] + even[1::2]) / 2
        halved = rows if width == 0 else (rows[:, ::2] + rows[:, 1::2]) / 2
        stored = np.asarray(halved, dtype=np.float32)
    return stored


def _wrapped(index: Array, size: int, mode: str) -> NDArray[np.intp]:
    whole = index.astype(np.intp)
    if mode == "clamp":
        return np.clip(whole, 0, size - 1)
    if mode == "mirror":
        folded = np.mod(whole, 2 * size)
        return np.where(folded < size, folded, 2 * size - 1 - folded)
    return np.mod(whole, size)
