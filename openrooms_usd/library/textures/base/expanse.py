"""A small picture of cloth, hide or pile laid many times, without the eye finding its repeat.

What repeats visibly is not the threads but the clouds in them. So the long waves of the small
picture are taken out, and waves as strong are drawn anew over the whole.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base.family import Order
from openrooms_usd.library.textures.base.maps import Maps, with_mean
from openrooms_usd.library.textures.base.noise import Field, smooth_noise

# Waves of at most so many cycles a side of the small picture are long.
_LONG_CYCLES: Final = 3
# What is drawn over the whole: about as long as the small picture, ...
_LENGTH_SHARE: Final = 0.8
# ... and no stronger than this, share of the brightness.
_MAX_SHADE_SHARE: Final = 0.06
_MIN_SHADE_SHARE: Final = 0.02
_MAX_ROUGHNESS: Final = 0.02


def laid(small: Maps, order: Order, count: int) -> Maps:
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


def _wave(order: Order, count: int) -> Field:
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
