"""The lamps of a generated room: how bright, how warm, which way, and which are on at its moment.

Shades, bells and cans shape the light by their form. Where a lamp's own optics do so it has a
profile: heads on rails have lenses, offices have discs that spare the eye, bulbs that hang have a
cap above. What lights the room is wide: a narrow spot alone leaves it to what one bright patch of
floor reflects, which takes many samples to find.
"""

from typing import Any, Final

import numpy as np

from openrooms_usd.draws import generator
from openrooms_usd.furniture import category
from openrooms_usd.generation.moments import MOMENTS, Moment, moment_of
from openrooms_usd.generation.rooms import Generated, named, program_of
from openrooms_usd.library.styles.beams import HOME_KELVIN, WORK_ROOMS, BeamName, lamp_kelvin

Section = dict[str, Any]
_Profile = tuple[BeamName, tuple[float, float] | None]

# Flux of lamps that are not on the ceiling, as a share of what their category usually has.
_SHARE: Final = (0.6, 1.3)
# Flux of lamps that are dimmed, as a share of their own; they become warmer by so many kelvin.
_DIMMED_SHARE: Final = (0.25, 0.7)
_DIMMED_KELVIN: Final = -300
# How much of the lamps' flux reaches the floor, roughly.
_FLUX_ON_FLOOR_SHARE: Final = 0.5
# What shows pictures, but for what is bent; and the luminance of its white, cd/m2.
_SCREENS: Final = frozenset({"laptop", "monitor", "television"})
_DARK_STYLES: Final = frozenset({"curved", "tube"})
_NITS: Final = (100.0, 300.0)
# How often a lamp that stands somewhere at home shines in a colour in the evening, and the colours.
_COLORED_SHARE: Final = 0.04
_COLORS: Final = ([1.0, 0.25, 0.6], [0.3, 0.4, 1.0], [1.0, 0.35, 0.1], [0.5, 0.25, 1.0])
# Profiles by category and style, at home and where people work: the name, and from where to where
# beam angles go, degrees. They multiply luminance: a flat lens of 75 degrees has a beam of 66.
_OPAL: Final[_Profile] = ("downlight", (100.0, 120.0))
_OFFICE: Final[_Profile] = ("batwing", (60.0, 90.0))
_LENS: Final[_Profile] = ("downlight", (70.0, 90.0))
_BULB: Final[_Profile] = ("bare bulb", None)
_PROFILES: Final[dict[tuple[str, str], tuple[_Profile, _Profile]]] = {
    ("ceiling_lamp", "flush"): (_OPAL, _OFFICE),
    ("ceiling_lamp", "spots"): (_LENS, _LENS),
    ("ceiling_lamp", "pendant"): (_BULB, _BULB),
    ("floor_lamp", "arc"): (_BULB, _BULB),
}


def lamps(room: Generated, *, seen: bool = True) -> dict[str, Section]:
    """What every lamp emits: those on the ceiling together give the floor its illuminance.

    Args:
        room: The room.
        seen: Whether the room is seen at its own moment; otherwise all lamps are on.
    """
    rng = generator(room.seed, "generate", room.room_type, "lamps")
    moment = MOMENTS[moment_of(room.room_type, room.seed)]
    at_work = room.room_type in WORK_ROOMS
    kelvin = int(rng.choice(lamp_kelvin(room.room_type)))
    lux = float(rng.uniform(*program_of(room.room_type).lux))
    rows = [(name, item.category) for _, name, item, _ in named(room.furnishing.groups)]
    ceiling = [name for name, kind in rows if kind == "ceiling_lamp"]
    each = round(lux * room.shell.area / _FLUX_ON_FLOOR_SHARE / max(len(ceiling), 1), -1)
    found = {name: {"lumen": each, "kelvin": kelvin} for name in ceiling}
    warm = kelvin if at_work else int(rng.choice(HOME_KELVIN))
    for name, kind in rows:
        spec = category(kind)
        if spec.emits and name not in found:
            lumen = round(spec.lumen * float(rng.uniform(*_SHARE)), -1)
            found[name] = {"lumen": lumen, "kelvin": warm}
    for name, section in _profiles(room).items():
        found[name] |= section
    return _switched(found, ceiling, room, moment, rng) if seen else found


def _profiles(room: Generated) -> dict[str, Section]:
    """Where the light of lamps goes, of those with optics of their own; alike for each style."""
    rng = generator(room.seed, "generate", room.room_type, "profiles")
    made = {}
    for key, choices in _PROFILES.items():
        name, beams = choices[room.room_type in WORK_ROOMS]
        beam = {"beam": 5 * round(float(rng.uniform(*beams)) / 5.0)} if beams else {}
        made[key] = {"profile": name, **beam}
    items = [(name, item) for _, name, item, _ in named(room.furnishing.groups)]
    keys = {name: (item.category, item.style) for name, item in items}
    return {name: made[key] for name, key in keys.items() if key in made}


def _switched(
    found: dict[str, Section],
    ceiling: list[str],
    room: Generated,
    moment: Moment,
    rng: np.random.Generator,
) -> dict[str, Section]:
    """The lamps with some of them off, dimmed or coloured; those on the ceiling share a switch."""
    at_work = room.room_type in WORK_ROOMS
    has_window = any(gap.kind == "window" for gap in room.shell.gaps)
    is_dark = moment.elevation[1] < 0.0
    above = not has_window or rng.random() < moment.ceiling[at_work]
    others = {name: rng.random() < moment.others for name in found if name not in ceiling}
    if is_dark and not any(others.values()):
        above = True
    dim = float(rng.uniform(*_DIMMED_SHARE)) if rng.random() < moment.dimmed else 1.0
    for name, lamp in found.items():
        if not (above if name in ceiling else others[name]):
            lamp["on"] = False
        elif name in ceiling and not at_work and dim < 1.0:
            lamp["lumen"] = round(lamp["lumen"] * dim, -1)
            lamp["kelvin"] += _DIMMED_KELVIN
        elif name not in ceiling and not at_work and is_dark and rng.random() < _COLORED_SHARE:
            del lamp["kelvin"]
            lamp["color"] = _COLORS[int(rng.integers(len(_COLORS)))]
    return found


def screens(room: Generated) -> dict[str, Section]:
    """The screens that are on at a room's moment."""
    rng = generator(room.seed, "generate", room.room_type, "screens")
    often = MOMENTS[moment_of(room.room_type, room.seed)].screens[room.room_type in WORK_ROOMS]
    found: dict[str, Section] = {}
    for _, name, item, _ in named(room.furnishing.groups):
        if item.category in _SCREENS and item.style not in _DARK_STYLES:
            # Drawn for each, so that one that is on changes no other.
            is_on, nits = rng.random() < often, 10.0 * round(float(rng.uniform(*_NITS)) / 10.0)
            found |= {name: {"nits": nits}} if is_on else {}
    return found
