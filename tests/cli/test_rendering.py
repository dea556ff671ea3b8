"""The commands ``render`` and ``channels``, in a process of their own where that matters."""

import json
import re
import shlex
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.channels import CHANNELS, WRITTEN, markdown_page
from openrooms_usd.cli import orusd
from openrooms_usd.cli.composing import _outcome
from openrooms_usd.cli.rendering import _losses, _warnings
from openrooms_usd.composing import ComposeSummary, StepSummary
from openrooms_usd.rendering import exr
from tests.commands import output_of, run

ROOT = Path(__file__).parents[2]

MAIN = "from openrooms_usd.cli import main; main()"

BALL = """#usda 1.0
(
    defaultPrim = "World"
    upAxis = "Z"
    metersPerUnit = 1
)
def Xform "World"
{
    def Sphere "Ball"
    {
        double radius = 0.5
        double3 xformOp:translate = (0, 3, 0.5)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        color3f[] primvars:displayColor = [(0.8, 0.1, 0.1)]
    }
    def Mesh "Floor"
    {
        point3f[] points = [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)]
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        uniform token subdivisionScheme = "none"
    }
    def RectLight "Lamp"
    {
        float inputs:intensity = 500
        float inputs:width = 2
        float inputs:height = 2
        double3 xformOp:translate = (0, 3, 3)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Scope "Cameras"
    {
        def Camera "above"
        {
            double3 xformOp:translate = (0, 3, 2.5)
            uniform token[] xformOpOrder = ["xformOp:translate"]
        }
        def Camera "front"
        {
            float focalLength = 20
            float horizontalAperture = 20
            float verticalAperture = 15
            double3 xformOp:translate = (0, 0, 1)
            float xformOp:rotateX = 80
            uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateX"]
        }
    }
}
"""


@pytest.fixture
def ball(tmp_path: Path) -> Path:
    path = tmp_path / "ball.usda"
    path.write_text(BALL)
    return path


def test_the_table_for_people_and_programs():
    said = json.loads(output_of("channels", "--json"))
    assert [row["name"] for row in said] == list(CHANNELS)
    assert all(row["meaning"] and row["unit"] for row in said)
    table = output_of("channels")
    assert all(name in table for name in CHANNELS)


def test_the_page_is_fresh():
    assert (ROOT / "docs/reference/channels.md").read_text("utf-8") == markdown_page()
    assert output_of("channels", "--markdown") == markdown_page()


@pytest.mark.parametrize("size", ["640", "640x", "x480", "-3x4", "3.5x2", "axb", "640x480x3"])
def test_sizes_that_are_none(size, ball, tmp_path):
    words = ["render", str(ball), "-o", str(tmp_path / "out"), "--resolution", size]
    result = run(*words)
    assert result.exit_code == 2
    assert "640x480" in result.output


def test_the_reflectance_model_can_be_forced(ball, tmp_path):
    """What has no material is a UsdPreviewSurface, unless told otherwise; a scalar backend too."""
    options = ["--variant", "scalar", "--resolution", "8x6", "--spp", "1", "--camera", "front"]
    losses = {}
    for bsdf in ("auto", "openrooms"):
        out = tmp_path / bsdf
        said = output_of("render", ball, "-o", out, *options, "--bsdf", bsdf, "--json")
        manifest = json.loads(said)["manifest"]
        used = {"auto": "preview", "openrooms": "openrooms"}[bsdf]
        assert manifest["renderer"]["bsdf"] == used
        losses[bsdf] = str(manifest["report"])
    assert "F0 0.04" in losses["openrooms"] and "F0" not in losses["auto"]


def test_a_ball_on_the_floor(ball, tmp_path):
    out = tmp_path / "out"
    options = ["--variant", "scalar", "--resolution", "32x24", "--spp", "4", "--json"]
    options += ["--camera", "front"]
    said = json.loads(output_of("render", ball, "-o", out, *options))
    assert said["manifest"] == json.loads((out / "manifest.json").read_text())
    assert said["manifest"]["views"].keys() == {"front"}
    images = exr.read_channels(out / "front" / "channels.exr")
    assert images.keys() == set(WRITTEN)
    middle = images["instance"][12, 16, 0]
    assert said["manifest"]["legend"]["instance"][str(int(middle))] == "/World/Ball"
    assert np.isfinite(images["radiance"]).all()
    assert images["radiance"].mean() > 0
    # The sphere's front is 2.5 m away along the floor; the camera looks 10 degrees down.
    assert 2.2 < images["distance"][12, 16, 0] < 2.8


def report_of(out: Path) -> dict:
    return json.loads((out / "manifest.json").read_text())["report"]


def test_an_error_that_is_not_reached_is_said(ball, tmp_path, monkeypatch):
    from orusd_mitsuba.transport import sampling

    monkeypatch.setattr(sampling, "_MOST_SAMPLES", 16)
    options = ["--variant", "scalar", "--resolution", "16x12", "--camera", "front"]
    for error, warned in (("1e-9", True), ("1e3", False)):
        said = output_of("render", ball, "-o", tmp_path / error, *options, "--target-error", error)
        found = re.search(r"warning: front: estimated error \S+ after 16 samples, not 1e-09", said)
        assert bool(found) == warned
        reasons = [row["reason"] for row in report_of(tmp_path / error)["losses"]]
        assert any("after 16 samples a pixel" in reason for reason in reasons) == warned


