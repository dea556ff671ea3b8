"""Foreign stages with UsdPhysics as worlds: frames, units, masses, shapes, joints, mistakes."""

from collections.abc import Callable

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdSemantics, UsdShade

from openrooms_usd.errors import InputError, StageError
from openrooms_usd.physics.mass import MassProperties
from openrooms_usd.physics.world import Link, World
from openrooms_usd.usd.rigid.reading import read_world

Place = tuple[float, float, float]


def new(metres: float = 1.0, up: str = "Z") -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, metres)
    UsdGeom.SetStageUpAxis(stage, up)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    return stage


def body(stage: Usd.Stage, name: str, at: Place = (0, 0, 0), scale: Place = (1, 1, 1)) -> str:
    """A cube of side 1 below a nested scope, its middle one to the right of the body."""
    path = f"/World/{name}"
    xform = UsdGeom.Xform.Define(stage, path)
    xform.AddTranslateOp().Set(Gf.Vec3d(*at))
    xform.AddScaleOp().Set(Gf.Vec3f(*scale))
    UsdPhysics.RigidBodyAPI.Apply(xform.GetPrim())
    UsdGeom.Scope.Define(stage, f"{path}/shapes")
    cube = UsdGeom.Cube.Define(stage, f"{path}/shapes/cube")
    cube.CreateSizeAttr(1.0)
    cube.AddTranslateOp().Set(Gf.Vec3d(1, 0, 0))
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
    return path


def link(world: World, name: str) -> Link:
    return next(item for found in world.bodies for item in found.links if item.name == name)


def placed(world: World, name: str) -> np.ndarray:
    """The corners of all shapes of a one-link body, in the world."""
    found = next(item for item in world.bodies if item.name == name)
    points = np.concatenate([shape.mesh.points for shape in found.links[0].shapes])
    return points @ found.world_from_body[:3, :3].T + found.world_from_body[:3, 3]


def test_what_a_body_is_by_words_of_others() -> None:
    """The nearest that says it, whether on the body or above it."""
    stage = new()
    for name, taxonomy, word in (("a", "class", "Sofa"), ("b", "category", "lamp"), ("c", "", "")):
        prim = stage.GetPrimAtPath(body(stage, name))
        if taxonomy:
            UsdSemantics.LabelsAPI.Apply(prim, taxonomy).CreateLabelsAttr([word])
    root = stage.GetDefaultPrim()
    UsdSemantics.LabelsAPI.Apply(root, "class").CreateLabelsAttr(["chair"])
    found = {one.name: one.category for one in read_world(stage).bodies}
    assert found == {"a": "sofa", "b": "lamp", "c": "chair"}


def test_masses_follow_from_volume_and_density_or_from_what_is_said() -> None:
    stage = new()
    body(stage, "water")
    wood = UsdPhysics.MassAPI.Apply(stage.GetPrimAtPath(body(stage, "wood", scale=(2, 1, 1))))
    wood.CreateDensityAttr(500.0)
    said = UsdPhysics.MassAPI.Apply(stage.GetPrimAtPath(body(stage, "said")))
    said.CreateMassAttr(3.0)
    body(stage, "mirrored", scale=(-1, 1, 1))
    world = read_world(stage)
    mirrored = link(world, "mirrored").mass
    assert mirrored is not None and mirrored.mass == pytest.approx(1000.0)
    for name, mass, centre, side in (
        ("water", 1000, 1, 1),
        ("wood", 1000, 2, 2),
        ("said", 3, 1, 1),
    ):
        found = link(world, name).mass
        assert found is not None
        assert found.mass == pytest.approx(mass, rel=1e-6)
        np.testing.assert_allclose(found.centre, [centre, 0, 0], atol=1e-6)
        # A box about its middle.
        moments = mass / 12.0 * np.array([2.0, side**2 + 1.0, side**2 + 1.0])
        np.testing.assert_allclose(np.diag(found.inertia), moments, rtol=1e-5)


