"""The command ``orusd convert``."""

import json

from tests import small
from tests.commands import run


def test_the_command_writes_a_scene_and_says_what_was_lost(tmp_path):
    made = small.Stage(path=tmp_path / "scene.usda")
    made.box("/Box", 1.0)
    made.camera((0, -4, 0), (0, 0, 0))
    made.stage.Save()
    plain = run("convert", tmp_path / "scene.usda", tmp_path / "out")
    assert plain.exit_code == 0
    assert (tmp_path / "out" / "scene.xml").is_file()
    assert "approximated /Box: it has no material: grey is used" in plain.output
    assert "approximated /: the stage has no light" in plain.output
    result = json.loads(
        run("convert", tmp_path / "scene.usda", tmp_path / "again.xml", "--json").output
    )
    assert (result["translated"], result["approximated"], result["skipped"]) == (1, 2, 0)
    assert result["losses"][0]["prim"] == "/Box"


def test_what_cannot_be_converted_is_an_error_for_people(tmp_path):
    missing = run("convert", tmp_path / "nothing.usda", tmp_path / "out")
    assert "no such file" in str(missing.exception)
    (tmp_path / "text.usda").write_text("this is no USD")
    assert "not a readable USD file" in str(
        run("convert", tmp_path / "text.usda", tmp_path).exception
    )
    unknown = run("convert", tmp_path / "text.usda", tmp_path, "--format", "mitsuba4")
    assert not (tmp_path / "scene.xml").exists()
    assert unknown.exit_code != 0
