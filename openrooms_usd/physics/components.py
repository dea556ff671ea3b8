"""Triangles made sound: welded, without repeats, parted into what hangs together."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry import topology
from openrooms_usd.geometry.topology import distinct_rows
from openrooms_usd.geometry.triangulation import has_area
from openrooms_usd.geometry.vectors import crossed, doubled_areas
from openrooms_usd.physics.borders import lids
from openrooms_usd.physics.hulls import finite_points

Ints = NDArray[np.int32]

# Corners closer than this are one, metres.
WELD_M: Final = 1e-6
# Holes of no more area than this share of the squared size are cracks between triangles.
CRACK_AREA_SHARE: Final = 1e-9
# Planes times corners up to which a component is asked whether it is convex.
MAX_CONVEXITY_PAIRS: Final = 1 << 22
# Components whose corners lie no farther in front of any of their triangles are convex, metres.
CONVEX_TOLERANCE_M: Final = 1e-4


@dataclass(frozen=True, eq=False)
class Part:
    """A named surface of one contact material.

    Attributes:
        name: What it is called, for people and for files.
        points: (N, 3) metres, in the frame of its link.
        triangles: (M, 3) rows of ``points``.
        contact: Which contact material it has; shapes never mix two.
    """

    name: str
    points: Array
    triangles: Ints
    contact: str = ""


@dataclass(frozen=True, eq=False)
class Component:
    """Triangles that hang together.

    Attributes:
        corners: (M, 3, 3) metres; counter-clockwise seen from outside where it is closed.
        contact: Its part's contact material.
        part: Its part's name.
        closed: Whether it has an inside: every edge is run along as often in either direction.
    """

    corners: Array
    contact: str
    part: str
    closed: bool

    @cached_property
    def planes(self) -> Array | None:
        """(F, 4) the planes of its triangles where it is closed and convex within the tolerance."""
        return _planes_if_convex(self.corners) if self.closed else None


def components(parts: Sequence[Part]) -> list[Component]:
    """The connected components of some parts, in their order; equal ones once.

    Raises:
        InputError: A part has a coordinate that is not finite or a row that does not exist, or
            nothing has an area.
    """
    found: dict[bytes, Component] = {}
    for part in parts:
        for component in _components(part):
            # Duplicates are recognised by their corners, whatever the order of the triangles.
            rows = np.round(component.corners.reshape(-1, 9) / WELD_M).astype(np.int64)
            key = rows[np.lexsort(rows.T)].tobytes() + part.contact.encode()
            found.setdefault(key, component)
    if not found:
        raise InputError(
            "collision shapes need at least one triangle with an area",
            place=", ".join(part.name for part in parts[:3]) or None,
        )
    return list(found.values())


def _components(part: Part) -> Iterator[Component]:
    points, triangles = _welded(part)
    if not len(triangles):
        return
    label = topology.parts(triangles)
    order = np.argsort(label, kind="stable")
    for rows in np.split(order, np.cumsum(np.bincount(label))[:-1]):
        closed = _is_closed(points, triangles[rows])
        corners = points[triangles[rows]]
        if closed and _signed_volume(corners) < 0.0:
            corners = corners[:, ::-1]
        yield Component(corners, part.contact, part.name, closed)


def _welded(part: Part) -> tuple[Array, NDArray[np.int64]]:
    """Points without duplicates, and the triangles that have an area, each once."""
    triangles = np.asarray(part.triangles, dtype=np.int64).reshape(-1, 3)
    if not len(triangles):
        return np.empty((0, 3)), triangles
    try:
        points = finite_points(part.points)
    except InputError as error:
        raise InputError(error.message, place=part.name, remedy=error.remedy) from error
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise InputError("a triangle refers to a point that does not exist", place=part.name)
    first, places = topology.weld(points, WELD_M)
    points, triangles = points[first], places[triangles]
    triangles = triangles[has_area(points[triangles])]
    once, _ = distinct_rows(np.sort(triangles, axis=1))
    return points, triangles[np.sort(once)]


def _is_closed(points: Array, triangles: NDArray[np.int64]) -> bool:
    """Whether no edge has a free side, but for cracks without an area.

    More than two triangles may meet in an edge: so solids touch each other.
    """
    if not len(topology.open_edges(triangles)[0]):
        return True
    size = float(np.ptp(points[triangles].reshape(-1, 3), axis=0).max())
    found = lids(points, triangles, np.zeros(len(triangles), dtype=np.int64), 1)
    return bool(found.openings[0] <= CRACK_AREA_SHARE * size * size)


def _signed_volume(corners: Array) -> float:
    a, b, c = np.moveaxis(corners - corners.mean(axis=(0, 1)), 1, 0)
    return float(np.einsum("ij,ij->", a, crossed(b, c)))


def _planes_if_convex(corners: Array) -> Array | None:
    """(F, 4) the planes of a closed component's triangles where no corner is in front of one."""
    normals = doubled_areas(corners)
    lengths = np.linalg.norm(normals, axis=1)
    # The planes of slivers are noise.
    sound = lengths > 1e-4 * lengths.max()
    normals = normals[sound] / lengths[sound, None]
    planes = np.column_stack([normals, -np.einsum("ij,ij->i", normals, corners[sound, 0])])
    planes = np.round(planes, 9)
    planes = planes[distinct_rows(planes)[0]]
    points = corners.reshape(-1, 3)
    points = points[distinct_rows(points)[0]]
    if len(planes) * len(points) > MAX_CONVEXITY_PAIRS:
        return None
    return planes if (points @ planes[:, :3].T + planes[:, 3]).max() < CONVEX_TOLERANCE_M else None
