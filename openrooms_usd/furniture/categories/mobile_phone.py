"""Mobile phones, on their back or on their screen."""

from functools import partial
from typing import Final

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.handheld import slab
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import STANDARD, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme

_FACE_UP: Final = partial(slab, corner=0.009, rim=0.0022)

CATEGORY: Final = BuiltCategory(
    description="a mobile phone",
    size=(0.072, 0.148, 0.008),
    min_size=(0.04, 0.08, 0.005),
    max_size=(0.12, 0.22, 0.03),
    styles={"face_up": Style(_FACE_UP), "face_down": Style(partial(_FACE_UP, camera=True))},
    size_variation=STANDARD,
    support="surface",
    mass_range=(0.1, 0.3),
    words="cell_phone cellphone smartphone cellular_telephone iphone",
    classes=Classes(openrooms45="telephone", coco="cell_phone"),
    schemes=(
        scheme("black_plastic", screen="lens", weight=2.0),
        scheme("phone_back", screen="lens"),
    ),
    construction=(row(ANY, filled(2100), "weight"),),
    placements=(
        on("desk bedside", pose="flat", weight=0.5, cluster="charging", max_groups=1),
        on(
            "coffee_table dining_table worktop sofa_arm sofa_seat",
            pose="flat",
            clutter=2,
            weight=0.3,
            max_groups=1,
        ),
    ),
)
