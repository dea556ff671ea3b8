"""How far convex shapes are off the thing that they stand for."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.components import Component
from openrooms_usd.physics.solid import Solid

# How close the bounds of distances are brought, metres.
RESOLUTION_M: Final = 1e-3
# Points that volumes are estimated by.
POINTS: Final = 40_000


@dataclass(frozen=True)
class CollisionError:
    """What shapes get wrong; all in metres and cubic metres.

    Distances are upper bounds, and at most `slack` above the true ones.

    Attributes:
        protrusion: The farthest that any shape's surface lies outside the thing.
        uncovered: The farthest that the thing's surface lies outside all shapes.
        slack: What the distances can be too great by.
    """

    protrusion: float
    uncovered: float
    slack: float


@dataclass(frozen=True)
class Volumes:
    """Volumes by counting points of a jittered lattice.

    Attributes:
        shapes: Of the union of the shapes, cubic metres.
        thing: Of what the closed parts of the thing fill together.
        shapes_error: The standard error of the first, that of plain random points: an upper bound.
        thing_error: The same of the second.
    """

    shapes: float
    thing: float
    shapes_error: float
    thing_error: float


def collision_error(
    shapes: Sequence[TriangleMesh], thing: Solid, resolution: float = RESOLUTION_M
) -> CollisionError:
    """The distances both ways.

    The whole surface of every shape counts, also where another shape hides it: so a hollow that is
    filled shows even under a lid. What lies inside the other counts nothing either way.

    Args:
        shapes: Closed convex meshes, metres.
        thing: What they stand for.
        resolution: How close the bounds shall be, metres.
    """
    union = as_solid(shapes)
    outer = thing.greatest(_triangles(union), resolution)
    inner = union.greatest(_triangles(thing), resolution)
    slack = max(upper - lower for lower, upper in (outer, inner))
    return CollisionError(outer[1], inner[1], slack)


def volumes(shapes: Sequence[TriangleMesh], thing: Solid, seed: int = 0) -> Volumes:
    """What the shapes and the thing fill, by the same points.

    Args:
        shapes: Closed convex meshes, metres.
        thing: What they stand for.
        seed: Of the points' places in their cells.
    """
    union = as_solid(shapes)
    corners = np.concatenate([c.corners.reshape(-1, 3) for c in union.components])
    low, high = corners.min(axis=0), corners.max(axis=0)
    points = _lattice(low, high, seed)
    box = float(np.prod(high - low))
    shares = [float(solid.inside(points).mean()) for solid in (union, thing)]
    errors = [box * sqrt(share * (1.0 - share) / len(points)) for share in shares]
    return Volumes(shares[0] * box, shares[1] * box, errors[0], errors[1])


def as_solid(shapes: Sequence[TriangleMesh]) -> Solid:
    """What convex shapes fill together."""
    return Solid([Component(s.points[s.triangles], "", "", True) for s in shapes])


def _triangles(solid: Solid) -> Array:
    return np.concatenate([component.corners for component in solid.components])


def _lattice(low: Array, high: Array, seed: int) -> Array:
    """About `POINTS` points, one at random in each of equal cells."""
    side = (np.prod(high - low) / POINTS) ** (1.0 / 3.0)
    counts = np.maximum(np.round((high - low) / side), 1).astype(int)
    cells = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    shares = (cells + np.random.default_rng(seed).random(cells.shape)) / counts
    return np.asarray(low + shares * (high - low))
