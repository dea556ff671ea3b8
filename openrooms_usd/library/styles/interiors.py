"""Styles of rooms: which furniture, materials and colours go together."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final, get_args

import numpy as np

from openrooms_usd.description.styles import InteriorStyle
from openrooms_usd.furniture.joinery.pieces import Fronts
from openrooms_usd.library.styles.assignment.rooms import Place
from openrooms_usd.library.styles.assignment.weights import Weights, drawn
from openrooms_usd.tables import read_table


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

    def style_of(self, category: str, weights: Weights, rng: np.random.Generator) -> str:
        """Draw one of some styles of a category of furniture, of the weights of its record."""
        factors = self.furniture.get(category, {})
        found = {style: weight * factors.get(style, 1.0) for style, weight in weights.items()}
        return drawn(rng, found if any(found.values()) else weights)


def _interior(told: dict[str, Any]) -> Interior:
    first = told.pop("woods")
    woods = {(pair.split()[0], pair.split()[1]): weight for pair, weight in first.items()}
    return Interior(**{**told, "woods": woods, "shell": ShellStyle(**told["shell"])})


_TABLES: Final = read_table(__file__, "interiors.toml")
INTERIORS: Final[Mapping[InteriorStyle, Interior]] = {
    style: _interior(_TABLES[style]) for style in get_args(InteriorStyle)
}
"""Every style by its name."""
PLAIN: Final = ShellStyle(**_TABLES["plain"]["shell"])
"""Of rooms without a style."""
