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
- ``weight``: the density is chosen so that the whole weighs what such products weigh (the ranges of
  tests/library/test_construction.py): motors, transformers, batteries and weights are not modelled.
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
        categories: Of what they are part; `ANY` for all others.
        parts: Their kinds; `ANY` for all others, as those of models that name none.
        construction: How they are made.
        reason: A key of the module's sources.
        substances: Only where they show one of these; empty for all.
    """

    categories: tuple[str, ...]
    parts: tuple[str, ...]
    construction: Construction
    reason: str
    substances: tuple[Substance, ...] = ()


def _solid(density: float | None = None) -> Construction:
    return Construction("solid", density)


def _walls(millimetres: float, density: float | None = None) -> Construction:
    return Construction("shell", density, millimetres / 1000.0)


def _filled(density: float) -> Construction:
    return Construction("filled", density, _PAD)


def _row(
    categories: str, parts: str, made: Construction, reason: str, *substances: Substance
) -> Row:
    return Row(tuple(categories.split()), tuple(parts.split()), made, reason, substances)


_TABLES: Final = "desk table coffee_table side_table"
_STORAGE: Final = "cabinet dresser bookshelf shelf wardrobe kitchen_cabinet counter desk storage"
_SEATS: Final = "sofa armchair chair bench stool bed"
_LAMPS: Final = "floor_lamp table_lamp ceiling_lamp wall_lamp lamp"
_COOKERS: Final = "stove oven"
_MACHINES: Final = "refrigerator stove oven dishwasher washing_machine microwave"

# The first row that fits counts, among those for the most special name of a part; rows for a
# category stand before rows for all.
ROWS: Final[tuple[Row, ...]] = (
    # Seats and beds.
    _row("bed", "frame headboard footboard", _walls(12), "board", "wood", "paint"),
    _row("bed", "base", _walls(5), "common"),
    _row("bed", "blanket sheet", _filled(45), "foam"),
    _row("office_chair", "seat_cushion seat", _filled(150), "weight"),
    _row("office_chair", "back_cushion", _filled(60), "foam"),
    _row("office_chair", "leg", _walls(4, ALUMINIUM), "common"),
    _row("office_chair", "mechanism", _walls(4, STEEL), "weight"),
    _row("office_chair", "column back_support", _walls(3, STEEL), "common"),
    _row("office_chair", "arm_support", _walls(2.5, STEEL), "common"),
    _row("office_chair", "back back_frame arm", _walls(3, 1100), "common"),
    _row("office_chair", ANY, _filled(110), "weight"),
    _row("stool", "seat_cushion", _filled(100), "foam"),
    _row("stool", "cushion", _filled(90), "weight"),
    _row("stool", "base", _walls(2.5, STEEL), "common", "metal", "paint"),
    _row(_SEATS, f"frame back arm headboard {ANY}", _filled(90), "weight", "fabric", "leather"),
    # Storage and tables.
    _row(_STORAGE, "base", _filled(150), "common", "wood", "paint"),
    _row("file_cabinet", "frame base door drawer_front drawer_box shelf", _walls(0.45, STEEL),
         "sheet"),
    _row("file_cabinet", "handle", _walls(1.5), "sheet", "metal", "paint"),
    _row("file_cabinet", ANY, _filled(115), "weight"),
    _row(_TABLES, "door drawer_front drawer_box", _walls(0.45), "sheet", "metal"),
    _row(_TABLES, "frame base", _walls(0.8), "sheet", "metal"),
    _row("pool_table", "tabletop", _solid(2700), "common"),  # slate under the felt
    _row("pool_table", "frame leg base", _walls(20), "board", "wood", "paint"),
    _row("pool_table", "cushion", _solid(1000), "common"),
    _row("pool_table", "ball cue_ball", _solid(1750), "common"),
    _row("pool_table", ANY, _filled(600), "weight", "wood", "paint", "fabric"),
    # Appliances.
    _row("refrigerator", "frame", _walls(0.3, STEEL), "sheet"),
    _row("refrigerator", "container", _filled(70), "weight"),
    _row("refrigerator", "door drawer_front", _filled(130), "weight"),
    _row("refrigerator", "shelf tray drawer_box", _walls(2.5), "common", "plastic"),
    _row("refrigerator", "base", _filled(1200), "weight"),
    _row("washing_machine", "drum", _filled(8000), "weight"),
    _row("washing_machine", "top", _filled(2000), "weight"),
    _row("dishwasher", "base", _filled(400), "weight"),
    _row("microwave", "panel", _filled(4000), "weight"),
    _row("microwave", "tray", _solid(2500), "common"),
    _row(_COOKERS, "base", _filled(150), "weight"),
    _row(_COOKERS, "container", _filled(160), "weight"),
    _row(_COOKERS, "door", _filled(600), "weight"),
    _row(_COOKERS, "burner grate", _solid(7200), "common"),
    _row(_MACHINES, "glass screen", _walls(5, 2500), "common"),
    _row(_MACHINES, "rack handle knob button", _walls(1.5), "sheet", "metal", "plastic"),
    _row(_MACHINES, "container cooktop door drawer_box drawer_front drum frame lid panel top",
         _walls(0.4, STEEL), "sheet"),
    _row("refrigerator", ANY, _filled(80), "weight"),
    _row("washing_machine", ANY, _filled(215), "weight"),
    _row("dishwasher", ANY, _filled(130), "weight"),
    _row("microwave", ANY, _filled(220), "weight"),
    _row(_COOKERS, ANY, _filled(150), "weight"),
    # What has electronics in it.
    _row("television", ANY, _filled(350), "weight"),
    _row("television monitor laptop", "screen", _solid(2500), "common"),
    _row("monitor", ANY, _filled(300), "weight"),
    _row("monitor", "stand base foot", _filled(3000), "weight"),
    _row("laptop", "lid", _filled(600), "weight"),
    _row("laptop", ANY, _filled(1050), "weight"),
    _row("keyboard", ANY, _filled(500), "weight"),
    _row("printer", "paper", _solid(750), "common"),
    _row("printer", ANY, _filled(330), "weight"),
    _row("speaker", "grille", _filled(350), "weight"),
    _row("speaker", ANY, _filled(350), "weight"),
    _row("speaker", "driver", _filled(4000), "weight"),
    _row("telephone", ANY, _filled(400), "weight"),
    _row("clock", ANY, _filled(500), "weight"),
    # Lamps: a base keeps a lamp upright.
    _row("floor_lamp", "base", _filled(4000), "weight"),
    _row("table_lamp", "base", _walls(3, STEEL), "weight", "metal", "paint"),
    _row(_LAMPS, "leg", _walls(1.5, STEEL), "sheet", "metal", "paint"),
    _row(_LAMPS, "light_bulb", _walls(1.5, 2500), "common"),
    _row(_LAMPS, "lamp_shade", _filled(600), "common"),
    _row(_LAMPS, ANY, _walls(1, STEEL), "sheet", "metal", "paint"),
    # Baths and kitchens.
    _row("toilet", "seat lid", _filled(900), "weight"),
    _row("bathtub", f"container {ANY}", _walls(5, 1200), "common", "specular_stone"),  # acrylic
    _row("toilet sink", ANY, _walls(10, CHINA), "china", "specular_stone"),
    _row("sink", "bowl", _walls(0.5, STEEL), "sheet"),
    _row("faucet", ANY, _walls(3, BRASS), "common"),
    _row("sink", "body spout switch", _walls(3, BRASS), "common"),
    # Small things.
    _row("trash_bin", "bag", _walls(0.05, 950), "common"),
    _row("trash_bin", ANY, _walls(0.4, STEEL), "sheet", "metal", "paint"),
    _row("basket", ANY, _filled(250), "weight", "fabric"),
    _row("bottle jar bowl", "container", _walls(3), "common", "specular_stone"),
    _row("bottle", "container", _walls(0.6), "sheet", "metal"),
    _row("jar", "lid", _walls(0.4), "sheet", "metal"),
    _row("plant_pot", f"pot {ANY}", _filled(900), "weight"),
    _row("plant_pot", "soil", _solid(1200), "common"),
    _row("plant_pot", "plant leaf stem", _solid(800), "common"),
    _row("picture", "canvas", _filled(200), "common"),
    _row("whiteboard", ANY, _filled(800), "weight"),
    _row("whiteboard", "stand", _walls(1.5, STEEL), "sheet"),
    _row("whiteboard", "frame tray bracket stud", _walls(1.5, ALUMINIUM), "common"),
    _row("curtain shower_curtain", "sheer", _filled(60), "common"),
    _row("curtain shower_curtain", f"curtain cord {ANY}", _filled(80), "common", "fabric"),
    _row("curtain blinds", "slat", _filled(400), "common"),
    _row("rug floor_mat", ANY, _filled(220), "common"),
    # A leaf is a honeycomb between two boards.
    _row("door", "frame", _solid(), "common"),
    _row("door", f"door leaf panel {ANY}", _filled(350), "weight", "wood", "paint"),
    _row("box", ANY, _filled(100), "weight"),  # a carton with light things in it
    _row("books book paper", ANY, _filled(700), "common"),
    _row("clothes towel", ANY, _filled(150), "common"),
    _row("bag cap", ANY, _filled(100), "common"),
    _row("can", ANY, _walls(0.2), "sheet"),
    _row("bicycle", ANY, _walls(1.0), "sheet", "metal", "paint"),
    _row("guitar", ANY, _walls(2.5, 500), "common"),
    _row("piano", ANY, _filled(200), "weight"),
    # Parts of anything.
    _row(ANY, "mattress", _filled(60), "foam"),
    _row(ANY, "pillow", _filled(40), "foam"),
    _row(ANY, "seat_cushion back_cushion cushion headboard_pad", _filled(45), "foam",
         "fabric", "leather"),
    _row(ANY, "book pages", _solid(700), "common"),
    _row(ANY, "fruit", _solid(900), "common"),
    _row(ANY, "tabletop countertop", _solid(), "common", "wood", "specular_stone", "rough_stone"),
    _row(ANY, "leg foot post rail slat seat back arm shelf step frame door drawer_front drawer_box "
         "lid bar_stretcher footboard headboard", _solid(), "common", "wood"),
    _row(ANY, "mirror", _walls(2.5, 2500), "common"),
    _row(ANY, "wheel caster", _solid(), "common"),
    _row(ANY, "label mat", _solid(), "common"),
    # Anything, by what it shows.
    _row(ANY, ANY, _walls(18), "board", "wood"),
    _row(ANY, ANY, _walls(18, BOARD), "board", "paint"),
    _row(ANY, ANY, _walls(1.5), "sheet", "metal"),
    _row(ANY, ANY, _walls(2.5), "common", "plastic"),
    _row(ANY, ANY, _walls(4), "common", "rubber"),
    _row(ANY, ANY, _walls(6), "common", "specular_stone"),
    _row(ANY, ANY, _walls(20), "common", "rough_stone"),
    _row(ANY, ANY, _filled(45), "foam", "fabric"),
    _row(ANY, ANY, _filled(60), "foam", "leather"),
    _row(ANY, ANY, _walls(18, BOARD), "board"),
)  # fmt: skip
