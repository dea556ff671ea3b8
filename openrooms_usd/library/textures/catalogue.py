"""All families by substance, how a material is ordered by its name, and laid over metres."""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.description.substances import Substance
from openrooms_usd.draws import generator
from openrooms_usd.errors import InputError
from openrooms_usd.library.textures import (
    fabric,
    leather,
    metal,
    paint,
    plastic,
    rough_stone,
    rubber,
    specular_stone,
    wood,
)
from openrooms_usd.library.textures.base.family import Color, Family, TextureParams
from openrooms_usd.library.textures.base.maps import Maps, TextureSet, encoded, with_mean
from openrooms_usd.library.textures.base.noise import Field, smooth_noise, smoothstep, standardized
from openrooms_usd.spelling import did_you_mean

# A small picture is laid many times without the eye finding its repeat. What repeats visibly is not
# the threads but the clouds in them. So the long waves of the small picture are taken out, and
# waves as strong are drawn anew over the whole.

# Waves of at most so many cycles a side of the small picture are long.
_LONG_CYCLES: Final = 3
# What is drawn over the whole: about as long as the small picture, ...
_LENGTH_SHARE: Final = 0.8
# ... and no stronger than this, share of the brightness.
_MAX_SHADE_SHARE: Final = 0.06
_MIN_SHADE_SHARE: Final = 0.02
_MAX_ROUGHNESS: Final = 0.02


def laid(small: Maps, order: TextureParams, count: int) -> Maps:
    """A small picture laid ``count`` times along each side.

    Args:
        small: What is laid.
        order: Of the whole; its generator draws the long waves.
        count: How often.
    """
    shade = small.albedo.mean(axis=2)
    long = _long_waves(shade) / shade.mean()
    strength = float(np.clip(np.std(long), _MIN_SHADE_SHARE, _MAX_SHADE_SHARE))
    wave = np.clip(_wave(order, count), -2.5, 2.5)
    even = small.albedo / (1.0 + np.clip(long, -0.5, 1.0))[..., None]
    shaded = _tiled(even, count) * (1.0 + strength * wave)[..., None]
    height = small.height - _long_waves(small.height)
    rough = small.roughness - _long_waves(small.roughness)
    return replace(
        small,
        albedo=with_mean(shaded, small.albedo.mean(axis=(0, 1))),
        height=_tiled(height, count),
        roughness=_tiled(rough, count) + _MAX_ROUGHNESS * (wave - wave.mean()),
        metallic=_tiled(small.metallic, count)
        if isinstance(small.metallic, np.ndarray)
        else small.metallic,
    )


def _wave(order: TextureParams, count: int) -> Field:
    length = _LENGTH_SHARE * order.size / count
    return smooth_noise(order.rng, order.resolution, order.size, (length, length))


def _tiled(field: Field, count: int) -> Field:
    return np.tile(field, (count, count, *(1,) * (field.ndim - 2)))


def _long_waves(field: Field) -> Field:
    """What a periodic field has of a few cycles a side, without its mean."""
    spectrum = np.fft.rfft2(field)
    rows = np.abs(np.fft.fftfreq(len(field), 1.0 / len(field)))
    columns = np.arange(spectrum.shape[1])
    kept = np.hypot(rows[:, None], columns) <= _LONG_CYCLES
    kept[0, 0] = False
    return np.fft.irfft2(spectrum * kept, s=field.shape)


# How much the roughness varies, share of its mean: clouds of a hand's width and more, and smears
# of fingers and cloths. Glossy things show both most; cloth and rubber take no polish.
_CLOUDS: Final[dict[Substance, float]] = {
    "leather": 0.05,
    "metal": 0.08,
    "paint": 0.05,
    "plastic": 0.06,
    "rough_stone": 0.02,
    "specular_stone": 0.06,
    "wood": 0.06,
}
_SMEARS: Final[dict[Substance, float]] = {
    "metal": 0.10,
    "paint": 0.05,
    "plastic": 0.10,
    "specular_stone": 0.08,
    "wood": 0.05,
}
_CLOUD_M: Final = 0.25
_SMEAR_M: Final = (0.02, 0.06)
# Long waves need few texels; they are drawn on a grid of so many and read between them.
_GRID_TEXELS: Final = 128


