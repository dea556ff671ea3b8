"""How likely a proposal is an opening: weighed evidence, as probabilities that hold.

Each kind of proposal has a table of evidence, and a logistic sum of it is the probability. The
weights are a ridge fit to proposals in simulated and real scans with known openings. None is
negative, so that evidence never speaks for the opposite; holes, views behind and free ways have a
least weight by reason. A scan that is left out of the fit is judged nearly as well as the others.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.scan.openings.wallholes import Proposal

# Part of a doorway through which something is seen far behind where it is surely open.
_OPEN_VIEW_SHARE: Final = 0.7
# Higher and wider doors are unusual, and by so much the heads of usual ones differ, metres.
_TALL_DOOR_M: Final = 2.35
_WIDE_DOOR_M: Final = 1.8
_USUAL_HEAD_M, _HEAD_RANGE_M, _MOST_RANGES = 2.05, 0.2, 1.5
# Windows smaller than the first area, with sills above the second range of heights, or as near to
# the ceiling as the third, are less likely; square metres and metres.
_USUAL_WINDOW_M2: Final = 0.8
_HIGH_SILLS_M: Final = (1.6, 2.4)
_MOST_HIGH: Final = 2.0
_UNDER_CEILING_M: Final = 0.15
_SMALL_WINDOW_M: Final = 0.4
# A hole of which so much is one and is framed by wall is a clean one.
_CLEAN_SHARES: Final = (0.65, 0.9)

Measure = Callable[[Proposal], float]


@dataclass(frozen=True)
class Evidence:
    """Evidence from 0 to about 1, and what it adds to the log odds."""

    measure: Measure
    weight: float


def _passed(p: Proposal) -> float:
    return max(p.threshold, min(1.0, p.beyond / _OPEN_VIEW_SHARE))


def _vast(p: Proposal) -> float:
    return -float(p.width > _WIDE_DOOR_M or p.height > _TALL_DOOR_M)


def _unusual_head(p: Proposal) -> float:
    return min(_MOST_RANGES, abs(p.height - _USUAL_HEAD_M) / _HEAD_RANGE_M)


def _high(p: Proposal) -> float:
    low, high = _HIGH_SILLS_M
    return float(np.clip((p.sill - low) / (high - low), 0.0, _MOST_HIGH))


def _clean(p: Proposal) -> float:
    low, high = _CLEAN_SHARES
    return float(np.clip((p.framed * p.hole - low) / (high - low), 0.0, 1.0))


DOORWAY: Final[Mapping[str, Evidence]] = {
    "a hole": Evidence(lambda p: p.hole, 3.00),
    "wall on every side": Evidence(lambda p: p.framed, 2.38),
    "wall around": Evidence(lambda p: p.walled, 0.80),
    "floor or a view behind": Evidence(_passed, 1.00),
    "furniture around": Evidence(lambda p: -p.clutter, 1.67),
    "furniture before it": Evidence(lambda p: -p.blocked * (1.0 - _passed(p)), 2.00),
    "larger than a double door": Evidence(_vast, 1.95),
}
CLOSED_DOOR: Final[Mapping[str, Evidence]] = {
    "a frame": Evidence(lambda p: p.leaf, 1.02),
    "wall on every side": Evidence(lambda p: p.framed, 1.75),
    "wall around": Evidence(lambda p: p.walled, 0.73),
    "open, with a view behind": Evidence(lambda p: p.hole * _passed(p), 1.54),
    "furniture around": Evidence(lambda p: -p.clutter, 0.87),
    "furniture before a closed leaf": Evidence(lambda p: -p.blocked * p.solid, 3.95),
    "unusual height": Evidence(lambda p: -_unusual_head(p), 1.46),
}
WINDOW: Final[Mapping[str, Evidence]] = {
    "a hole": Evidence(lambda p: p.hole, 3.00),
    "wall on every side": Evidence(lambda p: p.framed, 2.29),
    "wall around": Evidence(lambda p: p.walled, 2.21),
    "clean": Evidence(_clean, 1.93),
    "furniture around": Evidence(lambda p: -p.clutter, 1.53),
    "large": Evidence(lambda p: min(1.0, p.width * p.height / _USUAL_WINDOW_M2), 3.48),
    "high above the floor": Evidence(lambda p: -_high(p), 1.58),
    "under the ceiling": Evidence(lambda p: -float(p.headroom < _UNDER_CEILING_M), 1.42),
    "seen through": Evidence(lambda p: p.hole - p.recess, 0.51),
    "small": Evidence(lambda p: -float(min(p.width, p.height) < _SMALL_WINDOW_M), 2.06),
}
# Log odds without evidence.
_PRIORS: Final = {"doorway": -3.14, "closed door": -0.71, "window": -8.46}
_TABLES: Final = {"doorway": DOORWAY, "closed door": CLOSED_DOOR, "window": WINDOW}


def likelihood(proposal: Proposal) -> float:
    """The probability that a proposal is an opening, by what the wall shows without labels."""
    sort = "window" if proposal.kind == "window" else "closed door" if proposal.leaf else "doorway"
    odds = _PRIORS[sort] + sum(e.weight * e.measure(proposal) for e in _TABLES[sort].values())
    return float(1.0 / (1.0 + np.exp(-odds)))
