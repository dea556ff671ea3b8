"""Periodic noise on a square grid: everything here tiles without a seam.

A finer grid shows the same noise with more detail: its long waves are drawn first, and whatever
the resolution, the generator goes on as if one number had been drawn.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array

Field = Array
Spectrum = NDArray[np.complex128]

# Of a Gaussian, so that one number a wavelength describes a noise.
_SIGMA_OF_WAVELENGTH: Final = 0.35
# Mean radius of the power f^2 exp(-f^2), squared, in the plane: gamma(3.5) / (gamma(3) sqrt 2).
_BAND_MEAN: Final = 1.175


# The first block of frequencies, cycles a side; each further one is twice as wide.
_FIRST_BLOCK_CYCLES: Final = 16


def apart(rng: np.random.Generator) -> np.random.Generator:
    """A generator of its own: however much is drawn from it, ``rng`` goes on the same."""
    return np.random.Generator(np.random.PCG64(int(rng.integers(2**63))))


def white_spectrum(rng: np.random.Generator, resolution: int) -> Spectrum:
    """The Fourier transform (`numpy.fft.rfft2`) of white noise, up to its amplitude.

    Uniform, not normal: made of integers alone, so that every machine draws the same.

    Args:
        rng: One number is drawn from it.
        resolution: Texels along each side.

    Returns:
        (N, N // 2 + 1) independent real and imaginary parts. Frequencies that two resolutions have
        in common are the same in both.
    """
    key = int(rng.integers(2**63))
    spectrum = np.zeros((resolution, resolution // 2 + 1), complex)
    width = _FIRST_BLOCK_CYCLES
    while width < resolution:
        width *= 2
    # Wide blocks first, so that what narrower grids have in common replaces their middle.
    while width >= _FIRST_BLOCK_CYCLES:
        _put(spectrum, _block(np.random.Generator(np.random.PCG64([key, width])), width))
        width //= 2
    spectrum[0, 0] = 0.0
    # Of what does not vary along s, only the half that is symmetric stays in a real field.
    spectrum[:, 0] *= math.sqrt(2.0)
    return spectrum


def _block(rng: np.random.Generator, width: int) -> Spectrum:
    """(width, width // 2) values for frequencies of both signs along t, from 0 along s."""
    parts: Field = rng.random((width, width)) - 0.5
    return parts.view(complex)


def _put(spectrum: Spectrum, block: Spectrum) -> None:
    """Replace the frequencies that both have."""
    half = min(len(block), len(spectrum)) // 2
    columns = min(block.shape[1], spectrum.shape[1])
    spectrum[:half, :columns] = block[:half, :columns]
    spectrum[len(spectrum) - half :, :columns] = block[len(block) - half :, :columns]


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
    spectrum = white_spectrum(rng, resolution) * along_t[:, None] * along_s
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
    spectrum = white_spectrum(rng, resolution) * band
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
