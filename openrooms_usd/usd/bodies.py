"""Authoring UsdPhysics: bodies, masses, collision shapes and joints.

Conventions of the standard that matter where prims are scaled. The frame of a body is the rotation
and the position of its prim; its scale is that of `Gf.Transform`, negative where it mirrors. The
centre of mass and a joint's anchors are in the prim's own frame, before its scale. The principal
moments are not scaled: they are true kg m2 along the body's own axes.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade, Vt

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import face_vectors
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.geometry.vectors import UP, unit
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.usd.shapes.meshes import define_mesh

PURPOSE: Final = "physics"
# Normals of shapes: what is finer is noise, and makes equal arrays differ.
_DIGITS: Final = 6
# Beyond this angle from its zero PhysX stops a hinge that holds on to the world.
_HALF_TURN_DEG: Final = 180.0
_AXES: Final = (UsdPhysics.Tokens.x, UsdPhysics.Tokens.y, UsdPhysics.Tokens.z)


def frame_and_scale(matrix: Gf.Matrix4d) -> tuple[Array, Array]:
    """The rigid frame of a body at a prim, and the scale that comes before it.

    Args:
        matrix: From the prim's frame to the stage's.

    Returns:
        (4, 4) stage from body, for column vectors, and (3,) the scale. A mirror negates all three,
        as physics engines that read USD have it. What is sheared is in neither.
    """
    transform = Gf.Transform(matrix)
    frame = np.eye(4)
    frame[:3, :3] = np.array(Gf.Matrix3d(transform.GetRotation())).T
    frame[:3, 3] = transform.GetTranslation()
    return frame, np.array(transform.GetScale())


def define_scene(stage: Usd.Stage, path: str | Sdf.Path, gravity: float) -> None:
    """Define the PhysicsScene: gravity in m/s2 along -Z."""
    scene = UsdPhysics.Scene.Define(stage, path)
    scene.CreateGravityDirectionAttr(Gf.Vec3f(0.0, 0.0, -1.0))
    scene.CreateGravityMagnitudeAttr(gravity)


def author_body(prim: Usd.Prim) -> None:
    """Make a prim, with all that collides below it, a body that moves."""
    UsdPhysics.RigidBodyAPI.Apply(prim)
    UsdPhysics.MassAPI.Apply(prim)


def author_articulation(prim: Usd.Prim) -> None:
    """Make a body that moves the root of what hangs on it by joints.

    The standard wants a floating articulation's root on its root body. What is joined to something
    that never moves has none: it holds on to the world, and a static root is an error.
    """
    UsdPhysics.ArticulationRootAPI.Apply(prim)


def author_mass(spec: Sdf.PrimSpec, mass: MassProperties, scale: ArrayLike) -> None:
    """Say what a body weighs.

    Args:
        spec: The body, perhaps inside a variant; `author_body` applies the schema.
        mass: In its rigid frame, metres and kilograms.
        scale: The scale of the prim, as `frame_and_scale` gives it.
    """
    moments, turn = mass.principal()
    centre = mass.centre / np.asarray(scale, dtype=np.float64)
    tokens, types = UsdPhysics.Tokens, Sdf.ValueTypeNames
    for name, kind, value in (
        (tokens.physicsMass, types.Float, float(mass.mass)),
        (tokens.physicsCenterOfMass, types.Point3f, _vector(centre)),
        (tokens.physicsDiagonalInertia, types.Float3, _vector(moments)),
        (tokens.physicsPrincipalAxes, types.Quatf, _quaternion(turn)),
    ):
        Sdf.AttributeSpec(spec, name, kind, declaresCustom=False).default = value


def define_collider(stage: Usd.Stage, path: Sdf.Path, mesh: TriangleMesh) -> Usd.Prim:
    """Define a convex shape that collides; its purpose is that of the scope that it is in.

    Args:
        stage: Where; its edit target receives everything.
        path: The shape's path.
        mesh: A closed, convex surface in the frame of its parent.
    """
    counts = np.full(len(mesh.triangles), 3, dtype=np.int32)
    faces = Mesh(mesh.points, counts, mesh.triangles.reshape(-1))
    shape = define_mesh(stage, path, faces)
    # Who looks at shapes sees their faces; one a face is a third of one a corner.
    normals = np.round(unit(face_vectors(faces), UP), _DIGITS) + 0.0
    shape.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(normals.astype(np.float32)))
    shape.SetNormalsInterpolation(UsdGeom.Tokens.uniform)
    prim = shape.GetPrim()
    UsdPhysics.CollisionAPI.Apply(prim)
    convex = UsdPhysics.Tokens.convexHull
    UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(convex)
    UsdShade.MaterialBindingAPI.Apply(prim)
    return prim


def define_guides(stage: Usd.Stage, path: Sdf.Path) -> Sdf.Path:
    """Define a scope for shapes that are never drawn."""
    scope = UsdGeom.Scope.Define(stage, path)
    scope.CreatePurposeAttr(UsdGeom.Tokens.guide)
    return scope.GetPath()


def bind_physics(spec: Sdf.PrimSpec, material: Sdf.Path) -> None:
    """Bind a material to a collider, perhaps inside a variant, for contacts alone."""
    name = f"{UsdShade.Tokens.materialBinding}:{PURPOSE}"
    binding = Sdf.RelationshipSpec(spec, name, custom=False)
    binding.targetPathList.explicitItems = [material]


@dataclass(frozen=True, eq=False)
class Motion:
    """How one body moves against another.

    Attributes:
        kind: A ``hinge`` turns counter-clockwise about the axis, a ``rail`` slides along it.
        axis: (3,) unit vector in the frame of the body that moves.
        limits: From how it is built: degrees or metres.
        parent_from_child: (4, 4) how it is built, in the other body's own frame.
        damping: N m s/rad or N s/m.
        friction: N m or N that it takes to move it at all.
    """

    kind: Literal["hinge", "rail"]
    axis: Array
    limits: tuple[float, float]
    parent_from_child: Array
    damping: float = 0.0
    friction: float = 0.0


def keep_apart(prim: Usd.Prim, others: Iterable[Sdf.Path]) -> None:
    """Let a body pass through other bodies or colliders."""
    relation = UsdPhysics.FilteredPairsAPI.Apply(prim).CreateFilteredPairsRel()
    for other in others:
        relation.AddTarget(other)


def define_joint(
    stage: Usd.Stage, path: Sdf.Path, motion: Motion, bodies: Sequence[Sdf.Path], scale: ArrayLike
) -> Usd.Prim:
    """Define a RevoluteJoint or a PrismaticJoint; the two bodies do not collide.

    Its zero is how it is built; in the middle of its way where a knob turns farther than PhysX
    would let it.

    Args:
        stage: Where; its edit target receives everything.
        path: The joint's path.
        motion: How it moves.
        bodies: What holds, and what moves.
        scale: The scale of both, as `frame_and_scale` gives it.
    """
    hinge = motion.kind == "hinge"
    schema = UsdPhysics.RevoluteJoint if hinge else UsdPhysics.PrismaticJoint
    joint = schema.Define(stage, path)
    axis, stretch = _in_body(motion, np.asarray(scale, dtype=np.float64))
    number = int(np.abs(axis).argmax())
    align = Gf.Quatf(Gf.Rotation(Gf.Vec3d(*np.eye(3)[number]), Gf.Vec3d(*axis)).GetQuat())
    built, limits = motion.parent_from_child, motion.limits
    middle = sum(limits) / 2.0 if hinge and max(map(abs, limits)) > _HALF_TURN_DEG else 0.0
    turned = Gf.Quatf(Gf.Rotation(Gf.Vec3d(*axis), middle).GetQuat())
    joint.CreateBody0Rel().SetTargets([bodies[0]])
    joint.CreateBody1Rel().SetTargets([bodies[1]])
    joint.CreateAxisAttr(_AXES[number])
    joint.CreateLocalPos0Attr(_vector(built[:3, 3]))
    joint.CreateLocalRot0Attr(_quaternion(built[:3, :3]) * turned * align)
    joint.CreateLocalPos1Attr(Gf.Vec3f(0.0))
    joint.CreateLocalRot1Attr(align)
    joint.CreateLowerLimitAttr(limits[0] * stretch - middle)
    joint.CreateUpperLimitAttr(limits[1] * stretch - middle)
    joint.CreateCollisionEnabledAttr(False)
    drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular" if hinge else "linear")
    drive.CreateTypeAttr(UsdPhysics.Tokens.force)
    drive.CreateStiffnessAttr(0.0)
    # The standard counts angles in degrees.
    drive.CreateDampingAttr(motion.damping * (np.pi / 180.0 if hinge else 1.0))
    # The standard has no word for it.
    friction = Sdf.ValueTypeNames.Float
    joint.GetPrim().CreateAttribute(names.JOINT_FRICTION, friction).Set(motion.friction)
    return joint.GetPrim()


def _in_body(motion: Motion, scale: Array) -> tuple[Array, float]:
    """The axis after the scale, and by how much distances along it grow."""
    if motion.kind == "rail":
        along = scale * motion.axis
        length = float(np.linalg.norm(along))
        return along / length, length
    # An axis of rotation is a normal of its plane, and its sense turns round in a mirror.
    about = np.prod(scale) / scale * motion.axis
    return about / np.linalg.norm(about), 1.0


def _vector(values: ArrayLike) -> Gf.Vec3f:
    return Gf.Vec3f(*(float(v) + 0.0 for v in np.asarray(values)))


def _quaternion(rotation: Array) -> Gf.Quatf:
    """A (3, 3) rotation for column vectors as a quaternion."""
    matrix = Gf.Matrix4d(1.0)
    matrix.SetRotateOnly(Gf.Matrix3d(*rotation.T.reshape(-1).tolist()))
    return Gf.Quatf(matrix.ExtractRotationQuat())
