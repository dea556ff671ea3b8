"""Meshes as USD prims: authored by `define_mesh`, found again in any stage by `read_meshes`."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import isfinite
from typing import Final, Literal

import numpy as np
from pxr import Sdf, Usd, UsdGeom, Vt

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.triangulation import Ints, TriangleMesh
from openrooms_usd.usd.places.frames import world_from_stage
from openrooms_usd.usd.shapes.traversal import Tints, Walk

__all__ = [
    "FARTHEST_M",
    "MeshReading",
    "PlacedMesh",
    "TriangleMesh",
    "define_mesh",
    "is_outside",
    "read_meshes",
    "world_triangles",
]


def define_mesh(
    stage: Usd.Stage, path: str | Sdf.Path, mesh: Mesh, *, double_sided: bool = False
) -> UsdGeom.Mesh:
    """Define a mesh prim: polygons, never subdivided, right-handed.

    Args:
        stage: Where to define it; the edit target receives everything.
        path: The prim's path.
        mesh: Polygons in the prim's local frame, stage units. Normals and texture coordinates are
            authored face-varying, where it has them.
        double_sided: Whether both sides are seen; author it for open sheets only.
    """
    points = mesh.points.astype(np.float32)
    prim = UsdGeom.Mesh.Define(stage, path)
    prim.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
    prim.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(mesh.counts.astype(np.int32)))
    prim.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(mesh.indices.astype(np.int32)))
    # From the rounded points, so that it bounds what is stored.
    extent = np.stack([points.min(axis=0), points.max(axis=0)])
    prim.CreateExtentAttr(Vt.Vec3fArray.FromNumpy(extent))
    prim.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    prim.CreateOrientationAttr(UsdGeom.Tokens.rightHanded)
    if double_sided:
        prim.CreateDoubleSidedAttr(True)
    if mesh.normals is not None:
        prim.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(mesh.normals.astype(np.float32)))
        prim.SetNormalsInterpolation(UsdGeom.Tokens.faceVarying)
    if mesh.st is not None:
        primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(
            names.ST, Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.faceVarying
        )
        primvar.Set(Vt.Vec2fArray.FromNumpy(mesh.st.astype(np.float32)))
    return prim


@dataclass(frozen=True, eq=False)
class PlacedMesh:
    """Triangles where they stand in the world.

    Attributes:
        path: Where it stands: the prim's path, through instances; a point instancer adds the
            number of the instance in brackets.
        prim: The mesh or intrinsic shape; an instance proxy inside instances.
        mesh: Its triangles in its local frame; instances of one prototype share this object.
        world_from_local: (4, 4) for column vectors, to the world: Z up, metres.
        double_sided: Whether its back is seen too.
        mirrored: Whether ``world_from_local`` turns the winding round.
        tints: What point instancers say of it, by primvar (`traversal.TINTS`).
    """

    path: str
    prim: Usd.Prim
    mesh: TriangleMesh
    world_from_local: Array
    double_sided: bool = False
    mirrored: bool = False
    tints: Tints = ()

    def world_points(self) -> Array:
        """(N, 3) its points in the world, metres."""
        return self.mesh.points @ self.world_from_local[:3, :3].T + self.world_from_local[:3, 3]


@dataclass(frozen=True, eq=False)
class MeshReading:
    """Everything of a stage that can be drawn, and what became of the rest.

    Attributes:
        meshes: In the order of the stage.
        losses: (prim path, ``approximated`` or ``skipped``, reason).
    """

    meshes: list[PlacedMesh]
    losses: list[tuple[str, Literal["approximated", "skipped"], str]]

    def __iter__(self) -> Iterator[PlacedMesh]:
        return iter(self.meshes)

    def __len__(self) -> int:
        return len(self.meshes)


def read_meshes(
    stage: Usd.Stage,
    *,
    purposes: Sequence[str] = ("default", "render"),
    outside: bool = True,
    bare: bool = False,
) -> MeshReading:
    """Every visible surface of a stage, instances and point instancers expanded.

    Any stage will do, also one that is Y up or in centimetres. A prototype is read once, however
    often it is used. Prims that are invisible or have another purpose are left out in silence;
    what cannot be drawn is left out with a reason.

    Args:
        stage: The composed stage.
        purposes: Which ``purpose`` is drawn.
        outside: Whether to read what stands outside before the windows, too; else that is named
            among what is left out.
        bare: Whether only shapes are read, without normals and texture coordinates. What stands
            outside is then not named either where it is left out.
    """
    without = names.OUTSIDE if bare and not outside else None
    parts = Walk(purposes, bare=bare, without=without).stage(stage)
    losses: dict[tuple[int, str], tuple[str, Literal["approximated", "skipped"], str]] = {}
    if not outside:
        left = [part.path for part in parts if is_outside(part.path)]
        losses |= {(0, path): (path, "skipped", LEFT_OUTSIDE) for path in left}
        parts = [part for part in parts if not is_outside(part.path)]
    meshes: list[PlacedMesh] = []
    matrices = np.array([part.matrix for part in parts]).reshape(-1, 4, 4)
    matrices = world_from_stage(stage) @ matrices
    with np.errstate(all="ignore"):
        volumes = np.linalg.det(matrices[:, :3, :3])
    sizes = np.abs(matrices[:, :3]).sum(axis=(1, 2)).tolist()
    reaches: dict[int, float] = {}
    for part, matrix, volume, size in zip(parts, matrices, volumes.tolist(), sizes, strict=True):
        path, surface = part.path, part.surface
        for outcome, reason in surface.losses:
            losses.setdefault((id(surface), reason), (path, outcome, reason))
        if surface.mesh is None:
            continue
        if not isfinite(volume) or volume == 0.0:
            losses[0, path] = (path, "skipped", "its transform is singular")
            continue
        if id(surface) not in reaches:
            reaches[id(surface)] = max(1.0, float(np.abs(surface.mesh.points).max()))
        if not reaches[id(surface)] * size < FARTHEST_M:
            losses[0, path] = (path, "skipped", "its coordinates exceed the range of renderers")
            continue
        prim = stage.GetPrimAtPath(part.prim)
        meshes.append(
            PlacedMesh(
                path, prim, surface.mesh, matrix, surface.double_sided, volume < 0.0, part.tints
            )
        )
    return MeshReading(meshes, list(losses.values()))


FARTHEST_M: Final = 1e15
"""How far a scene may reach, metres: what renderers square must fit single precision."""

LEFT_OUTSIDE: Final = "it stands outside, and is not part of the room"
"""Why what hands on the room alone leaves something out."""


def is_outside(path: str) -> bool:
    """Whether a prim stands outside the windows: it is visible, but not part of the room."""
    return path.startswith(f"{names.OUTSIDE}/")


def world_triangles(meshes: Iterable[PlacedMesh]) -> tuple[Array, Ints, Ints]:
    """All triangles in one soup, for ray casting.

    Returns:
        (N, 3) points in the world, metres; (M, 3) rows of them; (M,) the number of the mesh.
    """
    placed = list(meshes)
    if not placed:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32), np.zeros(0, dtype=np.int32)
    sizes = [len(item.mesh.points) for item in placed]
    offsets = np.cumsum([0, *sizes[:-1]]).astype(np.int32)
    rows = [item.mesh.triangles + at for item, at in zip(placed, offsets, strict=True)]
    lengths = [len(item.mesh.triangles) for item in placed]
    owners = np.repeat(np.arange(len(placed), dtype=np.int32), lengths)
    return np.concatenate([item.world_points() for item in placed]), np.concatenate(rows), owners
