"""Curves of pieces, and B-splines, as weights of their control points."""

from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.sparse import csr_array

from openrooms_usd.geometry.cages import matrix

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

# A cubic piece, or what lies between two knots, is drawn by so many lines.
LINES: Final = 6

# Rows: what each of four points weighs, by the powers 0 to 3 of the way along a piece.
BASES: Final = {
    "bezier": np.array([[1, -3, 3, -1], [0, 3, -6, 3], [0, 0, 3, -3], [0, 0, 0, 1]], float),
    "bspline": np.array([[1, -3, 3, -1], [4, 0, -6, 3], [1, 3, 3, -3], [0, 0, 0, 1]], float) / 6,
    "catmullRom": np.array([[0, -1, 2, -1], [2, 0, -5, 3], [0, 1, 4, -3], [0, 0, -1, 1]], float)
    / 2,
}
# The same of a point, the next, and the tangents at both.
HERMITE: Final = np.array([[1, 0, -3, 2], [0, 0, 3, -2], [0, 1, -2, 1], [0, 0, -1, 1]], float)
# Of two points along a line.
LINE: Final = np.array([[1.0, -1.0], [0.0, 1.0]])


def spans(knots: Array, order: int, count: int, reach: Array | None) -> csr_array:
    """(S, count) what each control point weighs along a B-spline.

    Args:
        knots: (count + order,) as USD has them.
        order: Its degree and one.
        count: Control points.
        reach: From where to where; None for all of it.

    Raises:
        ValueError: Knots fall, or there are too few points.
    """
    if order < 2 or count < order or (np.diff(knots) < 0.0).any():
        raise ValueError("knots fall, or there are fewer points than the order")
    low, high = knots[order - 1], knots[count]
    if reach is not None:
        low, high = max(low, reach[0]), min(high, reach[1])
    if not low < high:
        raise ValueError("the range of its knots is empty")
    inner = np.unique(np.clip(knots, low, high))
    steps = 1 if order == 2 else LINES
    at = np.unique(np.concatenate([np.linspace(a, b, steps + 1) for a, b in pairwise(inner)]))
    return csr_array(BSpline.design_matrix(at, knots, order - 1))


def rational(weights: csr_array, own: Array) -> csr_array:
    """Weights of control points that have weights of their own.

    Raises:
        ValueError: They are not positive.
    """
    if not (own > 0.0).all():
        raise ValueError("pointWeights are not positive")
    scaled = weights.multiply(own[None, :])
    return csr_array(scaled.multiply(1.0 / scaled.sum(axis=1)[:, None]))


def sampled(pieces: Ints, closed: bool) -> tuple[Ints, Array, Ints]:
    """(S,) the piece of each point of the polylines and the way along it, and points of each."""
    place, way = (
        np.repeat(np.arange(pieces.sum()), LINES),
        np.tile(np.arange(LINES) / LINES, pieces.sum()),
    )
    if closed:
        return place, way, pieces * LINES
    # The last piece of each goes to its end.
    last = np.cumsum(pieces) * LINES
    place = np.insert(place, last, np.cumsum(pieces) - 1)
    return place, np.insert(way, last, 1.0), pieces * LINES + 1


def weighted(places: Ints, way: Array, basis: Array, rows: Ints, size: int) -> csr_array:
    """(S, size) the weights of a basis of polynomials along pieces of the points ``rows``."""
    powers = way[:, None] ** np.arange(basis.shape[1])
    values, columns = powers @ basis.T, rows[places]
    samples = np.repeat(np.arange(len(places)), rows.shape[1])
    return matrix(samples, columns.reshape(-1), values.reshape(-1), (len(places), size))


def identity(size: int) -> csr_array:
    """(size, size) what stays as it is."""
    rows = np.arange(size)
    return matrix(rows, rows, 1.0, (size, size))
