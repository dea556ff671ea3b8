"""Jars with lids."""

from typing import Final

from openrooms_usd.furniture.construction import row, walls
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.joinery.vessel import jar_canister, jar_ginger, jar_preserving
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import WIDE, BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme

_KITCHENS: Final = "kitchen apartment"

CATEGORY: Final = BuiltCategory(
    description="a jar with a lid",
    size=(0.11, 0.11, 0.17),
    min_size=(0.04, 0.04, 0.05),
    max_size=(0.5, 0.5, 0.7),
    styles={
        "ginger": Style(jar_ginger, size=(0.17, 0.17, 0.24)),
        "preserving": Style(jar_preserving, size=(0.09, 0.09, 0.15)),
        "canister": Style(jar_canister),
    },
    size_variation=WIDE,
    round=True,
    support="surface",
    mass_range=(0.2, 2),
    words="canister",
    classes=Classes(openrooms45="jar"),
    synsets=("03593526",),
    schemes=(
        scheme("glaze", glaze="handle"),
        scheme(
            "glaze", wood="lid", membrane="seal", bottle_label="label", needs="seal", weight=100.0
        ),
        scheme("bottle_glass", metal="lid frame", needs="frame", weight=100.0),
    ),
    construction=(
        row("container", walls(3), "common", "specular_stone"),
        row("lid", walls(0.4), "sheet", "metal"),
    ),
    placements=(
        on("worktop shelf cupboard", _KITCHENS, count=(2, 4), cluster="cooking", max_variants=4),
        on("worktop dining_table mantel", weight=0.6, cluster="cooking", max_variants=4),
        on("shelf cabinet_top dresser_top media_top desk", weight=0.5, max_variants=4),
    ),
)
