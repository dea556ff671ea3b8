"""A room in the browser: what it shows is what the renderer sees, and a click says what it is."""

from pathlib import Path

import numpy as np
import OpenImageIO
import pytest
from numpy.typing import NDArray
from pxr import Usd

import openrooms_usd as ou
from openrooms_usd.arrays import Floats
from openrooms_usd.importing import import_capture
from openrooms_usd.view import shell
from openrooms_usd.view.room import room_app, room_state
from tests.chromium import Page, needs_chromium, opened
from tests.conftest import REAL
from tests.view.conftest import Shown, drawn

pytestmark = [pytest.mark.slow, needs_chromium]

SIZE = (320, 240)
ROOM = "document.getElementById('view').room"


@pytest.fixture(scope="module")
def page(composed_demo: Path, shown: Shown) -> Page:
    return shown(room_app(composed_demo))


def labels(page: Page) -> NDArray[np.str_]:
    """(H, W) the prim of each pixel of the camera that the page looks through."""
    width, height = SIZE
    prims, numbers = page.evaluate(
        f"[{ROOM}.surfaces.prims, Array.from({ROOM}.labels({width}, {height}))]"
    )
    found: NDArray[np.str_] = np.array(prims)[np.array(numbers).reshape(height, width)]
    return found


def pixels(path: Path) -> Floats:
    return np.asarray(OpenImageIO.ImageBuf(str(path)).get_pixels("float"))[..., :3]


def test_every_pixel_shows_the_prim_that_the_preview_renderer_sees(
    page: Page, composed_demo: Path, tmp_path: Path
) -> None:
    page.evaluate("document.getElementById('walk').checked = false")
    cameras = [camera["name"] for camera in room_state(composed_demo)["cameras"]]
    rendered = ou.render(
        composed_demo, tmp_path, channels="part", resolution=SIZE, renderer="preview"
    )
    for camera in cameras:
        page.click_on(f"#camera-{camera}")
        page.wait(f"document.body.dataset.camera == '{camera}'")
        view = rendered[camera]
        names = {0: "", **rendered.legend("part")}
        expected = np.vectorize(names.get)(view["part"])
        same = labels(page) == expected
        print(f"{camera}: {100 * same.mean():.2f} % of the pixels")
        assert same.mean() > 0.99
    # A picture that is turned by a degree is another one: the measure sees it.
    page.evaluate(f"{ROOM}.camera.turned(Math.PI / 180 / 0.005, 0)")
    assert (labels(page) == expected).mean() < 0.99


@pytest.mark.long
@pytest.mark.parametrize("room", ["kitchen", "lounge"])
def test_generated_and_scanned_rooms_show_what_the_preview_renderer_sees(
    room: str, shown: Shown, tmp_path: Path
) -> None:
    """A kitchen with all that lies about, and a room that was scanned by phone."""
    if room == "kitchen":
        scene = Path(ou.compose(ou.generate("kitchen", seed=5), tmp_path / "out"))
    else:
        capture = REAL / "real_dev/data/arkit_lounge"
        if not capture.is_dir():
            pytest.skip("the captures of real rooms are not here (ORUSD_REAL)")
        options = {"up": "0,1,0", "frames": str(capture / "frames.json")}
        import_capture("scan", capture / "textured.obj", tmp_path / "room", options)
        scene = Path(ou.compose(tmp_path / "room" / "room.yaml", tmp_path / "out"))
    page = shown(room_app(scene))
    cameras = [camera["name"] for camera in room_state(scene)["cameras"]][:2]
    rendered = ou.render(
        scene,
        tmp_path / "render",
        channels="part",
        resolution=SIZE,
        renderer="preview",
        cameras=cameras,
    )
    for camera in cameras:
        page.click_on(f"#camera-{camera}")
        page.wait(f"document.body.dataset.camera == '{camera}'")
        names = {0: "", **rendered.legend("part")}
        expected = np.vectorize(names.get)(rendered[camera]["part"])
        # What stands outside of the windows is not in the page.
        inside = ~np.char.startswith(expected, "/World/Outside")
        same = (labels(page) == expected)[inside]
        print(f"{room} {camera}: {100 * same.mean():.2f} % of {100 * inside.mean():.1f} %")
        assert inside.mean() > 0.8 and same.mean() > 0.99


