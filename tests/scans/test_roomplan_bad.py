"""What is wrong with a RoomPlan export is said in one message, and nothing is written of it."""

import json
import struct
import zipfile
from pathlib import Path
from typing import Any

import pytest

from openrooms_usd.errors import InputError
from tests.commands import run
from tests.scans.roomplan_usdz import pack, read

CORNERS = [[0, 0], [5, 0], [5, 4], [0, 4]]
HEAD = '#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = "Y"\n)\n'
IDENTITY = "( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1) )"


def refused(path: Path) -> InputError:
    """The error, which the command line says in full, leaving nothing."""
    with pytest.raises(InputError) as error:
        read(path)
    assert path.name in str(error.value.place)
    assert error.value.remedy
    out = path.parent / "out"
    done = run("import", "roomplan", path, "-o", out)
    assert done.exit_code != 0
    assert isinstance(done.exception, InputError)
    assert not out.exists()
    return error.value


def test_what_is_missing_in_an_object_is_named(scanner) -> None:
    for key in ("dimensions", "transform"):
        data = scanner.room(CORNERS, 2.5)
        data["objects"] = [scanner.box("chair", [1, 1, 0.4], [0.5, 0.5, 0.8], 0)]
        del data["objects"][0][key]
        error = refused(scanner.write(data))
        assert f"{key!r} is missing" in str(error)
        assert "objects[0]" in str(error.place)


@pytest.mark.parametrize("word", ["\ud800", "a\x00b", "x" * 5000, "", [1], {"a": {}}])
@pytest.mark.parametrize("key", ["identifier", "category"])
def test_words_that_cannot_be_written_are_named(scanner, key: str, word: Any) -> None:
    if (key, word) == ("category", {"a": {}}):
        return  # how an enumeration is written
    data = scanner.room(CORNERS, 2.5)
    data["objects"] = [scanner.box("chair", [1, 1, 0.4], [0.5, 0.5, 0.8], 0) | {key: word}]
    assert f"objects[0].{key}" in str(refused(scanner.write(data)).place)


def test_objects_without_a_size_are_named(scanner) -> None:
    data = scanner.room(CORNERS, 2.5)
    data["objects"] = [scanner.box("chair", [1, 1, 0.4], [0.5, 0.0, 0.8], 0)]
    assert "a dimension is zero" in str(refused(scanner.write(data)))


def test_curves_of_nonsense_are_named(scanner) -> None:
    data = scanner.room(CORNERS, 2.5)
    for curve in ({"radius": -2}, {"radius": "wide"}, {"radius": 2, "startAngle": {"unit": 3}}):
        data["walls"][0]["curve"] = {"startAngle": 1.0, "endAngle": 2.0} | curve
        assert "walls[0].curve" in str(refused(scanner.write(data)).place)


@pytest.mark.slow
def test_ten_thousand_objects_and_openings_are_read(scanner) -> None:
    data = scanner.room(CORNERS, 2.5)
    chair = scanner.box("chair", [1, 1, 0.4], [0.5, 0.5, 0.8], 0)
    door = scanner.surface("door", [1, 0], [2, 0], 0, 2)
    data["objects"] = [chair | {"identifier": f"{i}"} for i in range(10_000)]
    data["doors"] = [door | {"identifier": f"{i}"} for i in range(2_000)]
    # One over the other: what lies outside the floor would be left out.
    x, y, z = door["transform"][12:15]
    spread = [[*door["transform"][:12], x, y + 3.0 + 3.0 * i, z, 1.0] for i in range(8_000)]
    data["windows"] = [door | {"identifier": f"w{i}", "transform": M} for i, M in enumerate(spread)]
    capture = read(scanner.write(data))
    assert len(capture.boxes) == 10_000
    assert len(capture.openings) == 8_001


def component(geometry: str, category: str = "Chair") -> str:
    return (
        f'{HEAD}def Xform "A" (\n    customData = {{\n        string Category = "{category}"\n'
        f'        string UUID = "u"\n    }}\n)\n{{\n{geometry}\n}}\n'
    )


def cube(matrix: str = IDENTITY, scale: str = "(1, 1, 1)", category: str = "Chair") -> str:
    text = (
        '    def Cube "A"\n    {\n        double size = 1\n'
        f"        double3 xformOp:scale = {scale}\n"
        f"        matrix4d xformOp:transform = {matrix}\n"
        '        uniform token[] xformOpOrder = ["xformOp:transform", "xformOp:scale"]\n    }'
    )
    return component(text, category)


