"""Colour for people: exposure, a film-like curve, a colour map and a palette.

Nothing here touches data: what is written to EXR files stays scene-linear and unexposed.
"""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Bytes, Mask
from openrooms_usd.colorimetry import LUMINANCE, srgb_from_linear

Array = NDArray[np.floating[Any]]

_LUMINANCE: Final = LUMINANCE.astype(np.float32)
MIDDLE_GREY: Final = 0.18
KEY: Final = 0.27  # a little above middle grey: rooms have light walls
_BLOCK_PIXELS: Final = 8
NONFINITE: Final = (255, 0, 255)

# AgX (T. Sobotka, https://github.com/sobotka/AgX): the primaries move towards each other before
# the curve and back after it, so that bright colours fade to white as they do on film.
_PRIMARIES: Final = np.array(
    [
        [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
        [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
        [0.0423756549057051, 0.0784336, 0.879142973793104],
    ]
)
_INSET: Final = _PRIMARIES / _PRIMARIES.sum(axis=1, keepdims=True)  # so that grey stays grey
_OUTSET: Final = np.linalg.inv(_INSET)
_STOPS: Final = (-10.0, 6.5)  # what the curve covers, relative to middle grey
_SLOPE, _POWER = 2.4, 1.5
_GAMMA: Final = 2.2  # of the display that the curve was drawn for
# Of the pixels of a block that is lit: noise leaves some of them black.
_LEAST_LIT_SHARE: Final = 0.75

_PLASTIC: Final = 1.22074408460575947536  # the root of x^4 = x + 1


def quantize(values: Array) -> Bytes:
    """[0, 1] to the nearest of 256 steps; what is not finite becomes 0."""
    return (np.clip(np.nan_to_num(values, posinf=0, neginf=0), 0, 1) * 255 + 0.5).astype(np.uint8)


def fitted_exposure(radiance: Array) -> float:
    """The factor that brings a picture's log-average luminance to `KEY`.

    It counts blocks of 8x8 pixels, whose noise is small, and the darkest and brightest twentieth
    of them as their borders, so that neither a lamp in view nor a black corner decides (after E.
    Reinhard et al., Photographic Tone Reproduction for Digital Images, 2002, equation 1). Where
    there is nothing behind what is seen, blocks at its outline do not count (`lit_blocks`).

    Args:
        radiance: (height, width, 3) scene-linear.

    Returns:
        The factor; 1 for a picture without light.
    """
    lit = block_means(radiance @ _LUMINANCE)[lit_blocks(radiance)]
    if not lit.size:
        return 1.0
    logarithms = np.log(lit)
    low, high = np.percentile(logarithms, (5, 95))
    return float(KEY / np.exp(np.clip(logarithms, low, high).mean()))


def block_means(values: Array) -> Array:
    """(height, width) to its blocks' means; what is left over at two edges does not count."""
    rows, columns = (max(1, size // _BLOCK_PIXELS) for size in values.shape)
    high, wide = (min(size, _BLOCK_PIXELS) for size in values.shape)
    cut = values[: rows * high, : columns * wide].astype(np.float64)
    return np.asarray(cut.reshape(rows, high, columns, wide).mean(axis=(1, 3)))


def lit_blocks(radiance: Array) -> Mask:
    """Which of a picture's blocks show something that is lit: finite, and hardly black anywhere.

    Where none is so, in noise for instance, those that are not black throughout.

    Args:
        radiance: (height, width, 3) scene-linear.
    """
    luminance = radiance @ _LUMINANCE
    means = block_means(luminance)
    lit = np.isfinite(means) & (means > 0)
    whole = lit & (block_means((luminance > 0).astype(np.float32)) >= _LEAST_LIT_SHARE)
    return whole if whole.any() else lit


def film(linear: Array) -> Array:
    """Compress exposed scene-linear values into [0, 1] display-linear ones with the AgX curve.

    Args:
        linear: (..., 3); middle grey is 0.18 and stays 0.18.

    Returns:
        The same shape; encode as sRGB to look at it.
    """
    low, high = _STOPS
    inset = np.maximum(linear @ _INSET.T, 1e-10)
    stops = np.log2(inset / MIDDLE_GREY)
    curved = _sigmoid((np.clip(stops, low, high) - low) / (high - low))
    return np.asarray(np.clip(curved @ _OUTSET.T, 0, 1) ** _GAMMA)


def _sigmoid(x: Array) -> Array:
    """A straight line through middle grey that bends into 0 at 0 and into 1 at 1."""
    middle_x = -_STOPS[0] / (_STOPS[1] - _STOPS[0])
    middle_y = MIDDLE_GREY ** (1 / _GAMMA)
    line = _SLOPE * (x - middle_x)
    toe = _bend(_SLOPE * middle_x, middle_y)
    shoulder = _bend(_SLOPE * (1 - middle_x), 1 - middle_y)
    limit = np.where(line < 0, toe, shoulder)
    return np.asarray(middle_y + line / (1 + np.abs(line / limit) ** _POWER) ** (1 / _POWER))


def _bend(run: float, rise: float) -> float:
    """The limit for which the bent line rises by ``rise`` where the straight one would by ``run``.

    Solves run / (1 + (run / limit)^p)^(1/p) = rise.
    """
    return float((rise**-_POWER - run**-_POWER) ** (-1 / _POWER))


def ramp(x: Array) -> Array:
    """A colour map from bright yellow at 0 to dark blue at 1, of evenly falling lightness.

    It is a straight line in lightness and hue of OKLab (B. Ottosson, A perceptual color space for
    image processing, 2020).

    Args:
        x: (...) in [0, 1].

    Returns:
        (..., 3) sRGB-encoded in [0, 1].
    """
    t = np.clip(np.asarray(x, np.float32), 0, 1)
    hue = np.radians(105 + 180 * t)
    return srgb_from_linear(_from_oklab(0.94 - 0.70 * t, 0.09 * np.cos(hue), 0.09 * np.sin(hue)))


def _from_oklab(L: Array, a: Array, b: Array) -> Array:
    """OKLab to linear Rec.709."""
    cone = np.stack(
        [
            L + 0.3963377774 * a + 0.2158037573 * b,
            L - 0.1055613458 * a - 0.0638541728 * b,
            L - 0.0894841775 * a - 1.2914855480 * b,
        ],
        axis=-1,
    )
    linear = cone**3 @ np.array(
        [
            [4.0767416621, -1.2684380046, -0.0041960863],
            [-3.3077115913, 2.6097574011, -0.7034186147],
            [0.2309699292, -0.3413193965, 1.7076147010],
        ]
    )
    return np.asarray(linear)


def palette(ids: NDArray[np.integer[Any]]) -> Bytes:
    """A colour for every number, the same in every picture; 0 is black.

    Hue, lightness and chroma follow a low-discrepancy sequence, so that colours stay apart however
    many numbers there are (M. Roberts, The unreasonable effectiveness of quasirandom sequences).

    Args:
        ids: (...) from 0.

    Returns:
        (..., 3) sRGB.
    """
    unique, where = np.unique(ids, return_inverse=True)
    u, v, w = (unique * _PLASTIC**-k % 1.0 for k in (1, 2, 3))
    hue, lightness, chroma = 2 * np.pi * u, 0.48 + 0.37 * v, 0.05 + 0.10 * w
    linear = _from_oklab(lightness, chroma * np.cos(hue), chroma * np.sin(hue))
    colors = quantize(srgb_from_linear(linear))
    colors[unique == 0] = 0
    return np.asarray(colors[where.reshape(np.shape(ids))])
