"""Renders, photographs and scans in the room's page."""

from pathlib import Path

import numpy as np
import pytest

import openrooms_usd as ou
from openrooms_usd.cli.viewing import _page
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.reading import read_render
from openrooms_usd.view.room import room_app
from openrooms_usd.view.scanned import packed, scan_app
from openrooms_usd.view.shots import ViewPoint, hemisphere
from tests.chromium import Page, needs_chromium
from tests.view.conftest import Shown

pytestmark = [pytest.mark.slow, needs_chromium]

ROOM = "document.getElementById('view').room"
GRID = (8, 6)


@pytest.fixture(scope="module")
def rendered(composed_demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("render") / "render"
    channels = ["radiance", "environment", "depth", "irradiance"]
    ou.render(composed_demo, out, channels=channels, resolution=(80, 60), grid=GRID, samples=16)
    return out


@pytest.fixture(scope="module")
def page(composed_demo: Path, rendered: Path, shown: Shown) -> Page:
    return shown(room_app(composed_demo, render=rendered))


def test_a_camera_shows_the_channels_of_its_render(page: Page, rendered: Path) -> None:
    page.click_on("button[id^=camera-]")
    kind = "document.getElementById('shot-kind')"
    assert "depth" in page.evaluate(f"[...{kind}.options].map(one => one.value)")
    page.evaluate(f"{kind}.value = 'depth'; {kind}.dispatchEvent(new Event('change'))")
    assert page.wait("!document.getElementById('shot').hidden")
    name = page.evaluate("document.body.dataset.shot")
    held = page.evaluate(
        "import('orusd/source.js').then(s => s.resource(document.body.dataset.shot))"
        ".then(bytes => Array.from(new Uint8Array(bytes)))"
    )
    camera = page.evaluate("document.body.dataset.camera")
    assert name.endswith("depth.png")
    assert bytes(held) == (rendered / camera / "depth.png").read_bytes()
    page.drag((200, 300), (240, 300))
    page.wait("document.getElementById('shot').hidden")


def test_a_click_shows_the_light_that_arrives_there(page: Page, rendered: Path) -> None:
    page.click_on("button[id^=camera-]")
    page.click(280, 380)
    page.wait("!document.getElementById('hemisphere').hidden")
    told = page.evaluate("document.getElementById('irradiance').textContent")
    assert all(float(word) > 0.0 for word in told.split(" lux")[0].split(", "))


def test_hemispheres_are_those_of_the_render(rendered: Path) -> None:
    """Their cosine integral, beside the render's irradiance, which does not come from them."""
    render = read_render(rendered)
    view = next(iter(render.each()))
    columns, rows = GRID
    found, known = [], []
    for row in range(rows):
        for column in range(columns):
            x, y = (column + 0.5) / columns, (row + 0.5) / rows
            told = hemisphere(render, ViewPoint(camera=str(view.entry.camera), x=x, y=y))
            assert (told["row"], told["column"]) == (row, column)
            found.append(told["irradiance"])
            known.append(view.pixels["irradiance"][int(y * view.height), int(x * view.width)])
    lit = np.array(known).sum(axis=1) > 0
    ratio = np.array(found)[lit].sum(axis=1) / np.array(known)[lit].sum(axis=1)
    assert np.median(ratio) == pytest.approx(1.0, abs=0.15)
    with pytest.raises(InputError, match="no hemispheres"):
        hemisphere(render, ViewPoint(camera="/World/Cameras/none", x=0.5, y=0.5))


def test_a_render_finds_its_stage(composed_demo: Path, rendered: Path, tmp_path: Path) -> None:
    out = composed_demo.parent / "beside"
    out.symlink_to(rendered)
    try:
        app = _page(out)
    finally:
        out.unlink()
    assert app.state()["shots"]
    (tmp_path / "render").symlink_to(rendered)
    with pytest.raises(InputError, match="not beside it"):
        _page(tmp_path / "render")


def test_a_scan_is_shown_as_its_points(shown: Shown, tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    places = rng.uniform((0, 0, 0), (4, 3, 2.5), (5000, 3))
    places[:4000, 2] = 0.0
    np.savetxt(tmp_path / "scan.xyz", places, fmt="%.4f")
    app = scan_app(tmp_path / "scan.xyz")
    page = shown(app)
    count = page.wait("Number(document.body.dataset.points ?? 0)")
    assert count > 4000
    held = app.resources["scan.points"]()
    assert len(held) == 4 + 15 * count
    found = np.frombuffer(held, "<f4", 3 * count, 4).reshape(-1, 3)
    assert found.max(axis=0) == pytest.approx(places.max(axis=0), abs=0.1)
    # Two points are clicked, and their distance is measured.
    page.click_on("#measure")
    spots = page.evaluate(
        f"{found[::50].tolist()}.map(p => {ROOM}.camera.project(p))"
        ".filter(([x, y]) => x > 40 && x < 500 && y > 40 && y < 560)"
    )
    met = []
    for x, y in (min(spots), max(spots)):
        met.append(page.evaluate(f"{ROOM}.at({x}, {y}).point"))
        page.click(x, y)
    told = page.evaluate("document.getElementById('distance').textContent")
    expected = float(np.linalg.norm(np.subtract(*met)))
    assert float(told.split(" m")[0]) == pytest.approx(expected, abs=2e-3)
    codes = np.array(page.evaluate(f"Array.from({ROOM}.codes(160, 120))")).reshape(-1, 4)
    assert len(np.unique(codes, axis=0)) > 20
    assert page.messages == []


def test_many_points_are_thinned_evenly() -> None:
    points = np.arange(3.0 * 1_200_000).reshape(-1, 3)
    held = packed(points, None)
    assert np.frombuffer(held, "<u4", 1)[0] == 400_000
