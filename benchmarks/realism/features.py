"""One picture as numbers: its tones, its colours, the spectrum and the gradients of its luminance.

All of them need sRGB pixels alone, so that renders and photographs are measured by the same code.
"""

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.colorimetry import linear_from_srgb, luminance

Array = NDArray[np.float64]
Pixels = NDArray[np.uint8]

# Frequencies that the slope of a spectrum is fitted to, cycles a pixel: between those that the
# frame itself brings and those that lenses, demosaicing and JPEG take away.
_SLOPE_BAND_CYCLES: Final = (0.02, 0.25)
# Levels out of 255 from which on a pixel counts as clipped, or as black.
_CLIPPED_LEVEL: Final = 254
_BLACK_LEVEL: Final = 2
# A patch of 8 x 8 pixels whose levels deviate by less than this has nothing on it.
_EMPTY_PATCH_LEVELS: Final = 0.8
_PATCH_PIXELS: Final = 8
# Added to luminances out of 1 before logarithms are taken: half of a level.
_HALF_LEVEL: Final = 0.5 / 255.0 / 12.92


def features(pixels: Pixels) -> dict[str, float]:
    """Measure a picture.

    Args:
        pixels: (H, W, 3) sRGB, 8 bits.

    Returns:
        By name:

        - `spectral slope`: of the power of luminance over frequency, in a log-log plot;
        - `gradient deviation`, `gradient kurtosis`: of the differences of the natural logarithm of
          luminance between neighbours;
        - `upright share`: the part of the gradients' energy that runs across, from upright edges;
        - `empty patches`: the share of patches of 8 x 8 pixels that deviate by less than a level;
        - `mean level`, `level deviation`: of encoded luminance, 0 to 1;
        - `contrast, stops`: between the 1st and the 99th percentile of luminance;
        - `log skewness`: of the logarithm of luminance;
        - `clipped share`, `black share`: of pixels with a component at the end of its range;
        - `colourfulness`: that of Hasler and Suesstrunk (2003);
        - `warmth`: mean of red minus blue over their sum, of linear values.
    """
    linear = linear_from_srgb(pixels.astype(np.float64) / 255.0)
    light = luminance(linear)
    logs = np.log(light + _HALF_LEVEL)
    levels = pixels.astype(np.float64) @ (0.2126, 0.7152, 0.0722)
    across, down = np.diff(logs, axis=1), np.diff(logs, axis=0)
    steps = np.concatenate([across.ravel(), down.ravel()])
    low, high = np.percentile(light + _HALF_LEVEL, (1.0, 99.0))
    return {
        "spectral slope": spectral_slope(light),
        "gradient deviation": float(steps.std()),
        "gradient kurtosis": _moment(steps, 4),
        "upright share": float((across**2).sum() / max(1e-12, float((steps**2).sum()))),
        "empty patches": float((_patches(levels).std(axis=1) < _EMPTY_PATCH_LEVELS).mean()),
        "mean level": float(levels.mean() / 255.0),
        "level deviation": float(levels.std() / 255.0),
        "contrast, stops": float(np.log2(high / low)),
        "log skewness": _moment(logs.ravel(), 3),
        "clipped share": float((pixels.max(axis=2) >= _CLIPPED_LEVEL).mean()),
        "black share": float((pixels.max(axis=2) <= _BLACK_LEVEL).mean()),
        "colourfulness": colourfulness(pixels),
        "warmth": float(
            (linear[..., 0] - linear[..., 2]).mean() / (linear[..., 0] + linear[..., 2]).mean()
        ),
    }


def spectral_slope(light: Array) -> float:
    """The exponent s of power ~ frequency^s, averaged over directions, with a Hann window.

    Args:
        light: (H, W) luminance in any unit.
    """
    height, width = light.shape
    window = np.outer(np.hanning(height), np.hanning(width))
    centred = (light - float((light * window).sum() / window.sum())) * window
    power = np.abs(np.fft.fft2(centred)) ** 2
    frequency = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width)[None, :])
    edges = np.geomspace(*_SLOPE_BAND_CYCLES, 13)
    ring = np.digitize(frequency.ravel(), edges)
    sums = np.bincount(ring, power.ravel(), minlength=len(edges) + 1)[1:-1]
    counts = np.bincount(ring, minlength=len(edges) + 1)[1:-1]
    middles = np.sqrt(edges[1:] * edges[:-1])
    filled = (counts > 0) & (sums > 0.0)
    if filled.sum() < 2:
        return 0.0
    mean = sums[filled] / counts[filled]
    return float(np.polyfit(np.log(middles[filled]), np.log(mean), 1)[0])


def colourfulness(pixels: Pixels) -> float:
    """Hasler and Suesstrunk, *Measuring colourfulness in natural images* (2003).

    0 is none, 15 slight, 33 moderate, 45 average, 59 quite colourful.
    """
    red, green, blue = np.moveaxis(pixels.astype(np.float64), 2, 0)
    opponent = np.stack([red - green, 0.5 * (red + green) - blue])
    spread = np.hypot(*opponent.std(axis=(1, 2)))
    return float(spread + 0.3 * np.hypot(*opponent.mean(axis=(1, 2))))


def _moment(values: Array, order: int) -> float:
    """A standardised moment; 3 for a normal distribution's kurtosis."""
    spread = float(values.std())
    return float((((values - values.mean()) / spread) ** order).mean()) if spread > 0.0 else 0.0


def _patches(levels: Array) -> NDArray[Any]:
    """(N, 64) the whole patches of a picture."""
    size = _PATCH_PIXELS
    height, width = (side // size * size for side in levels.shape)
    tiles = levels[:height, :width].reshape(height // size, size, width // size, size)
    return tiles.transpose(0, 2, 1, 3).reshape(-1, size * size)