def test_the_picture_is_neither_empty_nor_plain(page: Page, tmp_path: Path) -> None:
    page.click_on("#overview")
    page.click_on("button[id^=camera-]")
    picture = pixels(drawn(page, tmp_path))[:, :560]
    assert picture.std(axis=(0, 1)).min() > 0.05
    assert len(np.unique((picture * 255).astype(np.uint8).reshape(-1, 3), axis=0)) > 500
    assert page.messages == []
    assert all(
        address.startswith(("http://127.0.0.1:", "data:", "blob:")) for address in page.requests
    )


def test_a_click_names_the_prim_and_what_is_known_of_it(page: Page) -> None:
    page.click_on("button[id^=camera-]")
    place, path = page.evaluate(
        f"(() => {{const r = {ROOM}, box = r.bounds(['/World/Furniture/desk']);"
        "const at = r.camera.project([0, 1, 2].map(k => (box[0][k] + box[1][k]) / 2 * (k < 2)"
        " + (k == 2) * box[1][2]));"
        "return [at, r.at(...at).path]})()"
    )
    page.click(*place)
    assert page.evaluate("document.body.dataset.prim") == path
    assert path.startswith("/World/Furniture/desk")
    assert page.evaluate("document.querySelector('.tree .chosen') !== null")
    assert page.evaluate("document.querySelector('[data-fact=path]').textContent") == path
    assert "alignment" in page.evaluate("document.querySelector('[data-fact=layers]').textContent")
    marked = page.evaluate(f"[...{ROOM}.surfaces.marked]")
    assert marked == [path]


def test_a_click_beside_everything_chooses_nothing(page: Page) -> None:
    page.click_on("#overview")
    page.wait(f"{ROOM}.at(5, 5) === null")
    page.click(5, 5)
    assert page.evaluate("document.body.dataset.prim") == ""
    assert page.evaluate("document.querySelector('.tree .chosen') === null")
    assert page.messages == []


def test_a_name_in_the_tree_marks_the_prim(page: Page) -> None:
    if page.evaluate("document.querySelector(\"[data-path='/World/Furniture/desk']\") === null"):
        page.click_on("[data-path='/World/Furniture'] > .fold")
    page.click_on("[data-path='/World/Furniture/desk'] > .name")
    assert page.evaluate("document.body.dataset.prim") == "/World/Furniture/desk"
    assert page.evaluate("document.querySelector('[data-fact=category]').textContent") == "table"


def test_opinions_are_those_of_the_layers(page: Page, composed_demo: Path) -> None:
    page.evaluate(f"{ROOM}.page.choose('/World/Furniture/desk')")
    page.click_on("#opinions > summary")
    layers = page.wait("[...document.querySelectorAll('[data-layer]')].map(e => e.dataset.layer)")
    stage, home = Usd.Stage.Open(str(composed_demo)), composed_demo.parent
    stack = stage.GetPrimAtPath("/World/Furniture/desk").GetPrimStack()
    assert layers == [Path(x.layer.realPath).relative_to(home).as_posix() for x in stack]
    told = page.evaluate(
        "[...document.querySelectorAll('[data-layer]')].map("
        "e => [...e.querySelectorAll('dd')].map(d => d.dataset.fact))"
    )
    expected = [sorted(one.name for one in spec.properties) for spec in stack]
    # A property without a value, such as a class of nothing, has nothing to show.
    assert all(set(found) <= set(names) for found, names in zip(told, expected, strict=True))
    assert sum(map(len, told)) > 0.7 * sum(map(len, expected))
    refused = page.evaluate(
        "import('orusd/source.js').then(s => s.send('opinions', {path: '/Nowhere'}))"
        ".catch(error => error.message)"
    )
    assert refused == "the stage has no such prim"


