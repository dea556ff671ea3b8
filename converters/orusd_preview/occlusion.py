"""Ambient occlusion: how much of the hemisphere over a point is free of what is near."""

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.geometry.raycast import RayCaster

Array = NDArray[np.float64]

# Rays begin this far above their surface, metres: single precision puts points below it.
_LIFT_METRES: Final = 1e-3
# Steps that fill a square evenly however many they are: inverse powers of the plastic number, the
# root of x^3 = x + 1 (M. Roberts, The Unreasonable Effectiveness of Quasirandom Sequences, 2018).
_LATTICE_STEPS: Final = 1.324717957244746 ** np.array([-1.0, -2.0])
# Points that are worked on at once: some 200 bytes each.
_POINTS_A_BATCH: Final = 1 << 19


def openness(
    caster: RayCaster,
    points: Array,
    normals: Array,
    rays: int,
    reach: float,
    rng: np.random.Generator,
    progress: Callable[[float], None] = lambda fraction: None,
) -> Array:
    """(P,) the part of the hemispheres that is free, weighted by the cosine; 1 in the open.

    What is at a distance d blocks a part 1 - d / reach of the light: each ray has a length of its
    own, even between 0 and the reach. The rays of a point are a lattice over the hemisphere, which
    every point shifts at random (Cranley and Patterson 1976).

    Args:
        caster: What may be near.
        points: (P, 3) on surfaces, metres.
        normals: (P, 3) unit, on the side that counts.
        rays: For each point.
        reach: Farther away nothing counts, metres.
        rng: Shifts the lattices.
        progress: Called with the finished fraction.
    """
    free = np.zeros(len(points))
    shifts = rng.random((len(points), 3))
    for start in range(0, len(points), _POINTS_A_BATCH):
        part = slice(start, start + _POINTS_A_BATCH)
        origins = points[part] + _LIFT_METRES * normals[part]
        across, along = _tangents(normals[part])
        for number in range(rays):
            lattice = np.array([(number + 0.5) / rays, *(number * _LATTICE_STEPS)])
            u, v, w = ((lattice + shifts[part]) % 1.0).T
            radius, phi = np.sqrt(u), 2.0 * np.pi * v
            directions = (
                (radius * np.cos(phi))[:, None] * across
                + (radius * np.sin(phi))[:, None] * along
                + np.sqrt(1.0 - u)[:, None] * normals[part]
            )
            free[part] += ~caster.occluded(origins, directions, reach * w)
            progress((start + len(origins) * (number + 1) / rays) / len(points))
    return free / rays


def _tangents(normals: Array) -> tuple[Array, Array]:
    """Two unit vectors that are normal to each unit vector and to each other.

    Without a root or a branch (T. Duff et al., Building an Orthonormal Basis, Revisited, 2017).
    """
    x, y, z = normals.T
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    return (
        np.column_stack([1.0 + sign * x * x * a, sign * b, -sign * x]),
        np.column_stack([b, sign + y * y * a, -y]),
    )
