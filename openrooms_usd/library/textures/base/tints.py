"""Which colour and gloss an order has, given or drawn, and how a pattern keeps to them."""

from collections.abc import Sequence

import numpy as np

from openrooms_usd.library.textures.base.family import Color, Order
from openrooms_usd.library.textures.base.maps import ALBEDO_RANGE, ROUGHNESS_RANGE
from openrooms_usd.library.textures.base.noise import Field


def mean_color(order: Order, colors: Sequence[Color], spread: float = 0.15) -> Field:
    """(3,) the colour that is asked for, or one of some that are usual, a little varied.

    Args:
        order: What is asked for.
        colors: Usual mean colours, scene-linear Rec.709.
        spread: How much lighter or darker a drawn one may be.
    """
    drawn = colors[int(order.rng.integers(len(colors)))]
    varied = np.array(drawn) * order.rng.uniform(1.0 - spread, 1.0 + spread)
    return varied if order.color is None else np.array(order.color)


def tinted(pattern: Field, mean: Field | None = None) -> Field:
    """(N, N, 3) albedo with a pattern's contrasts and the given mean.

    What is nearly white or black has little contrast left: between bright threads the light
    bounces until it fills the hollows. So contrasts shrink to fit the range of albedo.

    Args:
        pattern: (N, N) or (N, N, 3) positive brightness.
        mean: (3,) mean colour; None: the pattern's own, which must then have three channels.
    """
    own = pattern.mean(axis=(0, 1))
    low, high = ALBEDO_RANGE
    wanted = np.clip(own if mean is None else mean, low, high)
    channels = pattern / own - 1.0
    if pattern.ndim == 2:
        channels = channels[..., None]
    above = max(float(np.max(wanted * channels.max(axis=(0, 1)) / (high - wanted + 1e-9))), 1.0)
    # Of the brightest channel: if another comes below the range, it is not seen.
    below = -float(channels.min(axis=(0, 1)).max()) / max(1.0 - low / float(wanted.max()), 1e-9)
    return np.asarray(np.clip(wanted + channels * (wanted / max(above, below)), low, high))


def around(mean: float, variation: Field) -> Field:
    """Roughness that varies about its mean, within what is physical."""
    return np.asarray(np.clip(mean + variation - variation.mean(), *ROUGHNESS_RANGE))
