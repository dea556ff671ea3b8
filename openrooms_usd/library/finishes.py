"""What furniture is usually made of: finishes, and which finish each part of a category has."""

from collections.abc import Iterable, Mapping
from math import prod
from typing import Final

import numpy as np

from openrooms_usd.description.substances import Substance
from openrooms_usd.furniture.construction import ANY
from openrooms_usd.furniture.registry import record
from openrooms_usd.furniture.schemes import METAL, METALS, Scheme
from openrooms_usd.library.assignment.kinds import known_as
from openrooms_usd.library.assignment.weights import Weights, families_for
from openrooms_usd.library.finish import Finish
from openrooms_usd.library.small_finishes import SMALL_THINGS
from openrooms_usd.library.textures import Use

# What a part gets of which nothing is known.
UNKNOWN: Final = "lacquer"


_MOULDED: Final = {"moulded_plastic": 1.0, "spark_eroded_plastic": 1.0}
# What has no substance of its own among the nine is counted to the one that it feels like: glass,
# glazed ceramic and vitreous enamel are smooth stones, fired clay and soil are rough ones, paper is
# wood (cellulose), the skin of leaves and fruit is a polyester, and billiard balls are cast resin.
FINISHES: Final[dict[str, Finish]] = {
    "wood": Finish(
        "wood",
        {"quartered_oak": 3, "walnut_veneer": 2.5, "ash_veneer": 2, "beech_staves": 2,
         "pine_staves": 1.5, "birch_plywood": 1, "sapele_ribbon": 0.7, "curly_maple": 0.3,
         "bamboo_strips": 0.3},
        choices=3,
    ),
    # Shells and legs in one piece: no joints of boards run across what is bent or turned.
    "bent_wood": Finish(
        "wood",
        {"quartered_oak": 3, "walnut_veneer": 2.5, "ash_veneer": 2, "birch_plywood": 1,
         "sapele_ribbon": 0.7},
        choices=3,
    ),
    "lacquer": Finish(
        "paint", {"sprayed_satin": 6, "high_gloss_lacquer": 1, "chalk_paint": 0.3},
        colors=((0.76, 0.75, 0.72), (0.42, 0.41, 0.39), (0.065, 0.07, 0.075), (0.27, 0.33, 0.27),
                (0.13, 0.22, 0.31), (0.58, 0.50, 0.39)),
        choices=3,
    ),
    "kitchen_lacquer": Finish(
        "paint", {"sprayed_satin": 3, "high_gloss_lacquer": 1},
        colors=((0.62, 0.6, 0.55), (0.3, 0.34, 0.29), (0.1, 0.15, 0.2), (0.045, 0.047, 0.05),
                (0.36, 0.42, 0.4), (0.45, 0.42, 0.38)),
    ),
    "wall_tiles": Finish(
        "specular_stone",
        {"subway_tiles": 4, "zellige": 1, "porcelain_tiles": 1, "hexagon_mosaic": 0.7,
         "fish_scale_tiles": 0.5},
    ),
    "piano_lacquer": Finish(
        "paint", {"high_gloss_lacquer": 1}, colors=((0.02, 0.02, 0.021),), roughness=(0.06, 0.12),
    ),
    "ivory": Finish("plastic", colors=((0.72, 0.7, 0.64),), roughness=(0.2, 0.3)),
    "ebony": Finish("wood", colors=((0.035, 0.026, 0.02),), roughness=(0.35, 0.45)),
    "bag_cloth": Finish(
        "fabric", {"canvas": 2, "twill": 2},
        colors=((0.03, 0.035, 0.05), (0.025, 0.025, 0.026), (0.1, 0.11, 0.07), (0.3, 0.05, 0.04),
                (0.06, 0.12, 0.2), (0.25, 0.2, 0.13)),
        choices=3,
    ),
    "luggage_shell": Finish(
        "plastic",
        colors=((0.05, 0.055, 0.06), (0.03, 0.07, 0.12), (0.35, 0.36, 0.36), (0.3, 0.06, 0.05),
                (0.18, 0.26, 0.22)),
        roughness=(0.3, 0.45), choices=2,
    ),
    "soft_vinyl": Finish(
        "rubber", colors=((0.12, 0.2, 0.3), (0.3, 0.3, 0.31), (0.3, 0.09, 0.12), (0.1, 0.22, 0.18)),
        roughness=(0.45, 0.6), choices=2,
    ),
    "water_bottle": Finish(
        "plastic", colors=((0.2, 0.32, 0.45),), roughness=(0.1, 0.18), transmission=0.4,
    ),
    "back_painted_glass": Finish(
        "specular_stone", colors=((0.7, 0.71, 0.7), (0.35, 0.4, 0.38), (0.05, 0.052, 0.055)),
        roughness=(0.03, 0.06),
    ),
    "white": Finish(
        "paint", {"sprayed_satin": 1}, colors=((0.79, 0.785, 0.77),), roughness=(0.34, 0.42),
    ),
    "upholstery": Finish(
        "fabric",
        {"twill": 2, "basket_weave": 2, "linen": 2, "canvas": 1.5, "boucle": 1.5, "velvet": 1.5,
         "corduroy": 1, "herringbone": 1, "felt": 0.7, "repp": 0.5},
        choices=3,
    ),
    "hide": Finish(
        "leather",
        {"full_grain_leather": 3, "pebbled_leather": 2, "nappa": 2, "suede": 0.7, "nubuck": 0.7,
         "stitched_leather": 0.2},
        choices=2,
    ),
    "throw": Finish(
        "fabric",
        {"waffle_weave": 2, "cable_knit": 1, "rib_knit": 1, "jersey_knit": 1, "boucle": 1,
         "tartan": 0.3, "seersucker": 0.3, "twill": 1},
        choices=2,
    ),
    "linen": Finish(
        "fabric", {"linen": 4, "canvas": 1, "satin": 0.5, "waffle_weave": 0.5},
        colors=((0.58, 0.56, 0.52), (0.5, 0.47, 0.41), (0.36, 0.42, 0.46)), choices=2,
    ),
    "drape": Finish(
        "fabric", {"linen": 2, "twill": 1, "canvas": 1, "repp": 1},
        colors=((0.43, 0.41, 0.37), (0.38, 0.35, 0.32), (0.29, 0.33, 0.36)), choices=2,
        transmission=0.1,
    ),
    # A roller blind lets a sixth through.
    "blind": Finish(
        "fabric", {"canvas": 2, "linen": 1},
        colors=((0.44, 0.43, 0.4), (0.42, 0.39, 0.33), (0.3, 0.32, 0.34)), choices=2,
        transmission=0.37,
    ),
    "sheer": Finish(
        "fabric", colors=((0.28, 0.277, 0.27),), roughness=(0.8, 0.9), transmission=0.66,
    ),
    "shade": Finish(
        "fabric", {"linen": 3, "canvas": 1}, colors=((0.6, 0.58, 0.53), (0.57, 0.5, 0.4)),
        choices=2,
    ),
    "black": Finish(
        "paint", {"powder_coat": 1}, colors=((0.03, 0.03, 0.032),), roughness=(0.45, 0.6),
    ),
    "steel": Finish(
        "metal", {"brushed_metal": 3, "orbital_sanded": 1, "sandblasted_metal": 1},
        colors=((0.56, 0.55, 0.53),), roughness=(0.24, 0.38),
    ),
    "brass": Finish(
        "metal", {"polished_metal": 1, "brushed_metal": 1},
        colors=((0.70, 0.51, 0.25),), roughness=(0.18, 0.34),
    ),
    "ceramic": Finish(
        "specular_stone", {"crackle_glaze": 1},
        colors=((0.78, 0.77, 0.74), (0.45, 0.47, 0.45), (0.25, 0.29, 0.31)),
        roughness=(0.08, 0.2), choices=2,
    ),
    "sanitary": Finish("specular_stone", colors=((0.8, 0.8, 0.79),), roughness=(0.06, 0.1)),
    "screen": Finish("specular_stone", colors=((0.022, 0.022, 0.025),), roughness=(0.06, 0.12)),
    "carpet": Finish(
        "fabric", {"cut_carpet": 3, "loop_carpet": 2, "shag_carpet": 1},
        colors=((0.46, 0.41, 0.34), (0.28, 0.29, 0.3), (0.36, 0.16, 0.12), (0.16, 0.2, 0.28)),
        choices=3,
    ),
    "carpet_border": Finish(
        "fabric", {"repp": 1, "canvas": 1},
        colors=((0.12, 0.11, 0.1), (0.5, 0.47, 0.41), (0.2, 0.1, 0.07)), choices=2,
    ),
    "stone": Finish(
        "specular_stone",
        {"quartz_worktop": 3, "granite": 2, "carrara_marble": 1.5, "terrazzo": 0.1,
         "black_galaxy_granite": 0.7},
    ),
    "masonry": Finish(
        "rough_stone",
        {"sandstone": 2, "shell_limestone": 2, "travertine": 1, "slate": 1, "basalt": 0.5},
        choices=2,
    ),
    "pebble": Finish(
        "rough_stone", colors=((0.52, 0.5, 0.46), (0.24, 0.235, 0.23)), roughness=(0.5, 0.7),
    ),
    "soot": Finish("rough_stone", colors=((0.035, 0.033, 0.031),), roughness=(0.8, 0.95)),
    "chrome": Finish(
        "metal", {"polished_metal": 1}, colors=((0.6, 0.61, 0.62),), roughness=(0.08, 0.14),
    ),
    # A pane of glass, of which the silver behind it is seen.
    "mirror": Finish(
        "specular_stone", colors=((0.88, 0.89, 0.88),), roughness=(0.02, 0.03), metallic=1.0,
    ),
    "grey": Finish(
        "paint", {"powder_coat": 1}, colors=((0.36, 0.365, 0.36), (0.2, 0.205, 0.21)),
        roughness=(0.4, 0.55),
    ),
    "enamel": Finish("specular_stone", colors=((0.79, 0.79, 0.78),), roughness=(0.14, 0.24)),
    "cavity": Finish("specular_stone", colors=((0.05, 0.052, 0.058),), roughness=(0.3, 0.45)),
    "plastic": Finish("plastic", colors=((0.74, 0.75, 0.75),), roughness=(0.28, 0.4)),
    "dark_plastic": Finish("plastic", _MOULDED, colors=((0.06, 0.062, 0.065),)),
    "cast_iron": Finish("metal", colors=((0.025, 0.025, 0.026),), roughness=(0.55, 0.7)),
    "print": Finish("paint", colors=((0.34, 0.34, 0.34),), roughness=(0.3, 0.4)),
    "paper": Finish("wood", colors=((0.7, 0.67, 0.58),), roughness=(0.8, 0.9)),
    "binding": Finish(
        "fabric",
        colors=((0.24, 0.045, 0.04), (0.04, 0.075, 0.15), (0.055, 0.12, 0.075), (0.5, 0.44, 0.33),
                (0.05, 0.048, 0.046), (0.62, 0.6, 0.55), (0.26, 0.12, 0.045), (0.16, 0.2, 0.23),
                (0.12, 0.07, 0.045), (0.34, 0.33, 0.3), (0.2, 0.3, 0.34), (0.4, 0.3, 0.12)),
        roughness=(0.5, 0.75), choices=16, each=True,
    ),
    "tinted_plastic": Finish(
        "plastic", _MOULDED, colors=((0.72, 0.715, 0.7), (0.18, 0.18, 0.185), (0.24, 0.3, 0.33)),
        choices=2,
    ),
    "pale_plastic": Finish(
        "plastic", _MOULDED, colors=((0.7, 0.69, 0.66), (0.62, 0.58, 0.5)), choices=2,
    ),
    "black_plastic": Finish("plastic", colors=((0.022, 0.022, 0.024),), roughness=(0.3, 0.45)),
    "membrane": Finish("rubber", colors=((0.05, 0.05, 0.053),), roughness=(0.55, 0.7)),
    "tyre": Finish("rubber", colors=((0.03, 0.03, 0.031),), roughness=(0.6, 0.8)),
    "aluminium": Finish(
        "metal", {"anodised_aluminium": 2, "sandblasted_metal": 1},
        colors=((0.68, 0.68, 0.69), (0.45, 0.45, 0.46)), roughness=(0.32, 0.42),
    ),
    "white_paper": Finish("wood", colors=((0.8, 0.8, 0.785),), roughness=(0.8, 0.95)),
    "print_ground": Finish(
        "paint", colors=((0.7, 0.66, 0.57), (0.62, 0.64, 0.62), (0.55, 0.3, 0.18),
                         (0.1, 0.16, 0.22), (0.3, 0.36, 0.3)),
        roughness=(0.6, 0.8), choices=4,
    ),
    "print_field": Finish(
        "paint", colors=((0.05, 0.1, 0.16), (0.45, 0.13, 0.07), (0.13, 0.2, 0.14),
                         (0.06, 0.055, 0.06), (0.35, 0.27, 0.16)),
        roughness=(0.6, 0.8), choices=5, each=True,
    ),
    "print_accent": Finish(
        "paint", colors=((0.72, 0.42, 0.08), (0.6, 0.1, 0.06), (0.78, 0.74, 0.66),
                         (0.1, 0.3, 0.38)),
        roughness=(0.6, 0.8), choices=4, each=True,
    ),
    "leaf": Finish(
        "plastic", colors=((0.045, 0.12, 0.035), (0.06, 0.15, 0.05), (0.09, 0.17, 0.06)),
        roughness=(0.32, 0.5), choices=3,
    ),
    "stem": Finish("wood", colors=((0.1, 0.12, 0.045),), roughness=(0.5, 0.7)),
    "soil": Finish("rough_stone", colors=((0.05, 0.036, 0.026),), roughness=(0.9, 1.0)),
    "terracotta": Finish("rough_stone", colors=((0.42, 0.19, 0.11),), roughness=(0.7, 0.85)),
    "glaze": Finish(
        "specular_stone", colors=((0.78, 0.77, 0.73), (0.06, 0.13, 0.24), (0.2, 0.32, 0.27),
                                  (0.5, 0.27, 0.14)),
        roughness=(0.08, 0.22), choices=3,
    ),
    "felt": Finish(
        "fabric", {"felt": 1}, colors=((0.03, 0.16, 0.075), (0.04, 0.11, 0.2), (0.26, 0.035, 0.04)),
        choices=2,
    ),
    "rope": Finish(
        "fabric", {"basket_weave": 2, "sisal": 1},
        colors=((0.5, 0.38, 0.23), (0.42, 0.4, 0.36)), choices=2,
    ),
    # Float glass of 4 mm: a little green.
    "glass": Finish(
        "specular_stone", colors=((0.86, 0.9, 0.88),), roughness=(0.01, 0.011),
        pane=(0.978, 0.989, 0.981),
    ),
    "bulb": Finish("specular_stone", colors=((0.8, 0.8, 0.79),), roughness=(0.2, 0.3)),
    **SMALL_THINGS,
}  # fmt: skip

