"""How the parts of things are made: solid, hollow with walls of some thickness, or filled.

What is seen of a part is its surface. A table leg is wood all through, a toilet is a hollow of
china, and a sofa's arm is air, foam and laths under cloth. Densities of fillings are those of the
whole body, what is inside it and round it included. Where the library models both sides of one
sheet of metal, each side has half of its thickness.

Sources, by the keys that rows give as their reason:

- ``board``: particleboard of 600 to 680 kg/m3 in boards of 16 to 19 mm (EN 312), of which painted
  furniture is mostly made; MDF has 700 to 800 (EN 622-5).
- ``foam``: polyurethane foam has 22 to 45 kg/m3 in cushions and mattresses (makers' guides), with
  cover and interlining 35 to 60; pocket springs make a mattress 50 to 90.
- ``sheet``: household and office steel is drawn from sheets of 0.5 to 0.9 mm, tubes of 1 to 2 mm.
- ``china``: vitreous china has 2,300 to 2,400 kg/m3 and walls of 8 to 12 mm.
- ``weight``: the density is chosen so that the whole weighs what such products weigh, as the
  ``mass_range`` of the category says: motors, transformers, batteries and weights are not modelled.
- ``common``: what such parts usually measure.
"""

from dataclasses import dataclass
from typing import Final, Literal

from openrooms_usd.description.substances import Substance

STEEL: Final = 7850.0
BRASS: Final = 8500.0
ALUMINIUM: Final = 2700.0
CHINA: Final = 2400.0
BOARD: Final = 650.0

# The thickness of an open surface where a solid or filled body was expected, metres.
_PANEL: Final = 0.01
_PAD: Final = 0.05

ANY: Final = "*"


@dataclass(frozen=True)
class Construction:
    """How a part is made.

    Attributes:
        kind: ``solid`` of its material, a ``shell`` with nothing inside, or ``filled`` with more or
            less of other things.
        density: kg/m3; None for that of its own material.
        wall: Metres: of a shell the thickness of its wall, of others that of a surface which
            encloses nothing.
    """

    kind: Literal["solid", "shell", "filled"]
    density: float | None = None
    wall: float = _PANEL


@dataclass(frozen=True)
class Row:
    """How parts of some kinds are made.

    Attributes:
        parts: Their kinds; `ANY` for all others, as those of models that name none.
        construction: How they are made.
        reason: A key of the module's sources.
        substances: Only where they show one of these; empty for all.
    """

    parts: tuple[str, ...]
    construction: Construction
    reason: str
    substances: tuple[Substance, ...] = ()


def solid(density: float | None = None) -> Construction:
    """A body of its material all through, or of some kg/m3."""
    return Construction("solid", density)


def walls(millimetres: float, density: float | None = None) -> Construction:
    """A hollow with walls of its material, or of some kg/m3."""
    return Construction("shell", density, millimetres / 1000.0)


def filled(density: float) -> Construction:
    """A body with more or less of other things in it, kg/m3."""
    return Construction("filled", density, _PAD)


def row(parts: str, made: Construction, reason: str, *substances: Substance) -> Row:
    """How parts are made whose kinds are apart by blanks."""
    return Row(tuple(parts.split()), made, reason, substances)


# What several categories share.
SEAT_ROWS: Final = (
    row(f"frame back arm headboard {ANY}", filled(90), "weight", "fabric", "leather"),
)
STORAGE_ROWS: Final = (row("base", filled(150), "common", "wood", "paint"),)
TABLE_ROWS: Final = (
    row("door drawer_front drawer_box", walls(0.45), "sheet", "metal"),
    row("frame base", walls(0.8), "sheet", "metal"),
)
COOKER_ROWS: Final = (
    row("base", filled(150), "weight"),
    row("container", filled(160), "weight"),
    row("door", filled(600), "weight"),
    row("burner grate", solid(7200), "common"),
)
MACHINE_ROWS: Final = (
    row("glass screen", walls(5, 2500), "common"),
    row("rack handle knob button", walls(1.5), "sheet", "metal", "plastic"),
    row(
        "container cooktop door drawer_box drawer_front drum frame lid panel top",
        walls(0.4, STEEL),
        "sheet",
    ),
)
COOKER_REST_ROWS: Final = (row(ANY, filled(150), "weight"),)
LAMP_ROWS: Final = (
    row("leg", walls(1.5, STEEL), "sheet", "metal", "paint"),
    row("light_bulb", walls(1.5, 2500), "common"),
    row("lamp_shade", filled(600), "common"),
    row(ANY, walls(1, STEEL), "sheet", "metal", "paint"),
)

# Of anything, where its category says nothing of a part. The first row that fits counts, among
# those for the most special name of a part; the rows of a category stand before these.
GENERAL: Final[tuple[Row, ...]] = (
    # Parts of anything.
    row("mattress", filled(60), "foam"),
    row("pillow", filled(40), "foam"),
    row("seat_cushion back_cushion cushion headboard_pad", filled(45), "foam", "fabric", "leather"),
    row("book pages", solid(700), "common"),
    row("fruit", solid(900), "common"),
    row("tabletop countertop", solid(), "common", "wood", "specular_stone", "rough_stone"),
    row(
        "leg foot post rail slat seat back arm shelf step frame door drawer_front drawer_box "
        "lid bar_stretcher footboard headboard",
        solid(),
        "common",
        "wood",
    ),
    row("mirror", walls(2.5, 2500), "common"),
    row("pane", solid(2500), "common"),
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
)
