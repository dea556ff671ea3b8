"""Cameras against the projection of USD's own frustum."""

import math

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.pinhole import look_at
from openrooms_usd.usd.cameras import (
    PinholeCamera,
    define_camera,
    exposure_of_ev100,
    framing_camera,
    list_cameras,
    read_camera,
    set_field_of_view,
)
from openrooms_usd.usd.places.frames import world_from_stage
from openrooms_usd.usd.shapes.meshes import define_mesh


def new_stage(axis: str = "Z", unit: float = 1.0) -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, axis)
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    return stage


def projected(camera: PinholeCamera, points: Array) -> Array:
    """(N, 2) pixels of world points."""
    seen = (
        np.column_stack([points, np.ones(len(points))]) @ np.linalg.inv(camera.world_from_camera).T
    )
    pixels = seen[:, :3] @ camera.K.T
    assert (pixels[:, 2] > 0).all()
    return pixels[:, :2] / pixels[:, 2:]


def by_frustum(prim: Usd.Prim, points: Array, width: int, height: int) -> Array:
    """(N, 2) pixels of stage points by USD's view and projection matrices."""
    camera = UsdGeom.Camera(prim).GetCamera(Usd.TimeCode.Default())
    # Conformed horizontally: the window's middle stays where it is.
    camera.verticalAperture = camera.horizontalAperture * height / width
    frustum = camera.frustum
    matrix = frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()
    ndc = np.array([matrix.Transform(Gf.Vec3d(*point)) for point in points.tolist()])
    return np.stack([(ndc[:, 0] + 1) / 2 * width, (1 - ndc[:, 1]) / 2 * height], axis=1)


def foreign_camera(stage: Usd.Stage, aspect: float, offsets: tuple[float, float]) -> UsdGeom.Camera:
    holder = UsdGeom.Xform.Define(stage, "/World/holder")
    holder.AddTranslateOp().Set((3, -4, 5))
    holder.AddRotateXYZOp().Set((10, 20, 30))
    camera = UsdGeom.Camera.Define(stage, "/World/holder/camera")
    camera.AddRotateYOp().Set(-40.0)
    camera.CreateFocalLengthAttr(35.0)
    camera.CreateHorizontalApertureAttr(24.0)
    camera.CreateVerticalApertureAttr(24.0 / aspect)
    camera.CreateHorizontalApertureOffsetAttr(offsets[0])
    camera.CreateVerticalApertureOffsetAttr(offsets[1])
    camera.CreateClippingRangeAttr(Gf.Vec2f(1, 1000))
    return camera


@pytest.mark.parametrize("axis", ["Y", "Z"])
@pytest.mark.parametrize("unit", [1.0, 0.01])
@pytest.mark.parametrize("offsets", [(0.0, 0.0), (3.0, -2.0)])
@pytest.mark.parametrize("size", [(640, 480), (480, 640), (1920, 816)])
def test_pixels_are_those_of_usds_frustum(
    axis: str, unit: float, offsets: tuple[float, float], size: tuple[int, int]
) -> None:
    """Also where the picture has another shape than the apertures."""
    stage = new_stage(axis, unit)
    prim = foreign_camera(stage, 4 / 3, offsets).GetPrim()
    rng = np.random.default_rng(2)
    local = np.column_stack([rng.uniform(-2, 2, (50, 2)), rng.uniform(-9, -4, 50)])
    placed = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
    points = np.array([placed.Transform(Gf.Vec3d(*point)) for point in local.tolist()])
    world = points @ world_from_stage(stage)[:3, :3].T
    found = projected(read_camera(prim, *size), world)
    # Offsets are in tenths of a unit on the film: the same in the conformed window.
    np.testing.assert_allclose(found, by_frustum(prim, points, *size), atol=1e-3)


def test_scaled_parents_do_not_bend_the_camera() -> None:
    stage = new_stage()
    camera = foreign_camera(stage, 4 / 3, (0, 0))
    plain = read_camera(camera.GetPrim(), 64, 48)
    UsdGeom.Xform(stage.GetPrimAtPath("/World/holder")).AddScaleOp().Set((2, 2, 2))
    scaled = read_camera(camera.GetPrim(), 64, 48)
    np.testing.assert_allclose(scaled.world_from_camera, plain.world_from_camera, atol=1e-6)


