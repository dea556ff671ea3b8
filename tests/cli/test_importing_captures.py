"""`orusd import` of Scan2CAD and of boxes, whole or not at all."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.capture import read_capture
from openrooms_usd.description import load_room
from openrooms_usd.errors import InputError, OutputError
from tests.commands import run

TETRAHEDRON = """mtllib model_normalized.mtl
v -0.3 -0.4 -0.2
v 0.3 -0.4 -0.2
v 0 -0.4 0.2
v 0 0.4 0
usemtl wood
f 1 2 3
f 1 4 2
f 2 4 3
f 3 4 1
"""
IDENTITY = {"translation": [0, 0, 0], "rotation": [1, 0, 0, 0], "scale": [1, 1, 1]}
# Y up to Z up: the scan stands upright in a world with Y up.
SCAN = {**IDENTITY, "rotation": [0.5**0.5, -(0.5**0.5), 0, 0]}


def annotation(scan: str = "scene0001_00") -> dict[str, Any]:
    def model(cad: str, x: float) -> dict[str, Any]:
        return {
            "trs": {**IDENTITY, "translation": [x, 0.4, -2.0], "scale": [1.0, 1.5, 1.0]},
            "bbox": [0.3, 0.4, 0.2],
            "center": [0, 0, 0],
            "sym": "__SYM_NONE",
            "catid_cad": "03001627",
            "id_cad": cad,
        }

    models = [model("here", 1.0), model("missing", 2.0), model("here", 3.0)]
    return {"id_scan": scan, "trs": SCAN, "aligned_models": models}


@pytest.fixture
def scan2cad(tmp_path: Path) -> tuple[object, ...]:
    source = tmp_path / "data"
    for cad in ("here", "unused"):
        folder = source / "shapenet/03001627" / cad
        (folder / "models").mkdir(parents=True)
        (folder / "models/model_normalized.obj").write_text(TETRAHEDRON)
        (folder / "models/model_normalized.mtl").write_text("newmtl wood\nKd 0.5 0.3 0.1\n")
        (folder / "models/model_normalized.solid.binvox").write_text("large")
    entries = [annotation("scene0000_00"), annotation()]
    (source / "full_annotations.json").write_text(json.dumps(entries))
    floor = {"floor": [[0, 0], [4, 0], [4, 3], [0, 3]], "level": 0.0}
    (source / "floor.json").write_text(json.dumps(floor))
    K = [[500, 0, 320], [0, 500, 240], [0, 0, 1]]
    pose = [[1, 0, 0, 2], [0, 0, 1, 0.5], [0, -1, 0, 1.4], [0, 0, 0, 1]]
    frames = [
        {"id": i, "world_from_camera": pose, "K": K, "resolution": [640, 480]} for i in (4, 8)
    ]
    (source / "cameras.json").write_text(json.dumps(frames))
    return (
        "scan2cad",
        source / "full_annotations.json",
        "--scan",
        "scene0001_00",
        "--models",
        source / "shapenet",
        "--polygon",
        source / "floor.json",
        "--frames",
        source / "cameras.json",
    )


def test_only_what_the_scan_needs_is_copied_and_reads_the_same(scan2cad, tmp_path) -> None:
    out = tmp_path / "room"
    result = run("import", *scan2cad, "-o", out, "--json")
    assert result.exit_code == 0, result.output
    report = json.loads(result.output)
    assert (report["objects"], report["models"], report["frames"]) == (3, 2, 2)
    assert any("missing" in note for note in report["notes"])
    here = "models/03001627/here/models/model_normalized"
    assert sorted(p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file()) == [
        "floor.json",
        "frames.json",
        f"{here}.mtl",
        f"{here}.obj",
        "room.yaml",
        "scene0001_00.json",
    ]
    assert str(tmp_path) not in "".join(p.read_text() for p in out.rglob("*.*") if p.is_file())
    section = load_room(out / "room.yaml").furniture
    copied = read_capture(section.reader, out / section.file, section.options, out)
    given = dict(zip(scan2cad[2::2], scan2cad[3::2], strict=True))
    options = {str(name)[2:]: str(value) for name, value in given.items()}
    source = read_capture("scan2cad", scan2cad[1], options)
    assert [model.id for model in copied.models] == [model.id for model in source.models]
    for one, other in zip(copied.models, source.models, strict=True):
        assert one.world_from_model == pytest.approx(other.world_from_model)
    for one, other in zip(copied.frames, source.frames, strict=True):
        assert one.world_from_camera == pytest.approx(other.world_from_camera)
        assert (one.id, one.resolution) == (other.id, other.resolution)
    assert np.array_equal(copied.floor, source.floor)


def test_the_cameras_of_the_photographs_are_taken(scan2cad, tmp_path) -> None:
    run("import", *scan2cad, "-o", tmp_path / "room")
    room = load_room(tmp_path / "room/room.yaml")
    (view,) = room.cameras.views
    assert (view.source, view.every, room.cameras.resolution) == ("capture", 1, None)


def test_without_a_polygon_the_remedy_is_named(scan2cad, tmp_path) -> None:
    given = [word for word in scan2cad if "floor" not in str(word) and word != "--polygon"]
    result = run("import", *given, "-o", tmp_path / "room")
    assert isinstance(result.exception, InputError)
    assert "--polygon FILE" in str(result.exception)
    assert not (tmp_path / "room").exists()


def test_an_unknown_scan_is_told_the_nearest(scan2cad, tmp_path) -> None:
    given = ["scene0001_01" if word == "scene0001_00" else word for word in scan2cad]
    result = run("import", *given, "-o", tmp_path / "room")
    assert isinstance(result.exception, InputError)
    assert "scene0001_00" in str(result.exception)
    assert not (tmp_path / "room").exists()


def test_another_file_of_that_name_is_not_overwritten(scan2cad, tmp_path) -> None:
    (tmp_path / "room").mkdir()
    (tmp_path / "room/floor.json").write_text("mine")
    result = run("import", *scan2cad, "-o", tmp_path / "room")
    assert isinstance(result.exception, OutputError)
    assert [path.name for path in (tmp_path / "room").iterdir()] == ["floor.json"]
    assert (tmp_path / "room/floor.json").read_text() == "mine"


@pytest.mark.parametrize("scan", ["../../evil", "/evil", "a/b", ""])
def test_a_scan_whose_name_is_a_path_writes_nothing(scan2cad, tmp_path: Path, scan: str) -> None:
    annotations = tmp_path / "one.json"
    annotations.write_text(json.dumps([annotation(scan)]))
    before = sorted(tmp_path.rglob("*"))
    result = run("import", "scan2cad", annotations, *scan2cad[6:8], "-o", tmp_path / "a/b/room")
    assert isinstance(result.exception, InputError)
    assert "id_scan" in str(result.exception)
    assert sorted(tmp_path.rglob("*")) == before


def test_a_number_out_of_range_that_nobody_reads_is_named(scan2cad, tmp_path: Path) -> None:
    annotations = tmp_path / "one.json"
    data = json.dumps([{**annotation(), "keypoints": 1}])
    annotations.write_text(data.replace('"keypoints": 1', '"keypoints": 1e999'))
    result = run("import", "scan2cad", annotations, *scan2cad[6:8], "-o", tmp_path / "room")
    assert isinstance(result.exception, InputError)
    assert "out of range" in str(result.exception)
    assert not (tmp_path / "room").exists()


def test_a_file_that_would_take_the_place_of_the_room_is_refused(tmp_path: Path) -> None:
    boxes = tmp_path / "boxes.csv"
    boxes.write_text("label,x,y,z,width,depth,height\nchair,1,1,0,0.5,0.5,0.9\n")
    (tmp_path / "room.yaml").write_text('{"floor": [[0, 0], [3, 0], [3, 3], [0, 3]]}')
    given = ("boxes", boxes, "--polygon", tmp_path / "room.yaml")
    result = run("import", *given, "-o", tmp_path / "room")
    assert isinstance(result.exception, InputError)
    assert "another name" in str(result.exception)
    assert not (tmp_path / "room").exists()


def test_help_lists_the_options_of_an_importer() -> None:
    text = run("import", "scan2cad", "--help").output
    for name in ("--scan", "--models", "--frames", "--polygon"):
        assert name in text


HEADER = "id,label,x,y,z,width,depth,height,yaw\n"
BAD = {
    "a missing column": "id,label,x,y\na,chair,1,2\n",
    "a number is not finite": HEADER + "a,chair,nan,2,0,1,1,1,0\n",
    "a side of zero": HEADER + "a,chair,1,2,0,0,1,1,0\n",
    "an id twice": HEADER + "a,chair,1,2,0,1,1,1,0\na,chair,3,2,0,1,1,1,0\n",
    "nothing": "",
}


@pytest.mark.parametrize("name", BAD)
def test_bad_tables_leave_nothing(tmp_path: Path, name: str) -> None:
    path = tmp_path / "boxes.csv"
    path.write_text(BAD[name])
    result = run("import", "boxes", path, "-o", tmp_path / "room")
    assert isinstance(result.exception, InputError), result.output
    assert str(path) in str(result.exception)
    assert result.exit_code != 0
    assert [p.name for p in tmp_path.iterdir()] == ["boxes.csv"]


def test_a_table_becomes_a_room(tmp_path: Path) -> None:
    path = tmp_path / "boxes.csv"
    path.write_text(HEADER + "a,chair,100,200,0,50,50,90,30\nb,gizmo,300,100,0,90,40,70,0\n")
    result = run("import", "boxes", path, "--unit", "cm", "-o", tmp_path / "room")
    assert result.exit_code == 0, result.output
    room = load_room(tmp_path / "room/room.yaml")
    assert room.layout.options == {"unit": "cm"}
    assert "no floor is given" in result.output
