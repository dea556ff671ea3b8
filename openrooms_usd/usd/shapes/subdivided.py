"""Meshes with a subdivision scheme, as USD describes them: refined, and moved onto their limit."""

import hashlib
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final

import numpy as np
from pxr import UsdGeom
from scipy.sparse import csr_array

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.geometry.cages import Cage, Weights
from openrooms_usd.geometry.subdivision import Refinement, limit, refine, smooth_normals
from openrooms_usd.geometry.triangulation import TriangleMesh, has_area
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.usd.arrays import array_of, integers
from openrooms_usd.usd.places.frames import TIME

# What is sharper stays so, however often it is refined.
_ENDLESS: Final = UsdGeom.Mesh.SHARPNESS_INFINITE


def _sharp(values: Any, count: int) -> Array | None:
    """One sharpness for each of so many; what is beyond USD's greatest is endless."""
    found = array_of(values, np.float64)
    if len(found) != count or not np.isfinite(found).all():
        return None
    return np.where(found >= _ENDLESS, np.inf, np.maximum(found, 0.0))


def read_corners(geometry: UsdGeom.Mesh, count: int) -> Array:
    """(N,) sharpness of each point."""
    found = np.zeros(count)
    rows = integers(geometry.GetCornerIndicesAttr())
    sharp = _sharp(geometry.GetCornerSharpnessesAttr().Get(TIME), len(rows))
    if sharp is not None and len(rows) and rows.min() >= 0 and rows.max() < count:
        np.maximum.at(found, rows, sharp)
    return found


def read_creases(geometry: UsdGeom.Mesh, cage: Cage) -> Array:
    """(K,) sharpness of each edge, at the corners that begin it."""
    edges = np.zeros(len(cage.ends))
    points = integers(geometry.GetCreaseIndicesAttr())
    lengths = integers(geometry.GetCreaseLengthsAttr())
    if not len(lengths) or lengths.min() < 2 or lengths.sum() != len(points):
        return edges[cage.edges]
    # Edges of one crease follow each other; between creases there is none.
    inner = np.ones(len(points), dtype=np.bool_)
    inner[np.cumsum(lengths) - 1] = False
    starts = np.flatnonzero(inner)
    pairs = np.sort(np.stack([points[starts], points[starts + 1]], axis=1), axis=1)
    said = geometry.GetCreaseSharpnessesAttr().Get(TIME)
    sharp = _sharp(said, len(lengths))
    sharp = _sharp(said, len(pairs)) if sharp is None else np.repeat(sharp, lengths - 1)
    if sharp is None:
        return edges[cage.edges]
    size = len(cage.corners) + 1
    keys = cage.ends[:, 0] * size + cage.ends[:, 1]
    wanted = pairs[:, 0] * size + pairs[:, 1]
    at = np.searchsorted(keys, wanted)
    there = (at < len(keys)) & (keys[np.minimum(at, len(keys) - 1)] == wanted)
    np.maximum.at(edges, at[there], sharp[there])
    return edges[cage.edges]


# How often faces are refined, and of one mesh the most triangles before that is less often.
LEVELS: Final = 2
_MOST_TRIANGLES: Final = 400_000
# How many topologies are kept; large ones take some hundred megabytes together.
_MOST_TOPOLOGIES: Final = 16

_T: Final = UsdGeom.Tokens


class Topologies:
    """What refining polygons gives depends on their topology alone: of equal ones it is kept.

    Sets of furniture, crowds and what moves over time are many meshes of few topologies.
    """

    def __init__(self) -> None:
        self._known: OrderedDict[bytes, tuple[Refinement, Weights]] = OrderedDict()

    def refined(
        self, cage: Cage, scheme: str, levels: int, *, linear: bool, smooth_triangles: bool
    ) -> tuple[Refinement, Weights]:
        """The fine polygons, and where their points lie on the limit; see `refine` and `limit`."""
        key = hashlib.blake2b(f"{scheme} {levels} {linear} {smooth_triangles}".encode())
        for part in (cage.counts, cage.indices, cage.creases, cage.corners):
            key.update(f"{part.dtype.str} {len(part)}".encode())
            key.update(np.ascontiguousarray(part).data)
        name = key.digest()
        if name not in self._known:
            fine = refine(cage, scheme, levels, linear=linear, smooth_triangles=smooth_triangles)
            onto = fine.weights if linear else csr_array(limit(fine.cage, scheme) @ fine.weights)
            self._known[name] = fine, onto
            if len(self._known) > _MOST_TOPOLOGIES:
                self._known.popitem(last=False)
        self._known.move_to_end(name)
        return self._known[name]


