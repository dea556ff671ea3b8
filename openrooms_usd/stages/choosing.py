"""Draws at random what the description and the tables leave open: one chooser a look of a room."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import numpy as np

from openrooms_usd.description.materials import Look
from openrooms_usd.description.substances import Substance
from openrooms_usd.library import textures
from openrooms_usd.library.assignment.rooms import Place, surface_of
from openrooms_usd.library.assignment.weights import Weights, drawn
from openrooms_usd.library.ensembles import Ensemble, ensemble_of
from openrooms_usd.library.finishes import FINISHES, Finish, finishes_of
from openrooms_usd.library.interiors import INTERIORS
from openrooms_usd.stages.base import StageContext
from openrooms_usd.stages.swatches import Swatch

# The families of a substance that suit a place, with weights.
Suited = Callable[[Substance], Weights]

# Materials of each family that rooms draw from: few enough that rooms share their textures.
NUMBERS_PER_FAMILY: Final = 64
# Ratio of the probabilities of successive variants of a finish in a room.
_RARER_FACTOR: Final = 0.5
_COLOR_DECIMALS: Final = 3


@dataclass(frozen=True)
class Chooser:
    """Draws the materials of one look.

    Attributes:
        context: The seed, and what the description says.
        look: Which look; each draws its own.
    """

    context: StageContext
    look: int = 0

    @cached_property
    def ensemble(self) -> Ensemble | None:
        """What the room has in common in this look, where it has a style."""
        style = self.context.room.style
        return ensemble_of(INTERIORS[style], self.rng("ensemble")) if style else None

    def finishes(self, category: str, kinds: Sequence[str], suite: str = "") -> dict[str, str]:
        """The finish of each kind of part of an object; a suite of them draws one scheme."""
        rng, shared = (
            self.rng("scheme", *((suite,) if suite else (category, *kinds))),
            self.ensemble,
        )
        if shared is None:
            return finishes_of(category, kinds, rng)
        return finishes_of(category, kinds, rng, shared.interior.finishes, shared.metal)

    def rng(self, *key: str) -> np.random.Generator:
        """A generator of this look for a key."""
        look = (f"look_{self.look}",) if self.look else ()
        return self.context.rng("materials", *look, *key)

    def finish(self, name: str, *key: str) -> Swatch:
        """The swatch of a finish: one of the few that the room has of it.

        Args:
            name: A key of `FINISHES`.
            key: Names what it is for; the same key gives the same swatch.
        """
        shared = self.ensemble
        finish = shared.finish(name) if shared else FINISHES[name]
        lot = shared.lot(name) if shared else name
        variant = self._choice(finish, lot, key)
        number, rng = str(variant), self.rng("finish", lot, str(variant))
        if shared:
            family, color = shared.family(name, variant, rng), shared.color(name, variant, rng)
        else:
            family = drawn(rng, finish.families) if finish.families else None
            color = finish.colors[int(rng.integers(len(finish.colors)))] if finish.colors else None
        roughness = round(float(rng.uniform(*finish.roughness)), 3) if finish.roughness else None
        swatch = Swatch(
            finish.substance, family, int(rng.integers(NUMBERS_PER_FAMILY)) if family else 0, name,
            color,
            roughness, finish.metallic, transmission=finish.transmission, pane=finish.pane,
        )  # fmt: skip
        return self._scaled(swatch, name, number)

    def _choice(self, finish: Finish, name: str, key: tuple[str, ...]) -> int:
        rng = self.rng("choice", name, *key)
        if finish.each:
            return int(rng.integers(finish.choices))
        weights = {f"{i:03d}": _RARER_FACTOR**i for i in range(finish.choices)}
        return int(drawn(rng, weights))

    def asked(self, look: Look, suited: Suited, *key: str) -> Swatch:
        """The swatch of a look that the description asks for.

        Args:
            look: The look.
            suited: Which families of a substance suit, where the look leaves the family open.
            key: Names what it is for; the same key gives the same swatch.
        """
        if look.is_constant:
            metal = look.metallic is not None and look.metallic >= 0.5
            substance = look.substance or ("metal" if metal else "paint")
            return Swatch(
                substance, None, 0, "constant", look.color, look.roughness, look.metallic or 0.0
            )
        rng = self.rng("look", *key)
        if look.file is not None:
            own = Swatch(look.substance or "paint", size=look.size, file=look.file)
            return self._scaled(own, *key)
        family = _family(look, suited, rng)
        number = int(rng.integers(NUMBERS_PER_FAMILY))
        swatch = Swatch(
            textures.substance_of(family), family, number if look.number is None else look.number,
            "", look.color, look.roughness,
            size=look.size or self.context.room.materials.texture_size,
        )  # fmt: skip
        return self._scaled(swatch, *key)

    def surface(self, place: Place) -> Swatch:
        """What floor or walls of a room of this type usually have."""
        rng, room, color = self.rng("surface", place), self.context.room.room, None
        if self.ensemble:
            family, substance, color = self.ensemble.surface(room, place, rng)
        else:
            family, substance = surface_of(room, place, rng)
        swatch = Swatch(substance, family, int(rng.integers(NUMBERS_PER_FAMILY)), color=color)
        sized = replace(swatch, size=self.context.room.materials.texture_size)
        return self._scaled(sized, place)

    def _scaled(self, swatch: Swatch, *key: str) -> Swatch:
        """The swatch with its factors, where the description asks for some."""
        scale, rng = self.context.room.materials.scale, self.rng("scale", *key)
        red, green, blue = (
            round(float(rng.uniform(*scale.color)), _COLOR_DECIMALS) for _ in range(3)
        )
        wear = round(float(rng.uniform(*scale.roughness)), _COLOR_DECIMALS)
        return replace(swatch, tint=(red, green, blue), wear=wear)


def _family(look: Look, suited: Suited, rng: np.random.Generator) -> str:
    """The family that a look names, or one of the substance that it names."""
    substance = look.substance or next((s for s in textures.FAMILIES if s == look.family), None)
    return drawn(rng, suited(substance)) if substance else str(look.family)
