"""The channels of light that the sums of a `CompleteIntegrator` make."""

from collections.abc import Callable
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import luminance
from orusd_mitsuba.complete.accumulator import OF_LIGHT, ONCE


def _sum_of(*kinds: str) -> Callable[[Array, int], Array]:
    rows = [ONCE.index(kind) for kind in kinds]
    return lambda planes, light: np.asarray(planes[rows].sum(axis=0))


def _sum_of_light(*names: str) -> Callable[[Array, int], Array]:
    def pick(planes: Array, light: int) -> Array:
        by_name = planes[len(ONCE) :].reshape(len(OF_LIGHT), -1, *planes.shape[1:])
        return np.asarray(by_name[[[*OF_LIGHT].index(name) for name in names], light].sum(axis=0))

    return pick


def _visibility(planes: Array, light: int) -> Array:
    """A ratio of two means over the same samples."""
    seen, whole = (
        _sum_of_light(name)(planes, light) for name in ("irradiance_direct", "unoccluded")
    )
    ratio = np.divide(seen, whole, out=np.zeros_like(whole), where=whole > 0.0)
    return np.clip(ratio, 0.0, 1.0)


def _traced(planes: Array, light: int) -> Array:
    """What of the indirect light no cache had; 1 where there is none."""
    whole, known = (
        luminance(_sum_of(name)(planes, light))[..., None] for name in ("indirect", "looked_up")
    )
    share = np.divide(known, whole, out=np.zeros_like(whole), where=whole > 0.0)
    return np.clip(1.0 - share, 0.0, 1.0)


PICKS: Final[dict[str, Callable[[Array, int], Array]]] = {
    "radiance": _sum_of("emission", "direct", "indirect"),
    "emission": _sum_of("emission"),
    "direct": _sum_of("direct"),
    "indirect": _sum_of("indirect"),
    "diffuse": _sum_of("diffuse"),
    "specular": _sum_of("specular"),
    "irradiance": _sum_of("irradiance_direct", "irradiance_indirect"),
    "irradiance_direct": _sum_of("irradiance_direct"),
    "irradiance_indirect": _sum_of("irradiance_indirect"),
    "radiance_i": _sum_of_light("radiance"),
    "irradiance_i": _sum_of_light("irradiance_direct", "irradiance_indirect"),
    "direct_i": _sum_of_light("irradiance_direct"),
    "unoccluded_i": _sum_of_light("unoccluded"),
    "visibility_i": _visibility,
    "traced": _traced,
}
"""By channel, what makes its picture of the sums; of a channel of every light, given its number."""

RECEIVED: Final = frozenset(name for name in PICKS if name.startswith("irradiance"))
"""Those that need nothing of what the first surface scatters."""
