"""Many thin things at once: tubes and ribbons along polylines."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.vectors import unit


@dataclass(frozen=True, eq=False)
class Strands:
    """Polylines, each of at least two points.

    Attributes:
        points: (N, 3), strand by strand.
        widths: (N,) across, at each point.
        counts: (C,) points of each strand.
        closed: Whether the last point of each leads back to its first.
    """

    points: Array
    widths: Array
    counts: Ints
    closed: bool = False

    @cached_property
    def firsts(self) -> Ints:
        """(C,) the first point of each strand."""
        return np.cumsum(self.counts) - self.counts

    @cached_property
    def strand(self) -> Ints:
        """(N,) the strand of each point."""
        return np.repeat(np.arange(len(self.counts)), self.counts)

    @cached_property
    def after(self) -> Ints:
        """(N,) the next point of the same strand; of the last its own, or the first of a ring."""
        rows = np.arange(len(self.points))
        last = rows == (self.firsts + self.counts - 1)[self.strand]
        return np.where(last, self.firsts[self.strand] if self.closed else rows, rows + 1)

    @cached_property
    def before(self) -> Ints:
        """(N,) likewise, the point before."""
        rows = np.arange(len(self.points))
        first = rows == self.firsts[self.strand]
        ends = (self.firsts + self.counts - 1)[self.strand]
        return np.where(first, ends if self.closed else rows, rows - 1)

    @cached_property
    def tangents(self) -> Array:
        """(N, 3) unit, along the strands."""
        return unit(self.points[self.after] - self.points[self.before])


def tubes(strands: Strands, sides: int) -> Mesh:
    """Round tubes with smooth normals; flat ends, no ends of rings.

    Args:
        strands: Their axes and diameters.
        sides: Of each tube's section; it has the area of the circle.
    """
    across = _transported(strands)
    beside = np.cross(strands.tangents, across)
    turn = 2.0 * np.pi * np.arange(sides) / sides
    rays = np.cos(turn)[:, None] * across[:, None] + np.sin(turn)[:, None] * beside[:, None]
    # A polygon as large as the circle sticks out a little at its corners.
    radii = 0.5 * strands.widths * np.sqrt(turn[1] / np.sin(turn[1]))
    points = strands.points[:, None] + radii[:, None, None] * rays
    rows = np.flatnonzero(strands.after != np.arange(len(strands.points)))
    corner = np.arange(sides)
    following = (corner + 1) % sides
    one, other = rows[:, None] * sides, strands.after[rows][:, None] * sides
    walls = np.stack([one + corner, one + following, other + following, other + corner], axis=2)
    indices, counts = walls.reshape(-1), np.full(walls.shape[0] * sides, 4)
    normals = rays.reshape(-1, 3)[indices]
    if not strands.closed:
        starts, ends = strands.firsts, strands.firsts + strands.counts - 1
        lids = np.concatenate(
            [starts[:, None] * sides + corner[::-1], ends[:, None] * sides + corner]
        )
        along = np.concatenate([-strands.tangents[starts], strands.tangents[ends]])
        indices = np.concatenate([indices, lids.reshape(-1)])
        counts = np.concatenate([counts, np.full(len(lids), sides)])
        normals = np.concatenate([normals, np.repeat(along, sides, axis=0)])
    return _mesh(points.reshape(-1, 3), counts, indices, normals)


def ribbons(strands: Strands, facing: Array) -> Mesh:
    """Flat strips.

    Args:
        strands: Their middles and widths.
        facing: (N, 3) where they face at each point.
    """
    across = unit(np.cross(facing, strands.tangents))
    sides = 0.5 * strands.widths[:, None] * across
    points = np.stack([strands.points - sides, strands.points + sides], axis=1)
    rows = np.flatnonzero(strands.after != np.arange(len(strands.points)))
    one, other = 2 * rows, 2 * strands.after[rows]
    indices = np.stack([one, other, other + 1, one + 1], axis=1).reshape(-1)
    normals = unit(np.cross(strands.tangents, across))[indices // 2]
    return _mesh(points.reshape(-1, 3), np.full(len(rows), 4), indices, normals)


def _mesh(points: Array, counts: Ints, indices: Ints, normals: Array) -> Mesh:
    return Mesh(
        points, counts.astype(np.int32), indices.astype(np.int32), normals.astype(np.float32)
    )


def _transported(strands: Strands) -> Array:
    """(N, 3) unit, square to the strands, turning as little as can be from point to point.

    Wang et al., "Computation of Rotation Minimizing Frames" (2008): the double reflection.
    """
    found = np.zeros_like(strands.points)
    tangents = strands.tangents
    first = strands.firsts
    away = np.eye(3)[np.abs(tangents[first]).argmin(axis=1)]
    found[first] = unit(np.cross(tangents[first], away))
    for step in range(1, int(strands.counts.max())):
        here = first[strands.counts > step] + step
        found[here] = _transport_directions(strands, found, here - 1, here)
    # What is left of an error is taken off, and strands that stand still face anywhere.
    square = unit(found - (found * tangents).sum(axis=1, keepdims=True) * tangents)
    if not strands.closed:
        return square
    # A ring comes back turned by some angle, which all of it shares.
    back = _transport_directions(strands, square, first + strands.counts - 1, first)
    beside = np.cross(tangents[first], square[first])
    angle = np.arctan2((back * beside).sum(axis=1), (back * square[first]).sum(axis=1))
    share = (np.arange(len(square)) - first[strands.strand]) / strands.counts[strands.strand]
    turn = -(angle[strands.strand] * share)[:, None]
    return np.asarray(np.cos(turn) * square + np.sin(turn) * np.cross(tangents, square))


def _transport_directions(strands: Strands, found: Array, last: Ints, here: Ints) -> Array:
    """Directions of the points ``last``, taken along to the points ``here``."""
    tangents = strands.tangents
    step = strands.points[here] - strands.points[last]
    mirrored, along = _reflected(step, found[last], tangents[last])
    return _reflected(tangents[here] - along, mirrored)[0]


def _reflected(normal: Array, *vectors: Array) -> tuple[Array, ...]:
    """Vectors mirrored at planes; where a plane has no normal they stay."""
    size = (normal**2).sum(axis=1, keepdims=True)
    share = np.divide(2.0, size, out=np.zeros_like(size), where=size > 0.0)
    return tuple(
        one - share * (normal * one).sum(axis=1, keepdims=True) * normal for one in vectors
    )
