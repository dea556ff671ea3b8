"""Blender itself: what of a room arrives there, and how it comes back.

Runs where `.ci/install-blender` has been, or where ORUSD_BLENDER_PYTHON names a Python with bpy.
"""

from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from pxr import Usd, UsdGeom, UsdLux

from openrooms_usd import names
from openrooms_usd.colorimetry import luminance
from openrooms_usd.composing import compose_room
from openrooms_usd.demo import write_starter
from openrooms_usd.edits.adopting import adopt
from openrooms_usd.library.pictures import write_exr
from openrooms_usd.rendering import RenderRequest
from openrooms_usd.rules import validate_stage
from openrooms_usd.usd.cameras import FLIP, read_camera
from openrooms_usd.usd.light.lights import MeshLight, define_dome, read_lights
from orusd_usdz import UsdzExporter
from tests.blender.conftest import Blender
from tests.opening import open_with

pytestmark = pytest.mark.slow


def test_a_room_arrives_lit_and_seen_as_it_is(blender: Blender, example: Path) -> None:
    scene = example / "scene.usda"
    found = blender("seen", scene)
    stage = Usd.Stage.Open(str(scene))
    prims = Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies())
    shapes = [UsdGeom.Imageable(prim) for prim in prims if prim.IsA(UsdGeom.Gprim)]
    drawn = [shape for shape in shapes if shape.ComputePurpose() == UsdGeom.Tokens.default_]
    # Instances are collections: their meshes count once.
    assert 0.5 * len(drawn) < found["kinds"]["MESH"] <= len(drawn)
    lamps = [x.radiance for x in read_lights(stage) if isinstance(x, MeshLight)]
    glow = sorted(found["glow"].values())
    assert len(glow) == len(lamps) == 3
    np.testing.assert_allclose(glow, sorted(x.tolist() for x in lamps), rtol=1e-5)
    # Blender passes over the exposure that cameras carry: docs/howto/blender.md says how to set it.
    assert found["exposure"] == 0.0
    for name, camera in found["cameras"].items():
        ours = read_camera(stage.GetPrimAtPath(f"{names.CAMERAS}/{name}"), 640, 480)
        np.testing.assert_allclose(
            np.array(camera["matrix"]), ours.world_from_camera @ FLIP, atol=1e-5
        )
        assert camera["fov"] == pytest.approx(
            np.degrees(2 * np.arctan(320 / ours.K[0, 0])), rel=1e-5
        )


def test_an_exchange_brings_no_stray_lamps(blender: Blender, example: Path, tmp_path: Path) -> None:
    stage = Usd.Stage.Open(str(example / "scene.usda"))
    portals = sum(prim.IsA(UsdLux.PortalLight) for prim in stage.Traverse())
    lamps = {}
    for profile in ("default", "exchange"):
        UsdzExporter().convert(stage, tmp_path / f"{profile}.usdz", {"profile": profile})
        lamps[profile] = blender("seen", tmp_path / f"{profile}.usdz")["kinds"].get("LIGHT", 0)
    assert lamps == {"default": portals, "exchange": 0} and portals > 0


def test_cycles_shows_the_light_that_we_show(
    blender: Blender, example: Path, tmp_path: Path
) -> None:
    """Two renderers, one room: walls and furniture are as bright, and the exposure suits both."""
    mitsuba = pytest.importorskip("orusd_mitsuba")
    scene, size, samples = example / "scene.usda", (96, 72), 64
    exr = tmp_path / "cycles.exr"
    blender("picture", scene, camera="overview", samples=samples, size=size, picture=str(exr))
    theirs = OpenImageIO.ImageBuf(str(exr)).get_pixels(OpenImageIO.FLOAT)[..., :3]
    path, (width, height) = f"{names.CAMERAS}/overview", size
    stage = Usd.Stage.Open(str(scene))
    request = RenderRequest(path, ("radiance",), width=width, height=height, samples=samples)
    view = open_with(mitsuba.MitsubaRenderer(), stage, {}).render(request)
    ours = view.images["radiance"].pixels
    # What emits is seen as it is; what is lit by it is what two renderers may see differently.
    lit = np.maximum(luminance(ours), luminance(theirs)) < 3000.0
    assert lit.mean() > 0.8
    assert theirs[lit].mean() == pytest.approx(ours[lit].mean(), rel=0.1)
    exposure = 2.0 ** stage.GetPrimAtPath(path).GetAttribute("exposure").Get()
    assert 0.05 < float(np.median(luminance(theirs)[lit])) * exposure < 0.6


