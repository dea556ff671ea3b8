"""What surrounds the pages: the panel that folds, help, keys, lengths, what hangs on walls."""

from pathlib import Path

import pytest

import openrooms_usd as ou
from openrooms_usd.view.corrections import corrections
from openrooms_usd.view.objects import objects_app
from openrooms_usd.view.room import room_app
from openrooms_usd.view.server import serving
from tests.chromium import Page, needs_chromium, opened
from tests.view.conftest import ROOM, Shown

pytestmark = [pytest.mark.slow, needs_chromium]

DESCRIPTION = """
layout: {polygon: [[0, 0], [4, 0], [4, 3], [0, 3]], height: 2.5}
furniture:
  objects:
    - {category: picture, at: [2.0, 3.0]}
    - {name: chair, category: chair, at: [1.2, 1.2]}
    - {name: table, category: table, at: [2.4, 1.2], size: [1.2, 0.8, 0.74]}
"""


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("framed")
    (folder / "room.yaml").write_text(DESCRIPTION)
    return ou.compose(folder / "room.yaml", folder / "out").path


def text(page: Page, id: str) -> str:
    return str(page.evaluate(f"document.getElementById('{id}').textContent"))


def test_on_a_phone_the_panel_is_folded_and_leaves_the_room(scene: Path) -> None:
    with (
        serving(room_app(scene)) as server,
        opened(server.address, webgl=True, size=(390, 780)) as page,
    ):
        page.wait("document.body.dataset.ready == 'yes'")
        view = "document.getElementById('view')"
        size = f"[{view}.clientWidth, {view}.clientHeight]"
        assert page.evaluate(size) == [390, 780]
        page.click_on("#fold")
        width, height = page.evaluate(size)
        assert width == 390 and 0.5 * 780 < height < 780
        page.click_on("#fold")
        assert page.evaluate(size) == [390, 780]
        assert page.messages == []


def test_a_length_stands_at_its_line_and_selects_nothing(scene: Path, shown: Shown) -> None:
    page = shown(room_app(scene))
    page.click_on("#overview")
    page.click_on("#measure")
    ends = page.evaluate(f"[[1, 1, 0], [3, 2.4, 0]].map((at) => {ROOM}.camera.project(at))")
    for end in ends:
        page.click(*end)
    page.wait("!document.getElementById('length').hidden")
    metres = float(text(page, "length").removesuffix(" m"))
    assert metres == pytest.approx((2.0**2 + 1.4**2) ** 0.5, abs=0.03)
    left, top = page.evaluate(
        "(() => {const b = document.getElementById('length').getBoundingClientRect();"
        " return [b.x + b.width / 2, b.y + b.height]})()"
    )
    middle = page.evaluate(f"{ROOM}.camera.project([2, 1.7, 0])")
    assert abs(left - middle[0]) < 10 and abs(top - middle[1]) < 30
    assert not page.evaluate("document.body.dataset.prim")
    page.click_on("#measure")
    page.wait("document.getElementById('length').hidden")


def test_help_and_fit_by_keys(scene: Path, shown: Shown) -> None:
    page = shown(room_app(scene))
    page.key("?")
    assert page.evaluate("document.getElementById('help').open")
    page.key("?")
    assert not page.evaluate("document.getElementById('help').open")
    page.evaluate(f"{ROOM}.camera.nearer(-5000)")
    near = page.evaluate(f"{ROOM}.camera.distance")
    page.key("f")
    assert page.evaluate(f"{ROOM}.camera.distance") > 4 * near


def test_pictures_hide_with_their_wall(scene: Path, shown: Shown) -> None:
    page = shown(room_app(scene))
    names = page.evaluate(f"{ROOM}.hung.map((one) => one.path)")
    assert len(names) == 1 and "picture" in names[0]
    hidden = f"{ROOM}.surfaces.hidden.has('{names[0]}')"
    # Seen from +y through the wall that it hangs on, then from the other side.
    for yaw, gone in ((-1.57, True), (1.57, False)):
        page.evaluate(f"Object.assign({ROOM}.camera, {{yaw: {yaw}, pitch: -0.3}}), {ROOM}.fit()")
        page.evaluate(
            "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )
        assert page.evaluate(hidden) is gone


def test_two_fingers_move_and_come_nearer(scene: Path, shown: Shown) -> None:
    page = shown(room_app(scene))
    page.evaluate(f"{ROOM}.fit()")
    before = page.evaluate(f"{ROOM}.camera.distance")
    page.evaluate(
        """(() => {
      const canvas = document.getElementById('view');
      canvas.setPointerCapture = () => {};
      const send = (kind, pointerId, clientX) => canvas.dispatchEvent(new PointerEvent(kind,
        { pointerId, clientX, clientY: 300, pointerType: 'touch', isPrimary: pointerId === 1 }));
      send('pointerdown', 1, 250); send('pointerdown', 2, 350);
      send('pointermove', 1, 200); send('pointermove', 2, 400);
      send('pointerup', 1, 200); send('pointerup', 2, 400);
    })()"""
    )
    assert page.evaluate(f"{ROOM}.camera.distance") == pytest.approx(before / 2, rel=0.01)


def test_a_copy_is_free_and_selected_and_a_collision_is_said(scene: Path, shown: Shown) -> None:
    page = shown(objects_app(corrections(scene)))
    idle = "document.body.dataset.busy == '0'"
    page.evaluate(
        "(() => {const e = document.getElementById('object'); e.value = 'chair';"
        " e.dispatchEvent(new Event('change'))})()"
    )
    page.click_on("#duplicate")
    page.wait(idle)
    assert page.evaluate("document.body.dataset.object") == "chair_copy"
    assert page.evaluate("document.getElementById('told').className") == "told", text(page, "told")
    for id, value in (("y", 1.2), ("x", 2.4)):
        page.evaluate(
            f"Object.assign(document.getElementById('{id}'), {{value: {value}}})"
            ".dispatchEvent(new Event('change'))"
        )
        page.wait(idle)
    assert page.evaluate("document.getElementById('told').className") == "wrong"
    assert "overlaps table by" in text(page, "told")
    for key in ("Control+z", "Control+z", "Control+z"):
        page.key(key)
        page.wait(idle)
    assert not page.evaluate("document.getElementById('redo').disabled")
    for key in ("Control+y", "Control+Shift+z"):
        page.key(key)
        page.wait(idle)
    assert "redone" in text(page, "told")
