"""What moves, held at one time: against closed forms, and stages that were written still."""

import math
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Ts, Usd, UsdGeom, UsdLux, UsdSkel, Vt

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.cameras import read_camera
from openrooms_usd.usd.moments import freeze_time
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.shapes.meshes import read_meshes

SQUARE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]


def new_stage() -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(24.0)
    return stage


def square(stage: Usd.Stage, path: str) -> UsdGeom.Mesh:
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(SQUARE)
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr("none")
    return mesh


def points(stage: Usd.Stage) -> dict[str, np.ndarray]:
    return {mesh.path: mesh.world_points() for mesh in read_meshes(stage)}


def moving_stage() -> Usd.Stage:
    """A square that flies, one that bends, one that vanishes; a camera that zooms, a lamp."""
    stage = new_stage()
    flying = UsdGeom.Xformable(square(stage, "/flying")).AddTranslateOp()
    flying.Set((0, 0, 0), 10.0)
    flying.Set((6, 0, 3), 40.0)
    bending = square(stage, "/bending").GetPointsAttr()
    bending.Set(SQUARE, 10.0)
    bending.Set([(x, y, 9.0 * x) for x, y, _ in SQUARE], 40.0)
    vanishing = square(stage, "/vanishing").CreateVisibilityAttr()
    vanishing.Set("inherited", 10.0)
    vanishing.Set("invisible", 30.0)
    zoom = UsdGeom.Camera.Define(stage, "/camera").GetFocalLengthAttr()
    zoom.Set(20.0, 10.0)
    zoom.Set(80.0, 40.0)
    lamp = UsdLux.SphereLight.Define(stage, "/lamp").CreateIntensityAttr()
    lamp.Set(100.0, 10.0)
    lamp.Set(400.0, 40.0)
    return stage


def still_stage(done: float) -> Usd.Stage:
    """The same, written without time: at this part of the way."""
    stage = new_stage()
    UsdGeom.Xformable(square(stage, "/flying")).AddTranslateOp().Set((6 * done, 0, 3 * done))
    square(stage, "/bending").GetPointsAttr().Set([(x, y, 9.0 * x * done) for x, y, _ in SQUARE])
    square(stage, "/vanishing")
    if done * 30.0 + 10.0 >= 30.0:
        stage.GetPrimAtPath("/vanishing").GetAttribute("visibility").Set("invisible")
    UsdGeom.Camera.Define(stage, "/camera").GetFocalLengthAttr().Set(20.0 + 60.0 * done)
    UsdLux.SphereLight.Define(stage, "/lamp").CreateIntensityAttr(100.0 + 300.0 * done)
    return stage


@pytest.mark.parametrize("time_code", [None, 0.0, 10.0, 17.5, 30.0, 40.0, 99.0])
def test_a_stage_held_still_is_one_written_still(time_code: float | None) -> None:
    moving = moving_stage()
    assert freeze_time(moving, time_code) == {}
    at = 10.0 if time_code is None else min(max(time_code, 10.0), 40.0)
    still = still_stage((at - 10.0) / 30.0)
    ours, theirs = translate(moving), translate(still)
    assert ours.report.rows == theirs.report.rows
    assert len(ours.patches) == len(theirs.patches)
    for one, other in zip(ours.patches, theirs.patches, strict=True):
        assert np.allclose(one.triangles.corners, other.triangles.corners, atol=1e-6)
        assert np.allclose(one.triangles.normals, other.triangles.normals, atol=1e-6)
        assert (one.radiance is None) == (other.radiance is None)
        if one.radiance is not None:
            assert np.allclose(one.radiance, other.radiance, rtol=1e-6)
    cameras = (read_camera(stage.GetPrimAtPath("/camera"), 64, 48) for stage in (moving, still))
    assert np.allclose(*(camera.K for camera in cameras), rtol=1e-6)


def test_a_still_stage_stays_as_it_is() -> None:
    stage = still_stage(0.5)
    freeze_time(stage)
    assert stage.GetSessionLayer().empty
    before = points(stage)
    freeze_time(stage, 3.0)
    assert all(np.array_equal(before[path], now) for path, now in points(stage).items())


def test_values_that_are_held_between_samples() -> None:
    stage = moving_stage()
    stage.SetInterpolationType(Usd.InterpolationTypeHeld)
    freeze_time(stage, 39.0)
    assert np.allclose(points(stage)["/flying"], SQUARE)


def test_splines() -> None:
    stage = new_stage()
    radius = UsdGeom.Sphere.Define(stage, "/ball").GetRadiusAttr()
    spline = Ts.Spline("double")
    for at, value in ((2.0, 5.0), (4.0, 9.0)):
        knot = Ts.Knot()
        knot.SetTime(at)
        knot.SetValue(value)
        knot.SetNextInterpolation(Ts.InterpLinear)
        spline.SetKnot(knot)
    radius.SetSpline(spline)
    freeze_time(stage, 3.5)
    assert radius.Get(TIME) == pytest.approx(8.0)