def test_units_and_axes_become_ours() -> None:
    stage = new(0.01, "Y")
    UsdPhysics.SetStageKilogramsPerUnit(stage, 0.001)
    path = body(stage, "box", at=(100, 200, 300), scale=(50, 50, 50))
    UsdPhysics.MassAPI.Apply(stage.GetPrimAtPath(path)).CreateMassAttr(4000.0)
    scene = UsdPhysics.Scene.Define(stage, "/World/Scene")
    scene.CreateGravityMagnitudeAttr(300.0)
    world = read_world(stage)
    (found,) = world.bodies
    mass = found.links[0].mass
    assert mass is not None and mass.mass == pytest.approx(4.0)
    np.testing.assert_allclose(mass.centre, [0.5, 0, 0], atol=1e-6)
    np.testing.assert_allclose(np.diag(mass.inertia), np.full(3, 4.0 * 0.5**2 / 6.0), rtol=1e-5)
    corners = placed(world, "box")
    np.testing.assert_allclose(corners.min(axis=0), [1.25, -3.25, 1.75], atol=1e-6)
    np.testing.assert_allclose(world.gravity, [0, 0, -3.0], atol=1e-6)


@pytest.mark.parametrize("scale", [(1, 1, 1), (2, 1, 3), (-1, 1, 1), (-2, 3, -1)])
def test_scales_and_mirrors_are_baked_into_shapes_and_visuals(scale: Place) -> None:
    stage = new()
    path = body(stage, "box", at=(1, 2, 3), scale=scale)
    mass = UsdPhysics.MassAPI.Apply(stage.GetPrimAtPath(path))
    mass.CreateMassAttr(1.0)
    mass.CreateCenterOfMassAttr(Gf.Vec3f(1, 0, 0))
    mass.CreateDiagonalInertiaAttr(Gf.Vec3f(1, 1, 1))
    (found,) = read_world(stage).bodies
    assert np.linalg.det(found.world_from_body[:3, :3]) == pytest.approx(1.0)
    sides = np.array([[0.5, 1.5], [-0.5, 0.5], [-0.5, 0.5]]) * np.array(scale)[:, None]
    low, high = np.sort(sides, axis=1).T + np.array([1, 2, 3])
    corners = placed(read_world(stage), "box")
    np.testing.assert_allclose(corners.min(axis=0), low, atol=1e-6)
    np.testing.assert_allclose(corners.max(axis=0), high, atol=1e-6)
    for mesh in (found.links[0].shapes[0].mesh, found.links[0].visuals[0].mesh):
        a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
        volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0
        assert volume == pytest.approx(abs(np.prod(scale)), rel=1e-6)
    weight = found.links[0].mass
    assert weight is not None
    at = found.world_from_body[:3, :3] @ weight.centre + found.world_from_body[:3, 3]
    np.testing.assert_allclose(at, [1.0 + scale[0], 2.0, 3.0], atol=1e-6)


def hinged(
    make: Callable[..., UsdPhysics.Joint], **ends: str
) -> tuple[Usd.Stage, UsdPhysics.Joint]:
    stage = new()
    body(stage, "a")
    body(stage, "b", at=(3, 0, 0))
    joint = make(stage, "/World/joint")
    for side, path in ends.items():
        getattr(joint, f"Create{side.capitalize()}Rel")().SetTargets([path])
    return stage, joint


