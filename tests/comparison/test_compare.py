"""Photographs beside renders: of a room that is its own photograph, and of a real capture."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.capture import CapturedFrame
from openrooms_usd.cli.comparing import compare as command
from openrooms_usd.comparison.driver import Comparison, compare_stage
from openrooms_usd.comparison.photographs import Photographs
from openrooms_usd.composing import compose_room
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError
from openrooms_usd.imagefile import write_png
from openrooms_usd.rendering.contract import RenderRequest
from openrooms_usd.rendering.previews import preview
from openrooms_usd.usd.cameras import PinholeCamera
from orusd_preview import PreviewRenderer
from tests.opening import open_with

# A camera 1.3 m high that looks along +X.
LOOKING = [[0, 0, 1, 0.4], [-1, 0, 0, 1.6], [0, -1, 0, 1.3], [0, 0, 0, 1]]
BOXES = {
    "floor": [[0, 0], [4, 0], [4, 3], [0, 3]],
    "objects": [{"id": "a", "label": "box", "center": [2.8, 1, 0.4], "size": [0.8, 0.8, 0.8]}],
    "frames": [
        {
            "id": "7",
            "picture": "photos/7.png",
            "resolution": [240, 180],
            "K": [[170, 0, 120], [0, 170, 90], [0, 0, 1]],
            "world_from_camera": LOOKING,
        }
    ],
}
ROOM = """\
name: compared
layout: {from: boxes, file: boxes.json}
furniture: {from: boxes, file: boxes.json}
"""
# Middles, sizes and colours: floor, three walls and what stands before them.
BLOCKS = {
    "floor": ((2, 1.5, -0.1), (4.4, 3.4, 0.2), (0.5, 0.3, 0.2)),
    "back": ((4.1, 1.5, 1.3), (0.2, 3.4, 2.6), (0.8, 0.8, 0.8)),
    "left": ((2, 3.1, 1.3), (4.4, 0.2, 2.6), (0.6, 0.7, 0.8)),
    "right": ((2, -0.1, 1.3), (4.4, 0.2, 2.6), (0.8, 0.7, 0.6)),
    "box": ((2.8, 1.0, 0.4), (0.8, 0.8, 0.8), (0.1, 0.3, 0.1)),
}


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_room(tmp_path_factory.mktemp("compare"))


def write_room(folder: Path) -> Path:
    """A folder with a description of boxes, and a stage that another hand made of it."""
    (folder / "boxes.json").write_text(json.dumps(BOXES))
    (folder / "room.yaml").write_text(ROOM)
    (folder / "out").mkdir()
    stage = Usd.Stage.CreateNew(str(folder / "out/scene.usda"))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    prim = UsdGeom.Xform.Define(stage, names.ROOM).GetPrim()
    matrix = prim.CreateAttribute(names.SOURCE_FROM_WORLD, Sdf.ValueTypeNames.Matrix4d)
    matrix.Set(Gf.Matrix4d(1.0))
    for name, (middle, size, color) in BLOCKS.items():
        cube = UsdGeom.Cube.Define(stage, f"{names.ROOM}/{name}")
        cube.CreateSizeAttr(1.0)
        cube.AddTranslateOp().Set(middle)
        cube.AddScaleOp().Set(size)
        cube.CreateDisplayColorAttr([color])
    stage.Save()
    return folder


def compared(room: Path, out: Path, **asked: object) -> Comparison:
    """The room's comparison by the quick renderer."""
    settings = RenderSettings(renderer="preview")
    return compare_stage(room / "out/scene.usda", out, settings, **asked)  # type: ignore[arg-type]


def photographed(room: Path, folder: Path, shift: int) -> Path:
    """A folder in which the room's own picture, shifted to the right, is its photograph."""
    opened = open_with(PreviewRenderer(), Usd.Stage.Open(str(room / "out/scene.usda")))
    frame = BOXES["frames"][0]
    camera = PinholeCamera(np.array(frame["K"], float), np.array(LOOKING, float))
    request = RenderRequest("photograph", ("radiance",), 240, 180, samples=1)
    picture = preview("radiance", opened.picture(camera, request).images["radiance"].pixels).pixels
    (folder / "photos").mkdir(parents=True)
    write_png(folder / "photos/7.png", np.ascontiguousarray(np.roll(picture, shift, axis=1)))
    return folder


