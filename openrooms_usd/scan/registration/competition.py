"""Tries starts of a CAD against each other: surveyed, refined roughly, the best of them finely."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.registration.evidence import Evidence
from openrooms_usd.scan.registration.fitting import FINE, ROUGH, Fit, Stage, energy, refined
from openrooms_usd.scan.registration.hypotheses import stretched, true_size, varied
from openrooms_usd.scan.registration.priors import Start
from openrooms_usd.scan.registration.surroundings import Surroundings
from openrooms_usd.scan.registration.template import Shape
from openrooms_usd.scan.registration.truesize import Sizes, Trial

Array = NDArray[np.float64]

# How starts are compared, how many variations of each are refined roughly, how many of all are
# refined finely, and how much worse than the best these may be.
_SURVEY: Final = Stage(0.12, 80, 0, 1.0)
_STRETCH: Final = Stage(0.05, 400, 0, 0.8)
_ROUGHLY: Final = 2
_FINELY: Final = 4
_HOPELESS: Final = (20.0, 1.6)
# Fits whose parameters are as near to each other as this are one, metres or radians.
_SAME: Final = 0.02


def begun(shape: Shape, evidence: Evidence, around: Surroundings, start: Start) -> list[Trial]:
    """The best of what varies one start, roughly refined."""
    surveyed: list[tuple[float, int, Array]] = []
    for parameters in varied(start):
        if around.support is not None:
            parameters[2] = around.support
        cost = energy(shape, evidence, around, start, parameters, _SURVEY)
        surveyed.append((cost, len(surveyed), parameters))
    return [
        Trial(shape, start, around, refined(shape, evidence, around, start, parameters, ROUGH))
        for _, _, parameters in sorted(surveyed)[:_ROUGHLY]
    ]


def finished(trials: Sequence[Trial], evidence: Evidence) -> Sizes:
    """The best trials, finely refined: of any size, and of the CAD's true one."""
    energies = [trial.fit.energy for trial in trials]
    order = _different(trials, sorted(range(len(trials)), key=energies.__getitem__))
    limit = _HOPELESS[0] + _HOPELESS[1] * energies[order[0]]
    hopeful = [row for row in _mixed(trials, order)[:_FINELY] if energies[row] < limit]
    fine = [_settled(trials[row], evidence) for row in hopeful]
    true = [sizes.true for sizes in fine if sizes.true is not None]
    return Sizes(
        min((sizes.any for sizes in fine), key=lambda trial: trial.fit.energy),
        min(true, key=lambda trial: trial.fit.energy, default=None),
    )


def _mixed(trials: Sequence[Trial], order: Sequence[int]) -> list[int]:
    """The best of each start before the second best: rough fits hardly tell fronts from sides."""
    starts = [trials[row].start for row in order]
    earlier = [sum(other is start for other in starts[:k]) for k, start in enumerate(starts)]
    return [row for _, row in sorted(zip(earlier, order, strict=True), key=lambda pair: pair[0])]


def _different(trials: Sequence[Trial], order: Sequence[int]) -> list[int]:
    """Those rows that lead elsewhere than an earlier one of the same start."""
    kept: list[int] = []
    for row in order:
        trial = trials[row]
        same = [
            other
            for other in kept
            if trials[other].start is trial.start
            and np.abs(trials[other].fit.parameters - trial.fit.parameters).max() < _SAME
        ]
        if not same:
            kept.append(row)
    return kept


def _settled(trial: Trial, evidence: Evidence) -> Sizes:
    t = trial
    begins = [t.fit.parameters, *stretched(t.shape, t.fit.parameters)]
    costs = [energy(t.shape, evidence, t.around, t.start, begin, _STRETCH) for begin in begins]
    begin = begins[int(np.argmin(costs))]
    fit = refined(t.shape, evidence, t.around, t.start, begin, FINE)
    size = true_size(t.start)
    if size is None:
        return Sizes(replace(t, fit=fit))
    begin = np.concatenate([fit.parameters[:4], size])
    same = refined(t.shape, evidence, t.around, t.start.at(size), begin, FINE)
    cost = energy(t.shape, evidence, t.around, t.start, same.parameters, FINE[-1])
    return Sizes(replace(t, fit=fit), replace(t, fit=Fit(same.parameters, cost)))