@pytest.mark.parametrize("size", [(640, 480), (300, 500)])
def test_reading_gives_back_what_was_defined(size: tuple[int, int]) -> None:
    stage = new_stage()
    matrix = look_at((1, 2, 1.5), (4, -1, 0.5))
    camera = define_camera(
        stage,
        "/World/Cameras/a",
        world_from_camera=matrix,
        fov_degrees=70.0,
        resolution=size,
        exposure=0.25,
    )
    found = read_camera(camera.GetPrim(), *size)
    np.testing.assert_allclose(found.world_from_camera, matrix, atol=1e-9)
    half = math.degrees(math.atan(size[0] / 2 / found.K[0, 0]))
    assert half == pytest.approx(35.0, rel=1e-6)
    assert found.K[1, 1] == found.K[0, 0]
    np.testing.assert_allclose(found.K[:2, 2], [size[0] / 2, size[1] / 2])
    assert found.exposure == pytest.approx(0.25, rel=1e-6)
    assert (found.f_stop, found.lens_radius) == (0.0, 0.0)
    frustum = camera.GetCamera(Usd.TimeCode.Default())
    assert frustum.GetFieldOfView(Gf.Camera.FOVHorizontal) == pytest.approx(70.0, abs=1e-4)
    assert frustum.aspectRatio == pytest.approx(size[0] / size[1], rel=1e-6)


def test_a_camera_sees_its_target_in_the_middle_and_up_above() -> None:
    stage = new_stage()
    matrix = look_at((1, 2, 3), (4, 5, 1))
    prim = define_camera(
        stage, "/c", world_from_camera=matrix, fov_degrees=60, resolution=(200, 100)
    ).GetPrim()
    pixels = projected(read_camera(prim, 200, 100), np.array([[4.0, 5, 1], [4, 5, 1.2]]))
    np.testing.assert_allclose(pixels[0], [100, 50], atol=1e-4)
    assert pixels[1][0] == pytest.approx(100, abs=1e-4)
    assert pixels[1][1] < 50


def test_a_field_of_view_for_all_cameras_stays_out_of_the_files() -> None:
    stage = new_stage(unit=0.01)
    for name in "ab":
        camera = UsdGeom.Camera.Define(stage, f"/{name}")
        camera.CreateHorizontalApertureAttr(24.0)
    camera.CreateFocalLengthAttr().Set(30.0, 1.0)
    before = stage.GetRootLayer().ExportToString()
    set_field_of_view(stage, 57.95)
    for prim in list_cameras(stage):
        K = read_camera(prim, 640, 480).K
        assert 2.0 * math.degrees(math.atan(320.0 / K[0, 0])) == pytest.approx(57.95, abs=1e-4)
    assert stage.GetRootLayer().ExportToString() == before
    with pytest.raises(InputError, match="0 degrees cannot form a picture"):
        set_field_of_view(stage, 0.0)
    with pytest.raises(InputError, match="cannot form a picture"):
        set_field_of_view(stage, math.nan)


def test_exposure_follows_the_schema() -> None:
    stage = new_stage()
    camera = UsdGeom.Camera.Define(stage, "/c")
    assert read_camera(camera.GetPrim(), 4, 3).exposure is None
    camera.CreateExposureAttr(-3.0)
    camera.CreateExposureIsoAttr(200.0)
    camera.CreateExposureTimeAttr(0.5)
    camera.CreateExposureFStopAttr(2.0)
    exposure = read_camera(camera.GetPrim(), 4, 3).exposure
    assert exposure == pytest.approx(2.0**-3 * 2.0 * 0.5 / 4.0)


def test_ev100_is_that_of_a_light_meter() -> None:
    # A reflected-light meter with K = 12.5 reads L = K 2^EV / 100; a sensor saturates at
    # 78 / (100 q) 2^EV: mid grey is then 12.5 / 78 x q = 10.4 % of saturation.
    for value in (-3.0, 0.0, 7.5, 15.0):
        metered = 12.5 * 2.0**value / 100.0
        assert metered * exposure_of_ev100(value) == pytest.approx(0.125 / (0.78 / 0.65))


