"""What a room of a style has in common: its woods, its metal, its colours.

Every object draws its finishes from them, so that a chair is of the wood of the table, and handles
are of the metal of the lamps.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from openrooms_usd.description.substances import Substance
from openrooms_usd.library.styles.assignment.rooms import Place, families_of, substance_of
from openrooms_usd.library.styles.assignment.weights import drawn
from openrooms_usd.library.styles.finishes import FINISHES, Finish
from openrooms_usd.library.styles.interiors import Color, Interior

Role = Literal["light", "deep", "accent"]

# The finishes whose colours are the room's own: for each variant a colour, the most frequent first,
# and how bright it is beside it: paint is brighter than cloth, and cloth than a border.
_DYED: Final[Mapping[str, tuple[tuple[Role, float], ...]]] = {
    "lacquer": (("light", 0.95), ("deep", 0.8), ("accent", 1.0)),
    "upholstery": (("deep", 1.0), ("accent", 1.0)),
    "throw": (("accent", 1.1), ("light", 0.8)),
    "linen": (("light", 0.85), ("deep", 1.2)),
    "drape": (("light", 0.55), ("deep", 0.9)),
    "carpet": (("deep", 1.0), ("accent", 0.9)),
    "carpet_border": (("light", 0.7), ("deep", 0.5)),
    "ceramic": (("light", 1.0), ("accent", 1.0)),
    "glaze": (("light", 1.0), ("accent", 1.0), ("deep", 1.0)),
}
# Wood in one piece where that of the room is glued of staves: another family of its colour.
_WOODS: Final[Mapping[str, Mapping[str, tuple[str, Color | None]]]] = {
    "wood": {},
    "bent_wood": {
        "beech_staves": ("ash_veneer", (0.50, 0.315, 0.185)),
        "brushed_larch": ("ash_veneer", (0.44, 0.26, 0.125)),
        "butcher_block": ("ash_veneer", (0.50, 0.315, 0.185)),
        "knotty_pine": ("ash_veneer", (0.56, 0.365, 0.175)),
        "pine_staves": ("ash_veneer", (0.56, 0.365, 0.175)),
    },
}
_MAX_ALBEDO: Final = 0.8


@dataclass(frozen=True)
class Ensemble:
    """What one room of a style has in common.

    Attributes:
        interior: The style.
        woods: Families of its main and of its second wood.
        metal: The finish of its frames, handles and lamps.
        accent: A colour of few things.
        light: Its light neutral.
        deep: Its deeper neutral.
        wall: The colour of its painted walls.
        ceiling: The colour of its painted ceiling.
    """

    interior: Interior
    woods: tuple[str, str]
    metal: str
    accent: Color
    light: Color
    deep: Color
    wall: Color
    ceiling: Color

    def finish(self, name: str) -> Finish:
        """A finish of `FINISHES` as this room has it."""
        usual = FINISHES[name]
        if name in _WOODS:
            woods = [_WOODS[name].get(wood, (wood, None))[0] for wood in self.woods]
            return replace(usual, families=dict.fromkeys(woods, 1.0), choices=self._kinds)
        finish = replace(usual, families=self.interior.weighted(usual.families))
        if name in _DYED:
            finish = replace(finish, colors=(), choices=len(_DYED[name]))
        return finish

    @property
    def _kinds(self) -> int:
        return len(set(self.woods))

    def lot(self, name: str) -> str:
        """The finish that one of the same lot has: bent wood is of the wood of boards."""
        return "wood" if name in _WOODS else name

    def family(self, name: str, variant: int, rng: np.random.Generator) -> str | None:
        """The family of textures of one of the variants of a finish; None for a constant."""
        if name in _WOODS:
            wood = self.woods[variant]
            return _WOODS[name].get(wood, (wood, None))[0]
        families = self.finish(name).families
        return drawn(rng, families) if families else None

    def color(self, name: str, variant: int, rng: np.random.Generator) -> Color | None:
        """The mean base colour of one of the variants of a finish; None: the family's own."""
        if name in _DYED:
            role, factor = _DYED[name][variant]
            red, green, blue = (
                round(min(factor * value, _MAX_ALBEDO), 3) for value in getattr(self, role)
            )
            return red, green, blue
        if name in _WOODS:
            return _WOODS[name].get(self.woods[variant], ("", None))[1]
        colors = FINISHES[name].colors
        return colors[int(rng.integers(len(colors)))] if colors else None

    def surface(
        self, room: str, place: Place, rng: np.random.Generator
    ) -> tuple[str, Substance, Color | None]:
        """Draw the family, the substance and the colour of floor, walls or ceiling."""
        substance = substance_of(room, place, rng, self.interior.substances.get(place, {}))
        family = drawn(rng, self.interior.weighted(families_of(room, place, substance)))
        painted = {"wall": self.wall, "ceiling": self.ceiling}.get(place)
        return family, substance, painted if substance == "paint" else None


def ensemble_of(interior: Interior, rng: np.random.Generator) -> Ensemble:
    """Draw what a room of a style has in common."""
    pairs = {"/".join(pair): weight for pair, weight in interior.woods.items()}
    main, second = drawn(rng, pairs).split("/")
    metal = drawn(rng, interior.metals)
    light, deep = interior.neutrals[int(rng.integers(len(interior.neutrals)))]
    accent, wall, ceiling = (
        colors[int(rng.integers(len(colors)))]
        for colors in (interior.accents, interior.walls, interior.ceilings)
    )
    return Ensemble(interior, (main, second), metal, accent, light, deep, wall, ceiling)
