"""What of a triangle mesh encloses a volume: its components, their winding, holes and cavities.

Meshes from anywhere: corners at one place are one point, triangles that share an edge are one
component, and each component is judged by itself.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.topology import weld
from openrooms_usd.physics.borders import components, lids, sums, vector_areas

# Corners nearer than this share of the diagonal are one point.
_WELD_SHARE: Final = 1e-6
# Holes of up to this share of a component's area are closed: a sofa without an underside.
_OPENING_AREA_SHARE: Final = 0.25
# Holes of less than this share of the area are cracks between triangles and are not reported.
_CRACK_AREA_SHARE: Final = 1e-3
# A component that has less than this share of (its area)^1.5 for a volume is a sheet of two sides.
_FLAT_VOLUME_SHARE: Final = 1e-9


@dataclass(frozen=True, eq=False)
class Enclosure:
    """A mesh by its components, about an origin of its own.

    Attributes:
        origin: (3,) where its local frame stands in that of the points; axes are the same.
        points: (N, 3) local points, each place once.
        triangles: (M, 3) rows of ``points``; outwards where its component encloses anything.
        labels: (M,) the component of each triangle; a cavity is one with the body round it.
        lids: (L, 3, 3) local corners of the triangles that close the holes, outwards.
        lid_labels: (L,) their components.
        areas: (K,) area of each component without lids, m2.
        volumes: (K,) what each encloses, less its cavities, m3; 0 where it encloses nothing.
        two_sided: (K,) components whose triangles show both sides of a sheet.
        notes: What was mended, one sentence each.
    """

    origin: Array
    points: Array
    triangles: Ints
    labels: Ints
    lids: Array
    lid_labels: Ints
    areas: Array
    volumes: Array
    two_sided: Mask
    notes: tuple[str, ...]

    @property
    def corners(self) -> Array:
        """(M, 3, 3) the corners of the triangles, local."""
        return self.points[self.triangles]


def examined(points: ArrayLike, triangles: ArrayLike) -> Enclosure:
    """Take a mesh apart, and turn its components outwards.

    Args:
        points: (N, 3) metres.
        triangles: (M, 3) rows of ``points``.

    Raises:
        InputError: A number is not finite, a triangle has a point that is not there, or nothing has
            any area.
    """
    origin, local, faces = _welded(*_valid(points, triangles))
    labels, turned, one_sided = components(faces)
    faces, count = np.where(turned[:, None], faces[:, ::-1], faces), int(labels.max()) + 1
    areas = sums(labels, np.linalg.norm(vector_areas(local[faces]), axis=1), count)
    closing = lids(local, faces, labels, count)
    volumes = _volumes(local[faces], labels, count)
    volumes += _volumes(closing.corners, closing.labels, count)
    cracked, flat = (
        closing.openings <= _CRACK_AREA_SHARE * areas,
        abs(volumes) <= _FLAT_VOLUME_SHARE * areas**1.5,
    )
    encloses = ~flat & ~one_sided & (closing.openings <= _OPENING_AREA_SHARE * areas)
    kept = encloses[closing.labels]
    mended = {
        "triangles wound against their neighbours were turned": turned.any(),
        "holes were closed": (encloses & ~cracked).any(),
    }
    return _outwards(
        Enclosure(
            origin,
            local,
            faces,
            labels,
            closing.corners[kept],
            closing.labels[kept],
            areas,
            np.where(encloses, volumes, 0.0),
            flat & cracked,
            tuple(note for note, holds in mended.items() if holds),
        )
    )


def _valid(points: ArrayLike, triangles: ArrayLike) -> tuple[Array, Ints]:
    places = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    faces = np.asarray(triangles, dtype=np.int64).reshape(-1, 3)
    if faces.size and (faces.min() < 0 or faces.max() >= len(places)):
        raise InputError(
            f"a triangle has a corner that is not among the mesh's {len(places)} points",
            remedy="export the model again",
        )
    if not np.isfinite(places[faces]).all():
        raise InputError(
            "a corner of the mesh has a coordinate that is not a finite number",
            remedy="export the model again, or take the broken part out",
        )
    if not faces.size:
        raise _nothing()
    return places, faces


def _welded(points: Array, faces: Ints) -> tuple[Array, Array, Ints]:
    """The origin, the local points, and the triangles that still have three corners."""
    used, rows = np.unique(faces, return_inverse=True)
    low, high = points[used].min(axis=0), points[used].max(axis=0)
    origin = 0.5 * (low + high)
    step = _WELD_SHARE * float(np.linalg.norm(high - low))
    if not step > 0:
        raise _nothing()
    local = points[used] - origin
    first, place = weld(points[used], step)
    local, faces = local[first], place[rows.reshape(-1, 3)]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    if not np.linalg.norm(vector_areas(local[faces]), axis=1).sum() > 0:
        raise _nothing()
    return origin, local, faces


def _nothing() -> InputError:
    return InputError(
        "the mesh has no surface, so it has no mass",
        remedy="remove it, or give the object its own mass and shape",
    )


def _volumes(corners: Array, labels: Ints, count: int) -> Array:
    """(count,) signed volumes between the triangles of each label and the origin."""
    return sums(labels, np.linalg.det(corners) / 6.0, count)


def _outwards(found: Enclosure) -> Enclosure:
    """Components turned so that they enclose positive volumes, and cavities joined to bodies."""
    count, owner = len(found.volumes), np.arange(len(found.volumes))
    turn = np.full(count, found.volumes.sum() < 0)
    outward = np.where(turn, -found.volumes, found.volumes) > 0
    for k in np.flatnonzero(~outward & (found.volumes != 0)):
        inside = [abs(_windings(found, point)) > 0.5 for point in _extremes(found, int(k))]
        around = np.flatnonzero(outward & np.all(inside, axis=0))
        if len(around):
            owner[k] = around[np.argmin(abs(found.volumes[around]))]
        else:
            turn[k] = ~turn[k]
    volumes = sums(owner, np.where(turn, -found.volumes, found.volumes), count)
    inside_out = (turn & (found.volumes != 0)).any()
    told = ("a surface that was inside out was turned",) if inside_out else ()
    return Enclosure(
        found.origin,
        found.points,
        np.where(turn[found.labels, None], found.triangles[:, ::-1], found.triangles),
        owner[found.labels],
        np.where(turn[found.lid_labels, None, None], found.lids[:, ::-1], found.lids),
        owner[found.lid_labels],
        sums(owner, found.areas, count),
        volumes,
        found.two_sided,
        found.notes + told,
    )


def _extremes(found: Enclosure, k: int) -> Array:
    """(6, 3) the outermost points of component k along the axes."""
    points = found.corners[found.labels == k].reshape(-1, 3)
    return np.asarray(points[[*points.argmin(axis=0), *points.argmax(axis=0)]])


def _windings(found: Enclosure, point: Array) -> Array:
    """(K,) how often each component goes round a point.

    By the solid angles of their triangles: Van Oosterom and Strackee, "The Solid Angle of a Plane
    Triangle", IEEE Trans. Biomed. Eng. 30 (1983).
    """
    corners = np.concatenate([found.corners, found.lids]) - point
    labels = np.concatenate([found.labels, found.lid_labels])
    a, b, c = np.moveaxis(corners, 1, 0)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", p, q) for p, q in ((a, b), (b, c), (c, a)))
    below = la * lb * lc + ab * lc + bc * la + ca * lb
    angles = 2.0 * np.arctan2(np.linalg.det(corners), below)
    return sums(labels, angles, len(found.volumes)) / (4.0 * np.pi)
