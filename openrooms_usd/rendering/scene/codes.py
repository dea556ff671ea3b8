"""Pictures of 8 bits that stay what they are: a quarter of the memory, and read in a tenth of time.

Their decoding, scale, offset and limits are the same for every texel of a channel, so that 256
levels say all. What is not that simple is left to `pictures.load`.
"""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Bytes
from openrooms_usd.colorimetry import linear_from_srgb, srgb_from_linear
from openrooms_usd.rendering.scene.pictures import (
    MAX_SIDE,
    Coding,
    Limits,
    Picture,
    are_directions,
    load,
    made_smaller,
    placed,
)
from openrooms_usd.rendering.scene.wrapping import framed
from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE, Texture, chosen, taken
from openrooms_usd.usd.shading.textures import read_codes

_OPAQUE_CODE: Final = 255


# A picture's codes by its file, the channel that is asked for, how many are needed, the longest
# side and whether the codes are sRGB; with the numbers of its channels, and whether it was made
# smaller. None: it is not stored so.
_Key = tuple[str, str, int, int, bool]
Known = dict[_Key, tuple[Bytes, tuple[int, ...], bool] | None]
# Rows that are made smaller at once.
_ROWS_AT_ONCE: Final = 64


def load_picture(
    texture: Texture, channels: int, limits: Limits, uv: Array, known: Known, side: int = MAX_SIDE
) -> Picture:
    """Read a texture as `pictures.load` does, in 8 bits where that loses nothing.

    Args:
        texture: What the material says.
        channels: 1 or 3: what the input needs.
        limits: The least and the greatest value that make sense.
        uv: (3, 3) from the mesh's texture coordinates to the picture's.
        known: What was read before: materials that differ in tint and place share their codes.
        side: The longest side that is kept as it is, pixels.
    """
    key = (texture.file, texture.channel, channels, side, texture.color_space == "sRGB")
    if key not in known:
        known[key] = _read(*key)
    found = known[key]
    if found is None:
        return load(texture, channels, limits, uv, side)
    picked, which, smaller = found
    directed = are_directions(channels, limits)
    if directed and not _is_normal_map(texture, picked):
        return load(texture, channels, limits, uv, side)
    coding = Coding(
        texture.color_space == "sRGB" and 3 not in which,
        taken(texture, texture.scale, channels),
        taken(texture, texture.bias, channels),
        limits,
    )
    black = None if directed else np.zeros(channels, np.uint8)
    texels, wrap, where, losses = framed(picked, texture, black)
    losses = (made_smaller(texture.file, side), *losses) if smaller else losses
    return Picture(np.ascontiguousarray(texels), wrap, placed(where, uv), losses, coding)


def _read(
    file: str, channel: str, channels: int, side: int, is_srgb: bool
) -> tuple[Bytes, tuple[int, ...], bool] | None:
    """The codes of the channels that are asked for, the lowest row first, and which these are."""
    codes = read_codes(file)
    if codes is None:
        return None
    which = chosen(channel, channels)
    if 3 in which and len(set(which)) > 1:
        return None
    picked = _picked(codes, which)
    smaller = max(codes.shape[:2]) > side
    if smaller:
        picked = _shrunk(picked, side, is_srgb=is_srgb and 3 not in which)
    return np.ascontiguousarray(picked[::-1]), which, smaller


def _shrunk(codes: Bytes, side: int, *, is_srgb: bool) -> Bytes:
    """Codes of the means of squares, whose sides are a power of two, so that the longer side fits.

    Means are of what the codes stand for; the new codes are off by half a step at most.
    """
    factor = 1
    while max(codes.shape[:2]) > side * factor:
        factor *= 2
    high, wide = (max(1, length // factor) for length in codes.shape[:2])
    down, across = (min(factor, length) for length in codes.shape[:2])
    steps = np.arange(256, dtype=np.float32) / np.float32(255.0)
    levels = linear_from_srgb(steps) if is_srgb else steps
    found = np.empty((high, wide, codes.shape[2]), np.uint8)
    for start in range(0, high, _ROWS_AT_ONCE):
        some = codes[start * down : (start + _ROWS_AT_ONCE) * down, : wide * across]
        rows = min(_ROWS_AT_ONCE, high - start)
        blocks = levels[some[: rows * down]].reshape(rows, down, wide, across, -1)
        means = blocks.mean(axis=(1, 3))
        encoded = srgb_from_linear(means) if is_srgb else means
        found[start : start + rows] = np.round(255.0 * encoded).astype(np.uint8)
    return found


def _picked(codes: Bytes, which: tuple[int, ...]) -> Bytes:
    """The channels that are asked for, of r, g, b and a."""
    count = codes.shape[2]
    if which[0] == 3:
        alpha = codes[..., -1:] if count in (2, 4) else np.full_like(codes[..., :1], _OPAQUE_CODE)
        return np.repeat(alpha, len(which), axis=2)
    stored = [index if count >= 3 else 0 for index in which]
    return codes if stored == list(range(count)) else codes[..., stored]


def _is_normal_map(texture: Texture, codes: Bytes) -> bool:
    """Whether it is stored as usual and holds directions: its channels differ."""
    usual = texture.scale == NORMAL_SCALE and texture.bias == NORMAL_BIAS
    return usual and not np.array_equal(codes[..., 0], codes[..., 2])
