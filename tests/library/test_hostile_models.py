"""Models and materials that mean harm, or are damaged: one sentence, at once, without memory."""

import json
import logging
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from openrooms_usd import untrusted
from openrooms_usd.errors import InputError
from openrooms_usd.library.models.meshfile import dependencies, read_model
from openrooms_usd.library.ownmaterials import files_of, read_material
from openrooms_usd.library.pictures import write_png
from openrooms_usd.library.styles.assignment.annotations import read_annotation
from openrooms_usd.scan.models.meshscene import shown_meshes

ENDINGS = (".obj", ".glb", ".ply", ".usd", ".usda", ".usdc", ".usdz")
TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n"


pytestmark = pytest.mark.usefixtures("in_time")


@pytest.mark.parametrize("ending", ENDINGS)
def test_only_regular_files_are_read(tmp_path: Path, ending: str) -> None:
    os.mkfifo(tmp_path / f"pipe{ending}")
    (tmp_path / f"endless{ending}").symlink_to("/dev/zero")
    for name, what in (("pipe", "a pipe"), ("endless", "a device")):
        with pytest.raises(InputError, match=what):
            read_model(tmp_path / f"{name}{ending}")
        assert dependencies(tmp_path / f"{name}{ending}") == []


@pytest.mark.parametrize("ending", ENDINGS)
def test_what_is_too_large_is_not_even_read(
    tmp_path: Path, ending: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for kind in untrusted.MOST_BYTES:
        monkeypatch.setitem(untrusted.MOST_BYTES, kind, 10)
    (tmp_path / f"a{ending}").write_bytes(b"x" * 11)
    with pytest.raises(InputError, match="at most"):
        read_model(tmp_path / f"a{ending}")


@pytest.mark.parametrize("name", ["x" * 300 + ".mtl", "a\0.mtl", "a/" * 3000 + "a.mtl"])
def test_names_that_no_file_has_are_noted(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.obj"
    path.write_text(f"mtllib {name}\n{TRIANGLE}")
    assert any("cannot be the path of a file" in note for note in read_model(path).notes)
    assert dependencies(path) == []
    (tmp_path / "b.mtl").write_text(f"newmtl red\nmap_Kd {name}\n")
    path.write_text(f"mtllib b.mtl\n{TRIANGLE}")
    assert any("cannot be the path of a file" in note for note in read_model(path).notes)
    with pytest.raises(InputError, match="cannot be the path of a file"):
        read_model(tmp_path / ("x" * 300 + ".obj"))


@pytest.mark.parametrize("value", ["Kd nan 0 0", "Ns nan", "d inf", "Kd 1", "Ns", "Kd a b c"])
def test_constants_that_are_no_numbers_are_noted(tmp_path: Path, value: str) -> None:
    (tmp_path / "a.mtl").write_text(f"newmtl red\n{value}\n")
    (tmp_path / "a.obj").write_text(f"mtllib a.mtl\n{TRIANGLE}")
    assert any("is not valid" in note for note in read_model(tmp_path / "a.obj").notes)


def glb(header: dict[str, Any], data: bytes = b"") -> bytes:
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if data:
        chunks += struct.pack("<II", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def boxed() -> tuple[dict[str, Any], bytes]:
    """A box as its description and its data."""
    content = trimesh.Scene(trimesh.creation.box()).export(file_type="glb")
    size = int.from_bytes(content[12:16], "little")
    return json.loads(content[20 : 20 + size]), content[28 + size :]


CLAIMS = {
    "an accessor without data": lambda h: h["accessors"][0].update(count=1 << 40),
    "a count of an accessor": lambda h: h["accessors"][0].update(count=-1),
    "many accessors over one view": lambda h: h["accessors"].extend(
        [{"componentType": 5126, "type": "MAT4", "count": 100_000, "bufferView": 0}] * 1000
    ),
    "many views of one buffer": lambda h: h["bufferViews"].extend(
        [{"buffer": 0, "byteLength": 1 << 20}] * 1000
    ),
    "a stride of nothing": lambda h: h["bufferViews"][0].update(byteStride=0),
    "a node below itself": lambda h: h["nodes"].extend(
        [{"children": [len(h["nodes"]) + 1]}, {"children": [len(h["nodes"])]}]
    ),
    "a node with two parents": lambda h: h["nodes"].extend([{"children": [0]}] * 2),
    "a node below that is not there": lambda h: h["nodes"].append({"children": [999]}),
    "a mesh that is not there": lambda h: h["nodes"].append({"mesh": 999}),
    "one mesh too often": lambda h: h["nodes"].extend([{"mesh": 0}] * 3_000_000),
    "pictures in KTX": lambda h: h.update(extensionsRequired=["KHR_texture_basisu"]),
    "meshes by meshopt": lambda h: h.update(extensionsRequired=["EXT_meshopt_compression"]),
    "lists that are none": lambda h: h.update(nodes=3),
    "extensions that are none": lambda h: h.update(extensionsRequired=[1, None]),
}


@pytest.mark.slow
@pytest.mark.parametrize("claim", sorted(CLAIMS))
def test_what_a_glb_claims_is_weighed(tmp_path: Path, claim: str) -> None:
    header, data = boxed()
    (tmp_path / "good.glb").write_bytes(glb(header, data))
    assert read_model(tmp_path / "good.glb").parts
    CLAIMS[claim](header)
    (tmp_path / "a.glb").write_bytes(glb(header, data))
    with pytest.raises(InputError) as caught:
        read_model(tmp_path / "a.glb")
    assert caught.value.remedy
    assert len(str(caught.value)) < 600


def test_extensions_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    for name in ("KHR_texture_basisu", "EXT_meshopt_compression"):
        (tmp_path / "a.glb").write_bytes(glb({"extensionsRequired": [name]}))
        with pytest.raises(InputError, match=f"it requires {name}"):
            read_model(tmp_path / "a.glb")


def test_indices_beyond_the_points_are_refused(tmp_path: Path) -> None:
    header, data = boxed()
    faces = header["accessors"][header["meshes"][0]["primitives"][0]["indices"]]
    start = header["bufferViews"][faces["bufferView"]].get("byteOffset", 0)
    changed = data[:start] + struct.pack("<I", 4000) + data[start + 4 :]
    (tmp_path / "a.glb").write_bytes(glb(header, changed))
    with pytest.raises(InputError, match="missing vertex"):
        read_model(tmp_path / "a.glb")


def test_a_glb_reads_no_file_beside_it(tmp_path: Path) -> None:
    header, data = boxed()
    (tmp_path / "b.bin").write_bytes(data)
    header["buffers"][0]["uri"] = "b.bin"
    (tmp_path / "a.glb").write_bytes(glb(header))
    with pytest.raises(InputError, match="not a readable GLB file"):
        read_model(tmp_path / "a.glb")


def test_no_library_prints_its_own_traceback(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(InputError):
        shown_meshes(tmp_path / "a.ply", b"ply\nformat ascii 1.0\nelement vertex 99999999999\n")
    logging.getLogger("trimesh").warning("by the way", exc_info=ValueError("secret"))
    assert "Traceback" not in capfd.readouterr().err


def usda(reference: str) -> str:
    return f'#usda 1.0\ndef "A" (references = @{reference}@</B>)\n{{\n    def Cube "C" {{}}\n}}\n'


def test_layers_outside_the_models_folder_are_noted(tmp_path: Path) -> None:
    (tmp_path / "model").mkdir()
    (tmp_path / "b.usda").write_text('#usda 1.0\ndef "B" { def Sphere "S" {\n}\n}\n')
    path = tmp_path / "model" / "a.usda"
    path.write_text(usda("../b.usda"))
    assert "'../b.usda', outside the model's folder, is read, too" in read_model(path).notes
    (tmp_path / "model" / "b.usda").write_text((tmp_path / "b.usda").read_text())
    path.write_text(usda("./b.usda"))
    assert not any("outside" in note for note in read_model(path).notes)


def test_layers_that_are_no_files_are_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.usda")
    (tmp_path / "endless.usda").symlink_to("/dev/zero")
    for name, what in (("pipe.usda", "a pipe"), ("endless.usda", "a device")):
        (tmp_path / "a.usda").write_text(usda(f"./{name}"))
        with pytest.raises(InputError, match=what):
            read_model(tmp_path / "a.usda")


MTLX = '<?xml version="1.0" encoding="{}"?><materialx version="1.39">{}</materialx>'
SHADER = '<standard_surface name="S" type="surfaceshader"/>'
IMAGE = '<image name="I" type="color3"><input name="file" type="filename" value="{}"/></image>'
TEXTURED = (
    '<standard_surface name="S" type="surfaceshader">'
    '<input name="base_color" type="color3" nodename="I"/></standard_surface>'
)


@pytest.mark.parametrize("encoding", ["x", "utf-16", "latin-1", "", "utf-8"])
def test_the_encoding_that_a_materialx_file_states_is_nothing(
    tmp_path: Path, encoding: str
) -> None:
    pytest.importorskip("MaterialX")
    path = tmp_path / "a.mtlx"
    path.write_bytes(MTLX.format(encoding, SHADER + "<!-- caf\xe9 -->").encode("latin-1"))
    try:
        assert read_material(path).name == "a"
    except InputError as error:  # an empty name is no XML
        assert encoding == ""
        assert "readable XML" in str(error)


@pytest.mark.parametrize("name", ["x" * 300 + ".png", "a/" * 3000 + "a.png", "/" + "x" * 300])
def test_pictures_that_no_file_can_be(tmp_path: Path, name: str) -> None:
    pytest.importorskip("MaterialX")
    path = tmp_path / "a.mtlx"
    path.write_text(MTLX.format("utf-8", IMAGE.format(name) + TEXTURED))
    with pytest.raises(InputError, match="pictures of the material cannot be used"):
        read_material(path)
    assert files_of(path) == [path]
    with pytest.raises(InputError, match="cannot be the path of a file"):
        read_material(tmp_path / ("x" * 300))
    with pytest.raises(InputError, match="cannot be the path of a file"):
        files_of(tmp_path / "a\0")


def test_pictures_and_licences_have_a_sensible_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_png(tmp_path / "w_Color.png", np.zeros((4, 4, 3), np.uint8), is_color=True)
    assert read_material(tmp_path).name
    (tmp_path / "LICENSE").symlink_to("/dev/zero")
    assert read_material(tmp_path).name
    monkeypatch.setitem(untrusted.MOST_BYTES, "picture", 10)
    with pytest.raises(InputError, match="at most"):
        read_material(tmp_path)


@pytest.mark.parametrize("text", ["9" * 5000 + " 1", "0 " + "9" * 5000, "# " + "9" * 5000 + "\n0"])
def test_numbers_without_end_in_annotations(tmp_path: Path, text: str) -> None:
    (tmp_path / "ann.txt").write_text(text)
    with pytest.raises(InputError, match="expected the number of a part"):
        read_annotation(tmp_path / "ann.txt")
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match="a pipe"):
        read_annotation(tmp_path / "pipe")
