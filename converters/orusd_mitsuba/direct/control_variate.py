"""Straight light of less noise, where what would arrive without occlusion is known exactly."""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array

PLANES_PER_LIGHT: Final = 4
"""Pictures of each light that a pass gives: occluded, unoccluded, closed form, moments."""

# Relative variance that single precision cannot tell from none.
_LEAST_RELATIVE_VARIANCE: Final = 1e-5


def finish(planes: Array) -> dict[str, Array]:
    """The channels of every light from the means of passes.

    Visibility is a ratio of two means over the same samples. Occluded light is the mean itself.
    Where there is a closed form, a control variate lowers its noise: the samples' estimate of
    unoccluded light differs from the truth. A part of that difference is subtracted, by linear
    regression over the samples of the pixel (Lavenberg and Welch 1981). Where all is seen or
    nothing, the result is exact. Both are biased by what falls with the number of samples; of a
    single one nothing can be said.

    Args:
        planes: (4 L, height, width, 3) what a `DirectIntegrator` gives: all lights occluded, all
            unoccluded, all in closed form or -1, and the moments that the regression needs;
            ``planes[i::L]`` are those of one light.

    Returns:
        (L, height, width, 3) each: ``direct_i`` and ``unoccluded_i``, lux, and ``visibility_i``.
    """
    occluded, unoccluded, closed, moments = np.split(
        np.asarray(planes, dtype=np.float64), PLANES_PER_LIGHT
    )
    known = closed >= 0.0
    whole = np.where(known, closed, unoccluded)
    ratio = np.divide(occluded, unoccluded, out=np.zeros_like(occluded), where=unoccluded > 0.0)
    seen = np.where(whole > 0.0, np.clip(ratio, 0.0, 1.0), 0.0)
    varied = _slope(occluded[..., 1:2], unoccluded[..., 1:2], moments, seen[..., 1:2])
    better = np.clip(occluded + varied * (closed - unoccluded), 0.0, closed)
    return {
        "direct_i": np.where(known, better, occluded),
        "unoccluded_i": whole,
        "visibility_i": seen,
    }


def _slope(occluded: Array, unoccluded: Array, moments: Array, seen: Array) -> Array:
    """How occluded light goes with unoccluded over the samples of a pixel, from 0 to 1."""
    variance = moments[..., :1] - unoccluded**2
    common = moments[..., 1:2] - occluded * unoccluded
    # Where all samples are alike they tell nothing but how much is seen.
    told = variance > _LEAST_RELATIVE_VARIANCE * unoccluded**2
    slope = np.divide(common, variance, out=seen.copy(), where=told)
    return np.asarray(np.clip(slope, 0.0, 1.0))
