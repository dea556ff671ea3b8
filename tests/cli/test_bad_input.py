"""Bad input and disks that do not take it: one clear message, a code, and nothing half-written."""

import json
import os
import shutil
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.test_importing import WALLS, surface

DESCRIPTION, INPUT, OUTPUT, STAGE, RENDER = 2, 2, 3, 4, 5

# A square whose corners, and nothing else, are given by the test.
POLYGON = "layout: {{polygon: {}}}\n"
SQUARE = "[[0, 0], [4, 0], [4, 3], [0, 3]]"
OBJECTS = "furniture:\n  objects:\n"
COARSE = "materials: {resolution: 16}\n"

FAULTY: dict[str, tuple[str | bytes, tuple[str, ...]]] = {
    "empty": ("", ("1:1", "empty", "orusd init")),
    "truncated": ("layout:\n  polygon: [[0, 0], [4", ("room.yaml:2",)),
    "binary": (bytes(range(256)) * 8, ("room.yaml:2:118", "0x80 is not UTF-8")),
    "huge": (b"# " + b"x" * 70_000_000, ("at most 16 MiB", "right file")),
    "recursive": ("layout: &a\n  polygon: *a\n", ("room.yaml:2",)),
    "bomb": (
        "a: &a [x, x, x, x, x, x, x, x]\n"
        + "".join(f"{c}: &{c} [{', '.join([f'*{p}'] * 9)}]\n" for p, c in pairwise("abcdefgh")),
        ("more than 1,000,000 values",),
    ),
    "deep": (f"layout: {'[' * 5000}\n", ("room.yaml:1",)),
    "tagged": ("layout: !!python/object/apply:os.system ['true']\n", ("room.yaml:1:9",)),
    "crossing": (POLYGON.format("[[0, 0], [4, 3], [4, 0], [0, 3]]"), ("layout.polygon",)),
    "two points": (POLYGON.format("[[0, 0], [4, 0]]"), ("layout.polygon",)),
    "NaN": (POLYGON.format("[[0, 0], [.nan, 0], [4, 3]]"), ("layout.polygon[1][0]",)),
    "infinite": (POLYGON.format("[[0, 0], [.inf, 0], [4, 3]]"), ("layout.polygon[1][0]",)),
    "absurd": ("layout: {height: 1e300}\n", ("layout.height",)),
    "no number": ("cameras: {resolution: [640, many]}\n", ("cameras.resolution[1]", "'many'")),
    "category": (
        f"{OBJECTS}    - {{category: chiar, at: [1, 1]}}\n",
        ("room.yaml:3:18", "did you mean 'chair'?"),
    ),
    "style": (
        f"{OBJECTS}    - {{category: chair, at: [1, 1], style: baroque}}\n",
        ("room.yaml:3:44", "no chair has the style 'baroque'", "known: "),
    ),
    "circle": (
        f"{OBJECTS}    - {{name: a, category: table, at: [1, 1], on: b}}\n"
        "    - {name: b, category: table, at: [1, 1], on: a}\n",
        ("furniture.objects[0].on", "depends on itself"),
    ),
    "wall": (
        f"layout:\n  polygon: {SQUARE}\n  openings: [{{kind: door, wall: 9}}]\n",
        ("there is no wall 9", "0 to 3"),
    ),
    "wide window": (
        f"layout:\n  polygon: {SQUARE}\n  openings: [{{kind: window, wall: 0, width: 9}}]\n",
        ("window_0", "9.000 m wide", "it is free"),
    ),
    "lamp": ("lights: {lamps: {nolamp: {lumen: 3}}}\n", ("lights.lamps.nolamp", "'nolamp'")),
    "no lamp": (
        f"{OBJECTS}    - {{category: chair, at: [1, 1]}}\n{COARSE}"
        "lights: {lamps: {chair_0: {}}}\n",
        ("lights.lamps.chair_0",),
    ),
    "black sky": (
        f"lights: {{environment: {{color: [0, 0, 0], illuminance: 9}}}}\n{COARSE}",
        ("lights.environment.color", "give a brighter color"),
    ),
    "no panorama": (
        f"lights: {{environment: {{file: nosuch.hdr}}}}\n{COARSE}",
        ("nosuch.hdr: no such file", "relative to the folder"),
    ),
    "no capture": (
        "layout: {from: roomplan, file: nosuch.json}\n",
        ("nosuch.json: no such file", "relative to the folder"),
    ),
    "no mesh": (
        f"{OBJECTS}    - {{category: chair, at: [1, 1], file: nosuch.obj}}\n",
        ("nosuch.obj: no such file", "relative to the folder"),
    ),
}


