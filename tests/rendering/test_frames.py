"""Frames of a stage that moves: ranges, folders, and what their renders say."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from openrooms_usd.cli import orusd
from openrooms_usd.errors import InputError
from openrooms_usd.rendering import exr
from openrooms_usd.rendering.frames import frame_folders, frames_of

LIFT = """#usda 1.0
(
    upAxis = "Z"
    metersPerUnit = 1
)
def Cube "Lift"
{
    double size = 2
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 5: (0, 0, 4) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Camera "Above"
{
    float2 clippingRange = (0.01, 100)
    double3 xformOp:translate = (0, 0, 11)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""


@pytest.mark.parametrize(
    ("text", "codes"),
    [
        ("1:4", (1, 2, 3, 4)),
        ("3:3", (3,)),
        ("-2:2:2", (-2, 0, 2)),
        ("0:1:0.3", (0, 0.3, 0.6, 0.9)),
        ("0:0.3:0.1", (0, 0.1, 0.2, 0.3)),
    ],
)
def test_ranges(text: str, codes: tuple[float, ...]) -> None:
    assert frames_of(text) == codes


@pytest.mark.parametrize(
    "text", ["", "5", "4:1", "1:4:0", "1:4:-1", "a:b", "1:2:3:4", "nan:2", "0:1e9", "0:1000000"]
)
def test_what_is_no_range(text: str) -> None:
    with pytest.raises(InputError, match="frames"):
        frames_of(text)


def test_folders_sort_as_their_frames() -> None:
    out = Path("out")
    assert [path.name for path in frame_folders(out, (1.0, 12.0))] == ["frame_0001", "frame_0012"]
    halves = frame_folders(out, (9.5, 10.0))
    assert halves == {out / "frame_0009.5": 9.5, out / "frame_0010.0": 10.0}
    assert len(frame_folders(out, frames_of("0:2:0.001"))) == 2001


def orusd_render(*arguments: object) -> str:
    how = ["--renderer", "preview", "--channels", "depth", "--resolution", "8x6"]
    done = CliRunner().invoke(orusd, ["render", *map(str, arguments), *how])
    if done.exception and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.output


def test_each_frame_is_a_render_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "lift.usda").write_text(LIFT)
    orusd_render(tmp_path / "lift.usda", "-o", tmp_path / "out", "--time-codes", "1:5:2")
    orusd_render(tmp_path / "lift.usda", "-o", tmp_path / "one", "--time-code", 3)
    orusd_render(tmp_path / "lift.usda", "-o", tmp_path / "first")
    depths = {"out/frame_0001": 10.0, "out/frame_0003": 8.0, "out/frame_0005": 6.0}
    depths |= {"one": 8.0, "first": 10.0}
    for folder, depth in depths.items():
        pixels = exr.read_channels(tmp_path / folder / "Above" / "channels.exr")["depth"]
        assert pixels[3, 4] == pytest.approx(depth)
    said = {name: json.loads((tmp_path / name / "manifest.json").read_text()) for name in depths}
    assert said["out/frame_0003"]["time_code"] == said["one"]["time_code"] == 3.0
    assert "time_code" not in said["first"]


@pytest.mark.parametrize(
    ("asked", "answer"),
    [
        (["--time-codes", "1:5", "--time-code", "2"], "there is no --time-code"),
        (["--keep-frames"], "belong to --path"),
        (["--path", "walk", "--time-codes", "1:5"], "--time-codes; --keep-frames"),
        (["--path", "walk", "--f-stop", "2"], "--f-stop"),
        (["--time-code", "soon"], "not a valid float"),
    ],
)
def test_what_does_not_go_together(tmp_path: Path, asked: list[str], answer: str) -> None:
    (tmp_path / "lift.usda").write_text(LIFT)
    assert answer in orusd_render(tmp_path / "lift.usda", "-o", tmp_path / "out", *asked)
    assert not (tmp_path / "out").exists()
