"""Materials and furniture corrected in the browser: all that is done is an opinion in the edits."""

import json
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf

import openrooms_usd as ou
from openrooms_usd.description import load_room
from openrooms_usd.view.app import App
from openrooms_usd.view.corrections import corrections
from openrooms_usd.view.materials import materials_app
from openrooms_usd.view.objects import objects_app
from openrooms_usd.view.server import serving
from tests.chromium import Page, needs_chromium, opened
from tests.edits.test_arranging import box, is_a, objects
from tests.edits.test_assigning import others, worn
from tests.view.conftest import Shown

pytestmark = [pytest.mark.slow, needs_chromium]

ROOM = "document.getElementById('view').room"
SEAT = "/World/Furniture/chair_1/Geometry/seat"


@pytest.fixture
def scene(composed_demo: Path, tmp_path: Path) -> Path:
    shutil.copytree(composed_demo.parents[1], tmp_path / "room")
    return tmp_path / "room/out/scene.usda"


def idle(page: Page) -> None:
    page.wait("document.body.dataset.busy == '0'")
    assert page.evaluate("document.getElementById('told').className") == "told", page.evaluate(
        "document.getElementById('told').textContent"
    )


def seen(page: Page, path: str) -> tuple[float, float]:
    """Where in the window a prim is seen."""
    script = f"""(() => {{
      const r = {ROOM}, b = r.bounds([{json.dumps(path)}]);
      for (let k = 0; k < 400; k += 1) {{
        const share = (i) => ((k * [7, 11, 13][i] % 20) + 0.5) / 20;
        const at = [0, 1, 2].map((i) => b[0][i] + (b[1][i] - b[0][i]) * share(i));
        const p = r.camera.project(at);
        if (p && r.at(...p)?.path?.startsWith({json.dumps(path)})) return p;
      }}
      return null;
    }})()"""
    found = page.evaluate(script)
    assert found, f"{path} is not seen"
    return found[0], found[1]


@pytest.mark.parametrize(
    ("scope", "meant"),
    [
        ("part", lambda p: p == SEAT),
        pytest.param("category", lambda p: "/World/Furniture/chair_" in p, marks=pytest.mark.long),
    ],
)
def test_a_click_and_a_picture_change_what_things_are_made_of(
    scope: str, meant: Callable[[str], bool], scene: Path, shown: Shown, tmp_path: Path
) -> None:
    before, layers = worn(scene), others(scene)
    page = shown(materials_app(corrections(scene, scene.parents[1] / "room.yaml")))
    page.click(*seen(page, SEAT))
    assert page.evaluate("document.body.dataset.part") == SEAT
    assert page.evaluate("document.querySelector('[data-fact=object]').textContent") == "chair_1"
    choose(page, "scope", scope)
    choose(page, "substance", "leather")
    pictures = "[...document.querySelectorAll('#families img')]"
    page.wait(f"{pictures}.length > 5 && {pictures}.every((one) => one.naturalWidth)")
    color = shade(page, SEAT)
    page.click_on("[data-family=nappa]")
    idle(page)
    after = worn(scene)
    assert {path for path in after if after[path] != before[path]} == set(filter(meant, before))
    assert after[SEAT][0] == "nappa" and others(scene) == layers
    assert page.evaluate("document.querySelector('[data-fact=family]').textContent") == "nappa"
    assert np.abs(shade(page, SEAT) - color).max() > 8
    page.click_on("#undo")
    idle(page)
    assert worn(scene) == before
    page.click_on("#redo")
    idle(page)
    page.click_on("#compose")
    idle(page)
    assert worn(scene) == after
    # What the stages left out for it comes back by composing again, which the page does then.
    page.click_on("#reset")
    idle(page)
    assert worn(scene) == before
    assert page.messages == []


