"""Fits a CAD to the points of an object: where it stands, how it is turned, and its scale.

Both ways between the points and the CAD count, truncated: from every point to the CAD, and from
what a scanner must have seen of the CAD to the points, which is what holds its silhouette and
keeps it out of space that was seen to be free. Kernels are narrowed step by step (graduated
non-convexity); the priors of start and contacts are least squares.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.registration.discs import System, paired
from openrooms_usd.scan.registration.evidence import Evidence
from openrooms_usd.scan.registration.priors import PoseHypothesis
from openrooms_usd.scan.registration.surroundings import Surroundings, hidden_sides
from openrooms_usd.scan.registration.template import Template, directions, posed, unposed

Array = NDArray[np.float64]

# Distances that are as likely as one standard deviation of the priors, metres, and how many
# independent ones the points of one object amount to.
_DISTANCE_SIGMA_M: Final = 0.02
_INDEPENDENT_DISTANCES: Final = 250.0
# Weight of what a scanner must have seen, against the points that it gave.
_SEEN_WEIGHT: Final = 0.7
# The same where it is not known what a scanner saw.
_UNKNOWN_WEIGHT: Final = 0.35
# How high a support reaches into the points of what stands on it, metres, and at most which share
# of its height.
_SUPPORT_REACH_M: Final = 0.04
_MAX_SUPPORT_SHARE: Final = 0.3
# How much of one step is taken again with the next one.
_STEP_MOMENTUM: Final = 0.6
# The farthest that one step goes: metres, radians, logarithm of scale.
_MAX_STEP: Final = np.array([0.06, 0.06, 0.06, 0.12, 0.06, 0.06, 0.06])


class AnnealingLevel(NamedTuple):
    """One step of narrowing.

    Attributes:
        width: Of the kernel, metres.
        points: Of each side.
        steps: How many.
        disc: Radius of the disc that a point stands for, over the spacing of points: wide ones let
            surfaces slide along each other, narrow ones hold their edges.
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
        energy: Half of it is the negative logarithm of how likely it is; for comparison only.
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
    """Improve a pose by Gauss-Newton steps.

    Args:
        template: What is fitted.
        evidence: To these points.
        around: What else it touches.
        prior: What is known before.
        parameters: (7,) where to begin.
        schedule: Widths of the kernel, narrowing.
    """
    for level in schedule:
        part, scan = template.part(level.points), evidence.part(level.points)
        weights, hidden = _seen(part, around, parameters)
        velocity = np.zeros(7)
        for _ in range(level.steps):
            system = _system(
                template, part, evidence, scan, around, prior, parameters, level, weights, hidden
            )
            # Nearest points hold surfaces back along themselves: what goes on is sped up.
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
    """How bad a pose is, as a level sees it."""
    part, scan = template.part(level.points), evidence.part(level.points)
    weights, hidden = _seen(part, around, parameters)
    return _system(
        template, part, evidence, scan, around, prior, parameters, level, weights, hidden
    ).energy


def _step(system: System) -> Array:
    """A damped Gauss-Newton step."""
    damped = system.matrix + np.diag(1e-3 * np.diag(system.matrix) + 1e-9)
    step = np.linalg.solve(damped, -system.vector)
    return np.asarray(step * min(1.0, float((_MAX_STEP / np.maximum(np.abs(step), 1e-12)).min())))


def _seen(
    template: Template, around: Surroundings, parameters: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """(N,) weights of the points of a template by what a scanner saw, and (4,) its hidden sides."""
    places = posed(template.points, parameters)
    # Where it stands, its points cannot be told from those of what is below it.
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
    # Among few points of a template the nearest may lie on another of its surfaces.
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
    first = one.robust(np.full(len(scan), scale / len(scan)), level.width)
    second = other.robust(scale / len(weights) * weights[used], level.width)
    contacts = around.rows(template, parameters, hidden)
    before = prior.rows(parameters)
    return System(
        first.matrix + second.matrix + contacts.slope.T @ contacts.slope + before.matrix,
        first.vector + second.vector + contacts.slope.T @ contacts.residual + before.vector,
        first.energy + second.energy + contacts.energy + before.energy,
    )
