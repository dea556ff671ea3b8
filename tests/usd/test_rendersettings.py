"""What render settings ask of pictures, against USD's own words for each."""

from pathlib import Path

import pytest
from pxr import Gf, Usd, UsdGeom, UsdRender

from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering.context import RenderContext as OpenedStage
from openrooms_usd.rendering.opening import open_for_rendering
from openrooms_usd.usd.cameras import read_camera, set_field_of_view
from openrooms_usd.usd.moments import freeze_time
from openrooms_usd.usd.rendersettings import (
    asked_cameras,
    asked_purposes,
    asked_resolution,
    settings_losses,
)
from orusd_preview import PreviewRenderer
from tests.opening import open_with


def new_stage() -> tuple[Usd.Stage, UsdRender.Settings]:
    """Two cameras, and settings that ask for nothing; apertures are 3 to 2."""
    stage = Usd.Stage.CreateInMemory()
    for name in ("a", "b"):
        camera = UsdGeom.Camera.Define(stage, f"/{name}")
        camera.CreateHorizontalApertureAttr(30.0)
        camera.CreateVerticalApertureAttr(20.0)
        camera.CreateFocalLengthAttr(60.0)
    settings = UsdRender.Settings.Define(stage, "/Render/All")
    stage.SetMetadata("renderSettingsPrimPath", "/Render/All")
    return stage, settings


def product(stage: Usd.Stage, settings: UsdRender.Settings, camera: str) -> UsdRender.Product:
    made = UsdRender.Product.Define(stage, f"/Render{camera}")
    made.CreateCameraRel().SetTargets([camera])
    settings.CreateProductsRel().AddTarget(made.GetPath())
    return made


@pytest.mark.parametrize(
    ("policy", "size", "seen"),
    [
        # What of the scene the window is wide and high, in units of aperture.
        ("adjustApertureHeight", (400, 200), (30, 15)),
        ("adjustApertureWidth", (400, 200), (40, 20)),
        ("expandAperture", (400, 200), (40, 20)),  # wider than the aperture: more at the sides
        ("expandAperture", (200, 200), (30, 30)),  # narrower: more above and below
        ("cropAperture", (400, 200), (30, 15)),
        ("cropAperture", (200, 200), (20, 20)),
        (None, (400, 200), (40, 20)),  # USD's default expands
    ],
)
def test_windows_conform(
    policy: str | None, size: tuple[int, int], seen: tuple[float, float]
) -> None:
    stage, settings = new_stage()
    if policy:
        settings.CreateAspectRatioConformPolicyAttr(policy)
    K = read_camera(stage.GetPrimAtPath("/a"), *size).K
    assert (size[0] / K[0, 0] * 60, size[1] / K[1, 1] * 60) == pytest.approx(seen)


def test_a_product_is_stronger_than_its_settings() -> None:
    stage, settings = new_stage()
    settings.CreateAspectRatioConformPolicyAttr("adjustApertureHeight")
    settings.CreateResolutionAttr(Gf.Vec2i(100, 50))
    one = product(stage, settings, "/b")
    one.CreateAspectRatioConformPolicyAttr("adjustApertureWidth")
    assert asked_resolution(stage) == (100, 50)
    one.CreateResolutionAttr(Gf.Vec2i(400, 200))
    assert asked_resolution(stage) == (400, 200)
    assert asked_cameras(stage) == ("/b",)
    widths = [
        400 / read_camera(stage.GetPrimAtPath(path), 400, 200).K[0, 0] * 60 for path in ("/a", "/b")
    ]
    assert widths == pytest.approx([30, 40])


def test_a_field_of_view_that_is_asked_for_is_the_horizontal_one() -> None:
    stage, _ = new_stage()
    set_field_of_view(stage, 90.0)
    assert read_camera(stage.GetPrimAtPath("/a"), 400, 200).K[0, 0] == pytest.approx(200.0)


def test_without_products_all_cameras_are_asked_for() -> None:
    stage, settings = new_stage()
    settings.CreateCameraRel().SetTargets(["/b"])
    assert asked_cameras(stage) == ()


