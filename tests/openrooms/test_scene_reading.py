"""OpenRooms' scene files: what the released dialect says, and what a hostile one may try."""

from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.cli import main
from openrooms_usd.errors import InputError
from orusd_openrooms.scenes.reading import read_scene
from orusd_openrooms.scenes.records import whole
from orusd_openrooms.scenes.roots import Named, named
from orusd_openrooms.scenes.scene import pose_of
from orusd_openrooms.scenes.sceneobjects import contents
from orusd_openrooms.scenes.standins import material_name, substance_of
from tests.commands import run
from tests.openrooms.scenefiles import (
    CHAIR_SCALE,
    FOV,
    PUSH,
    RADIANCE,
    SNAP,
    UP,
    scene,
    shape,
    write_dataset,
)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "main.xml"
    path.write_text(scene())
    return path


def test_the_released_dialect(file: Path) -> None:
    read = read_scene(file)
    assert (len(read.bsdfs), len(read.shapes), read.notes) == (7, 9, ())
    assert (read.fov, read.resolution) == (FOV, (640, 480))
    assert (read.environment, read.environment_scale) == (f"{UP}EnvDataset/173L.hdr", 1e-8)
    oak, constant = read.bsdfs["03001627_abc_part0"], read.bsdfs["03001627_abc_part1"]
    assert oak.maps["normal"].endswith("Material__wood_oak/tiled/normal_tiled.png")
    assert (oak.uv_scale, oak.albedo_scale, oak.roughness_scale) == (1.3, (1.2, 0.8, 1.0), 0.9)
    assert (constant.maps, constant.albedo, constant.roughness) == ({}, (0.5, 0.4, 0.9), 0.5)
    assert constant.f0 == 0.05
    ids = [one.id for one in read.shapes]
    assert len(set(ids)) < len(ids), "identifiers repeat"
    # The colour of an emitter has no name.
    assert [one.radiance for one in read.shapes if one.radiance] == [RADIANCE]


def test_steps_count_in_their_order_and_fixes_stay_apart(file: Path) -> None:
    chair = read_scene(file).shapes[2]
    assert [step.kind for step in chair.steps] == ["scale", "rotate", *["translate"] * 3]
    c, s = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
    point = np.array([0.25, -0.5, 0.1]) * CHAIR_SCALE
    point = np.array([c * point[0] + s * point[2], point[1], c * point[2] - s * point[0]])
    point = point + np.array([-0.5, -0.63, 0.2]) + np.array(SNAP) + np.array(PUSH)
    assert whole(chair.steps) @ [0.25, -0.5, 0.1, 1.0] == pytest.approx([*point, 1.0])
    pose = pose_of(chair.steps, np.eye(4))
    assert [fix.tolist() for fix in pose.fixes] == [list(SNAP), list(PUSH)]
    assert pose.final == pytest.approx(whole(chair.steps))
    lamp = pose_of(read_scene(file).shapes[5].steps, np.eye(4))
    assert lamp.fixes == () and lamp.measured == pytest.approx(
        whole(read_scene(file).shapes[5].steps)
    )


def test_a_lamp_of_two_shapes_is_one_thing_wherever_they_stand(file: Path) -> None:
    found = contents(read_scene(file).shapes)
    assert found.layout is not None and found.container
    lamps = [item for item in found.members if item.kind == "lamp"]
    assert [(item.number, len(item.files), item.radiance) for item in lamps] == [(5, 2, RADIANCE)]
    assert [
        item.label for item in found.members
    ] == "chair chair table ceiling_lamp door window".split()


@pytest.mark.parametrize(
    "text",
    [
        f"{UP}uv_mapped/a/b.obj",
        "/eccv20/data/uv_mapped/a/b.obj",
        "..\\uv_mapped\\a\\b.obj",
        "uv_mapped/a/b.obj",
    ],
)
def test_paths_count_from_the_dataset_s_folder(text: str) -> None:
    assert named(text, "here") == Named("uv_mapped", "a/b.obj")


@pytest.mark.parametrize(
    "text",
    [
        "../../etc/passwd",
        "uv_mapped/../../x.obj",
        "uv_mapped/a//b",
        "uv_mapped",
        "a\0/uv_mapped/b\0",
        "",
    ],
)
def test_paths_that_leave_the_dataset_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="is not a path into uv_mapped"):
        named(text, "here")


@pytest.mark.parametrize(
    ("name", "substance"),
    [
        ("wood_elm_japanese", "wood"),
        ("parquet_distressed", "wood"),
        ("linen_woven", "fabric"),
        ("carpet_loop", "fabric"),
        ("plastic_dot_grid_subway_plastic_emboss", "plastic"),
        ("gold_leaf", "metal"),
        ("steel_oxidized", "metal"),
        ("roughcast_sprayed", "rough_stone"),
        ("marble_portoro", "specular_stone"),
        ("leather_fine", "leather"),
    ],
)
def test_names_of_materials_say_what_they_are(name: str, substance: str) -> None:
    path = f"{UP}BRDFOriginDataset/Material__{name}/tiled/diffuse_tiled.png"
    assert substance_of(material_name(path)) == substance


def one_shape(steps: str = "", file: str = "uv_mapped/03001627/abc/alignedNew.obj") -> str:
    return scene(shapes=shape("a", file, steps))


