"""What small things are finished with: tableware, packages, cloths, toys, paper and ink.

What has no substance of its own among the nine is counted to the one that it feels like, as in
`finishes`.
"""

from typing import Final

from openrooms_usd.furniture.schemes import TONES
from openrooms_usd.library.finish import Finish

_PALETTES: Final = {
    "dawn": ((0.7, 0.53, 0.4), (0.85, 0.74, 0.52), (0.46, 0.4, 0.44), (0.27, 0.28, 0.36),
             (0.11, 0.14, 0.19), (0.045, 0.06, 0.07)),
    "meadow": ((0.5, 0.62, 0.7), (0.8, 0.8, 0.74), (0.32, 0.43, 0.48), (0.19, 0.31, 0.25),
               (0.09, 0.18, 0.09), (0.21, 0.23, 0.08)),
    "silver": ((0.66, 0.66, 0.65), (0.8, 0.8, 0.79), (0.41, 0.41, 0.405), (0.24, 0.24, 0.237),
               (0.1, 0.1, 0.099), (0.04, 0.04, 0.04)),
    "ochre": ((0.64, 0.56, 0.41), (0.68, 0.28, 0.09), (0.48, 0.34, 0.19), (0.3, 0.17, 0.085),
              (0.15, 0.085, 0.055), (0.065, 0.046, 0.037)),
}  # fmt: skip