@pytest.mark.parametrize(
    ("as_what", "lost"), [('purpose = "guide"', 0), ('visibility = "invisible"', 1)]
)
def test_what_is_never_seen_is_reported_and_alarms_nobody(tmp_path, as_what, lost):
    stage = tmp_path / "scene.usda"
    stage.write_text(BALL + f'def Cube "Shape"\n{{\n    token {as_what}\n}}\n')
    how = ("--renderer", "preview", "--resolution", "8x6", "--camera", "front")
    said = output_of("render", stage, "-o", tmp_path / "out", *how)
    assert f"prims approximated, {lost} skipped" in said
    report = report_of(tmp_path / "out")
    assert report["skipped"] == 1
    skipped = [row for row in report["losses"] if row["outcome"] == "skipped"]
    assert (_losses({"losses": skipped}) != "") == lost


def test_pixels_that_are_no_numbers_are_said():
    row = {"estimated_error": None, "samples": 1, "nonfinite_pixels": 2}
    told = list(_warnings({"channels": {"radiance": row}}, None))
    assert told == ["2 pixels of radiance were no finite numbers"]


def test_what_is_surely_off_is_said():
    def channel(total, error):
        bias = {"total": total, "total_error": error}
        return {"estimated_error": None, "samples": 1, "nonfinite_pixels": 0, "bias": bias}

    rows = {
        "radiance": channel(0.1, 0.02),
        "irradiance": channel(-0.21, 0.04),
        "direct": {**channel(0.0, 0.0), "bias": None},
        "indirect": channel(0.3, 0.01),
    }
    (told,) = _warnings({"channels": rows}, None)
    assert told == (
        "irradiance is off by -21.0 %, and others too (1); --method reference has no bias"
    )


@pytest.fixture
def asked(monkeypatch):
    """What the demo asks of the renderer, which does nothing here."""
    compose = import_module("openrooms_usd.composing")
    render = import_module("openrooms_usd.rendering")
    words = {}

    def compose_room(description, out, **how):
        (out / "scene.usda").write_text("#usda 1.0\n")
        return compose.ComposeSummary(out / "scene.usda", ())

    def render_stage(stage, out, settings, **how):
        words.update(settings.model_dump())
        report = {"losses": [], "approximated": 0, "skipped": 0}
        said = {"views": {}, "report": report, "renderer": {"backend": "none"}, "stop": {}}
        return render.RenderSummary(out, said, {})

    monkeypatch.setattr(compose, "compose_room", compose_room)
    monkeypatch.setattr(render, "render_stage", render_stage)
    return words


def test_the_demo_for_programs(tmp_path, asked):
    result = run("demo", "-o", tmp_path, "--json")
    assert json.loads(result.stdout) == {
        "description": str(tmp_path / "source" / "room.yaml"),
        "scene": str(tmp_path / "scene.usda"),
        "render": str(tmp_path / "render"),
    }
    assert "rendered with none" in result.stderr


@pytest.mark.parametrize("usable", [True, False])
def test_the_demo_denoises_where_it_can(tmp_path, asked, monkeypatch, usable):
    denoise = import_module("openrooms_usd.rendering.denoise")
    monkeypatch.setattr(denoise, "is_usable", lambda: usable)
    said = output_of("demo", "-o", tmp_path)
    assert asked["denoise"] is usable
    assert ("denoised.png" in said) is usable
    assert ("openrooms-usd[denoise]" in said) is not usable


def test_what_the_demo_says_to_do_next_can_be_done(tmp_path, asked):
    lines = [line.partition("orusd ") for line in output_of("demo", "-o", tmp_path).splitlines()]
    commands = [shlex.split(rest) for _, found, rest in lines if found]
    assert len(commands) == 5
    for name, *words in commands:
        command = orusd.get_command(None, name)
        command.make_context(name, words)


def test_init_for_programs(tmp_path):
    said = json.loads(output_of("init", tmp_path, "--json"))
    assert said.keys() == {"description", "schema"}
    assert all(Path(path).is_file() for path in said.values())


def test_what_compose_says_it_did(tmp_path):
    def done(state, *files):
        stages = (StepSummary("layout", state, 0.0),)
        return _outcome(ComposeSummary(tmp_path, stages, files))

    assert done("written") == "composed"
    assert done("unchanged") == "nothing to do, everything is up to date"
    assert done("unchanged", tmp_path / "scene.usdc") == "the layers are up to date"


def test_spare_cameras_are_drawn_only_where_they_are_named(tmp_path: Path) -> None:
    scene = tmp_path / "scene.usda"
    spares = "".join(f'        def Camera "spare_{number}" {{}}\n' for number in range(5))
    scene.write_text(
        BALL.replace('        def Camera "above"', f'{spares}        def Camera "above"')
    )
    asked = ("render", scene, "-o", tmp_path / "out", "--resolution", "8x8", "--channels", "depth")
    said = output_of(*asked, "--renderer", "preview")
    assert "spare cameras: 5 x: spare_0, spare_1, spare_2 and 2 more; --camera" in said
    views = json.loads((tmp_path / "out/manifest.json").read_text())["views"]
    assert "above" in views and not any(name.startswith("spare") for name in views)
    said = output_of(*asked, "--renderer", "preview", "--camera", "spare_4")
    assert "spare cameras" not in said and (tmp_path / "out/spare_4").is_dir()
