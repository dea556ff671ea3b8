"""``orusd convert``: its options reach the exporter, and mistakes are answered in words."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

import pytest

from openrooms_usd.errors import InputError, OutputError
from tests.commands import output_of, run

STAGE = """\
#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    kilogramsPerUnit = 1
    upAxis = "Z"
)
def Xform "World"
{
    def PhysicsScene "Scene" {}
    def Material "Wax" (prepend apiSchemas = ["PhysicsMaterialAPI"])
    {
        float physics:staticFriction = 0.36
        float physics:dynamicFriction = 0.25
    }
    def Cube "crate" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI",
            "MaterialBindingAPI"]
    )
    {
        double size = 0.2
        float physics:mass = 1
        rel material:binding:physics = </World/Wax>
    }
}
"""


@pytest.fixture
def stage(tmp_path: Path) -> Path:
    path = tmp_path / "crate.usda"
    path.write_text(STAGE)
    return path


def _convert(stage: Path, out: Path, *options: str, to: str = "urdf") -> Any:
    command = ["convert", str(stage), str(out), "--format", to]
    given = [word for option in options for word in ("--option", option)]
    return run(*command, *given)


def _friction(out: Path) -> float:
    tree = ElementTree.parse(out / "objects/crate/crate.urdf")
    (found,) = tree.iter("lateral_friction")
    return float(found.attrib["value"])


@pytest.mark.parametrize(
    ("options", "root"), [((), 0.6), (("friction=static",), 0.6), (("friction=dynamic",), 0.5)]
)
def test_an_option_reaches_the_exporter(
    stage: Path, tmp_path: Path, options: tuple[str, ...], root: float
) -> None:
    result = _convert(stage, tmp_path / "out", *options)
    assert result.exit_code == 0, result.output
    assert _friction(tmp_path / "out") == pytest.approx(root, abs=1e-6)


def test_true_and_false_are_flags(stage: Path, tmp_path: Path) -> None:
    assert _convert(stage, tmp_path / "out", "roots=false", to="usdphysics").exit_code == 0
    refused = _convert(stage, tmp_path / "other", "roots=perhaps", to="usdphysics")
    assert isinstance(refused.exception, InputError)
    assert "true or false" in str(refused.exception.remedy)
    assert not (tmp_path / "other").exists()


@pytest.mark.parametrize("option", ["friction", "friction=", "=dynamic"])
def test_an_option_without_name_or_value_is_refused(
    stage: Path, tmp_path: Path, option: str
) -> None:
    refused = _convert(stage, tmp_path / "out", option)
    assert refused.exit_code == 2
    assert "say NAME=VALUE" in refused.output


def test_an_unknown_option_names_those_there_are(stage: Path, tmp_path: Path) -> None:
    refused = _convert(stage, tmp_path / "out", "frition=dynamic")
    assert isinstance(refused.exception, InputError)
    assert "use friction, package" in str(refused.exception.remedy)


def test_a_moment_of_what_moves(tmp_path: Path) -> None:
    """What copies layers keeps all that moves, and has no moments."""
    moving = STAGE.replace("double size = 0.2", "double size.timeSamples = { 0: 0.2, 10: 0.4 }")
    (tmp_path / "scene.usda").write_text(moving)
    asked = ["convert", str(tmp_path / "scene.usda")]
    for name, code in (("a", "5"), ("b", "10")):
        done = run(*asked, tmp_path / f"{name}.glb", "--time-code", code)
        assert done.exit_code == 0, done.output
    assert (tmp_path / "a.glb").read_bytes() != (tmp_path / "b.glb").read_bytes()
    with pytest.raises(InputError, match="all that moves"):
        output_of(*asked, tmp_path / "a.usdz", "--time-code", "5")
    assert not (tmp_path / "a.usdz").exists()


@pytest.mark.parametrize(
    ("name", "to", "said"),
    [
        *(
            (f"x.{ending}", None, f"no exporter writes .{ending}")
            for ending in ("fbx", "obj", "gltf")
        ),
        ("robot.urdf", "urdf", "the exporter urdf writes a folder"),
        ("scene.xml", "mjcf", "the exporter mjcf writes a folder"),
        ("folder", "gltf", "writes a file that ends in .glb"),
        ("a.usd", "usdz", "writes a file that ends in .usdz"),
        ("a.ply", "mitsuba", "writes a folder or a file that ends in .xml"),
        ("x" * 300, None, "a name in it is longer than 255 bytes"),
        ("x" * 300, "urdf", "a name in it is longer than 255 bytes"),
    ],
)
def test_an_ending_that_is_not_written_is_refused(
    name: str, to: str | None, said: str, stage: Path, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=said):
        output_of("convert", stage, tmp_path / name, *(("--format", to) if to else ()))
    assert [path.name for path in tmp_path.iterdir()] == ["crate.usda"]


def test_a_folder_may_have_a_dot_in_its_name(stage: Path, tmp_path: Path) -> None:
    (tmp_path / "my.room").mkdir()
    for name in ("room_1.5", "my.room"):
        output_of("convert", stage, tmp_path / name)
        assert (tmp_path / name / "scene.xml").is_file()


def test_scenes_in_one_folder_share_nothing(stage: Path, tmp_path: Path) -> None:
    larger = tmp_path / "larger.usda"
    larger.write_text(STAGE.replace("size = 0.2", "size = 0.4"))
    out = tmp_path / "out"
    output_of("convert", stage, out / "a.xml")
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    output_of("convert", larger, out / "b.xml")
    assert {path: path.read_bytes() for path in before} == before
    (mesh,) = (out / "b.meshes").iterdir()
    assert mesh.read_bytes() != (out / "a.meshes" / mesh.name).read_bytes()


def test_another_export_of_the_same_names_is_refused(stage: Path, tmp_path: Path) -> None:
    output_of("convert", stage, tmp_path / "out" / "scene.xml")
    with pytest.raises(OutputError, match="would be replaced"):
        output_of("convert", stage, tmp_path / "out", "--format", "mjcf")


def test_a_smaller_export_leaves_nothing_of_the_larger_one(stage: Path, tmp_path: Path) -> None:
    two = tmp_path / "two.usda"
    two.write_text(STAGE.replace("    def Cube", '    def Cube "other" {}\n    def Cube'))
    out = tmp_path / "out"
    output_of("convert", two, out)
    (out / "scene.meshes/mine.ply").write_text("mine")
    output_of("convert", stage, out)
    assert {path.name for path in (out / "scene.meshes").iterdir()} == {
        "World_crate.ply",
        "mine.ply",
    }


def test_losses_that_say_the_same_are_one_line(tmp_path: Path) -> None:
    suns = "\n".join(f'    def DistantLight "Sun_{number}" {{}}' for number in range(5))
    (tmp_path / "suns.usda").write_text(
        STAGE.replace("    def PhysicsScene", f"{suns}\n    def PhysicsScene")
    )
    said = output_of("convert", tmp_path / "suns.usda", tmp_path / "out").splitlines()
    (line,) = (line for line in said if "shadows are sharp" in line)
    named = "/World/Sun_0, /World/Sun_1, /World/Sun_2 and 2 more"
    assert line.startswith(f"approximated 5 x: {named}: its angle")


def test_the_file_is_named_by_an_option_or_as_second(stage: Path, tmp_path: Path) -> None:
    for words in (("-o", tmp_path / "a.glb"), (tmp_path / "b.glb",)):
        output_of("convert", stage, *words)
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()
    for words in ((), ("-o", tmp_path / "c.glb", tmp_path / "d.glb")):
        done = run("convert", stage, *words)
        assert done.exit_code == 2 and "one file or folder to write: -o OUT" in done.output
