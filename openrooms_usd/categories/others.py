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


def _other(classes: Classes, **said: Any) -> Category:
    """A category of which the library knows no more than is said."""
    unsaid: dict[str, Any] = {
        "support": _ANYWHERE, "also": (), "fixed": False, "words": NO_WORDS, "classes": classes,
        "synsets": NO_SYNSET, "schemes": BY_PARTS, "makes": NO_ROWS, "hinges": PLAIN_HINGES,
        "yields": RIGID,
    }  # fmt: skip
    return Category(**{**unsaid, **said})


OTHERS: Final[dict[str, Category]] = {
    "beam": _other(fixed=True, classes=Classes("ceiling", "otherstructure", "ceiling", UNLABELED)),
    "blinds": _other(
        classes=Classes("curtain", "blinds", "blind", UNLABELED),
        support="wall",
        fixed=True,
        makes=(makes.row("slat", makes.filled(400), "common"),),
    ),
    "ceiling": _other(
        fixed=True,
        classes=Classes("ceiling", "ceiling", "ceiling", UNLABELED),
    ),
    "ceiling_fan": _other(
        classes=Classes(UNLABELED, "otherprop", "fan", UNLABELED),
        support="ceiling",
    ),
    "ceiling_grid": _other(fixed=True, classes=Classes("ceiling", "ceiling", "ceiling", UNLABELED)),
    "chandelier": _other(
        classes=Classes("lamp", "otherstructure", "chandelier", UNLABELED),
        support="ceiling",
    ),
    "cladding": _other(fixed=True, classes=Classes("wall", "wall", "wall", UNLABELED)),
    "column": _other(
        classes=Classes(UNLABELED, "otherstructure", "column", UNLABELED),
        fixed=True,
    ),
    "cornice": _other(fixed=True, classes=Classes("wall", "otherstructure", "wall", UNLABELED)),
    "floor": _other(
        fixed=True,
        classes=Classes("floor", "floor", "floor", UNLABELED),
    ),
    "floor_mat": _other(
        classes=Classes(UNLABELED, "floor_mat", "rug", UNLABELED),
        makes=(makes.row(ANY, makes.filled(220), "common"),),
    ),
    "lamp": _other(
        classes=Classes("lamp", "lamp", "lamp", UNLABELED),
        schemes=(
            *LAMPS,
            *SOCKETED,
        ),
        makes=makes.LAMP,
    ),
    "opening": _other(
        fixed=True,
        classes=Classes(UNLABELED, "otherstructure", UNLABELED, UNLABELED),
        schemes=(Scheme({ANY: "white", "threshold": "wood"}),),
    ),
    "pendant_lamp": _other(
        classes=Classes("lamp", "lamp", "chandelier", UNLABELED),
        support="ceiling",
    ),
    "picture_rail": _other(
        fixed=True, classes=Classes("wall", "otherstructure", "wall", UNLABELED)
    ),
    "shelf": _other(
        classes=Classes("bookshelf", "shelves", "shelf", UNLABELED),
        schemes=STORAGE,
        makes=makes.STORAGE,
    ),
    "shower_curtain": _other(
        classes=Classes("curtain", "shower_curtain", "curtain", UNLABELED),
        fixed=True,
        makes=(
            makes.row("sheer", makes.filled(60), "common"),
            makes.row(f"curtain cord {ANY}", makes.filled(80), "common", "fabric"),
        ),
    ),
    "skirting": _other(fixed=True, classes=Classes("wall", "otherstructure", "wall", UNLABELED)),
    "storage": _other(
        classes=Classes("cabinet", "cabinet", "cabinet", UNLABELED),
        makes=makes.STORAGE,
    ),
    "wainscot": _other(fixed=True, classes=Classes("wall", "wall", "wall", UNLABELED)),
    "wall": _other(
        fixed=True,
        classes=Classes("wall", "wall", "wall", UNLABELED),
    ),
}
