"""Curve prims as tubes, or as ribbons where they have normals."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from pxr import Usd, UsdGeom
from scipy.sparse import block_diag, csr_array

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry import splines
from openrooms_usd.geometry.strands import Strands, ribbons, tubes
from openrooms_usd.usd.arrays import integers, numbers
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.shapes.tessellation import Drawn

# Sides of a tube; of many curves fewer, since they are hair or grass.
_SIDES: Final = 12
_FEW_SIDES: Final = 4
_MANY_CURVES: Final = 500
# Of curves that do not say how thick they are: as in Hydra, in units of the stage.
_WIDTH: Final = 1.0
# How far off a chord may be, in radii.
_SLACK: Final = 0.05

_T: Final = UsdGeom.Tokens


@dataclass(frozen=True, eq=False)
class Sampling:
    """Where polylines get their points from.

    Attributes:
        vertex: (S, N) what each control point weighs in each point of the polylines.
        varying: (S, V) likewise, of values at the ends of pieces.
        counts: (C,) points of each polyline.
        curves: (C,) which curve each polyline is; None where each is.
        closed: Whether each polyline ends where it begins.
        pieces: (C,) how many pieces that bend each has; None where all are straight.
    """

    vertex: csr_array
    varying: csr_array
    counts: Ints
    curves: Ints | None = None
    closed: bool = False
    pieces: Ints | None = None

    def along(self, values: Array, interpolation: str) -> Array:
        """(S, ...) a primvar's values along the polylines; one alone is that of all of them.

        Raises:
            ValueError: There are too few or too many of them.
        """
        numbers = np.arange(len(self.counts)) if self.curves is None else self.curves
        curve = np.repeat(numbers, self.counts)
        if len(values) == 1:
            return np.repeat(values, len(curve), axis=0)
        if interpolation == _T.uniform and curve.max() < len(values):
            return np.asarray(values[curve])
        weights = {_T.vertex: self.vertex, _T.varying: self.varying}.get(interpolation)
        if weights is None or weights.shape[1] != len(values):
            raise ValueError(f"{len(values)} values do not fit {interpolation} interpolation")
        return np.asarray(weights @ values)


def read_curves(prim: Usd.Prim) -> Drawn:
    """The surface of a prim of curves.

    Args:
        prim: A ``BasisCurves``, ``NurbsCurves`` or ``HermiteCurves``.
    """
    curves = UsdGeom.Curves(prim)
    losses: list[str] = []
    try:
        sampling, places = _polylines(curves, losses)
        widths = _widths(curves, sampling, losses)
        if sampling.pieces is not None and np.isfinite(places).all():
            slack = _SLACK * 0.5 * widths
            lines = splines.lines_needed(places, slack, sampling.pieces, sampling.closed)
            if (lines > splines.LINES).any():
                each = np.split(lines, np.cumsum(sampling.pieces)[:-1])
                sampling, places = _polylines(curves, [], each)
                widths = _widths(curves, sampling, [])
    except ValueError as reason:
        return Drawn(None, [str(reason)])
    facing = _facing(curves, sampling, losses)
    if not np.isfinite(places).all() or not np.isfinite(widths).all():
        return Drawn(None, ["points or widths hold NaN or infinity"])
    strands = Strands(places, np.maximum(widths, 0.0), sampling.counts, sampling.closed)
    if facing is not None:
        return Drawn(ribbons(strands, facing), losses, sampling.along)
    many = len(sampling.counts) > _MANY_CURVES
    sides = _FEW_SIDES if many else _SIDES
    losses.append(f"curves are drawn as tubes with {sides} sides")
    return Drawn(tubes(strands, sides), losses, sampling.along)


def _polylines(
    curves: UsdGeom.Curves, losses: list[str], lines: list[Ints] | None = None
) -> tuple[Sampling, Array]:
    """Where polylines get their points from, and the points.

    Args:
        curves: The prim.
        losses: What was approximated is added.
        lines: Of each curve, for each of its pieces; None for the least.
    """
    prim = curves.GetPrim()
    points = numbers(curves.GetPointsAttr(), 3)
    counts = integers(curves.GetCurveVertexCountsAttr())
    least = 0 if prim.IsA(UsdGeom.BasisCurves) else 2
    if not len(counts) or counts.min() < least or counts.sum() != len(points):
        raise ValueError("curveVertexCounts do not add up to the number of points")
    together = None if lines is None else np.concatenate(lines)
    if prim.IsA(UsdGeom.HermiteCurves):
        tangents = numbers(UsdGeom.HermiteCurves(prim).GetTangentsAttr(), 3)
        if len(tangents) != len(points):
            raise ValueError("there are not as many tangents as points")
        sampling, bent = _hermite(counts, together)
        return sampling, bent @ np.concatenate([points, tangents])
    if prim.IsA(UsdGeom.BasisCurves):
        sampling = _basis(UsdGeom.BasisCurves(prim), counts, losses, together)
    else:
        sampling = _nurbs(UsdGeom.NurbsCurves(prim), counts, losses, lines)
    return sampling, sampling.vertex @ points


def _widths(curves: UsdGeom.Curves, sampling: Sampling, losses: list[str]) -> Array:
    found = numbers(curves.GetWidthsAttr())
    if not len(found):
        losses.append(f"it has no widths: {_WIDTH:g} is used")
        return np.full(sampling.counts.sum(), _WIDTH)
    try:
        return sampling.along(found, curves.GetWidthsInterpolation())
    except ValueError as reason:
        losses.append(f"widths: {reason}; their mean is used")
        return np.full(sampling.counts.sum(), found.mean())


def _facing(curves: UsdGeom.Curves, sampling: Sampling, losses: list[str]) -> Array | None:
    """(S, 3) where ribbons face; None of tubes."""
    normals = numbers(curves.GetNormalsAttr(), 3)
    if not len(normals):
        return None
    try:
        return sampling.along(normals, curves.GetNormalsInterpolation())
    except ValueError as reason:
        losses.append(f"normals: {reason}; they are left out")
        return None


def _basis(
    curves: UsdGeom.BasisCurves, counts: Ints, losses: list[str], lines: Ints | None
) -> Sampling:
    """Pieces of four points each; linear ones are their points."""
    basis, wrap = str(curves.GetBasisAttr().Get(TIME)), str(curves.GetWrapAttr().Get(TIME))
    closed, number = wrap == _T.periodic, int(counts.sum())
    linear = curves.GetTypeAttr().Get(TIME) == _T.linear
    if not linear and basis not in splines.BASES:
        raise ValueError(f"the basis {basis} is not known")
    step = 3 if basis == "bezier" and not linear else 1
    short = linear or (wrap == _T.pinned and step == 1)
    fitting = _fitting(counts, 2 if short else max(step, 2) if closed else 4, step)
    ends, which = splines.identity(number), None
    if (fitting != counts).any():
        kind = "linear" if linear else f"{wrap} {basis}"
        losses.append(f"curveVertexCounts do not fit {kind} curves: surplus points are dropped")
        firsts = np.cumsum(counts) - counts
        kept = [start + np.arange(many) for start, many in zip(firsts, fitting, strict=True)]
        ends, which = csr_array(ends[np.concatenate(kept)]), np.flatnonzero(fitting)
        counts = fitting[which]
        if not len(counts):
            raise ValueError("no curve has as many points as its basis needs")
    if linear:
        return Sampling(ends, ends, counts, which, closed)
    if wrap == _T.pinned and step == 1:
        # One more point at each end, as far beyond as the next is before: the curve begins there.
        ends, counts = csr_array(_extended(counts) @ ends), counts + 2
    pieces = counts // step if closed else (counts - 4) // step + 1
    curve = np.repeat(np.arange(len(counts)), pieces)
    first = (np.cumsum(pieces) - pieces)[curve]
    local = (np.arange(len(curve)) - first)[:, None] * step + np.arange(4)
    rows = (np.cumsum(counts) - counts)[curve][:, None] + local % counts[curve][:, None]
    places, along, drawn = splines.sampled(pieces, closed, lines)
    vertex = splines.weighted(places, along, splines.BASES[basis], rows, int(counts.sum()))
    # Values at the ends of pieces: one more than pieces, of a ring as many.
    shown = pieces if closed else pieces + 1
    start = (np.cumsum(shown) - shown)[curve]
    one = np.arange(len(curve)) - first
    two = (one + 1) % shown[curve]
    pair = np.stack([start + one, start + two], axis=1)
    varying = splines.weighted(places, along, splines.LINE, pair, int(shown.sum()))
    return Sampling(csr_array(vertex @ ends), varying, drawn, which, closed, pieces)


def _fitting(counts: Ints, least: int, step: int) -> Ints:
    """(C,) how many points of each curve are whole pieces; none of those that are too few."""
    whole = least + (counts - least) // step * step
    return np.asarray(np.where(counts < least, 0, whole))


def _nurbs(
    curves: UsdGeom.NurbsCurves, counts: Ints, losses: list[str], lines: list[Ints] | None
) -> Sampling:
    orders = integers(curves.GetOrderAttr())
    knots, ranges = numbers(curves.GetKnotsAttr()), numbers(curves.GetRangesAttr(), 2)
    weights = numbers(curves.GetPointWeightsAttr())
    if len(orders) != len(counts) or (counts + orders).sum() != len(knots):
        losses.append("order or knots do not fit curveVertexCounts: straight through its points")
        return Sampling(
            splines.identity(int(counts.sum())), splines.identity(int(counts.sum())), counts
        )
    if len(weights) not in (0, counts.sum()) or len(ranges) not in (0, len(counts)):
        raise ValueError("pointWeights or ranges do not fit curveVertexCounts")
    found, at = [], 0
    for number, (count, order) in enumerate(zip(counts, orders, strict=True)):
        own = knots[at : at + count + order]
        at += count + order
        reach = ranges[number] if len(ranges) else None
        some = None if lines is None else lines[number]
        found.append(splines.spans(own, int(order), int(count), reach, some))
    vertex = csr_array(block_diag(found))
    if len(weights):
        vertex = splines.rational(vertex, weights)
    drawn = np.array([one.shape[0] for one in found])
    pieces = (drawn - 1) // splines.LINES if (orders > 2).all() else None
    return Sampling(vertex, splines.identity(int(drawn.sum())), drawn, pieces=pieces)


def _hermite(counts: Ints, lines: Ints | None) -> tuple[Sampling, csr_array]:
    """Weights along the lines between points, and of points, then tangents, along the curves."""
    pieces, number = counts - 1, int(counts.sum())
    curve = np.repeat(np.arange(len(counts)), pieces)
    first = np.arange(len(curve)) + curve
    places, along, drawn = splines.sampled(pieces, False, lines)
    pair = np.stack([first, first + 1], axis=1)
    straight = splines.weighted(places, along, splines.LINE, pair, number)
    bent = splines.weighted(
        places, along, splines.HERMITE, np.hstack([pair, pair + number]), 2 * number
    )
    return Sampling(straight, straight, drawn, pieces=pieces), bent


def _extended(counts: Ints) -> csr_array:
    """(N + 2 C, N) the points of open curves, with 2 a - b beyond both ends of each."""
    blocks: list[Any] = []
    for count in counts:
        block = np.zeros((count + 2, count))
        block[1:-1] = np.eye(count)
        block[0, :2], block[-1, -2:] = (2.0, -1.0), (-1.0, 2.0)
        blocks.append(csr_array(block))
    return csr_array(block_diag(blocks))
