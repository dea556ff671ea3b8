"""Scan2CAD annotations of CADs whose places are known, and a real one."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.capture import Capture, read_capture
from openrooms_usd.errors import InputError

CHAIR, TABLE = "03001627", "04379243"
FLOOR = [[1.0, 2.0], [5.0, 2.0], [5.0, 5.0], [1.0, 5.0]]


def trs(translation: Any, rotation: Rotation, scale: Any = (1, 1, 1)) -> dict[str, Any]:
    x, y, z, w = rotation.as_quat()
    return {
        "translation": list(map(float, translation)),
        "rotation": [float(q) for q in (w, x, y, z)],
        "scale": list(map(float, scale)),
    }


def matrix(translation: Any, rotation: Rotation, scale: Any = (1, 1, 1)) -> np.ndarray:
    M = np.eye(4)
    M[:3, :3] = rotation.as_matrix() * np.asarray(scale, dtype=float)
    M[:3, 3] = translation
    return M


SCAN = ([-1.7, -0.68, 1.4], Rotation.from_euler("x", -90, degrees=True))
TILTED = Rotation.from_euler("zyx", [2, 70, 1], True)
CADS = [
    (CHAIR, "chairone", ([0.5, -0.4, 0.9], TILTED, (1.4, 1.2, 1.5))),
    (CHAIR, "chairone", ([-0.5, -0.4, 0.3], Rotation.from_euler("y", 190, True), (1.2, 1.1, 1.3))),
    (TABLE, "tabletwo", ([0.1, -0.4, 0.0], Rotation.from_euler("y", 20, True), (2.0, 0.9, 1.1))),
]


def annotation(**more: Any) -> dict[str, Any]:
    models = [
        {
            "trs": trs(*placed),
            "bbox": [0.3, 0.4, 0.25],
            "center": [0.01, 0.02, -0.03],
            "sym": "__SYM_ROTATE_UP_2",
            "catid_cad": catid,
            "id_cad": cad,
        }
        for catid, cad, placed in CADS
    ]
    return {"id_scan": "scene0001_00", "trs": trs(*SCAN), "aligned_models": models} | more


def write(folder: Path, data: Any) -> Path:
    path = folder / "full_annotations.json"
    path.write_text(json.dumps(data))
    return path


def polygon(folder: Path, **more: Any) -> str:
    path = folder / "floor.json"
    path.write_text(json.dumps({"floor": FLOOR, "level": 0.05, "height": 2.5} | more))
    return str(path)


def read(path: Path, **options: str) -> Capture:
    return read_capture("scan2cad", path, options)


def test_a_cad_lies_in_the_scan_at_the_inverse_of_the_scan_times_its_own(tmp_path: Path) -> None:
    capture = read(write(tmp_path, [annotation()]), polygon=polygon(tmp_path))
    points = np.array([[0.1, 0.2, 0.3, 1.0], [-0.3, 0.4, 0.1, 1.0], [0, 0, 0, 1.0]]).T
    for model, (_, _, placed) in zip(capture.models, CADS, strict=True):
        expected = np.linalg.inv(matrix(*SCAN)) @ matrix(*placed) @ points
        found = capture.source_from_world @ model.world_from_model @ points
        assert found == pytest.approx(expected, abs=1e-9)
        scales = np.linalg.norm(model.world_from_model[:3, :3], axis=0)
        assert scales == pytest.approx(placed[2])
    assert [model.id for model in capture.models] == ["0_chairone", "1_chairone", "0_tabletwo"]
    assert [model.label for model in capture.models] == ["chair", "chair", "table"]
    assert capture.models[0].symmetry == "2"
    assert capture.models[0].file is None


def test_the_official_centre_is_taken_off_on_request_only(tmp_path: Path) -> None:
    source, floor = write(tmp_path, [annotation()]), polygon(tmp_path)
    plain = read(source, polygon=floor)
    assert (
        read(source, polygon=floor, official_centre="no").models[0].world_from_model
        == plain.models[0].world_from_model
    ).all()
    official = read(source, polygon=floor, official_centre="yes")
    for a, b in zip(plain.models, official.models, strict=True):
        middle = a.world_from_model @ [0.0, 0.0, 0.0, 1.0]
        assert b.world_from_model @ [*b.center, 1.0] == pytest.approx(middle)
    with pytest.raises(InputError, match="yes or no"):
        read(source, polygon=floor, official_centre="maybe")


def test_the_world_stands_on_the_polygon(tmp_path: Path) -> None:
    opening = {
        "kind": "door",
        "center": [3.0, 2.0, 1.05],
        "width": 0.9,
        "height": 2.0,
        "open": True,
    }
    path = polygon(tmp_path, openings=[opening])
    capture = read(write(tmp_path, [annotation()]), polygon=path)
    assert capture.height == 2.5
    assert capture.floor is not None
    assert capture.floor.min(axis=0) == pytest.approx([0, 0], abs=1e-9)
    lifted = np.column_stack([capture.floor, np.zeros(4), np.ones(4)])
    back = (lifted @ capture.source_from_world.T)[:, :3]
    assert {tuple(np.round(row, 6)) for row in back} == {(x, y, 0.05) for x, y in FLOOR}
    (door,) = capture.openings
    assert door.center == pytest.approx([2.0, 0.0, 1.0])
    assert np.abs(door.direction) == pytest.approx([1, 0, 0])
    assert door.is_open
    assert not capture.notes[:-1]


def test_a_csv_polygon_leaves_the_level_to_the_objects(tmp_path: Path) -> None:
    path = tmp_path / "floor.csv"
    path.write_text("x,y\n1,2\n5,2\n5,5\n1,5\n")
    capture = read(write(tmp_path, [annotation()]), polygon=str(path))
    assert capture.height is None
    assert any("level" in note for note in capture.notes)
    # Its height in the scan is the median base of what stands lowest.
    bases = []
    for _, _, placed in CADS:
        corners = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T * [0.3, 0.4, 0.25]
        M = np.linalg.inv(matrix(*SCAN)) @ matrix(*placed)
        bases.append((np.add(corners, [0.01, 0.02, -0.03]) @ M[:3, :3].T + M[:3, 3])[:, 2].min())
    standing = [base for base in bases if base - min(bases) < 0.15]
    assert capture.source_from_world[2, 3] == pytest.approx(np.median(standing))


def test_the_scan_is_chosen_and_unknown_ones_are_told_the_nearest(tmp_path: Path) -> None:
    path = write(tmp_path, [annotation(), annotation(id_scan="scene0001_01")])
    assert len(read(path, scan="scene0001_01").models) == 3
    with pytest.raises(InputError, match="scene0001_0") as caught:
        read(path, scan="scene0001_02")
    assert "no scan is named 'scene0001_02'" in str(caught.value)
    with pytest.raises(InputError, match="holds 2 scans"):
        read(path)


def broken(data: dict[str, Any], keys: tuple[Any, ...], value: Any) -> list[Any]:
    node: Any = data
    for key in keys[:-1]:
        node = node[key]
    if value is KeyError:
        del node[keys[-1]]
    else:
        node[keys[-1]] = value
    return [data]


FIRST = ("aligned_models", 0)


@pytest.mark.parametrize(
    ("keys", "value", "said"),
    [
        ((*FIRST, "trs"), KeyError, "[0].aligned_models[0]: 'trs' is missing"),
        ((*FIRST, "trs", "scale"), [1, 0, 1], "aligned_models[0].trs.scale: a scale is zero"),
        ((*FIRST, "trs", "scale"), [1, -1, 1], "it mirrors"),
        ((*FIRST, "trs", "rotation"), [0.5, 0.5, 0.5, 0.1], "has the length 0.872, not 1"),
        ((*FIRST, "trs", "rotation"), [1, 0, 0], "4 numbers expected, found 3"),
        ((*FIRST, "trs", "translation"), [1e300, 0, 0], "out of range"),
        ((*FIRST, "bbox"), [0.1, 0, 0.1], "aligned_models[0].bbox: a half extent"),
        ((*FIRST, "id_cad"), "../../etc", "not an identifier of Scan2CAD"),
        ((*FIRST, "center"), None, "'center' is missing"),
        (("trs", "scale"), [1, 1, 2], "shears"),
        (("aligned_models",), 5, "a list expected"),
        (("id_scan",), KeyError, "not a Scan2CAD annotation"),
    ],
)
def test_nonsense_is_refused_with_its_place(tmp_path, keys, value, said) -> None:
    path = write(tmp_path, broken(annotation(), keys, value))
    with pytest.raises(InputError) as caught:
        read(path)
    assert said in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_number_that_is_none_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "nan.json"
    path.write_text(json.dumps([annotation()]).replace("0.02", "NaN"))
    with pytest.raises(InputError, match="NaN"):
        read(path)
