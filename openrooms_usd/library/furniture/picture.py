"""Pictures on a wall."""

from typing import Final

from openrooms_usd.categories import makes
from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.record import NO_SYNSET, PLAIN_HINGES, RIGID, UNLABELED, Classes
from openrooms_usd.categories.schemes import Scheme
from openrooms_usd.library.furniture.built import NO_APPLIANCE, NO_LAMP, WIDE, BuiltCategory
from openrooms_usd.library.furniture.joinery import Style
from openrooms_usd.library.furniture.lying import Lies
from openrooms_usd.library.furniture.wall_board import canvas, framed, triptych

CATEGORY: Final = BuiltCategory(
    description="a picture on a wall",
    size=(0.5, 0.025, 0.7),
    least=(0.12, 0.012, 0.12),
    most=(3.0, 0.1, 2.2),
    styles={
        "framed": Style(framed, lambda size: size[0] < 2.2 * size[2]),
        "canvas": Style(canvas, lambda size: size[0] < 2.2 * size[2], (0.8, 0.03, 0.6)),
        "triptych": Style(triptych, lambda size: size[0] > 1.4 * size[2], (1.2, 0.03, 0.6)),
    },
    spread=WIDE,
    round=False,
    alike=False,
    support="wall",
    also=(),
    level=1.25,
    lumen=NO_LAMP,
    weighs={ANY: (0.8, 5)},
    worktop=NO_APPLIANCE,
    fixed=False,
    words="painting poster pictures photo picture_frame art artwork bulletin_board calendar "
    "corkboard map notice_board photo_frame photograph pin_board tapestry wall_art "
    "wall_hanging",
    classes=Classes(UNLABELED, "picture"),
    synsets=NO_SYNSET,
    schemes=(
        Scheme({ANY: "wood", "mat": "white_paper"}, weight=2.0),
        Scheme({ANY: "black", "mat": "white_paper"}),
        Scheme({ANY: "white", "mat": "white_paper"}),
    ),
    makes=(makes.row("canvas", makes.filled(200), "common"),),
    hinges=PLAIN_HINGES,
    yields=RIGID,
    lies=(Lies(on=("wall",), most=5, makes=5),),
)
