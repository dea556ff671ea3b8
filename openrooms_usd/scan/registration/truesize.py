"""Whether CADs have their true size, which all objects of a scan say together.

Sides that nobody saw leave the size of one object open. But a collection of CADs is to scale or it
is not: where what was seen well has its true size, the rest likely has it too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.scan.registration.fitting import Fit
from openrooms_usd.scan.registration.priors import PoseHypothesis
from openrooms_usd.scan.registration.surroundings import Surroundings
from openrooms_usd.scan.registration.template import Template

# What three scales that are free save by fitting noise, at even odds, in the energy's unit: half
# of an energy is the negative logarithm of a likelihood.
_FREE_SCALES_ENERGY: Final = 9.0
# Energies of good fits in scans that are not bent.
_GOOD_FIT_ENERGY: Final = 50.0
# How often the share of CADs to scale is estimated anew.
_EM_ROUNDS: Final = 20


@dataclass(frozen=True, eq=False)
class Candidate:
    """A fit with all that it was made of.

    Attributes:
        template: What was fitted.
        hypothesis: What was known before.
        around: What it touches.
        fit: How far it has come.
    """

    template: Template
    hypothesis: PoseHypothesis
    around: Surroundings
    fit: Fit


@dataclass(frozen=True, eq=False)
class Sizes:
    """The best fits of one object.

    Attributes:
        any: Its scales are free.
        true: It has its CAD's true size; None where that is not known, or far off.
    """

    any: Candidate
    true: Candidate | None = None

    @property
    def excess(self) -> float:
        """What the true size costs more than any, less what free scales save.

        Where drift bends a scan, its points deviate more than energies assume and every difference
        is as much too large (the ratio of Birge 1932).
        """
        assert self.true is not None
        more = self.true.fit.energy - self.any.fit.energy
        return more / max(1.0, self.any.fit.energy / _GOOD_FIT_ENERGY) - _FREE_SCALES_ENERGY


def sized(objects: Sequence[Sizes]) -> list[Candidate]:
    """The likelier fit of each object, given what the others say.

    The share of CADs to scale is that of a mixture, by expectation and maximisation from even odds
    (with one object of either kind beforehand).
    """
    known = [sizes.excess for sizes in objects if sizes.true is not None]
    excess, odds = np.clip(np.array(known), -50.0, 50.0), 0.0
    for _ in range(_EM_ROUNDS):
        likely = float((1.0 / (1.0 + np.exp(0.5 * excess - odds))).sum())
        odds = float(np.log((likely + 1.0) / (len(known) - likely + 1.0)))
    return [
        sizes.true if sizes.true is not None and 0.5 * sizes.excess < odds else sizes.any
        for sizes in objects
    ]
