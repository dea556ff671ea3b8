"""Which finish each part of a category usually has, and what several categories share."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from openrooms_usd.furniture.construction import ANY

# Schemes say "metal"; one of these is drawn for the whole object.
METAL: Final = "metal"
METALS: Final = ("steel", "brass", "black")
TONES: Final = ("sky", "light", "far", "middle", "near", "ground")
"""The sheets of a landscape's print, from behind to before."""


@dataclass(frozen=True)
class Scheme:
    """Which finish the parts of a category have.

    Attributes:
        finishes: By part; `ANY` for all others that are not in `PARTS`.
        needs: A part that the object must have, by which its build is recognised.
        weight: How often it is chosen among those that fit.
        suite: What it is bought with: all objects of a room in a suite draw alike, whatever their
            categories, and a scheme of a suite goes before others.
    """

    finishes: Mapping[str, str] = field(default_factory=dict)
    needs: str | None = None
    weight: float = 1.0
    suite: str = ""


_NO_PARTS: Final[Mapping[str, str]] = {}


def scheme(
    finish: str,
    shared: Mapping[str, str] = _NO_PARTS,
    /,
    *,
    needs: str | None = None,
    weight: float = 1.0,
    suite: str = "",
    **parts: str,
) -> Scheme:
    """A scheme by the finish of most parts, and by those that have another.

    Args:
        finish: Of all that are not named.
        shared: Finishes of parts which several schemes have; ``parts`` go before them.
        needs: As of `Scheme`.
        weight: As of `Scheme`.
        suite: As of `Scheme`.
        **parts: The finish of each other part.
    """
    return Scheme({ANY: finish, **shared, **parts}, needs, weight, suite)


# Parts that several categories finish alike.
HIDE: Final = {"seat_cushion": "hide", "back_cushion": "hide", "cushion": "hide"}
TAP: Final = {"body": "chrome", "switch": "chrome"}
DARK_TAP: Final = {"body": METAL, "switch": METAL, "spout": METAL, "drain": METAL}
_HOT: Final = {"container": "cavity", "base": "black", "rack": "chrome", "handle": "steel"}

CHAIRS: Final = (
    scheme("bent_wood", weight=3.0),
    scheme("lacquer", leg="bent_wood", frame="bent_wood"),
    scheme("lacquer"),
    scheme("upholstery", leg="bent_wood", needs="arm", weight=100.0),
)
TABLES: Final = (
    scheme("wood", weight=3.0),
    scheme(METAL, tabletop="wood", shelf="wood"),
    scheme("white", tabletop="wood", shelf="wood"),
)
STORAGE: Final = (
    scheme("wood", weight=2.0),
    scheme("white", leg="wood", base="white"),
    scheme("wood", door="lacquer", drawer_front="lacquer", needs="handle"),
)
_UNIT: Final = {
    "shelf": "white",
    "drawer_box": "white",
    "container": "plastic",
    "tray": "plastic",
    "rack": "chrome",
}
KITCHEN: Final = (
    scheme("white", _UNIT, weight=3.0, suite="kitchen"),
    scheme("kitchen_lacquer", _UNIT, weight=3.0, suite="kitchen"),
    scheme("wood", _UNIT, weight=2.0, suite="kitchen"),
    scheme("white", _UNIT, kickboard="black", suite="kitchen"),
)
# Of appliances behind the fronts of a kitchen.
PANELLED: Final = tuple(replace(each, needs="kickboard") for each in KITCHEN)
LAMPS: Final = (scheme(METAL, weight=2.0), scheme(METAL, base="ceramic"))
SOCKETED: Final = (scheme(METAL, lamp_shade="lacquer", needs="socket", weight=100.0),)
COOKERS: Final = (
    scheme("steel", _HOT, frame="black", weight=2.0),
    scheme("enamel", _HOT, knob="enamel", weight=2.0),
    scheme("screen", _HOT, frame="black", knob="steel"),
)
SCREENS: Final = (
    scheme("black_plastic", weight=3.0),
    scheme("black_plastic", stand="aluminium", base="aluminium", foot="aluminium"),
)
