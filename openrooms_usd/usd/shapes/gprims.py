"""One geometric prim as triangles: topology, normals and texture coordinates, checked and unrolled.

What is drawn less well than it was meant, or not at all, comes with a reason.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array, Floats, Mask
from openrooms_usd.geometry.triangulation import Ints, TriangleMesh, triangulate
from openrooms_usd.usd.arrays import array_of, flattened, in_rows
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.shapes.tessellation import Drawn, tessellate

if TYPE_CHECKING:
    from openrooms_usd.usd.shapes.subdivided import Subdivided, Topologies

Loss = tuple[Literal["approximated", "skipped"], str]

_UV_TYPES: Final = frozenset(
    {
        Sdf.ValueTypeNames.TexCoord2fArray,
        Sdf.ValueTypeNames.TexCoord2dArray,
        Sdf.ValueTypeNames.TexCoord2hArray,
        Sdf.ValueTypeNames.Float2Array,
        Sdf.ValueTypeNames.Double2Array,
        Sdf.ValueTypeNames.Half2Array,
    }
)
# Their third number is not a texture coordinate.
_UVW_TYPES: Final = frozenset(
    {
        Sdf.ValueTypeNames.TexCoord3fArray,
        Sdf.ValueTypeNames.TexCoord3dArray,
        Sdf.ValueTypeNames.TexCoord3hArray,
    }
)


_COLOR_TYPES: Final = frozenset(
    {
        Sdf.ValueTypeNames.Color3fArray,
        Sdf.ValueTypeNames.Color3dArray,
        Sdf.ValueTypeNames.Color3hArray,
        Sdf.ValueTypeNames.Float3Array,
    }
)


_OPACITY: Final = "displayOpacity"
# The cosine between a normal and its triangle's at which no smoothing can be the cause.
_SURELY_BEHIND: Final = -0.5


@dataclass(frozen=True)
class GprimSurface:
    """What a prim gives to draw.

    Attributes:
        mesh: None when there is nothing to draw.
        double_sided: Whether its back is seen too.
        losses: What was approximated, or why it was skipped.
    """

    mesh: TriangleMesh | None
    double_sided: bool = False
    losses: tuple[Loss, ...] = ()


def read_surface(
    prim: Usd.Prim, *, bare: bool = False, topologies: "Topologies | None" = None
) -> GprimSurface:
    """The triangles of a ``UsdGeom.Gprim`` in its local frame.

    Args:
        prim: It.
        bare: Whether normals and texture coordinates are left out.
        topologies: Those of subdivision surfaces that were refined before.
    """
    double_sided = bool(UsdGeom.Gprim(prim).GetDoubleSidedAttr().Get(TIME))
    if prim.IsA(UsdGeom.Mesh):
        return _Polygons(prim, double_sided, topologies).surface(bare)
    kind = prim.GetTypeName()
    reader = _reader(kind)
    drawn = Drawn(tessellate(prim)) if reader is None else reader(prim)
    polygons, losses = drawn.mesh, drawn.losses
    if polygons is None:
        reason = "; ".join(losses) or f"{kind} without a known surface"
        return GprimSurface(None, losses=(("skipped", reason),))
    corners, faces = triangulate(polygons.points, polygons.counts, polygons.indices)
    if not len(faces):
        return GprimSurface(None, losses=(("skipped", "no face has an area"),))
    turned = _left_handed(prim)
    if turned:
        corners = corners[:, ::-1]
    normals = None if bare or polygons.normals is None else polygons.normals[corners]
    if turned and normals is not None and reader is not None:
        normals = -normals
    uvs = {} if bare or polygons.st is None else {names.ST: polygons.st[corners]}
    triangles = polygons.indices[corners]
    colors = {} if bare else _colors_along(prim, drawn, triangles)
    mesh = TriangleMesh(polygons.points, triangles, faces, normals, uvs, colors=colors)
    # Ribbons of curves are seen from both sides, tubes have no other.
    both = double_sided or prim.IsA(UsdGeom.Curves)
    return GprimSurface(mesh, both, tuple(("approximated", one) for one in losses))


def _colors_along(prim: Usd.Prim, drawn: Drawn, triangles: Ints) -> dict[str, NDArray[Any]]:
    """(M, 3, C) what primvars of colours are at the corners of what is drawn, by their names."""
    found = {}
    for primvar, width in _painting(prim):
        values = in_rows(array_of(flattened(primvar), np.float64, width))
        at = drawn.at_points(values, primvar.GetInterpolation())
        if at is not None and np.isfinite(at).all():
            found[primvar.GetPrimvarName()] = at[triangles].astype(np.float32)
    return found


def _painting(prim: Usd.Prim) -> Iterator[tuple[UsdGeom.Primvar, int | None]]:
    """Primvars of colours, and displayOpacity, with more than one value; and how wide these are."""
    for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithValues():
        if primvar.GetInterpolation() == UsdGeom.Tokens.constant:
            continue
        if primvar.GetTypeName() in _COLOR_TYPES:
            yield primvar, 3
        elif primvar.GetPrimvarName() == _OPACITY:
            yield primvar, None


def _reader(kind: str) -> Callable[[Usd.Prim], Drawn] | None:
    """For prims other than polygons: how polygons are made, and what was approximated.

    It is imported here, since most stages have none and scipy is slow to import.
    """
    if kind in ("BasisCurves", "HermiteCurves", "NurbsCurves"):
        from openrooms_usd.usd.shapes.curves import read_curves

        return read_curves
    if kind in ("NurbsPatch", "Points", "TetMesh"):
        from openrooms_usd.usd.shapes import patches

        return {
            "NurbsPatch": patches.read_patch,
            "Points": patches.read_points,
            "TetMesh": patches.read_tetrahedra,
        }[kind]
    return None


def _against(normals: NDArray[Any], flat: NDArray[Any]) -> Mask:
    """(M, 3) which normals at corners have the wrong sign.

    Those of smooth surfaces may lie a little below the horizon of their triangle, where the others
    of it do not.

    Args:
        normals: (M, 3, 3) unit.
        flat: (M, 3) unit, of the triangles' fronts.
    """
    facing = np.einsum("mki,mi->mk", normals, flat)
    against = facing < _SURELY_BEHIND
    below = np.where(against, -facing, facing).sum(axis=1) < 0.0
    return np.asarray(against ^ below[:, None])


def _left_handed(prim: Usd.Prim) -> bool:
    return bool(UsdGeom.Gprim(prim).GetOrientationAttr().Get(TIME) == UsdGeom.Tokens.leftHanded)


def _usual_first(sets: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Texture coordinates by name, those that consumers of a single set take first."""
    return dict(sorted(sets.items(), key=lambda item: (item[0] != names.ST, item[0])))


