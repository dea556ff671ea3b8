"""Textures as linear arrays, looked up exactly as Mitsuba's ``bitmap`` looks them up.

All colour decoding happens here, once, so that every backend and the ground-truth channels see
the same numbers.
"""

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.usd.surfaces import Texture
from openrooms_usd.usd.textures import read_texture

Array = NDArray[np.float64]

# Half precision keeps 11 bits: better than the 8 of most pictures, at half the memory.
_HALF_MAX: Final = 6e4
# The longest side of a picture that is kept as it is; longer ones are halved until they fit.
_MAX_SIDE: Final = 4096


@dataclass(frozen=True, eq=False)
class Picture:
    """A texture whose values are ready to use.

    Attributes:
        pixels: (H, W, C) half or float32, C = 1 or 3, the first row at v = 0 (the bottom).
        wrap: ``repeat``, ``mirror`` or ``clamp``, in both directions.
        uv: (3, 3) from the mesh's texture coordinates to the picture's.
        losses: What could not be kept, in words.
    """

    pixels: NDArray[np.floating]
    wrap: str = "repeat"
    uv: Array = field(default_factory=lambda: np.eye(3))
    losses: tuple[str, ...] = ()

    @property
    def channels(self) -> int:
        """1 or 3."""
        return int(self.pixels.shape[2])

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
        height, width, _ = self.pixels.shape
        uv = st @ self.uv[:2, :2].T + self.uv[:2, 2]
        x, y = uv[..., 0] * width - 0.5, uv[..., 1] * height - 0.5
        x0, y0 = np.floor(x), np.floor(y)
        fx, fy = (x - x0)[..., None], (y - y0)[..., None]
        columns = [_wrapped(x0 + step, width, self.wrap) for step in (0, 1)]
        rows = [_wrapped(y0 + step, height, self.wrap) for step in (0, 1)]
        low, high = (
            self.pixels[row, columns[0]] * (1 - fx) + self.pixels[row, columns[1]] * fx
            for row in rows
        )
        return np.asarray(low * (1 - fy) + high * fy, dtype=np.float64)


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


def load(texture: Texture, channels: int, limits: tuple[float, float], uv: Array) -> Picture:
    """Read a texture and apply its colour space, scale, bias and channel.

    Args:
        texture: What the material says; a file that cannot be read gives its fallback.
        channels: 1 or 3: what the input needs.
        limits: The least and the greatest value that make sense.
        uv: (3, 3) from the mesh's texture coordinates to the picture's.
    """
    losses = [*_unsupported(texture)]
    try:
        stored = read_texture(texture.file)
    except InputError as error:
        losses.append(f"{texture.file}: {error.message}; its fallback colour is used")
        values = np.array(texture.fallback, dtype=np.float32).reshape(1, 1, 4)
    else:
        if max(stored.shape[:2]) > _MAX_SIDE:
            losses.append(f"{texture.file}: longer than {_MAX_SIDE} pixels, made smaller")
        rgba = _rgba(within(stored))
        if texture.color_space == "sRGB":
            rgba[..., :3] = linear_from_srgb(rgba[..., :3])
        values = rgba * np.array(texture.scale, np.float32) + np.array(texture.bias, np.float32)
    picked = _picked(values, texture.channel, channels)
    if not np.isfinite(picked).all():
        losses.append(f"{texture.file}: pixels that are no numbers are taken as {limits[0]:g}")
        picked = np.nan_to_num(picked, nan=limits[0], posinf=limits[0], neginf=limits[0])
    pixels = np.clip(picked, *limits)[::-1]
    kind = np.float16 if pixels.max() < _HALF_MAX else np.float32
    return Picture(np.ascontiguousarray(pixels, dtype=kind), _wrap(texture), uv, tuple(losses))


def linear_from_srgb(encoded: NDArray[np.float32]) -> NDArray[np.float32]:
    """Decode sRGB (IEC 61966-2-1)."""
    power = ((np.maximum(encoded, 0.0) + 0.055) / 1.055) ** 2.4
    return np.where(encoded <= 0.04045, encoded / 12.92, power).astype(np.float32)


def _rgba(stored: NDArray[np.float32]) -> NDArray[np.float32]:
    count = stored.shape[2]
    color = stored[..., :3] if count >= 3 else np.repeat(stored[..., :1], 3, axis=2)
    alpha = stored[..., -1:] if count in (2, 4) else np.ones_like(stored[..., :1])
    return np.concatenate([color, alpha], axis=2)


def _picked(rgba: NDArray[np.float32], channel: str, channels: int) -> NDArray[np.float32]:
    if channel == "rgb":
        # A single number that is fed by a colour takes its first channel, as Hydra does.
        return rgba[..., :channels]
    index = "rgba".index(channel)
    return np.repeat(rgba[..., index : index + 1], channels, axis=2)


def within(stored: NDArray[np.float32]) -> NDArray[np.float32]:
    """Halve a picture until its longer side fits."""
    while max(stored.shape[:2]) > _MAX_SIDE:
        height, width = (side // 2 * 2 for side in stored.shape[:2])
        even = stored[: max(height, 1), : max(width, 1)]
        rows = even if height == 0 else (even[::2] + even[1::2]) / 2
        halved = rows if width == 0 else (rows[:, ::2] + rows[:, 1::2]) / 2
        stored = np.asarray(halved, dtype=np.float32)
    return stored


def _unsupported(texture: Texture) -> list[str]:
    if texture.wrap_s != texture.wrap_t:
        return [f"{texture.file}: wraps differ; {_wrap(texture)} is used in both directions"]
    if texture.wrap_s == "black":
        return [f"{texture.file}: black beyond its edge is taken as clamp"]
    return []


def _wrap(texture: Texture) -> str:
    return "clamp" if texture.wrap_s == "black" else texture.wrap_s


def _wrapped(index: Array, size: int, mode: str) -> NDArray[np.intp]:
    whole = index.astype(np.intp)
    if mode == "clamp":
        return np.clip(whole, 0, size - 1)
    if mode == "mirror":
        folded = np.mod(whole, 2 * size)
        return np.where(folded < size, folded, 2 * size - 1 - folded)
    return np.mod(whole, size)
