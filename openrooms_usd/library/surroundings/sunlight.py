"""What the sun sends straight through the air, and how bright dusk and night are.

The beam is integrated over wavelengths: a black body of 5772 K that gives the solar illuminance
constant outside the atmosphere, dimmed by molecules, haze and ozone as in Preetham, Shirley,
Smits: A Practical Analytic Model for Daylight (SIGGRAPH 1999), appendix A.1.
"""

import math
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import luminance

# Lux on a surface that faces the sun at one astronomical unit, outside the atmosphere (IESNA).
SOLAR_CONSTANT: Final = 133_800.0
# The sun's angular radius at one astronomical unit, degrees.
SUN_RADIUS: Final = 0.26656

_SUN_SURFACE_K: Final = 5772.0  # kelvin, IAU 2015
_OZONE_CM: Final = 0.35  # centimetres at normal pressure
_NM: Final = np.arange(380.0, 781.0, 5.0)
# IEC 61966-2-1: linear Rec.709 from CIE XYZ.
RGB_FROM_XYZ: Final = np.array(
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)
# Janiczek and DeYoung, Computer Programs for Sun and Moon Illuminance (US Naval Observatory
# Circular 171, 1987): log10 of lux as a polynomial of elevation / 90 degrees, by lowest elevation.
_ILLUMINANCE: Final = (
    (20.0, (3.74, 3.97, -4.07, 1.47)),
    (5.0, (3.05, 13.28, -45.98, 64.33)),
    (-0.8, (2.88, 22.26, -207.64, 1034.30)),
    (-5.0, (2.88, 21.81, -258.11, -858.36)),
    (-12.0, (2.70, 12.17, -431.69, -1899.83)),
    (-18.0, (13.84, 262.72, 1447.42, 2797.93)),
)


def direct_normal(elevation: float, turbidity: float, distance: float = 1.0) -> Array:
    """(3,) what the sun gives to a surface that faces it: lux of each Rec.709 primary.

    Args:
        elevation: Degrees above the horizon, as it is seen.
        turbidity: Haze: how many times the extinction of clean air.
        distance: Astronomical units.
    """
    spectrum = _planck(_NM) * _transmittance(_NM, air_mass(elevation), turbidity)
    scale = SOLAR_CONSTANT / distance**2 / float((_planck(_NM) * _matching(_NM)[1]).sum())
    xyz = scale * (_matching(_NM) @ spectrum)
    # A sun at the horizon is redder than Rec.709 can show: what it shows keeps the luminance.
    rgb = np.maximum(RGB_FROM_XYZ @ xyz, 0.0)
    return np.asarray(rgb * (xyz[1] / float(luminance(rgb))))


def air_mass(elevation: float) -> float:
    """Relative optical path through the air (Kasten and Young 1989), for degrees from 0 to 90."""
    h = max(elevation, 0.0)
    return 1.0 / (math.sin(math.radians(h)) + 0.50572 * math.pow(h + 6.07995, -1.6364))


def clear_illuminance(elevation: float) -> float:
    """Typical horizontal illuminance under a clear sky without moon, lux.

    Valid from the zenith through dusk (Janiczek and DeYoung 1987); below -18 degrees the night is
    as dark as it becomes, 0.65 millilux of stars and airglow.

    Args:
        elevation: Degrees of the sun, without refraction.
    """
    h = max(elevation, _ILLUMINANCE[-1][0])
    x = h / 90.0
    a, b, c, d = next(row for lowest, row in _ILLUMINANCE if h >= lowest)
    return float(10.0 ** (a + x * (b + x * (c + x * d))))


def overcast_illuminance(elevation: float) -> float:
    """Horizontal illuminance under clouds, lux (Krochmann and Seidl 1974), at dusk in proportion.

    Args:
        elevation: Degrees of the sun, without refraction.
    """
    day = 300.0 + 21_000.0 * math.sin(math.radians(max(elevation, 0.0)))
    return day * clear_illuminance(min(elevation, 0.0)) / clear_illuminance(0.0)


def _planck(nm: Array) -> Array:
    """Relative radiance of the sun's surface."""
    metres = nm * 1e-9
    return np.asarray(1e-30 / (metres**5 * np.expm1(0.014387769 / (metres * _SUN_SURFACE_K))))


def _transmittance(nm: Array, mass: float, turbidity: float) -> Array:
    """Of the direct beam: Rayleigh, Angstrom's haze, and ozone's Chappuis band as a Gaussian."""
    um = nm / 1000.0
    rayleigh = 0.008735 * um**-4.08
    haze = max(0.0, 0.04608 * turbidity - 0.04586) * um**-1.3
    ozone = 0.125 * _OZONE_CM * np.exp(-0.5 * ((um - 0.603) / 0.05) ** 2)
    return np.asarray(np.exp(-mass * (rayleigh + haze + ozone)))


