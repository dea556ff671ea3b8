"""Light in the browser: a lamp gives what its lightmap holds, and pictures are toned alike."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom

import openrooms_usd as ou
from openrooms_usd.arrays import Array, Mask
from openrooms_usd.colorimetry import LUMINANCE, srgb_from_linear
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.rendering.bake.layer import LIGHT_IRRADIANCE, LIGHT_NAMES, SCALE_OFFSET
from openrooms_usd.rendering.scene.pictures import Picture
from openrooms_usd.rendering.tone import fitted_tone
from openrooms_usd.usd.cameras import list_cameras, read_camera
from openrooms_usd.usd.shading.textures import read_texture
from openrooms_usd.usd.shapes.meshes import read_meshes, world_triangles
from openrooms_usd.view.room import room_app
from tests.chromium import Page, needs_chromium
from tests.view.conftest import PICTURE, ROOM, Shown, lit_picture, slide, turn

pytestmark = [pytest.mark.slow, needs_chromium]


SIZE = PICTURE
LAMP, WINDOW = "table_lamp_0", "window_0"


@pytest.fixture(scope="module")
def baked(composed_demo: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small room with coarse lightmaps."""
    out = tmp_path_factory.mktemp("lit") / "lit"
    return Path(ou.bake(composed_demo, out, texel=0.25, samples=64).stage)


@pytest.fixture(scope="module")
def page(composed_demo: Path, baked: Path, shown: Shown) -> Page:
    page = shown(room_app(composed_demo, light=[baked.parent]))
    page.evaluate("document.getElementById('matt').click()")
    return page


def irradiance(baked: Path, light: str, camera: str) -> tuple[Array, Mask]:
    """(H, W, 3) lux of one light at what a camera sees, by rays and the EXR; and where it is known.

    Nothing of the page, nor of the exporter, is used here.
    """
    stage = Usd.Stage.Open(str(baked))
    reading = read_meshes(stage, outside=False)
    points, triangles, _ = world_triangles(reading)
    places = []
    for mesh in reading:
        found = UsdGeom.PrimvarsAPI(mesh.prim).FindPrimvarWithInheritance(SCALE_OFFSET)
        st = mesh.mesh.uvs.get("st1")
        if found and st is not None:
            places.append(st * np.array(found.Get())[:2] + np.array(found.Get())[2:])
        else:
            places.append(np.full((len(mesh.mesh.triangles), 3, 2), np.nan))
    (atlas,) = (x for x in stage.Traverse() if x.GetAttribute(LIGHT_IRRADIANCE).HasAuthoredValue())
    number = list(atlas.GetAttribute(LIGHT_NAMES).Get()).index(light)
    asset = atlas.GetAttribute(LIGHT_IRRADIANCE).Get()[number]
    held = Picture(read_texture(asset.resolvedPath)[::-1, :, :3], "clamp")
    (prim,) = (x for x in list_cameras(stage) if x.GetName() == camera)
    lens = read_camera(prim, *SIZE)
    ways = lens.directions(*SIZE).reshape(-1, 3) @ lens.world_from_camera[:3, :3].T
    origins = np.broadcast_to(lens.world_from_camera[:3, 3], ways.shape)
    hits = RayCaster(points, triangles).first_hit(origins, ways)
    met = hits.triangle[hits.hit]
    # Barycentric coordinates of where each ray meets its triangle.
    at = origins[hits.hit] + hits.distance[hits.hit, None] * (
        ways[hits.hit] / np.linalg.norm(ways[hits.hit], axis=1, keepdims=True)
    )
    a, b, c = np.moveaxis(points[triangles[met]], 1, 0)
    edges = np.stack([b - a, c - a], axis=-1)
    inner = (np.linalg.pinv(edges) @ (at - a)[..., None])[..., 0]
    shares = np.column_stack([1.0 - inner.sum(axis=1), inner])
    where = np.einsum("nk,nkc->nc", shares, np.concatenate(places)[met])
    known = np.zeros(len(ways), bool)
    known[hits.hit] = np.isfinite(where).all(axis=1)
    found = np.zeros((len(ways), 3))
    found[known] = held.lookup(where[np.isfinite(where).all(axis=1)])
    return found.reshape(*SIZE[::-1], 3), known.reshape(SIZE[::-1])


def off(found: Array, expected: Array, known: Mask) -> float:
    """The mean difference of pixels, as a part of what is expected in the mean."""
    return float(np.abs(found - expected)[known].mean() / expected[known].mean())


@pytest.mark.parametrize("light", [LAMP, WINDOW])
def test_a_light_that_is_switched_off_takes_away_what_its_lightmap_holds(
    page: Page, baked: Path, composed_demo: Path, tmp_path: Path, light: str
) -> None:
    camera = page.evaluate("document.body.dataset.camera")
    asked = {"channels": ["base_color", "metallic"], "cameras": camera, "resolution": SIZE}
    view = ou.render(composed_demo, tmp_path, renderer="preview", **asked)[camera]
    colour = view["base_color"] * (1.0 - view["metallic"][..., None])
    before = lit_picture(page)
    turn(page, light, on=False)
    taken = before - lit_picture(page)
    turn(page, light, on=True)
    assert np.array_equal(lit_picture(page), before)
    lux, known = irradiance(baked, light, camera)
    expected = lit_picture(page, output=2) * (1.0 - view["metallic"][..., None]) * lux / np.pi
    print(f"{light}: {100 * off(taken, expected, known):.2f} % of the mean")
    assert known.mean() > 0.8
    # Graphics units look between texels in steps of 1/256.
    assert off(taken, expected, known) < 0.01
    assert taken[known].sum() == pytest.approx(expected[known].sum(), rel=0.003)
    # By the renderer's base colour, which knows no mipmaps.
    assert off(taken, colour * lux / np.pi, known) < 0.06
    # Another light is another picture: the measure sees it.
    other, _ = irradiance(baked, WINDOW if light == LAMP else LAMP, camera)
    assert off(taken, colour * other / np.pi, known) > 0.5