SMALL_THINGS: Final[dict[str, Finish]] = {
    "billiard": Finish(
        "plastic", colors=((0.62, 0.36, 0.02), (0.02, 0.06, 0.3), (0.5, 0.03, 0.02),
                           (0.12, 0.03, 0.2), (0.6, 0.16, 0.02), (0.02, 0.2, 0.07),
                           (0.22, 0.03, 0.04), (0.02, 0.02, 0.02)),
        roughness=(0.04, 0.08), choices=16, each=True,
    ),
    "felt_pen": Finish(
        "plastic", colors=((0.45, 0.03, 0.03), (0.03, 0.08, 0.35), (0.03, 0.25, 0.08),
                           (0.03, 0.03, 0.03)),
        roughness=(0.3, 0.4), choices=4, each=True,
    ),
    "bottle_label": Finish(
        "wood", colors=((0.74, 0.71, 0.63), (0.12, 0.12, 0.13), (0.35, 0.09, 0.07)),
        roughness=(0.5, 0.7), choices=2,
    ),
    "bottle_glass": Finish(
        "specular_stone", colors=((0.02, 0.05, 0.025), (0.075, 0.032, 0.01)),
        roughness=(0.04, 0.08), choices=2,
    ),
    "fruit": Finish(
        "plastic", colors=((0.5, 0.05, 0.035), (0.62, 0.26, 0.03), (0.32, 0.42, 0.07)),
        roughness=(0.25, 0.4), choices=6, each=True,
    ),
    "apple_skin": Finish(
        "plastic", colors=((0.42, 0.04, 0.025), (0.3, 0.36, 0.06), (0.5, 0.22, 0.06),
                           (0.28, 0.025, 0.03)),
        roughness=(0.22, 0.34), choices=6,
    ),
    "orange_skin": Finish("plastic", colors=((0.72, 0.24, 0.015),), roughness=(0.4, 0.5)),
    "pear_skin": Finish(
        "plastic", colors=((0.4, 0.42, 0.09), (0.45, 0.32, 0.1)), roughness=(0.4, 0.55), choices=3,
    ),
    "lemon_skin": Finish("plastic", colors=((0.74, 0.55, 0.03),), roughness=(0.35, 0.45)),
    "banana_skin": Finish(
        "plastic", colors=((0.7, 0.5, 0.05), (0.55, 0.5, 0.07)), roughness=(0.4, 0.5), choices=2,
    ),
    "toiletry": Finish(
        "plastic", colors=((0.74, 0.73, 0.7), (0.1, 0.28, 0.42), (0.62, 0.3, 0.34),
                           (0.16, 0.34, 0.25), (0.03, 0.03, 0.032), (0.66, 0.46, 0.14),
                           (0.36, 0.2, 0.42)),
        roughness=(0.15, 0.35), choices=12,
    ),
    "toiletry_cap": Finish(
        "plastic", colors=((0.76, 0.76, 0.75), (0.04, 0.04, 0.042), (0.5, 0.48, 0.42)),
        roughness=(0.2, 0.4), choices=4,
    ),
    "tinted_glass": Finish(
        "specular_stone", colors=((0.5, 0.53, 0.52),), roughness=(0.01, 0.011),
        pane=(0.56, 0.59, 0.58),
    ),
    "porcelain": Finish(
        "specular_stone", colors=((0.8, 0.79, 0.76), (0.78, 0.75, 0.68), (0.42, 0.47, 0.5),
                                  (0.17, 0.19, 0.2)),
        roughness=(0.07, 0.16),
    ),
    "mug_glaze": Finish(
        "specular_stone", colors=((0.78, 0.77, 0.74), (0.06, 0.1, 0.2), (0.45, 0.12, 0.07),
                                  (0.3, 0.4, 0.36), (0.62, 0.44, 0.16), (0.04, 0.04, 0.042)),
        roughness=(0.07, 0.2), choices=6,
    ),
    "coffee": Finish("specular_stone", colors=((0.028, 0.022, 0.02),), roughness=(0.03, 0.05)),
    "clear_glass": Finish(
        "specular_stone", colors=((0.88, 0.9, 0.9),), roughness=(0.01, 0.011),
        pane=(0.955, 0.965, 0.96),
    ),
    "cutlery_steel": Finish(
        "metal", {"polished_metal": 1}, colors=((0.6, 0.59, 0.57),), roughness=(0.12, 0.22),
    ),
    "cookware_steel": Finish(
        "metal", {"brushed_metal": 2, "polished_metal": 1}, colors=((0.58, 0.57, 0.56),),
        roughness=(0.16, 0.28),
    ),
    "cookware_black": Finish("metal", colors=((0.03, 0.03, 0.031),), roughness=(0.3, 0.45)),
    "cookware_enamel": Finish(
        "specular_stone", colors=((0.45, 0.05, 0.03), (0.05, 0.12, 0.2), (0.72, 0.68, 0.58),
                                  (0.13, 0.2, 0.17)),
        roughness=(0.1, 0.18), choices=2,
    ),
    "board_wood": Finish(
        "wood", {"beech_staves": 2, "walnut_veneer": 1.5, "quartered_oak": 1.5,
                 "bamboo_strips": 1, "butcher_block": 1},
        choices=2,
    ),
    "crust": Finish(
        "rough_stone", {"cast_concrete": 1}, colors=((0.36, 0.17, 0.06), (0.3, 0.13, 0.045)),
        roughness=(0.6, 0.75), choices=2,
    ),
    "crumb": Finish("rubber", {"sponge": 1}, colors=((0.66, 0.52, 0.32),), roughness=(0.85, 0.95)),
    "cardboard": Finish("wood", colors=((0.36, 0.25, 0.15),), roughness=(0.8, 0.9)),
    "package": Finish(
        "wood", colors=((0.55, 0.05, 0.03), (0.03, 0.13, 0.36), (0.62, 0.4, 0.04),
                        (0.05, 0.26, 0.1), (0.6, 0.17, 0.03), (0.7, 0.68, 0.62),
                        (0.22, 0.05, 0.18), (0.04, 0.3, 0.34)),
        roughness=(0.35, 0.55), choices=12, each=True,
    ),
    "package_field": Finish(
        "wood", colors=((0.7, 0.6, 0.3), (0.6, 0.08, 0.05), (0.08, 0.2, 0.42), (0.1, 0.32, 0.16),
                        (0.66, 0.64, 0.58), (0.5, 0.26, 0.1), (0.72, 0.45, 0.06)),
        roughness=(0.35, 0.55), choices=12, each=True,
    ),
    "package_ink": Finish(
        "wood", colors=((0.78, 0.77, 0.74), (0.04, 0.04, 0.05)), roughness=(0.35, 0.55),
        choices=2,
    ),
    "terry": Finish(
        "fabric", {"waffle_weave": 1, "boucle": 1},
        colors=((0.74, 0.73, 0.7), (0.42, 0.45, 0.46), (0.5, 0.42, 0.33), (0.2, 0.28, 0.33),
                (0.42, 0.3, 0.27)),
        roughness=(0.85, 0.95), choices=2,
    ),
    "dish_linen": Finish(
        "fabric", {"ticking": 2, "waffle_weave": 2, "linen": 2, "tartan": 1}, choices=3,
    ),
    "table_linen": Finish(
        "fabric", {"linen": 1}, colors=((0.7, 0.68, 0.63), (0.33, 0.36, 0.33), (0.25, 0.28, 0.34)),
    ),
    "soap": Finish(
        "plastic", colors=((0.74, 0.7, 0.58), (0.7, 0.66, 0.66), (0.5, 0.58, 0.5)),
        roughness=(0.35, 0.5), choices=2,
    ),
    "sponge": Finish(
        "rubber", {"sponge": 1}, colors=((0.68, 0.5, 0.06), (0.66, 0.22, 0.3)), choices=2,
    ),
    "scourer": Finish("fabric", {"felt": 1}, colors=((0.05, 0.2, 0.06),), roughness=(0.85, 0.95)),
    "toy_plastic": Finish(
        "plastic", colors=((0.6, 0.05, 0.03), (0.02, 0.14, 0.5), (0.68, 0.44, 0.02),
                           (0.03, 0.32, 0.09), (0.64, 0.2, 0.02), (0.66, 0.65, 0.62),
                           (0.35, 0.1, 0.4)),
        roughness=(0.2, 0.35), choices=14, each=True,
    ),
    "tissue": Finish("fabric", colors=((0.8, 0.8, 0.79),), roughness=(0.9, 1.0)),
    "wax": Finish(
        "plastic", colors=((0.76, 0.71, 0.6), (0.74, 0.73, 0.7), (0.4, 0.09, 0.07)),
        roughness=(0.35, 0.5), choices=2, transmission=0.05,
    ),
    "can_metal": Finish(
        "metal", {"polished_metal": 1}, colors=((0.62, 0.62, 0.61),), roughness=(0.15, 0.25),
    ),
    "newsprint": Finish("wood", colors=((0.56, 0.54, 0.49),), roughness=(0.85, 0.95)),
    "spine_ink": Finish(
        "paint", colors=((0.66, 0.5, 0.2), (0.74, 0.72, 0.66), (0.05, 0.05, 0.055),
                         (0.5, 0.1, 0.06)),
        roughness=(0.3, 0.5), choices=4, each=True,
    ),
    "envelope": Finish(
        "wood", colors=((0.76, 0.76, 0.74), (0.76, 0.76, 0.74), (0.5, 0.37, 0.22)),
        roughness=(0.7, 0.85), choices=4, each=True,
    ),
    "eraser": Finish("rubber", colors=((0.62, 0.28, 0.27), (0.7, 0.69, 0.67)), choices=2,
                     roughness=(0.7, 0.85)),
    "pad_cloth": Finish(
        "fabric", {"felt": 2, "canvas": 1}, colors=((0.03, 0.03, 0.032), (0.2, 0.2, 0.205),
                                                    (0.07, 0.1, 0.14)),
    ),
    "phone_back": Finish(
        "specular_stone", colors=((0.55, 0.56, 0.58), (0.08, 0.1, 0.14), (0.6, 0.5, 0.46)),
        roughness=(0.1, 0.3), choices=2,
    ),
    "garment": Finish(
        "fabric", {"twill": 2, "denim": 1.5, "jersey_knit": 2, "rib_knit": 1, "felt": 1,
                   "herringbone": 0.7, "corduroy": 0.5},
        colors=((0.045, 0.05, 0.065), (0.05, 0.075, 0.13), (0.2, 0.19, 0.18), (0.36, 0.31, 0.24),
                (0.1, 0.12, 0.085), (0.3, 0.06, 0.05), (0.55, 0.54, 0.5)),
        choices=6, each=True,
    ),
    "shoe_upper": Finish(
        "fabric", {"canvas": 2, "twill": 1, "jersey_knit": 1},
        colors=((0.62, 0.61, 0.58), (0.05, 0.055, 0.065), (0.06, 0.09, 0.17), (0.32, 0.32, 0.33)),
        choices=3,
    ),
    "white_sole": Finish("rubber", colors=((0.66, 0.65, 0.61),), roughness=(0.5, 0.65)),
    "shoe_leather": Finish(
        "leather", {"nappa": 2, "full_grain_leather": 2, "suede": 1},
        colors=((0.03, 0.028, 0.027), (0.16, 0.075, 0.03), (0.075, 0.035, 0.02)), choices=3,
    ),
    "bag_cloth": Finish(
        "fabric", {"canvas": 3, "linen": 1},
        colors=((0.6, 0.56, 0.46), (0.06, 0.065, 0.075), (0.12, 0.17, 0.14), (0.4, 0.16, 0.09)),
        choices=3,
    ),
    "plush": Finish(
        "fabric", {"boucle": 1}, colors=((0.36, 0.21, 0.1), (0.5, 0.39, 0.26), (0.5, 0.49, 0.47)),
        choices=2,
    ),
    "plush_pad": Finish("fabric", {"felt": 1}, colors=((0.6, 0.5, 0.37),)),
    "shirt_cloth": Finish(
        "fabric", {"canvas": 2, "linen": 1.5, "ticking": 1, "tartan": 1, "denim": 0.7},
        colors=((0.72, 0.72, 0.7), (0.45, 0.52, 0.62), (0.07, 0.08, 0.12), (0.5, 0.42, 0.33),
                (0.2, 0.26, 0.22), (0.4, 0.16, 0.14)),
        choices=6,
    ),
    "coat_cloth": Finish(
        "fabric", {"twill": 2, "denim": 1.5, "felt": 1.5, "herringbone": 1, "corduroy": 0.5},
        colors=((0.045, 0.05, 0.065), (0.05, 0.06, 0.1), (0.16, 0.155, 0.15), (0.33, 0.25, 0.15),
                (0.09, 0.11, 0.075), (0.2, 0.04, 0.035)),
        choices=4,
    ),
    **{
        f"{name}_{tone}": Finish("paint", colors=(color,), roughness=(0.5, 0.7))
        for name, colors in _PALETTES.items()
        for tone, color in zip(TONES, colors, strict=True)
    },
    "picture_ink": Finish("paint", colors=((0.03, 0.03, 0.032),), roughness=(0.6, 0.8)),
    "petal": Finish(
        "plastic", colors=((0.66, 0.12, 0.14), (0.72, 0.5, 0.06), (0.72, 0.7, 0.66),
                           (0.62, 0.3, 0.4), (0.4, 0.2, 0.48), (0.7, 0.28, 0.08)),
        roughness=(0.5, 0.65), choices=3,
    ),
    "dried_grass": Finish("wood", colors=((0.5, 0.4, 0.26), (0.36, 0.26, 0.15)),
                          roughness=(0.8, 0.95), choices=2),
    "binder": Finish(
        "paint", colors=((0.05, 0.05, 0.055), (0.05, 0.1, 0.22), (0.5, 0.5, 0.49),
                         (0.35, 0.05, 0.04), (0.07, 0.18, 0.1)),
        roughness=(0.4, 0.55), choices=4,
    ),
    "lit_digit": Finish("plastic", colors=((0.7, 0.12, 0.06),), roughness=(0.3, 0.4)),
    "cork": Finish("wood", {"birch_plywood": 1}, colors=((0.4, 0.27, 0.16),), roughness=(0.8, 0.9)),
}  # fmt: skip
