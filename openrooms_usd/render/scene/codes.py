"""Pictures of 8 bits that stay what they are: a quarter of the memory, and read in a tenth of time.

Their decoding, scale, offset and limits are the same for every texel of a channel, so that 256
levels say all. What is not that simple is left to `pictures.load`.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.render.scene.pictures import (
    MAX_SIDE,
    Array,
    Coding,
    Limits,
    Picture,
    load,
    placed,
)
from openrooms_usd.render.scene.wrapping import framed
from openrooms_usd.usd.surfaces import NORMAL_BIAS, NORMAL_SCALE, Texture
from openrooms_usd.usd.textures import read_codes

_OPAQUE_CODE: Final = 255


# A picture's codes by its file, the channel that is asked for, and how many are needed; with the
# numbers of its channels. None: it is not stored so.
Known = dict[tuple[str, str, int], tuple[NDArray[np.uint8], tuple[int, ...]] | None]


def load_picture(
    texture: Texture, channels: int, limits: Limits, uv: Array, known: Known
) -> Picture:
    """Read a texture as `pictures.load` does, in 8 bits where that loses nothing.

    Args:
        texture: What the material says.
        channels: 1 or 3: what the input needs.
        limits: The least and the greatest value that make sense.
        uv: (3, 3) from the mesh's texture coordinates to the picture's.
        known: What was read before: materials that differ in tint and place share their codes.
    """
    key = (texture.file, texture.channel, channels)
    if key not in known:
        known[key] = _read(*key)
    found = known[key]
    if found is None:
        return load(texture, channels, limits, uv)
    picked, which = found
    if limits[0] < 0.0 and not _is_normal_map(texture, picked):
        return load(texture, channels, limits, uv)
    coding = Coding(
        texture.color_space == "sRGB" and 3 not in which,
        tuple(texture.scale[index] for index in which),
        tuple(texture.bias[index] for index in which),
        limits,
    )
    black = None if limits[0] < 0.0 else np.zeros(channels, np.uint8)
    texels, wrap, where, losses = framed(picked, texture, black)
    return Picture(np.ascontiguousarray(texels), wrap, placed(where, uv), losses, coding)


def _read(
    file: str, channel: str, channels: int
) -> tuple[NDArray[np.uint8], tuple[int, ...]] | None:
    """The codes of the channels that are asked for, the lowest row first, and which these are."""
    codes = read_codes(file)
    if codes is None or max(codes.shape[:2]) > MAX_SIDE:
        return None
    picked, which = _picked(codes, channel, channels)
    return np.ascontiguousarray(picked[::-1]), which


def _picked(
    codes: NDArray[np.uint8], channel: str, channels: int
) -> tuple[NDArray[np.uint8], tuple[int, ...]]:
    """The channels that are asked for, and which of r, g, b, a they are."""
    count = codes.shape[2]
    which = tuple(range(channels)) if channel == "rgb" else ("rgba".index(channel),) * channels
    if which[0] == 3:
        alpha = codes[..., -1:] if count in (2, 4) else np.full_like(codes[..., :1], _OPAQUE_CODE)
        return np.repeat(alpha, channels, axis=2), which
    stored = [index if count >= 3 else 0 for index in which]
    return codes if stored == list(range(count)) else codes[..., stored], which


def _is_normal_map(texture: Texture, codes: NDArray[np.uint8]) -> bool:
    """Whether it is stored as usual and holds directions: its channels differ."""
    usual = texture.scale == NORMAL_SCALE and texture.bias == NORMAL_BIAS
    return usual and not np.array_equal(codes[..., 0], codes[..., 2])
