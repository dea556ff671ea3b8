"""Paint: nearly one colour, with the relief that its tool leaves."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.library.textures.maps import Maps
from openrooms_usd.library.textures.noise import band_noise, smooth_noise

# Interior colours, scene-linear Rec.709: whites, greys, sand, sage, mist, blush, ochre.
COLORS: Final = (
    (0.80, 0.79, 0.76),
    (0.76, 0.74, 0.69),
    (0.72, 0.72, 0.71),
    (0.60, 0.60, 0.59),
    (0.70, 0.64, 0.54),
    (0.59, 0.63, 0.54),
    (0.58, 0.65, 0.69),
    (0.72, 0.61, 0.56),
    (0.71, 0.62, 0.43),
)


@dataclass(frozen=True)
class Finish:
    """How a paint is applied.

    Attributes:
        roughness: Range of its mean.
        stipple: Distance between the bumps along s and t, metres.
        relief: Standard deviation of their height, metres.
        waviness: Standard deviation of the height over a hand's breadth, metres.
        tint: Standard deviation of the colour's brightness.
    """

    roughness: tuple[float, float]
    stipple: float
    relief: float
    waviness: float
    tint: float


FINISHES: Final = {
    # Emulsion on plaster, by roller.
    "matt": Finish((0.75, 0.92), 0.0055, 20e-6, 100e-6, 0.006),
    # Lacquer on wood or metal, by spray gun: orange peel.
    "satin": Finish((0.34, 0.5), 0.004, 5e-6, 8e-6, 0.003),
    # Powder coat on metal, fine and even.
    "powder": Finish((0.45, 0.6), 0.0025, 6e-6, 0.0, 0.004),
}


def make(
    finish: Finish,
    rng: np.random.Generator,
    color: tuple[float, float, float] | None,
    roughness: float | None,
    resolution: int,
    size: float,
) -> Maps:
    """A painted surface.

    Args:
        finish: One of `FINISHES`.
        rng: What is not given is drawn from it.
        color: Mean base colour, scene-linear Rec.709.
        roughness: Mean perceptual roughness.
        resolution: Texels along each side.
        size: Physical length of each side, metres.
    """
    drawn = COLORS[int(rng.integers(len(COLORS)))]
    mean = np.array(drawn if color is None else color)
    gloss = rng.uniform(*finish.roughness) if roughness is None else roughness
    stipple = band_noise(rng, resolution, size, finish.stipple)
    wave = smooth_noise(rng, resolution, size, (0.12, 0.12))
    cloud = smooth_noise(rng, resolution, size, (0.05, 0.05))
    # Paint gathers in the hollows, where it also looks a little more matt.
    shade = 1.0 + finish.tint * (0.6 * cloud + 0.4 * wave) + 0.5 * finish.tint * stipple
    return Maps(
        albedo=mean * shade[..., None],
        height=finish.relief * stipple + finish.waviness * wave,
        roughness=gloss * (1.0 + 0.02 * cloud - 0.015 * stipple),
    )
