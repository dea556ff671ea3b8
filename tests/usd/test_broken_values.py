"""What USD or a picture holds and nobody can read is refused with the file's name."""

import os
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd

from openrooms_usd.errors import InputError
from openrooms_usd.library.pictures import write_exr
from openrooms_usd.library.surroundings.environments import read_panorama
from openrooms_usd.rules import validate_stage
from openrooms_usd.usd.files.diagnostics import plain, quiet, reading
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading import textures
from openrooms_usd.validation.licences import licences

READERS: list[Callable[[str], object]] = [
    textures.picture_facts,
    textures.read_texture,
    textures.texture_size,
    textures.color_space,
    read_panorama,
]


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("kind", ["pipe", "device", "folder", "text", "empty", "huge", "nul"])
def test_what_is_no_picture_is_refused(
    reader: Callable[[str], object], kind: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.png"
    match kind:
        case "pipe":
            os.mkfifo(path)
        case "device":
            path.symlink_to("/dev/zero")
        case "folder":
            path.mkdir()
        case "text":
            path.write_bytes(b"no picture \xff\x1b[2J")
        case "empty":
            path.touch()
        case "huge":
            path.write_bytes(_huge_png())
        case "nul":
            path = tmp_path / "a\0.png"
    with quiet(), pytest.raises(InputError) as caught:
        reader(str(path))
    assert "\x1b" not in str(caught.value)


def _huge_png() -> bytes:
    import zlib

    def chunk(name: bytes, data: bytes) -> bytes:
        check = zlib.crc32(name + data)
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", check)

    head = struct.pack(">IIBBBBB", 60_000, 60_000, 8, 6, 0, 0, 0)
    start = b"\x89PNG\r\n\x1a\n"
    return start + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"")) + chunk(b"IEND", b"")


def test_bytes_of_a_picture_that_are_no_text_are_no_crash(tmp_path: Path) -> None:
    path = tmp_path / "a.exr"
    write_exr(path, np.ones((8, 16, 3), np.float32))
    whole = path.read_bytes()
    for place in range(8, 200):
        path.write_bytes(whole[:place] + b"\xff" + whole[place + 1 :])
        try:
            textures.read_texture(str(path))
        except InputError as error:
            assert len(error.message) < 400


def test_an_entry_of_a_package_that_is_a_pipe_or_missing_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.usdz")
    for name in ("a.usdz[b.png]", "none.usdz[b.png]"):
        with pytest.raises(InputError):
            textures.read_texture(str(tmp_path / name))


def write_crate(path: Path, text: str) -> None:
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    world = Sdf.PrimSpec(layer, "World", Sdf.SpecifierDef, "Xform")
    world.assetInfo = {"name": text, "license": text}
    Sdf.AttributeSpec(world, "text", Sdf.ValueTypeNames.String).default = text
    Sdf.AttributeSpec(world, "file", Sdf.ValueTypeNames.Asset).default = Sdf.AssetPath(
        f"{text}.png"
    )
    layer.Export(str(path))


def test_names_in_a_crate_that_are_no_text_name_the_file(tmp_path: Path) -> None:
    path = tmp_path / "a.usdc"
    write_crate(path, "MARKMARK")
    data = path.read_bytes()
    assert b"MARK" in data
    path.write_bytes(data.replace(b"MARK", b"M\xffRK"))
    for read in (validate_stage, lambda file: licences(open_stage(file))):
        try:
            read(path)
        except InputError as error:
            assert str(path) in str(error)


@pytest.mark.parametrize("share", [0.02, 0.2, 0.5, 0.9, 0.99])
def test_a_crate_that_is_cut_off_is_refused(share: float, tmp_path: Path) -> None:
    path = tmp_path / "a.usdc"
    write_crate(path, "some text")
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with quiet(), pytest.raises(InputError, match=r"a\.usdc"):
        validate_stage(path)


def test_what_is_defined_below_an_instance_is_a_warning(tmp_path: Path) -> None:
    (tmp_path / "layers").mkdir()
    (tmp_path / "layers/edits.usda").write_text(
        '#usda 1.0\n(\n  defaultPrim = "World"\n)\n'
        'over "World"\n{\n  over "a"\n  {\n    def "mine"\n    {\n    }\n  }\n}\n'
    )
    (tmp_path / "chair.usda").write_text('#usda 1.0\ndef Xform "c" {\n}\n')
    (tmp_path / "scene.usda").write_text(
        '#usda 1.0\n(\n  defaultPrim = "World"\n  subLayers = [@./layers/edits.usda@]\n'
        '  customLayerData = {\n    string creator = "openrooms_usd"\n  }\n)\n'
        'def Xform "World"\n{\n  def Xform "a" (\n    instanceable = true\n'
        "    references = @./chair.usda@</c>\n  )\n  {\n  }\n}\n"
    )
    codes = {finding.code for finding in validate_stage(tmp_path / "scene.usda")}
    assert "below-instance" in codes


