"""Photograph, render, edges and difference of depth side by side, for people."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.comparison.edges import EdgeMap, EdgeMatch
from openrooms_usd.comparison.scandepth import DepthError
from openrooms_usd.rendering.color import quantize

Array = NDArray[np.float64]
Bytes = NDArray[np.uint8]

# Full colour of the difference of depth, metres.
_FULL_M: Final = 0.3
_MET: Final = (90, 230, 90)
_MISSED: Final = (255, 70, 200)
_UNKNOWN: Final = 40
# How much of the photograph stays below the edges.
_DIMMED: Final = 0.55


def edge_picture(photograph: Bytes, edges: EdgeMap, match: EdgeMatch | None) -> Bytes:
    """The render's edges over the photograph: green where the photograph has them, too."""
    from scipy.ndimage import binary_dilation

    picture = (_DIMMED * photograph.astype(np.float64)).astype(np.uint8)
    picture[binary_dilation(edges.mask)] = _MISSED
    if match is not None:
        picture[binary_dilation(match.met)] = _MET
    return picture


def depth_picture(rendered: Array, scanned: Array) -> Bytes:
    """Blue where the render is nearer than the scan, red where it is farther, white where alike."""
    both = (rendered > 0.0) & (scanned > 0.0)
    off = np.where(both, np.clip((rendered - scanned) / _FULL_M, -1.0, 1.0), 0.0)[..., None]
    farther = np.array([1.0, 0.25, 0.2])
    nearer = np.array([0.2, 0.4, 1.0])
    mixed = 1.0 + np.maximum(off, 0.0) * (farther - 1.0) + np.maximum(-off, 0.0) * (nearer - 1.0)
    picture = quantize(mixed)
    picture[~both] = _UNKNOWN
    return picture


def blank(size: tuple[int, int]) -> Bytes:
    """(H, W, 3) in place of a picture that is not there."""
    return np.full((size[1], size[0], 3), _UNKNOWN, np.uint8)


def edge_words(match: EdgeMatch | None) -> str:
    """The caption of the edges."""
    if match is None:
        return "edges of the render over the photograph"
    return f"edges: {match.share:.0%} meet (by chance {match.chance:.0%}), in green"


def depth_words(error: DepthError | None) -> str:
    """The caption of the difference of depth, in two lines."""
    if error is None:
        return "depth: nothing scanned here"
    return (
        f"depth off by {100 * error.median:.0f} cm (median)\n"
        f"{error.right:.0%} within 10 cm; blue nearer, red farther than the scan"
    )
