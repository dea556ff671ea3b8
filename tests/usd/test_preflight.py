"""Files of others are refused with a reason before USD's own parser could end the process."""

import io
import os
import struct
from pathlib import Path

import pytest
from pxr import Sdf, Usd, UsdGeom, Vt

from openrooms_usd.errors import InputError
from openrooms_usd.usd.files import layers, preflight
from openrooms_usd.usd.files.crate_reader import check_crate
from openrooms_usd.usd.files.diagnostics import composition_errors

HEAD = "#usda 1.0\n"
DEEP = 2000


def _prims(depth: int) -> str:
    return HEAD + 'def "a" {\n' * depth + "}\n" * depth


def _dictionaries(depth: int) -> str:
    inner = "dictionary d = {\n" * depth + "}\n" * depth
    return f'{HEAD}def "a" (\ncustomData = {{\n{inner}}}\n) {{\n}}\n'


def _lists(depth: int) -> str:
    return f'{HEAD}def "a" {{\ndouble[] x = {"[" * depth}{"]" * depth}\n}}\n'


def _expression(depth: int) -> str:
    inner = "if(true, " * depth + "'x'" + ")" * depth
    return f"{HEAD}(\nsubLayers = [@`{inner}`@]\n)\n"


NESTED = [_prims, _dictionaries, _lists, _expression]


@pytest.mark.parametrize("make", NESTED)
def test_what_nests_too_deeply_is_refused(make, tmp_path: Path) -> None:
    file = tmp_path / "a.usda"
    for depth in (preflight.MAX_DEPTH + 1, DEEP, 20_000):
        file.write_text(make(depth))
        with pytest.raises(InputError, match="deep"):
            layers.open_stage(file)


