"""Reference materials: published coefficients of friction, and how each of them looks.

The coefficients are measured or codified, a source for each. The looks are not of the same
specimens, for which none are published: they are usual values of such a material.
"""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final, get_args

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.description.substances import Substance

FILE: Final = Path(__file__).with_name("references.json")
SUBSTANCES: Final[tuple[Substance, ...]] = get_args(Substance)

# The weight of "no difference" in the estimate of what a counterface does, in rows.
_CAUTION: Final = 1.0


@dataclass(frozen=True)
class Reference:
    """One published pair of surfaces, dry.

    Attributes:
        name: The material and where it was tried, for people.
        substance: What the material is.
        counterface: What it slid on: metal, wood, rubber, leather, plastic, textile, skin, or
            mineral (stone, concrete, glass).
        static: Published static coefficient; of sliding alone where nothing else was published.
        dynamic: Published dynamic coefficient; None where there is none.
        albedo: Usual linear base colour; of metals the reflectance at normal incidence.
        roughness: Usual perceptual roughness.
        density: kg/m3.
        source: A key of the file's sources.
        note: What the source says besides.
    """

    name: str
    substance: Substance
    counterface: str
    static: float
    dynamic: float | None
    albedo: tuple[float, float, float]
    roughness: float
    density: float
    source: str
    note: str = ""

    @property
    def specimen(self) -> tuple[object, ...]:
        """What tells its look from others': rows of one specimen differ in the counterface."""
        return (self.substance, self.albedo, self.roughness)


@cache
def _file() -> dict[str, Any]:
    return dict(json.loads(FILE.read_text("utf-8")))


def references() -> tuple[Reference, ...]:
    """All rows, in the order of the file."""
    rows = _file()["materials"]
    return tuple(Reference(**{**row, "albedo": tuple(row["albedo"])}) for row in rows)


def sources() -> dict[str, str]:
    """What was published where, by key."""
    return dict(_file()["sources"])


def restitution(substance: Substance) -> float:
    """Speed after a bounce on a hard floor by the speed before; some are assumed (see the file)."""
    return float(_file()["restitution"][substance]["value"])


def density(substance: Substance) -> float:
    """The median density of the references of a substance, kg/m3."""
    return float(np.median([row.density for row in references() if row.substance == substance]))


def counterface_factors(rows: tuple[Reference, ...]) -> dict[str, float]:
    """What each counterface does to a coefficient: the published pairs are of many.

    The logarithm of a coefficient is taken as the substance's part plus the counterface's, and both
    are fitted by least squares, the counterface's drawn towards 0 as by one more row that shows no
    difference.

    Returns:
        Factor by counterface; over the rows their logarithms are 0 in the mean.
    """
    faces = sorted({row.counterface for row in rows})
    substance = _indicators([row.substance for row in rows], list(SUBSTANCES))
    face = _indicators([row.counterface for row in rows], faces)
    design = np.concatenate([substance, face], axis=1)
    pull = np.diag([1e-9] * len(SUBSTANCES) + [_CAUTION] * len(faces))
    logarithms = np.log([row.static for row in rows])
    parts = np.linalg.solve(design.T @ design + pull, design.T @ logarithms)[len(SUBSTANCES) :]
    centred = parts - np.mean(face @ parts)
    return dict(zip(faces, map(float, np.exp(centred)), strict=True))


def _indicators(values: list[Any], known: list[Any]) -> Array:
    return np.array([[float(value == item) for item in known] for value in values])