def test_the_plan_is_drawn_over_the_picture(page: Page) -> None:
    page.click_on("#overview")
    assert page.evaluate(f"{ROOM}.overlays.has('plan')") is False
    before = np.array(page.evaluate(f"Array.from({ROOM}.codes(200, 150))")).reshape(-1, 4)
    page.click_on("#plan")
    assert page.evaluate(f"{ROOM}.overlays.get('plan').count") == 2 * (4 + 2 * 4)
    after = np.array(page.evaluate(f"Array.from({ROOM}.codes(200, 150))")).reshape(-1, 4)
    painted = (after != before).any(axis=1)
    assert 0.005 < painted.mean() < 0.1
    assert np.abs(after[painted][:, :3] - np.array([242, 77, 153])).max() <= 2
    page.click_on("#plan")


def test_a_click_on_a_cameras_eye_jumps_into_it(page: Page) -> None:
    page.click_on("#overview")
    page.click_on("#pyramids")
    camera = page.evaluate(f"{ROOM}.page.state.cameras[0]")
    eye = [row[3] for row in camera["world_from_camera"][:3]]
    page.click(*page.evaluate(f"{ROOM}.camera.project({eye})"))
    assert page.evaluate("document.body.dataset.camera") == camera["name"]
    assert np.abs(np.array(page.evaluate(f"{ROOM}.camera.eye")) - eye).max() < 1e-6
    page.click_on("#pyramids")


def test_what_is_moved_is_elsewhere_and_comes_back(page: Page) -> None:
    path = "/World/Furniture/desk"
    ask = f"{ROOM}.bounds(['{path}'])"
    before = np.array(page.evaluate(ask))
    shift = "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0.5,0,0.25,1]"
    page.evaluate(f"{ROOM}.move('{path}', {shift})")
    moved = np.array(page.evaluate(ask))
    assert np.abs(moved - before - [0.5, 0.0, 0.25]).max() < 1e-6
    page.evaluate(f"{ROOM}.move('{path}', null)")
    assert np.abs(np.array(page.evaluate(ask)) - before).max() < 1e-9


def test_mouse_and_keys_move_the_eye(page: Page) -> None:
    page.click_on("#overview")
    eye = f"{ROOM}.camera.eye"
    first = np.array(page.evaluate(eye))
    page.drag((200, 300), (300, 300))
    turned = np.array(page.evaluate(eye))
    assert np.abs(turned - first)[:2].max() > 0.3 and abs(turned[2] - first[2]) < 1e-9
    page.wheel(300, 300, -300)
    assert page.wait(f"{ROOM}.camera.distance") < np.linalg.norm(turned)
    page.click_on("#walk")
    walking = np.array(page.evaluate(eye))
    assert walking[2] == pytest.approx(1.6, abs=0.02)
    page.page.keyboard.down("w")
    page.wait(f"Math.hypot(...{eye}.map((v, k) => v - {walking.tolist()}[k])) > 0.3")
    page.page.keyboard.up("w")
    assert page.evaluate(f"{eye}[2]") == pytest.approx(1.6, abs=0.02)
    page.click_on("#walk")


def test_the_page_in_a_file_shows_the_same(composed_demo: Path, tmp_path: Path) -> None:
    app = room_app(composed_demo)
    shell.write(app, tmp_path / "page.html")
    text = (tmp_path / "page.html").read_bytes()
    shell.write(app, tmp_path / "again.html")
    assert text == (tmp_path / "again.html").read_bytes()
    with opened(tmp_path / "page.html", webgl=True, size=(900, 600)) as page:
        page.wait("document.body.dataset.ready == 'yes'")
        picture = pixels(drawn(page, tmp_path))[:, :560]
        assert picture.std(axis=(0, 1)).min() > 0.05
        assert page.messages == []
        assert all(address.startswith(("file:", "data:", "blob:")) for address in page.requests)