# What a substance means on furniture, where nobody says more.
GENERIC: Final[dict[Substance, str]] = {
    "fabric": "upholstery",
    "leather": "hide",
    "metal": "steel",
    "paint": "lacquer",
    "plastic": "tinted_plastic",
    "rough_stone": "masonry",
    "rubber": "tyre",
    "specular_stone": "stone",
    "wood": "wood",
}

_NO_FACTORS: Final[Weights] = {}
_ON_FURNITURE: Final[tuple[Use, ...]] = ("furniture", "object", "textile")

# Parts that are the same on whatever they are found.
PARTS: Final = {
    "seat_cushion": "upholstery",
    "back_cushion": "upholstery",
    "cushion": "upholstery",
    "pillow": "linen",
    "mattress": "linen",
    "blanket": "throw",
    "sheet": "linen",
    "lamp_shade": "shade",
    "lamp_pole": METAL,
    "light_bulb": "bulb",
    "handle": METAL,
    "bracket": METAL,
    "switch": "black",
    "wheel": "tyre",
    "firebox": "soot",
    "log": "wood",
    "tube": METAL,
    "glass": "screen",
    "screen": "screen",
    "accent": "print_accent",
    "agitator": "plastic",
    "book": "binding",
    "burner": "cast_iron",
    "button": "dark_plastic",
    "canvas": "print_ground",
    "drain": "chrome",
    "drum": "steel",
    "driver": "black_plastic",
    "field": "print_field",
    "fruit": "fruit",
    "grate": "cast_iron",
    "label": "paper",
    "leaf": "leaf",
    "lever": "chrome",
    "lock": "chrome",
    "mark": "print",
    "mirror": "mirror",
    "pages": "paper",
    "spine_print": "spine_ink",
    "pane": "glass",
    "plant": "leaf",
    "rack": "chrome",
    "roller": "plastic",
    "soil": "soil",
    "spout": "chrome",
    "stem": "stem",
}


