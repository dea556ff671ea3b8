"""How light travels between the surfaces of a scene: sampled once, linear ever after.

Elements are pieces of one part within a small cube that face about one way. For each element and
each observation the operator knows which share of the light that arrives comes from which element,
and what each source sends straight. Base colours and strengths can then change without a ray being
traced again: radiosity with a final gather (Goral et al., 1984).

What arrives is the mean radiance over the cosine-weighted hemisphere, nits: irradiance over pi.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from openrooms_usd.appearance.directions import (
    ELEVATIONS,
    between_elevations,
    frames_about,
    smith_ratio,
    visible_normals,
)
from openrooms_usd.appearance.elements import Elements, Lookup
from openrooms_usd.appearance.places import Places, strata
from openrooms_usd.appearance.straight import STEP_M, Lights, glass_of, slab
from openrooms_usd.arrays import Array
from openrooms_usd.arrays import Ints as Rows
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.rays import RayTracer
from openrooms_usd.rendering.scene.sources import Source

ROUGHNESSES: Final = (0.08, 0.2, 0.35, 0.5, 0.75)
"""Perceptual roughnesses for which mirror lobes are sampled."""

_CHUNK: Final = 1 << 19
# Points of each element, and rays from each point.
_POINTS: Final = 6
_ELEMENT_RAYS: Final = 64
_DIFFUSE_RAYS: Final = 140
_GLOSSY_RAYS: Final = 20
_ROUNDS: Final = 2
# Lobes at least as broad meet lights by points of these, sharper ones by rays.
_BROAD: Final = tuple(roughness for roughness in ROUGHNESSES if roughness > 0.3)


@dataclass(frozen=True, eq=False)
class Gather:
    """What arrives at places, by where it comes from.

    Attributes:
        direct: (N, K) from a unit of each source.
        form: (N, E) sparse, from a unit of radiance of each element.
    """

    direct: Array
    form: sparse.csr_array

    def of(self, strengths: Array, radiance: Array) -> Array:
        """(N, 3) what arrives, nits.

        Args:
            strengths: (K, 3) of the sources.
            radiance: (E, 3) of the elements, nits.
        """
        return np.asarray(self.direct @ strengths + self.form @ radiance)


@dataclass(frozen=True, eq=False)
class Transport:
    """The sampled operator.

    Attributes:
        part: (E,) the part's number of each element.
        between: What arrives at elements.
        diffuse: What arrives at observations.
        glossy: For each of `ROUGHNESSES`: what mirror lobes gather by a reflectance at normal
            incidence of 1, and by the rest of Schlick's term.
    """

    part: Rows
    between: Gather
    diffuse: Gather
    glossy: tuple[tuple[Gather, Gather], ...]


@dataclass(frozen=True, eq=False)
class _Rays:
    """What rays have met: elements by key, or sources by column (-1: neither)."""

    owner: Rows
    key: Rows
    column: NDArray[np.int64]
    second: NDArray[np.int64]
    share: Array
    weight: Array
    position: Array
    normal: Array


def sample_transport(
    scene: Scene, tracer: RayTracer, sources: Sequence[Source], places: Places, seed: int = 0
) -> Transport:
    """Sample how light reaches places, and all that they see.

    Args:
        scene: The arrays.
        tracer: Finds its triangles.
        sources: Its lights: lamps have a column each, the surroundings one for each of
            `ELEVATIONS`.
        places: Observations.
        seed: Of directions.
    """
    return _Sampler(scene, tracer, sources, seed).sample(places)


def sky_seen(scene: Scene, position: Array, directions: Array) -> Array:
    """(N, elevations) what a unit at each of `ELEVATIONS` shows along rays that meet nothing.

    Args:
        scene: The arrays; its panes dim what is seen through its portals.
        position: (N, 3) where rays start.
        directions: (N, 3) unit.
    """
    low, upper = between_elevations(directions)
    found = np.zeros((len(directions), len(ELEVATIONS)))
    row = np.arange(len(directions))
    found[row, low], found[row, low + 1] = 1.0 - upper, upper
    glass = glass_of(scene)
    if glass is not None:
        for portal in scene.portals:
            frame = portal.world_from_portal
            slope = directions @ frame[:3, 2]
            away = (frame[:3, 3] - position) @ frame[:3, 2]
            met = position + (away / np.where(slope > 1e-6, slope, 1e-6))[:, None] * directions
            beside = np.abs((met - frame[:3, 3]) @ frame[:3, :2])
            through = (slope > 1e-6) & (away > 0.0)
            through &= (beside < 0.5 * np.array([portal.width, portal.height])).all(axis=1)
            found[through] *= (glass * slab(slope[through]))[:, None]
    return found


def lamps_of(sources: Sequence[Source]) -> list[Source]:
    """The lights that have columns of their own."""
    return [source for source in sources if source.kind == "lamp"]


class _Sampler:
    def __init__(
        self, scene: Scene, tracer: RayTracer, sources: Sequence[Source], seed: int
    ) -> None:
        self._tracer = tracer
        self._rng = np.random.default_rng(seed)
        parts = np.array([piece.part for piece in scene.pieces] or [0], dtype=np.int64)
        self._part_of = parts[scene.triangles.pieces]
        self._corners = scene.triangles.corners
        self._elements = Elements(self._part_of, self._corners)
        self._lights = Lights(scene, tracer, lamps_of(sources), self._rng)

    def sample(self, places: Places) -> Transport:
        """The operator for some places."""
        diffuse = self._cast(*self._cosine(places, _DIFFUSE_RAYS))
        lobes = [self._lobe(places, roughness) for roughness in ROUGHNESSES]
        between, lookup = self._between([diffuse, *(met for met, _ in lobes)])
        many = len(places)
        even = np.full(len(diffuse.owner), 1.0 / _DIFFUSE_RAYS)
        seen = self._gather(diffuse, diffuse.owner, even, lookup, many, sources=False)
        straight = self._lights.straight(places, _BROAD)
        seen = Gather(seen.direct + straight.even, seen.form)
        glossy = []
        for roughness, (met, rest) in zip(ROUGHNESSES, lobes, strict=True):
            broad = roughness in _BROAD
            more = straight.lobes[_BROAD.index(roughness)] if broad else (0.0, 0.0)
            first, second = (
                self._gather(met, met.owner, met.weight * part, lookup, many, sources=not broad)
                for part in (1.0 - rest, rest)
            )
            glossy.append(
                (
                    Gather(first.direct + more[0], first.form),
                    Gather(second.direct + more[1], second.form),
                )
            )
        return Transport(lookup.part, between, seen, tuple(glossy))

    def _between(self, seen: Sequence[_Rays]) -> tuple[Gather, Lookup]:
        """What arrives at the elements that rays have met, and at those that these meet."""
        keys, points = self._grown(np.zeros(0, np.int64), seen)
        traced, every = [], [points]
        for round_ in range(_ROUNDS):
            position, normal, owner = points
            met = self._cast(*self._cosine(_single(position, normal), _ELEMENT_RAYS))
            traced.append((met, owner[met.owner]))
            if round_ + 1 < _ROUNDS:
                keys, points = self._grown(keys, [met])
                every.append(points)
        lookup = Lookup(np.sort(keys))
        position, normal, owner = (np.concatenate(some) for some in zip(*every, strict=True))
        count, row = len(keys), lookup(owner)
        number = np.bincount(row, minlength=count).astype(float)
        owners = np.concatenate([lookup(who) for _, who in traced])
        weight = 1.0 / (number[owners] * _ELEMENT_RAYS)
        all_met = _joined([met for met, _ in traced])
        found = self._gather(all_met, owners, weight, lookup, count, sources=False)
        straight = np.zeros((count, self._lights.columns))
        even = self._lights.straight(_single(position, normal), ()).even
        np.add.at(straight, row, even / number[row, None])
        return Gather(found.direct + straight, found.form), lookup

    def _cosine(self, places: Places, rays: int) -> tuple[Array, Array, Rows]:
        """Origins, directions and owners of cosine-weighted rays, stratified by place."""
        position, normal, _, owner = places.spread(rays)
        u = strata(self._rng, len(places), rays)
        radius, angle = np.sqrt(u[:, 0]), 2.0 * np.pi * u[:, 1]
        local = np.stack(
            [radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1.0 - u[:, 0])], axis=-1
        )
        directions = np.einsum("nij,nj->ni", frames_about(normal), local)
        return position + STEP_M * normal, directions, owner

    def _lobe(self, places: Places, roughness: float) -> tuple[_Rays, Array]:
        """Rays by visible normals of GGX (Heitz, 2018), and Schlick's (1 - cos)^5 of each."""
        alpha = roughness**2
        position, normal, towards, owner = places.spread(_GLOSSY_RAYS)
        frames = frames_about(normal)
        view = np.einsum("nij,ni->nj", frames, towards)
        view[:, 2] = np.maximum(view[:, 2], 1e-3)
        view /= np.linalg.norm(view, axis=1, keepdims=True)
        half = visible_normals(view, alpha, strata(self._rng, len(places), _GLOSSY_RAYS))
        cosine = np.einsum("ni,ni->n", view, half)
        light = 2.0 * cosine[:, None] * half - view
        weight = np.where(light[:, 2] > 1e-4, smith_ratio(view[:, 2], light[:, 2], alpha), 0.0)
        ahead = np.einsum("nij,nj->ni", frames, light)
        met = self._cast(position + STEP_M * normal, ahead, owner, weight / _GLOSSY_RAYS)
        return met, np.clip(1.0 - cosine, 0.0, 1.0) ** 5

    def _cast(
        self, origins: Array, directions: Array, owner: Rows, weight: Array | None = None
    ) -> _Rays:
        weight = np.ones(len(owner)) if weight is None else weight
        parts = [
            self._cast_some(origins[s], directions[s], owner[s], weight[s])
            for s in (slice(i, i + _CHUNK) for i in range(0, max(len(owner), 1), _CHUNK))
        ]
        return _joined(parts)

    def _cast_some(self, origins: Array, directions: Array, owner: Rows, weight: Array) -> _Rays:
        rows = self._tracer.rays(origins, directions)
        hit = rows >= 0
        met = np.maximum(rows, 0)
        corners = self._corners[met]
        edge, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        geometric = np.cross(edge, other)
        slope = np.einsum("ni,ni->n", geometric, directions)
        along = np.einsum("ni,ni->n", geometric, corners[:, 0] - origins)
        distance = along / np.where(np.abs(slope) > 1e-12, slope, 1e-12)
        position = origins + distance[:, None] * directions
        length = np.linalg.norm(geometric, axis=1)
        normal = geometric / np.where(length > 0.0, length, 1.0)[:, None]
        normal *= -np.sign(slope)[:, None]
        lamp = np.where(hit, self._lights.lamp_of[met], -1)
        front = slope < 0.0
        column, second, share = np.full(len(rows), -1), np.full(len(rows), -1), np.zeros(len(rows))
        column[hit & (lamp >= 0) & front] = lamp[hit & (lamp >= 0) & front]
        if not hit.all():
            low, part = between_elevations(directions[~hit])
            column[~hit] = len(self._lights.lamps) + low
            second[~hit] = len(self._lights.lamps) + low + 1
            share[~hit] = part
        key = np.where(hit, self._elements.key(self._part_of[met], position, normal), -1)
        return _Rays(owner, key, column, second, share, weight, position, normal)

    def _grown(self, known: Rows, met: Sequence[_Rays]) -> tuple[Rows, tuple[Array, Array, Rows]]:
        """The elements that rays have met, and some points of those that are new."""
        key = np.concatenate([one.key for one in met])
        fresh = np.flatnonzero((key >= 0) & ~np.isin(key, known))
        fresh = self._rng.permutation(fresh)
        order = fresh[np.argsort(key[fresh], kind="stable")]
        sorted_ = key[order]
        begin = np.searchsorted(sorted_, sorted_, side="left")
        few = order[np.arange(len(order)) - begin < _POINTS]
        position = np.concatenate([one.position for one in met])[few]
        normal = np.concatenate([one.normal for one in met])[few]
        return np.concatenate([known, np.unique(sorted_)]), (position, normal, key[few])

    def _gather(
        self,
        met: _Rays,
        owner: Rows,
        weight: Array,
        lookup: Lookup,
        many: int,
        *,
        sources: bool = True,
    ) -> Gather:
        """What rays bring to places; without ``sources``, what `_straight` leaves of it."""
        direct = np.zeros((many, self._lights.columns))
        sky = (met.second >= 0) & (sources or not self._lights.portals)
        used = sky | ((met.column >= 0) & (met.second < 0) & sources)
        np.add.at(direct, (owner[used], met.column[used]), (weight * (1.0 - met.share))[used])
        np.add.at(direct, (owner[sky], met.second[sky]), (weight * met.share)[sky])
        on = met.key >= 0
        place = owner[on], lookup(met.key[on])
        form = sparse.csr_array((weight[on], place), shape=(many, len(lookup.part)))
        form.sum_duplicates()
        return Gather(direct, form)


def _single(position: Array, normal: Array) -> Places:
    """Places of one point each, seen from straight above."""
    return Places(position[:, None], normal[:, None], normal[:, None])


def _joined(parts: Sequence[_Rays]) -> _Rays:
    names = ("owner", "key", "column", "second", "share", "weight", "position", "normal")
    return _Rays(*(np.concatenate([getattr(one, name) for one in parts]) for name in names))