LAUGHS = '<!DOCTYPE lolz [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
EXTERNAL = '<!DOCTYPE scene [<!ENTITY x SYSTEM "file:///etc/passwd">]>'
NAN = '<scale x="nan" y="1" z="1"/>'
MALFORMED = {
    "billion laughs": (scene(head=LAUGHS), "declares a DOCTYPE or entities"),
    "external entity": (scene(head=EXTERNAL), "declares a DOCTYPE or entities"),
    "parameter entity": (scene(head=EXTERNAL.replace("ENTITY x", "ENTITY % x")), "DOCTYPE"),
    "undefined entity": (one_shape().replace("verion", "v='&nope;' verion"), "undefined entity"),
    "path out": (one_shape(file="../../../etc/passwd"), "is not a path into"),
    "path out of a folder": (one_shape(file="uv_mapped/../../x.obj"), "is not a path into"),
    "truncated": (scene()[:2000], "is not readable XML"),
    "empty": ("", "is not readable XML"),
    "no XML": ("v 0 0 0\nf 1 2 3\n", "is not readable XML"),
    "another root": ("<mesh/>", "the root element is <mesh>"),
    "no shapes": (scene(shapes=""), "it has no shapes"),
    "1e6 shapes": (f"<scene>{'<shape/>' * 1_000_000}</scene>", "has more than 300,000 elements"),
    "20,000 shapes": (f"<scene>{'<shape/>' * 20_000}</scene>", "20,000 shapes"),
    "deep": ("<scene>" + "<shape>" * 5000 + "</shape>" * 5000 + "</scene>", "nested deeper"),
    "NaN scale": (one_shape(NAN), "nan is not between"),
    "infinite shift": (one_shape('<translate x="inf" y="0" z="0"/>'), "inf is not between"),
    "NaN angle": (one_shape('<rotate angle="nan" x="1"/>'), "nan is not between"),
    "mirrored": (one_shape('<scale x="-1" y="1" z="1"/>'), "factors must be positive"),
    "flat": (one_shape('<scale value="0"/>'), "factors must be positive"),
    "no axis": (one_shape('<rotate angle="30"/>'), "an axis without length"),
    "a matrix": (one_shape('<matrix value="1 0 0 0"/>'), "is not scale, rotate or translate"),
    "text for a number": (one_shape('<translate x="1,5"/>'), "'1,5' is not a number"),
    "a huge number": (one_shape(f'<translate x="{9**400}"/>'), "is not between"),
    "unknown material": (scene().replace('ref id="door_7_part0"', 'ref id="x"'), "no bsdf 'x'"),
    "twice": (
        scene().replace('f id="door_7_part0"', 'f id="03001627_abc_part1"'),
        "is defined twice",
    ),
    "no field of view": (scene().replace(f'value="{FOV}"', 'value="0"'), "a field of view of 0"),
    "two colours": (scene().replace("461.874 452.328 506.107", "1 2"), "is not a colour"),
    "NaN light": (scene().replace("461.874", "nan"), "nan is not between"),
}


@pytest.mark.parametrize("case", MALFORMED)
def test_malformed_files_are_refused(case: str, tmp_path: Path) -> None:
    text, reason = MALFORMED[case]
    path = tmp_path / "main.xml"
    path.write_text(text)
    with pytest.raises(InputError, match=reason) as raised:
        contents(read_scene(path).shapes)
    assert raised.value.remedy


@pytest.mark.parametrize("case", MALFORMED)
def test_nothing_is_written_of_a_malformed_file(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_dataset(tmp_path / "data")
    path.write_text(MALFORMED[case][0])
    room = tmp_path / "room"
    command = ["orusd", "import", "openrooms-xml", str(path), "-o", str(room)]
    monkeypatch.setattr("sys.argv", command)
    with pytest.raises(SystemExit) as ended:
        main()
    said = capsys.readouterr()
    assert ended.value.code not in (0, None)
    assert said.err.startswith("error: ") and "remedy: " in said.err
    assert "Traceback" not in said.err + said.out
    assert not room.exists()


def refusal(path: Path) -> str:
    """How the command refuses a scene, leaving nothing."""
    room = path.parents[3].parent / "room"
    error = run("import", "openrooms-xml", path, "-o", room).exception
    assert isinstance(error, InputError)
    assert not room.exists()
    return str(error)


def test_files_of_the_dataset_may_be_hostile_too(tmp_path: Path) -> None:
    path = write_dataset(tmp_path / "data")
    mesh = tmp_path / "data/uv_mapped/03001627/abc/alignedNew.obj"
    for text, reason in (("v nan 0 0\n" * 3 + "f 1 2 3\n", "not finite"), ("f 1 2 9\n", "OBJ")):
        mesh.write_text(text)
        assert reason in refusal(path)
    (path.parent / "transform.dat").write_bytes(b"cos\nsystem\n(S'true'\ntR.")
    mesh.unlink()
    assert "not a pickle of plain data" in refusal(path)


def test_files_of_the_dataset_have_limits(tmp_path: Path) -> None:
    path = write_dataset(tmp_path / "data")
    (path.parent / "cam.txt").write_text("10001\n" + "0 0 0\n0 0 1\n0 1 0\n" * 10_001)
    assert "10,001 cameras" in refusal(path)
    (path.parent / "cam.txt").unlink()
    mesh = tmp_path / "data/layoutMesh/scene0000_00/uv_mapped.obj"
    for text, reason in (
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\n" * 100_001, "100,001 triangles"),
        ("v 0 0 0\nv 1e6 0 0\nv 0 1 0\nf 1 2 3\n", "not finite"),
        ("v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n", "no level face"),
    ):
        mesh.write_text(text)
        assert reason in refusal(path)


def test_a_link_out_of_the_dataset_is_refused(tmp_path: Path) -> None:
    path = write_dataset(tmp_path / "data")
    secret = tmp_path / "secret.obj"
    secret.write_text("v 0 0 0\n")
    mesh = tmp_path / "data/uv_mapped/03001627/abc/alignedNew.obj"
    mesh.unlink()
    mesh.symlink_to(secret)
    assert "leads out of the folder" in refusal(path)