def test_velocities_carry_points_away_from_their_samples() -> None:
    stage = new_stage()
    mesh = square(stage, "/cloth")
    mesh.GetPointsAttr().Set(SQUARE, 24.0)
    mesh.GetPointsAttr().Set([(9, 9, 9)] * 4, 48.0)
    velocity = (1.0, -2.0, 4.0)
    for at in (24.0, 48.0):
        mesh.CreateVelocitiesAttr().Set([velocity] * 4, at)
    freeze_time(stage, 30.0)  # a quarter of a second later
    assert np.allclose(points(stage)["/cloth"], np.array(SQUARE) + np.array(velocity) / 4)


def test_velocities_turn_and_carry_instances() -> None:
    stage = new_stage()
    square(stage, "/swarm/proto")
    swarm = UsdGeom.PointInstancer.Define(stage, "/swarm")
    swarm.CreatePrototypesRel().AddTarget("/swarm/proto")
    swarm.CreateProtoIndicesAttr([0, 0])
    for at in (24.0, 72.0):
        swarm.CreatePositionsAttr().Set([(0, 0, 0), (5, 0, 0)], at)
        swarm.CreateVelocitiesAttr().Set([(0, 0, 2), (0, 0, 4)], at)
        swarm.CreateScalesAttr().Set([(1, 1, 1), (2, 2, 2)], at)
        swarm.CreateOrientationsAttr().Set([Gf.Quath(1), Gf.Quath(1)], at)
        swarm.CreateAngularVelocitiesAttr().Set([(0, 0, 0), (0, 0, 60)], at)
    freeze_time(stage, 36.0)  # half a second later: 30 degrees
    found = points(stage)
    assert np.allclose(found["/swarm[0]"], np.add(SQUARE, (0, 0, 1)), atol=1e-6)
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    turned = np.array(SQUARE) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    assert np.allclose(found["/swarm[1]"], 2.0 * turned + (5, 0, 2), atol=1e-5)


def test_what_moves_inside_of_instances() -> None:
    """Nested ones too; those with nothing inside that moves stay instances."""
    stage = new_stage()
    for name, moves in (("Wheel", True), ("Seat", False)):
        square(stage, f"/{name}/Part")
        if moves:
            op = UsdGeom.Xformable(stage.GetPrimAtPath(f"/{name}/Part")).AddTranslateOp()
            op.Set((0, 0, 0), 0.0)
            op.Set((0, 0, 8), 8.0)
        stage.GetPrimAtPath(f"/{name}").SetSpecifier(Sdf.SpecifierClass)
    for name in ("Wheel", "Seat"):
        inner = stage.DefinePrim(f"/Car/{name}", "Xform")
        inner.GetReferences().AddInternalReference(f"/{name}")
        inner.SetInstanceable(True)
    stage.GetPrimAtPath("/Car").SetSpecifier(Sdf.SpecifierClass)
    for number in range(2):
        car = UsdGeom.Xform.Define(stage, f"/car_{number}")
        car.GetPrim().GetReferences().AddInternalReference("/Car")
        car.GetPrim().SetInstanceable(True)
        car.AddTranslateOp().Set((10 * number, 0, 0))
    freeze_time(stage, 2.0)
    found = points(stage)
    for number in range(2):
        shift = (10 * number, 0, 0)
        assert np.allclose(found[f"/car_{number}/Wheel/Part"], np.add(SQUARE, (10 * number, 0, 2)))
        assert np.allclose(found[f"/car_{number}/Seat/Part"], np.add(SQUARE, shift))
    assert stage.GetPrimAtPath("/car_1/Seat").IsInstance()


def test_references_that_are_late() -> None:
    stage = new_stage()
    op = UsdGeom.Xformable(square(stage, "/Source/Part")).AddTranslateOp()
    op.Set((0, 0, 0), 0.0)
    op.Set((0, 0, 8), 8.0)
    for name, offset in (("now", 0.0), ("late", 3.0)):
        prim = stage.DefinePrim(f"/{name}", "Xform")
        prim.GetReferences().AddInternalReference("/Source", Sdf.LayerOffset(offset))
        prim.SetInstanceable(True)
    freeze_time(stage, 5.0)
    assert points(stage)["/now/Part"][0, 2] == pytest.approx(5.0)
    assert points(stage)["/late/Part"][0, 2] == pytest.approx(2.0)


