"""Light that comes straight from lamps and through portals.

Sums over many points of each light are exact but for what stands in between; that share comes from
random rays.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.appearance.directions import ELEVATIONS, between_elevations, lobe_values
from openrooms_usd.appearance.places import Places, strata
from openrooms_usd.arrays import Array
from openrooms_usd.arrays import Ints as Rows
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.rays import RayTracer
from openrooms_usd.rendering.scene.sources import Source
from openrooms_usd.usd.light.lights import Portal

STEP_M: Final = 1e-4
"""Rays start so far above surfaces, metres."""

_SHADOW_RAYS: Final = 35
_LIGHT_POINTS: Final = 128
_CHUNK: Final = 1 << 19


@dataclass(frozen=True, eq=False)
class Straight:
    """Light without detour: (N, K) of all directions alike, (broad lobes, 2, N, K) of lobes."""

    even: Array
    lobes: Array


@dataclass(frozen=True, eq=False)
class _Shine:
    """Rays towards something that emits: whose they are, what they carry, what is met first."""

    owner: Rows
    ahead: Array
    value: Array
    first: Rows


class Lights:
    """The lights of a scene, as columns: lamps, then the surroundings at `ELEVATIONS`.

    Args:
        scene: The arrays.
        tracer: Finds its triangles.
        lamps: Its lamps.
        rng: Of directions.
    """

    def __init__(
        self, scene: Scene, tracer: RayTracer, lamps: Sequence[Source], rng: np.random.Generator
    ) -> None:
        self._scene, self._tracer, self._rng = scene, tracer, rng
        self._corners = scene.triangles.corners
        self.lamps = lamps
        self.columns = len(lamps) + len(ELEVATIONS)
        self.portals = [_rectangle(portal) for portal in scene.portals]
        self._glass = glass_of(scene)
        self.lamp_of = np.full(len(scene.triangles), -1, dtype=np.int64)
        for number, lamp in enumerate(lamps):
            for patch in lamp.patches:
                self.lamp_of[scene.offsets[patch] : scene.offsets[patch + 1]] = number

    def straight(self, places: Places, broad: Sequence[float]) -> Straight:
        """What lamps of one nit, and the surroundings in portals, send without detour.

        Sums over many points of each light are exact but for what stands in between; that share
        comes from random rays.
        """
        many = len(places)
        even = np.zeros((many, self.columns))
        lobes = np.zeros((len(broad), 2, many, self.columns))
        for number, lamp in enumerate(self.lamps):
            rows = np.concatenate(
                [np.arange(*self._scene.offsets[p : p + 2]) for p in lamp.patches]
            )
            shine = self._shine(places, self._corners[rows])
            lit = (shine.first >= 0) & (self.lamp_of[np.maximum(shine.first, 0)] == number)
            self._add(places, self._corners[rows], shine, lit, number, broad, even, lobes)
        for corners in self.portals:
            shine = self._shine(places, corners)
            self._add(places, corners, shine, shine.first < 0, None, broad, even, lobes)
        return Straight(even, lobes)

    def _add(
        self,
        places: Places,
        corners: Array,
        shine: _Shine,
        lit: NDArray[np.bool_],
        lamp: int | None,
        broad: Sequence[float],
        even: Array,
        lobes: Array,
    ) -> None:
        """Add one light's share: sums over its points times how much of each is seen."""
        many = len(places)
        some = np.bincount(shine.owner[lit], shine.value[lit], many)
        every = np.bincount(shine.owner, shine.value, many)
        seen = some / np.where(every > 0.0, every, 1.0)
        points, facing, area = _points_of(corners)
        joints = places.position.shape[1]
        for joint in range(joints):
            for here in _slices(many, len(points)):
                part = [one[here, joint] for one in (places.position, places.normal, places.view)]
                ahead, value = _arriving(part[0], part[1], points, facing, area)
                value *= seen[here, None] / joints
                if lamp is None and self._glass is not None:
                    value *= self._glass * slab(np.abs(np.einsum("nti,ti->nt", ahead, facing)))
                share = self._shares(ahead, lamp)
                even[here] += np.einsum("nt,ntk->nk", value, share)
                for level, roughness in enumerate(broad):
                    both = lobe_values(part[1], part[2], ahead, roughness**2)
                    for index, one in enumerate(both):
                        lobes[level, index, here] += np.einsum("nt,ntk->nk", value * one, share)

    def _shares(self, ahead: Array, lamp: int | None) -> Array:
        """(N, T, K) which sources directions belong to."""
        share = np.zeros((*ahead.shape[:2], self.columns))
        if lamp is not None:
            share[..., lamp] = 1.0
            return share
        low, upper = between_elevations(ahead.reshape(-1, 3))
        flat = share.reshape(-1, self.columns)
        row = np.arange(len(flat))
        flat[row, len(self.lamps) + low] = 1.0 - upper
        flat[row, len(self.lamps) + low + 1] = upper
        return share

    def _shine(self, places: Places, corners: Array) -> _Shine:
        """Rays from places to stratified points of emitting triangles, and what they meet."""
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = 0.5 * np.linalg.norm(cross, axis=1)
        total = float(area.sum())
        position, normal, _, owner = places.spread(_SHADOW_RAYS)
        u, v = strata(self._rng, len(places), _SHADOW_RAYS).T
        edges = np.cumsum(area) / max(total, 1e-30)
        picked = np.searchsorted(edges, u).clip(0, len(corners) - 1)
        low = edges[picked] - area[picked] / max(total, 1e-30)
        u = np.clip((u - low) / np.maximum(edges[picked] - low, 1e-12), 0.0, 1.0)
        root = np.sqrt(u)
        chosen = corners[picked]
        weights = np.stack([1.0 - root, root * (1.0 - v), root * v], axis=-1)
        point = np.einsum("nj,nji->ni", weights, chosen)
        facing = cross[picked] / np.maximum(2.0 * area[picked], 1e-30)[:, None]
        origins = position + STEP_M * normal
        way = point - origins
        square = np.maximum(np.einsum("ni,ni->n", way, way), 1e-6)
        ahead = way / np.sqrt(square)[:, None]
        here = np.einsum("ni,ni->n", ahead, normal)
        there = -np.einsum("ni,ni->n", ahead, facing)
        value = np.maximum(here, 0.0) * np.maximum(there, 0.0) / square
        lit = np.flatnonzero(value > 0.0)
        first = self._tracer.rays(origins[lit], ahead[lit])
        return _Shine(owner[lit], ahead[lit], value[lit], first)


