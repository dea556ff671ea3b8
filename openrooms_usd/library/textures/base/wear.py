"""Use leaves its marks in gloss: rubbed places, smears of hands, dust; mild and of real size."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.description.substances import Substance
from openrooms_usd.library.textures.base.family import Order
from openrooms_usd.library.textures.base.maps import Maps
from openrooms_usd.library.textures.base.noise import Field, smooth_noise, smoothstep, standardized

# How much the roughness varies, share of its mean: clouds of a hand's width and more, and smears
# of fingers and cloths. Glossy things show both most; cloth and rubber take no polish.
_CLOUDS: Final[dict[Substance, float]] = {
    "leather": 0.05, "metal": 0.08, "paint": 0.05, "plastic": 0.06, "rough_stone": 0.02,
    "specular_stone": 0.06, "wood": 0.06,
}  # fmt: skip
_SMEARS: Final[dict[Substance, float]] = {
    "metal": 0.10, "paint": 0.05, "plastic": 0.10, "specular_stone": 0.08, "wood": 0.05,
}  # fmt: skip
_CLOUD_M: Final = 0.25
_SMEAR_M: Final = (0.02, 0.06)
# Long waves need few texels; they are drawn on a grid of so many and read between them.
_GRID_TEXELS: Final = 128


def worn(maps: Maps, order: Order, substance: Substance) -> Maps:
    """The maps with a roughness that use has changed here and there; its mean stays.

    Args:
        maps: As new.
        order: Their size; its generator draws the marks.
        substance: What it is.
    """
    clouds, smears = _CLOUDS.get(substance, 0.0), _SMEARS.get(substance, 0.0)
    if not clouds:
        return maps
    length = min(_CLOUD_M, 0.6 * order.size)
    marks = clouds * np.clip(_drawn(order, (length, length)), -2.0, 2.0)
    if smears and order.size > 2.0 * _SMEAR_M[1]:
        marks = marks + smears * smoothstep(1.2, 2.2, _drawn(order, _SMEAR_M))
    change = 1.0 + marks - marks.mean()
    return replace(maps, roughness=_read(change, order.resolution) * maps.roughness)


def _drawn(order: Order, lengths: tuple[float, float]) -> Field:
    return standardized(smooth_noise(order.rng, _GRID_TEXELS, order.size, lengths))


def _read(field: Field, resolution: int) -> Field:
    """A periodic field at the texels of another grid, linearly between its own."""
    n = len(field)
    place = (np.arange(resolution) + 0.5) * n / resolution - 0.5
    low = np.floor(place).astype(np.int64)
    share = place - low
    rows = field[low % n] * (1.0 - share[:, None]) + field[(low + 1) % n] * share[:, None]
    found: Field = rows[:, low % n] * (1.0 - share) + rows[:, (low + 1) % n] * share
    return found
