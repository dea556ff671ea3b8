"""From scene-linear light to a picture as a camera would show it: balance, exposure, curve.

Three tones (`openrooms_usd.description.rendering.ToneName`), for people alone: what is written to
EXR files stays as it is.

- ``photograph``: the white is balanced in part, as cameras do, so that lamps look warm and not
  orange. The exposure is the log-average's, a little lower where windows are bright. What is
  brighter than `_KNEE_STOPS` above middle grey is compressed until windows keep their detail. Then
  the AgX curve, with more contrast and colour.
- ``film``: the AgX curve alone.
- ``srgb``: nothing but the encoding; what is brighter than 1 is cut.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.colorimetry import LUMINANCE, srgb_from_linear
from openrooms_usd.description.rendering import ToneName
from openrooms_usd.rendering.color import (
    MIDDLE_GREY,
    block_means,
    film,
    fitted_exposure,
    lit_blocks,
)

Array = NDArray[np.floating[Any]]
Balance = tuple[float, float, float]

_TOLD: Final[Mapping[ToneName, str]] = {
    "photograph": "balanced white, windows that keep their detail, AgX with more contrast",
    "film": "AgX",
    "srgb": "sRGB, cut at 1",
}

# What rooms reflect in the mean, by primary and relative to green: wood and paint are warm.
_MEAN_REFLECTANCE: Final = np.array([1.05, 1.0, 0.93])
# Between which shares of a picture, by brightness, its light is judged.
_COUNTED_SHARES: Final = (0.2, 0.95)
# How far light is taken back towards white along the line from lamps to blue skies; and along it
# alone: rooms with green walls stay green. In logarithms of red and blue over green.
_BALANCED_SHARE: Final = 0.7
_WARM_TO_BLUE: Final = np.array([0.64, -1.0]) / np.hypot(0.64, 1.0)
# Light that is nearly white is left alone: up to so much of that logarithm.
_WHITE_ENOUGH: Final = 0.1
# No light is taken for more than this, that of lamps of 2900 K: cameras leave candles orange.
_MOST_CAST: Final = 1.45

# Stops above middle grey: what is brighter is compressed where the brightest part of the picture is
# above the second; the width of the bend.
_KNEE_STOPS: Final = 1.5
_BRIGHT_STOPS: Final = 3.9
_BEND_STOPS: Final = 0.5
_BRIGHT_PERCENTILE: Final = 98.5
# The exposure is lowered by so many stops for every one that the brightest part is too bright.
_LOWERED: Final = 0.15
_MAX_LOWERED_STOPS: Final = 0.4
_MIN_SLOPE: Final = 0.3
# And raised where the mean of the picture, encoded, would be less than this; a stop for so much.
_LEAST_LEVEL: Final = 0.47
_LEVEL_OF_A_STOP: Final = 0.13
_MAX_RAISED_STOPS: Final = 0.6

_CONTRAST: Final = 1.45
_SATURATION: Final = 1.25


@dataclass(frozen=True)
class Tone:
    """How one picture is shown.

    Attributes:
        name: Which of the three.
        exposure: What light is multiplied by.
        balance: Factors of the primaries that keep the luminance of what they balance.
        slope: Stops for each stop of what is brighter than the knee.
    """

    name: ToneName
    exposure: float
    balance: Balance = (1.0, 1.0, 1.0)
    slope: float = 1.0

    def shown(self, radiance: Array) -> Array:
        """(..., 3) scene-linear light as display-linear light in [0, 1]."""
        exposed = radiance * (np.float32(self.exposure) * np.array(self.balance, np.float32))
        if self.name == "srgb":
            return np.clip(exposed, 0.0, 1.0)
        if self.name == "film":
            return film(exposed)
        return _graded(film(_compressed(exposed, self.slope)))

    def told(self) -> str:
        """The tone in words."""
        words = [_TOLD[self.name]]
        if self.balance != (1.0, 1.0, 1.0):
            words.append("white balance " + " ".join(f"{factor:.3g}" for factor in self.balance))
        if self.slope < 1.0:
            words.append(f"{self.slope:.2g} stops a stop above {_KNEE_STOPS:g}")
        return ", ".join(words)


def fitted_tone(
    name: ToneName, radiance: Array, exposure: float | None = None, balance: Balance | None = None
) -> Tone:
    """The tone of a picture.

    Args:
        name: Which of the three.
        radiance: (height, width, 3) scene-linear.
        exposure: That of the camera; None fits it to the picture.
        balance: Its white balance, where it has one; None fits it to the picture.
    """
    if name != "photograph":
        return Tone(name, fitted_exposure(radiance) if exposure is None else exposure)
    balance = balance or white_balance(radiance)
    balanced = radiance * np.array(balance, np.float32)
    factor = fitted_exposure(balanced) if exposure is None else exposure
    bright = _bright_stops(balanced, factor)
    if exposure is None:
        lowered = float(np.clip(_LOWERED * (bright - _BRIGHT_STOPS), 0.0, _MAX_LOWERED_STOPS))
        factor, bright = factor * 2.0**-lowered, bright - lowered
    found = Tone(name, factor, balance, _slope(bright))
    if exposure is not None:
        return found
    short = (_LEAST_LEVEL - _mean_level(found, radiance)) / _LEVEL_OF_A_STOP
    raised = float(np.clip(short, 0.0, _MAX_RAISED_STOPS))
    return replace(found, exposure=factor * 2.0**raised, slope=_slope(bright + raised))


def _slope(bright: float) -> float:
    """Stops for each stop above the knee that bring the brightest part to `_BRIGHT_STOPS`."""
    wanted = (_BRIGHT_STOPS - _KNEE_STOPS) / (max(bright, _BRIGHT_STOPS) - _KNEE_STOPS)
    return max(wanted, _MIN_SLOPE)


def _mean_level(tone: Tone, radiance: Array) -> float:
    """The mean of what is shown, encoded; 1 where nothing is lit."""
    blocks = np.stack([block_means(radiance[..., i]) for i in range(3)], axis=-1)
    lit = blocks[lit_blocks(radiance)]
    if not (lit > 0.0).any():
        return 1.0
    return float(srgb_from_linear(tone.shown(lit) @ LUMINANCE).mean())


def white_balance(radiance: Array) -> Balance:
    """Factors of the primaries that take most of the cast of a picture's light away.

    The light is estimated as what a room of usual colours sends in the mean (grey world; G.
    Buchsbaum, A Spatial Processor Model for Object Colour Perception, 1980), in logarithms, so that
    a lamp in view does not decide.

    Args:
        radiance: (height, width, 3) scene-linear.
    """
    blocks = np.stack([block_means(radiance[..., i]) for i in range(3)], axis=-1).reshape(-1, 3)
    lit = blocks[np.isfinite(blocks).all(axis=1) & (blocks > 0.0).all(axis=1)]
    if not len(lit):
        return 1.0, 1.0, 1.0
    # Without the darkest, which say little, and the brightest, which are lamps and windows.
    ordered = lit[np.argsort(lit @ LUMINANCE, kind="stable")]
    first, last = (int(share * len(lit)) for share in _COUNTED_SHARES)
    mean = np.log(ordered[first : max(last, first + 1)]).mean(axis=0) - np.log(_MEAN_REFLECTANCE)
    along = float((mean[[0, 2]] - mean[1]) @ _WARM_TO_BLUE)
    cast = float(np.clip(abs(along) - _WHITE_ENOUGH, 0.0, _MOST_CAST))
    along = np.sign(along) * cast * _BALANCED_SHARE
    red, blue = np.exp(-along * _WARM_TO_BLUE)
    factors = np.array([red, 1.0, blue])
    light = np.exp(mean)
    factors *= float(light @ LUMINANCE) / float((light * factors) @ LUMINANCE)
    return float(factors[0]), float(factors[1]), float(factors[2])


def _bright_stops(radiance: Array, exposure: float) -> float:
    """How far above middle grey the brightest part of a picture is, lamps left aside."""
    blocks = block_means(radiance @ LUMINANCE.astype(np.float32)) * exposure
    finite = blocks[np.isfinite(blocks)]
    brightest = float(np.percentile(finite, _BRIGHT_PERCENTILE)) if finite.size else 0.0
    return float(np.log2(max(brightest, 1e-9) / MIDDLE_GREY))


def _compressed(exposed: Array, slope: float) -> Array:
    """Light with fewer stops above the knee; hues stay."""
    if slope >= 1.0:
        return exposed
    bright = np.maximum(exposed @ LUMINANCE.astype(np.float32), 1e-6)[..., None]
    above = (np.log2(bright / MIDDLE_GREY) - _KNEE_STOPS) / _BEND_STOPS
    # The logarithm of 1 + e^x bends from 0 to x.
    return np.asarray(exposed * 2.0 ** (-(1.0 - slope) * _BEND_STOPS * np.logaddexp(0.0, above)))


def _graded(shown: Array) -> Array:
    """More contrast about middle grey and more colour, both without leaving [0, 1]."""
    bright = np.maximum(shown @ LUMINANCE.astype(np.float32), 1e-6)[..., None]
    # x^c / (x^c + k (1 - x)^c) keeps 0, 1 and, by its k, middle grey.
    odds = (bright / np.maximum(1.0 - bright, 1e-6)) ** _CONTRAST
    grey = MIDDLE_GREY / (1.0 - MIDDLE_GREY)
    odds *= grey ** (1.0 - _CONTRAST)
    contrasted = odds / (1.0 + odds)
    saturated = bright + (shown - bright) * _SATURATION
    return np.asarray(np.clip(saturated * (contrasted / bright), 0.0, 1.0))