def test_lenses_come_in_metres() -> None:
    stage = new_stage(unit=0.01)
    camera = UsdGeom.Camera.Define(stage, "/c")
    camera.CreateFocalLengthAttr(50.0)  # tenths of a centimetre: 50 mm
    camera.CreateFStopAttr(2.0)
    camera.CreateFocusDistanceAttr(250.0)
    camera.CreateClippingRangeAttr(Gf.Vec2f(10, 5000))
    found = read_camera(camera.GetPrim(), 4, 3)
    assert found.lens_radius == pytest.approx(0.050 / 2.0 / 2.0)
    assert found.focus_distance == pytest.approx(2.5)
    assert found.clipping == pytest.approx((0.1, 50.0))


@pytest.mark.parametrize(
    ("said", "parallel", "clipping"),
    [
        (None, False, (0.0, math.inf)),
        ((1, 1e6), False, (0.0, math.inf)),  # 1 cm to 10 km
        ((1.1, 9e4), False, (0.011, 900.0)),
        ((5, 5), False, (0.0, math.inf)),
        (None, True, (0.0, math.inf)),
        ((-300, 200), True, (-3.0, 2.0)),
    ],
)
def test_planes_that_cut_something_away(
    said: tuple[float, float] | None, parallel: bool, clipping: tuple[float, float]
) -> None:
    stage = new_stage(unit=0.01)
    camera = UsdGeom.Camera.Define(stage, "/c")
    if parallel:
        camera.CreateProjectionAttr("orthographic")
    if said:
        camera.CreateClippingRangeAttr(Gf.Vec2f(*said))
    assert read_camera(camera.GetPrim(), 4, 3).clipping == pytest.approx(clipping)


@pytest.mark.parametrize("axis", ["Y", "Z"])
@pytest.mark.parametrize("unit", [1.0, 0.01])
@pytest.mark.parametrize("size", [(640, 480), (480, 640)])
def test_parallel_pixels_are_those_of_usds_frustum(
    axis: str, unit: float, size: tuple[int, int]
) -> None:
    stage = new_stage(axis, unit)
    camera = foreign_camera(stage, 4 / 3, (3.0, -2.0))
    camera.CreateProjectionAttr("orthographic")
    rng = np.random.default_rng(7)
    points = rng.normal((3, -4, 5), 3.0, (20, 3))
    found = read_camera(camera.GetPrim(), *size)
    assert found.projection == "orthographic"
    assert found.lens_radius == 0.0
    to_world = world_from_stage(stage)
    world = points @ to_world[:3, :3].T + to_world[:3, 3]
    local = (world - found.world_from_camera[:3, 3]) @ found.world_from_camera[:3, :3]
    pixels = local[:, :2] @ found.K[:2, :2].T + found.K[:2, 2]
    np.testing.assert_allclose(pixels, by_frustum(camera.GetPrim(), points, *size), atol=1e-6)
    # The rays through the pixels' centres are those of the same numbers.
    origins, directions = found.rays(*size)
    row, column = 7, 11
    at = origins[row * size[0] + column] + 4.0 * directions[0]
    seen = (at - found.world_from_camera[:3, 3]) @ found.world_from_camera[:3, :3]
    np.testing.assert_allclose(seen[:2] @ found.K[:2, :2].T + found.K[:2, 2], [11.5, 7.5])
    assert seen[2] == pytest.approx(4.0)


