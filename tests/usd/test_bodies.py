"""What is authored about bodies, as USD's own parser and its own rules read it."""

import math
from collections.abc import Iterator

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from openrooms_usd import names
from openrooms_usd.geometry.solids import box
from openrooms_usd.geometry.triangulation import TriangleMesh, triangulate
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.usd.bodies import (
    Motion,
    author_body,
    author_mass,
    define_collider,
    define_guides,
    define_joint,
    frame_and_scale,
)
from openrooms_usd.usd.rigid.reading import read_world
from openrooms_usd.usd.shading import physics
from openrooms_usd.usd.shading.physics import MaterialPhysics
from openrooms_usd.validation.model import Subject
from openrooms_usd.validation.physx_rules import joint_frames

Kind = UsdPhysics.ObjectType
SCALES = [(1.0, 1.0, 1.0), (2.0, 0.5, 3.0), (-1.0, 1.0, 1.0), (-2.0, 3.0, -1.5)]


def placed(scale: tuple[float, float, float]) -> tuple[Usd.Stage, UsdGeom.Xform]:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    root = UsdGeom.Xform.Define(stage, "/Thing")
    root.AddTranslateOp().Set(Gf.Vec3d(1, 2, 3))
    root.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, 30))
    root.AddScaleOp().Set(Gf.Vec3f(*scale))
    return stage, root


def shape(size: tuple[float, float, float]) -> TriangleMesh:
    mesh = box(size)
    corners, faces = triangulate(mesh.points, mesh.counts, mesh.indices)
    return TriangleMesh(mesh.points, mesh.indices[corners], faces)


