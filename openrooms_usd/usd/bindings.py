"""Which material a prim shows."""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom, UsdShade

from openrooms_usd.usd.arrays import array_of
from openrooms_usd.usd.frames import TIME

# Rows of triangles, and the material that they show.
Part = tuple[NDArray[np.int32], UsdShade.Material | None]


def bound_material(prim: Usd.Prim) -> UsdShade.Material | None:
    """The material that a prim shows: the binding for ``full``, for all purposes, or a preview."""
    api = UsdShade.MaterialBindingAPI(prim)
    for purpose in (UsdShade.Tokens.full, UsdShade.Tokens.preview):
        material, _ = api.ComputeBoundMaterial(purpose)
        if material:
            return material
    return None


def bound_materials(prims: Sequence[Usd.Prim]) -> list[UsdShade.Material | None]:
    """`bound_material` of many prims at once, on all cores."""
    api = UsdShade.MaterialBindingAPI
    found: list[UsdShade.Material | None] = [None] * len(prims)
    left = list(range(len(prims)))
    for purpose in (UsdShade.Tokens.full, UsdShade.Tokens.preview):
        materials, _ = api.ComputeBoundMaterials([prims[row] for row in left], purpose)
        for row, material in zip(left, materials, strict=True):
            found[row] = material or None
        left = [row for row in left if found[row] is None]
    return found


def bound_subsets(prim: Usd.Prim) -> list[tuple[NDArray[np.int32], UsdShade.Material]]:
    """The faces of a mesh that show another material than the mesh itself.

    Args:
        prim: A mesh.

    Returns:
        For each material subset (its face indices, its material); faces in none of them show
        `bound_material` of the mesh.
    """
    api = UsdShade.MaterialBindingAPI(prim)
    subsets = api.GetMaterialBindSubsets() if prim.IsA(UsdGeom.Mesh) else []
    found = [(subset, bound_material(subset.GetPrim())) for subset in subsets]
    return [
        (array_of(subset.GetIndicesAttr().Get(TIME), np.int32), material)
        for subset, material in found
        if material is not None and subset.GetElementTypeAttr().Get() == UsdGeom.Tokens.face
    ]


def parts_by_material(
    prim: Usd.Prim, faces: NDArray[np.int32], own: UsdShade.Material | None
) -> Iterator[Part]:
    """Each part of a mesh with a material of its own.

    Args:
        prim: The mesh.
        faces: (M,) the face of each of its triangles.
        own: The material of what is in no such part: `bound_material` of the mesh.
    """
    rest = np.ones(len(faces), dtype=bool)
    for indices, material in bound_subsets(prim):
        rows = np.flatnonzero(rest & np.isin(faces, indices))
        if len(rows):
            rest[rows] = False
            yield rows.astype(np.int32), material
    if rest.any():
        yield np.flatnonzero(rest).astype(np.int32), own


def material_key(material: UsdShade.Material) -> str:
    """The same for all instances of one prototype, which show it under many paths."""
    prim = material.GetPrim()
    source = prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim
    return str(source.GetPath())