def _matching(nm: Array) -> Array:
    """(3, N) the CIE 1931 functions; Wyman, Sloan, Shirley (JCGT 2013), multi-lobe fit."""
    x = (
        1.056 * _lobe(nm, 599.8, 37.9, 31.0)
        + 0.362 * _lobe(nm, 442.0, 16.0, 26.7)
        - 0.065 * _lobe(nm, 501.1, 20.4, 26.2)
    )
    y = 0.821 * _lobe(nm, 568.8, 46.9, 40.5) + 0.286 * _lobe(nm, 530.9, 16.3, 31.1)
    z = 1.217 * _lobe(nm, 437.0, 11.8, 36.0) + 0.681 * _lobe(nm, 459.0, 26.0, 13.8)
    return np.stack([x, y, z])


def _lobe(nm: Array, peak: float, below: float, above: float) -> Array:
    return np.asarray(np.exp(-0.5 * ((nm - peak) / np.where(nm < peak, below, above)) ** 2))


_J2000: Final = datetime(2000, 1, 1, 12, tzinfo=UTC)
_CENTURY_S: Final = 36_525.0 * 86_400.0  # seconds


@dataclass(frozen=True)
class SunPosition:
    """The sun seen from a place.

    Attributes:
        azimuth: Degrees clockwise from north, 0 to 360.
        elevation: Degrees above the horizon of its true centre, without the atmosphere.
        apparent: The same as it is seen, raised by refraction.
        distance: From the Earth, astronomical units.
    """

    azimuth: float
    elevation: float
    apparent: float
    distance: float


def sun_position(moment: datetime, latitude: float, longitude: float) -> SunPosition:
    """Find the sun.

    Args:
        moment: With its time zone.
        latitude: Degrees, positive northwards.
        longitude: Degrees, positive eastwards.
    """
    t = (moment - _J2000).total_seconds() / _CENTURY_S
    right_ascension, declination, distance = equatorial(t)
    hour_angle = _sidereal_time(t) + math.radians(longitude) - right_ascension
    phi = math.radians(latitude)
    # Components to the east, to the north and up: no quotient that fails at the poles.
    east = -math.cos(declination) * math.sin(hour_angle)
    north = math.sin(declination) * math.cos(phi) - math.cos(declination) * math.sin(
        phi
    ) * math.cos(hour_angle)
    up = math.sin(declination) * math.sin(phi) + math.cos(declination) * math.cos(phi) * math.cos(
        hour_angle
    )
    elevation = math.degrees(math.atan2(up, math.hypot(east, north)))
    azimuth = math.degrees(math.atan2(east, north)) % 360.0
    return SunPosition(azimuth, elevation, elevation + refraction(elevation), distance)


def equatorial(t: float) -> tuple[float, float, float]:
    """Right ascension and declination in radians, and the distance in astronomical units.

    Args:
        t: Julian centuries since J2000.0.
    """
    mean_longitude = 280.46646 + t * (36_000.76983 + t * 0.0003032)
    anomaly = math.radians(357.52911 + t * (35_999.05029 - t * 0.0001537))
    eccentricity = 0.016708634 - t * (0.000042037 + t * 0.0000001267)
    center = (
        (1.914602 - t * (0.004817 + t * 0.000014)) * math.sin(anomaly)
        + (0.019993 - t * 0.000101) * math.sin(2.0 * anomaly)
        + 0.000289 * math.sin(3.0 * anomaly)
    )
    node = math.radians(125.04 - 1934.136 * t)
    longitude = math.radians(mean_longitude + center - 0.00569 - 0.00478 * math.sin(node))
    obliquity = math.radians(
        23.4392911 - t * (0.0130042 + t * (1.64e-7 - t * 5.04e-7)) + 0.00256 * math.cos(node)
    )
    right_ascension = math.atan2(math.cos(obliquity) * math.sin(longitude), math.cos(longitude))
    declination = math.asin(math.sin(obliquity) * math.sin(longitude))
    true_anomaly = anomaly + math.radians(center)
    distance = 1.000001018 * (1.0 - eccentricity**2) / (1.0 + eccentricity * math.cos(true_anomaly))
    return right_ascension, declination, distance


def refraction(elevation: float) -> float:
    """How far the atmosphere lifts the sun, degrees (NOAA's solar calculator).

    Args:
        elevation: Degrees, without the atmosphere.
    """
    h = elevation
    if h > 85.0:
        return 0.0
    if h > 5.0:
        tangent = math.tan(math.radians(h))
        seconds = 58.1 / tangent - 0.07 / tangent**3 + 0.000086 / tangent**5
    elif h > -0.575:
        seconds = 1735.0 + h * (-518.2 + h * (103.4 + h * (-12.79 + h * 0.711)))
    else:
        seconds = -20.774 / math.tan(math.radians(max(h, -89.0)))
    return seconds / 3600.0


def _sidereal_time(t: float) -> float:
    """At Greenwich, radians (Meeus, equation 12.4)."""
    days = t * 36_525.0
    return math.radians(
        (280.46061837 + 360.98564736629 * days + t * t * (0.000387933 - t / 38_710_000.0)) % 360.0
    )
