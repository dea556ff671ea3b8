"""Light records against what the stage says, and masks of what pixels see."""

from typing import Any

import numpy as np
import pytest
from pxr import UsdGeom

from openrooms_usd.rendering.manifest import view_lights
from openrooms_usd.rendering.scene.lights import LightRecord
from openrooms_usd.usd.light.lights import Portal, define_mesh_light
from openrooms_usd.usd.semantics import label
from tests import small
from tests.pictures import save_picture
from tests.small import square

SIZE = (64, 48)


def lamp_object(
    made: Any, path: str, turn: float, *, nits: float, kelvin: float | None = None
) -> None:
    """An object of a shade and a bulb: a box of 0.2 by 0.1 by 0.3 m that is turned and moved."""
    root = UsdGeom.Xform.Define(made.stage, path)
    label(root.GetPrim(), "ceiling_lamp")
    root.AddTranslateOp().Set((1.0, 2.0, 0.5))
    root.AddRotateZOp().Set(turn)
    bulb = made.box(f"{path}/Bulb", 1.0)
    UsdGeom.Xformable(bulb).AddScaleOp().Set((0.2, 0.1, 0.3))
    define_mesh_light(bulb.GetPrim(), nits=nits, kelvin=kelvin)
    made.quad(f"{path}/Shade", square((0, 0, 0.3), 0.3))


def portal() -> Portal:
    """1.2 by 0.8 m around (0, 3, 0), outwards along y."""
    return small.window((-0.6, -0.4, 0.6, 0.4), 3.0, "/World/Lights/window")


def scene() -> Any:
    made = small.Stage()
    lamp_object(made, "/World/Lamp", 30.0, nits=50.0, kelvin=3000.0)
    lamp_object(made, "/World/Other/Lamp", 0.0, nits=0.0)
    outer, inner = square((0, 3, 0), (2, 3), "-Y"), square((0, 3, 0), (0.4, 0.6), "-Y")
    ring = [[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)]
    made.mesh("/World/Wall", [*outer, *inner], ring)
    made.dome(radiance=10.0, portals=(portal(),))
    made.camera((0.0, -2.0, 0.0), (0.0, 3.0, 0.0), fov=60)
    return made


def records(lit: Any, made: Any) -> tuple[Any, tuple[LightRecord, ...]]:
    from openrooms_usd.rendering.scene.light_records import light_records

    stage = lit(made.stage)
    return stage, light_records(made.stage, stage.scene, stage.sources)


def test_a_lamp_is_described_as_it_was_authored(lit: Any) -> None:
    _, (lamp, off, *_) = records(lit, scene())
    assert (lamp.number, lamp.name, lamp.path, lamp.kind, lamp.on) == (
        0,
        "Lamp",
        "/World/Lamp",
        "lamp",
        True,
    )
    area = 2.0 * (0.2 * 0.1 + 0.2 * 0.3 + 0.1 * 0.3)
    assert lamp.lumen == pytest.approx(np.pi * area * 50.0, rel=1e-5)
    assert lamp.radiance @ [0.2126, 0.7152, 0.0722] == pytest.approx(50.0, rel=1e-5)
    assert lamp.kelvin == 3000.0 and lamp.radiance[0] > lamp.radiance[2]
    np.testing.assert_allclose(lamp.size, [0.2, 0.1, 0.3], atol=1e-6)
    turned = [[np.cos(np.pi / 6), -0.5, 0], [0.5, np.cos(np.pi / 6), 0], [0, 0, 1]]
    np.testing.assert_allclose(lamp.world_from_box[:3, :3], turned, atol=1e-6)
    np.testing.assert_allclose(lamp.world_from_box[:3, 3], [1.0, 2.0, 0.5], atol=1e-6)
    # A lamp that is off keeps its number, and its name is its own.
    assert (off.number, off.name, off.on, off.lumen) == (1, "Lamp_2", False, 0.0)


def test_an_opening_lets_the_surroundings_in(lit: Any) -> None:
    _, (*_, window, rest) = records(lit, scene())
    assert (window.kind, window.name, window.on) == ("opening", "window", True)
    np.testing.assert_allclose(window.radiance, 10.0, rtol=2e-3)
    assert window.lumen == pytest.approx(np.pi * 10.0 * 1.2 * 0.8, rel=2e-3)
    np.testing.assert_allclose(window.size, [1.2, 0.8, 0.0])
    np.testing.assert_allclose(window.world_from_box, portal().world_from_portal, atol=1e-6)
    assert rest.kind == "elsewhere" and rest.number == 3
    assert window.fit_error is not None and window.fit_error < 1e-3