def _slices(many: int, points: int) -> Iterator[slice]:
    """Parts of rows of which each has so many points."""
    size = max(1, _CHUNK // points)
    for begin in range(0, many, size):
        yield slice(begin, begin + size)


def _points_of(corners: Array) -> tuple[Array, Array, Array]:
    """Middles of pieces of triangles, their unit normals, and their areas."""
    while len(corners) < _LIGHT_POINTS:
        middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
        outer = [
            np.stack([corners[:, i], middles[:, i], middles[:, i - 1]], axis=1) for i in range(3)
        ]
        corners = np.concatenate([*outer, middles])
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = 0.5 * np.linalg.norm(cross, axis=1)
    kept = area > 0.0
    corners, cross, area = corners[kept], cross[kept], area[kept]
    step = max(1, len(corners) // (2 * _LIGHT_POINTS))
    picked = slice(None, None, step)
    scale = area.sum() / area[picked].sum()
    normal = cross[picked] / (2.0 * area[picked])[:, None]
    return corners[picked].mean(axis=1), normal, area[picked] * scale


def _arriving(
    position: Array, normal: Array, points: Array, facing: Array, area: Array
) -> tuple[Array, Array]:
    """(N, T, 3) directions to points of a light, and (N, T) their share of what arrives."""
    way = points[None] - position[:, None]
    square = np.maximum(np.einsum("nti,nti->nt", way, way), area[None])
    ahead = way / np.sqrt(square)[..., None]
    here = np.maximum(np.einsum("nti,ni->nt", ahead, normal), 0.0)
    there = np.maximum(-np.einsum("nti,ti->nt", ahead, facing), 0.0)
    return ahead, here * there * area / (np.pi * square)


def glass_of(scene: Scene) -> float | None:
    """What the panes' glass lets through at normal incidence; None without panes."""
    clear = [pane.surface.pane for pane in scene.panes if pane.surface.pane is not None]
    return float(np.mean(clear)) if clear else None


def slab(cosine: Array) -> Array:
    """What a thin pane of glass lets through, with all reflections inside."""
    reflected = 0.04 + 0.96 * (1.0 - np.clip(cosine, 0.0, 1.0)) ** 5
    return np.asarray((1.0 - reflected) / (1.0 + reflected))


def _rectangle(portal: Portal) -> Array:
    """(2, 3, 3) the triangles of a portal; their front sides face the room."""
    half = 0.5 * np.array([portal.width, portal.height])
    signs = np.array([[-1, -1], [-1, 1], [1, 1], [1, -1]])
    local = np.column_stack([signs * half, np.zeros(4), np.ones(4)])
    corners = (local @ portal.world_from_portal.T)[:, :3]
    return np.asarray(corners[[[0, 1, 2], [0, 2, 3]]])