def test_cameras_that_make_no_picture_are_refused() -> None:
    stage = new_stage()
    camera = foreign_camera(stage, 4 / 3, (0, 0))
    prim = camera.GetPrim()
    for attribute, value, reason in (
        (camera.GetFocalLengthAttr(), 0.0, "focalLength"),
        (camera.GetFocalLengthAttr(), math.nan, "focalLength"),
        (camera.GetHorizontalApertureAttr(), math.inf, "horizontalAperture"),
    ):
        before = attribute.Get()
        attribute.Set(value)
        with pytest.raises(StageError, match=reason):
            read_camera(prim, 640, 480)
        attribute.Clear() if before is None else attribute.Set(before)
    for scale in ((-1, 1, 1), (0, 1, 1)):
        xform = UsdGeom.Xform(stage.GetPrimAtPath("/World/holder"))
        xform.ClearXformOpOrder()
        xform.AddScaleOp().Set(scale)
        with pytest.raises(StageError, match="mirrored or singular"):
            read_camera(prim, 640, 480)
    with pytest.raises(StageError, match="not a camera"):
        read_camera(stage.GetPrimAtPath("/World/holder"), 640, 480)


def test_all_cameras_are_found_sorted_also_in_instances() -> None:
    stage = new_stage()
    for name in ("b", "a"):
        UsdGeom.Camera.Define(stage, f"/World/{name}")
    assert [str(prim.GetPath()) for prim in list_cameras(stage)] == ["/World/a", "/World/b"]
    stage.CreateClassPrim("/Assets")
    UsdGeom.Xform.Define(stage, "/Assets/rig")
    UsdGeom.Camera.Define(stage, "/Assets/rig/eye")
    rig = UsdGeom.Xform.Define(stage, "/World/Z").GetPrim()
    rig.GetReferences().AddInternalReference("/Assets/rig")
    rig.SetInstanceable(True)
    found = list_cameras(stage)
    assert [str(prim.GetPath()) for prim in found] == ["/World/Z/eye", "/World/a", "/World/b"]
    UsdGeom.Xform(rig).AddTranslateOp().Set((1, 2, 3))
    origin = read_camera(found[0], 4, 3).world_from_camera[:3, 3]
    np.testing.assert_allclose(origin, [1, 2, 3])


# --- framing ---


def cuboid(low: Array, high: Array, *, inward: bool) -> Mesh:
    quads = np.array(
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
    )
    if inward:
        quads = quads[:, ::-1]
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    return Mesh(
        low + corners * (high - low),
        np.full(6, 4, dtype=np.int32),
        quads.astype(np.int32).reshape(-1),
    )


@pytest.mark.parametrize("size", [(640, 480), (300, 600)])
def test_an_object_is_framed_from_outside_as_large_as_it_fits(size: tuple[int, int]) -> None:
    stage = new_stage("Z", 0.01)
    low, high = np.array([100.0, 200, 0]), np.array([180.0, 260, 90])
    define_mesh(stage, "/World/thing", cuboid(low, high, inward=False))
    camera = framing_camera(stage, *size)
    corners = np.array([[x, y, z] for x in (1.0, 1.8) for y in (2.0, 2.6) for z in (0.0, 0.9)])
    pixels = projected(camera, corners) / size
    assert pixels.min() > 0.0
    assert pixels.max() < 1.0
    assert np.abs(2 * pixels - 1).max() == pytest.approx(1 / 1.05, rel=1e-6)
    assert camera.world_from_camera[2, 3] > 0.9  # from above


def test_a_closed_room_is_framed_from_inside() -> None:
    stage = new_stage("Y", 1.0)  # Y up: x to the right, y up to 2.5, z towards the viewer
    room = np.array([[0.0, 0, 0], [5, 2.5, 4]])
    define_mesh(stage, "/World/room", cuboid(*room, inward=True))
    define_mesh(
        stage,
        "/World/table",
        cuboid(np.array([2.0, 0.6, 1.5]), np.array([3.0, 0.7, 2.5]), inward=False),
    )
    camera = framing_camera(stage, 320, 240)
    eye = camera.world_from_camera[:3, 3]
    assert (eye > [0, -4, 0]).all()
    assert (eye < [5, 0, 2.5]).all()
    assert camera.world_from_camera[:3, 1] @ [0, 0, -1] > 0.8  # upright
    pixels = projected(camera, np.array([[2.5, -2.0, 0.7]]))[0]
    assert (pixels > 0).all()
    assert (pixels < [320, 240]).all()


def test_an_empty_stage_is_framed_too() -> None:
    camera = framing_camera(new_stage(), 64, 48)
    assert np.isfinite(camera.world_from_camera).all()
