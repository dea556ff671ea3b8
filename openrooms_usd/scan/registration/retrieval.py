"""Ranks CADs by similarity with an object's points, in proportions and a shape descriptor."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.models.cad import CadModel
from openrooms_usd.scan.registration.evidence import Evidence
from openrooms_usd.scan.registration.hints import Box

Array = NDArray[np.float64]

# Bins of the descriptor over distance from the vertical axis and height, relative to the box.
_RADIAL_BINS: Final = 6
_HEIGHT_BINS: Final = 10
# Log ratio of lengths that weighs as much as a wholly different descriptor.
_LENGTH_RATIO_LOG: Final = 0.5


def ranked(
    models: Sequence[CadModel], uprights: Sequence[Array], evidence: Evidence, box: Box
) -> list[int]:
    """Rows of the models, the most similar first.

    Args:
        models: Candidates.
        uprights: (3, 3) of each, to Z up.
        evidence: The points of the object.
        box: Around the points.
    """
    base, size, _ = box.upright()
    seen = _descriptor(evidence.points - base, size)
    costs = [
        _unlike(model, upright, size, seen) for model, upright in zip(models, uprights, strict=True)
    ]
    return [int(row) for row in np.argsort(costs, kind="stable")]


def _unlike(model: CadModel, upright: Array, size: Array, seen: Array) -> float:
    low, high = np.sort(model.extent @ upright.T, axis=0)
    own = high - low
    # Proportions, plus a bounded penalty of the scale: a CAD may come without a unit.
    ratio = np.log(np.maximum(_level_sorted(own), 1e-9) / np.maximum(_level_sorted(size), 1e-9))
    lengths = float(np.abs(ratio - np.median(ratio)).mean() + min(abs(np.median(ratio)), 0.5))
    base = np.array([0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), low[2]])
    shape = _descriptor(model.surface.points @ upright.T - base, own)
    return lengths / _LENGTH_RATIO_LOG + float(np.abs(shape - seen).sum())


def _level_sorted(size: Array) -> Array:
    return np.array([*np.sort(size[:2]), size[2]])


def _descriptor(points: Array, size: Array) -> Array:
    """(R * L,) histogram of the surface over distance from the vertical axis and height.

    Invariant under rotations about the vertical.
    """
    radius = np.linalg.norm(points[:, :2], axis=1) / max(0.5 * float(np.hypot(*size[:2])), 1e-9)
    height = points[:, 2] / max(float(size[2]), 1e-9)
    ring = np.clip((radius * _RADIAL_BINS).astype(np.intp), 0, _RADIAL_BINS - 1)
    layer = np.clip((height * _HEIGHT_BINS).astype(np.intp), 0, _HEIGHT_BINS - 1)
    counts = np.bincount(layer * _RADIAL_BINS + ring, minlength=_RADIAL_BINS * _HEIGHT_BINS)
    return np.asarray(counts / max(len(points), 1))
