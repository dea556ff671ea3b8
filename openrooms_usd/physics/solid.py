"""A thing as what it fills: closed components have an inside, open sheets have none."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.physics.components import Component
from openrooms_usd.physics.surfaces import TriangleSurface, balls, halved, squared_distances

# Triangles that are bounded at once, and how often, while the farthest point is searched.
TRIANGLES_PER_ROUND: Final = 3_000
MAX_ROUNDS: Final = 40
# Triangles of a convex component up to which distances to all of it are asked for.
FEW_FACES: Final = 64
# Points that lie less deep than this are on the surface, metres.
SKIN_M: Final = 1e-6
# Rays that ask for the inside: no furniture has faces or edges along them.
DIRECTIONS: Final = np.array([[0.41, 0.23, 0.88], [-0.67, 0.53, -0.52], [0.19, -0.94, 0.28]])


class Solid:
    """What some components fill together; they may overlap and touch.

    Args:
        components: At least one.
    """

    def __init__(self, components: Sequence[Component]) -> None:
        self.components = tuple(components)
        self._closed = [c.corners for c in self.components if c.closed]
        self._low = np.array([c.min(axis=(0, 1)) for c in self._closed]).reshape(-1, 3)
        self._high = np.array([c.max(axis=(0, 1)) for c in self._closed]).reshape(-1, 3)
        self._surfaces: dict[str | None, tuple[TriangleSurface, Ints]] = {}
        self._casters: dict[int, RayCaster] = {}
        self._planes = [c.planes for c in self.components if c.closed]

    def surface(self, contact: str | None = None) -> TriangleSurface:
        """All its triangles, or those of one contact material."""
        return self._surface_and_components(contact)[0]

    def _surface_and_components(self, contact: str | None) -> tuple[TriangleSurface, Ints]:
        """A surface, and the closed component that each of its triangles is of; -1 for none."""
        if contact is not None and all(c.contact == contact for c in self.components):
            contact = None
        if contact not in self._surfaces:
            number = np.cumsum([c.closed for c in self.components]) - 1
            mine = [k for k, c in enumerate(self.components) if contact in (None, c.contact)]
            owners = [number[k] if self.components[k].closed else -1 for k in mine]
            sizes = [len(self.components[k].corners) for k in mine]
            surface = TriangleSurface(np.concatenate([self.components[k].corners for k in mine]))
            self._surfaces[contact] = surface, np.repeat(owners, sizes)
        return self._surfaces[contact]

    def inside(self, points: Array) -> Mask:
        """(N,) whether points (N, 3) lie in a closed component."""
        found = np.zeros(len(points), dtype=np.bool_)
        low, high = points.min(axis=0, initial=np.inf), points.max(axis=0, initial=-np.inf)
        near = ((self._low <= high) & (self._high >= low)).all(axis=1)
        for k in np.flatnonzero(near):
            within = ((points >= self._low[k]) & (points <= self._high[k])).all(axis=1)
            rows = np.flatnonzero(within & ~found)
            if len(rows):
                found[rows] = self._in_one(int(k), points[rows])
        return found

    def _swallows(self, corners: Array) -> Mask:
        """(M,) whether all corners of a triangle lie in one convex component, hence all of it."""
        found = np.zeros(len(corners), dtype=np.bool_)
        low, high = corners.min(axis=1), corners.max(axis=1)
        for k, planes in enumerate(self._planes):
            if planes is None:
                continue
            within = (low >= self._low[k] - SKIN_M) & (high <= self._high[k] + SKIN_M)
            rows = np.flatnonzero(within.all(axis=1) & ~found)
            if len(rows):
                ends = corners[rows].reshape(-1, 3)
                inside = (ends @ planes[:, :3].T + planes[:, 3] <= SKIN_M).all(axis=1)
                found[rows] = inside.reshape(-1, 3).all(axis=1)
        return found

    def _off_convex(self, corners: Array, owners: Ints) -> Array:
        """(M,) how far triangles reach outside the components nearest to them, where convex.

        The distance to a convex set is a convex function, hence greatest at a corner.
        """
        found = np.full(len(corners), np.inf)
        for k in np.unique(owners[owners >= 0]):
            if self._planes[k] is None or len(self._closed[k]) > FEW_FACES:
                continue
            rows = np.flatnonzero(owners == k)
            ends = corners[rows].reshape(-1, 3)
            squared = squared_distances(ends[:, None], self._closed[k]).min(axis=1)
            squared[self._in_one(int(k), ends)] = 0.0
            found[rows] = np.sqrt(squared.reshape(-1, 3).max(axis=1))
        return found

    def _in_one(self, k: int, points: Array) -> Mask:
        planes = self._planes[k]
        if planes is not None:
            return np.asarray((points @ planes[:, :3].T + planes[:, 3] < -SKIN_M).all(axis=1))
        if k not in self._casters:
            self._casters[k] = RayCaster(
                self._closed[k].reshape(-1, 3), np.arange(3 * len(self._closed[k])).reshape(-1, 3)
            )
        return _enclosed(points, self._casters[k])

    def greatest(
        self, corners: Array, resolution: float, enough: float = 0.0
    ) -> tuple[float, float]:
        """Between which numbers the farthest lies that triangles reach outside the solid.

        A distance changes by no more than the way between two points, and the distance to one
        triangle is a convex function. So a triangle's centre and corners bound it everywhere; the
        triangles that may reach farthest are halved first.

        Args:
            corners: (M, 3, 3) triangles, metres.
            resolution: Largest gap of the bounds, metres; larger after `MAX_ROUNDS` rounds.
            enough: Bounds need be no lower than this, metres.
        """
        lower, upper = 0.0, 0.0
        corners = corners[~self._swallows(corners)]
        most = np.full(len(corners), np.inf)
        for _ in range(MAX_ROUNDS):
            if not len(most):
                break
            first = np.argsort(-most, kind="stable")[:TRIANGLES_PER_ROUND]
            rest = np.setdiff1d(np.arange(len(most)), first)
            chosen = corners[first]
            found, least = self._bounds(chosen, max(lower + resolution, enough))
            lower = max(lower, float(least.max()))
            floor = max(lower + resolution, enough)
            found = np.minimum(found, most[first])
            upper = max(upper, float(found[found <= floor].max(initial=0.0)))
            most = np.concatenate([most[rest], np.repeat(found, 2)])
            corners = np.concatenate([corners[rest], halved(chosen)])
            open_ = most > floor
            corners, most = corners[open_], most[open_]
        return lower, max(upper, lower, float(most.max(initial=0.0)))

    def _bounds(self, corners: Array, floor: float) -> tuple[Array, Array]:
        """(M,) upper and (M,) lower bounds of each triangle; loose where both are below a floor."""
        surface, owners = self._surface_and_components(None)
        centres, radii = balls(corners)
        nearest = surface.nearest(centres, floor)
        most = np.minimum(nearest.distance + radii, surface.farthest(corners, nearest.triangle))
        least = np.where(nearest.least > floor, nearest.least, 0.0)
        # The inside matters only where the surface is too far to settle it.
        asked = np.flatnonzero(most > floor)
        off = self._off_convex(corners[asked], owners[nearest.triangle[asked]])
        most[asked] = np.minimum(most[asked], off)
        asked = asked[most[asked] > floor]
        swallowed = self._swallows(corners[asked])
        most[asked[swallowed]] = least[asked[swallowed]] = 0.0
        asked = asked[~swallowed]
        own = asked[self.inside(centres[asked])]
        most[own] = np.minimum(most[own], np.maximum(radii[own] - nearest.least[own], 0.0))
        least[own] = 0.0
        return most, least


def _enclosed(points: Array, caster: RayCaster) -> Mask:
    """(N,) whether most rays meet the surface of a closed component from within first."""
    count = len(DIRECTIONS)
    directions = np.repeat(DIRECTIONS, len(points), axis=0)
    hits = caster.first_hit(np.tile(points, (count, 1)), directions)
    leaves = np.einsum("ij,ij->i", caster.normals[hits.triangle], directions) > 0.0
    return np.asarray((hits.hit & leaves).reshape(count, -1).sum(axis=0) * 2 > count)