CLIP = """#usda 1.0
def "Source"
{{
    point3f[] points.timeSamples = {{ {at}: [(0, 0, {z}), (1, 0, {z}), (1, 1, {z}), (0, 1, {z})] }}
}}
"""
MANIFEST = '#usda 1.0\ndef "Source"\n{\n    point3f[] points\n}\n'
CLIPPED = """#usda 1.0
(
    upAxis = "Z"
    metersPerUnit = 1
)
def Mesh "cloth" (
    clips = {{
        dictionary default = {{
            double2[] active = [(0, 0), (10, 1)]
            asset[] assetPaths = [@./a.usda@, @./b.usda@]
            asset manifestAssetPath = @./manifest.usda@
            string primPath = "/Source"
            double2[] times = [(0, 0), (10, 10)]
        }}
    }}
)
{{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    uniform token subdivisionScheme = "none"
}}
"""


@pytest.mark.parametrize(
    ("time_code", "height"), [(0.0, 1.0), (9.0, 2.8), (10.0, 3.0), (40.0, 3.0)]
)
def test_value_clips(tmp_path: Path, time_code: float, height: float) -> None:
    """Linear between the last sample of a clip and the first of the next, as USD has it."""
    (tmp_path / "a.usda").write_text(CLIP.format(at=0, z=1))
    (tmp_path / "b.usda").write_text(CLIP.format(at=10, z=3))
    (tmp_path / "manifest.usda").write_text(MANIFEST)
    (tmp_path / "stage.usda").write_text(CLIPPED.format())
    stage = Usd.Stage.Open(str(tmp_path / "stage.usda"))
    freeze_time(stage, time_code)
    assert np.allclose(points(stage)["/cloth"], np.add(SQUARE, (0, 0, height)))


def test_pictures_that_change_are_found_from_their_own_layer(tmp_path: Path) -> None:
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "a.png").write_bytes(b"")
    layer = Usd.Stage.CreateNew(str(tmp_path / "deep" / "part.usda"))
    attribute = layer.DefinePrim("/Part").CreateAttribute("file", Sdf.ValueTypeNames.Asset)
    attribute.Set(Sdf.AssetPath("./a.png"), 0.0)
    attribute.Set(Sdf.AssetPath("./a.<UDIM>.png"), 5.0)
    layer.GetRootLayer().Save()
    stage = new_stage()
    stage.DefinePrim("/Here").GetReferences().AddReference(
        str(tmp_path / "deep" / "part.usda"), "/Part"
    )
    found = stage.GetPrimAtPath("/Here").GetAttribute("file")
    for at, name in ((1.0, "a.png"), (6.0, "a.<UDIM>.png")):
        freeze_time(stage, at)
        assert found.Get(TIME).path == str(tmp_path / "deep" / name)
        stage.GetSessionLayer().Clear()


def test_a_shutter_that_is_open_while_something_moves_is_told() -> None:
    stage = moving_stage()
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/camera"))
    camera.CreateShutterOpenAttr(-0.25)
    camera.CreateShutterCloseAttr(0.25)
    for name in ("/camera", "/lamp"):
        for attribute in stage.GetPrimAtPath(name).GetAuthoredAttributes():
            if attribute.GetNumTimeSamples():
                stage.GetPrimAtPath(name).RemoveProperty(attribute.GetName())
    lost = freeze_time(stage, 20.0)
    assert list(lost) == ["/camera"]
    assert "motion blur" in lost["/camera"]
    assert "-0.25 to 0.25" in lost["/camera"]
    assert "2 values" in lost["/camera"]  # the third vanishes at 30
    assert freeze_time(stage, 90.0) == {}  # everything has come to rest


@pytest.mark.parametrize("time_code", [math.nan, math.inf])
def test_a_time_that_is_none(time_code: float) -> None:
    with pytest.raises(InputError, match="time code"):
        freeze_time(new_stage(), time_code)


def test_arrays_that_are_blocked() -> None:
    stage = new_stage()
    attribute = square(stage, "/mesh").GetPointsAttr()
    attribute.Set(Vt.Vec3fArray(SQUARE), 0.0)
    attribute.GetPrim().GetAttribute("points").Set(Sdf.ValueBlock(), 4.0)
    freeze_time(stage, 5.0)
    assert attribute.Get(TIME) is None


POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1], [1, 0, 2], [0, 0, 2.0]])
WEIGHTS = np.array([[1, 0], [1, 0], [0.5, 0.5], [0.5, 0.5], [0, 1], [0, 1.0]])
SMILE = np.array([[0, 0, 0], [0, 0, 0], [0, -1, 0], [0, -1, 0], [0, 0, 3], [0, 0, 3.0]])
# Row vectors, as USD has them: the second joint stands at the height 1.
BIND = np.array([np.eye(4), np.eye(4)])
BIND[1, 3, 2] = 1.0


