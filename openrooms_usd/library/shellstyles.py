"""What the shell of a room has by style: boards, mouldings, beams, heaters, walls that differ.

Heights are those of trade: skirting of 60 to 150 mm, architraves of 58 to 90 mm, coving of 60 to
127 mm; nothing that stands on the floor keeps more than 15 mm from walls, so skirting is thinner.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from openrooms_usd.description.styles import InteriorStyle
from openrooms_usd.library.assignment.weights import Weights


@dataclass(frozen=True, kw_only=True)
class ShellStyle:
    """How rooms of a style are finished.

    Attributes:
        profiles: Sections of skirting and casings, with weights.
        skirting: Range of its height, metres.
        casing: Range of the width of casings, metres.
        windows: How often windows have casings, too.
        cornices: Sections of cornices with weights; ``none`` for none.
        cornice: Range of their size, metres.
        picture_rail: How often a room of homes has one.
        wainscot: How often halls and dining rooms have one.
        ceilings: Kinds of ceilings of homes, with weights.
        heaters: Styles of radiators with weights; ``none`` for vents in the walls.
        rose: How often a lamp that hangs has a rose of plaster around it.
        accent: How often one wall differs.
        accents: What it has then: families with weights; ``paint`` for another colour.
        wood: How often boards are wood and not painted.
    """

    profiles: Weights
    skirting: tuple[float, float]
    casing: tuple[float, float]
    windows: float
    cornices: Weights = field(default_factory=lambda: {"none": 1.0})
    cornice: tuple[float, float] = (0.06, 0.1)
    picture_rail: float = 0.0
    wainscot: float = 0.0
    ceilings: Weights = field(default_factory=lambda: {"plain": 1.0})
    heaters: Weights
    rose: float = 0.0
    accent: float = 0.3
    accents: Weights = field(default_factory=lambda: {"paint": 1.0})
    wood: float = 0.0


SHELLS: Final[Mapping[InteriorStyle, ShellStyle]] = {
    "scandinavian": ShellStyle(
        profiles={"square": 2, "rounded": 3}, skirting=(0.07, 0.11), casing=(0.058, 0.07),
        windows=0.7, heaters={"panel": 3, "convector": 1}, accent=0.35,
        accents={"paint": 4, "oak_slats": 1},
    ),
    "mid_century": ShellStyle(
        profiles={"square": 3, "rounded": 1}, skirting=(0.06, 0.09), casing=(0.058, 0.07),
        windows=0.5, ceilings={"plain": 8, "beams": 1.5}, heaters={"convector": 2, "none": 2},
        accent=0.5, accents={"paint": 3, "oak_slats": 2}, wood=0.5,
    ),
    "industrial": ShellStyle(
        profiles={"square": 1}, skirting=(0.06, 0.1), casing=(0.06, 0.08), windows=0.2,
        ceilings={"plain": 2, "beams": 2}, heaters={"column": 3, "panel": 1}, accent=0.5,
        accents={"paint": 1, "running_bond_brick": 2, "cast_concrete": 1},
    ),
    "rustic": ShellStyle(
        profiles={"rounded": 1, "torus": 2, "square": 1}, skirting=(0.09, 0.13),
        casing=(0.07, 0.09), windows=0.8, ceilings={"plain": 1.5, "beams": 3},
        heaters={"column": 3, "panel": 1}, accent=0.2, wood=0.5,
        accents={"paint": 2, "knotty_pine": 1, "fieldstone_wall": 0.5},
    ),
    "traditional": ShellStyle(
        profiles={"ogee": 3, "torus": 2}, skirting=(0.11, 0.15), casing=(0.07, 0.09),
        windows=0.9, cornices={"cove": 2, "ogee": 2, "stepped": 1, "none": 1},
        picture_rail=0.25, wainscot=0.4, ceilings={"plain": 7, "coffers": 1},
        heaters={"column": 3, "panel": 1}, rose=0.6, accent=0.3,
        accents={"paint": 2, "damask": 1, "embossed_wallpaper": 1},
    ),
}  # fmt: skip

PLAIN: Final = ShellStyle(
    profiles={"square": 1, "rounded": 2}, skirting=(0.06, 0.09), casing=(0.06, 0.07), windows=0.3,
    heaters={"panel": 2, "none": 1}, accent=0.2,
)  # fmt: skip
"""Of rooms without a style."""