def refuse_to_compose(
    orusd: Callable[..., Any], lab: Any, room: Path, code: int, *fragments: str
) -> None:
    """Refused, and both a new folder and an older composition are as they were."""
    fresh, older = room.parent / "fresh", room.parent / "older"
    shutil.copytree(lab.composed, older)
    before = lab.tree(older)
    orusd("compose", room, "-o", fresh).refused(code, *fragments)
    assert not fresh.exists()
    orusd("compose", room, "-o", older, "--flatten", "--usdz").refused(code, *fragments)
    assert lab.tree(older) == before


@pytest.mark.parametrize("name", FAULTY)
def test_a_description(name: str, orusd: Any, lab: Any, tmp_path: Path) -> None:
    text, fragments = FAULTY[name]
    room = tmp_path / "room.yaml"
    data = text.encode() if isinstance(text, str) else text
    room.write_bytes(data)
    refuse_to_compose(orusd, lab, room, DESCRIPTION, *fragments)


def test_missing_files(orusd: Any, lab: Any, tmp_path: Path) -> None:
    out = tmp_path / "out"
    missing = tmp_path / "nosuch"
    orusd("compose", missing, "-o", out).refused(INPUT, "nosuch: no such file", "orusd init")
    orusd("compose", tmp_path, "-o", out).refused(INPUT, "not a file")
    orusd("validate", missing).refused(INPUT, "nosuch: no such file")
    orusd("render", missing, "-o", out).refused(INPUT, "nosuch: no such file")
    orusd("convert", missing, out).refused(INPUT, "nosuch: no such file")
    orusd("convert", tmp_path, out).refused(INPUT, "not a file")
    orusd("import", "roomplan", missing, "-o", out).refused(INPUT, "no such file")
    assert list(tmp_path.iterdir()) == []


SKY = np.ones((4, 8, 3), np.float32)


