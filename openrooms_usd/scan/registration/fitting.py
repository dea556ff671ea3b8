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

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.scan.registration.evidence import Evidence
from openrooms_usd.scan.registration.priors import Pairs, PoseHypothesis, System, paired
from openrooms_usd.scan.registration.surroundings import ObjectSurroundings, hidden_sides
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
    around: ObjectSurroundings,
    priors: Sequence[PoseHypothesis],
    parameters: Array,
    schedule: Sequence[AnnealingLevel],
) -> list[Fit]:
    """Refine poses by Gauss-Newton steps: several at once, as each step of one is little work.

    Args:
        template: The CAD.
        evidence: The points.
        around: Support, walls and visibility.
        priors: Of each pose.
        parameters: (B, 7) initial poses.
        schedule: Annealing levels.
    """
    for level in schedule:
        seen = _Seen.of(template, evidence, around, parameters, level)
        velocity = np.zeros_like(parameters)
        for _ in range(level.steps):
            # ICP converges slowly where surfaces slide along each other: momentum speeds it up.
            velocity = _step(seen.system(around, priors, parameters)) + _STEP_MOMENTUM * velocity
            moved = parameters + velocity
            parameters = np.stack(
                [prior.bounded(each) for prior, each in zip(priors, moved, strict=True)]
            )
    costs = energies(template, evidence, around, priors, parameters, schedule[-1])
    return [Fit(each, float(cost)) for each, cost in zip(parameters, costs, strict=True)]


def energies(
    template: Template,
    evidence: Evidence,
    around: ObjectSurroundings,
    priors: Sequence[PoseHypothesis],
    parameters: Array,
    level: AnnealingLevel,
) -> Array:
    """(B,) the energies of poses (B, 7) with their priors at an annealing level."""
    seen = _Seen.of(template, evidence, around, parameters, level)
    surfaces = sum(pairs.energy(w, level.width) for pairs, w in seen.pairs(parameters))
    others = [
        around.rows(seen.part, each, hidden).energy + prior.energy(each)
        for prior, each, hidden in zip(priors, parameters, seen.hidden, strict=True)
    ]
    return np.asarray(surfaces + np.array(others))


def _step(system: System) -> Array:
    """(B, 7) damped Gauss-Newton steps."""
    diagonal = np.einsum("...ii->...i", system.matrix)
    damped = system.matrix + np.eye(7) * (1e-3 * diagonal + 1e-9)[:, None]
    step = np.linalg.solve(damped, -system.vector[..., None])[..., 0]
    share = (_MAX_STEP / np.maximum(np.abs(step), 1e-12)).min(axis=-1, keepdims=True)
    return np.asarray(step * np.minimum(1.0, share))


@dataclass(frozen=True, eq=False)
class _Seen:
    """Samples of either side at an annealing level, and what of the CAD is visible in B poses.

    Attributes:
        whole: The CAD.
        evidence: The points.
        level: The annealing level.
        part: A sample of the CAD.
        scan: (S, 3) a sample of the points.
        rows: (B, M) visible points of ``part``; those that have fewer repeat one.
        weights: (B, M) of these; 0 where they repeat.
        hidden: (B, 4) the sides of the CAD that are hidden.
    """

    whole: Template
    evidence: Evidence
    level: AnnealingLevel
    part: Template
    scan: Array
    rows: NDArray[np.intp]
    weights: Array
    hidden: Mask

    @classmethod
    def of(
        cls,
        whole: Template,
        evidence: Evidence,
        around: ObjectSurroundings,
        parameters: Array,
        level: AnnealingLevel,
    ) -> "_Seen":
        part, scan = whole.part(level.points), evidence.part(level.points)
        places = posed(part.points, parameters)
        # Near the support, its points cannot be distinguished from the support's.
        heights = part.size[2] * np.exp(parameters[:, None, 6])
        foot = np.minimum(_SUPPORT_REACH_M, _MAX_SUPPORT_SHARE * heights)
        used = places[..., 2] > (-np.inf if around.support is None else around.support + foot)
        hidden = np.zeros((len(parameters), 4), dtype=np.bool_)
        weight = _UNKNOWN_WEIGHT
        if around.panoramas is not None:
            weight = _SEEN_WEIGHT
            normals = directions(part.normals, parameters).reshape(-1, 3)
            two_sided = np.tile(part.two_sided, len(parameters))
            visible = around.panoramas.visible(places.reshape(-1, 3), normals, two_sided)
            visible = visible.reshape(used.shape)
            used &= visible
            hidden = hidden_sides(part, visible)
        counts = used.sum(axis=1)
        rows = np.argsort(~used, axis=1, kind="stable")[:, : counts.max()]
        real = np.arange(rows.shape[1]) < counts[:, None]
        rows = np.where(real, rows, rows[:, :1])
        return cls(whole, evidence, level, part, scan, rows, weight * real, hidden)

    def pairs(self, parameters: Array) -> tuple[tuple[Pairs, Array], tuple[Pairs, Array]]:
        """Correspondences from points to the CAD and from its visible surface, with weights."""
        # Nearest neighbours in all points: those in a sample may be on another surface of the CAD.
        _, nearest = self.whole.tree.query(unposed(self.scan, parameters))
        disc, scale = self.level.disc, _INDEPENDENT_DISTANCES / _DISTANCE_SIGMA_M**2
        points, normals = self.whole.points[nearest], self.whole.normals[nearest]
        one = paired(points, normals, self.scan, disc * self.part.spacing, parameters)
        points, normals = self.part.points[self.rows], self.part.normals[self.rows]
        _, nearest = self.evidence.tree.query(posed(points, parameters))
        there = self.evidence.points[nearest]
        other = paired(points, normals, there, disc * self.evidence.spacing, parameters)
        return (
            (one, np.full(one.height.shape, scale / len(self.scan))),
            (other, scale / len(self.part.points) * self.weights),
        )

    def system(
        self, around: ObjectSurroundings, priors: Sequence[PoseHypothesis], parameters: Array
    ) -> System:
        """Normal equations of all terms about the poses."""
        first, second = (pairs.robust(w, self.level.width) for pairs, w in self.pairs(parameters))
        matrix, vector = first.matrix + second.matrix, first.vector + second.vector
        for row, (prior, each) in enumerate(zip(priors, parameters, strict=True)):
            contacts, before = around.rows(self.part, each, self.hidden[row]), prior.system(each)
            matrix[row] += contacts.slope.T @ contacts.slope + before.matrix
            vector[row] += contacts.slope.T @ contacts.residual + before.vector
        return System(matrix, vector)
