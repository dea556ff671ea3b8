"""The rigid links of an object, and the parts of each."""

import hashlib
import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.description.physics import Shapes
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.steps.materials.looks import VARIANT_SET
from openrooms_usd.usd.places.frames import TIME, matrix
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading import physics
from openrooms_usd.usd.shading.materials import bound_material
from openrooms_usd.usd.shading.physics import MaterialPhysics
from openrooms_usd.usd.shapes.gprims import read_surface

_DRAWN = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)
# The fixed parts of an object whose other parts move; in our own assets they have an Xform.
BODY = "Geometry/Body"


@dataclass(frozen=True)
class Substance:
    """The material of a part in one look.

    Attributes:
        material: The path of its Material, relative where it is below the object's root; None
            where nothing is bound.
        category: The substance, as the Material says it; None where nothing does.
        physics: Its numbers; None where it has none.
    """

    material: str | None = None
    category: str | None = None
    physics: MaterialPhysics | None = None


@dataclass(frozen=True, eq=False)
class Solid:
    """A part: a surface, and its material in each look.

    Attributes:
        path: Its prim, relative to the object's root.
        name: Its semantic part, or its prim's name.
        mesh: Its triangles in the frame of its link's prim, before any scale.
        substances: By look.
    """

    path: str
    name: str
    mesh: TriangleMesh
    substances: tuple[Substance, ...]


@dataclass(frozen=True)
class JointDescription:
    """The joint attributes of a moving part (`usd.joints`).

    Attributes:
        kind: ``hinge`` or ``rail``.
        axis: Unit vector in its own frame.
        limits: From how it is built: degrees or metres.
    """

    kind: Literal["hinge", "rail"]
    axis: tuple[float, float, float]
    limits: tuple[float, float]


@dataclass(frozen=True, eq=False)
class RigidLink:
    """Parts that move as one.

    Attributes:
        path: Their prim, relative to the object's root; ``.`` for the root itself.
        solids: The parts.
        joint: How it moves; None for what carries the others.
        built: (4, 4) from its frame to the object's, as it was built: nothing opened.
    """

    path: str
    solids: tuple[Solid, ...]
    joint: JointDescription | None = None
    built: Array = field(default_factory=lambda: np.eye(4))


def looks_of(root: Usd.Prim) -> tuple[str, ...]:
    """The looks of an object; one without a name where it has no choice."""
    variants = root.GetVariantSets()
    found = variants.GetVariantSet(VARIANT_SET).GetVariantNames()
    return tuple(found) if len(found) > 1 else ("",)


def read_links(stage: Usd.Stage, path: Sdf.Path, owner: Sdf.Path) -> list[RigidLink]:
    """The links of an object: the fixed one, then the moving ones, in the order of the stage.

    Args:
        stage: The composed stage.
        path: The object's root; it may be an instance.
        owner: Where its looks are chosen: the root itself, or a prim above it.
    """
    substances = _substances(stage, path, owner)
    root, cache = stage.GetPrimAtPath(path), UsdGeom.XformCache(TIME)
    movers = [prim for prim in _prims(root) if prim.GetAttribute(names.JOINT_TYPE)]
    base = root.GetPrimAtPath(BODY) if movers else root
    holders = {prim.GetPath(): prim for prim in movers}
    found: dict[Sdf.Path, list[Solid]] = {prim.GetPath(): [] for prim in (base or root, *movers)}
    for prim in _prims(root):
        if not _is_drawn(prim):
            continue
        mesh = read_surface(prim).mesh
        above = [path for path in prim.GetPath().GetPrefixes() if path in holders]
        holder = holders[above[-1]] if above else (base or root)
        if mesh is not None:
            solid = _solid(root, holder, prim, mesh, substances[prim.GetPath()], cache)
            found[holder.GetPath()].append(solid)
    return [_link(root, path, solids, holders.get(path), cache) for path, solids in found.items()]


def _prims(root: Usd.Prim) -> Iterator[Usd.Prim]:
    yield from Usd.PrimRange(root, Usd.TraverseInstanceProxies())


def _is_drawn(prim: Usd.Prim) -> bool:
    if not prim.IsA(UsdGeom.Gprim):
        return False
    shown = UsdGeom.Imageable(prim)
    hidden = shown.ComputeVisibility(TIME) == UsdGeom.Tokens.invisible
    return not hidden and shown.ComputePurpose() in _DRAWN


def _substances(
    stage: Usd.Stage, path: Sdf.Path, owner: Sdf.Path
) -> dict[Sdf.Path, tuple[Substance, ...]]:
    """What each surface is made of, look by look; the stage is as before afterwards."""
    found: dict[Sdf.Path, list[Substance]] = {}
    session = stage.GetSessionLayer()
    for look in looks_of(stage.GetPrimAtPath(owner)):
        if look:
            # Whatever prims Python holds may be made anew by this.
            spec = Sdf.CreatePrimInLayer(session, owner)
            spec.variantSelections[VARIANT_SET] = look
        for prim in _prims(stage.GetPrimAtPath(path)):
            if prim.IsA(UsdGeom.Gprim):
                found.setdefault(prim.GetPath(), []).append(_substance(path, prim))
    session.Clear()
    return {where: tuple(made) for where, made in found.items()}


