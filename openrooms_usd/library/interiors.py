"""Styles of rooms: which furniture, materials and colours go together.

A factor says how much more or less often than elsewhere something is taken; what a table does not
name has the factor 1. Colours are scene-linear Rec.709.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from openrooms_usd.description.styles import InteriorStyle
from openrooms_usd.library.assignment.rooms import Place
from openrooms_usd.library.assignment.weights import Weights, drawn
from openrooms_usd.library.furniture.joinery import Fronts
from openrooms_usd.library.shellstyles import SHELLS, ShellStyle

Color = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class Interior:
    """What rooms of one style have.

    Attributes:
        description: One sentence for people.
        furniture: Factors of the styles of furniture, by category.
        families: Factors of families of materials, wherever they are taken.
        substances: Factors of what floors and walls are made of.
        finishes: Factors of the schemes of furniture that have these finishes.
        woods: Pairs of a main and a second wood: families, with weights.
        metals: Finishes of frames, handles and lamps, with weights.
        accents: Colours of which a room has one, on few things.
        neutrals: Pairs of a light and a deeper neutral: of what is lacquered and what is woven.
        walls: Colours of painted walls.
        ceilings: Colours of painted ceilings.
        fronts: How the doors and drawers of its kitchen look, with weights.
        shell: Boards, mouldings, beams and heaters.
    """

    description: str
    furniture: Mapping[str, Weights] = field(default_factory=dict)
    families: Weights = field(default_factory=dict)
    substances: Mapping[Place, Weights] = field(default_factory=dict)
    finishes: Weights = field(default_factory=dict)
    woods: Mapping[tuple[str, str], float]
    metals: Weights
    accents: tuple[Color, ...]
    neutrals: tuple[tuple[Color, Color], ...]
    walls: tuple[Color, ...]
    ceilings: tuple[Color, ...] = ((0.8, 0.8, 0.785),)
    fronts: Mapping[Fronts, float]
    shell: ShellStyle

    def weighted(self, weights: Weights) -> Weights:
        """Weights of families times the style's factors; as they were where it likes none."""
        found = {name: weight * self.families.get(name, 1.0) for name, weight in weights.items()}
        return found if any(found.values()) else weights

    def style_of(self, category: str, styles: tuple[str, ...], rng: np.random.Generator) -> str:
        """Draw one of some styles of a category of furniture."""
        factors = self.furniture.get(category, {})
        weights = {style: factors.get(style, 1.0) for style in styles}
        return drawn(rng, weights if any(weights.values()) else dict.fromkeys(styles, 1.0))


