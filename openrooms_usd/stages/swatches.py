"""Swatches: materials that are fully determined."""

import hashlib
import json
from dataclasses import dataclass, fields, replace
from typing import Final

from openrooms_usd.description.substances import Substance
from openrooms_usd.library import textures

Color = tuple[float, float, float]

# OpenRooms' reflectance at normal incidence.
F0: Final = 0.05
# Families of more than this length have twice the texels along each side, metres, and those of no
# more than that half as many, unless they show threads: a texel is then about a millimetre.
_LARGE_FAMILY_M: Final = 1.0
_SMALL_FAMILY_M: Final = 0.3
# A pattern needs that many, however small the family.
_FEWEST_TEXELS: Final = 256


@dataclass(frozen=True)
class Swatch:
    """A material, by all that determines it.

    Attributes:
        substance: What it is.
        family: The family of its textures; None for a constant and for the user's own.
        number: Which material of the family.
        title: How it is called where it has no family, for people.
        color: Mean base colour, scene-linear Rec.709; None: the material's own.
        roughness: Mean perceptual roughness; None: the material's own.
        metallic: Of a constant.
        size: Width that one repeat of the textures covers, metres; None: the usual one.
        file: The user's own material, relative to the description.
        across: Whether its grain runs along s rather than t.
        transmission: Part of the light that passes diffusely.
        pane: What the glass of a clear pane lets through, by primary; None where it is none.
        tint: Factors of the base colour.
        wear: Factor of the roughness.
        place: Where on the material it is cut from, in repeats along s and t.
    """

    substance: Substance
    family: str | None = None
    number: int = 0
    title: str = ""
    color: Color | None = None
    roughness: float | None = None
    metallic: float = 0.0
    size: float | None = None
    file: str | None = None
    across: bool = False
    transmission: float = 0.0
    pane: Color | None = None
    tint: Color = (1.0, 1.0, 1.0)
    wear: float = 1.0
    place: tuple[float, float] = (0.0, 0.0)

    @property
    def turned(self) -> "Swatch":
        """The same with its grain along s, where it has a grain."""
        grain = self.family is not None and textures.family_of(self.family).grain
        return replace(self, across=True) if grain else self

    def cut(self, place: tuple[float, float], tint: Color) -> "Swatch":
        """The same of another piece: cut from elsewhere, a little lighter or redder."""
        if self.family is None:
            return self
        red, green, blue = (round(a * b, 4) for a, b in zip(self.tint, tint, strict=True))
        return replace(self, place=place, tint=(red, green, blue))

    @property
    def is_scaled(self) -> bool:
        """Whether it is brighter, tinted or rougher than it was made."""
        return self.tint != (1.0, 1.0, 1.0) or self.wear != 1.0

    def textures(self, resolution: int) -> textures.Material | None:
        """Its textures in the library.

        Args:
            resolution: Texels along each side; large families have twice as many, small ones half.
        """
        if self.family is None:
            return None
        size = self.size or textures.family_of(self.family).repeat
        texels = resolution * 2 if size > _LARGE_FAMILY_M else resolution
        if size <= _SMALL_FAMILY_M and self.substance != "fabric":
            texels = min(resolution, max(resolution // 2, _FEWEST_TEXELS))
        return textures.Material(self.family, self.number, self.color, self.roughness, texels, size)

    @property
    def digest(self) -> str:
        """8 hexadecimal digits of what is said of it, which other code does not change.

        Prims are named by it, and people's edits by prims; so nothing that is left as it is counts.
        """
        said = {
            item.name: value
            for item in fields(self)
            if (value := getattr(self, item.name)) != item.default
        }
        text = json.dumps(said, sort_keys=True, default=float)
        return hashlib.sha256(text.encode()).hexdigest()[:8]