def test_a_hinge_is_in_the_frame_of_its_child_and_counts_from_the_pose_of_the_stage() -> None:
    ends = {"body0": "/World/a", "body1": "/World/b"}
    stage, joint = hinged(UsdPhysics.RevoluteJoint.Define, **ends)
    joint.CreateAxisAttr("Z")
    joint.CreateLowerLimitAttr(-10.0)
    joint.CreateUpperLimitAttr(80.0)
    joint.CreateLocalPos0Attr(Gf.Vec3f(2, 0, 0))
    joint.CreateLocalPos1Attr(Gf.Vec3f(-1, 0, 0))
    drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular")
    drive.CreateDampingAttr(float(np.pi / 180.0))
    # The child stands 30 degrees open: turned about the joint's place.
    turned = UsdGeom.Xformable(stage.GetPrimAtPath("/World/b"))
    turned.ClearXformOpOrder()
    angle = np.radians(30.0)
    turned.AddTranslateOp(opSuffix="x").Set(Gf.Vec3d(2 + np.cos(angle), np.sin(angle), 0))
    turned.AddRotateZOp().Set(30.0)
    (found,) = read_world(stage).bodies
    assert [item.name for item in found.links] == ["a", "b"]
    (read,) = found.joints
    assert (read.kind, read.parent, read.child) == ("hinge", "a", "b")
    np.testing.assert_allclose(read.axis, [0, 0, 1], atol=1e-6)
    np.testing.assert_allclose(np.degrees(read.limits), [-40, 50], atol=1e-4)
    assert read.damping == pytest.approx(1.0, rel=1e-5)
    np.testing.assert_allclose(found.links[1].body_from_link[:3, 3], [2, 0, 0], atol=1e-6)
    mass = found.links[1].mass
    assert mass is not None
    np.testing.assert_allclose(mass.centre, [2, 0, 0], atol=1e-5)


def test_a_rail_that_is_held_by_its_second_body_is_turned_round() -> None:
    stage, joint = hinged(UsdPhysics.PrismaticJoint.Define, body0="/World/a")
    joint.CreateAxisAttr("Y")
    joint.CreateLowerLimitAttr(0.0)
    joint.CreateUpperLimitAttr(0.4)
    found = next(item for item in read_world(stage).bodies if len(item.links) > 1)
    assert found.fixed
    np.testing.assert_allclose(found.joints[0].axis, [0, -1, 0], atol=1e-6)
    np.testing.assert_allclose(found.joints[0].limits, [0, 0.4], atol=1e-6)


def test_a_body_that_is_fixed_to_the_world_never_moves() -> None:
    stage, _ = hinged(UsdPhysics.FixedJoint.Define, body1="/World/b")
    fixed = {item.name: item.fixed for item in read_world(stage).bodies}
    assert fixed == {"a": False, "b": True}


@pytest.mark.parametrize("how", ["physics:rigidBodyEnabled", "physics:kinematicEnabled"])
def test_what_is_switched_off_or_kinematic_stays_where_it_is(how: str) -> None:
    stage = new()
    prim = stage.GetPrimAtPath(body(stage, "box"))
    prim.GetAttribute(how).Set(how.endswith("kinematicEnabled"))
    (found,) = read_world(stage).bodies
    assert found.fixed
    assert found.links[0].mass is None
    assert len(found.links[0].shapes) == 1


def test_shapes_of_every_kind_are_convex_and_as_large_as_they_are() -> None:
    stage = new()
    makers = {
        "Sphere": (UsdGeom.Sphere, 4 / 3 * np.pi),
        "Cylinder": (UsdGeom.Cylinder, 2 * np.pi),
        "Capsule": (UsdGeom.Capsule, np.pi * (0.5**2 * 1.0 + 4 / 3 * 0.5**3)),
        "Cone": (UsdGeom.Cone, 2 / 3 * np.pi),
    }
    for name, (schema, _) in makers.items():
        prim = schema.Define(stage, f"/World/{name}").GetPrim()
        UsdPhysics.CollisionAPI.Apply(prim)
        UsdPhysics.RigidBodyAPI.Apply(prim)
    plane = UsdGeom.Plane.Define(stage, "/World/Ground").GetPrim()
    UsdPhysics.CollisionAPI.Apply(plane)
    world = read_world(stage)
    for name, (_, volume) in makers.items():
        mass = link(world, name).mass
        assert mass is not None
        assert mass.mass / 1000.0 == pytest.approx(volume, rel=0.03), name
    assert placed(world, "Ground")[:, 2].max() == pytest.approx(0.0)
    assert [outcome for path, outcome, _ in world.losses if path == "/World/Ground"] == [
        "approximated"
    ]


