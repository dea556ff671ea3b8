"""What people add themselves, in ``edits.usda``: our rules advise there, and break on nothing."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from openrooms_usd.cli.validating import validate
from openrooms_usd.composing import compose_room
from openrooms_usd.rules import validate_stage
from openrooms_usd.validation.model import Finding

ROOM = """\
layout: {}
furniture:
  objects:
    - {name: chair_a, category: chair, at: [1, 1]}
    - {name: chair_b, category: chair, at: [2, 1]}
    - {category: floor_lamp, at: [3, 2]}
materials: {resolution: 16}
"""
MESH = """def Mesh "{name}" {{
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 0, 1)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    float3[] extent = [(0, 0, 0), (1, 0, 1)]
    uniform token subdivisionScheme = "none"
}}
"""
HEAD = '#usda 1.0\n(\n defaultPrim = "root"\n metersPerUnit = 1\n upAxis = "Z"\n)\n'


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("room")
    (folder / "room.yaml").write_text(ROOM)
    return compose_room(folder / "room.yaml", folder / "out", workers=1).scene


def findings(scene: Path, body: str) -> list[Finding]:
    edits = scene.parent / "layers" / "edits.usda"
    before = edits.read_text()
    try:
        edits.write_text(before.rstrip() + "\n" + body)
        rc = CliRunner().invoke(validate, [str(scene)], catch_exceptions=False).exit_code
        found = validate_stage(scene)
    finally:
        edits.write_text(before)
    assert rc == any(finding.severity == "error" for finding in found)
    return found


def test_the_room_itself_is_clean(room: Path) -> None:
    assert findings(room, "") == []


def test_a_mesh_of_their_own_without_label_and_material_is_no_error(room: Path) -> None:
    found = findings(room, 'over "World" {\n' + MESH.format(name="Statue") + "}\n")
    assert {(f.severity, f.code, f.place) for f in found} == {
        ("warning", "label", "/World/Statue"),
        ("warning", "material", "/World/Statue"),
    }


@pytest.mark.parametrize("arc", ["references", "payload"])
@pytest.mark.parametrize("instance", ["true", "false"])
def test_nor_is_what_they_refer_to(room: Path, arc: str, instance: str) -> None:
    """Its prims are defined by the file that is referred to, and it is theirs nonetheless."""
    props = room.parent / "props"
    props.mkdir(exist_ok=True)
    asset = HEAD + 'def Xform "root" {\n' + MESH.format(name="mesh") + "}\n"
    (props / "statue.usda").write_text(asset)
    head = f"prepend {arc} = @../props/statue.usda@\n instanceable = {instance}"
    found = findings(room, f'over "World" {{\n def Xform "Statue" ({head}) {{\n }}\n}}\n')
    assert {(f.severity, f.code, f.place) for f in found} == {
        ("warning", "label", "/World/Statue/mesh"),
        ("warning", "material", "/World/Statue/mesh"),
    }


def test_a_prim_defined_below_an_instance_is_named_as_lost(room: Path) -> None:
    below = 'over "chair_a" {\n' + MESH.format(name="Bow") + "}\n"
    found = findings(room, 'over "World" {\n over "Furniture" {\n' + below + "}\n}\n")
    assert [(f.code, f.place) for f in found] == [
        ("below-instance", "/World/Furniture/chair_a/Bow")
    ]


def test_what_they_take_from_our_own_prims_stays_an_error(room: Path) -> None:
    found = findings(
        room,
        'over "World" {\n over "Room" {\n over "Floor" (\n'
        ' delete apiSchemas = ["SemanticsLabelsAPI:category"]) {\n'
        " token[] semantics:labels:category = None\n }\n }\n}\n",
    )
    assert ("error", "label") in {(f.severity, f.code) for f in found}


@pytest.mark.parametrize("taxonomy", ["category", "class"])
def test_words_of_others_are_labels(room: Path, taxonomy: str) -> None:
    schema = f' (prepend apiSchemas = ["SemanticsLabelsAPI:{taxonomy}"]) {{\n'
    said = f'    token[] semantics:labels:{taxonomy} = ["statue"]\n'
    mesh = MESH.format(name="Statue").replace(" {\n", schema + said, 1)
    found = findings(room, f'over "World" {{\n{mesh}}}\n')
    assert "label" not in {finding.code for finding in found}


def test_names_of_old_lights_are_told(room: Path) -> None:
    lamp = 'over "World" {\n def SphereLight "Old" {\n float intensity = 100\n }\n}\n'
    said = [(f.code, f.message) for f in findings(room, lamp) if f.place == "/World/Old"]
    assert ("plausible", "USD ignores these names of before 21.02: intensity") in said
