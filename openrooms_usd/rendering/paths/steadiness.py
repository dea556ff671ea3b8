"""What flickers: how much the same places of surfaces change from one frame to the next."""

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.colorimetry import LUMINANCE
from openrooms_usd.rendering.paths.reprojection import Taps

Pixels = NDArray[np.float32]


def flicker(now: Pixels, before: Pixels, taps: Taps) -> float:
    """The noise that two frames show at the same places, relative to their light.

    The root mean square over the surfaces that both see of the change of luminance, relative to
    sqrt(m^2 + 0.01 M^2) with m their mean there and M that of the picture, and over sqrt(2): of two
    frames with independent errors it is the relative standard error of one of them.

    Args:
        now: (H, W, 3) a frame, without its textures.
        before: (H, W, 3) the frame before it.
        taps: Where what ``now`` sees was in ``before``.

    Returns:
        0 where nothing is seen by both.
    """
    fresh = now.reshape(-1, 3) @ LUMINANCE
    old = taps((before.reshape(-1, 3) @ LUMINANCE).astype(np.float32))
    both = taps.found
    if not both.any():
        return 0.0
    mean = 0.5 * (fresh + old)
    scale = mean**2 + 0.01 * fresh.mean() ** 2
    change = np.divide((fresh - old) ** 2, scale, out=np.zeros_like(scale), where=scale > 0.0)
    return float(np.sqrt(change[both].mean() / 2.0))