def test_physics_materials_and_instances_are_read_through_prototypes() -> None:
    stage = new()
    UsdGeom.Xform.Define(stage, "/Thing")
    UsdPhysics.RigidBodyAPI.Apply(stage.GetPrimAtPath("/Thing"))
    cube = UsdGeom.Cube.Define(stage, "/Thing/cube").GetPrim()
    UsdPhysics.CollisionAPI.Apply(cube)
    rubber = UsdShade.Material.Define(stage, "/Thing/Rubber")
    made = UsdPhysics.MaterialAPI.Apply(rubber.GetPrim())
    made.CreateStaticFrictionAttr(0.9)
    made.CreateDynamicFrictionAttr(0.7)
    made.CreateDensityAttr(1100.0)
    binding = UsdShade.MaterialBindingAPI.Apply(cube)
    binding.Bind(rubber, UsdShade.Tokens.weakerThanDescendants, "physics")
    for name in ("one", "two"):
        prim = UsdGeom.Xform.Define(stage, f"/World/{name}").GetPrim()
        prim.GetReferences().AddInternalReference("/Thing")
        prim.SetInstanceable(True)
    world = read_world(stage)
    one, two = link(world, "one"), link(world, "two")
    assert one.shapes[0].contact.static_friction == pytest.approx(0.9)
    assert one.shapes[0].mesh is two.shapes[0].mesh
    assert one.visuals[0].mesh is two.visuals[0].mesh
    assert one.mass is not None and one.mass.mass == pytest.approx(8 * 1100.0)


def test_what_cannot_be_read_is_refused_or_told() -> None:
    with pytest.raises(StageError, match="has no physics"):
        read_world(new())
    stage = new()
    prim = stage.GetPrimAtPath(body(stage, "box"))
    UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(-2.0)
    with pytest.raises(InputError, match="physics:mass is -2"):
        read_world(stage)
    stage = new()
    stage.RemovePrim(f"{body(stage, 'hollow')}/shapes")
    with pytest.raises(InputError, match="the mass of this body is unknown"):
        read_world(stage)


def bare(stage: Usd.Stage) -> None:
    stage.RemovePrim("/World/thing/shapes")


def disabled(stage: Usd.Stage) -> None:
    stage.GetPrimAtPath(CUBE).GetAttribute("physics:collisionEnabled").Set(False)


def drawn(stage: Usd.Stage) -> None:
    stage.GetPrimAtPath(CUBE).RemoveAPI(UsdPhysics.CollisionAPI)


def line(stage: Usd.Stage) -> None:
    """A hull of two points, which no triangle joins."""
    bare(stage)
    mesh = UsdGeom.Mesh.Define(stage, "/World/thing/line")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0)])
    UsdPhysics.CollisionAPI.Apply(mesh.GetPrim())
    UsdPhysics.MassAPI.Apply(mesh.GetPrim()).CreateMassAttr(3.0)


CUBE = "/World/thing/shapes/cube"
BALL = 0.4 * 0.05**2
WEIGHED = {
    "a frame of a mass": (bare, 3.0, (0, 0, 0), 3.0 * BALL),
    "a line of a mass": (line, None, (0, 0, 0), 3.0 * BALL),
    "a disabled collider": (disabled, 3.0, (1, 0, 0), 3.0 / 6.0),
    "no collider": (drawn, 3.0, (1, 0, 0), 3.0 / 6.0),
    "neither collider nor mass": (drawn, None, (1, 0, 0), 1000.0 / 6.0),
}


