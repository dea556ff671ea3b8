"""The names of the procedural families, by substance: what a description may ask for.

The library has the recipes; a test keeps both equal.
"""

from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from openrooms_usd.description.substances import Substance

_NAMES: Final[dict[Substance, str]] = {
    "fabric": """
        basket_weave boucle cable_knit canvas corduroy cut_carpet damask denim felt herringbone
        houndstooth jersey_knit linen loop_carpet needlefelt_carpet repp rib_knit satin seersucker
        shag_carpet sisal tartan ticking twill velvet waffle_weave
    """,
    "leather": """
        cracked_leather crocodile_leather full_grain_leather lizard_leather nappa nubuck
        ostrich_leather patent_leather pebbled_leather perforated_leather quilted_leather saffiano
        shagreen snakeskin stitched_leather suede woven_leather
    """,
    "metal": """
        anodised_aluminium brushed_metal cast_iron corrugated_sheet crumpled_foil engine_turned
        galvanised_steel hammered_metal knurled_metal orbital_sanded patina_copper
        perforated_sheet polished_metal pressed_tin rusted_iron sandblasted_metal scratched_steel
        tarnished_brass tread_plate wire_mesh
    """,
    "paint": """
        blackboard_paint brushed_gloss chalk_paint combed_plaster crackled_paint dragged_glaze
        embossed_wallpaper flaking_paint hammered_enamel high_gloss_lacquer knockdown limewash
        metal_flake orange_peel popcorn_ceiling powder_coat rag_rolled roller_matt
        scratched_render skip_trowel speckled_coating sponged_distemper sprayed_satin
        venetian_plaster woodchip_wallpaper wrinkle_finish
    """,
    "plastic": """
        anti_slip_sheet carbon_look chip_vinyl coated_fabric foam_beads frosted_acrylic
        glitter_plastic hairline_plastic leather_grain_plastic linoleum moulded_plastic
        perforated_plastic printed_layers prismatic_sheet ribbed_plastic spark_eroded_plastic
        studded_vinyl twin_wall_sheet vinyl_composition_tiles vinyl_planks wood_laminate
        woven_resin
    """,
    "rough_stone": """
        ashlar basalt board_formed_concrete cast_concrete cobblestone exposed_aggregate
        fieldstone_wall quarry_hexagons running_bond_brick sandstone shell_limestone slate
        split_face_ledger stack_bond_brick stucco terracotta_tiles travertine trowelled_plaster
        whitewashed_brick
    """,
    "rubber": """
        bubble_mat coin_rubber corrugated_rubber crosshatch_rubber crumb_rubber
        diamond_tread_rubber eva_foam five_bar_rubber honeycomb_mat latex marbled_rubber
        pebbled_rubber ribbed_rubber ring_mat smooth_rubber speckled_rubber sponge tyre_tread
    """,
    "specular_stone": """
        agate banded_onyx black_galaxy_granite breccia_marble carrara_marble checkerboard_marble
        crackle_glaze fish_scale_tiles granite hexagon_mosaic penny_mosaic polished_concrete
        porcelain_tiles quartz_worktop subway_tiles terrazzo zellige
    """,
    "wood": """
        ash_veneer bamboo_strips beech_staves birch_plywood birdseye_maple brushed_larch
        butcher_block charred_cedar chevron_parquet chipboard cork curly_maple end_grain_blocks
        fibreboard herringbone_parquet knotty_pine mosaic_parquet oak_planks oak_slats pine_staves
        quartered_oak reclaimed_planks sapele_ribbon strand_board strip_parquet walnut_burl
        walnut_veneer whitewashed_boards zebrano
    """,
}

FAMILIES: Final = {substance: tuple(names.split()) for substance, names in _NAMES.items()}

if TYPE_CHECKING:
    Family: TypeAlias = str
    FamilyName: TypeAlias = str
else:
    Family = Literal[tuple(name for names in FAMILIES.values() for name in names)]
    # A substance stands for any of its families that fits.
    FamilyName = Literal[Substance, Family]