def test_a_room_meets_its_own_picture(room: Path, tmp_path: Path) -> None:
    found = compared(room, tmp_path / "out", pictures=photographed(room, tmp_path / "p", 0)).frames[
        0
    ]
    assert found.edges is not None
    assert found.edges.share > 0.85
    assert found.edges.chance < 0.5 * found.edges.share
    assert found.depth is None  # a list of boxes has no points


@pytest.mark.slow
def test_a_shifted_picture_is_told(room: Path, tmp_path: Path) -> None:
    right = compared(room, tmp_path / "a", pictures=photographed(room, tmp_path / "p", 0)).frames[0]
    wrong = compared(room, tmp_path / "b", pictures=photographed(room, tmp_path / "q", 20)).frames[
        0
    ]
    assert right.edges is not None
    assert wrong.edges is not None
    assert wrong.edges.share < 0.6 * right.edges.share


def test_a_missing_photograph_is_named(room: Path, tmp_path: Path) -> None:
    stage = str(room / "out/scene.usda")
    done = CliRunner().invoke(command, [stage, "-o", str(tmp_path / "o"), "--renderer", "preview"])
    assert done.exit_code == 0, done.output
    assert "no photograph" in done.output
    assert "photos/7.png" in done.output
    assert "--photographs" in done.output
    written = {path.name for path in (tmp_path / "o").iterdir() if not path.name.startswith(".")}
    assert written == {"comparison.json", "contact_sheet.png", "frames"}


@pytest.mark.slow
def test_the_same_again_gives_the_same_bytes(room: Path, tmp_path: Path) -> None:
    files = ("comparison.json", "contact_sheet.png", "frames/7.png")
    compared(room, tmp_path / "o")
    first = [(tmp_path / "o" / name).read_bytes() for name in files]
    compared(room, tmp_path / "o")
    assert [(tmp_path / "o" / name).read_bytes() for name in files] == first


def test_what_cannot_be_compared_is_refused(room: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no frame '8'"):
        compared(room, tmp_path / "o", frames=["8"])
    alone = tmp_path / "elsewhere/scene.usda"
    alone.parent.mkdir()
    alone.write_bytes((room / "out/scene.usda").read_bytes())
    with pytest.raises(InputError, match="not beside its folder") as refused:
        compare_stage(alone, tmp_path / "o")
    assert "--description" in str(refused.value)
    assert not (tmp_path / "o").exists()


def test_names_of_pictures_do_not_leave_the_folder(room: Path, tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "secret.png").write_bytes(b"x")
    frame = CapturedFrame("1", np.eye(4), np.eye(3), (4, 4), "../secret.png")
    assert Photographs((frame,), None, (tmp_path / "in",)).file(frame) is None


@pytest.mark.slow
def test_a_real_capture_is_near_its_photographs(
    real: Callable[[str], Path], tmp_path: Path
) -> None:
    """The room's shell alone: walls and floor are where the scan has them, furniture is not."""
    source = real("real_dev/data/arkit_lounge")
    folder = tmp_path / "lounge"
    folder.mkdir()
    (folder / "room.yaml").write_text(f"""\
name: lounge
layout:
  from: scan
  scan: {source}/textured.obj
  options: {{up: "0,1,0", frames: {source}/frames.json}}
furniture: {{from: objects}}
lights: {{environment: {{from: constant, illuminance: 10000}}}}
cameras: {{from: capture, every: 3}}
""")
    compose_room(folder / "room.yaml", folder / "out")
    found = compared(folder, tmp_path / "o", pictures=source, count=6, width=320)
    assert not found.missing
    depths = [frame.depth for frame in found.frames]
    assert all(depth is not None and depth.seen > 0.3 for depth in depths)
    # What stands before the walls is not there: the render is farther, and never much nearer.
    assert min(depth.bias for depth in depths if depth) > -0.05
    # 0.49 was measured with the corrected poses of the photographs.
    assert np.median([depth.right for depth in depths if depth]) > 0.45
