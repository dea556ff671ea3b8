"""Boards to write on, on a wall or on wheels."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.library.furniture.built import NO_APPLIANCE, NO_LAMP, USUAL, BuiltCategory
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.wall_board import glass, mobile, wall

CATEGORY: Final = BuiltCategory(
    description="a board to write on; it stands where it is deep",
    size=(1.8, 0.08, 1.2),
    least=(0.4, 0.05, 0.3),
    most=(4.0, 1.0, 2.2),
    styles={
        "wall": Style(wall, lambda size: size[1] < 0.3),
        "glass": Style(glass, lambda size: size[1] < 0.3),
        "mobile": Style(mobile, lambda size: size[1] >= 0.3, (1.6, 0.6, 1.85)),
    },
    spread=USUAL,
    round=False,
    alike=False,
    support="wall",
    also=(),
    level=0.9,
    lumen=NO_LAMP,
    weighs={ANY: (8, 35)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="white_board blackboard board board_panel chalkboard display_panel dry_erase_board "
    "projection_screen projector_screen",
    classes=Classes("whiteboard", "whiteboard", UNLABELED, UNLABELED),
    synsets=NO_SYNSET,
    schemes=(
        Scheme(
            {
                ANY: "aluminium",
                "board": "enamel",
                "corner": "black_plastic",
                "pen": "felt_pen",
                "eraser": "membrane",
            }
        ),
    ),
    makes=(
        makes.row(ANY, makes.filled(800), "weight"),
        makes.row("stand", makes.walls(1.5, makes.STEEL), "sheet"),
        makes.row("frame tray bracket stud", makes.walls(1.5, makes.ALUMINIUM), "common"),
    ),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    photographed=0.7,
)
