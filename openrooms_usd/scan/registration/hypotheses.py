"""Pose hypotheses from a hint, a box or the points themselves, and their variations."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, product
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.rotations import in_plan
from openrooms_usd.scan.registration.evidence import Evidence
from openrooms_usd.scan.registration.fitting import (
    FINE,
    ROUGH,
    AnnealingLevel,
    Fit,
    energies,
    refined,
)
from openrooms_usd.scan.registration.hints import Box
from openrooms_usd.scan.registration.priors import PoseHypothesis
from openrooms_usd.scan.registration.scalelimits import (
    CAD_UNITS_M,
    Candidate,
    Sizes,
    sizes_of,
    turns_of,
)
from openrooms_usd.scan.registration.surroundings import ObjectSurroundings
from openrooms_usd.scan.registration.template import Template, turn_of
from openrooms_usd.scan.results import Pose

# The largest log scale error at which a unit of CADs is accepted.
_UNIT_LOG_TOLERANCE: Final = 0.25
# Standard deviations of a given pose or box: metres, radians, logarithms of scale.
_GIVEN_POSE_SIGMAS: Final = np.array([0.12, 0.12, 0.12, 0.2, 0.12, 0.12, 0.12])
# The same of a box around the points, which cover only a part of the object.
_SEEN_BOX_SIGMAS: Final = np.array([0.25, 0.25, 0.25, 0.25, 0.25, 0.25, 0.25])
# The same of a CAD that is built at any size: its top was seen, and it has no height of its own.
_BUILT_SIGMAS: Final = np.array([0.25, 0.25, 0.25, 0.25, 0.25, 0.25, 0.1])
# Standard deviation of anisotropic scale, and its limit where only points, perhaps outliers, give
# the box.
_BOX_STRETCH_LOG: Final = 0.18
_POINTS_STRETCH_LOG: Final = 0.3
# The same deviation of what is built at any size: it decides headings where there is little other
# evidence.
_BUILT_STRETCH_LOG: Final = 0.4
_TURNS_RAD: Final = (0.0, 0.14, -0.14)
_STRETCHES_LOG: Final = (-0.18, -0.1, 0.1, 0.18)
# Axis and direction of the end that moves while the other one stays; the base always stays.
_ENDS: Final = ((0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0), (2, 0.0))
_SHIFTS_M: Final = ((0.0, 0.0), (0.08, 0.0), (-0.08, 0.0), (0.0, 0.08), (0.0, -0.08))


def box_of(evidence: Evidence, support: float | None) -> Box:
    """The smallest upright box around most of some points, extended down to their support."""
    points = evidence.points
    low_z, high_z = np.quantile(points[:, 2], [0.01, 0.99])
    low_z = low_z if support is None else support

    def rectangle(angle: float) -> tuple[float, Array, Array]:
        level = points[:, :2] @ in_plan(angle)
        low, high = np.quantile(level, [0.01, 0.99], axis=0)
        return float(np.prod(np.maximum(high - low, 0.02))), low, high

    angles = np.deg2rad(np.arange(0.0, 90.0, 3.0))
    best = float(min(angles, key=lambda angle: rectangle(angle)[0]))
    _, low, high = rectangle(best)
    middle = in_plan(best) @ (0.5 * (low + high))
    return Box(
        np.array([*middle, 0.5 * (low_z + high_z)]),
        np.maximum([*(high - low), high_z - low_z], 0.01),
        np.array([np.cos(0.5 * best), 0.0, 0.0, np.sin(0.5 * best)]),
    )


def from_pose(template: Template, pose: Pose) -> list[PoseHypothesis]:
    """The hypothesis of a noisy pose."""
    known = template.parameters(pose)
    return [PoseHypothesis(known, _GIVEN_POSE_SIGMAS, plain(template))]


def from_box(
    template: Template, box: Box, *, given: bool, limited: bool = False
) -> list[PoseHypothesis]:
    """The hypotheses of a box: one for each side that may be its front.

    Args:
        template: The CAD.
        box: Around the object.
        given: Whether it was annotated; else it bounds the points.
        limited: Whether the CAD must stay what it is, as it was chosen for its category.
    """
    base, size, heading = box.upright()
    hypotheses = []
    turns = turns_of(template.model, template.upright, size) if limited else []
    for quarter in range(4):
        if turns and quarter % 2 not in turns:
            continue
        lengths = size if quarter % 2 == 0 else size[[1, 0, 2]]
        scale = np.log(np.maximum(lengths, 0.01) / np.maximum(template.size, 0.01))
        free = template.model.sizes is not None
        if not given and not free:
            usual = float(np.median(scale - plain(template)))
            scale = np.minimum(scale, plain(template) + usual + _POINTS_STRETCH_LOG)
        limits = None
        if limited:
            limits = np.log(sizes_of(template.model, template.upright, lengths) / template.size)
            scale = np.clip(scale, *limits)
        known = np.array([*base, heading + quarter * 0.5 * np.pi, *scale])
        hypotheses.append(
            PoseHypothesis(
                known,
                _GIVEN_POSE_SIGMAS if given else _BUILT_SIGMAS if free else _SEEN_BOX_SIGMAS,
                plain(template),
                _BUILT_STRETCH_LOG if free else _BOX_STRETCH_LOG,
                limits,
                to_scale=not free,
            )
        )
    return hypotheses


def plain(template: Template) -> Array:
    """(3,) log scales at which a CAD has its own size, its unit being metres."""
    return np.asarray(-np.abs(template.upright) @ np.log(template.reference))


def true_size(hypothesis: PoseHypothesis) -> Array | None:
    """(3,) log scales at which a CAD has its own size in the likeliest unit.

    That is the unit with the size nearest to the hypothesis; None where none is near, or where the
    CAD has no size of its own.
    """
    if not hypothesis.to_scale:
        return None
    mean = float(np.mean(hypothesis.parameters[4:] - hypothesis.plain))
    nearest = min((np.log(unit) for unit in CAD_UNITS_M), key=lambda log: abs(log - mean))
    return (
        np.asarray(hypothesis.plain + nearest)
        if abs(nearest - mean) < _UNIT_LOG_TOLERANCE
        else None
    )


def varied(hypothesis: PoseHypothesis) -> Iterator[Array]:
    """(7,) parameters around a hypothesis: turned and shifted, at its size and at the true one."""
    true = true_size(hypothesis)
    known = hypothesis.parameters[4:]
    for turn, shift in product(_TURNS_RAD, _SHIFTS_M):
        yield _moved(hypothesis.parameters, turn, shift, known if true is None else true)
    if true is not None:
        for turn in _TURNS_RAD:
            yield _moved(hypothesis.parameters, turn, (0.0, 0.0), known)


def _moved(parameters: Array, turn: float, shift: tuple[float, float], size: Array) -> Array:
    moved = np.concatenate([parameters[:4], size])
    moved[:4] += [*shift, 0.0, turn]
    return moved


def stretched(template: Template, parameters: Array) -> Iterator[Array]:
    """(7,) parameters with one side moved outward or inward while the opposite one stays."""
    turn = turn_of(parameters)
    for (axis, end), stretch in product(_ENDS, _STRETCHES_LOG):
        moved = parameters.copy()
        moved[4 + axis] += stretch
        grown = template.size[axis] * (np.exp(moved[4 + axis]) - np.exp(parameters[4 + axis]))
        moved[:3] += 0.5 * end * grown * turn[:, axis]
        yield moved


# Pose search from coarse to fine: all hypotheses scored, some refined roughly, few finely.

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
# Factor of the energy of a fit up to which one along the wall is as likely.
_STRAIGHT_ENERGY: Final = 1.1
# The most between it and the wall, metres.
_AT_WALL_M: Final = 0.1
# Fits with all parameters within this are duplicates.
_SAME_FIT_M_RAD: Final = 0.02


@dataclass(frozen=True, eq=False)
class Survey:
    """A hypothesis with the variations of it that scored best.

    Attributes:
        template: The CAD.
        hypothesis: Prior of the pose.
        around: Support, walls and visibility.
        begins: (B, 7) parameters of the variations, the best first.
        score: Energy of the best one.
    """

    template: Template
    hypothesis: PoseHypothesis
    around: ObjectSurroundings
    begins: Array
    score: float


def surveyed(
    template: Template, evidence: Evidence, around: ObjectSurroundings, hypothesis: PoseHypothesis
) -> Survey:
    """Score all variations of one hypothesis."""
    begins = np.array([*varied(hypothesis)])
    if around.support is not None:
        begins[:, 2] = around.support
    priors = [hypothesis] * len(begins)
    costs = energies(template, evidence, around, priors, begins, _SURVEY_LEVEL)
    best = np.argsort(costs, kind="stable")[:_ROUGH_VARIATIONS]
    return Survey(template, hypothesis, around, begins[best], float(costs[best[0]]))


def rough_candidates(surveys: Sequence[Survey], evidence: Evidence) -> list[Candidate]:
    """The variations of all hypotheses with some hope, roughly refined."""
    limit = _HOPELESS_SCORE * min(survey.score for survey in surveys)
    hopeful = [survey for survey in surveys if survey.score <= limit]
    return [
        candidate
        for _, same in groupby(hopeful, lambda survey: id(survey.template))
        for candidate in _roughly_refined([*same], evidence)
    ]


def _roughly_refined(surveys: Sequence[Survey], evidence: Evidence) -> Iterator[Candidate]:
    """The variations of the hypotheses of one template on one support."""
    template, around = surveys[0].template, surveys[0].around
    hypotheses = [survey.hypothesis for survey in surveys for _ in survey.begins]
    begins = np.concatenate([survey.begins for survey in surveys])
    fits = refined(template, evidence, around, hypotheses, begins, ROUGH)
    for hypothesis, fit in zip(hypotheses, fits, strict=True):
        yield Candidate(template, hypothesis, around, fit)


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
    t, prior = candidate, candidate.hypothesis
    begins = np.array([t.fit.parameters, *stretched(t.template, t.fit.parameters)])
    costs = energies(t.template, evidence, t.around, [prior] * len(begins), begins, _STRETCH_LEVEL)
    begin = begins[[int(np.argmin(costs))]]
    (fit,) = refined(t.template, evidence, t.around, [prior], begin, FINE)
    size = true_size(prior)
    if size is None:
        return Sizes(replace(t, fit=fit))
    begin = np.concatenate([fit.parameters[:4], size])[None]
    (same,) = refined(t.template, evidence, t.around, [prior.at(size)], begin, FINE)
    costs = energies(t.template, evidence, t.around, [prior], same.parameters[None], FINE[-1])
    return Sizes(replace(t, fit=fit), replace(t, fit=Fit(same.parameters, float(costs[0]))))


def along_wall(candidate: Candidate, evidence: Evidence) -> Candidate:
    """A candidate turned to the wall that it stands at, where its points allow it.

    Points that are not all of one straight thing, such as of shelves around a corner, lie best in
    a box across them. The part at the wall may be half as deep.
    """
    t, parameters = candidate, candidate.fit.parameters
    found = t.around.walls.askew(parameters, _size(t.template, parameters))
    if found is None:
        return t
    wall, turn = found
    begin = parameters + np.eye(7)[3] * turn
    begins = np.array([begin, *_halved(t.template, begin)])
    straight = [t.hypothesis.headed(float(begin[3]))] * len(begins)
    fits = refined(t.template, evidence, t.around, straight, begins, FINE)
    ends = np.array([fit.parameters for fit in fits])
    costs = energies(t.template, evidence, t.around, [t.hypothesis] * len(ends), ends, FINE[-1])
    for cost, end in sorted(zip(costs.tolist(), ends, strict=True), key=lambda each: each[0]):
        gap = t.around.walls.gaps(end, _size(t.template, end))[wall]
        if abs(gap) < _AT_WALL_M and cost < _STRAIGHT_ENERGY * t.fit.energy:
            return replace(t, fit=Fit(end, cost))
    return t


def _size(template: Template, parameters: Array) -> Array:
    """(3,) size of a template's box, metres."""
    return np.asarray(template.size * np.exp(parameters[4:]))


def _halved(template: Template, parameters: Array) -> Iterator[Array]:
    """(7,) parameters with half the depth, the back or the front staying where it is."""
    for end in (1.0, -1.0):
        moved = parameters + np.eye(7)[5] * np.log(0.5)
        moved[:3] += 0.5 * end * _size(template, moved)[1] * turn_of(parameters)[:, 1]
        yield moved
