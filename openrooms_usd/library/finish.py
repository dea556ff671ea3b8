"""What a finish is: a treatment of surfaces, before chance decides the rest."""

from dataclasses import dataclass, field

from openrooms_usd.description.substances import Substance
from openrooms_usd.library.assignment.weights import Weights

Color = tuple[float, float, float]


@dataclass(frozen=True)
class Finish:
    """A treatment of surfaces, before chance decides the rest.

    Attributes:
        substance: What it is.
        families: Its families of textures, one of which is drawn; empty for a plain constant.
        colors: Mean base colours, scene-linear Rec.709, one of which is drawn; empty: the family's.
        roughness: Range of the mean perceptual roughness; None: the family's.
        metallic: 0 or 1; of a constant.
        choices: How many different ones a room has; more objects share them.
        transmission: Part of the light that passes diffusely through a face. Base colour R and
            it, T, are together at most 1; cloth of two faces passes T^2 / (1 - R^2).
        pane: What the glass of a clear pane lets through, by primary; None where it is none.
        each: Whether every instance of a part draws its own, as books do.
    """

    substance: Substance
    families: Weights = field(default_factory=dict)
    colors: tuple[Color, ...] = ()
    roughness: tuple[float, float] | None = None
    metallic: float = 0.0
    choices: int = 1
    transmission: float = 0.0
    pane: Color | None = None
    each: bool = False
