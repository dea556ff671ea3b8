"""Convex shapes that stand for a thing in collisions, as few as a tolerance allows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.collision_error import RESOLUTION_M, as_solid
from openrooms_usd.physics.components import Component, Part, components
from openrooms_usd.physics.convex_decomposition import (
    MAX_JOINED_COMPONENTS,
    PRINT_SHARE,
    Limits,
    Piece,
    convex_decomposition,
    protrusions,
)
from openrooms_usd.physics.hulls import convex_hull, half_spaces, oriented_box, outside_others
from openrooms_usd.physics.solid import Solid
from openrooms_usd.physics.surfaces import squared_distances

Method = Literal["auto", "hull", "box"]

METHODS: Final[tuple[Method, ...]] = get_args(Method)
# How far shapes may be off the thing, metres.
TOLERANCE: Final = 0.01
# Shapes a thing may have.
MOST_SHAPES: Final = 256
# How closely a crowd of components is measured, as parts of its size.
COARSE_STEPS: Final = 32
# A box stands for a hull where it adds no more than this share of the tolerance.
BOX_SHARE: Final = 0.25
# What stands on a box that is lower than its hull by more stands askew, metres.
SINK_M: Final = 1e-4
# A box that is so near to a hull is that hull, metres.
SAME_BOX_M: Final = 1e-5


@dataclass(frozen=True, eq=False)
class ConvexShape:
    """One convex shape.

    Attributes:
        mesh: Its closed convex surface in the frame of the link, metres.
        contact: Which contact material it has.
        parts: The names of the parts that it stands for.
        box: Whether it is a box: 8 corners, right angles.
    """

    mesh: TriangleMesh
    contact: str
    parts: tuple[str, ...]
    box: bool = False


@dataclass(frozen=True, eq=False)
class Shapes:
    """What stands for a thing in collisions.

    Attributes:
        shapes: In the order of their parts.
        protrusion: They stick out of the thing no farther, metres.
        uncovered: Its surface lies no farther outside of them, metres.
    """

    shapes: tuple[ConvexShape, ...]
    protrusion: float
    uncovered: float

    @property
    def error(self) -> float:
        """The greater of both, metres."""
        return max(self.protrusion, self.uncovered)


def collision_shapes(
    parts: Sequence[Part],
    method: Method = "auto",
    tolerance: float = TOLERANCE,
    most: int = MOST_SHAPES,
) -> Shapes:
    """Convex shapes for the parts of one link.

    ``auto`` makes a hull of each connected component, cuts those that stick out of the thing by
    more than the tolerance, and merges neighbours of one contact material while that stays so.
    Where that holds, no opening wider than twice the tolerance is closed.
    Where more shapes would be needed than there may be, the tolerance is widened, and a crowd of
    components is pooled.

    The search looks at samples; the errors are proven of what came out, by every method: no point
    of a shape's surface, and none of the thing's, is farther off.

    Args:
        parts: Surfaces in the link's frame, metres.
        method: ``auto``, or one ``hull`` or ``box`` a contact material.
        tolerance: How far they may be off, metres.
        most: The most shapes.

    Raises:
        InputError: A coordinate is not finite, nothing has an area, or an option is not allowed.
    """
    _checked(method, tolerance, most)
    found = components(parts)
    solid = Solid(found)
    if method == "auto":
        pieces = convex_decomposition(found, solid, tolerance, most)
    else:
        pieces = _whole(found)
    shapes = _shapes(pieces, method, solid, tolerance)
    seen = outside_others([shape.mesh.points for shape in shapes], PRINT_SHARE * tolerance)
    shapes = tuple(shapes[k] for k in seen)
    union = np.concatenate([shape.mesh.points[shape.mesh.triangles] for shape in shapes])
    corners = np.concatenate([component.corners for component in found])
    # Bounds of a crowd are coarse: they would take minutes.
    size = float(np.ptp(corners.reshape(-1, 3), axis=0).max())
    resolution = RESOLUTION_M if len(found) <= MAX_JOINED_COMPONENTS else size / COARSE_STEPS
    protrusion = solid.greatest(union, resolution, tolerance)[1]
    thing = as_solid([shape.mesh for shape in shapes])
    return Shapes(shapes, protrusion, thing.greatest(corners, resolution, tolerance)[1])


def _checked(method: str, tolerance: float, most: int) -> None:
    if method not in METHODS:
        raise InputError(
            f"unknown method for collision shapes: {method!r}",
            remedy=f"choose one of {', '.join(METHODS)}",
        )
    if not 1e-4 <= tolerance <= 1.0:
        raise InputError(
            f"the tolerance of collision shapes cannot be {tolerance:g} m",
            remedy="give a tolerance between 0.0001 m and 1 m",
        )
    if most < 1:
        raise InputError(
            f"an object cannot have {most} collision shapes", remedy="allow at least 1"
        )


def _whole(found: Sequence[Component]) -> list[Piece]:
    """One piece a contact material."""
    pieces = []
    for contact in dict.fromkeys(component.contact for component in found):
        mine = [component for component in found if component.contact == contact]
        points = np.concatenate([component.corners.reshape(-1, 3) for component in mine])
        names = tuple(dict.fromkeys(component.part for component in mine))
        pieces.append(Piece(points, contact, names))
    return pieces


def _shapes(
    pieces: Sequence[Piece], method: Method, solid: Solid, tolerance: float
) -> tuple[ConvexShape, ...]:
    """The shapes of pieces; boxes where they are asked for or as good."""
    boxes = [oriented_box(piece.points) for piece in pieces]
    if method == "box":
        pairs = zip(pieces, boxes, strict=True)
        return tuple(ConvexShape(box, piece.contact, piece.parts, True) for piece, box in pairs)
    hulls = [convex_hull(piece.points) for piece in pieces]
    off = [farthest_corner(box.points, hull) for box, hull in zip(boxes, hulls, strict=True)]
    fits = [
        far <= BOX_SHARE * tolerance and hull.points[:, 2].min() <= box.points[:, 2].min() + SINK_M
        for far, box, hull in zip(off, boxes, hulls, strict=True)
    ]
    if method == "auto":
        limits = Limits.of(tolerance)
        asked = [k for k in range(len(pieces)) if fits[k] and off[k] > SAME_BOX_M]
        for contact in dict.fromkeys(pieces[k].contact for k in asked):
            mine = [k for k in asked if pieces[k].contact == contact]
            faces = [boxes[k].points[boxes[k].triangles] for k in mine]
            for k, out in zip(mine, protrusions(faces, solid, limits, contact), strict=True):
                fits[k] = out <= tolerance
    return tuple(
        ConvexShape(box if is_box else hull, piece.contact, piece.parts, is_box)
        for piece, box, hull, is_box in zip(pieces, boxes, hulls, fits, strict=True)
    )


def farthest_corner(points: Array, hull: TriangleMesh) -> float:
    """How far the hull of some points sticks out of another hull: its corners do so most.

    The distance to a convex set is a convex function, which is greatest at corners.
    """
    planes = half_spaces(hull)
    outside = points[(points @ planes[:, :3].T + planes[:, 3] > 0.0).any(axis=1)]
    corners = hull.points[hull.triangles]
    squared = squared_distances(np.unique(outside, axis=0)[:, None], corners).min(axis=1)
    return float(np.sqrt(squared.max(initial=0.0)))