def test_sliders_dim_a_lamp_and_change_its_colour(page: Page) -> None:
    whole = lit_picture(page)
    turn(page, LAMP, on=False)
    without = lit_picture(page)
    turn(page, LAMP, on=True)
    slide(page, f"share-{LAMP}", 0.5)
    half = lit_picture(page)
    assert np.abs(half - 0.5 * (whole + without)).max() < 1e-3 * whole.max()
    slide(page, f"share-{LAMP}", 1)
    slide(page, f"kelvin-{LAMP}", 6500)
    cold = (lit_picture(page) - without).sum(axis=(0, 1))
    warm = (whole - without).sum(axis=(0, 1))
    assert cold[2] / cold[0] > 1.5 * warm[2] / warm[0]
    assert cold @ LUMINANCE == pytest.approx(warm @ LUMINANCE, rel=0.2)


def test_the_sky_behind_an_opening_is_as_bright_as_it_is_set(page: Page) -> None:
    width, height = SIZE
    numbers = np.array(page.evaluate(f"Array.from({ROOM}.labels({width}, {height}))"))
    sky = numbers.reshape(height, width) == 0
    before = lit_picture(page)[sky]
    assert len(before) > 100 and before.min() > 0.0
    lights = page.evaluate(f"{ROOM}.light.lights.filter(one => one.half).map(one => one.name)")
    taken = np.zeros_like(before)
    for light in lights:
        slide(page, f"share-{light}", 0.5)
        taken += before - lit_picture(page)[sky]
        slide(page, f"share-{light}", 1)
    # Each part of the sky is seen through one of them.
    assert np.abs(taken - 0.5 * before).max() < 1e-3 * before.max()


def test_pictures_are_toned_as_those_of_renders(page: Page, baked: Path) -> None:
    """The exposure, the white and the curve, by `openrooms_usd.rendering.tone`."""
    page.evaluate(f"{ROOM}.meter()")
    told: dict[str, Any] = page.evaluate(f"{ROOM}.tone")
    width, height = (
        160,
        page.evaluate(
            "Math.round(160 * document.getElementById('view').clientHeight"
            " / document.getElementById('view').clientWidth)"
        ),
    )
    ask = f"Array.from({ROOM}.{{}}({width}, {height}))"
    light = np.array(page.evaluate(ask.format("radiance")), np.float32).reshape(height, width, 4)
    tone = fitted_tone("photograph", light[..., :3])
    # Where it is raised the page judges pixels, the renderer their blocks: less than 0.1 stops.
    assert abs(np.log2(told["exposure"] / tone.exposure)) < 0.1
    assert told["balance"] == pytest.approx(tone.balance, rel=0.005)
    assert told["slope"] == pytest.approx(tone.slope, rel=0.05)
    same = replace(tone, **{k: told[k] for k in ("exposure", "slope")}, balance=(*told["balance"],))
    expected = srgb_from_linear(same.shown(light[..., :3])) * 255.0
    codes = np.array(page.evaluate(ask.format("codes"))).reshape(height, width, 4)[..., :3]
    # Panes of glass lie over the picture, and not over its light.
    assert np.percentile(np.abs(codes - expected), 90) <= 1.0


def test_a_traced_picture_shows_the_same_view_with_its_lamps_as_they_are_set(page: Page) -> None:
    turn(page, WINDOW, on=False)
    page.evaluate(f"{ROOM}.meter()")
    for name, value in (("trace-size", 0.25), ("trace-samples", 16)):
        chosen = f"document.getElementById('{name}')"
        page.evaluate(f"{chosen}.value = {value}; {chosen}.dispatchEvent(new Event('change'))")
    page.click_on("#trace")
    page.wait("document.body.dataset.traced == 1", 240)
    traced = page.evaluate(
        "(() => {const i = document.getElementById('traced'), c = document.createElement('canvas');"
        "[c.width, c.height] = [i.naturalWidth, i.naturalHeight];"
        "const g = c.getContext('2d'); g.drawImage(i, 0, 0);"
        "return [c.width, c.height, Array.from(g.getImageData(0, 0, c.width, c.height).data)]})()"
    )
    width, height = traced[:2]
    own = np.array(page.evaluate(f"Array.from({ROOM}.codes({width}, {height}))"))
    pictures = [np.reshape(x, (height, width, 4))[..., :3] for x in (traced[2], own)]
    grey = [picture.mean(axis=2).ravel() for picture in pictures]
    alike = float(np.corrcoef(*grey)[0, 1])
    print(f"correlation {alike:.3f}, means {grey[0].mean():.1f} {grey[1].mean():.1f}")
    assert alike > 0.9
    assert grey[0].mean() == pytest.approx(grey[1].mean(), rel=0.15)
    # Another view is another picture: the measure sees it.
    assert np.corrcoef(grey[0], pictures[1][:, ::-1].mean(axis=2).ravel())[0, 1] < 0.7
    turn(page, WINDOW, on=True)
    page.click_on("#traced")
