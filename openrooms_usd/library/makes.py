"""How the parts of anything are made, where its category says nothing of them."""

from typing import Final

from openrooms_usd.categories.makes import ANY, BOARD, Row, filled, row, solid, walls

# The first row that fits counts, among those for the most special name of a part; the rows of a
# category stand before these.
GENERAL: Final[tuple[Row, ...]] = (
    # Parts of anything.
    row("mattress", filled(60), "foam"),
    row("pillow", filled(40), "foam"),
    row("seat_cushion back_cushion cushion headboard_pad", filled(45), "foam",
         "fabric", "leather"),
    row("book pages", solid(700), "common"),
    row("fruit", solid(900), "common"),
    row("tabletop countertop", solid(), "common", "wood", "specular_stone", "rough_stone"),
    row("leg foot post rail slat seat back arm shelf step frame door drawer_front drawer_box "
         "lid bar_stretcher footboard headboard", solid(), "common", "wood"),
    row("mirror", walls(2.5, 2500), "common"),
    row("wheel caster", solid(), "common"),
    row("label mat", solid(), "common"),
    # Anything, by what it shows.
    row(ANY, walls(18), "board", "wood"),
    row(ANY, walls(18, BOARD), "board", "paint"),
    row(ANY, walls(1.5), "sheet", "metal"),
    row(ANY, walls(2.5), "common", "plastic"),
    row(ANY, walls(4), "common", "rubber"),
    row(ANY, walls(6), "common", "specular_stone"),
    row(ANY, walls(20), "common", "rough_stone"),
    row(ANY, filled(45), "foam", "fabric"),
    row(ANY, filled(60), "foam", "leather"),
    row(ANY, walls(18, BOARD), "board"),
)  # fmt: skip
