"""What gets a place of its own in an atlas: meshes, and instances with all that is below them."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from pxr import Usd, UsdGeom, UsdShade

from openrooms_usd.arrays import Ints, Mask
from openrooms_usd.usd.light.lights import MeshLight, read_lights
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import bound_material, bound_subsets
from openrooms_usd.usd.shading.surfaces import PreviewSurface, Texture
from openrooms_usd.usd.shapes.meshes import LEFT_OUTSIDE, PlacedMesh, is_outside, read_meshes

_EMITS: Final = "it emits light"
_CLEAR: Final = "light passes straight through it"


@dataclass(frozen=True, eq=False)
class Member:
    """A mesh of a unit.

    Attributes:
        path: Relative to the unit's prim, without a slash before it; empty for the prim itself.
        mesh: Where it stands.
        lit: (M,) which of its triangles get texels.
    """

    path: str
    mesh: PlacedMesh
    lit: Mask


@dataclass(frozen=True, eq=False)
class Unit:
    """A prim whose surfaces share a rectangle of an atlas.

    Attributes:
        path: The prim: a mesh, or the outermost instance that meshes are in.
        prototype: What instances have in common that share their layout; of a mesh its own path.
        is_instance: Whether opinions on what is below must come in by a reference.
        nested: Instances inside this one, relative to it: they cease to be instances.
        members: Its meshes.
    """

    path: str
    prototype: str
    is_instance: bool
    nested: tuple[str, ...]
    members: tuple[Member, ...]


@dataclass(frozen=True, eq=False)
class Reading:
    """What of a stage gets a lightmap.

    Attributes:
        units: In the order of the stage.
        left_out: (prim path, reason) of surfaces that get none.
    """

    units: tuple[Unit, ...]
    left_out: tuple[tuple[str, str], ...]


def read_units(stage: Usd.Stage) -> Reading:
    """The units of a stage, and what gets no lightmap."""
    lamps = {light.path for light in read_lights(stage) if isinstance(light, MeshLight)}
    materials = _Materials()
    left_out: list[tuple[str, str]] = []
    gathered: dict[str, list[Member]] = {}
    for mesh in read_meshes(stage):
        path = str(mesh.prim.GetPath())
        dark = np.zeros(len(mesh.mesh.triangles), dtype=bool)
        reasons = [reason] if (reason := _unfit(mesh)) else []
        if is_outside(mesh.path):
            reasons.append(LEFT_OUTSIDE)
        if path in lamps:
            reasons.append(_EMITS)
        dark[:] = bool(reasons)
        for rows, reason in () if reasons else materials.dark(mesh):
            dark[rows] = True
            reasons.append(reason)
        left_out += [(mesh.path, reason) for reason in dict.fromkeys(reasons)]
        if not dark.all():
            root = _outermost(mesh.prim)
            member = Member(path[len(root) + 1 :], mesh, ~dark)
            gathered.setdefault(root, []).append(member)
    units = tuple(_unit(stage, path, members) for path, members in gathered.items())
    return Reading(units, tuple(left_out))


def _unit(stage: Usd.Stage, path: str, members: list[Member]) -> Unit:
    prim = stage.GetPrimAtPath(path)
    if not prim.IsInstance():
        return Unit(path, path, False, (), tuple(members))
    inner: dict[str, None] = {}
    for member in members:
        inner |= dict.fromkeys(_instances_above(member.mesh.prim))
    nested = tuple(one[len(path) + 1 :] for one in inner if one != path)
    return Unit(path, str(prim.GetPrototype().GetPath()), True, nested, tuple(members))


def _unfit(mesh: PlacedMesh) -> str | None:
    """Why no texture coordinates can be written for it, if so."""
    if mesh.path != str(mesh.prim.GetPath()):
        return "it is scattered by a point instancer"
    if not mesh.prim.IsA(UsdGeom.Mesh):
        return f"a {mesh.prim.GetTypeName()} has no texture coordinates"
    return None


def _instances_above(prim: Usd.Prim) -> Iterator[str]:
    """Paths of the instances that a prim is, or is in; the innermost first."""
    while prim and not prim.IsPseudoRoot():
        if prim.IsInstance():
            yield str(prim.GetPath())
        prim = prim.GetParent()


def _outermost(prim: Usd.Prim) -> str:
    return [str(prim.GetPath()), *_instances_above(prim)][-1]


class _Materials:
    """Which parts of meshes have materials that no lightmap is for."""

    def __init__(self) -> None:
        self._reasons: dict[str, str | None] = {}

    def dark(self, mesh: PlacedMesh) -> Iterator[tuple[Ints, str]]:
        """(rows of triangles, reason) of the parts that emit or are clear."""
        rest = np.ones(len(mesh.mesh.triangles), dtype=bool)
        for indices, material in bound_subsets(mesh.prim):
            rows = np.flatnonzero(rest & np.isin(mesh.mesh.faces, indices))
            rest[rows] = False
            if reason := self._reason(material):
                yield rows, reason
        material = bound_material(mesh.prim)
        if material is not None and (reason := self._reason(material)):
            yield np.flatnonzero(rest), reason

    def _reason(self, material: UsdShade.Material) -> str | None:
        key = str(material.GetPrim().GetPath())
        if key not in self._reasons:
            self._reasons[key] = _why_dark(read_preview_surface(material)[0])
        return self._reasons[key]


def _why_dark(surface: PreviewSurface) -> str | None:
    if isinstance(surface.emissive, Texture) or any(np.ravel(surface.emissive)):
        return _EMITS
    if not isinstance(surface.opacity, Texture) and surface.opacity < 1.0:
        return _CLEAR
    return None
