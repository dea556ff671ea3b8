"""The renderer without light: what it draws, what it says of itself, what it has for nothing."""

import json
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest
import trimesh
from numpy.typing import NDArray
from pxr import Gf, Usd, UsdGeom, UsdLux, UsdShade

from openrooms_usd import adapters
from openrooms_usd.channels import each
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.rendering import RenderRequest
from openrooms_usd.rendering.given import EXACT
from openrooms_usd.usd.shading.materials import define_preview_surface
from openrooms_usd.usd.shading.surfaces import PreviewSurface
from orusd_preview import PreviewRenderer
from orusd_preview.session import BACKGROUND, openness, shade
from tests.commands import run
from tests.opening import open_with

SIZE = (32, 24)


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if the package had been installed with the entry point that pyproject.toml has."""
    ours = EntryPoint("preview", "orusd_preview:PreviewRenderer", adapters.RENDERERS)

    def found(*, group: str) -> list[EntryPoint]:
        others = [point for point in entry_points(group=group) if point.name != ours.name]
        return [*others, ours] if group == ours.group else others

    monkeypatch.setattr(adapters, "entry_points", found)


def board(*colors: tuple[float, float, float], exposure: float | None = None) -> Usd.Stage:
    """Squares of 1 m beside each other, seen from 4 m above."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    for number, color in enumerate(colors):
        mesh = UsdGeom.Mesh.Define(stage, f"/Square_{number}")
        x = number - 0.5 * len(colors)
        corners = ((x, -0.5), (x + 1, -0.5), (x + 1, 0.5), (x, 0.5))
        mesh.CreatePointsAttr([Gf.Vec3f(a, b, 0) for a, b in corners])
        mesh.CreateFaceVertexCountsAttr([4])
        mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
        mesh.CreateSubdivisionSchemeAttr("none")
        define_preview_surface(stage, f"/Look_{number}", PreviewSurface(base_color=color))
        look = UsdShade.Material.Get(stage, f"/Look_{number}")
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(look)
    camera = UsdGeom.Camera.Define(stage, "/Camera")
    camera.AddTranslateOp().Set(Gf.Vec3d(0, 0, 4))
    if exposure is not None:
        camera.CreateExposureAttr(exposure)
    return stage


def drawn(stage: Usd.Stage, samples: int = 16, seed: int = 0) -> NDArray[Any]:
    request = RenderRequest("/Camera", ("radiance",), *SIZE, samples=samples, seed=seed)
    return (
        open_with(PreviewRenderer(), stage, default_light=False)
        .render(request)
        .images["radiance"]
        .pixels
    )


def ball(radius: float) -> RayCaster:
    mesh = trimesh.creation.icosphere(subdivisions=5, radius=radius)
    return RayCaster(mesh.vertices, mesh.faces)


