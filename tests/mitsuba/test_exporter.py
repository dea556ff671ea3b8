"""The XML scene: Mitsuba loads it by itself and sees what the session sees."""

import hashlib
import math
import time
from xml.etree import ElementTree

import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdLux, UsdRender

from openrooms_usd.errors import InputError, OutputError
from openrooms_usd.rendering.scene import gathering
from openrooms_usd.usd.shading.surfaces import NORMAL_BIAS, NORMAL_SCALE, Texture
from orusd_mitsuba import MitsubaExporter
from tests import small
from tests.crowd import crowd
from tests.mitsuba.rendering import radiance, session_of
from tests.pictures import save_picture
from tests.small import square


def room(folder, matte=False):
    """One of everything that is exported.

    Matte surfaces are alike in all renderers; of others XML has Mitsuba's own.
    """
    made = small.Stage()
    random = np.random.default_rng(2)
    paper = save_picture(folder / "paper.png", random.integers(0, 255, (8, 8, 3)).astype(np.uint8))
    sky = save_picture(folder / "sky.exr", random.random((8, 16, 3)).astype(np.float32))
    tilted = np.full((4, 4, 3), 128, dtype=np.uint8)
    tilted[..., 0], tilted[..., 2] = 180, 230
    relief = save_picture(folder / "relief.png", tilted)
    textured = made.material(
        "/M/textured",
        base_color=Texture(paper, color_space="sRGB", uv_rotation=20.0),
        roughness=Texture(paper, channel="g", wrap_s="mirror", wrap_t="mirror", uv_scale=(2, 3)),
        normal=Texture(relief, scale=NORMAL_SCALE, bias=NORMAL_BIAS),
        ior=1.0 if matte else 1.5,
    )
    leaf = made.material("/M/leaf", base_color=(0.2, 0.6, 0.2), opacity=0.6)
    shiny = {} if matte else {"metallic": 1.0, "roughness": 0.3}
    metal = made.material("/M/metal", base_color=(0.9, 0.7, 0.5), **shiny)
    made.quad("/Floor", square((0, 0, 0), 2), material=textured)
    made.box("/a/box", 0.8, material=metal, at=(0.7, 0, 0.4))
    made.box("/A/Box", 0.8, material=leaf, at=(-0.7, 0.3, 0.4))
    bulb = made.box("/bsdf", 0.2, at=(0, 0, 1.5))
    UsdLux.LightAPI(UsdLux.MeshLightAPI.Apply(bulb.GetPrim())).CreateIntensityAttr(20.0)
    made.light("Distant", "/Sun", 1.0, turn=(40.0, 0, 0))
    made.dome("/environment", radiance=2.0).CreateTextureFileAttr(sky)
    made.camera((0.5, -4, 2), (0, 0, 0.4))
    settings = UsdRender.Settings.Define(made.stage, "/Render/Settings")
    settings.CreateResolutionAttr(Gf.Vec2i(640, 480))
    UsdGeom.Scope.Define(made.stage, "/World")
    return made.stage


@pytest.mark.one_in(2)
def test_mitsuba_loads_the_file_and_sees_the_same(shoot, tmp_path, variant):
    # Without LLVM Mitsuba's own surfaces are shown.
    stage = room(tmp_path, matte=variant != "scalar")
    ours = shoot(stage, "radiance", width=64, height=48, samples=64).images["radiance"]
    MitsubaExporter().convert(stage, tmp_path / "out", {})
    import mitsuba as mi

    loaded = mi.load_file(str(tmp_path / "out" / "scene.xml"))
    film = mi.traverse(loaded)
    film["World_Camera.film.size" if "World_Camera.film.size" in film else "Camera.film.size"] = (
        mi.ScalarVector2u(64, 48)
    )
    film.update()
    theirs = np.asarray(mi.render(loaded, spp=64, seed=5))
    assert theirs.shape == ours.pixels.shape
    for color in range(3):
        a, b = ours.pixels[..., color].astype(np.float64), theirs[..., color].astype(np.float64)
        deviation = math.sqrt(2 * ours.error / a.size) * float(np.sqrt((a**2).mean()))
        assert abs(a.mean() - b.mean()) < 4 * deviation
    difference = (
        (ours.pixels - theirs) ** 2 / (ours.pixels**2 + 0.01 * ours.pixels.mean() ** 2)
    ).mean()
    assert difference == pytest.approx(2 * ours.error, rel=0.5)