@pytest.mark.parametrize("scale", SCALES)
def test_frames_are_those_of_the_parser(scale: tuple[float, float, float]) -> None:
    stage, root = placed(scale)
    author_body(root.GetPrim())
    define_collider(stage, Sdf.Path("/Thing/shape"), shape((1, 1, 1)))
    found = UsdPhysics.UsdPhysicsLoadStageFromPrimRange(stage, ["/"])
    ((_, *_), (desc, *_)) = found[Kind.RigidBody]
    frame, size = frame_and_scale(root.ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
    np.testing.assert_allclose(frame[:3, 3], np.array(desc.position), atol=1e-6)
    R = np.array(Gf.Matrix3d(Gf.Quatd(desc.rotation))).T
    np.testing.assert_allclose(frame[:3, :3], R, atol=1e-6)
    np.testing.assert_allclose(size, np.array(desc.scale), atol=1e-6)


@pytest.mark.parametrize("scale", SCALES)
def test_a_mass_is_read_as_it_was_written(scale: tuple[float, float, float]) -> None:
    stage, root = placed(scale)
    author_body(root.GetPrim())
    axes = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    inertia = axes @ np.diag([1.0, 2.0, 2.5]) @ axes.T
    mass = MassProperties(7.0, np.array([0.1, -0.2, 0.3]), inertia)
    _, size = frame_and_scale(root.ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
    author_mass(stage.GetRootLayer().GetPrimAtPath("/Thing"), mass, size)
    weight, moments, centre, turn = UsdPhysics.RigidBodyAPI(root.GetPrim()).ComputeMassProperties(
        lambda prim: UsdPhysics.RigidBodyAPI.MassInformation()
    )
    R = np.array(Gf.Matrix3d(Gf.Quatd(turn).GetNormalized())).T
    assert weight == pytest.approx(7.0)
    np.testing.assert_allclose(np.array(centre), mass.centre, atol=1e-6)
    np.testing.assert_allclose(R @ np.diag(np.array(moments)) @ R.T, inertia, atol=1e-5)


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0)])
def test_joints_move_scaled_and_mirrored_parts_as_a_turned_prim_would(
    scale: tuple[float, float, float], axis: tuple[float, float, float]
) -> None:
    stage, root = placed(scale)
    parts = {}
    for name, at in (("body", (0, 0, 0)), ("part", (0.3, 0.4, 0.5))):
        part = UsdGeom.Xform.Define(stage, f"/Thing/{name}")
        parts[name] = part.AddTranslateOp()
        parts[name].Set(Gf.Vec3d(*at))
        author_body(part.GetPrim())
        define_collider(stage, part.GetPath().AppendChild("shape"), shape((0.1, 0.1, 0.1)))
    built = np.eye(4)
    built[:3, 3] = 0.3, 0.4, 0.5
    _, size = frame_and_scale(root.ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
    motion = Motion("rail", np.array(axis), (0.0, 0.2), built)
    ends = (Sdf.Path("/Thing/body"), Sdf.Path("/Thing/part"))
    define_joint(stage, Sdf.Path("/Thing/joint"), motion, ends, size)
    ((_, *_), (desc, *_)) = UsdPhysics.UsdPhysicsLoadStageFromPrimRange(stage, ["/"])[
        Kind.PrismaticJoint
    ]
    frame, _ = frame_and_scale(root.ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
    align = np.array(Gf.Matrix3d(Gf.Quatd(desc.localPose0Orientation).GetNormalized())).T
    unit = np.eye(3)["XYZ".index(str(desc.axis)[-1])]
    gone = frame[:3, :3] @ align @ unit * desc.limit.upper

    def middle() -> np.ndarray:
        prim = UsdGeom.Xformable(stage.GetPrimAtPath("/Thing/part"))
        place = prim.ComputeLocalToWorldTransform(Usd.TimeCode.Default())
        return np.array(place.ExtractTranslation())

    before = middle()
    parts["part"].Set(Gf.Vec3d(*(np.array([0.3, 0.4, 0.5]) + 0.2 * np.array(axis))))
    np.testing.assert_allclose(middle() - before, gone, atol=1e-6)
    assert not desc.collisionEnabled


@pytest.mark.parametrize(
    ("limits", "zero"), [((0.0, 270.0), 135.0), ((-90.0, 200.0), 55.0), ((0.0, 180.0), 0.0)]
)
def test_a_knob_has_its_zero_where_no_engine_stops_it(
    limits: tuple[float, float], zero: float
) -> None:
    stage, _ = placed((1.0, 1.0, 1.0))
    for name in ("body", "knob"):
        part = UsdGeom.Xform.Define(stage, f"/Thing/{name}")
        author_body(part.GetPrim())
        define_collider(stage, part.GetPath().AppendChild("shape"), shape((0.1, 0.1, 0.1)))
    motion = Motion("hinge", np.array([0.0, -1.0, 0.0]), limits, np.eye(4))
    ends = (Sdf.Path("/Thing/body"), Sdf.Path("/Thing/knob"))
    joint = UsdPhysics.RevoluteJoint(
        define_joint(stage, Sdf.Path("/Thing/joint"), motion, ends, np.ones(3))
    )
    written = (joint.GetLowerLimitAttr().Get(), joint.GetUpperLimitAttr().Get())
    assert written == (limits[0] - zero, limits[1] - zero)
    # As it is built, it has the same way to go.
    (body,) = read_world(stage).bodies
    np.testing.assert_allclose(np.degrees(body.joints[0].limits), limits, atol=1e-3)
    assert not list(joint_frames(Subject(stage)))


def test_colliders_are_guides_and_bound_prims_are_valid() -> None:
    stage, _ = placed((1.0, 1.0, 1.0))
    scope = define_guides(stage, Sdf.Path("/Thing/Colliders"))
    prim = define_collider(stage, scope.AppendChild("shape"), shape((1, 2, 3)))
    assert UsdGeom.Imageable(prim).ComputePurpose() == UsdGeom.Tokens.guide
    api = UsdPhysics.MeshCollisionAPI(prim)
    assert api.GetApproximationAttr().Get() == UsdPhysics.Tokens.convexHull
    np.testing.assert_allclose(
        np.array(UsdGeom.Mesh(prim).GetExtentAttr().Get()), [[-0.5, -1, -1.5], [0.5, 1, 1.5]]
    )


OAK = MaterialPhysics(0.5, 0.375, 0.625, 720.0, friction_spread=0.125)


@pytest.fixture
def prim() -> Iterator[Usd.Prim]:
    stage = Usd.Stage.CreateInMemory()
    yield UsdShade.Material.Define(stage, "/World/Materials/oak").GetPrim()


def test_round_trip(prim):
    assert physics.read(prim) is None
    physics.author(prim, OAK)
    assert physics.read(prim) == OAK
    standard = UsdPhysics.MaterialAPI(prim)
    assert standard.GetDynamicFrictionAttr().Get() == 0.375
    assert standard.GetDensityAttr().Get() == 720.0
    spread = prim.GetAttribute("openrooms:material:frictionSpread")
    assert spread.GetTypeName() == Sdf.ValueTypeNames.Float and not spread.IsCustom()
    # Without the plugin of our schemas USD lists only those that it knows.
    assert names.MATERIAL_API in prim.GetMetadata("apiSchemas").GetAppliedItems()


def test_without_spread_it_is_the_standard_alone(prim):
    physics.author(prim, MaterialPhysics(0.5, 0.25, 0.0, 0.0))
    assert prim.GetMetadata("apiSchemas").GetAppliedItems() == ["PhysicsMaterialAPI"]
    assert physics.read(prim) == MaterialPhysics(0.5, 0.25, 0.0, 0.0, None)


@pytest.mark.parametrize(
    "wrong",
    [
        {"dynamic_friction": 0.6},
        {"dynamic_friction": -0.1},
        {"static_friction": math.nan},
        {"static_friction": math.inf},
        {"restitution": 1.1},
        {"density": -1.0},
        {"density": math.nan},
        {"friction_spread": -0.1},
        {"friction_spread": math.nan},
    ],
    ids=str,
)
def test_what_no_surface_has(prim, wrong):
    with pytest.raises(ValueError, match="no "):
        physics.author(prim, MaterialPhysics(**{**OAK.__dict__, **wrong}))
    assert prim.GetAppliedSchemas() == []


def test_a_foreign_file_that_says_little_or_nonsense(prim):
    UsdPhysics.MaterialAPI.Apply(prim)
    assert physics.read(prim) == MaterialPhysics(0.0, 0.0, 0.0, 0.0, None)
    prim.CreateAttribute("physics:staticFriction", Sdf.ValueTypeNames.Float).Set(math.nan)
    prim.CreateAttribute("physics:density", Sdf.ValueTypeNames.Float).Set(-3.0)
    assert physics.read(prim) == MaterialPhysics(0.0, 0.0, 0.0, 0.0, None)


def test_category(prim):
    assert physics.read_category(prim) is None
    prim.CreateAttribute(names.MATERIAL_CATEGORY, Sdf.ValueTypeNames.Token).Set("wood")
    assert physics.read_category(prim) == "wood"