@pytest.mark.parametrize(("radius", "reach"), [(0.5, 1.0), (0.5, 2.0), (0.2, 0.9)])
def test_openness_inside_a_ball_is_its_closed_form(radius: float, reach: float) -> None:
    """A ray at an angle a to the normal ends after 2 r cos a: the mean of that over the reach."""
    normals = np.random.default_rng(0).normal(size=(64, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = -radius * normals
    found = openness(ball(radius), points, normals, 256, reach, np.random.default_rng(1))
    assert found.mean() == pytest.approx(4.0 * radius / (3.0 * reach), abs=0.005)


def test_openness_in_the_open_and_below_a_lid() -> None:
    """Below a lid at a height h a ray at an angle a to the normal ends after h / cos a."""
    corners = np.array([(x, y, 0.3) for x in (-99.0, 99.0) for y in (-99.0, 99.0)])
    lid = RayCaster(corners, [[0, 1, 2], [1, 3, 2]])
    points, up = np.zeros((400, 3)), np.tile([0.0, 0.0, 1.0], (400, 1))
    rng = np.random.default_rng(2)
    assert (openness(lid, points, -up, 16, 1.0, rng) == 1.0).all()
    # E[min(1, t / R)] with t = h / c, density 2 c: h^2 / R^2 + 2 h / R (1 - h / R).
    expected = 0.3**2 + 2.0 * 0.3 * 0.7
    assert openness(lid, points, up, 256, 1.0, rng).mean() == pytest.approx(expected, abs=0.005)


def test_white_that_faces_the_camera_upwards_in_the_open_is_white() -> None:
    one = np.ones((1, 1))
    seen = {
        "base_color": np.ones((1, 3)),
        "normal": np.array([[0.0, 0.0, 1.0]]),
        "emission_mask": 0.0 * one,
    }
    down = np.array([[0.0, 0.0, -3.0]])
    assert shade(seen, down, np.ones(1)) == pytest.approx(np.ones((1, 3)))
    darker = [
        shade(seen, np.array([[3.0, 0.0, -1.0]]), np.ones(1)),
        shade(seen, down, np.array([0.4])),
        shade(seen | {"normal": np.array([[1.0, 0.0, 0.0]])}, np.array([[-1.0, 0, 0]]), np.ones(1)),
    ]
    assert all(found.max() < 0.95 for found in darker)
    shining = seen | {"emission_mask": one, "base_color": np.zeros((1, 3))}
    assert shade(shining, down, np.zeros(1)).min() == 1.0


def test_colors_are_in_the_proportions_of_the_base_colors() -> None:
    pixels = drawn(board((0.8, 0.4, 0.2), (0.2, 0.2, 0.8)))
    left, right = pixels[12, 12], pixels[12, 19]
    assert left / right == pytest.approx((4.0, 2.0, 0.25), rel=0.01)
    assert pixels[1, 1] == pytest.approx(BACKGROUND)


def test_it_is_as_bright_by_day_and_by_night() -> None:
    dark, lit = board((0.5, 0.5, 0.5)), board((0.5, 0.5, 0.5))
    UsdLux.DistantLight.Define(lit, "/Sun").CreateIntensityAttr(1e5)
    assert np.array_equal(drawn(dark), drawn(lit))


def test_the_exposure_of_the_camera_shows_white_as_one() -> None:
    pixels = drawn(board((1.0, 1.0, 1.0), exposure=-7.0))
    assert pixels[12, 16] * 2.0**-7 == pytest.approx(1.0, abs=0.02)


def test_equal_seeds_give_equal_bits() -> None:
    stage = board((0.5, 0.5, 0.5))
    box = UsdGeom.Cube.Define(stage, "/Box")
    box.CreateSizeAttr(0.5)
    first, again, other = drawn(stage), drawn(stage), drawn(stage, seed=1)
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
    assert other == pytest.approx(first, rel=0.3)


def test_the_exact_channels_are_those_of_another_renderer() -> None:
    """What Mitsuba's ray tracer finds and what the core's finds are the same triangles."""
    from orusd_mitsuba import MitsubaRenderer

    stage = board((0.8, 0.4, 0.2), (0.2, 0.2, 0.8))
    ball = UsdGeom.Sphere.Define(stage, "/Ball")
    ball.CreateRadiusAttr(0.4)
    # Off the axis: rays that meet an edge exactly may be of either side.
    ball.AddTranslateOp().Set(Gf.Vec3d(0.0137, 0.0271, 0.0))
    UsdLux.SphereLight.Define(stage, "/Lamp").CreateRadiusAttr(0.1)
    request = RenderRequest("/Camera", EXACT, 64, 48, samples=1)
    opened = [open_with(renderer, stage) for renderer in (PreviewRenderer(), MitsubaRenderer())]
    assert opened[0].legend == opened[1].legend
    ours, theirs = (one.render(request).images for one in opened)
    assert set(ours) == set(theirs) == set(each(EXACT, 2))
    for name in ours:
        apart = np.abs(ours[name].pixels - theirs[name].pixels).max(axis=2) > 1e-5
        assert apart.mean() < 0.002, name


@pytest.mark.usefixtures("installed")
def test_the_command_writes_what_it_writes_with_any_renderer(tmp_path: Path) -> None:
    stage = board((0.8, 0.4, 0.2))
    stage.GetRootLayer().Export(str(tmp_path / "board.usda"))
    out = tmp_path / "out"
    words = ["render", str(tmp_path / "board.usda"), "-o", str(out), "--resolution", "16x12"]
    done = run(*words, "--renderer", "preview", "--spp", "8", "--option", "reach=0.5")
    assert done.exit_code == 0, done.output
    manifest = json.loads((out / "manifest.json").read_text())
    assert manifest["renderer"] == {
        "name": "preview",
        "backend": "preview, rays cast by the core",
        "reach": "0.5",
    }
    assert "without light transport" in manifest["conventions"]["radiance"]
    said = [row["reason"] for row in manifest["report"]["losses"] if row["prim"] == "/Camera"]
    assert said == ["radiance: a preview, no light"]
    assert {"radiance", "depth", "semantic", "friction"} <= manifest["channels"].keys()
    assert (out / "contact_sheet.png").is_file()


@pytest.mark.usefixtures("installed")
def test_it_draws_the_thumbnails_of_the_catalogue(tmp_path: Path) -> None:
    words = ["library", "sheet", "-o", str(tmp_path / "sheet.png"), "--category", "plant_pot"]
    done = run(*words, "--size", "32", "--renderer", "preview")
    assert done.exit_code == 0, done.output
    sheet = OpenImageIO.ImageBuf(str(tmp_path / "sheet.png")).get_pixels()
    # Green leaves before the grey of the studio, above the caption.
    green = sheet[:40, :, 1] - np.maximum(sheet[:40, :, 0], sheet[:40, :, 2])
    assert (green > 0.05).sum() > 20


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--channels", "irradiance"], "--renderer mitsuba gives it"),
        (["--variant", "llvm"], "it has: reach"),
        (["--bsdf", "openrooms"], "it has: reach"),
        (["--option", "reach=far"], "metres, such as 0.6"),
    ],
    ids=" ".join,
)
def test_what_it_cannot_do_is_refused(options: list[str], said: str, tmp_path: Path) -> None:
    stage = board((0.8, 0.4, 0.2))
    stage.GetRootLayer().Export(str(tmp_path / "board.usda"))
    words = ["render", str(tmp_path / "board.usda"), "-o", str(tmp_path / "out")]
    done = run(*words, "--renderer", "preview", *options)
    assert isinstance(done.exception, InputError)
    assert said in str(done.exception)