def test_furniture_is_dragged_copied_exchanged_and_removed(
    scene: Path, shown: Shown, tmp_path: Path
) -> None:
    layers = others(scene)
    page = shown(objects_app(corrections(scene, scene.parents[1] / "room.yaml")))
    start = seen(page, "/World/Furniture/chair_1")
    page.click(*start)
    assert page.evaluate("document.body.dataset.object") == "chair_1"
    # To the wall at x = 4, on the floor under the mouse.
    goal = page.evaluate(
        f"(() => {{const r = {ROOM}.camera;"
        "const a = r.project([2.6, 1.5, 0]), b = r.project([3.7, 0.9, 0]);"
        "return [b[0] - a[0], b[1] - a[1]]})()"
    )
    page.drag(start, (start[0] + goal[0], start[1] + goal[1]), steps=6)
    idle(page)
    low, high = box(scene, "chair_1")
    assert high[0] == pytest.approx(4.0, abs=1e-4) and low[2] == pytest.approx(0.0, abs=1e-6)
    assert np.array(page.evaluate(f"{ROOM}.bounds(['/World/Furniture/chair_1'])")) == pytest.approx(
        box(scene, "chair_1"), abs=1e-3
    )
    page.key("q")
    idle(page)
    page.click_on("#duplicate")
    idle(page)
    assert page.evaluate("document.body.dataset.object") == "chair_1_copy"
    choose(page, "style", "shell")
    idle(page)
    choose(page, "category", "stool")
    idle(page)
    assert is_a(scene, "chair_1_copy")[0] == "stool"
    assert is_a(scene, "chair_1_copy")[1] != is_a(scene, "chair_1")[1]
    choose(page, "object", "table_lamp_0")
    page.click_on("#delete")
    idle(page)
    wanted = {
        "desk": True,
        "chair_0": True,
        "chair_1": True,
        "chair_1_copy": True,
        "table_lamp_0": False,
    }
    assert objects(scene) == wanted and others(scene) == layers
    placed = box(scene, "chair_1")
    page.click_on("#compose")
    idle(page)
    assert objects(scene) == wanted and box(scene, "chair_1") == pytest.approx(placed, abs=1e-6)
    assert page.messages == []


def test_it_is_turned_by_its_handle(scene: Path, shown: Shown) -> None:
    page = shown(objects_app(corrections(scene)))
    page.click(*seen(page, "/World/Furniture/chair_1"))
    script = (
        f"(() => {{const r = {ROOM}.camera, o = [2.6, 1.5, 0.01], d = 0.265 + 0.35;"
        "return [r.project([o[0] + d, o[1], o[2]]), r.project([o[0], o[1] - d, o[2]])]})()"
    )
    grip, goal = (tuple(place) for place in page.evaluate(script))
    before = box(scene, "chair_1")
    page.drag(grip, goal, steps=8)
    idle(page)
    # From 90 degrees to 0: width and depth change places.
    assert np.ptp(box(scene, "chair_1"), axis=0)[:2] == pytest.approx(
        np.ptp(before, axis=0)[[1, 0]], abs=0.01
    )


def test_what_another_program_writes_is_shown(scene: Path, shown: Shown) -> None:
    page = shown(objects_app(corrections(scene)))
    where = f"{ROOM}.bounds(['/World/Furniture/chair_1'])[0][0]"
    before = page.evaluate(where)
    layer = Sdf.Layer.OpenAsAnonymous(str(scene.parent / "layers/edits.usda"))
    prim = Sdf.CreatePrimInLayer(layer, "/World/Furniture/chair_1")
    moved = Sdf.AttributeSpec(prim, "xformOp:translate", Sdf.ValueTypeNames.Double3)
    moved.default = Gf.Vec3d(3.2, 1.5, 0.0)
    layer.Export(str(scene.parent / "layers/edits.usda"))
    page.wait(f"Math.abs({where} - {before} - 0.6) < 1e-3")
    assert "another program" in page.evaluate("document.getElementById('told').textContent")


def test_what_is_refused_is_said_and_the_picture_is_as_it_was(scene: Path, shown: Shown) -> None:
    page = shown(objects_app(corrections(scene)))
    page.click(*seen(page, "/World/Furniture/chair_1"))
    where = f"{ROOM}.bounds(['/World/Furniture/chair_1'])"
    before = np.array(page.evaluate(where))
    page.evaluate(
        "Object.assign(document.getElementById('width'), {value: -1})"
        ".dispatchEvent(new Event('change'))"
    )
    page.wait(
        "document.getElementById('told').className == 'wrong' && document.body.dataset.busy == '0'"
    )
    assert "width" in page.evaluate("document.getElementById('told').textContent")
    assert np.array(page.evaluate(where)) == pytest.approx(before) and objects(scene)["chair_1"]


