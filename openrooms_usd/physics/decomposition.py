"""Convex shapes that stand for a thing in collisions, as few as a tolerance allows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.collision_error import RESOLUTION
from openrooms_usd.physics.components import Component, Part, components
from openrooms_usd.physics.decomposers import DECOMPOSERS
from openrooms_usd.physics.fewest import Limits, Piece, fewest, protrusions
from openrooms_usd.physics.hulls import convex_hull, half_spaces, oriented_box, volume
from openrooms_usd.physics.solid import Solid
from openrooms_usd.physics.surfaces import Surface, bisected, squared_distances

Array = NDArray[np.float64]
Method = Literal["parts", "auto", "coacd", "vhacd", "hull", "box"]

METHODS: Final[tuple[Method, ...]] = ("parts", "auto", "coacd", "vhacd", "hull", "box")
# How far shapes may be off the thing, metres.
TOLERANCE: Final = 0.01
# Shapes a thing may have.
MOST_SHAPES: Final = 256
# Pieces of a component that is not convex, where components are the shapes.
MOST_OF_ONE: Final = 16
# A hull that fills less of its box is none, as a share of the volume.
FULL_BOX: Final = 0.8
# Places of hulls that are looked at, and triangles that are looked at from each.
SAMPLED: Final = 96
SURVEYED: Final = 3_000
# A box stands for a hull where it adds no more than this share of the tolerance.
BOX_SHARE: Final = 0.25
# What lies so deep inside another shape can never be touched, metres.
HIDDEN: Final = 1e-6


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
class Fit:
    """A shape, and how far it sticks out of the thing, and its piece out of it, at most, metres."""

    shape: ConvexShape
    protrusion: float = np.inf
    uncovered: float = np.inf


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
    seed: int = 0,
) -> Shapes:
    """Convex shapes for the parts of one link.

    ``auto`` makes a hull of each connected component, cuts those that stick out of the thing by
    more than the tolerance, and merges neighbours of one contact material while that stays so. No
    opening wider than twice the tolerance is closed. Where more shapes would be needed than there
    may be, the tolerance is widened: the error says what came out.

    ``parts`` is quick and proves nothing: a hull of each connected component, and V-HACD for those
    whose hull seems to be off by more than the tolerance. Errors of all but ``auto`` are those of
    samples.

    Args:
        parts: Surfaces in the link's frame, metres.
        method: ``parts``; ``auto``; ``coacd`` or ``vhacd`` for every component; or one ``hull`` or
            ``box`` a contact material.
        tolerance: How far they may be off, metres.
        most: The most shapes; CoACD and V-HACD give as many a component.
        seed: Of CoACD's search.

    Raises:
        InputError: A coordinate is not finite, nothing has an area, or an option is no option.
        MissingPackageError: ``coacd`` or ``vhacd`` is asked for and not installed.
    """
    _checked(method, tolerance, most)
    found = components(parts)
    if method == "parts":
        return by_components(found, tolerance)
    solid = Solid(found)
    if method == "auto":
        pieces = fewest(found, solid, tolerance, most)
    elif method in DECOMPOSERS:
        pieces = _decomposed(found, method, tolerance, most, seed)
    else:
        pieces = _whole(found)
    fitted = [_fitted(piece, method, solid, tolerance) for piece in pieces]
    shapes = tuple(fit.shape for fit in fitted)
    shapes = _without_hidden(shapes) if method == "auto" else shapes
    if method != "auto":
        corners = np.concatenate([component.corners for component in found])
        hulls = [shape.mesh for shape in shapes]
        return Shapes(shapes, sampled_excess(hulls, found), left_out(hulls, corners))
    coarse = [fit.shape.mesh for fit in fitted if np.isinf(fit.protrusion)]
    protrusion = max((fit.protrusion for fit in fitted if fit.protrusion < np.inf), default=0.0)
    if coarse:
        corners = np.concatenate([mesh.points[mesh.triangles] for mesh in coarse])
        protrusion = max(protrusion, solid.greatest(corners, RESOLUTION)[1])
    return Shapes(shapes, protrusion, max(fit.uncovered for fit in fitted))


def by_components(found: Sequence[Component], tolerance: float) -> Shapes:
    """A hull or a box of each component; several of one that is not convex."""
    shapes: list[ConvexShape] = []
    protrusion = uncovered = 0.0
    for component in found:
        whole = component.corners.reshape(-1, 3)
        hulls = [convex_hull(whole)]
        off = sampled_excess(hulls, [component])
        if off > tolerance:
            pieces = DECOMPOSERS["vhacd"](component, tolerance, MOST_OF_ONE, 0)
            hulls = [convex_hull(piece) for piece in pieces] or hulls
            off = sampled_excess(hulls, [component])
        else:
            uncovered = max(uncovered, farthest_corner(whole, hulls[0]))
        protrusion = max(protrusion, off)
        shapes += [_boxed(hull, component, tolerance) for hull in hulls]
    return Shapes(_without_hidden(tuple(shapes)), protrusion, uncovered)


def _boxed(hull: TriangleMesh, component: Component, tolerance: float) -> ConvexShape:
    """A hull, or the box that is as good."""
    box = oriented_box(hull.points)
    fits = (
        volume(hull) > FULL_BOX * volume(box)
        and farthest_corner(box.points, hull) <= BOX_SHARE * tolerance
    )
    return ConvexShape(box if fits else hull, component.contact, (component.part,), fits)


def left_out(hulls: Sequence[TriangleMesh], corners: Array) -> float:
    """How far corners of a thing lie outside of all hulls at most, metres."""
    points = np.unique(corners.reshape(-1, 3), axis=0)
    for hull in hulls:
        planes = half_spaces(hull)
        points = points[(points @ planes[:, :3].T + planes[:, 3]).max(axis=1) > 0.0]
    if not len(points):
        return 0.0
    faces = np.concatenate([hull.points[hull.triangles] for hull in hulls])
    return float(Surface(faces).nearest(points).distance.max())


def sampled_excess(hulls: Sequence[TriangleMesh], found: Sequence[Component]) -> float:
    """How far hulls stick out of what they are of, at the middles and corners of large pieces.

    Args:
        hulls: At least one.
        found: What they stand for.
    """
    places = np.concatenate([_places(hull) for hull in hulls])
    # Where hulls meet inside a thing nothing sticks out.
    places = places[~Solid(found).inside(places)]
    if not len(places):
        return 0.0
    corners = np.concatenate([component.corners for component in found])
    if len(corners) > SURVEYED:
        return float(Surface(corners).nearest(places).distance.max())
    return float(np.sqrt(squared_distances(places[:, None], corners[None]).min(axis=1).max()))


def _places(hull: TriangleMesh) -> Array:
    """Places of a hull's surface that are looked at."""
    size = float(np.linalg.norm(np.ptp(hull.points, axis=0)))
    pieces, _ = bisected(hull.points[hull.triangles], size / 8.0)
    a, b, c = np.moveaxis(pieces, 1, 0)
    largest = np.argsort(-np.linalg.norm(np.cross(b - a, c - a), axis=1), kind="stable")[:SAMPLED]
    places = np.concatenate([pieces[largest].mean(axis=1), pieces[largest].reshape(-1, 3)])
    return np.unique(places, axis=0)