def test_a_product_without_a_camera_has_that_of_its_settings() -> None:
    stage, settings = new_stage()
    settings.CreateCameraRel().SetTargets(["/a"])
    product(stage, settings, "/b").GetCameraRel().ClearTargets(True)
    assert asked_cameras(stage) == ("/a",)


def opened(stage: Usd.Stage) -> OpenedStage:
    return open_with(PreviewRenderer(), stage)


def test_purposes_that_are_drawn() -> None:
    stage, settings = new_stage()
    for purpose in ("default", "render", "proxy", "guide"):
        shape = UsdGeom.Cube.Define(stage, f"/{purpose}")
        shape.CreatePurposeAttr(purpose)
    assert set(opened(stage).legend.instance.values()) == {"/default", "/render"}
    settings.CreateIncludedPurposesAttr(["default", "proxy"])
    assert asked_purposes(stage) == ("default", "proxy")
    found = opened(stage)
    assert set(found.legend.instance.values()) == {"/default", "/proxy"}
    assert ("/render", "skipped", "its purpose is render") in found.report.rows


def test_lenses_and_shutters_that_are_switched_off() -> None:
    stage, settings = new_stage()
    camera = UsdGeom.Camera(stage.GetPrimAtPath("/a"))
    camera.CreateFStopAttr(2.0)
    camera.CreateShutterCloseAttr(0.5)
    turn = camera.AddRotateYOp()
    turn.Set(0.0, 0.0)
    turn.Set(90.0, 10.0)
    assert read_camera(camera.GetPrim(), 4, 3).lens_radius > 0.0
    assert list(freeze_time(stage, 3.0)) == ["/a"]
    stage.GetSessionLayer().Clear()
    settings.CreateDisableDepthOfFieldAttr(True)
    settings.CreateDisableMotionBlurAttr(True)
    assert read_camera(camera.GetPrim(), 4, 3).lens_radius == 0.0
    assert freeze_time(stage, 3.0) == {}


def test_what_pictures_do_not_have_is_told() -> None:
    stage, settings = new_stage()
    settings.CreateResolutionAttr(Gf.Vec2i(100, 50))
    settings.CreateMaterialBindingPurposesAttr(["preview"])
    first, second = (product(stage, settings, path) for path in ("/a", "/b"))
    second.CreateResolutionAttr(Gf.Vec2i(100, 51))
    first.CreateResolutionAttr(Gf.Vec2i(100, 50))
    first.CreateDataWindowNDCAttr(Gf.Vec4f(0, 0, 0.5, 1))
    second.CreatePixelAspectRatioAttr(2.0)
    for name, source in (("z", "Z"), ("direct", "direct"), ("odd", "cryptomatte")):
        var = UsdRender.Var.Define(stage, f"/Render/{name}")
        var.CreateSourceNameAttr(source)
        first.CreateOrderedVarsRel().AddTarget(var.GetPath())
    told = dict(settings_losses(stage))
    assert told == {
        "/Render/All": "materials bound for 'preview' are replaced by full ones",
        "/Render/a": "dataWindowNDC is left out: the whole picture is rendered",
        "/Render/b": "all views have 100x50 pixels",
        "/Render/direct": "it must be requested: --channels usual,direct",
        "/Render/odd": "no channel has the name 'cryptomatte'",
    }
    assert ("/Render/b", "pixels are square") in list(settings_losses(stage))
    assert ("/Render/odd", "approximated", "no channel has the name 'cryptomatte'") in opened(
        stage
    ).report.rows


def test_renders_are_of_the_products_cameras(tmp_path: Path) -> None:
    stage, settings = new_stage()
    product(stage, settings, "/b")
    stage.GetRootLayer().Export(str(tmp_path / "scene.usda"))
    asked = RenderSettings(renderer="preview", channels=["depth"], resolution=(8, 6))
    scene = tmp_path / "scene.usda"
    assert dict(open_for_rendering(scene, asked).views) == {"b": "/b"}
    assert dict(open_for_rendering(scene, asked, cameras=["a"]).views) == {"a": "/a"}