def finishes_of(
    category: str,
    parts: Iterable[str],
    rng: np.random.Generator,
    factors: Weights = _NO_FACTORS,
    metal: str | None = None,
) -> dict[str, str]:
    """Choose a finish for each part of an object.

    Args:
        category: What it is; any word.
        parts: The kinds of its parts; any words.
        rng: Draws one of the schemes that fit, and its metal.
        factors: How much more or less often schemes with these finishes are drawn.
        metal: The metal that all objects of the room share; drawn by default.

    Returns:
        Keys of `FINISHES` by part.
    """
    names = sorted(set(parts))
    known = record(category)
    schemes = known.schemes if known else ()
    fitting = [scheme for scheme in schemes if scheme.needs is None or scheme.needs in names]
    fitting = [scheme for scheme in fitting if scheme.suite] or fitting
    weights = np.cumsum([_weight(scheme, factors) for scheme in fitting] or [1.0])
    drawn = int(np.searchsorted(weights, rng.uniform(0.0, weights[-1]), side="right"))
    chosen = fitting[drawn].finishes if fitting else {}
    drawn_metal = METALS[int(rng.integers(len(METALS)))]
    metal = metal or drawn_metal
    picked = {part: _finish(part, chosen) for part in names}
    return {part: metal if finish == METAL else finish for part, finish in picked.items()}


def suite_of(category: str, parts: Iterable[str]) -> str:
    """The suite that an object is of, by the kinds of its parts; empty for none."""
    known, names = record(category), set(parts)
    schemes = known.schemes if known else ()
    return next((s.suite for s in schemes if s.suite and (s.needs or "") in {"", *names}), "")


def _weight(scheme: Scheme, factors: Weights) -> float:
    """How often a scheme is drawn: its own weight times the factors of its finishes."""
    named = sorted(set(scheme.finishes.values()))
    return scheme.weight * prod(factors.get(finish, 1.0) for finish in named)


def _finish(part: str, scheme: Mapping[str, str]) -> str:
    """The finish of a part: by the scheme, else by `PARTS`, else that of the scheme's rest."""
    for table in (scheme, PARTS):
        for name in known_as(part):
            if name in table:
                return table[name]
    return scheme.get(ANY, UNKNOWN)


def furniture_families(substance: Substance) -> Weights:
    """The families of a substance that suit furniture."""
    return FINISHES[GENERIC[substance]].families or families_for(substance, _ON_FURNITURE)
