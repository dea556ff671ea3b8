"""How bright a point is drawn: a light at the camera, and soft light from all around."""

from collections.abc import Mapping
from typing import Final

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# What is drawn where nothing is seen: a pale sky.
BACKGROUND: Final = np.array([0.78, 0.84, 0.92])
# What the light at the camera gives of a white surface that faces it; the rest comes from around.
_HEADLIGHT_SHARE: Final = 0.35
# How much darker soft light is from below than from above.
_LOSS_FROM_BELOW: Final = 0.35


def shade(seen: Mapping[str, Array], directions: Array, free: Array) -> Array:
    """(R, 3) colours of points, where white that faces the camera, upwards and in the open, is 1.

    Args:
        seen: (R, C) of the channels ``base_color``, ``normal`` (world) and ``emission_mask``.
        directions: (R, 3) from the camera to the points, of any length.
        free: (R,) how much of the hemisphere is free, from 0 to 1.
    """
    normals = seen["normal"]
    lengths = np.linalg.norm(directions, axis=1)
    facing = np.maximum(-np.einsum("ij,ij->i", normals, directions) / lengths, 0.0)
    above = 1.0 - _LOSS_FROM_BELOW * 0.5 * (1.0 - normals[:, 2])
    light = _HEADLIGHT_SHARE * facing + (1.0 - _HEADLIGHT_SHARE) * free * above
    # What shines is white, whatever its colour when it is off.
    return np.asarray(
        np.where(seen["emission_mask"] > 0.0, 1.0, seen["base_color"] * light[:, None])
    )
