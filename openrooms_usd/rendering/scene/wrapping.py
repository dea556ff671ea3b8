"""How pictures go on beyond their edges, where renderers know one way for both directions.

Black is a frame of black texels that goes on for ever, and a mirrored picture is twice as long.
"""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.usd.shading.surfaces import Texture

_ENDING: Final = frozenset({"clamp", "black"})
_GOING_ON: Final = frozenset({"repeat", "mirror"})


def framed(
    texels: NDArray[Any], texture: Texture, black: NDArray[Any] | None
) -> tuple[NDArray[Any], str, NDArray[np.float64], tuple[str, ...]]:
    """A picture that goes on in one way in both directions, as its texture says.

    Args:
        texels: (H, W, C), the first row at the bottom.
        texture: Which says how it goes on.
        black: (C,) what lies beyond where that is black; None where black means nothing, as of
            directions.

    Returns:
        The texels, how they go on (``repeat``, ``mirror`` or ``clamp``), (3, 3) from the texture's
        coordinates to theirs, and what was lost.
    """
    ways = texture.wrap_s, texture.wrap_t
    kinds, where = frozenset(ways), np.eye(3)
    losses: tuple[str, ...] = ()
    if kinds <= _ENDING:
        for axis, way in enumerate(ways):
            if way == "black" and black is not None:
                texels = _bordered(texels, 1 - axis, black, where[axis])
        if "black" in kinds and black is None:
            losses = (f"{texture.file}: black beyond its edge is taken as clamp",)
        return texels, "clamp", where, losses
    if kinds == _GOING_ON:
        axis = ways.index("mirror")
        where[axis] /= 2.0
        doubled = np.concatenate([texels, np.flip(texels, 1 - axis)], axis=1 - axis)
        return doubled, "repeat", where, ()
    wrap = "clamp" if texture.wrap_s == "black" else texture.wrap_s
    if len(kinds) > 1:
        losses = (f"{texture.file}: wraps differ; {wrap} is used in both directions",)
    return texels, wrap, where, losses


def _bordered(
    texels: NDArray[Any], axis: int, black: NDArray[Any], row: NDArray[np.float64]
) -> NDArray[Any]:
    """With a line of black at both ends of an axis; ``row`` becomes that of its coordinates."""
    size = texels.shape[axis]
    row *= size / (size + 2.0)
    row[2] += 1.0 / (size + 2.0)
    line = np.broadcast_to(black.astype(texels.dtype), np.take(texels, [0], axis).shape)
    return np.concatenate([line, texels, line], axis=axis)