WIDTH, HEIGHT = 64, 32


@pytest.mark.parametrize("degrees", [0.0, 40.0, -90.0])
def test_the_sky_stands_upright_to_the_pixel(
    blender: Blender, tmp_path: Path, degrees: float
) -> None:
    """A picture whose pixels say where they lie in it, against the closed form of UsdLux."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    place = np.stack([(u + 0.5) / WIDTH, (v + 0.5) / HEIGHT, np.ones_like(u)], axis=-1)
    write_exr(tmp_path / "sky.exr", place.astype(np.float32))
    stage = Usd.Stage.CreateNew(str(tmp_path / "sky.usda"))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    define_dome(stage, "/World/Sky", texture="./sky.exr", rotation=degrees)
    stage.Save()
    exr = tmp_path / "panorama.exr"
    blender("panorama", tmp_path / "sky.usda", picture=str(exr), size=[WIDTH, HEIGHT])
    shown = OpenImageIO.ImageBuf(str(exr)).get_pixels(OpenImageIO.FLOAT)[..., :2]

    # Blender's panorama: its middle looks along +Y, and to the right lies +X.
    right, up = (place[..., 0] - 0.5) * 2 * np.pi, (0.5 - place[..., 1]) * np.pi
    # Ours: the middle of the picture looks along -Y, a quarter from the left along +X; turned
    # counter-clockwise from above.
    azimuth = np.arctan2(np.cos(right), np.sin(right)) - np.radians(degrees)
    expected_u = (0.25 - azimuth / (2 * np.pi)) % 1.0
    off_u = (shown[..., 0] - expected_u + 0.5) % 1.0 - 0.5
    # Beside the picture's seam two pixels that lie a whole width apart are mixed.
    away = np.minimum(expected_u, 1.0 - expected_u) > 1.0 / WIDTH
    assert away.mean() > 0.9
    assert np.abs(off_u[away]).max() * WIDTH < 0.01
    rows = slice(1, -1)
    assert np.abs(shown[rows, :, 1] - (0.5 - up / np.pi)[rows]).max() * HEIGHT < 0.01


@pytest.fixture(scope="session")
def exports(blender: Blender, example: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("exports")
    for job in ("export", "rearranged"):
        (folder / job).mkdir()
        blender(job, example / "scene.usda", folder=str(folder / job))
    return folder


@pytest.mark.parametrize("form", ["root", "bare", "merged", "instanced", "unnamed", "matrices"])
def test_a_room_that_was_only_looked_at_comes_back_unchanged(
    example: Path, exports: Path, form: str
) -> None:
    adoption = adopt(example / "scene.usda", exports / f"export/{form}.usda", dry_run=True)
    assert (adoption.changes, adoption.left) == ((), ())
    assert adoption.compared > 100


@pytest.mark.parametrize("form", ["root", "bare", "merged", "unnamed"])
def test_what_was_done_in_blender_comes_back(exports: Path, tmp_path: Path, form: str) -> None:
    described = write_starter(tmp_path)[0]
    out = tmp_path / "out"
    compose_room(described, out, workers=2)
    adoption = adopt(out / "scene.usda", exports / f"rearranged/{form}.usda")
    changed = {x.path: x.fields for x in adoption.changes if not x.new}
    furniture = names.FURNITURE
    assert changed == {
        f"{furniture}/sofa_0": ("xformOp:translate",),
        f"{furniture}/table_lamp_0": ("xformOp:translate",),
        f"{furniture}/chair_1": ("active",),
        f"{furniture}/floor_lamp_0/Geometry/light_bulb": ("inputs:intensity",),
        f"{names.CAMERAS}/overview": ("focalLength",),
    }
    new = {x.path for x in adoption.changes if x.new}
    assert {f"{furniture}/dining_table_001", f"{names.WORLD}/Crate"} <= new
    assert adoption.left == ()
    compose_room(described, out, workers=2)
    assert [x for x in validate_stage(out / "scene.usda") if x.severity == "error"] == []
    stage = Usd.Stage.Open(str(out / "scene.usda"))
    stage.Reload()
    sofa = UsdGeom.Xformable(stage.GetPrimAtPath(f"{furniture}/sofa_0")).GetLocalTransformation()
    np.testing.assert_allclose(sofa.ExtractTranslation(), [2.7, 3.48, 0.0], atol=1e-5)
