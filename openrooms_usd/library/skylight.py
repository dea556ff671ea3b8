"""The dome of the sky without the sun: clear (Hosek and Wilkie), overcast (CIE), dusk and night.

Hosek and Wilkie: An Analytic Model for Full Spectral Sky-Dome Radiance (SIGGRAPH 2012), with the
authors' RGB coefficients beside this module, under their own licence. Their luminous efficacy is
left out there: one unit of luminance is 683 cd/m2.
"""

from functools import cache
from math import comb
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.colorimetry import luminance
from openrooms_usd.library.environments import horizontal_illuminance
from openrooms_usd.library.sunlight import clear_illuminance, overcast_illuminance

Array = NDArray[np.float64]

_COEFFICIENTS: Final = Path(__file__).with_name("hosek_wilkie.npy")
_LUMENS_PER_WATT: Final = 683.0
# Below this the model is brighter than measured skies, three times at the horizon: from here down
# its brightness goes over to that of the published curve.
_LOW_SUN_DEG: Final = 10.0
# The glow of dusk gives way to a dark sky between these elevations.
_DUSK_LIMITS_DEG: Final = (-6.0, -18.0)
# The blue of dusk, when ozone takes the orange out of light that has come through much of it (E. O.
# Hulburt, Explanation of the Brightness and Color of the Sky, 1953): its hue, about 20,000 K and of
# luminance 1; the sun's elevation at which it is full; how far up the glow of the sunset reaches,
# as a sine.
_DUSK_HUE: Final = np.array([0.62, 0.98, 2.31])
_BLUE_HOUR_DEG: Final = -4.0
_GLOW_HEIGHT: Final = 0.12


def clear_sky(way: Array, sun: Array, elevation: float, turbidity: float, albedo: Array) -> Array:
    """(H, W, 3) nits of a cloudless sky; 0 below the horizon.

    Args:
        way: (H, W, 3) unit vectors of `directions`.
        sun: (3,) unit vector to the sun as it is seen, perhaps below the horizon.
        elevation: Degrees of the sun, without refraction.
        turbidity: 1 to 10.
        albedo: (3,) reflectance of the ground, which lights the air from below.
    """
    bearing = np.array([sun[0], sun[1], max(float(sun[2]), 0.0)])
    sky = hosek_wilkie(way, bearing / np.linalg.norm(bearing), turbidity, albedo)
    if elevation >= _LOW_SUN_DEG:
        return sky
    given = horizontal_illuminance(sky)
    wanted = clear_illuminance(elevation)
    nearness = min(1.0, (_LOW_SUN_DEG - elevation) / _LOW_SUN_DEG)
    sky *= (wanted / given) ** nearness
    night = float(
        np.clip(
            (_DUSK_LIMITS_DEG[0] - elevation) / (_DUSK_LIMITS_DEG[0] - _DUSK_LIMITS_DEG[1]),
            0.0,
            1.0,
        )
    )
    return (1.0 - night) * _at_dusk(sky, way, bearing, elevation) + night * _even(way, wanted)


def _at_dusk(sky: Array, way: Array, sun: Array, elevation: float) -> Array:
    """The sky in the blue of dusk but for the glow above the sun; its luminance stays."""
    share = float(np.clip(elevation / _BLUE_HOUR_DEG, 0.0, 1.0))
    if share == 0.0:
        return sky
    flat = np.maximum(np.linalg.norm(way[..., :2], axis=-1), 1e-9)
    facing = 0.5 * (1.0 + way[..., :2] @ (sun[:2] / max(float(np.hypot(*sun[:2])), 1e-9)) / flat)
    glow = facing * np.exp(-np.clip(way[..., 2], 0.0, None) / _GLOW_HEIGHT)
    blue = (share * (1.0 - glow))[..., None]
    return np.asarray((1.0 - blue) * sky + blue * luminance(sky)[..., None] * _DUSK_HUE)


def overcast_sky(way: Array, elevation: float) -> Array:
    """(H, W, 3) nits of the CIE overcast sky, grey; 0 below the horizon.

    Its zenith is three times as bright as its horizon (Moon and Spencer 1942; ISO 15469).

    Args:
        way: (H, W, 3) unit vectors of `directions`.
        elevation: Degrees of the sun, without refraction.
    """
    up = way[..., 2]
    shape = np.where(up > 0.0, 1.0 + 2.0 * up, 0.0)[..., None] * np.ones(3)
    return np.asarray(shape * (overcast_illuminance(elevation) / horizontal_illuminance(shape)))


def hosek_wilkie(way: Array, sun: Array, turbidity: float, albedo: Array) -> Array:
    """(H, W, 3) nits of the model itself; 0 below the horizon.

    Args:
        way: (H, W, 3) unit vectors.
        sun: (3,) unit vector, not below the horizon.
        turbidity: 1 to 10.
        albedo: (3,) reflectance of the ground, 0 to 1.
    """
    A, B, C, D, E, F, G, H, I, mean = _parameters(sun, turbidity, albedo)  # noqa: E741
    above = way[..., 2] > 0.0
    up = way[above][:, 2:]
    cosine = np.clip(way[above] @ sun, -1.0, 1.0)[:, None]
    halo = (1.0 + cosine**2) / (1.0 + I**2 - 2.0 * I * cosine) ** 1.5
    around = C + D * np.exp(E * np.arccos(cosine)) + F * cosine**2 + G * halo + H * np.sqrt(up)
    sky = np.zeros(way.shape)
    sky[above] = (
        np.maximum((1.0 + A * np.exp(B / (up + 0.01))) * around * mean, 0.0) * _LUMENS_PER_WATT
    )
    return sky


def _parameters(sun: Array, turbidity: float, albedo: Array) -> Array:
    """(10, 3) A to I and the mean radiance: quintic in the sun's height, linear in the others."""
    height = np.arcsin(np.clip(sun[2], 0.0, 1.0)) / (0.5 * np.pi)
    x = float(np.cbrt(height))
    bernstein = np.array([comb(5, i) * (1.0 - x) ** (5 - i) * x**i for i in range(6)])
    by_turbidity = np.einsum("tackp,c->takp", _coefficients(), bernstein)
    index = min(int(turbidity), 9)
    share = turbidity - index
    by_albedo = (1.0 - share) * by_turbidity[index - 1] + share * by_turbidity[index]
    weight = albedo[:, None]
    return np.asarray(((1.0 - weight) * by_albedo[0] + weight * by_albedo[1]).T)


@cache
def _coefficients() -> Array:
    """(10, 2, 6, 3, 10): turbidity, albedo, control point, primary, parameter."""
    return np.asarray(np.load(_COEFFICIENTS, allow_pickle=False), dtype=np.float64)


def _even(way: Array, illuminance: float) -> Array:
    """(H, W, 3) nits of the same grey from everywhere above."""
    shape = np.where(way[..., 2:] > 0.0, np.ones(3), 0.0)
    return np.asarray(shape * (illuminance / horizontal_illuminance(shape)))
