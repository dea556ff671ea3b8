"""Light becomes electrons, electrons become numbers: shot noise, read noise, a full well, steps.

The model of EMVA 1288 (Standard for characterization of image sensors, release 4.0, 2021, section
2): electrons come one by one, so their number is Poisson distributed; reading them out adds
Gaussian noise; the gain makes numbers of them, which are rounded. Of a number with gain K and mean
m above black the variance is K m + K^2 s^2 + 1/12, s the read noise: the photon transfer curve.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.description.dataset import Noise

Pixels = NDArray[np.float32]


@dataclass(frozen=True)
class Readout:
    """How a sensor counts.

    Attributes:
        white: Electrons of a pixel that is white in the picture.
        gain: Numbers an electron.
        black: The number of no light: noise below it is kept.
        most: The greatest number.
    """

    white: float
    gain: float
    black: int
    most: int

    @classmethod
    def of(cls, noise: Noise) -> "Readout":
        """The readout of a sensor: at twice the ISO half as many electrons are white."""
        most = 2**noise.bits - 1
        black = round(noise.black * most)
        white = noise.full_well * 100.0 / noise.iso
        return cls(white, (most - black) / white, black, most)


def counted(light: Pixels, noise: Noise, rng: np.random.Generator) -> NDArray[np.int64]:
    """The numbers that a sensor reads.

    Args:
        light: (..., components) light of which 1 is white; each component by pixels of its own.
        noise: The sensor.
        rng: Draws the noise.
    """
    readout = Readout.of(noise)
    wanted = np.clip(np.nan_to_num(light.astype(np.float64)), 0.0, None) * readout.white
    # What is a hundred times too bright fills the well by any draw; more could not be drawn.
    electrons = rng.poisson(np.minimum(wanted, 100.0 * noise.full_well)).astype(np.float64)
    electrons = np.minimum(electrons, noise.full_well)
    electrons += noise.read_noise * rng.standard_normal(electrons.shape)
    numbers = np.rint(readout.black + readout.gain * electrons)
    return np.asarray(np.clip(numbers, 0, readout.most), dtype=np.int64)


def light_of(numbers: NDArray[np.int64], noise: Noise) -> Pixels:
    """What the numbers say the light was, 1 white: less than 0 where noise was below black."""
    readout = Readout.of(noise)
    scale = readout.most - readout.black
    return ((numbers - readout.black) / scale).astype(np.float32)
