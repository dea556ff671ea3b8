"""Chooses between free scales and the CADs' true size, jointly for all objects of a scan.

Unseen sides leave the scale of one object ambiguous. But a collection of CADs is to scale or it is
not: where well-seen objects have their true size, the others likely have it, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.scan.registration.fitting import Fit
from openrooms_usd.scan.registration.priors import PoseHypothesis
from openrooms_usd.scan.registration.surroundings import Surroundings
from openrooms_usd.scan.registration.template import Template

# Energy that three free scales save by fitting noise: the penalty of the larger model.
_FREE_SCALES_ENERGY: Final = 9.0
# Energy of good fits in scans without drift.
_GOOD_FIT_ENERGY: Final = 50.0
# Expectation-maximisation steps for the share of CADs to scale.
_EM_ROUNDS: Final = 20


@dataclass(frozen=True, eq=False)
class Candidate:
    """A fit with its inputs.

    Attributes:
        template: The CAD.
        hypothesis: Prior of the pose.
        around: Support, walls and visibility.
        fit: The pose so far.
    """

    template: Template
    hypothesis: PoseHypothesis
    around: Surroundings
    fit: Fit


@dataclass(frozen=True, eq=False)
class Sizes:
    """The best fits of one object.

    Attributes:
        any: With free scales.
        true: With the CAD's true size; None where that is not known, or far off.
    """

    any: Candidate
    true: Candidate | None = None

    @property
    def excess(self) -> float:
        """Energy of the true size over that of free scales, less the penalty of these.

        Where drift bends a scan, residuals exceed the assumed noise and every difference is too
        large by the same factor (the ratio of Birge 1932).
        """
        assert self.true is not None
        more = self.true.fit.energy - self.any.fit.energy
        return more / max(1.0, self.any.fit.energy / _GOOD_FIT_ENERGY) - _FREE_SCALES_ENERGY


def sized(objects: Sequence[Sizes]) -> list[Candidate]:
    """The likelier fit of each object, given what the others say.

    The share of CADs to scale is the weight of a mixture of two, by expectation-maximisation from
    even odds (with a pseudo-count of one object of either kind).
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
