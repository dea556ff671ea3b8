"""Categories that nothing builds: the shell of rooms, and what captures and own files bring."""

from typing import Any, Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import (
    BY_PARTS,
    NO_ROWS,
    NO_SYNSET,
    NO_WORDS,
    PLAIN_HINGES,
    RIGID,
    UNLABELED,
    Category,
    Classes,
    Without,
)
from openrooms_usd.categories.schemes import LAMPS, SOCKETED, STORAGE, Scheme

_ANYWHERE: Final = Without("nobody knows what carries it before it is seen")
_AS_SPELT: Final = Without("the class lists have it in its own spelling, or not at all")


def _other(**said: Any) -> Category:
    """A category of which the library knows no more than is said."""
    unsaid: dict[str, Any] = {
        "support": _ANYWHERE, "also": (), "fixed": False, "words": NO_WORDS, "classes": _AS_SPELT,
        "synsets": NO_SYNSET, "schemes": BY_PARTS, "makes": NO_ROWS, "hinges": PLAIN_HINGES,
        "yields": RIGID,
    }  # fmt: skip
    return Category(**{**unsaid, **said})


OTHERS: Final[dict[str, Category]] = {
    "beam": _other(fixed=True, classes=Classes("ceiling", "otherstructure")),
    "bicycle": _other(
        classes=Classes("bike", "otherprop"),
        synsets=("02834778",),
        makes=(makes.row(ANY, makes.walls(1.0), "sheet", "metal", "paint"),),
    ),
    "blinds": _other(
        support="wall",
        fixed=True,
        makes=(makes.row("slat", makes.filled(400), "common"),),
    ),
    "ceiling": _other(
        fixed=True,
        classes=Classes("ceiling", "ceiling"),
    ),
    "ceiling_fan": _other(
        support="ceiling",
    ),
    "ceiling_grid": _other(fixed=True, classes=Classes("ceiling", "ceiling")),
    "chandelier": _other(
        support="ceiling",
    ),
    "cladding": _other(fixed=True, classes=Classes("wall", "wall")),
    "column": _other(
        fixed=True,
    ),
    "cornice": _other(fixed=True, classes=Classes("wall", "otherstructure")),
    "floor": _other(
        fixed=True,
        classes=Classes("floor", "floor"),
    ),
    "floor_mat": _other(
        makes=(makes.row(ANY, makes.filled(220), "common"),),
    ),
    "lamp": _other(
        classes=Classes("lamp", "lamp"),
        schemes=(
            *LAMPS,
            *SOCKETED,
        ),
        makes=makes.LAMP,
    ),
    "opening": _other(
        fixed=True,
        classes=Classes(UNLABELED, "otherstructure"),
        schemes=(Scheme({ANY: "white", "threshold": "wood"}),),
    ),
    "pendant_lamp": _other(
        support="ceiling",
    ),
    "picture_rail": _other(fixed=True, classes=Classes("wall", "otherstructure")),
    "shelf": _other(
        classes=Classes("bookshelf", "shelves"),
        schemes=STORAGE,
        makes=makes.STORAGE,
    ),
    "shower_curtain": _other(
        fixed=True,
        makes=(
            makes.row("sheer", makes.filled(60), "common"),
            makes.row(f"curtain cord {ANY}", makes.filled(80), "common", "fabric"),
        ),
    ),
    "skirting": _other(fixed=True, classes=Classes("wall", "otherstructure")),
    "storage": _other(
        classes=Classes("cabinet", "cabinet"),
        makes=makes.STORAGE,
    ),
    "wainscot": _other(fixed=True, classes=Classes("wall", "wall")),
    "wall": _other(
        fixed=True,
        classes=Classes("wall", "wall"),
    ),
    "wall_shelf": _other(
        support="wall",
    ),
}