def test_a_room_yaml_is_corrected_and_composed(scene: Path, shown: Shown) -> None:
    file = scene.parents[1] / "room.yaml"
    page = shown(objects_app(corrections(file, out=scene.parent)))
    page.click(*seen(page, "/World/Furniture/chair_1"))
    before = box(scene, "chair_1")
    page.key("ArrowRight")
    idle(page)
    assert box(scene, "chair_1") - before == pytest.approx(
        np.tile([0.05, 0.0, 0.0], (2, 1)), abs=1e-4
    )
    chair = load_room(file).as_dict()["furniture"]["objects"][2]
    assert chair["at"] == pytest.approx([2.65, 1.5])
    page.click_on("#undo")
    idle(page)
    assert box(scene, "chair_1") == pytest.approx(before)


def choose(page: Page, id: str, value: str) -> None:
    """Choose from a list as a person does."""
    page.evaluate(
        f"(() => {{const e = document.getElementById({json.dumps(id)});"
        f"e.value = {json.dumps(value)}; e.dispatchEvent(new Event('change'))}})()"
    )


def shade(page: Page, path: str) -> np.ndarray:
    """The colour in which a prim is seen, without its mark."""
    script = f"""(() => {{
      const r = {ROOM}, marked = r.surfaces.marked;
      r.select([]);
      const [width, height] = [r.canvas.clientWidth, r.canvas.clientHeight];
      const prims = r.labels(width, height).map((n) => r.surfaces.prims[n]);
      const light = r.radiance(width, height, 2);
      r.select([...marked]);
      const sum = [0, 0, 0, 0];
      prims.forEach((prim, k) => {{
        if (prim !== {json.dumps(path)}) return;
        for (let c = 0; c < 3; c += 1) sum[c] += light[4 * k + c];
        sum[3] += 1;
      }});
      return sum.slice(0, 3).map((v) => 255 * v / sum[3]);
    }})()"""
    return np.array(page.evaluate(script))


@pytest.fixture
def generated(tmp_path: Path) -> Path:
    room = ou.generate("bedroom", seed=4, style="mid_century", clutter=1, area=12)
    room.save(tmp_path / "room.yaml")
    return ou.compose(tmp_path / "room.yaml", tmp_path / "out").path


@contextmanager
def alone(app: App) -> Iterator[Page]:
    """A page that is closed before the next one: both would read the same layers."""
    with serving(app) as server, opened(server.address, webgl=True) as page:
        page.resize(900, 600)
        page.wait("document.body.dataset.ready == 'yes'")
        yield page
        idle(page)
        assert page.messages == []


@pytest.mark.long
def test_a_generated_room_keeps_a_material_and_a_place(generated: Path, tmp_path: Path) -> None:
    layers, before = others(generated), worn(generated)
    held = corrections(generated, generated.parents[1] / "room.yaml")
    stand = next(name for name in objects(generated) if name.startswith("night_stand"))
    path = f"/World/Furniture/{stand}"
    rest = [f"/World/Furniture/{name}" for name in objects(generated) if name != stand]
    meant = {one for one in before if one.startswith(f"{path}/")}
    start = box(generated, stand)
    with alone(materials_app(held)) as page:
        page.evaluate(f"{ROOM}.hide({json.dumps(rest)})")
        page.click(*seen(page, path))
        choose(page, "scope", "object")
        choose(page, "substance", "wood")
        page.click_on("[data-family=zebrano]")
    after = worn(generated)
    assert {one for one in after if after[one][0] == "zebrano"} == meant
    assert all(after[one] == before[one] for one in set(before) - meant)
    with alone(objects_app(held)) as page:
        choose(page, "object", stand)
        page.key("ArrowLeft")
        idle(page)
        assert others(generated) == layers
        page.click_on("#compose")
    assert worn(generated).items() >= {one: after[one] for one in meant}.items()
    assert np.abs(box(generated, stand) - start).max() > 1e-3
