"""Where the sun stands: its place in the sky of any place on Earth at any moment.

Meeus, Astronomical Algorithms (2nd edition, 1998), chapters 12, 13, 22 and 25 (low accuracy, 0.01
degree), with the refraction of NOAA's solar calculator. Good for the years 1800 to 2200.
"""

import math
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Final

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