def puppet(path: str = "/World/Puppet") -> Usd.Stage:
    """Two joints: the root rises, the other one bends by a right angle within ten time codes."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdSkel.Root.Define(stage, path)
    skeleton = UsdSkel.Skeleton.Define(stage, f"{path}/Skeleton")
    skeleton.CreateJointsAttr(["a", "a/b"])
    matrices = [Gf.Matrix4d(one) for one in BIND]
    skeleton.CreateBindTransformsAttr(matrices)
    skeleton.CreateRestTransformsAttr(matrices)
    animation = UsdSkel.Animation.Define(stage, f"{path}/Animation")
    animation.CreateJointsAttr(["a", "a/b"])
    animation.CreateScalesAttr([Gf.Vec3h(1)] * 2)
    animation.CreateBlendShapesAttr(["smile"])
    bent = Gf.Quatf(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90).GetQuat())
    for at, height, turn in ((0.0, 0.0, Gf.Quatf(1)), (10.0, 4.0, bent)):
        animation.CreateTranslationsAttr().Set([(0, 0, height), (0, 0, 1)], at)
        animation.CreateRotationsAttr().Set([Gf.Quatf(1), turn], at)
        animation.CreateBlendShapeWeightsAttr().Set([at / 10.0], at)
    binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    mesh = UsdGeom.Mesh.Define(stage, f"{path}/Mesh")
    mesh.CreatePointsAttr(POINTS.astype(np.float32))
    mesh.CreateFaceVertexCountsAttr([4, 4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3, 3, 2, 4, 5])
    mesh.CreateSubdivisionSchemeAttr("none")
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateJointIndicesPrimvar(False, 2).Set([0, 1] * len(POINTS))
    binding.CreateJointWeightsPrimvar(False, 2).Set(WEIGHTS.reshape(-1).tolist())
    shape = UsdSkel.BlendShape.Define(stage, f"{path}/Mesh/Smile")
    shape.CreateOffsetsAttr(SMILE.astype(np.float32))
    binding.CreateBlendShapesAttr(["smile"])
    binding.CreateBlendShapeTargetsRel().SetTargets([shape.GetPath()])
    UsdGeom.Xformable(root).AddTranslateOp().Set((7, 0, 0))
    return stage


def expected(done: float) -> Array:
    """Blend shapes, then every point by the mean of its joints' motions since they were bound."""
    angle = np.radians(90.0 * done)
    c, s = np.cos(angle), np.sin(angle)
    first = np.eye(4)
    first[3, 2] = 4.0 * done
    second = np.array([[1, 0, 0, 0], [0, c, s, 0], [0, -s, c, 0], [0, 0, 1, 1]]) @ first
    motions = np.linalg.inv(BIND) @ np.array([first, second])
    shaped = np.column_stack([POINTS + done * SMILE, np.ones(len(POINTS))])
    moved = np.einsum("pj,pr,jrc->pc", WEIGHTS, shaped, motions)[:, :3]
    return np.add(moved, (7.0, 0.0, 0.0))


def only(stage: Usd.Stage) -> Array:
    (mesh,) = read_meshes(stage)
    return mesh.world_points()


@pytest.mark.parametrize("time_code", [None, 0.0, 5.0, 10.0])
def test_a_pose_is_what_linear_blend_skinning_gives(time_code: float | None) -> None:
    stage = puppet()
    assert freeze_time(stage, time_code) == {}
    assert np.allclose(only(stage), expected((time_code or 0.0) / 10.0), atol=1e-5)


def test_instances_of_what_is_skinned() -> None:
    stage = puppet("/Puppets/Puppet")
    stage.GetPrimAtPath("/Puppets").SetActive(True)
    for number in range(2):
        prim = stage.DefinePrim(f"/World/puppet_{number}", "Xform")
        prim.GetReferences().AddInternalReference("/Puppets")
        prim.SetInstanceable(True)
    freeze_time(stage, 5.0)
    found = [mesh.world_points() for mesh in read_meshes(stage)]
    assert len(found) == 3
    assert all(np.allclose(one, expected(0.5), atol=1e-5) for one in found)


def test_skinning_that_does_not_fit_is_told() -> None:
    stage = puppet()
    primvar = UsdSkel.BindingAPI(stage.GetPrimAtPath("/World/Puppet/Mesh")).GetJointIndicesPrimvar()
    primvar.Set([0, 7] * len(POINTS))
    lost = freeze_time(stage, 5.0)
    assert list(lost) == ["/World/Puppet/Mesh"]
    assert "rest pose" in lost["/World/Puppet/Mesh"]
    assert np.isfinite(only(stage)).all()