def test_what_usd_says_is_short_and_of_one_line() -> None:
    said = plain("x" * 5000 + "\n\x1b[31m at line 48 in file /opt/USD/pxr/usd/sdf/parser.h : why")
    assert len(said) <= 300 and "\n" not in said and "\x1b" not in said and ".h" not in said


@pytest.mark.parametrize(
    "error", [RecursionError(), UnicodeDecodeError("utf-8", b"\xff", 0, 1, "")]
)
def test_what_values_end_in_names_the_file(error: Exception) -> None:
    with pytest.raises(InputError, match=r"a\.usda"), reading("a.usda"):
        raise error


def test_a_prim_that_is_not_there_names_the_file() -> None:
    stage = Usd.Stage.CreateInMemory()
    with pytest.raises(InputError, match=r"a\.usda"), reading("a.usda"):
        stage.GetPrimAtPath("/none").GetName()


def test_what_is_no_mistake_of_usd_is_not_hidden() -> None:
    with pytest.raises(RuntimeError, match="mine"), reading("a.usda"):
        raise RuntimeError("mine")


@pytest.mark.parametrize("section", ["TOKENS", "STRINGS", "FIELDS", "FIELDSETS", "PATHS", "SPECS"])
@pytest.mark.parametrize("claim", ["start", "length", "count"])
def test_what_a_crate_claims_is_weighed_before_usd_believes_it(
    section: str, claim: str, tmp_path: Path
) -> None:
    path = tmp_path / "a.usdc"
    write_crate(path, "some text")
    assert open_stage(path)
    data = bytearray(path.read_bytes())
    row = data.rindex(section.encode() + b"\0")
    start = struct.unpack_from("<q", data, row + 16)[0]
    struct.pack_into(
        "<q", data, {"start": row + 16, "length": row + 24, "count": start}[claim], 2**50
    )
    path.write_bytes(data)
    with pytest.raises(InputError, match=r"announces|outside"):
        open_stage(path)


def test_a_label_of_another_type_is_no_label(tmp_path: Path) -> None:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    prim = Sdf.PrimSpec(layer, "a", Sdf.SpecifierDef)
    schemas = Sdf.TokenListOp()
    schemas.prependedItems = ["SemanticsLabelsAPI:category"]
    prim.SetInfo("apiSchemas", schemas)
    kind = Sdf.ValueTypeNames.Int
    Sdf.AttributeSpec(prim, "semantics:labels:category", kind).default = 3
    layer.Export(str(tmp_path / "a.usda"))
    assert read_label(open_stage(tmp_path / "a.usda").GetPrimAtPath("/a"), "category") is None


UNKNOWN_TYPE = """#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    upAxis = "Z"
)
def Mesh "World" {
    fl0at3[] extent = [(0, 0, 0), (1, 1, 1)]
    p0int3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
}
"""


def test_values_of_types_that_usd_does_not_know(tmp_path: Path) -> None:
    from openrooms_usd.library.models.meshfile import read_model

    path = tmp_path / "a.usda"
    path.write_text(UNKNOWN_TYPE)
    for read in (lambda: validate_stage(path), lambda: read_model(path)):
        with quiet(), pytest.raises(InputError, match="of a type that USD does not know"):
            read()


def test_a_package_whose_names_are_no_text(tmp_path: Path) -> None:
    (tmp_path / "room.usda").write_text('#usda 1.0\ndef Xform "World" {}\n')
    archive = Sdf.ZipFileWriter.CreateNew(str(tmp_path / "a.usdz"))
    archive.AddFile(str(tmp_path / "room.usda"), "room.usda")
    archive.Save()
    data = (tmp_path / "a.usdz").read_bytes()
    (tmp_path / "a.usdz").write_bytes(data.replace(b"room.usda", b"ro\xf1m.usda"))
    with quiet(), pytest.raises(InputError, match="not UTF-8 text"):
        open_stage(tmp_path / "a.usdz")