def _substance(root: Sdf.Path, prim: Usd.Prim) -> Substance:
    material = bound_material(prim)
    if material is None:
        return Substance()
    made, path = material.GetPrim(), material.GetPath()
    where = str(path.MakeRelativePath(root) if path.HasPrefix(root) else path)
    return Substance(where, physics.read_category(made), physics.read(made))


def _solid(
    root: Usd.Prim,
    holder: Usd.Prim,
    prim: Usd.Prim,
    mesh: TriangleMesh,
    made: tuple[Substance, ...],
    cache: UsdGeom.XformCache,
) -> Solid:
    to_world = cache.GetLocalToWorldTransform(prim)
    M = matrix(to_world * cache.GetLocalToWorldTransform(holder).GetInverse())
    triangles = mesh.triangles[:, ::-1] if np.linalg.det(M[:3, :3]) < 0.0 else mesh.triangles
    moved = TriangleMesh(mesh.points @ M[:3, :3].T + M[:3, 3], triangles, mesh.faces)
    path = str(prim.GetPath().MakeRelativePath(root.GetPath()))
    return Solid(path, read_label(prim, names.PART) or prim.GetName(), moved, made)


def _link(
    root: Usd.Prim,
    path: Sdf.Path,
    solids: list[Solid],
    joint: Usd.Prim | None,
    cache: UsdGeom.XformCache,
) -> RigidLink:
    relative = str(path.MakeRelativePath(root.GetPath()))
    if joint is None:
        return RigidLink(relative, tuple(solids))
    built = np.eye(4)
    built[:3, 3] = _pivot(joint)
    above = cache.GetLocalToWorldTransform(joint.GetParent())
    outer = matrix(above * cache.GetLocalToWorldTransform(root).GetInverse())
    return RigidLink(relative, tuple(solids), _says(joint), outer @ built)


def _says(prim: Usd.Prim) -> JointDescription:
    kind, axis, lower, upper = (
        prim.GetAttribute(key).Get(TIME)
        for key in (names.JOINT_TYPE, names.JOINT_AXIS, names.JOINT_LOWER, names.JOINT_UPPER)
    )
    x, y, z = (float(value) for value in axis)
    return JointDescription(
        "rail" if kind == "rail" else "hinge", (x, y, z), (float(lower), float(upper))
    )


def _pivot(joint: Usd.Prim) -> Array:
    """(3,) the closed position of a moving part: its asset's, whatever an edit has opened."""
    attribute = joint.GetAttribute("xformOp:translate")
    values = [spec.default for spec in attribute.GetPropertyStack(TIME)] if attribute else []
    return np.array(values[-1] if values else (0.0, 0.0, 0.0), dtype=np.float64)


# What an object is for physics before anything is computed; equal objects share one.


@dataclass(frozen=True)
class ColliderSettings:
    """How collision shapes are made.

    Attributes:
        shapes: By which method.
        tolerance: How far they may lie from what is seen, metres.
    """

    shapes: Shapes
    tolerance: float


@dataclass(frozen=True, eq=False)
class RigidAsset:
    """An object as physics has it; equal ones share all of it.

    Attributes:
        root: The root of one of those that are alike.
        title: What its layer is called after.
        category: What it is.
        fixed: Whether it never moves.
        mass: Its mass if it is given, kilograms.
        friction: Likewise the static coefficient of all of it.
        scale: (3,) of its root, as `usd.bodies.frame_and_scale` gives it.
        looks: The names of its looks; one without a name where it has no choice.
        links: What it consists of.
        settings: How its collision shapes are made.
    """

    root: Sdf.Path
    title: str
    category: str
    fixed: bool
    mass: float | None
    friction: float | None
    scale: Array
    looks: tuple[str, ...]
    links: tuple[RigidLink, ...]
    settings: ColliderSettings

    def digest(self, code: str) -> str:
        """8 hexadecimal digits of all that its layer depends on.

        Args:
            code: The digest of the code that writes the layer.
        """
        parts: list[Any] = [
            code,
            self.category,
            self.fixed,
            self.mass,
            self.friction,
            self.scale.tolist(),
            self.looks,
            vars(self.settings),
        ]
        content = hashlib.sha256()
        for link in self.links:
            parts.append([link.path, link.built.tolist(), repr(link.joint)])
            for solid in link.solids:
                parts.append([solid.path, solid.name, [repr(s) for s in solid.substances]])
                content.update(np.ascontiguousarray(solid.mesh.points).tobytes())
                content.update(np.ascontiguousarray(solid.mesh.triangles).tobytes())
        content.update(json.dumps(parts, sort_keys=True).encode())
        return content.hexdigest()[:8]
