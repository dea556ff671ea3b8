"""Which turns about the vertical a model does not notice."""

from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.rotations import about_z

Symmetry = Literal["none", "2", "4", "inf"]

# A turned model counts as the same where all but this part of its surface moves by less than
# this, metres: below what depth cameras tell apart.
SHARE: Final = 0.005
DISTANCE: Final = 0.015
SAMPLES: Final = 40_000
TURNED: Final = 4000
# The turns that each symmetry allows, degrees; the odd ones stand for all angles.
TURNS: Final[tuple[tuple[Symmetry, tuple[int, ...]], ...]] = (
    ("inf", (37, 90, 143)),
    ("4", (90, 180)),
    ("2", (180,)),
)


def symmetry_of(vertices: Array, faces: NDArray[np.int64]) -> Symmetry:
    """The symmetry about the vertical through the origin.

    Args:
        vertices: (V, 3) Z up, metres.
        faces: (F, 3) rows of ``vertices``.
    """
    from scipy.spatial import cKDTree

    samples = surface_samples(vertices, faces, SAMPLES, np.random.default_rng(0))
    surface, some = cKDTree(samples), samples[:TURNED]
    for name, angles in TURNS:
        if all(
            np.quantile(surface.query(turned(some, a))[0], 1 - SHARE) < DISTANCE for a in angles
        ):
            return name
    return "none"


def turned(points: Array, degrees: float) -> Array:
    """(N, 3) points after a turn about the vertical."""
    return np.asarray(points @ about_z(-np.radians(degrees)))


def surface_samples(
    vertices: Array, faces: NDArray[np.int64], count: int, random: np.random.Generator
) -> Array:
    """(count, 3) points that are uniform on a surface."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = random.choice(len(faces), count, p=areas / areas.sum())
    u, v = random.random((2, count, 1))
    outside = u + v > 1
    u, v = np.where(outside, 1 - u, u), np.where(outside, 1 - v, v)
    return np.asarray(a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen])
