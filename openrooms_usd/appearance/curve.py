"""How a camera turns light into the values of its files."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import linear_from_srgb, srgb_from_linear

_STEPS: Final = 2049


@dataclass(frozen=True)
class Curve:
    """The sRGB curve followed by an S of some strength, as phones have it.

    Attributes:
        strength: 0 leaves sRGB alone; 1 is all S, ``v^2 (3 - 2 v)``.
    """

    strength: float = 0.0

    def values(self, linear: Array) -> Array:
        """From 0 to 1, of linear light in which 1 is white."""
        v = srgb_from_linear(np.clip(linear, 0.0, 1.0))
        return np.asarray(v + self.strength * _bend(v))

    def slope(self, linear: Array) -> Array:
        """Their derivative."""
        x = np.clip(linear, 1e-6, 1.0)
        v = srgb_from_linear(x)
        toe = x <= 0.0031308
        first = np.where(toe, 12.92, 1.055 / 2.4 * np.maximum(x, 0.0031308) ** (1 / 2.4 - 1))
        return np.asarray(first * (1.0 + self.strength * (6.0 * v * (1.0 - v) - 1.0)))

    def by_strength(self, linear: Array) -> Array:
        """The derivative of values by the strength."""
        return _bend(srgb_from_linear(np.clip(linear, 0.0, 1.0)))

    def linear(self, values: Array) -> Array:
        """Linear light of values."""
        grid = np.linspace(0.0, 1.0, _STEPS)
        return np.asarray(
            linear_from_srgb(np.interp(values, grid + self.strength * _bend(grid), grid))
        )


def _bend(v: Array) -> Array:
    return np.asarray(v * v * (3.0 - 2.0 * v) - v)
