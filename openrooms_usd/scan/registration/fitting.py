"""Robust ICP of a CAD to the points of an object, over translation, yaw and three scales.

Residuals run both ways: from every point to the CAD, and from the CAD's visible surface to the
points, which keeps it out of free space. The robust kernel is narrowed step by step (graduated
non-convexity); priors and contacts are least squares.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.scan.registration.evidence import Evidence
from openrooms_usd.scan.registration.priors import Pairs, PoseHypothesis, System, paired
from openrooms_usd.scan.registration.surroundings import Surroundings, hidden_sides
from openrooms_usd.scan.registration.template import Template, directions, posed, unposed

# Standard deviation of a residual, metres, and the effective number of independent ones that the
# correlated points of one object amount to.
_DISTANCE_SIGMA_M: Final = 0.02
_INDEPENDENT_DISTANCES: Final = 250.0
# Weight of residuals from the CAD's visible surface, against those from points.
_SEEN_WEIGHT: Final = 0.7
# The same where visibility is not known.
_UNKNOWN_WEIGHT: Final = 0.35
# Height above its support below which a CAD's points are ignored, metres, and as a share of the
# CAD's height.
_SUPPORT_REACH_M: Final = 0.04
_MAX_SUPPORT_SHARE: Final = 0.3
# Part of the previous step that is added to the next one.
_STEP_MOMENTUM: Final = 0.6
# Largest step: metres, radians, logarithm of scale.
_MAX_STEP: Final = np.array([0.06, 0.06, 0.06, 0.12, 0.06, 0.06, 0.06])


class AnnealingLevel(NamedTuple):
    """One level of the annealing schedule.

    Attributes:
        width: Of the kernel, metres.
        points: Sampled from either side.
        steps: Gauss-Newton steps.
        disc: Radius of a point's disc, over the spacing of points: large ones approach
            point-to-plane residuals, small ones point-to-point.
    """

    width: float
    points: int
    steps: int
    disc: float


ROUGH: Final = (AnnealingLevel(0.12, 250, 6, 1.0), AnnealingLevel(0.07, 250, 6, 1.0))
FINE: Final = (
    AnnealingLevel(0.06, 900, 8, 1.0),
    AnnealingLevel(0.035, 1400, 5, 0.8),
    AnnealingLevel(0.02, 1400, 9, 0.5),
)


@dataclass(frozen=True, eq=False)
class Fit:
    """A template in the scan.

    Attributes:
        parameters: (7,).
        energy: Twice the negative logarithm of the likelihood, up to a constant.
    """

    parameters: Array
    energy: float


def refined(
    template: Template,
    evidence: Evidence,
    around: Surroundings,
    prior: PoseHypothesis,
    parameters: Array,
    schedule: Sequence[AnnealingLevel],
) -> Fit:
    """Refine a pose by Gauss-Newton steps.

    Args:
        template: The CAD.
        evidence: The points.
        around: Support, walls and visibility.
        prior: Of the pose.
        parameters: (7,) initial pose.
        schedule: Annealing levels.
    """
    for level in schedule:
        part, scan = template.part(level.points), evidence.part(level.points)
        weights, hidden = _seen(part, around, parameters)
        velocity = np.zeros(7)
        for _ in range(level.steps):
            system = _system(
                template, part, evidence, scan, around, prior, parameters, level, weights, hidden
            )
            # ICP converges slowly where surfaces slide along each other: momentum speeds it up.
            velocity = _step(system) + _STEP_MOMENTUM * velocity
            parameters = prior.bounded(parameters + velocity)
    return Fit(parameters, energy(template, evidence, around, prior, parameters, schedule[-1]))


def energy(
    template: Template,
    evidence: Evidence,
    around: Surroundings,
    prior: PoseHypothesis,
    parameters: Array,
    level: AnnealingLevel,
) -> float:
    """The energy of a pose at an annealing level."""
    part, scan = template.part(level.points), evidence.part(level.points)
    weights, hidden = _seen(part, around, parameters)
    terms = _residuals(template, part, evidence, scan, parameters, level, weights)
    surfaces = sum(pairs.energy(each, level.width) for pairs, each in terms)
    contacts = around.rows(part, parameters, hidden).energy
    return surfaces + contacts + prior.rows(parameters).energy


def _step(system: System) -> Array:
    """A damped Gauss-Newton step."""
    damped = system.matrix + np.diag(1e-3 * np.diag(system.matrix) + 1e-9)
    step = np.linalg.solve(damped, -system.vector)
    return np.asarray(step * min(1.0, float((_MAX_STEP / np.maximum(np.abs(step), 1e-12)).min())))


def _seen(
    template: Template, around: Surroundings, parameters: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """(N,) weights of a template's points by visibility, and (4,) its hidden sides."""
    places = posed(template.points, parameters)
    # Near the support, its points cannot be distinguished from the support's.
    foot = min(
        _SUPPORT_REACH_M, _MAX_SUPPORT_SHARE * float(template.size[2] * np.exp(parameters[6]))
    )
    clear = places[:, 2] > (-np.inf if around.support is None else around.support + foot)
    if around.panoramas is None:
        return _UNKNOWN_WEIGHT * clear.astype(np.float64), np.zeros(4, dtype=np.bool_)
    visible = around.panoramas.visible(
        places, directions(template.normals, parameters), template.two_sided
    )
    return _SEEN_WEIGHT * (visible & clear).astype(np.float64), hidden_sides(template, visible)


def _system(
    whole: Template,
    template: Template,
    evidence: Evidence,
    scan: Array,
    around: Surroundings,
    prior: PoseHypothesis,
    parameters: Array,
    level: AnnealingLevel,
    weights: Array,
    hidden: NDArray[np.bool_],
) -> System:
    """Normal equations of all terms about a pose."""
    terms = _residuals(whole, template, evidence, scan, parameters, level, weights)
    first, second = (pairs.robust(each, level.width) for pairs, each in terms)
    contacts = around.rows(template, parameters, hidden)
    before = prior.rows(parameters)
    return System(
        first.matrix + second.matrix + contacts.slope.T @ contacts.slope + before.matrix,
        first.vector + second.vector + contacts.slope.T @ contacts.residual + before.vector,
        first.energy + second.energy + contacts.energy + before.energy,
    )


def _residuals(
    whole: Template,
    template: Template,
    evidence: Evidence,
    scan: Array,
    parameters: Array,
    level: AnnealingLevel,
    weights: Array,
) -> tuple[tuple[Pairs, Array], tuple[Pairs, Array]]:
    """Correspondences from points to the CAD and from its visible surface, with their weights."""
    # Nearest neighbours in all points: those in a sample may be on another surface of the CAD.
    _, nearest = whole.tree.query(unposed(scan, parameters))
    one = paired(
        whole.points[nearest],
        whole.normals[nearest],
        scan,
        level.disc * template.spacing,
        parameters,
    )
    used = weights > 0.0
    places = posed(template.points[used], parameters)
    _, there = evidence.tree.query(places)
    other = paired(
        template.points[used],
        template.normals[used],
        evidence.points[there],
        level.disc * evidence.spacing,
        parameters,
    )
    scale = _INDEPENDENT_DISTANCES / _DISTANCE_SIGMA_M**2
    return (
        (one, np.full(len(scan), scale / len(scan))),
        (other, scale / len(weights) * weights[used]),
    )
