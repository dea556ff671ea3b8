"""What furniture is usually made of: finishes, and which finish each part of a category has."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import prod
from typing import Final

import numpy as np

from openrooms_usd.description.substances import Substance
from openrooms_usd.furniture.construction import ANY
from openrooms_usd.furniture.registry import record
from openrooms_usd.furniture.schemes import METAL, METALS, TONES, Scheme
from openrooms_usd.library.styles.assignment.kinds import known_as
from openrooms_usd.library.styles.assignment.weights import Weights, families_for
from openrooms_usd.library.textures import Use
from openrooms_usd.tables import read_table

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
        pane: Transmittance of a clear pane's glass, by primary; None if it is not a clear pane.
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


# What a part gets of which nothing is known.
UNKNOWN: Final = "lacquer"


_TABLES: Final = read_table(__file__, "finishes.toml")
FINISHES: Final[dict[str, Finish]] = {
    **{name: Finish(**told) for name, told in _TABLES["finishes"].items()},
    **{
        f"{name}_{tone}": Finish("paint", colors=(color,), roughness=(0.5, 0.7))
        for name, colors in _TABLES["palettes"].items()
        for tone, color in zip(TONES, colors, strict=True)
    },
}

GENERIC: Final[dict[Substance, str]] = _TABLES["generic"]
"""The default finish of a substance on furniture."""

_NO_FACTORS: Final[Weights] = {}
_ON_FURNITURE: Final[tuple[Use, ...]] = ("furniture", "object", "textile")

PARTS: Final[dict[str, str]] = _TABLES["parts"]
"""Finishes of parts that are the same on whatever they are found."""


def finishes_of(
    category: str,
    parts: Iterable[str],
    rng: np.random.Generator,
    factors: Weights = _NO_FACTORS,
    metal: str | None = None,
) -> dict[str, str]:
    """Choose a finish for each part of an object.

    Args:
        category: What it is; any word.
        parts: The kinds of its parts; any words.
        rng: Draws one of the schemes that fit, and its metal.
        factors: How much more or less often schemes with these finishes are drawn.
        metal: The metal that all objects of the room share; drawn by default.

    Returns:
        Keys of `FINISHES` by part.
    """
    names = sorted(set(parts))
    known = record(category)
    schemes = known.schemes if known else ()
    fitting = [scheme for scheme in schemes if scheme.needs is None or scheme.needs in names]
    fitting = [scheme for scheme in fitting if scheme.suite] or fitting
    weights = np.cumsum([_weight(scheme, factors) for scheme in fitting] or [1.0])
    drawn = int(np.searchsorted(weights, rng.uniform(0.0, weights[-1]), side="right"))
    chosen = fitting[drawn].finishes if fitting else {}
    drawn_metal = METALS[int(rng.integers(len(METALS)))]
    metal = metal or drawn_metal
    picked = {part: _finish(part, chosen) for part in names}
    return {part: metal if finish == METAL else finish for part, finish in picked.items()}


def suite_of(category: str, parts: Iterable[str]) -> str:
    """The suite that an object is of, by the kinds of its parts; empty for none."""
    known, names = record(category), set(parts)
    schemes = known.schemes if known else ()
    return next((s.suite for s in schemes if s.suite and (s.needs or "") in {"", *names}), "")


def _weight(scheme: Scheme, factors: Weights) -> float:
    """How often a scheme is drawn: its own weight times the factors of its finishes."""
    named = sorted(set(scheme.finishes.values()))
    return scheme.weight * prod(factors.get(finish, 1.0) for finish in named)


def _finish(part: str, scheme: Mapping[str, str]) -> str:
    """The finish of a part: by the scheme, else by `PARTS`, else that of the scheme's rest."""
    for table in (scheme, PARTS):
        for name in known_as(part):
            if name in table:
                return table[name]
    return scheme.get(ANY, UNKNOWN)


def furniture_families(substance: Substance) -> Weights:
    """The families of a substance that suit furniture."""
    return FINISHES[GENERIC[substance]].families or families_for(substance, _ON_FURNITURE)
