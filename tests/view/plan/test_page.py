"""A real scan's plan in a browser: a corner dragged, a window drawn, saved, and composed."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

import openrooms_usd as ou
from openrooms_usd import names
from openrooms_usd.description import load_room
from openrooms_usd.importing import import_capture
from openrooms_usd.view.plan.session import Session
from openrooms_usd.view.server import serving
from tests.chromium import Page, needs_chromium, opened

pytestmark = [pytest.mark.slow, needs_chromium]

PLAN = """\
layout:
  polygon: [[0, 0], [5, 0], [5, 4], [0, 4]]
  openings: [{kind: door, wall: 2}]
"""


def count(page: Page, number: int) -> None:
    page.wait(f"document.body.dataset.undo == {number}")


def place(page: Page, group: str, x: float, y: float) -> tuple[float, float]:
    """Where a point in metres is on the screen."""
    at = page.evaluate(
        f"(() => {{ const p = new DOMPoint({x}, {y}).matrixTransform("
        f"document.querySelector('{group} > g').getScreenCTM()); return [p.x, p.y] }})()"
    )
    return at[0], at[1]


def test_a_real_scan_is_corrected_saved_and_composed(
    real: Callable[[str], Path], tmp_path: Path
) -> None:
    source = real("real_dev/data/arkit_lounge/textured.obj")
    file = import_capture("scan", source, tmp_path / "room").file
    session = Session(file)
    before = session.history.now
    with serving(session.app()) as server, opened(server.address, size=(1200, 800)) as page:
        page.wait("document.getElementById('points')?.dataset.loaded")
        assert page.evaluate("document.getElementById('draft').getClientRects().length") == 0
        x, y = before.corners[1]
        page.drag(page.middle("[data-corner='1']"), place(page, "#plan", x + 0.5, y - 0.4))
        count(page, 1)
        page.click_on("[data-wall='0']")
        page.wait("document.getElementById('elevation-points').dataset.shown == 'wall_0'")
        seen = page.evaluate(
            "(() => { const c = document.getElementById('elevation-points'); const p = c.getContext"
            "('2d').getImageData(0, 0, c.width, c.height).data; let n = 0; for (let i = 3; i < "
            "p.length; i += 4) n += p[i] > 0; return n / (c.width * c.height) })()"
        )
        assert seen > 0.05
        page.drag(place(page, "#elevation", 0.6, 0.9), place(page, "#elevation", 1.6, 2.0))
        count(page, 2)
        page.drag(page.middle("[data-edge$=':right']"), place(page, "#elevation", 1.8, 1.5))
        count(page, 3)
        page.click_on("#height")
        page.evaluate("document.getElementById('height').select()")
        page.write("2.7")
        page.key("Enter")
        count(page, 4)
        page.key("Tab")
        page.click_on("#undo")
        count(page, 3)
        page.click_on("#redo")
        count(page, 4)
        clicks = int(page.evaluate("document.getElementById('clicks').textContent").split()[0])
        page.click_on("#save")
        page.wait("document.getElementById('saved').textContent.startsWith('as in')")
        assert page.messages == []
        assert all("127.0.0.1" in request for request in page.requests if ":" in request[:6])
    assert clicks == 7
    layout = load_room(file).layout
    assert layout.polygon is not None and layout.height == 2.7
    drawn = next(one for one in layout.openings if one.wall == 0)
    assert (drawn.width, drawn.height, drawn.sill) == pytest.approx((1.2, 1.1, 0.9), abs=0.04)
    assert np.allclose(layout.polygon[1], (x + 0.5, y - 0.4), atol=0.13)
    ou.compose(file, tmp_path / "out", only="layout")
    stage = Usd.Stage.Open(str(tmp_path / "out/scene.usda"))
    floor = np.array(stage.GetPrimAtPath(names.ROOM).GetAttribute(names.ROOM_FLOOR).Get())
    assert np.allclose(floor, layout.polygon, atol=1e-4)
    report = json.loads((tmp_path / "out/report.json").read_text())["layout"]
    assert len(report["rooms"]) == 1 and report["rooms"][0]["ceiling_height"] == 2.7
    kinds = [one["type"] for one in report["rooms"][0]["openings"]]
    assert kinds.count("window") == 2


@pytest.fixture
def served(tmp_path: Path) -> Path:
    (tmp_path / "room.yaml").write_text(PLAN)
    return tmp_path / "room.yaml"


def test_keys_refusals_and_a_change_by_another_program(served: Path, tmp_path: Path) -> None:
    with serving(Session(served).app()) as server, opened(server.address, size=(1000, 700)) as page:
        page.wait("document.body.dataset.ready")
        page.drag(page.middle("[data-wall='1']"), place(page, "#plan", 5.5, 2.0))
        count(page, 1)
        page.key("Control+z")
        count(page, 0)
        page.key("Control+y")
        count(page, 1)
        page.drag(page.middle("[data-corner='0']"), place(page, "#plan", 7.0, 2.2))
        count(page, 2)
        assert "meets wall" in page.evaluate("document.getElementById('refusal').textContent")
        page.click_on("#save")
        page.wait("document.getElementById('refusal').textContent.includes('room.yaml')")
        assert served.read_text() == PLAN
        page.key("Control+z")
        count(page, 1)
        page.key("Control+s")
        page.wait("document.getElementById('saved').textContent.startsWith('as in')")
        assert "5.5" in served.read_text()
        served.write_text(PLAN + "  height: 3.3\n")
        page.wait("document.getElementById('height').value == '3.300'")
        page.click_on("[data-wall='2']")
        page.wait("document.querySelector('[data-hole]') !== null")
        page.click_on("[data-hole='0']")
        page.wait("document.getElementById('selected').textContent.startsWith('door_0')")
        page.key("Delete")
        page.wait("document.querySelector('[data-hole]') === null")
        page.click_on("[data-wall='0']")
        page.wait("document.getElementById('selected').textContent == 'wall 0'")
        x, y = place(page, "#elevation", 2.0, 1.0)
        page.drag((x, y), (x + 4, y + 90))
        page.wait("document.getElementById('refusal').textContent.includes('too small')")
        assert page.evaluate("document.querySelectorAll('[data-hole]').length") == 0
        assert all("422" in message for message in page.messages)
    with serving(Session(served).app()) as server, opened(server.address, size=(1000, 700)) as page:
        page.wait("document.getElementById('draft')?.getClientRects().length")
        page.click_on("#draft-take")
        count(page, 1)
        assert page.evaluate("document.getElementById('draft').getClientRects().length") == 0


def test_the_page_is_one_file_to_look_at(served: Path, tmp_path: Path) -> None:
    from openrooms_usd.view import shell

    page_file = tmp_path / "page.html"
    shell.write(Session(served).app(), page_file)
    text = page_file.read_bytes()
    shell.write(Session(served).app(), page_file)
    assert page_file.read_bytes() == text
    with opened(page_file) as page:
        page.wait("document.body.dataset.ready")
        assert page.evaluate("document.querySelectorAll('[data-corner]').length") == 4
        assert page.messages == []