@dataclass(frozen=True, eq=False)
class Subdivided:
    """A mesh prim whose faces are refined.

    Attributes:
        geometry: The prim.
        points: (N, 3) of the control cage.
        cage: The control cage.
        scheme: ``catmullClark``, ``loop`` or ``bilinear``.
        holes: Faces that are not drawn.
        topologies: Those that were refined before.
    """

    geometry: UsdGeom.Mesh
    points: Array
    cage: Cage
    scheme: str
    holes: Ints
    topologies: Topologies

    @staticmethod
    def read(
        geometry: UsdGeom.Mesh,
        points: Array,
        counts: Any,
        indices: Any,
        topologies: Topologies | None = None,
    ) -> "Subdivided":
        """What a prim says of its edges, corners and boundaries; what does not fit is left out."""
        counts, indices = np.asarray(counts, np.int64), np.asarray(indices, np.int64)
        smooth = Cage(counts, indices, np.zeros(len(indices)), np.zeros(len(points)))
        creases, corners = read_creases(geometry, smooth), read_corners(geometry, len(points))
        holes = integers(geometry.GetHoleIndicesAttr())
        boundary = geometry.GetInterpolateBoundaryAttr().Get(TIME)
        if boundary == _T.none:
            open_points = np.unique(smooth.ends[smooth.is_open])
            beside = smooth.faces[np.isin(indices, open_points)]
            holes = np.union1d(holes, beside)
        elif boundary != _T.edgeOnly:
            corners[np.bincount(indices, minlength=len(points)) == 1] = np.inf
        cage = replace(smooth, creases=creases, corners=corners)
        scheme = str(geometry.GetSubdivisionSchemeAttr().Get(TIME))
        return Subdivided(geometry, points, cage, scheme, holes, topologies or Topologies())

    def unfit(self) -> str | None:
        """Why it cannot be refined, if so."""
        if (self.cage.counts < 3).any():
            return "it has faces of less than three corners"
        if self.scheme == _T.loop and (self.cage.counts != 3).any():
            return "loop refines only triangles"
        if self.scheme not in (_T.catmullClark, _T.loop, _T.bilinear):
            return f"there is no scheme {self.scheme}"
        return None

    @cached_property
    def levels(self) -> int:
        """How often faces are refined."""
        first = 2 * len(self.cage.indices) if self.scheme != _T.loop else 4 * len(self.cage.counts)
        found = 1
        while found < LEVELS and first * 4**found <= _MOST_TRIANGLES:
            found += 1
        return found

    @property
    def refinement(self) -> Refinement:
        """The fine polygons."""
        return self._refined(self.cage)[0]

    def mesh(
        self,
        uvs: Mapping[str, Array],
        colors: Mapping[str, Array],
        *,
        left_handed: bool = False,
        bare: bool = False,
    ) -> TriangleMesh:
        """Its triangles, with smooth normals that break at sharp edges, or flat ones.

        Args:
            uvs: (K', 2) texture coordinates at the corners of the fine faces, by their name.
            colors: (K', 3) colours at these, likewise.
            left_handed: Whether faces are seen from where they turn clockwise.
            bare: Whether normals are left out.
        """
        refinement, onto = self._refined(self.cage)
        cage, faces = refinement.cage, refinement.faces
        points = onto @ self.points
        corners = np.arange(len(cage.indices)).reshape(len(cage.counts), -1)
        if corners.shape[1] == 4:
            corners = corners[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)
            faces = np.repeat(faces, 2)
        seen = ~np.isin(faces, self.holes) & has_area(points[cage.indices[corners]])
        corners, faces = corners[seen], faces[seen]
        # Bilinear surfaces are flat between the edges of the cage.
        flat = bare or self.scheme == _T.bilinear
        normals = None if flat else smooth_normals(cage, points)[corners]
        if normals is not None:
            # Where faces lie back to back those around a point add up to nothing.
            none = ~normals.any(axis=-1, keepdims=True)
            normals = np.where(none, _flat_normals(points[cage.indices[corners]]), normals)
        if left_handed:
            corners = corners[:, ::-1]
            normals = None if normals is None else -normals[:, ::-1]
        return TriangleMesh(
            points,
            cage.indices[corners].astype(np.int32),
            faces.astype(np.int32),
            None if normals is None else normals.astype(np.float32),
            {name: values[corners].astype(np.float32) for name, values in uvs.items()},
            None,
            {name: values[corners].astype(np.float32) for name, values in colors.items()},
        )

    # What is carried along.

    def carried(self, values: Array, indices: Ints, interpolation: str) -> Array | None:
        """(K', ...) a primvar's values at the corners of the fine faces; None if they do not fit.

        Args:
            values: (P, ...) its values.
            indices: Of its elements; empty where it has none.
            interpolation: As USD names it.
        """
        cage, fine = self.cage, self.refinement.cage
        sizes = {
            _T.constant: 1,
            _T.uniform: len(cage.counts),
            _T.faceVarying: len(cage.indices),
            _T.vertex: len(cage.corners),
            _T.varying: len(cage.corners),
        }
        if len(values) == 1 and not len(indices):
            # One value alone is that of all, whatever its interpolation.
            interpolation = _T.constant
        rows = indices if len(indices) else np.arange(len(values))
        if len(rows) != sizes.get(interpolation) or rows.min() < 0 or rows.max() >= len(values):
            return None
        if interpolation == _T.faceVarying:
            return self._face_varying(values, rows)
        own = np.asarray(values[rows], np.float64)
        if interpolation == _T.constant:
            return np.repeat(own, len(fine.indices), axis=0)
        if interpolation == _T.uniform:
            return own[self.refinement.faces[fine.faces]]
        if interpolation == _T.varying:
            linear, weights = self._refined(self.cage, linear=True)
            return np.asarray(weights @ own)[linear.cage.indices]
        return np.asarray(self._refined(self.cage)[1] @ own)[fine.indices]

    def _face_varying(self, values: Array, rows: Ints) -> Array:
        """Smooth where values are one, and as ``faceVaryingLinearInterpolation`` says elsewhere."""
        cage = self.cage
        # One value of one point: where equal values have several indices they are the same.
        _, same = np.unique(values, axis=0, return_inverse=True)
        keys = np.stack([cage.indices, same.reshape(-1)[rows]], axis=1)
        found, first, indices = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        indices = indices.reshape(-1)
        own = Cage(cage.counts, indices, cage.creases, cage.corners[found[:, 0]])
        rule = self.geometry.GetFaceVaryingLinearInterpolationAttr().Get(TIME)
        if rule == _T.all or self.scheme == _T.bilinear:
            fine, weights = self._refined(own, linear=True)
            return np.asarray(weights @ values[rows[first]])[fine.cage.indices]
        own.corners[_pinned(own, found[:, 0], cage, rule)] = np.inf
        fine, weights = self._refined(own)
        return np.asarray(weights @ values[rows[first]])[fine.cage.indices]

    def _refined(self, cage: Cage, *, linear: bool = False) -> tuple[Refinement, Weights]:
        rule = self.geometry.GetTriangleSubdivisionRuleAttr().Get(TIME)
        smooth = rule == _T.smooth
        return self.topologies.refined(
            cage, self.scheme, self.levels, linear=linear, smooth_triangles=smooth
        )


