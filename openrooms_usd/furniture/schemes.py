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


def finished(**parts: str) -> dict[str, str]:
    """Finishes by part: by each finish the parts that have it, apart by blanks."""
    return {part: finish for finish, named in parts.items() for part in named.split()}


def scheme(
    finish: str,
    shared: Mapping[str, str] = _NO_PARTS,
    /,
    *,
    needs: str | None = None,
    weight: float = 1.0,
    suite: str = "",
    **others: str,
) -> Scheme:
    """A scheme by the finish of most parts, and by those that have another.

    Args:
        finish: Of all that are not named.
        shared: Finishes by part which several schemes have; ``others`` go before them.
        needs: As of `Scheme`.
        weight: As of `Scheme`.
        suite: As of `Scheme`.
        **others: Parts of other finishes, as `finished` has them.
    """
    return Scheme({ANY: finish, **shared, **finished(**others)}, needs, weight, suite)


def landscape_print(tones: str) -> dict[str, str]:
    """The finishes of a landscape's sheets in tones that fit together; the sky is its canvas."""
    return {"canvas" if tone == "sky" else tone: f"{tones}_{tone}" for tone in TONES}


# Parts that several categories finish alike.
HIDE: Final = finished(hide="seat_cushion back_cushion cushion")
TAP: Final = finished(chrome="body switch")
DARK_TAP: Final = finished(metal="body switch spout drain")
_HOT: Final = finished(cavity="container", black="base", chrome="rack", steel="handle")

CHAIRS: Final = (
    scheme("bent_wood", weight=3.0),
    scheme("lacquer", bent_wood="leg frame"),
    scheme("lacquer"),
    scheme("upholstery", bent_wood="leg", needs="arm", weight=100.0),
)
TABLES: Final = (
    scheme("wood", weight=3.0),
    scheme(METAL, wood="tabletop shelf"),
    scheme("white", wood="tabletop shelf"),
)
STORAGE: Final = (
    scheme("wood", weight=2.0),
    scheme("white", wood="leg", white="base"),
    scheme("wood", lacquer="door drawer_front", needs="handle"),
)
_UNIT: Final = finished(white="shelf drawer_box", plastic="container tray", chrome="rack")
KITCHEN: Final = (
    scheme("white", _UNIT, weight=3.0, suite="kitchen"),
    scheme("kitchen_lacquer", _UNIT, weight=3.0, suite="kitchen"),
    scheme("wood", _UNIT, weight=2.0, suite="kitchen"),
    scheme("white", _UNIT, black="kickboard", suite="kitchen"),
)
# Of appliances behind the fronts of a kitchen.
PANELLED: Final = tuple(replace(each, needs="kickboard") for each in KITCHEN)
LAMPS: Final = (scheme(METAL, weight=2.0), scheme(METAL, ceramic="base"))
SOCKETED: Final = (scheme(METAL, lacquer="lamp_shade", needs="socket", weight=100.0),)
COOKERS: Final = (
    scheme("steel", _HOT, black="frame", weight=2.0),
    scheme("enamel", _HOT, enamel="knob", weight=2.0),
    scheme("screen", _HOT, black="frame", steel="knob"),
)
SCREENS: Final = (
    scheme("black_plastic", weight=3.0),
    scheme("black_plastic", aluminium="stand base foot"),
)