def test_as_deep_as_anybody_builds_is_opened(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text(_prims(50))
    assert len(list(layers.open_stage(tmp_path / "a.usda").TraverseAll())) == 50


@pytest.mark.parametrize(
    "literal",
    [
        '"%s"',
        "'%s'",
        '"""%s\n"""',
        "'''%s\n'''",
        '"\\"%s"',
        '"""\\""" " %s"""',
        '""',
        "''",
        '"a" # %s',
        '"a" // %s',
        '"a" /* %s\n*/',
    ],
)
def test_brackets_in_strings_and_comments_nest_nothing(literal: str) -> None:
    text = literal.replace("%s", "([{" * DEEP)
    preflight.check_text(f'{HEAD}def "a" {{\nstring s = {text}\n}}\n'.encode(), "here")
    nested = f"{HEAD}string s = {literal.replace('%s', 'x')}\n{'{' * DEEP}"
    with pytest.raises(InputError, match="deep"):
        preflight.check_text(nested.encode(), "here")


@pytest.mark.usefixtures("in_time")
def test_brackets_side_by_side_nest_nothing_and_take_no_time() -> None:
    """By the square of their number it would take hours."""
    text = f'{HEAD}def "a" {{\nfloat3[] p = [{"(1, 2, 3), " * 1_000_000}]\n}}\n'.encode()
    preflight.check_text(text, "here")


@pytest.mark.usefixtures("in_time")
@pytest.mark.parametrize("opener", [b'"""', b"'''", b"@@@", b"/*", b'"', b"@", b"\\", b"`"])
def test_what_is_never_closed_takes_no_time(opener: bytes) -> None:
    preflight.check_text(HEAD.encode() + (opener + b" ") * 1_000_000, "here")


@pytest.mark.parametrize("place", ["name", "value", "comment", "metadata"])
def test_a_byte_that_is_no_text_is_refused_with_its_line(place: str, tmp_path: Path) -> None:
    rows = {
        "name": b'#usda 1.0\n\ndef "a\xff" {\n}\n',
        "value": b'#usda 1.0\n\ndef "a" { string s = "\xff"\n}\n',
        "comment": b"#usda 1.0\n\n# \xff\n",
        "metadata": b'#usda 1.0\n(\ndoc = "\xff"\n)\n',
    }
    (tmp_path / "a.usda").write_bytes(rows[place])
    with pytest.raises(InputError, match="0xff") as caught:
        layers.open_stage(tmp_path / "a.usda")
    assert str(caught.value.place).endswith("a.usda:3")


ARCS = {
    "sublayer": "(\nsubLayers = [@./b.usda@]\n)\n",
    "reference": 'def "a" (\nreferences = @./b.usda@\n) {\n}\n',
    "payload": 'def "a" (\npayload = @./b.usda@\n) {\n}\n',
    "expression": '(\nexpressionVariables = {\nstring V = "b"\n}\n'
    'subLayers = [@`"./${V}.usda"`@]\n)\n',
    "variant": 'def "a" (\nvariantSets = "v"\nvariants = {\nstring v = "x"\n}\n) {\n'
    'variantSet "v" = {\n"x" (\nreferences = @./b.usda@\n) {\n}\n}\n}\n',
    "clip": 'def "a" (\nclips = {\ndictionary default = {\nasset[] assetPaths = [@./b.usda@]\n'
    "asset manifestAssetPath = @./b.usda@\n}\n}\n) {\n}\n",
}


@pytest.mark.parametrize("arc", ARCS)
@pytest.mark.parametrize("between", [False, True])
def test_what_a_file_refers_to_is_looked_through_too(
    arc: str, between: bool, tmp_path: Path
) -> None:
    (tmp_path / "a.usda").write_text(HEAD + ARCS[arc])
    target = tmp_path / ("c.usda" if between else "b.usda")
    if between:
        (tmp_path / "b.usda").write_text(f"{HEAD}(\nsubLayers = [@./c.usda@]\n)\n")
    target.write_text(_prims(20_000))
    with pytest.raises(InputError, match="deep") as caught:
        layers.open_stage(tmp_path / "a.usda")
    assert str(caught.value.place) == str(target)


@pytest.mark.parametrize("name", ["a.usda", "b.usda"])
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_what_is_no_file_is_not_waited_for(name: str, kind: str, tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text(HEAD + ARCS["reference"])
    (tmp_path / name).unlink(missing_ok=True)
    if kind == "pipe":
        os.mkfifo(tmp_path / name)
    else:
        (tmp_path / name).symlink_to("/dev/zero")
    with pytest.raises(InputError, match="not a file"):
        layers.open_stage(tmp_path / "a.usda")


def test_who_names_a_description_or_a_folder_is_told_the_stage(tmp_path: Path) -> None:
    (tmp_path / "room.yaml").write_text("room: office\n")
    with pytest.raises(InputError, match=r"compose it first: orusd compose .*room\.yaml -o OUT"):
        layers.open_stage(tmp_path / "room.yaml")
    with pytest.raises(InputError, match="give the path of a regular file"):
        layers.open_stage(tmp_path)
    (tmp_path / "scene.usda").write_text(HEAD)
    with pytest.raises(InputError, match=r"remedy: name .*scene\.usda"):
        layers.open_stage(tmp_path)


def test_what_is_missing_is_left_to_usd(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text(HEAD + ARCS["reference"])
    assert composition_errors(layers.open_stage(tmp_path / "a.usda"))


@pytest.mark.parametrize("nested", [False, True])
@pytest.mark.parametrize("at_root", [False, True])
def test_packages_are_looked_through(nested: bool, at_root: bool, tmp_path: Path) -> None:
    deep, root, archive = tmp_path / "b.usda", tmp_path / "a.usda", tmp_path / "x.usdz"
    deep.write_text(_prims(DEEP))
    root.write_text(HEAD + ARCS["reference"])
    files = [deep] if at_root else [root, deep]
    with Sdf.ZipFileWriter.CreateNew(str(archive)) as writer:
        for file in files:
            writer.AddFile(str(file), file.name)
    if nested:
        inner, archive = archive, tmp_path / "y.usdz"
        root.write_text(HEAD + ARCS["reference"].replace("b.usda", "x.usdz"))
        with Sdf.ZipFileWriter.CreateNew(str(archive)) as writer:
            writer.AddFile(str(root), root.name)
            writer.AddFile(str(inner), inner.name)
    with pytest.raises(InputError, match="deep"):
        layers.open_stage(archive)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("depth", [300, 1500])
def test_a_crate_that_nests_too_deeply_is_refused(depth: int, tmp_path: Path) -> None:
    layer = Sdf.Layer.CreateAnonymous(".usdc")
    spec = Sdf.PrimSpec(layer, "a", Sdf.SpecifierDef)
    with Sdf.ChangeBlock():
        for _ in range(depth - 1):
            spec = Sdf.PrimSpec(spec, "a", Sdf.SpecifierDef)
    layer.Export(str(tmp_path / "b.usdc"))
    (tmp_path / "a.usda").write_text(HEAD + ARCS["reference"].replace("b.usda", "b.usdc"))
    for name in ("a.usda", "b.usdc"):
        with pytest.raises(InputError, match="deep"):
            layers.open_stage(tmp_path / name)


def test_a_file_that_changed_is_looked_through_again(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text(HEAD + ARCS["sublayer"])
    (tmp_path / "b.usda").write_text(_prims(3))
    assert len(list(layers.open_stage(tmp_path / "a.usda").TraverseAll())) == 3
    (tmp_path / "b.usda").write_text(_prims(DEEP))
    with pytest.raises(InputError, match="deep"):
        layers.open_stage(tmp_path / "a.usda")


def test_a_stack_of_files_is_looked_through(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text(_prims(DEEP))
    with pytest.raises(InputError, match="deep"):
        layers.stacked_files([tmp_path / "a.usda"])
    target = Sdf.Layer.CreateAnonymous(".usda")
    with (
        pytest.raises(InputError, match="deep"),
        layers.stacked(target, [tmp_path / "a.usda"], []) as stage,
    ):
        assert isinstance(stage, Usd.Stage)


def test_a_sublayer_that_cannot_be_read_is_not_passed_over(tmp_path: Path) -> None:
    """USD goes on without it, and what somebody said there would be gone."""
    (tmp_path / "scene.usda").write_text("#usda 1.0\n(\n subLayers = [@./edits.usda@]\n)\n")
    (tmp_path / "edits.usda").write_text("#usda 1.0\n(\n subLayers = [@./more.usda@]\n)\n")
    layers.open_stage(tmp_path / "scene.usda")  # one that is not there yet is no mistake
    (tmp_path / "more.usda").write_text('#usda 1.0\ndef Xform "a" {\n  int b = oops\n}\n')
    with pytest.raises(InputError, match=r"more\.usda: not a readable USD file"):
        layers.open_stage(tmp_path / "scene.usda")


def test_the_grammar_of_usd_is_not_told(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text('#usda 1.0\ndef Xform "a\n')
    with pytest.raises(InputError) as caught:
        layers.open_stage(tmp_path / "a.usda")
    assert "pegtl" not in str(caught.value)
    assert "a.usda:2:13: parse error" in str(caught.value)


def crate(path: Path, points: int) -> bytes:
    """A mesh of equal points, which pack as well as anything."""
    stage = Usd.Stage.CreateNew(str(path))
    for name in ("A", "B" * 3000):
        mesh = UsdGeom.Mesh.Define(stage, f"/{name}")
        mesh.CreatePointsAttr(Vt.Vec3fArray(points))
        mesh.CreateFaceVertexIndicesAttr(Vt.IntArray(points))
    for number in range(points):
        stage.DefinePrim(f"/P/P{number}", "Xform").SetDocumentation("same")
    stage.Save()
    return path.read_bytes()


def check(data: bytes) -> None:
    check_crate(io.BytesIO(data), len(data), "a.usdc")


@pytest.mark.one_in(9)
@pytest.mark.parametrize("points", [0, 1, 5000])
def test_what_usd_writes_passes(tmp_path: Path, points: int) -> None:
    check(crate(tmp_path / "a.usdc", points))


@pytest.mark.parametrize("name", ["TOKENS", "STRINGS", "FIELDS", "FIELDSETS", "PATHS", "SPECS"])
def test_what_no_section_can_hold_is_refused(tmp_path: Path, name: str) -> None:
    data = bytearray(crate(tmp_path / "a.usdc", 2))
    entry = data.rindex(name.encode().ljust(16, b"\0"))
    (start,) = struct.unpack_from("<q", data, entry + 16)
    struct.pack_into("<Q", data, start, 1 << 30)
    with pytest.raises(InputError, match=f"section {name} announces 1,073,741,824 entries"):
        check(bytes(data))
    struct.pack_into("<q", data, entry + 16, len(data))
    with pytest.raises(InputError, match="outside the file"):
        check(bytes(data))


@pytest.mark.parametrize("length", [8, 20, 60])
def test_what_is_cut_off_is_refused(tmp_path: Path, length: int) -> None:
    data = crate(tmp_path / "a.usdc", 2)
    with pytest.raises(InputError, match="not a readable USD file"):
        check(data[:length])
    check(b"#usda 1.0\n")
