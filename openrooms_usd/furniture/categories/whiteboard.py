"""Boards to write on, on a wall or on wheels."""

from typing import Final

from openrooms_usd.furniture.construction import ALUMINIUM, ANY, STEEL, filled, row, walls
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.joinery.wall_board import glass, mobile, wall
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme

CATEGORY: Final = BuiltCategory(
    description="a board to write on; it stands where it is deep",
    size=(1.8, 0.08, 1.2),
    min_size=(0.4, 0.05, 0.3),
    max_size=(4.0, 1.0, 2.2),
    styles={
        "wall": Style(wall, lambda size: size[1] < 0.3),
        "glass": Style(glass, lambda size: size[1] < 0.3),
        "mobile": Style(mobile, lambda size: size[1] >= 0.3, (1.6, 0.6, 1.85)),
    },
    support="wall",
    mount_height=0.9,
    mass_range=(8, 35),
    words="white_board blackboard board board_panel chalkboard display_panel dry_erase_board "
    "projection_screen projector_screen",
    classes=Classes(openrooms45="whiteboard", nyu40="whiteboard"),
    schemes=(
        scheme(
            "aluminium", enamel="board", black_plastic="corner", felt_pen="pen", membrane="eraser"
        ),
    ),
    construction=(
        row(ANY, filled(800), "weight"),
        row("stand", walls(1.5, STEEL), "sheet"),
        row("frame tray bracket stud", walls(1.5, ALUMINIUM), "common"),
    ),
    view_importance=0.7,
)