@pytest.mark.parametrize("kind", list(WEIGHED))
def test_without_a_collider_what_is_drawn_is_weighed(kind: str) -> None:
    """A cube of side 1 m has a sixth of its mass about every axis, a ball 0.4 m r2."""
    change, said, centre, moment = WEIGHED[kind]
    stage = new()
    prim = stage.GetPrimAtPath(body(stage, "thing"))
    body(stage, "other")
    if said is not None:
        UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(said)
    change(stage)
    world = read_world(stage)
    found = link(world, "thing").mass
    assert found is not None and found.mass == pytest.approx(said or (3.0 if moment < 1 else 1e3))
    np.testing.assert_allclose(found.centre, centre, atol=1e-6)
    np.testing.assert_allclose(found.inertia, moment * np.eye(3), atol=1e-5 * moment)
    assert ("/World/thing", "approximated") in [row[:2] for row in world.losses]


def test_joints_that_hold_nothing_are_told() -> None:
    ends = {"body0": "/World/a", "body1": "/World/b"}
    for make, why in (
        (UsdPhysics.DistanceJoint.Define, "distance"),
        (UsdPhysics.Joint.Define, "every direction free"),
    ):
        stage, _ = hinged(make, **ends)
        world = read_world(stage)
        assert len(world.bodies) == 2
        (told,) = world.losses
        assert told[:2] == ("/World/joint", "skipped") and why in told[2]


@pytest.mark.parametrize("missing", ["/World/none/at/all", "/World/a.visibility"])
def test_a_joint_to_what_is_no_prim_holds_on_to_the_world(missing: str) -> None:
    stage, _ = hinged(UsdPhysics.RevoluteJoint.Define, body0=missing, body1="/World/b")
    (found,) = (item for item in read_world(stage).bodies if item.joints)
    assert [row.name for row in found.links] == ["joint", "b"]


def test_names_are_unique_and_safe() -> None:
    stage = new()
    body(stage, "box")
    UsdGeom.Xform.Define(stage, "/World/inner")
    body(stage, "inner/box")
    names = [item.name for item in read_world(stage).bodies]
    assert names == ["box", "box_1"]


SIDE = 0.02
MOMENTS = np.array([6e-8, 7e-8, 8e-8])


@pytest.fixture
def stage() -> Usd.Stage:
    """A cube of a gram that says all of its mass itself."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    cube = UsdGeom.Cube.Define(stage, "/crumb")
    cube.CreateSizeAttr(1.0)
    cube.AddScaleOp().Set(Gf.Vec3f(SIDE))
    prim = cube.GetPrim()
    UsdPhysics.RigidBodyAPI.Apply(prim)
    UsdPhysics.CollisionAPI.Apply(prim)
    said = UsdPhysics.MassAPI.Apply(prim)
    said.CreateMassAttr(1e-3)
    said.CreateCenterOfMassAttr(Gf.Vec3f(1, 0, 0))
    said.CreateDiagonalInertiaAttr(Gf.Vec3f(*MOMENTS))
    return stage


def mass_of(stage: Usd.Stage) -> MassProperties:
    found = read_world(stage).bodies[0].links[0].mass
    assert found is not None
    return found


def test_its_inertia_is_what_it_says(stage: Usd.Stage) -> None:
    """USD's own computation takes such moments for unsaid."""
    found = mass_of(stage)
    assert found.mass == pytest.approx(1e-3)
    np.testing.assert_allclose(found.centre, [SIDE, 0, 0], rtol=1e-6)
    np.testing.assert_allclose(found.inertia, np.diag(MOMENTS), rtol=1e-6)


def test_its_axes_are_what_it_says(stage: Usd.Stage) -> None:
    """A quarter turn about Z changes X with Y."""
    quarter = Gf.Quatf(0.5**0.5, 0, 0, 0.5**0.5)
    UsdPhysics.MassAPI(stage.GetPrimAtPath("/crumb")).CreatePrincipalAxesAttr(quarter)
    np.testing.assert_allclose(mass_of(stage).inertia, np.diag(MOMENTS[[1, 0, 2]]), atol=1e-14)