def test_names_are_unique_whatever_the_objects_are_called() -> None:
    from openrooms_usd.rendering.scene.light_records import _unique

    names = _unique(["a", "a_2", "a", "a", "b"])
    assert names[:2] == ["a", "a_2"] and len(set(names)) == 5


def test_a_textured_lamp_is_the_mean_of_its_picture(lit: Any, tmp_path: Any) -> None:
    made = small.Stage()
    pixels = np.zeros((2, 4, 3), dtype=np.float32)
    pixels[:, :2] = 4.0
    light = made.light("Rect", "/Light", 1.0)
    light.CreateTextureFileAttr(save_picture(tmp_path / "light.exr", pixels))
    light.CreateIntensityAttr(5.0)
    _, (lamp, _) = records(lit, made)
    np.testing.assert_allclose(lamp.radiance, 10.0, rtol=0.02)


def test_masks_are_where_pixels_see_the_light(lit: Any) -> None:
    from openrooms_usd.rendering.exact import light_masks
    from openrooms_usd.rendering.scene.first_hits import first_hits
    from orusd_mitsuba.tracer import MitsubaTracer

    made = scene()
    stage, found = records(lit, made)
    camera = stage.camera(*SIZE)
    hits = first_hits(stage.scene, MitsubaTracer(stage.scene, stage.built), camera, *SIZE)
    masks = light_masks(stage.scene, stage.sources, camera, hits)
    assert masks.shape == (4, SIZE[1], SIZE[0], 1)
    sky = np.ones(SIZE[0] * SIZE[1], dtype=bool)
    sky[hits.pixels] = False
    np.testing.assert_array_equal(masks[2:].sum(axis=0).ravel() == 1.0, sky)
    # What is past the wall is elsewhere; the hole is the window, but for the lamps before it.
    height, width = SIZE[1], SIZE[0]
    focal = width / 2.0 / np.tan(np.radians(30.0))
    u, v = np.meshgrid(np.arange(width) + 0.5 - width / 2, np.arange(height) + 0.5 - height / 2)
    inside = (np.abs(u * 5.0 / focal) < 0.6) & (np.abs(v * 5.0 / focal) < 0.4)
    free = masks[:2].sum(axis=0)[..., 0] == 0.0
    np.testing.assert_array_equal(masks[2][..., 0] == 1.0, inside & free)
    entries = view_lights(found, camera.K, camera.world_from_camera, SIZE, dict(enumerate(masks)))
    left, top, right, bottom = entries[2]["box2d_projected"]
    assert right - left == pytest.approx(1.2 * focal / 5.0, abs=1e-3)
    assert bottom - top == pytest.approx(0.8 * focal / 5.0, abs=1e-3)
    assert entries[0]["box2d"] and entries[0]["box2d"][0] >= entries[0]["box2d_projected"][0] - 20


def camera_entry(world_from_box: Any, size: tuple[float, float, float]) -> dict[str, Any]:
    """The entry of one box for a camera at the origin of 100 by 100 pixels, focal length 50."""
    record = LightRecord(
        0, "a", "/a", "lamp", True, world_from_box, np.array(size), np.ones(3), 1.0
    )
    K = np.array([[50.0, 0, 50], [0, 50.0, 50], [0, 0, 1]])
    return view_lights([record], K, np.eye(4), (100, 100), {})[0]


def test_a_box_in_a_camera_is_cut_at_its_plane_and_its_edges() -> None:
    ahead = np.eye(4)
    ahead[2, 3] = 2.0
    entry = camera_entry(ahead, (1.0, 0.5, 2.0))
    assert entry["box2d_projected"] == [25.0, 37.5, 75.0, 62.5]
    np.testing.assert_allclose(entry["opengl_from_box"][2], [0, 0, -1, -2])
    assert "box2d" not in entry
    behind = np.eye(4)
    behind[2, 3] = -2.0
    assert camera_entry(behind, (1.0, 0.5, 2.0))["box2d_projected"] == []
    aside = ahead.copy()
    aside[0, 3] = 9.0
    assert camera_entry(aside, (1.0, 0.5, 2.0))["box2d_projected"] == []
    # The camera stands in the box: it fills the picture.
    assert camera_entry(np.eye(4), (1.0, 1.0, 1.0))["box2d_projected"] == [0.0, 0.0, 100.0, 100.0]