def worn(maps: Maps, order: TextureParams, substance: Substance) -> Maps:
    """The maps with a roughness that use has changed here and there; its mean stays.

    Args:
        maps: As new.
        order: Their size; its generator draws the marks.
        substance: What it is.
    """
    clouds, smears = _CLOUDS.get(substance, 0.0), _SMEARS.get(substance, 0.0)
    if not clouds:
        return maps
    length = min(_CLOUD_M, 0.6 * order.size)
    marks = clouds * np.clip(_drawn(order, (length, length)), -2.0, 2.0)
    if smears and order.size > 2.0 * _SMEAR_M[1]:
        marks = marks + smears * smoothstep(1.2, 2.2, _drawn(order, _SMEAR_M))
    change = 1.0 + marks - marks.mean()
    return replace(maps, roughness=_read(change, order.resolution) * maps.roughness)


def _drawn(order: TextureParams, lengths: tuple[float, float]) -> Field:
    return standardized(smooth_noise(order.rng, _GRID_TEXELS, order.size, lengths))


def _read(field: Field, resolution: int) -> Field:
    """A periodic field at the texels of another grid, linearly between its own."""
    n = len(field)
    place = (np.arange(resolution) + 0.5) * n / resolution - 0.5
    low = np.floor(place).astype(np.int64)
    share = place - low
    rows = field[low % n] * (1.0 - share[:, None]) + field[(low + 1) % n] * share[:, None]
    found: Field = rows[:, low % n] * (1.0 - share) + rows[:, (low + 1) % n] * share
    return found


DEFAULT_RESOLUTION: Final = 1024
# Quotients of lengths are not whole numbers.
_LESS: Final = 1e-6

FAMILIES: Final[dict[Substance, dict[str, Family]]] = {
    "fabric": fabric.FAMILIES,
    "leather": leather.FAMILIES,
    "metal": metal.FAMILIES,
    "paint": paint.FAMILIES,
    "plastic": plastic.FAMILIES,
    "rough_stone": rough_stone.FAMILIES,
    "rubber": rubber.FAMILIES,
    "specular_stone": specular_stone.FAMILIES,
    "wood": wood.FAMILIES,
}

_SUBSTANCES: Final = {name: kind for kind, families in FAMILIES.items() for name in families}


def substance_of(name: str) -> Substance:
    """The substance of a family.

    Raises:
        InputError: There is no such family.
    """
    if name not in _SUBSTANCES:
        raise InputError(
            f"no material family {name!r}{did_you_mean(name, _SUBSTANCES)}",
            remedy="`orusd materials list` has all",
        )
    return _SUBSTANCES[name]


def family_of(name: str) -> Family:
    """A family by its name.

    Raises:
        InputError: There is no such family.
    """
    return FAMILIES[substance_of(name)][name]


def make(
    name: str,
    number: int,
    *,
    color: Color | None = None,
    roughness: float | None = None,
    resolution: int = DEFAULT_RESOLUTION,
    size: float | None = None,
) -> TextureSet:
    """Make one material of a family: name and number alone say which, in whatever room.

    Args:
        name: The family.
        number: Which of its materials, from 0.
        color: Mean base colour, scene-linear Rec.709, in place of the material's own.
        roughness: Mean perceptual roughness, in place of the material's own.
        resolution: Texels along each side.
        size: Physical length of each side, metres; by default the family's usual size.

    Raises:
        InputError: There is no such family.
    """
    family = family_of(name)
    metres = family.size if size is None else size
    order = TextureParams(generator(number, "textures", name), resolution, metres, color, roughness)
    over = replace(order, rng=generator(number, "textures", name, "over"))
    count = _repeats_per_side(family, order)
    if count > 1:
        small = replace(order, resolution=resolution // count, size=metres / count)
        maps = laid(family.make(small), over, count)
    else:
        maps = family.make(order)
    return encoded(worn(maps, over, substance_of(name)), metres)


def _repeats_per_side(family: Family, order: TextureParams) -> int:
    """How often a family's picture is laid along a side: a power of two that divides it."""
    count = 1
    while (
        2 * count <= min(family.laid, order.size / family.size + _LESS)
        and order.resolution % (2 * count) == 0
    ):
        count *= 2
    return count
