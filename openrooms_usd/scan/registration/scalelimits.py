"""How far a CAD may be scaled and still be the thing that it is.

A CAD of known size may be 0.6 to 1.6 times as long along each axis, one of unknown unit as much off
the proportions that it has. What the library builds has its own limits of size: a table may have
0.4 to 8 m, but not 5 cm.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.scan.models.cad import CadModel

if TYPE_CHECKING:
    from openrooms_usd.scan.registration.fitting import Fit
    from openrooms_usd.scan.registration.priors import PoseHypothesis
    from openrooms_usd.scan.registration.surroundings import ObjectSurroundings
    from openrooms_usd.scan.registration.template import Template

SCALES: Final = (0.6, 1.6)
"""The least and the greatest scale along an axis."""
CAD_UNITS_M: Final = (1.0, 0.001, 0.01, 0.0254)
"""The units that CADs are in."""


def sizes_of(model: CadModel, upright: Array, size: Array) -> Array:
    """(2, 3) the least and the greatest size of a CAD, upright, metres.

    Args:
        model: The CAD.
        upright: (3, 3) signed permutation from its axes to Z up.
        size: (3,) along its upright axes as it was measured, by which a unit is guessed, metres.
    """
    if model.sizes is not None:
        return model.sizes
    own = np.maximum(np.abs(upright) @ np.ptp(model.extent, axis=0), 1e-9)
    unit = model.unit or float(np.exp(np.median(np.log(np.maximum(size, 1e-9) / own))))
    return np.asarray(np.outer(SCALES, own * unit))


def turns_of(model: CadModel, upright: Array, size: Array) -> list[int]:
    """The quarter turns, 0 or 1, by which a CAD may have a size; the natural ones if there are any.

    The points of an object bound its size from below: how deep it is, is not known where only its
    front was seen. Which side is the front of people's own CADs is not known either.

    Args:
        model: The CAD.
        upright: (3, 3) signed permutation from its axes to Z up.
        size: (3,) metres.
    """
    possible = [turn for turn in (0, 1) if _may_be(model, upright, _turned(size, turn))]
    return [turn for turn in possible if _suits(model, _turned(size, turn))] or possible


def is_natural(model: CadModel, upright: Array, size: Array) -> bool:
    """Whether a size (3,) that a CAD may have is a usual one of its style, metres."""
    return any(_suits(model, _turned(size, turn)) for turn in turns_of(model, upright, size))


def _turned(size: Array, turn: int) -> Array:
    return size[[1, 0, 2]] if turn else size


def _suits(model: CadModel, size: Array) -> bool:
    width, depth, height = size.tolist()
    return model.suits is None or model.suits((width, depth, height))


def _may_be(model: CadModel, upright: Array, size: Array) -> bool:
    least, most = sizes_of(model, upright, size)
    deep = 1 if model.sizes is not None else int(np.argmin(size[:2]))
    seen = np.arange(3) != deep
    return bool((size <= most).all() and (size >= least)[seen].all())


# Chooses between free scales and the CADs' true size, jointly for all objects of a scan.
#
# Unseen sides leave the scale of one object ambiguous. But a collection of CADs is to scale or it
# is not: where well-seen objects have their true size, the others likely have it, too.

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

    template: "Template"
    hypothesis: "PoseHypothesis"
    around: "ObjectSurroundings"
    fit: "Fit"


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