def _with(value: float) -> np.ndarray:
    pixels = SKY.copy()
    pixels[1, 2, 1] = value
    return pixels


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("name", "content", "fragment"),
    [
        ("negative.exr", _with(-1), "pixel (2, 1) has G = -1.0, which is not valid radiance"),
        ("infinite.exr", _with(np.inf), "pixel (2, 1) has G = inf, which is not valid radiance"),
        ("nan.exr", _with(np.nan), "pixel (2, 1) has G = nan, which is not valid radiance"),
        ("square.exr", np.ones((4, 4, 3), np.float32), "4 x 4 pixels are not a latitude-longitude"),
        ("bright.exr", np.full((4, 8, 3), 3e38, np.float32), "exceeds the range of floats"),
        ("empty.hdr", b"", "not a picture: the file is empty"),
        ("text.hdr", b"this is a text\n", "not a readable picture"),
        ("binary.exr", bytes(range(256)), "not a readable picture"),
        ("cut.hdr", SKY, "unreadable picture"),
        ("cut.exr", SKY, "picture"),
        (
            "huge.hdr",
            b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 20000 +X 40000\n",
            "not a readable picture",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_panorama(
    name: str, content: Any, fragment: str, orusd: Any, lab: Any, tmp_path: Path
) -> None:
    from openrooms_usd.library.pictures import write_exr

    path = tmp_path / name
    if isinstance(content, bytes):
        path.write_bytes(content)
    elif name.startswith("cut"):
        _write_cut(path)
    else:
        write_exr(path, content)
    room = tmp_path / "room.yaml"
    sky = f"lights: {{environment: {{file: {name}, scale: 10}}}}\n"
    room.write_text(lab.OTHER_ROOM + sky)
    refuse_to_compose(orusd, lab, room, INPUT, f"{name}: ", fragment, "remedy: ")


def _write_cut(path: Path) -> None:
    import OpenImageIO

    pixels = np.random.default_rng(0).random((64, 128, 3), np.float32)
    OpenImageIO.ImageBuf(pixels).write(str(path))
    path.write_bytes(path.read_bytes()[:5000])


@pytest.mark.parametrize(
    ("name", "content", "fragment"),
    [
        ("empty.obj", b"", "no faces with an area"),
        ("nan.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not finite"),
        ("index.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "index.obj"),
        ("far.obj", b"v 0 0 0\nv 1e30 0 0\nv 0 1e30 0\nf 1 2 3\n", "longest side"),
        ("empty.glb", b"", "GLB"),
        ("garbage.glb", b"garbage", "GLB"),
        ("empty.ply", b"", "PLY"),
        ("garbage.usda", b"#usda 1.0\nnonsense{", "not a readable USD file"),
        ("cut.usdc", b"PXR-USDC" + bytes(50), "not a readable USD file"),
        ("text.usdz", b"no zip", "not a complete USDZ archive"),
        ("some.abc", b"", "cannot be read"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_mesh_file(
    name: str, content: bytes, fragment: str, orusd: Any, lab: Any, tmp_path: Path
) -> None:
    (tmp_path / name).write_bytes(content)
    room = tmp_path / "room.yaml"
    room.write_text(lab.OTHER_ROOM.replace("category: chair,", f"category: chair, file: {name},"))
    refuse_to_compose(orusd, lab, room, INPUT, name, fragment, "; ")


def test_steps_alone(orusd: Any, lab: Any, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for step in ("furniture", "materials", "lights", "cameras"):
        said = ("which does not exist yet", "compose the whole room once")
        orusd("compose", lab.room, "-o", out, "--only", step).refused(STAGE, *said)
    orusd("compose", lab.room, "-o", out, "--only", "ligts").refused(2, "--only", "'lights'")
    assert not out.exists()


@pytest.mark.parametrize(
    ("edit", "code", "fragment"),
    [
        ('#usda 1.0\nover "World" (references = @./nosuch.usda@)\n{\n}\n', STAGE, "nosuch.usda"),
        ("#usda 1.0\nnonsense {", INPUT, "edits.usda"),
    ],
    ids=["missing reference", "garbage"],
)
def test_human_edits(
    edit: str, code: int, fragment: str, orusd: Any, lab: Any, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    shutil.copytree(lab.composed, out)
    (out / "layers" / "edits.usda").write_text(edit)
    before = lab.tree(out)
    for _ in range(2):
        orusd("compose", lab.room, "-o", out).refused(code, fragment, "edits.usda", "remedy: ")
        assert lab.tree(out) == before


def _reading(command: str, stage: Path, out: Path, lab: Any) -> list[object]:
    words: dict[str, list[object]] = {
        "validate": ["validate", stage],
        "render": ["render", stage, "-o", out, *lab.QUICK],
        "convert": ["convert", stage, out],
    }
    return words[command]


@pytest.mark.parametrize("command", ["validate", "render", "convert"])
@pytest.mark.parametrize(
    "name", "empty.usda text.usda text.usd cut.usdc tail.usdc text.usdz cut.usdz a.txt".split()
)
def test_an_unreadable_stage(name: str, command: str, orusd: Any, lab: Any, tmp_path: Path) -> None:
    contents = {
        "empty.usda": b"",
        "text.usda": b"#usda 1.0\nnonsense{",
        "cut.usdc": (lab.composed / "scene.usdc").read_bytes()[:2000],
        "tail.usdc": (lab.composed / "scene.usdc").read_bytes()[:-2000],
        "cut.usdz": (lab.composed / "scene.usdz").read_bytes()[:-2000],
    }
    stage, out = tmp_path / name, tmp_path / "out"
    stage.write_bytes(contents.get(name, b"a text"))
    said = "not a complete USDZ archive" if name.endswith("usdz") else "not a readable USD file"
    words = _reading(command, stage, out, lab)
    orusd(*words).refused(INPUT, f"{name}: {said}", "remedy: ")
    orusd(*words, "--json").refused(INPUT, f"{name}: {said}")
    assert [path.name for path in tmp_path.iterdir()] == [name]
    if command != "validate":
        shutil.copytree(lab.rendered if command == "render" else lab.converted, out)
        before = lab.tree(out)
        orusd(*words).refused(INPUT, said)
        assert lab.tree(out) == before


HOLES = """\
#usda 1.0
(
    defaultPrim = "World"
    metersPerUnit = 1
    subLayers = [@./nosub.usda@]
    upAxis = "Z"
)
def Xform "World"
{
    def Xform "Gone" (references = @./nosuch.usda@)
    {
    }
    def Mesh "Spoilt"
    {
        point3f[] points = [(0, 0, nan), (1, 0, 0), (0, 0, 1)]
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
    }
    def Mesh "Wall" (prepend apiSchemas = ["MaterialBindingAPI"])
    {
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 0, 1)]
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        rel material:binding = </World/Paint>
    }
    def Material "Paint"
    {
        token outputs:surface.connect = </World/Paint/Surface.outputs:surface>
        def Shader "Surface"
        {
            uniform token info:id = "UsdPreviewSurface"
            color3f inputs:diffuseColor.connect = </World/Paint/Picture.outputs:rgb>
            token outputs:surface
        }
        def Shader "Picture"
        {
            uniform token info:id = "UsdUVTexture"
            asset inputs:file = @./nosuch.png@
            float3 outputs:rgb
        }
    }
}
"""


@pytest.mark.slow
def test_what_a_stage_lacks_is_reported(orusd: Any, lab: Any, tmp_path: Path) -> None:
    stage, out = tmp_path / "holes.usda", tmp_path / "out"
    stage.write_text(HOLES)
    rendered = orusd(*_reading("render", stage, out, lab), "--json")
    converted = orusd(*_reading("convert", stage, tmp_path / "xml", lab), "--json")
    assert (rendered.code, rendered.err) == (converted.code, converted.err) == (0, "")
    for report in (json.loads(rendered.out)["manifest"]["report"], json.loads(converted.out)):
        lost = {row["prim"]: (row["outcome"], row["reason"]) for row in report["losses"]}
        assert lost["/World/Gone"][0] == lost["/"][0] == lost["/World/Spoilt"][0] == "skipped"
        assert "@./nosuch.usda@" in lost["/World/Gone"][1]
        assert "@./nosub.usda@" in lost["/"][1]
        assert "nosuch.png" in lost["/World/Paint"][1]
    checked = orusd("validate", stage, "--json")
    assert (checked.code, checked.err) == (1, "")
    assert not json.loads(checked.out)["valid"]


@pytest.mark.parametrize(
    ("words", "code", "fragments"),
    [
        ("--camera nosuch", INPUT, ("no camera is named 'nosuch'", "left, right")),
        ("--channels radiance,dept", INPUT, ("'dept'", "did you mean 'depth'?")),
        ("--channels ,", INPUT, ("no channel",)),
        ("--spp 0", INPUT, ("--spp", "must be between")),
        ("--spp many", INPUT, ("--spp", "'many'")),
        ("--spp 4 --target-error 0.1", INPUT, ("--target-error", "samples is already given")),
        ("--target-error nan", INPUT, ("--target-error", "must be between")),
        ("--max-seconds -1", INPUT, ("--max-seconds", "must be between")),
        ("--resolution 0x10", INPUT, ("width: must be between",)),
        ("--resolution 99999x99999", INPUT, ("got 99999",)),
        ("--resolution 30000x30000", INPUT, ("30000x30000 is more than",)),
        ("--resolution big", INPUT, ("640x480",)),
        ("--bounces -1", INPUT, ("--bounces", "must be between")),
        ("--method cache", RENDER, ("scalar_rgb does not have the method 'cache'", "reference")),
        ("--method magic", INPUT, ("--method", "'magic'", "reference")),
        ("--variant vulkan", RENDER, ("'vulkan'", "auto, cuda, llvm, scalar")),
        ("--renderer mitzuba", INPUT, ("did you mean 'mitsuba'?",)),
        ("--nosuch", INPUT, ("--nosuch",)),
        ("--max-seconds nan", INPUT, ("--max-seconds", "must be between")),
        ("--target-error -1", INPUT, ("--target-error", "must be between")),
        ("--seed -1", INPUT, ("seed",)),
    ],
)
def test_render_options(
    words: str, code: int, fragments: tuple[str, ...], orusd: Any, lab: Any, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    said = orusd("render", lab.scene, "-o", out, "--variant", "scalar", *words.split())
    said.refused(code, *fragments)
    assert not out.exists()


def test_other_names(orusd: Any, lab: Any, tmp_path: Path) -> None:
    out = tmp_path / "out"
    orusd("convert", lab.scene, out, "--format", "mitzuba").refused(
        INPUT, "did you mean 'mitsuba'?"
    )
    orusd("import", "roomplna", lab.room, "-o", out).refused(INPUT, "did you mean 'roomplan'?")
    orusd("compsoe").refused(2, "compsoe")
    orusd("compose", lab.room).refused(2, "--out")
    orusd("compose", lab.room, "-o", out, "--workers", "0").refused(2, "--workers")
    assert not out.exists()


def _capture(path: Path) -> Path:
    path.write_text(json.dumps({"walls": [surface(*wall) for wall in WALLS]}))
    return path


@pytest.mark.parametrize(
    ("text", "fragment"),
    [
        (b"", "scan.json:1:1"),
        (b'{"walls": [{"dim', "scan.json:1:13"),
        (bytes(range(256)), "scan.json:1:1"),
        (b"[]", "not a RoomPlan export"),
        (b"{}", "not a RoomPlan export"),
        (b'{"walls": 3}', "walls"),
        (b'{"walls": [{"dimensions": [NaN, 1, 0]}]}', "NaN"),
        (b'{"walls": [{"dimensions": [1e300, 1, 0], "transform": [1]}]}', "walls[0]"),
        (b'{"walls": [{"dimensions": [1, 1, 0], "transform": [1, 2]}]}', "16 numbers expected"),
        (b"[" * 100_000, "nested too deeply"),
        (json.dumps({"walls": [surface(*WALLS[0])]}).encode(), "no floor"),
    ],
)
def test_a_capture(text: bytes, fragment: str, orusd: Any, tmp_path: Path) -> None:
    scan = tmp_path / "scan.json"
    scan.write_bytes(text)
    said = orusd("import", "roomplan", scan, "-o", tmp_path / "out", "--json")
    said.refused(INPUT, "scan.json", fragment, "remedy: ")
    assert [path.name for path in tmp_path.iterdir()] == ["scan.json"]


def _writing(lab: Any, folder: Path) -> dict[str, tuple[list[object], Path | None]]:
    """Every command that writes, its output folder last or left out; and an earlier result."""
    return {
        "init": (["init"], None),
        "import": (["import", "roomplan", _capture(folder / "scan.json"), "-o"], None),
        "compose": (["compose", lab.other, "-o"], lab.composed),
        "package": (["compose", lab.room, "--flatten", "--usdz", "-o"], lab.composed),
        "render": (["render", lab.scene, *lab.QUICK, "--camera", "left", "-o"], lab.rendered),
        "convert": (["convert", lab.scene], lab.converted),
        "demo": (["demo", "--spp", "1", "-o"], None),
    }


COMMANDS = ["init", "import", "compose", "package", "render", "convert", "demo"]


@pytest.mark.parametrize("command", COMMANDS)
def test_an_output_that_cannot_be(command: str, orusd: Any, lab: Any, tmp_path: Path) -> None:
    words, _ = _writing(lab, tmp_path)[command]
    file = tmp_path / "file"
    file.write_text("taken")
    special = [path for path in (Path("/proc"), Path("/sys")) if path.is_dir()]
    for out in (file, *(folder / "out" for folder in (file, *special))):
        orusd(*words, out).refused(OUTPUT, str(out), "cannot write", "remedy: ")
    assert file.read_text() == "taken"


@pytest.mark.parametrize("command", [name for name in COMMANDS if name != "demo"])
def test_a_read_only_disk(command: str, orusd: Any, lab: Any, tmp_path: Path) -> None:
    words, earlier = _writing(lab, tmp_path)[command]
    if os.geteuid() != 0:
        folder = tmp_path / "folder"
        folder.mkdir(mode=0o500)
        orusd(*words, folder / "out").refused(OUTPUT, "Permission denied", "remedy: ")
        return
    with lab.disk(tmp_path / "disk") as disk:
        if earlier:
            shutil.copytree(earlier, disk / "out")
        before = lab.tree(disk)
        if os.system(f"mount -o remount,ro '{disk}'"):
            pytest.skip("remounting is not allowed")
        orusd(*words, disk / "out").refused(OUTPUT, "Read-only file system", "remedy: ")
        assert lab.tree(disk) == before


@pytest.mark.slow
@pytest.mark.parametrize("command", ["init", "import", "compose", "render", "convert"])
def test_a_full_disk(command: str, orusd: Any, lab: Any, tmp_path: Path) -> None:
    """However small the disk is: everything is there, or nothing."""
    words, earlier = _writing(lab, tmp_path)[command]
    refused = 0
    for size in (4, 16, 32, 64, 128, 256, 512, 2048):
        with lab.disk(tmp_path / "disk", f"size={size}k") as disk:
            outcome = orusd(*words, disk / "out")
            if outcome.code == 0:
                break
            refused += 1
            outcome.refused(OUTPUT, str(disk), "remedy: ")
            assert lab.tree(disk) == {}
    assert outcome.code == 0
    assert refused
    if earlier:
        _fill_up(command, orusd, lab, tmp_path)


def _fill_up(command: str, orusd: Any, lab: Any, folder: Path) -> None:
    """The same with an earlier result on a disk that has less and less room beside it."""
    words, earlier = _writing(lab, folder)[command]
    assert earlier
    with lab.disk(folder / "disk", "size=4m") as disk:
        shutil.copytree(earlier, disk / "out")
        before = lab.tree(disk)
        for spare in (0, 8, 40, 80):
            room = shutil.disk_usage(disk).free
            (disk / "ballast").write_bytes(bytes(max(0, room - 1024 * spare)))
            orusd(*words, disk / "out").refused(OUTPUT, "remedy: ")
            (disk / "ballast").unlink()
            assert lab.tree(disk) == before


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("largest", [0, 100, 2000])
def test_a_disk_that_stops_taking_bytes(
    command: str, largest: int, lab: Any, tmp_path: Path
) -> None:
    """In a process whose files may not grow: also USD and OpenImageIO meet it while they write."""
    words, earlier = _writing(lab, tmp_path)[command]
    out = tmp_path / "out"
    if command == "import" and largest == 2000:
        pytest.skip("it needs no more")
    if earlier and largest != 100:
        shutil.copytree(earlier, out)
        (out / "scene.usdc").unlink(missing_ok=True)
    before = lab.tree(out)
    outcome = lab.finish(lab.start(*words, out, largest_file=largest))
    outcome.refused(OUTPUT, str(out), "cannot write", "remedy: ")
    assert lab.tree(out) == before


@pytest.mark.slow
def test_a_disk_that_takes_all_but_the_largest_picture(lab: Any, tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = ("render", lab.scene, *lab.QUICK, "--resolution", "64x48", "-o", out)
    outcome = lab.finish(lab.start(*words, largest_file=30_000))
    outcome.refused(OUTPUT, str(out / "left" / "channels.exr"), "cannot write the picture")
    assert not out.exists()


@pytest.mark.slow
def test_in_a_real_process(lab: Any, tmp_path: Path) -> None:
    out = tmp_path / "out"
    (tmp_path / "room.yaml").write_text("layout: {polygon: [[0, 0], [4, 0]]}\n")
    (tmp_path / "a.usda").write_text("#usda 1.0\nnonsense{")
    commands = (["compose", tmp_path / "room.yaml", "-o", out], ["validate", tmp_path / "a.usda"])
    running = [lab.start(*words, "--json") for words in commands]
    said = [lab.finish(process) for process in running]
    said[0].refused(DESCRIPTION, "room.yaml:1:19", "layout.polygon")
    said[1].refused(INPUT, "a.usda", "parse error at 'nonsense{'", "remedy: ")
    errors = [json.loads(one.out)["error"] for one in said]
    assert [error["code"] for error in errors] == ["description", "input"]
    assert errors[1]["remedy"] and errors[1]["place"].startswith(str(tmp_path / "a.usda"))
    assert not out.exists()
