"""How alike a render and a photograph are, whatever exposure and white balance the camera chose."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import linear_from_srgb, luminance, srgb_from_linear

_STEPS: Final = 12
_SMALLEST: Final = 1e-6
# Of structural similarity (Wang et al., 2004).
_WINDOW_PX: Final = 1.5
_C1, _C2 = 1e-4, 9e-4
_MOST_DB: Final = 60.0


@dataclass(frozen=True)
class Likeness:
    """Of a render and a photograph, after one gain for each primary.

    Attributes:
        psnr: Decibels.
        ssim: Structural similarity of luminance, up to 1.
    """

    psnr: float
    ssim: float

    def as_dict(self) -> dict[str, float]:
        """With four digits."""
        return {"psnr_db": round(self.psnr, 4), "ssim": round(self.ssim, 4)}


def likeness(radiance: Array, photograph: NDArray[np.uint8]) -> Likeness:
    """Compare a render with a photograph.

    Args:
        radiance: (H, W, 3) of the render, any unit.
        photograph: (H, W, 3) sRGB.
    """
    wanted = photograph / 255.0
    light = np.maximum(np.nan_to_num(radiance), 0.0)
    shown = np.stack([_balanced(light[..., c], wanted[..., c]) for c in range(3)], axis=-1)
    error = float(((shown - wanted) ** 2).mean())
    psnr = min(_MOST_DB, -10.0 * float(np.log10(max(error, 1e-12))))
    return Likeness(psnr, _structure(luminance(shown), luminance(wanted)))


def _balanced(light: Array, wanted: Array) -> Array:
    """One primary as shown, with the gain that brings it nearest to the photograph."""
    usable = (wanted > 0.02) & (wanted < 0.98) & (light > _SMALLEST)
    if not usable.any():
        return srgb_from_linear(np.clip(light, 0.0, 1.0))
    start = float(np.median(linear_from_srgb(wanted[usable]) / light[usable]))
    best, step = float(np.log(max(start, _SMALLEST))), 0.5
    cost = _cost(light, wanted, best)
    for _ in range(_STEPS):
        tries = [(_cost(light, wanted, best + move), best + move) for move in (-step, step)]
        lowest = min(tries)
        if lowest[0] < cost:
            cost, best = lowest
        else:
            step *= 0.5
    return _shown(light, best)


def _shown(light: Array, log_gain: float) -> Array:
    return srgb_from_linear(np.clip(light * np.exp(log_gain), 0.0, 1.0))


def _cost(light: Array, wanted: Array, log_gain: float) -> float:
    return float(((_shown(light, log_gain) - wanted) ** 2).mean())


def _structure(one: Array, other: Array) -> float:
    blurred = [gaussian_filter(values, _WINDOW_PX) for values in (one, other)]
    spread = [
        gaussian_filter(a * b, _WINDOW_PX) - blurred[i] * blurred[j]
        for a, b, i, j in ((one, one, 0, 0), (other, other, 1, 1), (one, other, 0, 1))
    ]
    first, second = blurred
    upper = (2.0 * first * second + _C1) * (2.0 * spread[2] + _C2)
    lower = (first**2 + second**2 + _C1) * (spread[0] + spread[1] + _C2)
    return float((upper / lower).mean())
