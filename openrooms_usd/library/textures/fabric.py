"""Fabric: yarns that go over and under each other. The warp runs along t, the weft along s.

Every yarn is a tube whose height follows the weave: up where it lies on top, down where it is
covered. The visible yarn is the higher one; its colour is its own, with melange along its length.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.library.textures.maps import Maps, with_mean
from openrooms_usd.library.textures.noise import Field, smooth_noise

# Upholstery colours, scene-linear Rec.709: greys, natural linen, blues, greens, rust, ochre, rose.
COLORS: Final = (
    (0.33, 0.33, 0.33),
    (0.12, 0.125, 0.13),
    (0.50, 0.46, 0.39),
    (0.40, 0.33, 0.25),
    (0.085, 0.13, 0.20),
    (0.20, 0.29, 0.36),
    (0.14, 0.21, 0.15),
    (0.30, 0.32, 0.22),
    (0.36, 0.14, 0.075),
    (0.45, 0.29, 0.09),
    (0.44, 0.27, 0.25),
)


@dataclass(frozen=True)
class Weave:
    """How yarns cross.

    Attributes:
        pattern: (n, m) 1 where the warp lies on top, rows along t; repeats.
        yarn: Range of the distance between neighbouring yarns, metres.
        contrast: Range of how much lighter the warp is than the weft.
        melange: Range of the colour's unevenness along a yarn.
        slub: How unevenly thick the yarns are, share of their distance.
    """

    pattern: tuple[tuple[int, ...], ...]
    yarn: tuple[float, float]
    contrast: tuple[float, float]
    melange: tuple[float, float]
    slub: float


WEAVES: Final = {
    # Linen-like cloth, as for curtains and shades.
    "plain": Weave(((1, 0), (0, 1)), (0.0016, 0.0022), (0.0, 0.15), (0.08, 0.18), 0.12),
    # Flat-woven upholstery with diagonal ribs.
    "twill": Weave(
        ((1, 1, 0, 0), (0, 1, 1, 0), (0, 0, 1, 1), (1, 0, 0, 1)),
        (0.0014, 0.002), (0.05, 0.35), (0.06, 0.14), 0.05,
    ),
    # Coarse upholstery, two by two.
    "basket": Weave(
        ((1, 1, 0, 0), (1, 1, 0, 0), (0, 0, 1, 1), (0, 0, 1, 1)),
        (0.0019, 0.0026), (0.0, 0.3), (0.08, 0.2), 0.10,
    ),
}  # fmt: skip

# Texels across a yarn below which its tube is drawn on a finer grid and averaged.
_FINE: Final = 7.0


def make(
    weave: Weave,
    rng: np.random.Generator,
    color: tuple[float, float, float] | None,
    roughness: float | None,
    resolution: int,
    size: float,
) -> Maps:
    """A woven cloth with a whole number of its pattern's repeats on each side.

    Args:
        weave: One of `WEAVES`.
        rng: What is not given is drawn from it.
        color: Mean base colour, scene-linear Rec.709.
        roughness: Mean perceptual roughness.
        resolution: Texels along each side.
        size: Physical length of each side, metres.
    """
    drawn = np.array(COLORS[int(rng.integers(len(COLORS)))]) * rng.uniform(0.85, 1.15)
    mean = drawn if color is None else np.array(color)
    matt = rng.uniform(0.8, 0.95) if roughness is None else roughness
    repeat = len(weave.pattern)
    yarns = repeat * max(1, round(size / rng.uniform(*weave.yarn) / repeat))
    finer = max(1, min(8, math.ceil(_FINE * yarns / resolution)))

    top, height = _woven(weave, rng, yarns, resolution * finer)
    tone = _tones(weave, rng, yarns, resolution * finer, top)
    radius = size / yarns / 2
    hollow = np.clip(0.5 + 0.5 * height, 0.0, 1.0)
    shade = _averaged(tone * (0.45 + 0.55 * hollow), finer)
    wrinkle = smooth_noise(rng, resolution, size, (0.06, 0.06))
    fuzz = smooth_noise(rng, resolution, size, (0.001, 0.001))
    shade = np.maximum(shade * (1.0 + 0.05 * fuzz + 0.02 * wrinkle), 0.05)
    return Maps(
        albedo=with_mean(shade[..., None] * np.ones(3), mean),
        height=radius * 0.7 * _averaged(height, finer) + 100e-6 * wrinkle,
        roughness=matt + 0.05 * (0.5 - _averaged(hollow, finer)),
    )


def _woven(
    weave: Weave, rng: np.random.Generator, yarns: int, resolution: int
) -> tuple[NDArray[np.bool_], Field]:
    """Which yarn is on top (True: warp) and how high it is, in radii, about -1..1."""
    place = (np.arange(resolution) + 0.5) / resolution * yarns
    bent = weave.slub * smooth_noise(rng, resolution, 1.0, (0.05, 0.05))
    warp = _tube(weave, place[None, :], place[:, None], bent)
    weft = _tube(weave, place[:, None], place[None, :], bent.T, warp=False)
    return warp >= weft, np.maximum(warp, weft)


def _tube(weave: Weave, across: Field, along: Field, bent: Field, *, warp: bool = True) -> Field:
    """(N, N) height of one set of yarns, in radii.

    Args:
        weave: The weave.
        across: Place across the yarns, in yarns.
        along: Place along them, in crossing yarns.
        bent: How far the yarns lie beside their place.
        warp: Whether they are the warp (across is s) or the weft (across is t).
    """
    pattern = np.array(weave.pattern)
    lift = 2.0 * pattern - 1.0 if warp else 1.0 - 2.0 * pattern
    lift = lift if warp else lift.T
    repeat = len(pattern)
    number = np.floor(across).astype(np.int64) % repeat
    crossing = np.floor(along).astype(np.int64)
    # From the middle of one crossing to the middle of the next, the yarn rises like a cosine.
    share = along - crossing - 0.5
    other = np.where(share >= 0, crossing + 1, crossing - 1)
    here, there = lift[crossing % repeat, number], lift[other % repeat, number]
    eased = 0.5 - 0.5 * np.cos(np.pi * np.abs(share))
    offset = np.clip(2.0 * (across - np.floor(across)) - 1.0 + bent * 0.3, -1.0, 1.0)
    rise = 0.45 * (here + (there - here) * eased)
    return np.asarray(rise + np.sqrt(1.0 - 0.95 * offset**2) - 0.5)


def _tones(
    weave: Weave,
    rng: np.random.Generator,
    yarns: int,
    resolution: int,
    top: NDArray[np.bool_],
) -> Field:
    """(N, N) brightness of the yarn on top: its own, and melange along its length."""
    contrast = rng.uniform(*weave.contrast) * rng.choice([-1.0, 1.0])
    melange = rng.uniform(*weave.melange)
    number = np.arange(resolution) * yarns // resolution
    own = 1.0 + 0.5 * melange * rng.uniform(-1.0, 1.0, (2, yarns))
    # One value per yarn and crossing would look like pixels: drawn along the yarn, on its length.
    grid = min(yarns, resolution)
    along = melange * smooth_noise(rng, grid, 1.0, (1e-3, 4.0 / grid))
    cells = np.arange(resolution) * grid // resolution
    warp = (1.0 + contrast / 2) * own[0][number][None, :] + along[cells][:, cells]
    weft = (1.0 - contrast / 2) * own[1][number][:, None] + along.T[cells][:, cells]
    return np.asarray(np.where(top, warp, weft))


def _averaged(field: Field, finer: int) -> Field:
    """Means over blocks of ``finer`` by ``finer``."""
    n = len(field) // finer
    return np.asarray(field.reshape(n, finer, n, finer).mean(axis=(1, 3)))
