"""`orusd view` on the command line."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from openrooms_usd.cli.viewing import view
from openrooms_usd.errors import InputError
from openrooms_usd.view.room import room_app, room_state
from tests.small import Stage


def test_a_room_is_written_as_a_page(composed_demo: Path, tmp_path: Path) -> None:
    target = tmp_path / "room.html"
    done = CliRunner().invoke(view, [str(composed_demo), "--export", str(target)])
    assert done.exit_code == 0 and str(target) in done.output
    text = target.read_text()
    assert 'data-resource="room.glb"' in text and "traced.png" not in text
    # Nothing of the machine that made it.
    assert str(composed_demo.parent) not in text


def test_any_stage_has_a_page(tmp_path: Path) -> None:
    made = Stage(up="Y", metres=0.01, path=tmp_path / "box.usda")
    made.box("/Box", 100.0)
    made.camera((0, 0, 400), (0, 0, 0), up=(0, 1, 0))
    made.stage.Save()
    state = room_state(tmp_path / "box.usda")
    assert [prim["path"] for prim in state["prims"]] == ["/Box", "/Camera"]
    (camera,) = state["cameras"]
    assert [row[3] for row in camera["world_from_camera"][:3]] == pytest.approx([0, -4, 0])
    assert room_app(tmp_path / "box.usda").resources["room.glb"]()[:4] == b"glTF"


def test_what_is_not_there_is_told(tmp_path: Path) -> None:
    for name in ("room.usda", "scan.ply"):
        with pytest.raises(InputError, match="no such file"):
            CliRunner().invoke(view, [str(tmp_path / name)], catch_exceptions=False)
