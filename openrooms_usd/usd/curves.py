"""Curve prims as tubes, or as ribbons where they have normals."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom
from scipy.sparse import block_diag, csr_array

from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.splines import (
    BASES,
    HERMITE,
    LINE,
    identity,
    rational,
    sampled,
    spans,
    weighted,
)
from openrooms_usd.geometry.strands import Strands, ribbons, tubes
from openrooms_usd.usd.arrays import integers, numbers
from openrooms_usd.usd.frames import TIME

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

# Sides of a tube; of many curves fewer, since they are hair or grass.
_SIDES: Final = 12
_FEW_SIDES: Final = 4
_MANY_CURVES: Final = 500
# Of curves that do not say how thick they are: as in Hydra, in units of the stage.
_WIDTH: Final = 1.0

_T: Final = UsdGeom.Tokens


@dataclass(frozen=True, eq=False)
class Sampling:
    """Where polylines get their points from.

    Attributes:
        vertex: (S, N) what each control point weighs in each point of the polylines.
        varying: (S, V) likewise, of values at the ends of pieces.
        counts: (C,) points of each polyline.
    """

    vertex: csr_array
    varying: csr_array
    counts: Ints

    def along(self, values: Array, interpolation: str) -> Array:
        """(S, ...) a primvar's values along the polylines.

        Raises:
            ValueError: There are too few or too many of them.
        """
        curve = np.repeat(np.arange(len(self.counts)), self.counts)
        rows = {_T.constant: 1, _T.uniform: len(self.counts), _T.vertex: self.vertex.shape[1],
                _T.varying: self.varying.shape[1]}  # fmt: skip
        if rows.get(interpolation) != len(values):
            raise ValueError(f"{len(values)} values do not fit {interpolation} interpolation")
        if interpolation == _T.constant:
            return np.repeat(values, len(curve), axis=0)
        if interpolation == _T.uniform:
            return np.asarray(values[curve])
        return np.asarray((self.vertex if interpolation == _T.vertex else self.varying) @ values)


def read_curves(prim: Usd.Prim) -> tuple[Mesh | None, list[str]]:
    """The surface of a prim of curves, and what was approximated; without one the reason.

    Args:
        prim: A ``BasisCurves``, ``NurbsCurves`` or ``HermiteCurves``.
    """
    curves = UsdGeom.Curves(prim)
    points = numbers(curves.GetPointsAttr(), 3)
    counts = integers(curves.GetCurveVertexCountsAttr())
    try:
        if not len(counts) or counts.min() < 2 or counts.sum() != len(points):
            raise ValueError("curveVertexCounts do not add up to the number of points")
        closed = False
        if prim.IsA(UsdGeom.BasisCurves):
            sampling, closed = _basis(UsdGeom.BasisCurves(prim), counts)
            places = sampling.vertex @ points
        elif prim.IsA(UsdGeom.NurbsCurves):
            sampling = _nurbs(UsdGeom.NurbsCurves(prim), counts)
            places = sampling.vertex @ points
        else:
            tangents = numbers(UsdGeom.HermiteCurves(prim).GetTangentsAttr(), 3)
            if len(tangents) != len(points):
                raise ValueError("there are not as many tangents as points")
            sampling, bent = _hermite(counts)
            places = bent @ np.concatenate([points, tangents])
        widths, losses = _widths(curves, sampling)
        normals = numbers(curves.GetNormalsAttr(), 3)
        facing = None
        if len(normals):
            facing = sampling.along(normals, curves.GetNormalsInterpolation())
    except ValueError as reason:
        return None, [str(reason)]
    if not np.isfinite(places).all() or not np.isfinite(widths).all():
        return None, ["points or widths hold NaN or infinity"]
    strands = Strands(places, np.maximum(widths, 0.0), sampling.counts, closed)
    if facing is not None:
        return ribbons(strands, facing), losses
    sides = _FEW_SIDES if len(counts) > _MANY_CURVES else _SIDES
    return tubes(strands, sides), [*losses, f"curves are drawn as tubes with {sides} sides"]


def _widths(curves: UsdGeom.Curves, sampling: Sampling) -> tuple[Array, list[str]]:
    found = numbers(curves.GetWidthsAttr())
    if not len(found):
        return np.full(sampling.counts.sum(), _WIDTH), [f"it has no widths: taken as {_WIDTH:g}"]
    return sampling.along(found, curves.GetWidthsInterpolation()), []


def _basis(curves: UsdGeom.BasisCurves, counts: Ints) -> tuple[Sampling, bool]:
    """Pieces of four points each; linear ones are their points."""
    basis, wrap = str(curves.GetBasisAttr().Get(TIME)), str(curves.GetWrapAttr().Get(TIME))
    closed, number = wrap == _T.periodic, int(counts.sum())
    if curves.GetTypeAttr().Get(TIME) == _T.linear:
        same = identity(number)
        return Sampling(same, same, counts), closed
    if basis not in BASES:
        raise ValueError(f"the basis {basis} is not known")
    step = 3 if basis == "bezier" else 1
    ends = identity(number)
    if wrap == _T.pinned and step == 1:
        # One more point at each end, as far beyond as the next is before: the curve begins there.
        ends, counts = _extended(counts), counts + 2
    pieces = counts // step if closed else (counts - 4) // step + 1
    left = counts % step if closed else (counts - 4) % step
    if (pieces < 1).any() or left.any():
        raise ValueError(f"curveVertexCounts do not fit {wrap} {basis} curves")
    curve = np.repeat(np.arange(len(counts)), pieces)
    first = (np.cumsum(pieces) - pieces)[curve]
    local = (np.arange(len(curve)) - first)[:, None] * step + np.arange(4)
    rows = (np.cumsum(counts) - counts)[curve][:, None] + local % counts[curve][:, None]
    places, along, lines = sampled(pieces, closed)
    vertex = weighted(places, along, BASES[basis], rows, int(counts.sum()))
    # Values at the ends of pieces: one more than pieces, of a ring as many.
    shown = pieces if closed else pieces + 1
    start = (np.cumsum(shown) - shown)[curve]
    one = np.arange(len(curve)) - first
    two = (one + 1) % shown[curve]
    pair = np.stack([start + one, start + two], axis=1)
    varying = weighted(places, along, LINE, pair, int(shown.sum()))
    return Sampling(csr_array(vertex @ ends), varying, lines), closed


def _nurbs(curves: UsdGeom.NurbsCurves, counts: Ints) -> Sampling:
    orders = integers(curves.GetOrderAttr())
    knots, ranges = numbers(curves.GetKnotsAttr()), numbers(curves.GetRangesAttr(), 2)
    weights = numbers(curves.GetPointWeightsAttr())
    if len(orders) != len(counts) or (counts + orders).sum() != len(knots):
        raise ValueError("order or knots do not fit curveVertexCounts")
    if len(weights) not in (0, counts.sum()) or len(ranges) not in (0, len(counts)):
        raise ValueError("pointWeights or ranges do not fit curveVertexCounts")
    found, at = [], 0
    for number, (count, order) in enumerate(zip(counts, orders, strict=True)):
        own = knots[at : at + count + order]
        at += count + order
        reach = ranges[number] if len(ranges) else None
        found.append(spans(own, int(order), int(count), reach))
    vertex = csr_array(block_diag(found))
    if len(weights):
        vertex = rational(vertex, weights)
    lines = np.array([one.shape[0] for one in found])
    return Sampling(vertex, identity(int(lines.sum())), lines)


def _hermite(counts: Ints) -> tuple[Sampling, csr_array]:
    """Weights along the lines between points, and of points, then tangents, along the curves."""
    pieces, number = counts - 1, int(counts.sum())
    curve = np.repeat(np.arange(len(counts)), pieces)
    first = np.arange(len(curve)) + curve
    places, along, lines = sampled(pieces, False)
    pair = np.stack([first, first + 1], axis=1)
    straight = weighted(places, along, LINE, pair, number)
    bent = weighted(places, along, HERMITE, np.hstack([pair, pair + number]), 2 * number)
    return Sampling(straight, straight, lines), bent


def _extended(counts: Ints) -> csr_array:
    """(N + 2 C, N) the points of open curves, with 2 a - b beyond both ends of each."""
    blocks: list[Any] = []
    for count in counts:
        block = np.zeros((count + 2, count))
        block[1:-1] = np.eye(count)
        block[0, :2], block[-1, -2:] = (2.0, -1.0), (-1.0, 2.0)
        blocks.append(csr_array(block))
    return csr_array(block_diag(blocks))
