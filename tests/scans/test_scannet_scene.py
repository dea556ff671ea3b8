"""A scene of ScanNet that we write ourselves: mesh, labels, alignment, frames and CADs."""

import json
import struct
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.capture import read_capture
from openrooms_usd.errors import InputError
from orusd_scans.scannet.importer import fuse_sens

NAME = "scene0000_00"
# The scan is turned by 30 degrees against the room; alignment turns it back and moves it.
C, S = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
ALIGN = np.array([[C, S, 0, -1.5], [-S, C, 0, 2.0], [0, 0, 1, -0.1], [0, 0, 0, 1.0]])
DEPTH_K = np.array([[60.0, 0, 31.5, 0], [0, 60.0, 23.5, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
COLOR_K = np.array([[120.0, 0, 63.5, 0], [0, 120.0, 47.5, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
SIZE = (64, 48)
# A wall at y = 2.5 m of the scan.
WALL = 2.5


def lattice() -> np.ndarray:
    x, y = np.meshgrid(np.arange(0, 2, 0.02), np.arange(0, 2, 0.02), indexing="ij")
    return np.stack([x.ravel() + 0.005, y.ravel() + 0.005, np.full(x.size, 0.1)], -1)


def scene(folder: Path, points: np.ndarray | None = None) -> Path:
    """A floor; the vertices at x < 1 belong to a chair, those at y > 1.5 beyond to a lamp."""
    folder.mkdir()
    points = lattice() if points is None else points
    n = len(points)
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {n}\n"
    head += "".join(f"property float {a}\n" for a in "xyz")
    row = points.astype("<f4")
    mesh = f"{NAME}_vh_clean_2"
    (folder / f"{mesh}.ply").write_bytes(head.encode() + b"end_header\n" + row.tobytes())
    labels = np.zeros(n, [("p", "<f4", 3), ("label", "<u2")])
    labels["p"], labels["label"] = row, 2
    labelled = head.encode() + b"property ushort label\nend_header\n" + labels.tobytes()
    (folder / f"{mesh}.labels.ply").write_bytes(labelled)
    segments = np.where(points[:, 0] < 1, 100, np.where(points[:, 1] > 1.5, 200, 300))
    data = {"sceneId": NAME, "segIndices": segments.tolist()}
    (folder / f"{mesh}.0.010000.segs.json").write_text(json.dumps(data))
    groups = [
        {"id": 0, "objectId": 0, "segments": [100], "label": "office chair"},
        {"id": 1, "objectId": 4, "segments": [200, 999], "label": "lamp"},
    ]
    (folder / f"{NAME}.aggregation.json").write_text(json.dumps({"segGroups": groups}))
    numbers = " ".join(f"{v:.9f}" for v in ALIGN.ravel())
    (folder / f"{NAME}.txt").write_text(f"axisAlignment = {numbers} \nsceneType = Office\n")
    return folder


def shot(i: int) -> tuple[np.ndarray, np.ndarray]:
    """The pose of a camera that looks along y of the scan, and the wall's depth, millimetres."""
    pose = np.array([[1, 0, 0, 0.1 * i], [0, 0, 1, 0.2 * i], [0, -1, 0, 1.2], [0, 0, 0, 1.0]])
    return pose, np.full(SIZE[::-1], round(1000 * (WALL - 0.2 * i)), "<u2")


def sens(path: Path, coding: int = 1, depth: bytes | None = None, count: int = 5) -> Path:
    out = [struct.pack("<IQ", 4, 3), b"lab", COLOR_K.astype("<f4").tobytes()]
    out += [np.eye(4, dtype="<f4").tobytes(), DEPTH_K.astype("<f4").tobytes()]
    out.append(np.eye(4, dtype="<f4").tobytes())
    out.append(struct.pack("<2i4IfQ", 2, coding, 128, 96, *SIZE, 1000.0, count))
    for i in range(count):
        pose, values = shot(i)
        lost = i == 3
        blob = zlib.compress(values.tobytes()) if coding == 1 else values.tobytes()
        blob = blob if depth is None else depth
        out.append((np.full((4, 4), -np.inf) if lost else pose).astype("<f4").tobytes())
        out.append(struct.pack("<4Q", i, i, 6, len(blob)) + b"\xff\xd8jpeg"[:6] + blob)
    path.write_bytes(b"".join(out))
    return path


def test_a_scene(tmp_path: Path) -> None:
    folder = scene(tmp_path / NAME)
    sens(folder / f"{NAME}.sens")
    capture = read_capture("scannet", folder)
    scan = lattice()
    assert capture.cloud.points == pytest.approx(scan @ ALIGN[:3, :3].T + ALIGN[:3, 3], abs=1e-6)
    assert capture.source_from_world @ ALIGN == pytest.approx(np.eye(4), abs=1e-8)
    chair, lamp = scan[:, 0] < 1, (scan[:, 0] >= 1) & (scan[:, 1] > 1.5)
    assert (capture.cloud.instance == np.where(chair, 1, np.where(lamp, 5, 0))).all()
    assert (capture.cloud.label == 2).all(), "the labelled mesh says more than names do"
    assert [frame.id for frame in capture.frames] == ["0", "1", "2", "4"]
    origin = ALIGN @ [0.1, 0.2, 1.2, 1.0]
    assert capture.frames[1].world_from_camera[:3, 3] == pytest.approx(origin[:3], abs=1e-6)
    assert capture.cloud.sensor_origins[1] == pytest.approx(origin[:3], abs=1e-6)
    assert read_capture("scannet", folder / f"{NAME}_vh_clean_2.ply").cloud.points == pytest.approx(
        capture.cloud.points
    )


@pytest.mark.parametrize(("wrong", "told"), [(1, "1 labels of"), (30, "an old release")])
def test_numbers_that_are_no_classes(tmp_path: Path, wrong: int, told: str) -> None:
    folder = scene(tmp_path / NAME)
    (folder / f"{NAME}.aggregation.json").unlink()
    file = folder / f"{NAME}_vh_clean_2.labels.ply"
    data = bytearray(file.read_bytes())
    for row in range(wrong):
        data[-14 * row - 2 : len(data) - 14 * row] = struct.pack("<H", 1357)
    file.write_bytes(data)
    capture = read_capture("scannet", folder)
    assert told in capture.notes[0]
    if wrong == 1:
        assert np.bincount(capture.cloud.label).tolist() == [1, 0, 9999]
    else:
        assert capture.cloud.label is None


def test_classes_by_name_and_by_table(tmp_path: Path) -> None:
    folder = scene(tmp_path / NAME)
    (folder / f"{NAME}_vh_clean_2.labels.ply").unlink()
    capture = read_capture("scannet", folder)
    instance = capture.cloud.instance
    assert (capture.cloud.label == np.where(instance == 5, 35, 0)).all()
    assert "1 names of objects have no class (such as 'office chair')" in capture.notes[0]
    assert capture.cloud.words == {1: ("office chair",), 5: ("lamp",)}
    table = tmp_path / "labels.tsv"
    table.write_text(
        "id\traw_category\tcategory\tnyu40id\tnyu40class\twnsynsetkey\n"
        "1\toffice chair\tchair\t5\tchair\tswivel_chair.n.01\n"
        "2\tlamp\tlamp\t35\tlamp\t\n3\tnothing\tnone\t\t\t\n"
    )
    capture = read_capture("scannet", folder, {"labels": str(table)})
    assert (capture.cloud.label == np.select([instance == 1, instance == 5], [5, 35])).all()
    assert capture.notes == ()
    assert capture.cloud.words == {
        1: ("office chair", "swivel chair", "chair"),
        5: ("lamp", "lamp"),
    }


@pytest.mark.parametrize("place", [".", "..", "../.."])
@pytest.mark.parametrize("name", ["scannetv2-labels.combined.tsv", "scannet-labels.combined.tsv"])
def test_the_table_of_labels_is_found_by_itself(tmp_path: Path, place: str, name: str) -> None:
    folder = scene(tmp_path / "a") if place == "." else tmp_path / "scans" / NAME
    if place != ".":
        folder.parent.mkdir()
        scene(folder)
    (folder / f"{NAME}_vh_clean_2.labels.ply").unlink()
    (folder / place / name).write_text(
        "id\tcategory\tnyu40id\tnyu40class\n1\toffice chair\t5\tchair\n2\tlamp\t35\tlamp\n"
    )
    capture = read_capture("scannet", folder)
    assert capture.notes == ()
    assert capture.cloud.words == {1: ("office chair", "chair"), 5: ("lamp", "lamp")}
    assert set(np.unique(capture.cloud.label)) == {0, 5, 35}


@pytest.mark.parametrize("ending", [".axisAlignment.txt", "_axis_align_matrix.txt"])
@pytest.mark.parametrize("key", ["axisAlignment = ", ""])
def test_the_axis_alignment_may_stand_in_its_own_file(
    tmp_path: Path, ending: str, key: str
) -> None:
    folder = scene(tmp_path / NAME)
    aligned = read_capture("scannet", folder)
    (folder / f"{NAME}.txt").write_text("sceneType = Office\n")
    numbers = "\n".join(" ".join(f"{v:.9f}" for v in row) for row in ALIGN)
    (folder / f"{NAME}{ending}").write_text(key + (numbers.replace("\n", " ") if key else numbers))
    capture = read_capture("scannet", folder)
    assert capture.notes == ()
    assert capture.cloud.points == pytest.approx(aligned.cloud.points)


@pytest.mark.parametrize("coding", [0, 1])
def test_depth_is_fused_from_the_stream(tmp_path: Path, coding: int) -> None:
    fused = fuse_sens(sens(tmp_path / "a.sens", coding), every=1)
    assert (fused.frames, fused.lost) == (4, 1)
    assert fused.cloud.points[:, 1] == pytest.approx(WALL, abs=1e-3)
    # The middle of the picture looks along the optical axis, up to half a pixel.
    middle = fused.cloud.points[:, [0, 2]].mean(axis=0)
    assert middle == pytest.approx([0.17, 1.2], abs=0.03)
    assert np.abs(fused.cloud.normals[:, 1]).min() > 0.99
    assert fuse_sens(sens(tmp_path / "b.sens"), every=2).frames == 3


def test_a_scene_without_mesh_is_fused_and_aligned(tmp_path: Path) -> None:
    folder = scene(tmp_path / NAME)
    sens(folder / f"{NAME}.sens")
    asked = read_capture("scannet", folder, {"fuse": "1"})
    (folder / f"{NAME}_vh_clean_2.ply").unlink()
    cloud = read_capture("scannet", folder, {"fuse": "1"}).cloud
    assert (cloud.points == asked.cloud.points).all()
    back = (cloud.points - ALIGN[:3, 3]) @ ALIGN[:3, :3]
    assert back[:, 1] == pytest.approx(WALL, abs=1e-3)


@pytest.mark.parametrize(
    ("coding", "depth", "said"),
    [
        (2, None, "packed by a method that is not known"),
        (1, b"no zlib", "is damaged"),
        (1, zlib.compress(bytes(10)), "is not of 6,144 bytes"),
        (0, bytes(7), "is not of 6,144 bytes"),
    ],
)
def test_damaged_depth_is_refused(tmp_path: Path, coding: int, depth: bytes, said: str) -> None:
    with pytest.raises(InputError, match=said):
        fuse_sens(sens(tmp_path / "bad.sens", coding, depth))


def test_depth_that_unfolds_without_end_takes_no_memory(tmp_path: Path) -> None:
    path = sens(tmp_path / "bomb.sens", 1, zlib.compress(bytes(10**7)))
    tracemalloc.start()
    with pytest.raises(InputError, match="is not of 6,144 bytes"):
        fuse_sens(path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 5_000_000


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        ("{n}.txt", "axisAlignment = 1 2 3", "16 numbers expected"),
        ("{n}.txt", "axisAlignment = a b", "not of numbers"),
        ("{n}.txt", "axisAlignment = " + "2 0 0 0 0 2 0 0 0 0 2 0 0 0 0 1", "not a rotation"),
        ("{n}_vh_clean_2.0.010000.segs.json", '{"segIndices": [1, 2]}', "2 vertices have segments"),
        ("{n}_vh_clean_2.0.010000.segs.json", '{"segIndices": ["a"]}', "whole numbers"),
        ("{n}_vh_clean_2.0.010000.segs.json", "{}", "'segIndices' is missing"),
        ("{n}.aggregation.json", '{"segGroups": [{"objectId": 1}]}', "'label' is missing"),
        ("{n}.aggregation.json", '{"segGroups": 5}', "a list expected"),
        ("{n}_vh_clean_2.ply", "", "empty"),
        ("{n}_vh_clean_2.labels.ply", "ply\n", "labels"),
    ],
)
def test_nonsense_in_a_scene_is_refused(tmp_path: Path, file: str, text: str, said: str) -> None:
    folder = scene(tmp_path / NAME)
    (folder / file.format(n=NAME)).write_text(text)
    with pytest.raises(InputError, match=said):
        read_capture("scannet", folder)


def test_what_is_missing_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no mesh"):
        read_capture("scannet", tmp_path)
    with pytest.raises(InputError, match="not a scene"):
        read_capture("scannet", tmp_path / "nothing")
    folder = scene(tmp_path / NAME)
    with pytest.raises(InputError, match=r"no \.sens file"):
        read_capture("scannet", folder, {"fuse": "5"})
    sens(folder / f"{NAME}.sens")
    with pytest.raises(InputError, match="not a number of frames"):
        read_capture("scannet", folder, {"fuse": "0"})
    for path in folder.iterdir():
        if path.suffix in (".json", ".txt") or "labels" in path.name:
            path.unlink()
    capture = read_capture("scannet", folder)
    assert capture.cloud.label is None
    assert any("no axisAlignment" in note for note in capture.notes)
    assert any("no segments and no labels" in note for note in capture.notes)