def _checked(method: str, tolerance: float, most: int) -> None:
    if method not in METHODS:
        raise InputError(
            f"there is no way to make collision shapes called {method!r}",
            remedy=f"choose one of {', '.join(METHODS)}",
        )
    if not 1e-4 <= tolerance <= 1.0:
        raise InputError(
            f"collision shapes cannot be {tolerance:g} m close",
            remedy="give a tolerance between 0.0001 m and 1 m",
        )
    if most < 1:
        raise InputError(f"a thing cannot have {most} collision shapes", remedy="allow at least 1")


def _decomposed(
    found: Sequence[Component], method: str, tolerance: float, most: int, seed: int
) -> list[Piece]:
    return [
        Piece(points, component.contact, (component.part,))
        for component in found
        for points in DECOMPOSERS[method](component, tolerance, most, seed)
    ]


def _whole(found: Sequence[Component]) -> list[Piece]:
    """One piece a contact material."""
    pieces = []
    for contact in dict.fromkeys(component.contact for component in found):
        mine = [component for component in found if component.contact == contact]
        points = np.concatenate([component.corners.reshape(-1, 3) for component in mine])
        names = tuple(dict.fromkeys(component.part for component in mine))
        pieces.append(Piece(points, contact, names))
    return pieces


def _fitted(piece: Piece, method: Method, solid: Solid, tolerance: float) -> Fit:
    """The shape of a piece; a box where that is asked for or as good."""
    hull = convex_hull(piece.points)
    if method == "box":
        return Fit(ConvexShape(oriented_box(piece.points), piece.contact, piece.parts, True))
    if method == "auto":
        box = oriented_box(piece.points)
        if farthest_corner(box.points, hull) <= BOX_SHARE * tolerance:
            bound = protrusions(
                [box.points[box.triangles]], solid, Limits.of(tolerance), piece.contact
            )[0]
            if bound <= tolerance:
                return Fit(ConvexShape(box, piece.contact, piece.parts, True), bound, 0.0)
    shape = ConvexShape(hull, piece.contact, piece.parts)
    return Fit(shape, piece.bound, farthest_corner(piece.points, hull))


def farthest_corner(points: Array, hull: TriangleMesh) -> float:
    """How far the hull of some points sticks out of another hull: its corners do so most.

    The distance to a convex set is a convex function, which is greatest at corners.
    """
    planes = half_spaces(hull)
    outside = points[(points @ planes[:, :3].T + planes[:, 3] > 0.0).any(axis=1)]
    corners = hull.points[hull.triangles]
    squared = [squared_distances(point, corners).min() for point in np.unique(outside, axis=0)]
    return float(np.sqrt(max(squared, default=0.0)))


def _without_hidden(shapes: tuple[ConvexShape, ...]) -> tuple[ConvexShape, ...]:
    """Shapes that do not lie wholly inside another one."""
    kept = list(shapes)
    for shape in sorted(shapes, key=lambda s: volume(s.mesh)):
        if any(_holds(other.mesh, shape.mesh) for other in kept if other is not shape):
            kept.remove(shape)
    return tuple(kept)


def _holds(outer: TriangleMesh, inner: TriangleMesh) -> bool:
    low, high = outer.points.min(axis=0) + HIDDEN, outer.points.max(axis=0) - HIDDEN
    if (inner.points < low).any() or (inner.points > high).any():
        return False
    planes = half_spaces(outer)
    return bool((inner.points @ planes[:, :3].T + planes[:, 3]).max() <= -HIDDEN)
