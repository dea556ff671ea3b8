"""Intensity profiles of usual luminaires, made by rules, as IES files.

A beam angle is that between the directions of half the intensity on the axis; of a batwing it is
the angle between its two wings.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.usd.light.profiles import Profile

BeamName = Literal["downlight", "spot", "batwing", "bare bulb"]
BEAMS: Final[tuple[BeamName, ...]] = get_args(BeamName)

# What profiles are scaled to.
_LUMEN: Final = 1000.0
# Of a batwing, straight down over in its wings.
_BETWEEN_WINGS_SHARE: Final = 0.5
# Of a bulb, what its cap leaves of light along its axis, and from where on it shades, degrees.
_BEHIND_CAP_SHARE: Final = 0.1
_CAP_FROM_DEG: Final = 140.0


@dataclass(frozen=True)
class _Beam:
    """A rule: relative intensities by degrees from the nadir and beam angle, and what is usual."""

    intensity: Callable[[Array, float], Array]
    usual_deg: float
    last_deg: int = 90


def _downlight(polar: Array, beam: float) -> Array:
    """A power of the cosine: even at a right angle short of the axis, nothing at the horizon."""
    power = math.log(0.5) / math.log(math.cos(math.radians(0.5 * beam)))
    return np.asarray(np.maximum(np.cos(np.radians(polar)), 0.0) ** power)


def _spot(polar: Array, beam: float) -> Array:
    """A bell that a reflector makes, with nothing at the horizon."""
    return np.where(polar < 90.0, 0.5 ** ((2.0 * polar / beam) ** 2), 0.0)


def _batwing(polar: Array, beam: float) -> Array:
    """Two wings, less between them, nothing at the horizon."""
    wing = 0.5 * beam
    rise = np.sin(0.5 * np.pi * np.minimum(polar / wing, 1.0)) ** 2
    fall = np.cos(0.5 * np.pi * np.clip((polar - wing) / (90.0 - wing), 0.0, 1.0)) ** 2
    return np.asarray((_BETWEEN_WINGS_SHARE + (1.0 - _BETWEEN_WINGS_SHARE) * rise) * fall)


def _bare_bulb(polar: Array, beam: float) -> Array:
    """Even but for what its cap, above, shades."""
    del beam
    turn = np.clip((polar - _CAP_FROM_DEG) / (180.0 - _CAP_FROM_DEG), 0.0, 1.0)
    return 1.0 - (1.0 - _BEHIND_CAP_SHARE) * np.sin(0.5 * np.pi * turn) ** 2


_RULES: Final[dict[BeamName, _Beam]] = {
    "downlight": _Beam(_downlight, 80.0),
    "spot": _Beam(_spot, 36.0),
    "batwing": _Beam(_batwing, 70.0),
    "bare bulb": _Beam(_bare_bulb, 360.0, 180),
}


def beam_profile(name: BeamName, beam: float | None = None) -> Profile:
    """The profile of a luminaire of 1000 lumen.

    Args:
        name: What it is.
        beam: Its beam angle, degrees; by default a usual one.
    """
    rule = _RULES[name]
    polar = np.arange(rule.last_deg + 1, dtype=np.float64)
    even = rule.intensity(polar, rule.usual_deg if beam is None else beam)
    around = np.array([0.0, 360.0])
    scale = _LUMEN / Profile(polar, around, np.stack([even, even])).flux
    # As many digits as the file has: what is read again is the same.
    row = np.array([float(f"{value:.6g}") for value in even * scale])
    return Profile(polar, around, np.stack([row, row]))


def profile_text(profile: Profile, title: str) -> str:
    """A profile as an IES file, LM-63-2002; the same text for the same profile.

    Args:
        profile: What to write.
        title: What it is, for people.
    """
    is_round = bool((profile.candela == profile.candela[:1]).all())
    around = profile.around[:1] if is_round else profile.around
    rows = profile.candela[: len(around)]
    lines = [
        "IESNA:LM-63-2002",
        "[TEST] made by rules",
        "[MANUFAC] openrooms_usd",
        f"[LUMINAIRE] {title}",
        "TILT=NONE",
        f"1 {profile.flux:.6g} 1 {len(profile.polar)} {len(around)} 1 2 0 0 0",
        "1 1 0",
    ]
    for values in (profile.polar, around, *rows):
        words = [f"{value:.6g}" for value in values]
        lines += [" ".join(words[first : first + 10]) for first in range(0, len(words), 10)]
    return "\n".join(lines) + "\n"


# Where people work, lamps are cooler, and on by day, too.
WORK_ROOMS: Final = frozenset(
    """
    bookstore classroom computer_cluster conference_room copy_room gym library lobby mail_room
    office
    """.split()
)
# Where people neither live nor work for long.
_USEFUL_ROOMS: Final = frozenset(
    {"basement", "bathroom", "closet", "garage", "kitchen", "laundry_room", "storage"}
)
# Kelvin; as often as they stand here.
HOME_KELVIN: Final = (2700, 2700, 2700, 2800, 3000)
_USEFUL_KELVIN: Final = (2700, 3000, 3000, 3500, 4000)
_WORK_KELVIN: Final = (3500, 4000, 4000)


def lamp_kelvin(room_type: str) -> tuple[int, ...]:
    """Colour temperatures of which a room of this kind has one."""
    if room_type in WORK_ROOMS:
        return _WORK_KELVIN
    return _USEFUL_KELVIN if room_type in _USEFUL_ROOMS else HOME_KELVIN