INTERIORS: Final[Mapping[InteriorStyle, Interior]] = {
    "scandinavian": Interior(
        shell=SHELLS["scandinavian"],
        description="Pale woods, white walls, plain cloth, few muted colours.",
        furniture={
            "armchair": {"wooden": 3, "modern": 2, "bentwood": 3, "wing": 0.3},
            "basket": {"rope": 2, "woven": 3, "crate": 0.5},
            "bathtub": {"clawfoot": 0.1},
            "bed": {"platform": 3, "slatted": 3, "four_poster": 0.1},
            "bench": {"plank": 3, "slatted": 2, "chest": 0.3},
            "bookshelf": {"cubes": 3, "ladder": 2, "case": 2},
            "cabinet": {"sideboard": 3},
            "ceiling_lamp": {"pendant": 3, "globe": 2, "drum": 2, "chandelier": 0, "spots": 0.5},
            "chair": {"shell": 3, "slat": 2, "sled": 0.5, "upholstered": 0.7},
            "clock": {"round": 3, "sunburst": 0.1, "mantel": 0.1},
            "coffee_table": {"drum": 2, "shelf": 2, "chest": 0.2},
            "curtain": {"sheer": 3, "layered": 2, "roller": 2, "drapes": 1},
            "desk": {"trestle": 3, "writing": 2, "pedestal": 0.5},
            "dresser": {"double": 3, "tallboy": 2, "mirrored": 0.2},
            "faucet": {"bridge": 0.1},
            "fireplace": {"stove": 3, "breast": 1, "mantel": 0.5},
            "floor_lamp": {"tripod": 3, "drum": 2, "globe": 2, "uplight": 0.4},
            "kitchen_cabinet": {"doors": 3, "open": 2, "glass": 0.5},
            "office_chair": {"executive": 0.2},
            "picture": {"framed": 3, "canvas": 1, "triptych": 0.3},
            "plant_pot": {"leafy": 2, "palm": 1.5},
            "rug": {"fringed": 2, "round": 2, "bordered": 0.7},
            "side_table": {"tripod": 3, "disc": 2, "nightstand": 2},
            "sofa": {"modern": 3, "wooden": 2, "chaise": 2, "rolled": 0.1},
            "stool": {"tripod": 3, "turned": 0.3, "column": 0.3},
            "table": {"four_legs": 3, "trestle": 1.5, "disc": 2, "pedestal": 0.3},
            "table_lamp": {"stick": 2, "globe": 3, "urn": 0.3},
            "wardrobe": {"sliding": 2, "hinged": 2, "open": 1},
        },
        families={
            "oak_planks": 3, "whitewashed_boards": 0.5, "strip_parquet": 1, "reclaimed_planks": 0.2,
            "sapele_ribbon": 0, "walnut_veneer": 0, "damask": 0, "tartan": 0, "velvet": 0.3,
            "linen": 2, "boucle": 2, "felt": 2, "basket_weave": 1.5, "waffle_weave": 2,
            "cable_knit": 2, "embossed_wallpaper": 0, "woodchip_wallpaper": 0.3,
            "terrazzo": 0.5, "granite": 0.3, "breccia_marble": 0, "checkerboard_marble": 0.1,
            "whitewashed_brick": 1, "running_bond_brick": 0.2, "terracotta_tiles": 0.2,
            "cracked_leather": 0, "full_grain_leather": 1, "loop_carpet": 2, "shag_carpet": 1.5,
        },
        substances={"floor": {"wood": 2, "fabric": 0.4}, "wall": {"fabric": 0.2}},
        finishes={"metal": 0.6, "white": 2.0, "hide": 0.4, "lacquer": 0.8},
        woods={
            ("ash_veneer", "birch_plywood"): 2.0,
            ("quartered_oak", "ash_veneer"): 3.0,
            ("birch_plywood", "pine_staves"): 1.0,
            ("beech_staves", "birch_plywood"): 1.5,
        },
        fronts={"slab": 2, "handleless": 2, "shaker": 1},
        metals={"black": 3.0, "steel": 1.0, "brass": 1.0},
        accents=(
            (0.11, 0.17, 0.23), (0.21, 0.25, 0.18), (0.45, 0.27, 0.07), (0.42, 0.2, 0.14),
            (0.47, 0.31, 0.27),
        ),
        neutrals=(
            ((0.76, 0.75, 0.71), (0.38, 0.37, 0.35)),
            ((0.77, 0.77, 0.75), (0.25, 0.26, 0.27)),
            ((0.74, 0.72, 0.67), (0.46, 0.42, 0.36)),
        ),
        walls=((0.8, 0.795, 0.775), (0.74, 0.74, 0.72), (0.66, 0.655, 0.63), (0.5, 0.52, 0.5)),
    ),
    "mid_century": Interior(
        shell=SHELLS["mid_century"],
        description="Walnut and teak on tapered legs, brass, mustard, olive and teal.",
        furniture={
            "armchair": {"wooden": 3, "bentwood": 3, "modern": 1, "tub": 1.5, "wing": 0.3},
            "bathtub": {"clawfoot": 0.1},
            "bed": {"platform": 3, "upholstered": 2, "slatted": 1, "four_poster": 0.1},
            "bench": {"slatted": 3, "hoop": 2, "chest": 0.3},
            "bookshelf": {"ladder": 2, "cubes": 1.5},
            "cabinet": {"sideboard": 5},
            "ceiling_lamp": {"globe": 3, "cluster": 3, "pendant": 2, "chandelier": 0.3},
            "chair": {"shell": 4, "slat": 1, "upholstered": 2, "armchair": 2, "sled": 0.7},
            "clock": {"sunburst": 5},
            "coffee_table": {"hairpin": 3, "shelf": 2, "drum": 1.5, "chest": 0.2},
            "curtain": {"drapes": 2, "sheer": 2, "layered": 2},
            "desk": {"writing": 4, "pedestal": 1.5, "standing": 0.5},
            "dresser": {"double": 4, "combined": 1.5, "mirrored": 0.5},
            "faucet": {"bridge": 0.2},
            "fireplace": {"breast": 3, "mantel": 0.3},
            "floor_lamp": {"arc": 3, "tripod": 3, "globe": 2, "uplight": 0.5},
            "picture": {"framed": 2, "canvas": 2, "triptych": 1},
            "plant_pot": {"swords": 2, "palm": 2, "leafy": 1.5},
            "rug": {"round": 2, "bordered": 1.5, "fringed": 1},
            "side_table": {"tripod": 2, "disc": 2, "nightstand": 2, "bracket": 0.3},
            "sofa": {"wooden": 3, "modern": 3, "chaise": 1.5, "rolled": 0.1},
            "stool": {"tripod": 2, "padded": 2, "turned": 0.3},
            "table": {"four_legs": 3, "disc": 2, "pedestal": 2, "trestle": 0.5},
            "table_lamp": {"globe": 3, "stick": 2, "urn": 1},
            "wall_lamp": {"globe": 2, "swing": 1.5},
        },
        families={
            "walnut_veneer": 4, "sapele_ribbon": 1, "strip_parquet": 3, "herringbone_parquet": 2,
            "mosaic_parquet": 2, "cork": 2, "whitewashed_boards": 0, "reclaimed_planks": 0.1,
            "tartan": 0, "twill": 2, "boucle": 2.5, "corduroy": 1.5, "velvet": 1,
            "damask": 0, "nappa": 2, "full_grain_leather": 2,
            "cracked_leather": 0, "shag_carpet": 3, "cut_carpet": 1.5, "terrazzo": 1.5,
            "checkerboard_marble": 0.2, "embossed_wallpaper": 0.3, "woodchip_wallpaper": 0.1,
            "limewash": 0.3, "skip_trowel": 0.3, "trowelled_plaster": 1, "split_face_ledger": 2,
            "chalk_paint": 0,
        },
        substances={"floor": {"wood": 1.5, "fabric": 1}, "wall": {"fabric": 0.7}},
        finishes={"metal": 0.8, "white": 0.4, "hide": 1.2, "lacquer": 0.6, "wood": 1.5},
        woods={
            ("walnut_veneer", "walnut_veneer"): 4.0,
            ("walnut_veneer", "ash_veneer"): 1.5,
            ("sapele_ribbon", "walnut_veneer"): 1.5,
            ("quartered_oak", "walnut_veneer"): 1.0,
        },
        fronts={"slab": 3, "handleless": 1},
        metals={"brass": 3.0, "black": 2.0, "steel": 0.5},
        accents=(
            (0.48, 0.26, 0.03), (0.43, 0.13, 0.04), (0.15, 0.16, 0.05), (0.03, 0.14, 0.16),
            (0.06, 0.12, 0.09),
        ),
        neutrals=(
            ((0.7, 0.66, 0.57), (0.3, 0.26, 0.2)),
            ((0.73, 0.71, 0.66), (0.2, 0.2, 0.19)),
            ((0.68, 0.66, 0.6), (0.38, 0.34, 0.27)),
        ),
        walls=(
            (0.76, 0.74, 0.69), (0.72, 0.69, 0.62), (0.55, 0.52, 0.44), (0.27, 0.3, 0.22),
            (0.18, 0.27, 0.28),
        ),
    ),
    "industrial": Interior(
        shell=SHELLS["industrial"],
        description="Steel frames, bare bulbs, brick, concrete, worn wood and leather.",
        furniture={
            "armchair": {"modern": 2, "tub": 2, "bentwood": 0.5, "wing": 0.5},
            "basket": {"crate": 3},
            "bed": {"platform": 3, "slatted": 2, "four_poster": 0.5},
            "bench": {"plank": 3, "hoop": 2},
            "bookshelf": {"ladder": 4, "case": 1},
            "cabinet": {"doors": 2, "drawers": 2, "shelves": 2},
            "ceiling_lamp": {"pendant": 3, "cluster": 3, "spots": 3, "drum": 0.3, "chandelier": 0},
            "chair": {"sled": 4, "slat": 1, "shell": 1, "upholstered": 0.5},
            "clock": {"round": 3, "sunburst": 0.1, "mantel": 0.1},
            "coffee_table": {"hairpin": 3, "sled": 4, "chest": 1, "drum": 0.5},
            "curtain": {"roller": 3, "venetian": 3, "drapes": 1, "layered": 0.3},
            "desk": {"framed": 4, "trestle": 2, "standing": 1.5, "pedestal": 0.5},
            "faucet": {"bridge": 1.5},
            "fireplace": {"stove": 4, "mantel": 0.1},
            "floor_lamp": {"tripod": 3, "arc": 2, "uplight": 1, "drum": 0.4},
            "kitchen_cabinet": {"open": 3, "doors": 2, "glass": 0.5},
            "picture": {"framed": 2, "canvas": 2, "triptych": 1},
            "rug": {"fringed": 1.5, "bordered": 0.7, "round": 0.3},
            "side_table": {"disc": 2, "bracket": 2, "block": 2, "tripod": 0.5},
            "sofa": {"modern": 3, "chaise": 2, "rolled": 1, "wooden": 0.5},
            "stool": {"column": 3, "square": 2, "turned": 0.2},
            "table": {"trestle": 2, "four_legs": 2, "shelf": 1.5, "pedestal": 0.3},
            "table_lamp": {"task": 4, "stick": 1, "urn": 0.2},
            "trash_bin": {"wire": 3, "pedal": 2},
            "wall_lamp": {"swing": 4},
            "wardrobe": {"open": 3},
        },
        families={
            "cast_concrete": 4, "polished_concrete": 6, "board_formed_concrete": 3,
            "running_bond_brick": 6, "whitewashed_brick": 2, "reclaimed_planks": 5,
            "oak_planks": 1.5, "strip_parquet": 0.5, "herringbone_parquet": 0.3,
            "chevron_parquet": 0.1, "birch_plywood": 0.7, "damask": 0,
            "tartan": 0.2, "velvet": 0.3, "canvas": 3, "twill": 2, "felt": 2,
            "full_grain_leather": 4, "cracked_leather": 1.0, "nappa": 0.5, "embossed_wallpaper": 0,
            "woodchip_wallpaper": 0, "venetian_plaster": 0.5, "subway_tiles": 3,
            "carrara_marble": 0.2, "breccia_marble": 0, "checkerboard_marble": 0.1,
            "high_gloss_lacquer": 0.1, "powder_coat": 3, "shag_carpet": 0.3,
        },
        substances={"floor": {"fabric": 0.1, "rough_stone": 4, "specular_stone": 3},
                    "wall": {"rough_stone": 8, "fabric": 0}},
        finishes={"metal": 4.0, "black": 3.0, "white": 0.3, "hide": 2.5, "lacquer": 0.6},
        woods={
            ("quartered_oak", "pine_staves"): 2.0,
            ("brushed_larch", "quartered_oak"): 1.5,
            ("walnut_veneer", "quartered_oak"): 1.5,
            ("butcher_block", "birch_plywood"): 1.0,
        },
        fronts={"slab": 3, "handleless": 2},
        metals={"black": 5.0, "steel": 2.0},
        accents=((0.3, 0.09, 0.035), (0.07, 0.1, 0.12), (0.11, 0.12, 0.07), (0.38, 0.22, 0.05)),
        neutrals=(
            ((0.58, 0.57, 0.55), (0.11, 0.11, 0.112)),
            ((0.5, 0.48, 0.45), (0.2, 0.185, 0.165)),
            ((0.66, 0.65, 0.63), (0.15, 0.155, 0.16)),
        ),
        walls=((0.74, 0.735, 0.72), (0.6, 0.6, 0.59), (0.36, 0.36, 0.355), (0.14, 0.145, 0.15)),
    ),
    "rustic": Interior(
        shell=SHELLS["rustic"],
        description="Solid pine and oak, lime plaster, linen, wool and iron.",
        furniture={
            "armchair": {"wooden": 2, "wing": 1.5, "bentwood": 1, "modern": 0.5},
            "basket": {"woven": 3, "rope": 2, "crate": 2},
            "bathtub": {"clawfoot": 3, "freestanding": 1.5},
            "bed": {"slatted": 3, "four_poster": 1.5, "platform": 1, "upholstered": 0.3},
            "bench": {"plank": 3, "chest": 2, "hoop": 0.2, "padded": 0.5},
            "bookshelf": {"case": 3, "over_doors": 2, "cubes": 0.5, "ladder": 0.7},
            "cabinet": {"doors": 2, "sideboard": 2},
            "ceiling_lamp": {"pendant": 3, "chandelier": 1.5, "drum": 1.5, "spots": 0.2},
            "chair": {"slat": 5, "armchair": 1, "shell": 0.1, "sled": 0.1},
            "clock": {"round": 2, "mantel": 1.5, "sunburst": 0.1},
            "coffee_table": {"chest": 3, "shelf": 2, "hairpin": 0.3, "sled": 0.3},
            "curtain": {"drapes": 3, "sheer": 1, "layered": 1, "roller": 0.5, "venetian": 0.3},
            "desk": {"writing": 2, "trestle": 2, "pedestal": 1.5, "standing": 0.1, "framed": 0.3},
            "door": {"panelled": 4, "flush": 0.3},
            "faucet": {"bridge": 4, "arc": 1},
            "fireplace": {"breast": 2, "stove": 3, "mantel": 1},
            "floor_lamp": {"tripod": 2, "drum": 3, "arc": 0.3, "globe": 0.5},
            "kitchen_cabinet": {"doors": 2, "open": 2, "glass": 1.5, "flaps": 0.1},
            "picture": {"framed": 3, "triptych": 0.2},
            "rug": {"fringed": 3, "bordered": 1.5, "runner": 1},
            "side_table": {"nightstand": 2, "tripod": 2, "block": 1.5, "disc": 0.7},
            "sofa": {"rolled": 3, "wooden": 2, "modern": 0.7, "chaise": 0.5},
            "stool": {"tripod": 3, "turned": 3, "column": 0.1, "padded": 0.5},
            "table": {"trestle": 4, "four_legs": 2, "pedestal": 0.5, "disc": 0.3},
            "table_lamp": {"urn": 3, "stick": 1, "task": 0.3, "globe": 0.5},
            "wardrobe": {"hinged": 4, "sliding": 0.1},
            "window": {"grid": 3, "casement": 2, "fixed": 0.3, "sliding": 0.2},
        },
        families={
            "pine_staves": 3, "knotty_pine": 2, "brushed_larch": 2, "reclaimed_planks": 4,
            "oak_planks": 2, "whitewashed_boards": 1, "mosaic_parquet": 0.2, "bamboo_strips": 0,
            "chevron_parquet": 0.1, "sapele_ribbon": 0, "curly_maple": 0,
            "terracotta_tiles": 4, "slate": 2, "quarry_hexagons": 2, "travertine": 1.5,
            "porcelain_tiles": 0.5, "terrazzo": 0, "granite": 0.3, "polished_concrete": 0.2,
            "limewash": 4, "trowelled_plaster": 3, "fieldstone_wall": 2, "embossed_wallpaper": 0.3,
            "woodchip_wallpaper": 0.2, "linen": 3, "canvas": 2, "tartan": 0.7, "herringbone": 1.5,
            "velvet": 0.3, "satin": 0, "cable_knit": 2, "cracked_leather": 0.7,
            "full_grain_leather": 2, "nappa": 0.4, "sisal": 2, "shag_carpet": 0.3,
            "high_gloss_lacquer": 0, "chalk_paint": 4,
        },
        substances={"floor": {"fabric": 0.1, "rough_stone": 3, "specular_stone": 0.4},
                    "wall": {"rough_stone": 5, "fabric": 0.1}},
        finishes={"metal": 0.5, "white": 0.5, "hide": 0.8, "lacquer": 0.7, "wood": 1.5},
        woods={
            ("pine_staves", "quartered_oak"): 2.0,
            ("quartered_oak", "pine_staves"): 2.0,
            ("brushed_larch", "pine_staves"): 1.0,
            ("knotty_pine", "quartered_oak"): 1.0,
        },
        fronts={"shaker": 4, "slab": 1},
        metals={"black": 4.0, "brass": 1.0},
        accents=((0.32, 0.07, 0.04), (0.13, 0.17, 0.1), (0.1, 0.13, 0.19), (0.42, 0.23, 0.08)),
        neutrals=(
            ((0.66, 0.61, 0.52), (0.33, 0.28, 0.21)),
            ((0.7, 0.67, 0.6), (0.27, 0.25, 0.2)),
            ((0.62, 0.58, 0.5), (0.4, 0.35, 0.27)),
        ),
        walls=((0.75, 0.72, 0.65), (0.68, 0.62, 0.52), (0.6, 0.5, 0.38), (0.42, 0.43, 0.35)),
        ceilings=((0.77, 0.75, 0.7),),
    ),
    "traditional": Interior(
        shell=SHELLS["traditional"],
        description="Turned and panelled wood, brass, patterned carpets, deep colours.",
        furniture={
            "armchair": {"wing": 4, "tub": 1.5, "wooden": 0.7, "modern": 0.4, "bentwood": 0.2},
            "bathtub": {"clawfoot": 3},
            "bed": {"upholstered": 2.5, "four_poster": 2, "slatted": 1, "platform": 0.5},
            "bench": {"padded": 3, "chest": 2, "plank": 0.5, "hoop": 0.2},
            "bookshelf": {"case": 3, "over_doors": 3, "cubes": 0.2, "ladder": 0.2},
            "cabinet": {"doors": 2, "sideboard": 2, "drawers": 1.5},
            "ceiling_lamp": {"chandelier": 4, "drum": 2, "flush": 1, "globe": 0.7, "spots": 0.1,
                             "cluster": 0.1},
            "chair": {"upholstered": 4, "slat": 2, "armchair": 1, "shell": 0.1, "sled": 0.1},
            "clock": {"mantel": 3, "round": 2, "sunburst": 0.5},
            "coffee_table": {"shelf": 3, "chest": 1, "hairpin": 0.1, "sled": 0.1},
            "curtain": {"drapes": 4, "layered": 3, "roller": 0.3, "venetian": 0.2},
            "desk": {"pedestal": 4, "writing": 2, "standing": 0.1, "trestle": 0.2, "framed": 0.2},
            "door": {"panelled": 5, "flush": 0.2, "glazed": 1},
            "dresser": {"mirrored": 2, "tallboy": 2, "combined": 1.5},
            "faucet": {"bridge": 4, "arc": 1, "mixer": 0.7},
            "fireplace": {"mantel": 5, "stove": 0.3},
            "floor_lamp": {"drum": 4, "uplight": 1, "arc": 0.1, "tripod": 0.4, "globe": 0.4},
            "jar": {"ginger": 3},
            "kitchen_cabinet": {"glass": 2.5, "doors": 2, "open": 0.5, "flaps": 0.1},
            "office_chair": {"executive": 3},
            "picture": {"framed": 5, "canvas": 0.7, "triptych": 0.1},
            "rug": {"bordered": 4, "fringed": 2, "round": 0.5},
            "side_table": {"tripod": 2, "nightstand": 2, "block": 0.2, "disc": 0.7},
            "sofa": {"rolled": 5, "wooden": 1, "modern": 0.5, "chaise": 0.5},
            "stool": {"padded": 2, "turned": 3, "column": 0.1, "square": 0.7},
            "table": {"pedestal": 4, "four_legs": 2, "trestle": 0.3, "disc": 0.4},
            "table_lamp": {"urn": 5, "stick": 1, "task": 0.5, "globe": 0.4},
            "wall_lamp": {"sconce": 3, "globe": 0.7},
            "wardrobe": {"hinged": 4, "sliding": 0.2, "open": 0.3},
            "window": {"grid": 3, "casement": 2, "fixed": 0.5},
        },
        families={
            "sapele_ribbon": 1, "walnut_veneer": 3, "herringbone_parquet": 4, "oak_planks": 1.5,
            "chevron_parquet": 2, "mosaic_parquet": 1, "whitewashed_boards": 0.2,
            "reclaimed_planks": 0.1, "bamboo_strips": 0, "cork": 0.2,
            "birch_plywood": 0.1, "velvet": 3, "damask": 2, "repp": 2, "herringbone": 1.5,
            "tartan": 0.5, "felt": 0.3, "boucle": 0.5, "basket_weave": 0.7,
            "nappa": 1, "full_grain_leather": 2, "stitched_leather": 1.5, "cut_carpet": 3,
            "loop_carpet": 1, "shag_carpet": 0.2, "carrara_marble": 2, "checkerboard_marble": 1.5,
            "polished_concrete": 0.1, "cast_concrete": 0.1, "terrazzo": 0.3,
            "embossed_wallpaper": 2, "venetian_plaster": 1.5, "limewash": 0.4, "skip_trowel": 0.4,
            "woodchip_wallpaper": 0.1, "running_bond_brick": 0.3, "chalk_paint": 0.5,
        },
        substances={"floor": {"wood": 1.5}, "wall": {"fabric": 2, "rough_stone": 0.3}},
        finishes={"metal": 0.4, "white": 0.7, "hide": 1.2, "lacquer": 0.6, "wood": 2.0},
        woods={
            ("walnut_veneer", "quartered_oak"): 2.0,
            ("sapele_ribbon", "walnut_veneer"): 1.5,
            ("quartered_oak", "walnut_veneer"): 2.0,
        },
        fronts={"shaker": 5, "slab": 0.5},
        metals={"brass": 5.0, "steel": 1.0, "black": 1.0},
        accents=(
            (0.2, 0.03, 0.03), (0.035, 0.06, 0.14), (0.04, 0.1, 0.055), (0.37, 0.22, 0.06),
            (0.17, 0.06, 0.09),
        ),
        neutrals=(
            ((0.72, 0.69, 0.61), (0.37, 0.32, 0.24)),
            ((0.74, 0.72, 0.67), (0.25, 0.24, 0.23)),
            ((0.69, 0.65, 0.56), (0.3, 0.23, 0.17)),
        ),
        walls=(
            (0.74, 0.71, 0.63), (0.6, 0.6, 0.54), (0.44, 0.5, 0.5), (0.3, 0.37, 0.31),
            (0.5, 0.38, 0.3),
        ),
    ),
}  # fmt: skip
"""Every style by its name."""