def _pinned(values: Cage, points: Ints, cage: Cage, rule: str) -> Mask:
    """Which values of a face-varying primvar stay where they are.

    Args:
        values: The polygons of the values, open where they differ between faces.
        points: (V,) the point of each value.
        cage: The polygons of the points.
        rule: ``faceVaryingLinearInterpolation``, other than ``all``.
    """
    pinned = np.zeros(len(points), dtype=np.bool_)
    if rule == _T.none:
        return pinned
    if rule == _T.boundaries:
        pinned[values.ends[values.is_open]] = True
        return pinned
    alone = np.bincount(values.indices, minlength=len(points)) == 1
    pinned |= alone
    if rule == _T.cornersOnly:
        return pinned
    number = np.bincount(points)[points]
    pinned |= number > 2
    if rule == _T.cornersPlus2:
        # Where a border between values ends inside, and around a corner of other values.
        seam = values.is_open[values.edges] & ~cage.is_open[cage.edges]
        darts = np.zeros(len(points), dtype=np.bool_)
        darts[values.indices[seam]] = darts[values.indices[values.after[seam]]] = True
        pinned |= darts & (number == 1)
        pinned |= (number == 2) & (np.bincount(points, weights=alone)[points] > 0)
    return pinned


def _flat_normals(triangles: Array) -> Array:
    """(M, 1, 3) the unit normal of each of (M, 3, 3) triangles, all of which have an area."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    return unit(np.cross(b - a, c - a))[:, None]
