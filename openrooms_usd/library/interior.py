"""What a style of rooms says: factors of what is taken, and what a room draws one of.

A factor says how much more or less often than elsewhere something is taken; what is not named has
the factor 1. Colours are scene-linear Rec.709.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from openrooms_usd.furniture.joinery.boards import Fronts
from openrooms_usd.library.assignment.rooms import Place
from openrooms_usd.library.assignment.weights import Weights, drawn
from openrooms_usd.library.shellstyles import ShellStyle

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
