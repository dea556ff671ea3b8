"""Fibres: noise drawn out along a direction, periodic, and matted layers of it."""

import math
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base.noise import Field, standardized, white_spectrum

_SIGMA_OF_WAVELENGTH: Final = 0.35


def fibres(
    rng: np.random.Generator,
    resolution: int,
    size: float,
    width: float,
    length: float,
    angle: float,
) -> Field:
    """(N, N) fibres of one direction, of mean 0 and standard deviation 1.

    Args:
        rng: Where the noise comes from.
        resolution: Texels along each side.
        size: Length of each side, metres.
        width: Of a fibre, metres.
        length: Of a fibre, metres.
        angle: From t towards s, radians.
    """
    frequency = np.fft.fftfreq(resolution, size / resolution)
    # Rows run against t.
    ft, fs = -frequency[:, None], np.abs(frequency[: resolution // 2 + 1])
    along = (ft * math.cos(angle) + fs * math.sin(angle)) * length
    across = (fs * math.cos(angle) - ft * math.sin(angle)) * width
    kernel = np.exp(-2.0 * (math.pi * _SIGMA_OF_WAVELENGTH) ** 2 * (along**2 + across**2))
    spectrum = white_spectrum(rng, resolution) * kernel
    return standardized(np.fft.irfft2(spectrum, s=(resolution, resolution)))


def matted(
    rng: np.random.Generator,
    resolution: int,
    size: float,
    width: float,
    length: float,
    layers: int,
    spread: float = math.pi,
) -> Field:
    """(N, N) fibres that lie over each other: the highest of layers of different directions.

    Args:
        rng: Where the noise comes from.
        resolution: Texels along each side.
        size: Length of each side, metres.
        width: Of a fibre, metres.
        length: Of a fibre, metres.
        layers: How many directions there are.
        spread: Range of the directions about t, radians.
    """
    top = np.full((resolution, resolution), -9.0)
    for layer in range(layers):
        angle = ((layer + rng.random()) / layers - 0.5) * spread
        np.maximum(top, fibres(rng, resolution, size, width, length, angle), out=top)
    return standardized(top)
