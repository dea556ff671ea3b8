"""CAD models that are fitted to a scan: a mesh, its category, and points on its surface."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.raycast import RayCaster

Symmetry = Literal["none", "2", "4", "inf"]
Up = Literal["X", "Y", "Z"]

# Signed permutations from a CAD's own axes to axes with Z up.
UPRIGHT: Final[dict[Up, Array]] = {
    "X": np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
    "Y": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "Z": np.eye(3),
}
_SEED: Final = 20190617
# Samples of a surface, and candidates for them, of which hidden ones are dropped.
_SURFACE_POINTS: Final = 6000
_CANDIDATE_POINTS: Final = 15000


@dataclass(frozen=True, eq=False)
class CadSurface:
    """Samples of the visible outside of a surface.

    Attributes:
        points: (N, 3).
        normals: (N, 3) unit, to a side that is visible from outside.
        two_sided: (N,) whether both sides are, as those of a sheet.
        spacing: Square root of the area per sample, in the points' unit.
    """

    points: Array
    normals: Array
    two_sided: Mask
    spacing: float


@dataclass(frozen=True, eq=False)
class CadModel:
    """A mesh in its own frame and unit.

    Attributes:
        id: What hints and reports call it.
        category: One of the library's, or the source's own.
        vertices: (V, 3).
        faces: (F, 3) rows of ``vertices``.
        symmetry: About its vertical; None: to be found from the mesh.
        up: Its vertical axis; None: not known.
        unit: Metres of its unit; None: not known.
        sizes: (2, 3) smallest and largest size of a CAD that is built at the size that is found, Z
            up, metres; None: a fixed mesh, which may be stretched a little.
        suits: Of such a CAD: whether a width, depth and height are natural for it, metres.
    """

    id: str
    category: str
    vertices: Array
    faces: NDArray[np.int32]
    symmetry: Symmetry | None = None
    up: Up | None = None
    unit: float | None = None
    sizes: Array | None = None
    suits: Callable[[tuple[float, float, float]], bool] | None = None

    def __post_init__(self) -> None:
        used = self.vertices[self.faces] if len(self.faces) else np.empty((0, 3))
        if not len(used) or not np.isfinite(used).all() or float(np.ptp(used.reshape(-1, 3))) == 0:
            raise InputError(
                f"the CAD {self.id!r} has no surface, or coordinates that are not finite",
                place=self.id,
                remedy="export its mesh again",
            )

    @cached_property
    def extent(self) -> Array:
        """(2, 3) least and greatest coordinates of its faces, in its own frame."""
        used = self.vertices[self.faces].reshape(-1, 3)
        return np.stack([used.min(axis=0), used.max(axis=0)])

    @cached_property
    def surface(self) -> CadSurface:
        """Even samples of the visible surface, deterministic.

        Hidden surfaces, such as the boards of a closed drawer, have none. The winding of the faces
        does not matter.
        """
        points, normals, area = scattered(self.vertices[self.faces], _CANDIDATE_POINTS)
        front, back = _exposed(RayCaster(self.vertices, self.faces), points, normals)
        seen = np.flatnonzero(front | back)
        seen = seen if len(seen) else np.arange(len(points))
        rows = seen[np.linspace(0, len(seen) - 1, min(_SURFACE_POINTS, len(seen))).astype(np.intp)]
        # Shuffled, so that every n-th sample is an even sample, too.
        rows = np.random.default_rng(_SEED).permutation(rows)
        return CadSurface(
            points[rows],
            np.where((front | ~back)[rows, None], normals[rows], -normals[rows]),
            (front == back)[rows],
            float(np.sqrt(area * len(seen) / len(points) / len(rows))),
        )


def scattered(corners: Array, count: int) -> tuple[Array, Array, float]:
    """Stratified samples of triangles (F, 3, 3), their normals, and the total area."""
    a, b, c = np.moveaxis(corners, 1, 0)
    cross = np.cross(b - a, c - a)
    doubled = np.linalg.norm(cross, axis=1)
    rng = np.random.default_rng(_SEED)
    ends = np.cumsum(doubled)
    stations = (np.arange(count) + rng.random(count)) * (ends[-1] / count)
    face = np.minimum(np.searchsorted(ends, stations, side="right"), len(ends) - 1)
    u, v = rng.random((2, count))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    points = a[face] + u[:, None] * (b - a)[face] + v[:, None] * (c - a)[face]
    return points, cross[face] / doubled[face][:, None], 0.5 * float(ends[-1])


def _exposed(caster: RayCaster, points: Array, normals: Array) -> tuple[Mask, Mask]:
    """(N,) each, whether the front and the back of a surface are visible from outside."""
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    front, back = np.zeros((2, len(points)), dtype=np.bool_)
    for direction in _DIRECTIONS:
        side = np.sign(normals @ direction)
        unknown = np.flatnonzero(((side > 0) & ~front) | ((side < 0) & ~back))
        starts = points[unknown] + (1e-4 * size) * side[unknown, None] * normals[unknown]
        free = unknown[~caster.occluded(starts, np.broadcast_to(direction, starts.shape))]
        front[free[side[free] > 0]] = True
        back[free[side[free] < 0]] = True
    return front, back


def _fibonacci(count: int) -> Array:
    """(N, 3) even directions over the sphere."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1)


_DIRECTIONS: Final = _fibonacci(32)
