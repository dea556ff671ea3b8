"""Curves of pieces, and B-splines, as weights of their control points."""

from itertools import pairwise
from typing import Final

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.cages import matrix

# A cubic piece, or what lies between two knots, is drawn by at least so many lines.
LINES: Final = 6
_MOST_LINES: Final = 96

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


def spans(
    knots: Array, order: int, count: int, reach: Array | None, lines: Ints | None = None
) -> csr_array:
    """(S, count) what each control point weighs along a B-spline.

    Args:
        knots: (count + order,) as USD has them.
        order: Its degree and one.
        count: Control points.
        reach: From where to where; None for all of it.
        lines: Of what lies between each two knots; None for `LINES`.

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
    if lines is None:
        lines = np.full(len(inner) - 1, 1 if order == 2 else LINES)
    ways = zip(pairwise(inner), lines.tolist(), strict=True)
    at = np.unique(np.concatenate([np.linspace(a, b, steps + 1) for (a, b), steps in ways]))
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


def sampled(pieces: Ints, closed: bool, lines: Ints | None = None) -> tuple[Ints, Array, Ints]:
    """(S,) the piece of each point of the polylines and the way along it, and points of each.

    Args:
        pieces: (C,) of each curve.
        closed: Whether each ends where it begins.
        lines: (P,) of each piece; None for `LINES`.
    """
    if lines is None:
        lines = np.full(pieces.sum(), LINES)
    place = np.repeat(np.arange(len(lines)), lines)
    way = (np.arange(len(place)) - np.repeat(np.cumsum(lines) - lines, lines)) / lines[place]
    ends = np.cumsum(lines)[np.cumsum(pieces) - 1]
    counts = np.diff(ends, prepend=0)
    if closed:
        return place, way, counts
    # The last piece of each goes to its end.
    place = np.insert(place, ends, np.cumsum(pieces) - 1)
    return place, np.insert(way, ends, 1.0), counts + 1


def lines_needed(points: Array, slack: Array, pieces: Ints, closed: bool) -> Ints:
    """(P,) how many lines each piece needs so that no chord is farther off than its slack.

    A chord over a step h of a curve is off by at most h^2 / 8 times its second derivative, which
    the second differences of points on it tell; that of a cubic is linear along a piece.

    Args:
        points: (S, 3) of all pieces by `LINES` lines each.
        slack: (S,) how far off a chord may be there; of a piece the largest counts.
        pieces: (C,) of each curve.
        closed: Whether each ends where it begins.
    """
    starts = np.arange(pieces.sum()) * LINES
    if not closed:
        starts += np.repeat(np.arange(len(pieces)), pieces)
    rows = starts[:, None] + np.arange(LINES)
    bends = points[rows[:, :-2]] - 2.0 * points[rows[:, 1:-1]] + points[rows[:, 2:]]
    lengths = np.linalg.norm(bends, axis=2)
    # Half a difference of the two beyond either end.
    steepest = lengths.max(axis=1) + np.linalg.norm(bends[:, -1] - bends[:, 0], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        wanted = LINES * np.sqrt(steepest / (8.0 * slack[rows].max(axis=1)))
    wanted = np.nan_to_num(wanted, nan=0.0, posinf=_MOST_LINES)
    return np.asarray(np.ceil(np.clip(wanted, LINES, _MOST_LINES)), dtype=np.int64)


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
