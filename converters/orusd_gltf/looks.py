"""What the parts of meshes are made of, each material read once."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom, UsdShade

from openrooms_usd.usd.arrays import array_of, flattened
from openrooms_usd.usd.bindings import bound_material, material_key, parts_by_material
from openrooms_usd.usd.materialreader import read_preview_surface
from openrooms_usd.usd.meshes import PlacedMesh
from openrooms_usd.usd.surfaces import PreviewSurface

Rows = NDArray[np.int32]


@dataclass(frozen=True)
class Look:
    """A material as it is read.

    Attributes:
        key: The same for all instances of one prototype, which show it under many paths.
        name: The prim's name.
        path: The prim that showed it first; empty where there is no material.
        preview: What it says.
        losses: What could not be read, in words.
    """

    key: str
    name: str
    path: str
    preview: PreviewSurface
    losses: tuple[str, ...]


@dataclass
class Looks:
    """Reads the materials of meshes."""

    _known: dict[str, Look] = field(default_factory=dict)

    def parts(self, mesh: PlacedMesh) -> list[tuple[Rows, Look]]:
        """(rows of triangles, their look) for each part of a mesh with a look of its own."""
        prim = mesh.prim
        found = parts_by_material(prim, mesh.mesh.faces, bound_material(prim))
        return [(rows, self._look(prim, material)) for rows, material in found]

    def _look(self, prim: Usd.Prim, material: UsdShade.Material | None) -> Look:
        if material is None:
            color, reason = _display_color(prim)
            preview = PreviewSurface(base_color=color)
            return Look(f"{color}", "no_material", "", preview, (reason,))
        own, key = material.GetPrim(), material_key(material)
        if key not in self._known:
            preview, losses = read_preview_surface(material)
            self._known[key] = Look(key, own.GetName(), str(own.GetPath()), preview, losses)
        return self._known[key]


def _display_color(prim: Usd.Prim) -> tuple[tuple[float, float, float], str]:
    primvar = UsdGeom.Gprim(prim).GetDisplayColorPrimvar()
    values = array_of(flattened(primvar), np.float64, 3)
    if not len(values) or not np.isfinite(values).all():
        return (0.18, 0.18, 0.18), "it has no material: taken as grey"
    red, green, blue = np.clip(values.mean(axis=0), 0.0, 1.0).tolist()
    return (red, green, blue), "it has no material: taken as its displayColor"
