"""Masses and inertias of the bodies of a stage, by the rules of the standard.

A mass, a centre, a density or an inertia that is authored counts; what is missing follows from
the volume of the colliders and from the density of the body, of their materials, or of water. What
has no collider with a volume, such as the frame of a camera, gets the inertia of what is drawn.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdPhysics

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.hulls import convex_hull, volume
from openrooms_usd.physics.inertia import enclosed
from openrooms_usd.physics.mass import MassProperties, combined
from openrooms_usd.usd.rigid.shapes import Frames, ShapeReader

_REMEDY: Final = "give it a positive physics:mass, or colliders that enclose a volume"
# What USD takes where nothing says a density, kg/m3.
_WATER: Final = 1000.0
# Of what is not drawn either, such as a tool's frame: the radius of a ball, metres.
_BALL: Final = 0.05


def read_mass(
    reader: ShapeReader,
    path: Sdf.Path,
    solids: Mapping[Sdf.Path, Sequence[TriangleMesh]],
    drawn: Sequence[TriangleMesh],
) -> MassProperties:
    """Mass, centre and inertia of a body in its rigid frame, metres and kilograms.

    Args:
        reader: Of the stage; receives what is approximated.
        path: The body's prim.
        solids: The closed surfaces of each of its colliders in its rigid frame, metres.
        drawn: What is seen of it, in the same frame; it counts where no collider has a volume.

    Raises:
        InputError: It has a negative mass, or neither a mass nor anything with a volume.
    """
    frames = reader.frames
    prim = frames.stage.GetPrimAtPath(path)
    _check(prim)
    # Bodies with full mass properties need no shapes: rooms have thousands of them.
    known: dict[Sdf.Path, MassProperties | None] = {}
    if not _is_complete(prim):
        known = {where: _of_one(shapes) for where, shapes in solids.items()}
        if not any(known.values()):
            return _without_colliders(reader, prim, solids, drawn).checked(path)
    api = UsdPhysics.RigidBodyAPI(prim)
    mass, moments, centre, axes = api.ComputeMassProperties(
        lambda collider: _information(known.get(collider.GetPath()), frames.metres)
    )
    found = MassProperties(
        float(mass) * frames.kilograms,
        np.array(centre, dtype=np.float64) * frames.metres,
        _tensor(frames, *(_said_inertia(prim) or (moments, axes))),
    )
    return found.checked(path)


def _tensor(frames: Frames, moments: Gf.Vec3f, axes: Gf.Quatf) -> Array:
    R = np.array(Gf.Matrix3d(Gf.Quatd(axes).GetNormalized())).T
    tensor = R @ np.diag(np.array(moments, dtype=np.float64)) @ R.T
    return np.asarray(tensor * frames.kilograms * frames.metres**2)


def _without_colliders(
    reader: ShapeReader,
    prim: Usd.Prim,
    colliders: Iterable[Sdf.Path],
    drawn: Sequence[TriangleMesh],
) -> MassProperties:
    """By what is said, and for the rest by the hulls of what is drawn, or by a small ball."""
    frames, api = reader.frames, UsdPhysics.MassAPI(prim)
    shapes = (UsdPhysics.MassAPI(frames.stage.GetPrimAtPath(path)) for path in colliders)
    said = api.GetMassAttr().Get() or sum(one.GetMassAttr().Get() or 0.0 for one in shapes)
    hulls = [convex_hull(mesh.points[np.unique(mesh.triangles)]) for mesh in drawn]
    if not (hulls or said):
        raise InputError(
            "the mass of this body is unknown: it has no mass, no collider with a volume, and no "
            "visible geometry",
            place=prim.GetPath(),
            remedy=_REMEDY,
        )
    if hulls:
        found, like = combined(filter(None, map(_at_density_one, hulls))), "of what is drawn"
    else:
        found, like = _ball(), f"of a ball of {100.0 * _BALL:g} cm"
    stated = (api.GetDensityAttr().Get() or 0.0) * frames.kilograms / frames.metres**3
    mass = said * frames.kilograms or found.mass * (stated or _WATER)
    whose = "its inertia is that" if said else "its mass and inertia are those"
    reason = f"no collider of it has a volume: {whose} {like}"
    reader.lose(prim.GetPath(), "approximated", reason)
    found = found.weighing(mass)
    centre = api.GetCenterOfMassAttr().Get()
    if centre is not None and np.isfinite(centre).all():
        found = replace(found, centre=np.array(centre, dtype=np.float64) * frames.metres)
    inertia = _said_inertia(prim)
    return replace(found, inertia=_tensor(frames, *inertia)) if inertia else found


def _ball() -> MassProperties:
    return MassProperties(1.0, np.zeros(3), 0.4 * _BALL**2 * np.eye(3))


def _check(prim: Usd.Prim) -> None:
    """Refuse what the standard would read over."""
    api = UsdPhysics.MassAPI(prim)
    for attribute in (api.GetMassAttr(), api.GetDensityAttr()):
        value = attribute.Get() if attribute else None
        if value is not None and not 0.0 <= value < np.inf:
            raise InputError(
                f"{attribute.GetName()} is {value:g}", place=prim.GetPath(), remedy=_REMEDY
            )


def _is_complete(prim: Usd.Prim) -> bool:
    """Whether a body has its mass, inertia and centre authored."""
    api = UsdPhysics.MassAPI(prim)
    centre = api.GetCenterOfMassAttr()
    said = bool(centre and centre.HasAuthoredValue())
    return said and bool(api.GetMassAttr().Get()) and _said_inertia(prim) is not None


def _said_inertia(prim: Usd.Prim) -> tuple[Gf.Vec3f, Gf.Quatf] | None:
    """The authored moments and principal axes of a body.

    USD's own rules take tiny moments for none: those of a knob of 4 g, 6e-7 kg m2, become NaN.
    """
    api = UsdPhysics.MassAPI(prim)
    moments = api.GetDiagonalInertiaAttr().Get()
    if not moments or not all(value > 0.0 for value in moments):
        return None
    axes = api.GetPrincipalAxesAttr().Get()
    return moments, axes if axes and axes.GetLength() > 0.0 else Gf.Quatf(1.0)


def _of_one(shapes: Sequence[TriangleMesh]) -> MassProperties | None:
    """The shapes of one collider at a density of 1; None where they enclose nothing."""
    pieces = [piece for piece in map(_at_density_one, shapes) if piece is not None]
    return combined(pieces) if pieces else None


def _at_density_one(mesh: TriangleMesh) -> MassProperties | None:
    """About the middle of the points; None where they enclose nothing."""
    if volume(mesh) <= 0.0:
        return None
    middle = mesh.points.mean(axis=0)
    found = enclosed(mesh.points[mesh.triangles] - middle)
    return replace(found, centre=found.centre + middle)


def _information(
    solid: MassProperties | None, metres: float
) -> UsdPhysics.RigidBodyAPI.MassInformation:
    """What the standard's own rules ask of a collider, in units of the stage."""
    found = UsdPhysics.RigidBodyAPI.MassInformation()
    found.localRot = Gf.Quatf(1.0)
    found.localPos = Gf.Vec3f(0.0)
    if solid is not None:
        found.volume = solid.mass / metres**3
        found.inertia = Gf.Matrix3f(*(solid.inertia / metres**5).reshape(-1).tolist())
        found.centerOfMass = Gf.Vec3f(*(solid.centre / metres).tolist())
    return found
