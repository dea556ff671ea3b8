"""Pose search from coarse to fine: all hypotheses scored, some refined roughly, few finely."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.registration.evidence import Evidence
from openrooms_usd.scan.registration.fitting import (
    FINE,
    ROUGH,
    AnnealingLevel,
    Fit,
    energy,
    refined,
)
from openrooms_usd.scan.registration.hypotheses import stretched, true_size, varied
from openrooms_usd.scan.registration.priors import PoseHypothesis
from openrooms_usd.scan.registration.surroundings import Surroundings
from openrooms_usd.scan.registration.template import Template
from openrooms_usd.scan.registration.truesize import Candidate, Sizes

# Annealing levels of scores; numbers of rough fits a hypothesis and of fine fits an object; and
# the offset and factor of the best energy above which a rough fit is dropped.
_SURVEY_LEVEL: Final = AnnealingLevel(0.12, 80, 0, 1.0)
_STRETCH_LEVEL: Final = AnnealingLevel(0.05, 400, 0, 0.8)
_ROUGH_VARIATIONS: Final = 2
_FINE_FITS: Final = 4
_HOPELESS_ENERGY: Final = (20.0, 1.6)
# Factor of the best score above which a hypothesis is not even refined roughly: of the best ones
# after refinement none of 38 objects of a real scan scored over 3.0.
_HOPELESS_SCORE: Final = 3.5
# Fits with all parameters within this are duplicates.
_SAME_FIT_M_RAD: Final = 0.02


@dataclass(frozen=True, eq=False)
class Survey:
    """A hypothesis with the variations of it that scored best.

    Attributes:
        template: The CAD.
        hypothesis: Prior of the pose.
        around: Support, walls and visibility.
        begins: (7,) parameters of each variation, the best first.
        score: Energy of the best one.
    """

    template: Template
    hypothesis: PoseHypothesis
    around: Surroundings
    begins: Sequence[Array]
    score: float


def surveyed(
    template: Template, evidence: Evidence, around: Surroundings, hypothesis: PoseHypothesis
) -> Survey:
    """Score all variations of one hypothesis."""
    scored: list[tuple[float, int, Array]] = []
    for parameters in varied(hypothesis):
        if around.support is not None:
            parameters[2] = around.support
        cost = energy(template, evidence, around, hypothesis, parameters, _SURVEY_LEVEL)
        scored.append((cost, len(scored), parameters))
    best = sorted(scored)[:_ROUGH_VARIATIONS]
    begins = [parameters for _, _, parameters in best]
    return Survey(template, hypothesis, around, begins, best[0][0])


def rough_candidates(surveys: Sequence[Survey], evidence: Evidence) -> list[Candidate]:
    """The variations of all hypotheses with some hope, roughly refined."""
    limit = _HOPELESS_SCORE * min(survey.score for survey in surveys)
    return [
        Candidate(
            each.template,
            each.hypothesis,
            each.around,
            refined(each.template, evidence, each.around, each.hypothesis, begin, ROUGH),
        )
        for each in surveys
        if each.score <= limit
        for begin in each.begins
    ]


def best_sizes(candidates: Sequence[Candidate], evidence: Evidence) -> Sizes:
    """The best candidates, finely refined: with free scales, and with the CAD's true size."""
    energies = [candidate.fit.energy for candidate in candidates]
    order = _without_duplicates(
        candidates, sorted(range(len(candidates)), key=energies.__getitem__)
    )
    limit = _HOPELESS_ENERGY[0] + _HOPELESS_ENERGY[1] * energies[order[0]]
    hopeful = [row for row in _interleaved(candidates, order)[:_FINE_FITS] if energies[row] < limit]
    fine = [_finely_refined(candidates[row], evidence) for row in hopeful]
    true = [sizes.true for sizes in fine if sizes.true is not None]
    return Sizes(
        min((sizes.any for sizes in fine), key=lambda candidate: candidate.fit.energy),
        min(true, key=lambda candidate: candidate.fit.energy, default=None),
    )


def _interleaved(candidates: Sequence[Candidate], order: Sequence[int]) -> list[int]:
    """The best fit of every hypothesis first: rough energies hardly rank their yaws."""
    hypotheses = [candidates[row].hypothesis for row in order]
    earlier = [
        sum(other is hypothesis for other in hypotheses[:k])
        for k, hypothesis in enumerate(hypotheses)
    ]
    return [row for _, row in sorted(zip(earlier, order, strict=True), key=lambda pair: pair[0])]


def _without_duplicates(candidates: Sequence[Candidate], order: Sequence[int]) -> list[int]:
    """Rows without duplicates of an earlier fit of the same hypothesis."""
    kept: list[int] = []
    for row in order:
        candidate = candidates[row]
        same = [
            other
            for other in kept
            if candidates[other].hypothesis is candidate.hypothesis
            and np.abs(candidates[other].fit.parameters - candidate.fit.parameters).max()
            < _SAME_FIT_M_RAD
        ]
        if not same:
            kept.append(row)
    return kept


def _finely_refined(candidate: Candidate, evidence: Evidence) -> Sizes:
    t = candidate
    begins = [t.fit.parameters, *stretched(t.template, t.fit.parameters)]
    costs = [
        energy(t.template, evidence, t.around, t.hypothesis, begin, _STRETCH_LEVEL)
        for begin in begins
    ]
    begin = begins[int(np.argmin(costs))]
    fit = refined(t.template, evidence, t.around, t.hypothesis, begin, FINE)
    size = true_size(t.hypothesis)
    if size is None:
        return Sizes(replace(t, fit=fit))
    begin = np.concatenate([fit.parameters[:4], size])
    same = refined(t.template, evidence, t.around, t.hypothesis.at(size), begin, FINE)
    cost = energy(t.template, evidence, t.around, t.hypothesis, same.parameters, FINE[-1])
    return Sizes(replace(t, fit=fit), replace(t, fit=Fit(same.parameters, cost)))
