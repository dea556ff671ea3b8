"""Draws from tables of names with weights."""

from collections.abc import Iterable, Mapping
from typing import TypeVar

import numpy as np

from openrooms_usd.description.substances import Substance
from openrooms_usd.library.textures import FAMILIES, Use

Weights = Mapping[str, float]
Name = TypeVar("Name", bound=str)


def drawn(rng: np.random.Generator, weights: Mapping[Name, float]) -> Name:
    """One of the names, as often as its weight says.

    The order in which a table names them changes nothing.
    """
    names = sorted(weights)
    shares = np.cumsum([weights[name] for name in names])
    return names[int(np.searchsorted(shares, rng.uniform(0.0, shares[-1]), side="right"))]


def families_for(substance: Substance, uses: Iterable[Use]) -> Weights:
    """The families of a substance that people have there, all alike; all where there is none."""
    wanted, families = set(uses), FAMILIES[substance]
    fitting = [name for name, family in families.items() if wanted & family.uses]
    return dict.fromkeys(fitting or families, 1.0)
