"""Periodic noise on a square grid: everything here tiles without a seam."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

Field = NDArray[np.float64]

# Of a Gaussian, so that one number a wavelength describes a noise.
_SIGMA_OF_WAVELENGTH: Final = 0.35
# Mean radius of the power f^2 exp(-f^2), squared, in the plane: gamma(3.5) / (gamma(3) sqrt 2).
_BAND_MEAN: Final = 1.175


def white(rng: np.random.Generator, resolution: int) -> Field:
    """(N, N) independent values of mean 0 and standard deviation 1.

    Uniform, not normal: made of integers alone, so that every machine draws the same.
    """
    return (rng.random((resolution, resolution)) - 0.5) * math.sqrt(12.0)


def smooth_noise(
    rng: np.random.Generator, resolution: int, size: float, wavelength: tuple[float, float]
) -> Field:
    """Noise with features of a given size, of mean 0 and standard deviation 1.

    White noise filtered by a Gaussian in the frequency domain, therefore periodic.

    Args:
        rng: Where the noise comes from.
        resolution: Texels along each side.
        size: Length of each side, metres.
        wavelength: Size of its features along s and along t, metres.

    Returns:
        (N, N), rows downwards.
    """
    frequency = np.fft.fftfreq(resolution, size / resolution)
    sigma_s, sigma_t = (_SIGMA_OF_WAVELENGTH * length for length in wavelength)
    along_s = np.exp(-2.0 * (np.pi * sigma_s * frequency[: resolution // 2 + 1]) ** 2)
    along_t = np.exp(-2.0 * (np.pi * sigma_t * frequency) ** 2)
    spectrum = np.fft.rfft2(white(rng, resolution)) * along_t[:, None] * along_s
    return standardized(np.fft.irfft2(spectrum, s=(resolution, resolution)))


def band_noise(rng: np.random.Generator, resolution: int, size: float, wavelength: float) -> Field:
    """Noise of about one wavelength, such as stipple, of mean 0 and standard deviation 1.

    Args:
        rng: Where the noise comes from.
        resolution: Texels along each side.
        size: Length of each side, metres.
        wavelength: Distance from crest to crest, metres.
    """
    frequency = np.fft.fftfreq(resolution, size / resolution)
    radius = np.hypot(frequency[:, None], frequency[: resolution // 2 + 1])
    squared = (_BAND_MEAN * wavelength * radius) ** 2
    band = squared * np.exp(1.0 - squared)
    spectrum = np.fft.rfft2(white(rng, resolution)) * band
    return standardized(np.fft.irfft2(spectrum, s=(resolution, resolution)))


def standardized(field: Field) -> Field:
    """A field of mean 0 and standard deviation 1; zeros where it is constant."""
    centered = field - field.mean()
    deviation = float(np.sqrt(np.mean(centered**2)))
    return centered / deviation if deviation > 1e-12 else np.zeros_like(centered)


def smoothstep(low: float, high: float, x: Field) -> Field:
    """0 below ``low``, 1 above ``high``, smooth between."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)