def test_one_shape_for_each_prim_with_names_that_differ(tmp_path):
    MitsubaExporter().convert(room(tmp_path), tmp_path / "x.xml", {})
    root = ElementTree.parse(tmp_path / "x.xml").getroot()
    identifiers = [element.get("id") for element in root]
    assert len({name.lower() for name in identifiers}) == len(identifiers)
    shapes = sorted(element.get("id") for element in root if element.tag == "shape")
    # What would be spelled alike, but for capital letters, has a number.
    assert [name.rstrip("_0123456789") for name in shapes] == ["A_Box", "Floor", "a_box", "bsdf"]
    files = [
        element.get("value") for element in root.iter("string") if element.get("name") == "filename"
    ]
    assert len(files) >= 8
    assert all((tmp_path / file).is_file() and not file.startswith(("/", "..")) for file in files)


@pytest.mark.slow
def test_equal_stages_give_equal_bytes(tmp_path):
    digests = []
    for name in ("first", "second"):
        MitsubaExporter().convert(room(tmp_path), tmp_path / name, {})
        files = sorted(path for path in (tmp_path / name).rglob("*") if path.is_file())
        time.sleep(1.1)  # whatever writes the time of day writes another one now
        digests.append([hashlib.sha256(file.read_bytes()).hexdigest() for file in files])
    assert digests[0] == digests[1]


def test_options_and_places_that_cannot_be_used_are_refused(tmp_path):
    made = small.Stage()
    with pytest.raises(InputError, match="colour"):
        MitsubaExporter().convert(made.stage, tmp_path, {"colour": 1})
    (tmp_path / "file").write_text("")
    made.box("/Box", 1.0)
    with pytest.raises(OutputError):
        MitsubaExporter().convert(made.stage, tmp_path / "file", {})


def test_a_stage_far_away_is_moved_near_and_says_so(tmp_path):
    made = small.Stage()
    made.box("/Box", 1.0, at=(5e6, 0, 0))
    report = MitsubaExporter().convert(made.stage, tmp_path, {})
    assert any(path == "/" and "moved" in reason for path, _, reason in report.losses())


def test_instances_share_a_file_and_stand_where_they_do(tmp_path, monkeypatch):
    pixels = np.random.default_rng(5).integers(40, 220, (8, 8, 3)).astype(np.uint8)
    stage = crowd(save_picture(tmp_path / "paper.png", pixels)).stage
    monkeypatch.setattr(gathering, "LEAST_SAVED_TRIANGLES", 1)
    monkeypatch.setattr(gathering, "_LEAST_SAVED_BY_ONE", 1)
    MitsubaExporter().convert(stage, tmp_path / "out", {})
    root = ElementTree.parse(tmp_path / "out" / "scene.xml").getroot()
    kinds = [element.get("type") for element in root if element.tag == "shape"]
    assert [kinds.count(kind) for kind in ("ply", "shapegroup", "instance")] == [1, 6, 24]
    assert len(list((tmp_path / "out" / "scene.meshes").iterdir())) == 7
    ours = radiance(session_of(stage, variant="scalar"), width=32, height=24, samples=32)
    import mitsuba as mi

    loaded = mi.load_file(str(tmp_path / "out" / "scene.xml"))
    film = mi.traverse(loaded)
    film["Camera.film.size"] = mi.ScalarVector2u(32, 24)
    film.update()
    theirs = np.asarray(mi.render(loaded, spp=32, seed=5))
    assert theirs.mean() == pytest.approx(float(ours.mean()), rel=5e-3)
    # Each pixel by itself: nothing stands elsewhere.
    assert np.median(np.abs(theirs - ours)) < 0.03
    assert np.isclose(theirs, ours, atol=0.25).mean() > 0.98
