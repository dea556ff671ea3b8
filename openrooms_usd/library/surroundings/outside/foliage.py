"""Trees, bushes and hedges as meshes: clumps of leaves on dark lobes, one unit high.

What stands near a window is seen from places that differ by more than a picture of it allows. Few
triangles have to do, so a clump of leaves is one face, and what lies behind the clumps is dark.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box, frustum, sphere
from openrooms_usd.library.surroundings.outside.noise import Floats

SHADES: Final = 8
"""Of leaves: columns of the picture that colours them, from those within to those outside."""

# How high a piece of hedge is to its length, and how thick; in its height.
HEDGE_LONG, HEDGE_DEEP = 1.25, 0.45
# The ball below the leaves of a lobe, as a part of its radius; clumps of leaves on it.
_LOBE_SHARE: Final = 0.84
_CLUMPS: Final = 120
_SIDES: Final = 6
_NO_LOBES: Final[Array] = np.zeros((0, 4, 4))


class Grown(NamedTuple):
    """A plant, its foot at the origin.

    Attributes:
        leaves: Faces whose texture coordinates lie in the column of their shade; None where it has
            lobes.
        wood: Its stem; None where none is seen.
        lobes: (N, 4, 4) where `lobe` stands in its crown.
    """

    leaves: Mesh | None
    wood: Mesh | None = None
    lobes: Array = _NO_LOBES


def lobe(rng: np.random.Generator) -> Mesh:
    """A part of a crown, of radius 1: clumps of leaves on a ball."""
    way = _unit(rng.standard_normal((_CLUMPS, 3)))
    at = way * rng.uniform(0.86, 1.16, (_CLUMPS, 1))
    core = sphere(_LOBE_SHARE, segments=_SIDES)
    return joined([_shaded(core, 2), _clumps(rng, at, way, 0.3 * rng.uniform(0.7, 1.3, _CLUMPS))])


def tree(rng: np.random.Generator) -> Grown:
    """A broad-leaved tree; its crown is about three quarters as wide as the tree is high."""
    return Grown(None, _stem(0.026, 0.62), _heap(rng, 11, 0.27, 0.27, 0.6, (0.13, 0.18)))


def bush(rng: np.random.Generator) -> Grown:
    """A bush, wider than high."""
    return Grown(None, None, _heap(rng, 5, 0.36, 0.24, 0.46, (0.26, 0.36)))


def fir(rng: np.random.Generator) -> Grown:
    """A fir: boughs that droop around a stem."""
    count = 420
    drop = rng.random(count) ** 0.7 * 0.9
    angle = rng.uniform(0.0, 2.0 * np.pi, count)
    reach = 0.23 * drop * (0.75 + 0.35 * rng.random(count))
    out = np.stack([np.cos(angle), np.sin(angle), np.full(count, -0.35)], axis=1)
    at = out * np.maximum(reach, 0.012)[:, None]
    at[:, 2] = 0.985 - drop - 0.1 * reach
    flat = np.stack([0.3 * np.cos(angle), 0.3 * np.sin(angle), np.ones(count)], axis=1)
    clumps = _clumps(rng, at, flat, 0.05 + 0.05 * drop, along=out)
    core = frustum(0.16, 0.005, 0.86, segments=_SIDES, base=(0.0, 0.0, 0.1))
    return Grown(joined([_shaded(core, 1), clumps]), _stem(0.02, 0.15))


def hedge(rng: np.random.Generator) -> Grown:
    """A piece of clipped hedge along X, `HEDGE_LONG` long, that repeats, seen from -Y."""
    half, deep = 0.5 * HEDGE_LONG, 0.5 * HEDGE_DEEP
    top, side = HEDGE_LONG * HEDGE_DEEP, HEDGE_LONG
    count = 190
    on_top = rng.random(count) < top / (top + side)
    at = np.stack(
        [
            rng.uniform(-half, half, count),
            np.where(on_top, rng.uniform(-deep, deep, count), -deep),
            np.where(on_top, 0.97, rng.random(count) * 0.98),
        ],
        axis=1,
    )
    out = np.stack([np.zeros(count), np.where(on_top, 0.0, -1.0), np.where(on_top, 1.0, 0.2)], 1)
    core = box((HEDGE_LONG, HEDGE_DEEP - 0.04, 0.95), (0.0, 0.0, 0.475))
    return Grown(joined([_shaded(core, 2), _clumps(rng, at, out, np.full(count, 0.08))]))


PLANTS: Final[Mapping[str, Callable[[np.random.Generator], Grown]]] = MappingProxyType(
    {"tree": tree, "bush": bush, "fir": fir, "hedge": hedge}
)
"""What grows, by name."""


def _heap(
    rng: np.random.Generator,
    count: int,
    wide: float,
    tall: float,
    middle: float,
    radii: tuple[float, float],
) -> Array:
    """(N, 4, 4) lobes around the middle of a crown, each turned otherwise."""
    # Spread evenly over a sphere, so that none is bald.
    turn = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0)) + rng.uniform(0.0, 2.0 * np.pi)
    up = 1.0 - 2.0 * (np.arange(count) + 0.5) / count
    flat = np.sqrt(1.0 - up**2)
    way = np.stack([flat * np.cos(turn), flat * np.sin(turn), up], axis=1)
    made = np.tile(np.eye(4), (count, 1, 1))
    spin, size = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(*radii, count)
    c, s = np.cos(spin) * size, np.sin(spin) * size
    made[:, 0, 0], made[:, 0, 1], made[:, 1, 0], made[:, 1, 1], made[:, 2, 2] = c, -s, s, c, size
    made[:, :3, 3] = way * [wide, wide, tall] * rng.uniform(0.7, 1.05, (count, 1))
    made[:, 2, 3] += middle
    return made


def _clumps(
    rng: np.random.Generator, at: Floats, out: Floats, sizes: Floats, along: Floats | None = None
) -> Mesh:
    """Pointed faces of four corners at (N, 3) places, that look about outwards."""
    count = len(at)
    normal = _unit(_unit(out) + 0.45 * rng.standard_normal((count, 3)))
    first = _unit(
        np.cross(
            normal, rng.standard_normal((count, 3)) if along is None else np.cross(along, normal)
        )
    )
    second = np.cross(normal, first)
    # A long corner, two to the sides, a short one: no two alike.
    long, wide, short = sizes, sizes * rng.uniform(0.45, 0.8, count), 0.7 * sizes
    slant = rng.uniform(-0.3, 0.3, count) * sizes
    corners = np.stack(
        [
            at - short[:, None] * first,
            at + slant[:, None] * first - wide[:, None] * second,
            at + long[:, None] * first,
            at - slant[:, None] * first + wide[:, None] * second,
        ],
        axis=1,
    )
    normals = np.repeat(normal, 4, axis=0).astype(np.float32)
    shade = rng.integers(2, SHADES, count)
    # New shoots at the top are paler.
    shade = np.clip(shade + np.round(2.0 * (normal[:, 2] - 0.3)).astype(int), 2, SHADES - 1)
    st = np.repeat((shade + 0.5) / SHADES, 4)
    return Mesh(
        corners.reshape(-1, 3),
        np.full(count, 4, np.int32),
        np.arange(4 * count, dtype=np.int32),
        normals,
        np.stack([st, np.full(4 * count, 0.5)], axis=1).astype(np.float32),
    )


def _shaded(mesh: Mesh, shade: int) -> Mesh:
    """A mesh all of whose texture coordinates lie in one column."""
    st = np.tile(np.array([(shade + 0.5) / SHADES, 0.5], np.float32), (len(mesh.indices), 1))
    return Mesh(mesh.points, mesh.counts, mesh.indices, mesh.normals, st)


def _stem(radius: float, height: float) -> Mesh:
    return frustum(radius, 0.5 * radius, height, segments=_SIDES)


def _unit(ways: Floats) -> Floats:
    return np.asarray(ways / np.linalg.norm(ways, axis=-1, keepdims=True))
