"""What a family of procedural materials is: a recipe, its usual size and where it is used."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from openrooms_usd.library.textures.base.maps import Maps

Color = tuple[float, float, float]
Use = Literal["floor", "wall", "ceiling", "furniture", "worktop", "textile", "object"]


@dataclass(frozen=True, eq=False)
class TextureParams:
    """What is asked of a family.

    Attributes:
        rng: What is not given is drawn from it.
        resolution: Texels along each side.
        size: Physical length of each side, metres.
        color: Mean base colour, scene-linear Rec.709; None: drawn.
        roughness: Mean perceptual roughness; None: drawn.
    """

    rng: np.random.Generator
    resolution: int
    size: float
    color: Color | None = None
    roughness: float | None = None


@dataclass(frozen=True)
class Family:
    """One kind of material, endless by seed.

    Attributes:
        make: Makes it; equal orders give equal maps.
        size: Its usual physical size, metres: wide for boards and tiles, small for threads.
        uses: Where people have it.
        grain: Whether it has a direction, along t, that joiners and weavers heed.
        metallic: Its metalness; None: a map of it, as of rust or worn plating.
        laid: How often a usual repeat shows its picture along each side, with clouds of its own
            over the whole: a weave repeats every few threads, a cloth over metres.
    """

    make: Callable[[TextureParams], Maps]
    size: float
    uses: frozenset[Use]
    grain: bool = False
    metallic: float | None = 0.0
    laid: int = 1

    @property
    def repeat(self) -> float:
        """Width of a usual repeat, metres."""
        return self.size * self.laid