BAD_LAYERS = {
    "no geometry": (component(""), "neither a cube nor a mesh"),
    "by rows": (cube("( (1, 0, 0, 5), (0, 1, 0, 1), (0, 0, 1, 2), (0, 0, 0, 1) )"), "row by row"),
    "left-handed": (cube(scale="(1, 1, -1)"), "left-handed"),
    "sheared": (cube("( (1, 0, 0, 0), (0.6, 0.8, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1) )"), "shears"),
    "NaN": (cube("( (nan, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1) )"), "out of range"),
    "far": (cube("( (1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (1e30, 0, 0, 1) )"), "out of range"),
    "zero": (cube(scale="(1, 0, 1)"), "a dimension is zero"),
    "other operation": (
        cube().replace('"xformOp:scale"]', '"xformOp:rotateX"]'),
        "xformOp:rotateX is not a transform",
    ),
    "a size in words": (cube().replace("double size = 1", 'string size = "big"'), "another type"),
    "Z up": (cube().replace('"Y"', '"Z"'), "the up axis is Z"),
    "centimetres": (cube().replace("metersPerUnit = 1", "metersPerUnit = 0.01"), "0.01 m"),
    "a floor of nothing": (component('    def Mesh "A"\n    {\n    }', "Floor"), "no valid points"),
    "a floor of one edge": (
        component(
            '    def Mesh "A"\n    {\n        int[] faceVertexCounts = [3]\n'
            "        int[] faceVertexIndices = [0, 1, 7]\n"
            "        point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]\n    }",
            "Floor",
        ),
        "not a flat polygon",
    ),
    "no category": (f'{HEAD}def Xform "Room"\n{{\n}}\n', "not an export of RoomPlan"),
    "no USD": ("#usda 1.0\ndef Xform {{{", "not readable as USD"),
    "text": ("hello", "not readable as USD"),
}


@pytest.mark.parametrize("name", BAD_LAYERS)
def test_layers_of_nonsense_are_named(tmp_path: Path, name: str) -> None:
    layer, message = BAD_LAYERS[name]
    suffix = "usdc" if name == "text" else "usda"
    assert message in str(refused(pack(tmp_path / "Room.usdz", {f"A.{suffix}": layer})))


def test_words_and_sections_of_nonsense_are_named(tmp_path: Path) -> None:
    for word in ("x" * 3000, "a\\nb"):
        path = pack(tmp_path / "Room.usdz", {"A.usda": cube(category=word)})
        assert "A.usda" in str(refused(path).place)
    section = """#usda 1.0
def Xform "Section_grp"
{
    def Xform "livingRoom0"
    {
        string xformOp:transform = "x"
        uniform token[] xformOpOrder = ["xformOp:transform"]
    }
}
"""
    path = pack(tmp_path / "Room.usdz", {"A.usda": section})
    assert "livingRoom0" in str(refused(path).place)


def test_archives_that_are_none_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "Room.usdz"
    path.write_bytes(b"")
    assert "archive is damaged" in str(refused(path))
    whole = pack(tmp_path / "whole.usdz", {"A.usda": cube()}).read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    assert "archive is damaged" in str(refused(path))
    broken = bytearray(whole)
    broken[60] ^= 0xFF  # in the layer: its checksum does not hold
    path.write_bytes(bytes(broken))
    assert "archive is damaged" in str(refused(path))
    assert "no USD layers" in str(refused(pack(path, {"a.png": b"x"})))
    with pytest.raises(InputError, match="no such file"):
        read(tmp_path / "none.usdz")


def test_archives_that_would_harm_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "Room.usdz"
    for name in ("../A.usda", "/A.usda", "a/../../A.usda"):
        assert "would leave its folder" in str(refused(pack(path, {name: cube()})))
    bomb = {f"{i}.usda": b"#" * (1 << 23) for i in range(9)}
    pack(path, bomb, compression=zipfile.ZIP_DEFLATED)
    assert path.stat().st_size < 1 << 20
    assert "too much for a capture" in str(refused(path))
    data = bytearray(pack(path, {"A.usda": cube()}).read_bytes())
    for signature, at in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        start = data.index(signature) + at
        data[start : start + 2] = struct.pack("<H", 1)
    path.write_bytes(bytes(data))
    assert "is encrypted" in str(refused(path))


def test_an_archive_that_lies_about_its_sizes_is_refused(tmp_path: Path) -> None:
    path = pack(tmp_path / "Room.usdz", {"A.usda": b"#" * 100_000}, compression=8)
    data = bytearray(path.read_bytes())
    for signature, at in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        start = data.index(signature) + at
        data[start : start + 4] = struct.pack("<I", 100)
    path.write_bytes(bytes(data))
    assert "archive is damaged" in str(refused(path))


def test_unknown_categories_are_kept(scanner) -> None:
    data = scanner.room(CORNERS, 2.5)
    data["objects"] = [scanner.box("grand piano", [2, 2, 0.5], [1.5, 1.4, 1.0], 0)]
    assert json.dumps(read(scanner.write(data)).boxes[0].label) == '"grand piano"'
