"""Programs of others: the Khronos validator finds nothing, and three.js shows the same room.

They run where `.ci/install-gltf-validator` has been, or where ORUSD_NODE_MODULES leads to the same
packages; pictures besides where Chromium is.
"""

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest
from pxr import Usd, UsdGeom

import openrooms_usd as ou
from openrooms_usd import names
from openrooms_usd.arrays import Floats
from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.demo import copy_example
from openrooms_usd.rendering.reading import read_render
from openrooms_usd.usd.cameras import list_cameras
from openrooms_usd.usd.shading.materials import bound_material
from orusd_gltf import GltfExporter
from tests.gltf.conftest import MODULES

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("gltf")]

Node = Callable[..., str]
ROOMS = (
    "example",
    *(pytest.param(name, marks=pytest.mark.long) for name in ("kitchen", "bedroom")),
)
SIZE = (320, 240)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The example, or a generated room, composed once."""
    folder = tmp_path_factory.mktemp("rooms")

    def composed(name: str) -> Path:
        out = folder / name
        if not (out / "scene.usda").is_file():
            source = folder / f"{name}_source"
            room = copy_example(source) if name == "example" else ou.generate(name, seed=5)
            ou.compose(room, out)
        return out / "scene.usda"

    return composed


def written(scene: Path, target: Path, **options: Any) -> Path:
    GltfExporter().convert(Usd.Stage.Open(str(scene)), target, options)
    return target


@pytest.mark.parametrize("name", ROOMS)
def test_the_validator_finds_nothing(
    name: str, scene: Callable[[str], Path], node: Node, tmp_path: Path
) -> None:
    (report,) = json.loads(node("validate.mjs", written(scene(name), tmp_path / "room.glb")))
    issues = report["issues"]
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"][:5]


def test_the_validator_sees_what_is_wrong(composed_demo: Path, node: Node, tmp_path: Path) -> None:
    """Of a file whose normals are too long: so the silence above says something."""
    file = written(composed_demo, tmp_path / "room.glb")
    whole = file.read_bytes()
    size = int.from_bytes(whole[12:16], "little")
    text = json.loads(whole[20 : 20 + size])
    primitive = text["meshes"][0]["primitives"][0]
    view = text["bufferViews"][text["accessors"][primitive["attributes"]["NORMAL"]]["bufferView"]]
    at = 28 + size + view["byteOffset"]
    file.write_bytes(whole[:at] + np.float32([3, 0, 0]).tobytes() + whole[at + 12 :])
    (report,) = json.loads(node("validate.mjs", file))
    assert report["issues"]["numErrors"] > 0


def picture(path: Path) -> Floats:
    return np.asarray(OpenImageIO.ImageBuf(str(path)).get_pixels("float"))[..., :3]


def shown(node: Node, glb: Path, camera: str, folder: Path, *kinds: str) -> dict[str, Any]:
    """What three.js shows and finds."""
    chromium = os.environ.get("ORUSD_CHROMIUM") or shutil.which("chromium")
    if not chromium:
        pytest.skip("no Chromium to show GLB files with (ORUSD_CHROMIUM)")
    job = {
        "modules": str(MODULES),
        "chromium": chromium,
        "glb": str(glb),
        "camera": camera,
        "width": SIZE[0],
        "height": SIZE[1],
        "exposure": 0.01,
        "pictures": {kind: str(folder / f"{kind}.png") for kind in kinds},
        "report": str(folder / "report.json"),
    }
    (folder / "job.json").write_text(json.dumps(job))
    node("viewer.mjs", folder / "job.json")
    return json.loads((folder / "report.json").read_text())  # type: ignore[no-any-return]


def panes(stage: Usd.Stage) -> list[str]:
    """The meshes that are clear panes."""
    found = []
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        material = bound_material(prim) if prim.IsA(UsdGeom.Mesh) else None
        if material and material.GetPrim().GetAttribute(names.MATERIAL_PANE).HasAuthoredValue():
            found.append(str(prim.GetPath()))
    return found


SMALLER = {"compression": "draco", "pictures": "webp"}


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("example", {}),
        ("example", SMALLER),
        *(pytest.param(name, {}, marks=pytest.mark.long) for name in ("kitchen", "bedroom")),
    ],
    ids=str,
)
def test_three_js_shows_the_same_room(
    name: str, options: dict[str, str], scene: Callable[[str], Path], node: Node, tmp_path: Path
) -> None:
    """Each pixel the same prim, and its colour."""
    glb = written(scene(name), tmp_path / "room.glb", **options)
    stage = Usd.Stage.Open(str(scene(name)))
    camera = list_cameras(stage)[0].GetName()
    report = shown(node, glb, camera, tmp_path, "base_color", "ids")
    asked = {"channels": ["base_color", "part"], "resolution": SIZE, "cameras": [camera]}
    view = ou.render(scene(name), tmp_path / "render", **asked)[camera]
    codes = np.round(picture(tmp_path / "ids.png") * 255).astype(int)
    prims = np.array(["", *(mesh["prim"] for mesh in report["meshes"])])
    theirs = prims[codes[..., 0] * 256 + codes[..., 1]]
    legend = read_render(tmp_path / "render").legend("part")
    parts = np.array([legend.get(k, "") for k in range(int(view["part"].max()) + 1)])
    same = theirs == parts[view["part"]]
    # Our labels look through clear panes.
    seen = ~np.isin(theirs, panes(stage))
    assert seen.mean() > 0.8 and same[seen].mean() > 0.99
    color = linear_from_srgb(picture(tmp_path / "base_color.png"))
    off = np.abs(color - view["base_color"])[same]
    print(name, same.mean(), off.mean(), (color - view["base_color"])[same].mean())
    assert off.mean() < 0.03
    assert abs((color - view["base_color"])[same].mean()) < 0.005
