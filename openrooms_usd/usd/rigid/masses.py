"""Masses and inertias of the bodies of a stage, by the rules of the standard.

A mass, a centre, a density or an inertia that is authored counts; what is missing follows from the
volume of the colliders and from the density of the body, of their materials, or of water.
"""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdPhysics

from openrooms_usd.errors import InputError
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.mass import MassProperties, combined, from_moments
from openrooms_usd.usd.rigid.frames import Frames

_REMEDY: Final = "give it a positive physics:mass, or colliders that enclose a volume"


def read_mass(
    frames: Frames, path: Sdf.Path, solids: Mapping[Sdf.Path, Sequence[TriangleMesh]]
) -> MassProperties:
    """Mass, centre and inertia of a body in its rigid frame, metres and kilograms.

    Args:
        frames: Of the stage.
        path: The body's prim.
        solids: The closed surfaces of each of its colliders in its rigid frame, metres.

    Raises:
        InputError: It has a negative mass, or neither a mass nor a volume.
    """
    prim = frames.stage.GetPrimAtPath(path)
    _check(prim)
    # Bodies with full mass properties need no shapes: rooms have thousands of them.
    known: dict[Sdf.Path, MassProperties | None] = {}
    if not _is_complete(prim):
        known = {where: _of_one(shapes) for where, shapes in solids.items()}
        if not any(known.values()):
            raise InputError(
                "this body has no volume and no mass of its own", place=path, remedy=_REMEDY
            )
    api = UsdPhysics.RigidBodyAPI(prim)
    mass, moments, centre, axes = api.ComputeMassProperties(
        lambda collider: _information(known.get(collider.GetPath()), frames.metres)
    )
    moments, axes = _said_inertia(prim) or (moments, axes)
    R = np.array(Gf.Matrix3d(Gf.Quatd(axes).GetNormalized())).T
    tensor = R @ np.diag(np.array(moments, dtype=np.float64)) @ R.T
    found = MassProperties(
        float(mass) * frames.kilograms,
        np.array(centre, dtype=np.float64) * frames.metres,
        tensor * frames.kilograms * frames.metres**2,
    )
    return found.checked(path)


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
    """By the divergence theorem, about the middle of the points."""
    middle = mesh.points.mean(axis=0)
    a, b, c = np.moveaxis(mesh.points[mesh.triangles] - middle, 1, 0)
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    total = a + b + c
    volume = float(volumes.sum())
    if volume <= 0.0:
        return None
    second = sum(np.einsum("i,ij,ik->jk", volumes, p, p) for p in (a, b, c, total)) / 20.0
    first = np.einsum("i,ij->j", volumes, total) / 4.0
    found = from_moments(volume, first, np.asarray(second))
    return MassProperties(found.mass, found.centre + middle, found.inertia)


def _information(
    volume: MassProperties | None, metres: float
) -> UsdPhysics.RigidBodyAPI.MassInformation:
    """What the standard's own rules ask of a collider, in units of the stage."""
    found = UsdPhysics.RigidBodyAPI.MassInformation()
    found.localRot = Gf.Quatf(1.0)
    found.localPos = Gf.Vec3f(0.0)
    if volume is not None:
        found.volume = volume.mass / metres**3
        found.inertia = Gf.Matrix3f(*(volume.inertia / metres**5).reshape(-1).tolist())
        found.centerOfMass = Gf.Vec3f(*(volume.centre / metres).tolist())
    return found
