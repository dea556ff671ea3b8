"""How pictures go on beyond their edges, in the fewest ways that say all.

Black is a frame of black texels that goes on for ever, and a picture that is mirrored in one
direction is twice as long.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.usd.shading.surfaces import Texture


def framed(
    texels: NDArray[Any], texture: Texture, black: NDArray[Any] | None
) -> tuple[NDArray[Any], str, Array, tuple[str, ...]]:
    """A picture, extended by its texture's wrap mode.

    Args:
        texels: (H, W, C), the first row at the bottom.
        texture: Which says how it goes on.
        black: (C,) what lies beyond where that is black; None where black means nothing, as of
            directions.

    Returns:
        The texels, how they go on (`Picture.wrap`), (3, 3) from the texture's
        coordinates to theirs, and what was lost.
    """
    ways, where = [texture.wrap_s, texture.wrap_t], np.eye(3)
    losses: tuple[str, ...] = ()
    if "black" in ways and black is None:
        losses = (f"{texture.file}: black beyond its edge is taken as clamp",)
    for axis, way in enumerate(tuple(ways)):
        if way == "black":
            if black is not None:
                texels = _bordered(texels, 1 - axis, black, where[axis])
            ways[axis] = "clamp"
        elif way == "mirror" and ways[1 - axis] != "mirror":
            texels = np.concatenate([texels, np.flip(texels, 1 - axis)], axis=1 - axis)
            where[axis] /= 2.0
            ways[axis] = "repeat"
    return texels, " ".join(dict.fromkeys(ways)), where, losses


def _bordered(texels: NDArray[Any], axis: int, black: NDArray[Any], row: Array) -> NDArray[Any]:
    """With a line of black at both ends of an axis; ``row`` becomes that of its coordinates."""
    size = texels.shape[axis]
    row *= size / (size + 2.0)
    row[2] += 1.0 / (size + 2.0)
    line = np.broadcast_to(black.astype(texels.dtype), np.take(texels, [0], axis).shape)
    return np.concatenate([line, texels, line], axis=axis)
