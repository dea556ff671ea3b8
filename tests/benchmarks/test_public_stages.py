"""The look at other people's stages tells pictures, sentences and failures apart."""

from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from pxr import Usd, UsdGeom

from benchmarks import public_stages


@pytest.mark.slow
def test_every_file_with_something_to_draw_is_told_of(tmp_path: Path) -> None:
    folder = tmp_path / "set"
    folder.mkdir()
    good = Usd.Stage.CreateNew(str(folder / "cube.usda"))
    UsdGeom.Cube.Define(good, "/Cube")
    good.Save()
    Usd.Stage.CreateNew(str(folder / "empty.usda")).Save()
    (folder / "broken.usda").write_text("#usda 1.0\ndef Cube {")
    (folder / "notes.txt").write_text("no stage")
    target = tmp_path / "found.json"
    words = [str(folder), "-o", str(tmp_path / "out"), "--spp", "1", "--json", str(target)]
    result = CliRunner().invoke(public_stages.main, words)
    assert result.exit_code == 0, result.output
    assert "| set | 2 | 1 | 1 | 0 | 0 |" in result.output
    assert (tmp_path / "out/sheet_01.png").is_file()


def test_what_ends_oddly_is_a_failure(tmp_path: Path) -> None:
    def outcome(code: int | None, said: str) -> str:
        (tmp_path / "a__b.usda.txt").write_text(said)
        ended: Any = public_stages._ended(tmp_path, "a/b.usda", code, 1.0)
        return str(ended.outcome)

    assert outcome(0, "wrote it") == "picture"
    assert outcome(2, "error: no USD file\n  remedy: export it again") == "one sentence"
    assert outcome(2, "Traceback (most recent call last):") == "failure"
    assert outcome(1, "Traceback") == outcome(-11, "") == "failure"
    assert outcome(None, "") == "out of time"