class _Polygons:
    """The reading of one mesh prim; it gathers the losses on its way."""

    def __init__(self, prim: Usd.Prim, double_sided: bool, topologies: "Topologies | None") -> None:
        self._topologies = topologies
        self._geometry = UsdGeom.Mesh(prim)
        self._double_sided = double_sided
        self._losses: list[Loss] = []
        self._points = array_of(self._geometry.GetPointsAttr().Get(TIME), np.float64, 3)
        self._counts = array_of(self._geometry.GetFaceVertexCountsAttr().Get(TIME), np.int32)
        self._indices = array_of(self._geometry.GetFaceVertexIndicesAttr().Get(TIME), np.int32)

    def surface(self, bare: bool) -> GprimSurface:
        reason = self._invalid()
        if reason is not None:
            return GprimSurface(None, losses=(("skipped", reason),))
        if self._geometry.GetSubdivisionSchemeAttr().Get(TIME) != UsdGeom.Tokens.none:
            refined = self._refined(bare)
            if refined is not None:
                return refined
        corners, faces = triangulate(self._points, self._counts, self._indices)
        seen = ~np.isin(faces, self._holes())
        corners, faces = corners[seen], faces[seen]
        if not len(faces):
            return GprimSurface(None, losses=(("skipped", "no face has an area"),))
        if _left_handed(self._geometry.GetPrim()):
            corners = np.ascontiguousarray(corners[:, ::-1])
        normals = None if bare else self._normals(corners, faces)
        uvs = {} if bare else self._flat(self._sets(self._coordinates(), corners, faces))
        colors = {} if bare else self._sets(_painting(self._geometry.GetPrim()), corners, faces)
        triangles = self._indices[corners]
        mesh = TriangleMesh(self._points, triangles, faces, normals, uvs, corners, colors)
        return GprimSurface(mesh, self._double_sided, tuple(self._losses))

    def _invalid(self) -> str | None:
        """Why there is nothing that could be drawn, if so."""
        if not len(self._points) or not len(self._counts):
            return "it has no points or no faces"
        if (self._counts < 0).any() or self._counts.sum(dtype=np.int64) != len(self._indices):
            return "faceVertexCounts do not add up to the number of faceVertexIndices"
        if self._indices.min(initial=0) < 0 or self._indices.max(initial=0) >= len(self._points):
            return "faceVertexIndices refer to points that do not exist"
        if not np.isfinite(self._points).all():
            return "points hold NaN or infinity"
        return None

    def _holes(self) -> Ints:
        return array_of(self._geometry.GetHoleIndicesAttr().Get(TIME), np.int32)

    def _refined(self, bare: bool) -> GprimSurface | None:
        """It as a subdivision surface; None, with a reason, where that cannot be."""
        from openrooms_usd.usd.shapes.subdivided import Subdivided

        fine = Subdivided.read(
            self._geometry, self._points, self._counts, self._indices, self._topologies
        )
        if unfit := fine.unfit():
            self._lose(f"a {fine.scheme} subdivision surface is drawn as its control cage: {unfit}")
            return None
        uvs = {} if bare else self._flat(self._carried(fine, self._coordinates()))
        colors = {} if bare else self._carried(fine, _painting(self._geometry.GetPrim()))
        left_handed = _left_handed(self._geometry.GetPrim())
        mesh = fine.mesh(uvs, colors, left_handed=left_handed, bare=bare)
        if not len(mesh.faces):
            return GprimSurface(None, losses=(("skipped", "no face has an area"),))
        how = f"a {fine.scheme} subdivision surface is refined {fine.levels} times"
        self._lose(f"{how}, its points on the limit surface")
        return GprimSurface(mesh, self._double_sided, tuple(self._losses))

    def _carried(
        self, fine: "Subdivided", primvars: Iterable[tuple[UsdGeom.Primvar, int | None]]
    ) -> dict[str, Array]:
        """(K', width) primvars at the corners of fine faces, by their names."""
        sets = {}
        for primvar, width in primvars:
            values = in_rows(array_of(primvar.Get(TIME), np.float64, width))
            indices = array_of(primvar.GetIndices(TIME), np.int64)
            carried = fine.carried(values, indices, primvar.GetInterpolation())
            name = primvar.GetPrimvarName()
            if carried is None or not np.isfinite(carried).all():
                self._lose(f"primvars:{name} do not fit the faces and are left out")
            else:
                sets[name] = carried
        return sets

    def _lose(self, reason: str) -> None:
        self._losses.append(("approximated", reason))

    def _normals(self, corners: Ints, faces: Ints) -> Floats | None:
        primvar = UsdGeom.PrimvarsAPI(self._geometry).GetPrimvar("normals")
        if primvar and primvar.HasValue():
            values, indices = primvar.Get(TIME), primvar.GetIndices(TIME)
            interpolation = primvar.GetInterpolation()
        else:
            values, indices = self._geometry.GetNormalsAttr().Get(TIME), None
            interpolation = self._geometry.GetNormalsInterpolation()
        vectors = array_of(values, np.float64, 3)
        if not len(vectors):
            return None
        rows = self._rows(interpolation, corners, faces)
        unrolled = self._unrolled(vectors, array_of(indices, np.int32), rows, "normals")
        return None if unrolled is None else self._unit(unrolled, corners)

    def _unit(self, normals: NDArray[Any], corners: Ints) -> Floats:
        """Unit normals on the front of their faces; the face's own where one is not usable."""
        with np.errstate(over="ignore", invalid="ignore"):
            lengths = np.linalg.norm(normals, axis=-1, keepdims=True)
        usable = np.isfinite(lengths) & (lengths > 0)
        units = np.where(usable, normals, 0.0) / np.where(usable, lengths, 1.0)
        a, b, c = np.moveaxis(self._points[self._indices[corners]], 1, 0)
        flat = np.cross(b - a, c - a)
        flat /= np.linalg.norm(flat, axis=1, keepdims=True)
        units = np.where(usable, units, flat[:, None])
        against = _against(units, flat)
        if against.any():
            units[against] *= -1.0
            count = int(against.any(axis=1).sum())
            of = "all" if count == len(corners) else f"{count} of {len(corners)}"
            self._lose(f"normals oppose the winding of {of} triangles and are flipped")
        return units.astype(np.float32)

    def _sets(
        self, primvars: Iterable[tuple[UsdGeom.Primvar, int | None]], corners: Ints, faces: Ints
    ) -> dict[str, Floats]:
        """(M, 3, width) primvars at each corner, by their names."""
        sets: dict[str, Floats] = {}
        for primvar, width in primvars:
            values = in_rows(array_of(primvar.Get(TIME), np.float32, width))
            indices = array_of(primvar.GetIndices(TIME), np.int32)
            rows = self._rows(primvar.GetInterpolation(), corners, faces)
            name = primvar.GetPrimvarName()
            unrolled = self._unrolled(values, indices, rows, f"primvars:{name}")
            if unrolled is not None:
                sets[name] = unrolled
        return sets

    def _coordinates(self) -> list[tuple[UsdGeom.Primvar, int]]:
        """Primvars of texture coordinates, and how many numbers each has."""
        found = UsdGeom.PrimvarsAPI(self._geometry).GetPrimvarsWithValues()
        widths = {**dict.fromkeys(_UV_TYPES, 2), **dict.fromkeys(_UVW_TYPES, 3)}
        return [(one, widths[kind]) for one in found if (kind := one.GetTypeName()) in widths]

    def _flat(self, sets: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        """Texture coordinates without a third number, the usual ones first."""
        for name, values in sets.items():
            if values.shape[-1] == 3 and np.ptp(values[..., 2]):
                self._lose(f"primvars:{name} have three numbers, and the first two are read")
        plane = {name: np.ascontiguousarray(values[..., :2]) for name, values in sets.items()}
        return _usual_first(plane)

    def _rows(self, interpolation: str, corners: Ints, faces: Ints) -> NDArray[Any] | None:
        """(M, 3) the element of a primvar that each corner takes; None for an unknown word."""
        rows: dict[str, Callable[[], NDArray[Any]]] = {
            UsdGeom.Tokens.constant: lambda: np.zeros_like(corners),
            UsdGeom.Tokens.uniform: lambda: np.repeat(faces[:, None], 3, axis=1),
            UsdGeom.Tokens.vertex: lambda: self._indices[corners],
            UsdGeom.Tokens.varying: lambda: self._indices[corners],
            UsdGeom.Tokens.faceVarying: lambda: corners,
        }
        return rows[interpolation]() if interpolation in rows else None

    def _unrolled(
        self, values: NDArray[Any], indices: Ints, rows: NDArray[Any] | None, what: str
    ) -> NDArray[Any] | None:
        """(M, 3, ...) values at each corner; None, with a reason, where they do not fit."""
        if len(values) == 1 and not len(indices):
            # One value alone is that of all, whatever its interpolation.
            rows = None if rows is None else np.zeros_like(rows)
        if rows is not None and len(indices) and rows.max() < len(indices):
            rows = indices[rows]
        elif len(indices):
            rows = None
        if rows is None or rows.min() < 0 or rows.max() >= len(values):
            self._lose(f"{what} do not fit the faces and are left out")
            return None
        unrolled: NDArray[Any] = values[rows]
        if what != "normals" and not np.isfinite(unrolled).all():
            self._lose(f"{what} hold NaN or infinity and are left out")
            return None
        return unrolled
