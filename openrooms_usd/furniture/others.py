"""Categories that nothing builds: the shell of rooms, and what captures and own files bring."""

from typing import Final

from openrooms_usd.furniture.construction import ANY, LAMP_ROWS, STORAGE_ROWS, filled, row
from openrooms_usd.furniture.record import Category, Classes
from openrooms_usd.furniture.schemes import LAMPS, SOCKETED, STORAGE, scheme

OTHERS: Final[dict[str, Category]] = {
    "beam": Category(fixed=True, classes=Classes("ceiling", "otherstructure", "ceiling")),
    "blinds": Category(
        classes=Classes("curtain", "blinds", "blind"),
        support="wall",
        fixed=True,
        construction=(row("slat", filled(400), "common"),),
    ),
    "ceiling": Category(fixed=True, classes=Classes("ceiling", "ceiling", "ceiling")),
    "ceiling_fan": Category(classes=Classes(ade20k="fan"), support="ceiling"),
    "ceiling_grid": Category(fixed=True, classes=Classes("ceiling", "ceiling", "ceiling")),
    "chandelier": Category(
        classes=Classes("lamp", "otherstructure", "chandelier"), support="ceiling"
    ),
    "cladding": Category(fixed=True, classes=Classes("wall", "wall", "wall")),
    "column": Category(classes=Classes(nyu40="otherstructure", ade20k="column"), fixed=True),
    "cornice": Category(fixed=True, classes=Classes("wall", "otherstructure", "wall")),
    "floor": Category(fixed=True, classes=Classes("floor", "floor", "floor")),
    "floor_mat": Category(
        classes=Classes(nyu40="floor_mat", ade20k="rug"),
        construction=(row(ANY, filled(220), "common"),),
    ),
    "lamp": Category(
        classes=Classes("lamp", "lamp", "lamp"), schemes=(*LAMPS, *SOCKETED), construction=LAMP_ROWS
    ),
    "opening": Category(
        fixed=True,
        classes=Classes(nyu40="otherstructure"),
        schemes=(scheme("white", wood="threshold"),),
    ),
    "pendant_lamp": Category(classes=Classes("lamp", "lamp", "chandelier"), support="ceiling"),
    "picture_rail": Category(fixed=True, classes=Classes("wall", "otherstructure", "wall")),
    "shelf": Category(
        classes=Classes("bookshelf", "shelves", "shelf"), schemes=STORAGE, construction=STORAGE_ROWS
    ),
    "shower_curtain": Category(
        classes=Classes("curtain", "shower_curtain", "curtain"),
        fixed=True,
        construction=(
            row("sheer", filled(60), "common"),
            row(f"curtain cord {ANY}", filled(80), "common", "fabric"),
        ),
    ),
    "skirting": Category(fixed=True, classes=Classes("wall", "otherstructure", "wall")),
    "storage": Category(
        classes=Classes("cabinet", "cabinet", "cabinet"), construction=STORAGE_ROWS
    ),
    "wainscot": Category(fixed=True, classes=Classes("wall", "wall", "wall")),
    "wall": Category(fixed=True, classes=Classes("wall", "wall", "wall")),
}
