"""Plain lists of boxes: the same boxes however they are written."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.capture import Capture, read_capture
from openrooms_usd.errors import InputError

HEADER = "id,label,x,y,z,width,depth,height,yaw\n"
TABLE = HEADER + "a,chair,1,2,0,0.5,0.6,0.9,30\nb,desk,3,1,0,1.6,0.8,0.75,\n"
BOXES = [
    {"id": "a", "label": "chair", "center": [1, 2, 0.45], "size": [0.5, 0.6, 0.9], "yaw": 30},
    {"id": "b", "label": "desk", "center": [3, 1, 0.375], "size": [1.6, 0.8, 0.75]},
]


def write(folder: Path, data: Any, name: str = "boxes.json") -> Path:
    path = folder / name
    path.write_text(data if isinstance(data, str) else json.dumps(data))
    return path


def read(path: Path, **options: str) -> Capture:
    return read_capture("boxes", path, options)


def same(a: Capture, b: Capture) -> None:
    assert [(box.id, box.label) for box in a.boxes] == [(box.id, box.label) for box in b.boxes]
    for one, other in zip(a.boxes, b.boxes, strict=True):
        assert one.center == pytest.approx(other.center, abs=1e-9)
        assert one.size == pytest.approx(other.size)
        assert one.rotation == pytest.approx(other.rotation, abs=1e-9)


def test_a_box_turns_counter_clockwise_and_stands_on_its_base(tmp_path: Path) -> None:
    chair = read(write(tmp_path, TABLE, "boxes.csv")).boxes[0]
    assert chair.center == pytest.approx([1, 2, 0.45])
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    assert chair.rotation == pytest.approx(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]))


def test_json_says_the_same_as_csv(tmp_path: Path) -> None:
    table = read(write(tmp_path, TABLE, "boxes.csv"))
    same(table, read(write(tmp_path, BOXES)))
    same(table, read(write(tmp_path, {"objects": BOXES})))
    same(table, read(write(tmp_path, TABLE.replace(",", ";"), "semicolons.csv")))
    middles = (
        TABLE.replace(",z,", ",cz,").replace(",2,0,", ",2,0.45,").replace(",1,0,", ",1,0.375,")
    )
    same(table, read(write(tmp_path, middles, "middles.csv")))
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    turned = {**BOXES[0], "rotation": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}
    same(table, read(write(tmp_path, [turned, BOXES[1]], "turned.json")))


def test_centimetres_and_y_up_come_back_to_the_source(tmp_path: Path) -> None:
    # (x, y, z) with Y up is (x, -z, y) with Z up.
    header = HEADER
    rows = "a,chair,100,0,-200,50,60,90,30\nb,desk,300,0,-100,160,80,75,0\n"
    found = read(write(tmp_path, header + rows, "cm.csv"), unit="cm", up="Y")
    same(found, read(write(tmp_path, TABLE, "boxes.csv")))
    M = found.source_from_world
    assert pytest.approx([100, 45, -200, 1]) == M @ [1, 2, 0.45, 1]
    with_units = header.replace("yaw", "yaw,unit") + rows.replace("30\n", "30,cm\n").replace(
        ",0\nb", ",0\nb"
    ).replace("75,0\n", "75,0,cm\n")
    same(found, read(write(tmp_path, with_units, "units.csv"), up="Y"))


def test_a_floor_openings_and_frames_may_lie_beside(tmp_path: Path) -> None:
    pose = [[1, 0, 0, 2.5], [0, 0, 1, 0.5], [0, -1, 0, 1.4], [0, 0, 0, 1]]
    data = {
        "objects": BOXES,
        "floor": [[0, 0], [5, 0], [5, 4], [0, 4]],
        "level": -0.1,
        "height": 2.6,
        "openings": [{"kind": "window", "center": [5, 2, 1.4], "width": 1.2, "height": 1.0}],
        "frames": [
            {
                "id": 7,
                "world_from_camera": pose,
                "resolution": [640, 480],
                "K": [[500, 0, 320], [0, 500, 240], [0, 0, 1]],
                "picture": "7.jpg",
            }
        ],
    }
    capture = read(write(tmp_path, data))
    assert capture.floor == pytest.approx(np.array([[0, 0], [5, 0], [5, 4], [0, 4]]))
    assert capture.height == 2.6
    assert capture.boxes[0].center == pytest.approx([1, 2, 0.55])  # the floor is at 0
    assert capture.openings[0].center == pytest.approx([5, 2, 1.5])
    assert np.abs(capture.openings[0].direction) == pytest.approx([0, 1, 0])
    (frame,) = capture.frames
    assert (frame.id, frame.picture, frame.resolution) == ("7", "7.jpg", (640, 480))
    assert frame.world_from_camera[:3, 3] == pytest.approx([2.5, 0.5, 1.5])
    assert frame.world_from_camera[:3, 2] == pytest.approx([0, 1, 0])


@pytest.mark.parametrize("drawn", [False, True])
def test_what_the_list_says_of_the_room_holds_without_its_floor(tmp_path, drawn: bool) -> None:
    window = {"kind": "window", "center": [1, 0, 1.5], "width": 1.0, "height": 1.0}
    data = {"objects": BOXES, "level": 0.1, "height": 2.6, "openings": [window]}
    options = {}
    if drawn:
        (tmp_path / "floor.csv").write_text("x,y\n0,0\n5,0\n5,4\n0,4\n")
        options = {"polygon": str(tmp_path / "floor.csv")}
    capture = read(write(tmp_path, data), **options)
    assert capture.height == 2.6
    assert capture.boxes[0].center == pytest.approx([1, 2, 0.35])
    assert [opening.kind for opening in capture.openings] == ["window"]
    if drawn:
        # What the floor's own file says comes first.
        polygon = {"floor": [[0, 0], [5, 0], [5, 4], [0, 4]], "level": 0.0, "height": 3.0}
        (tmp_path / "floor.json").write_text(json.dumps(polygon))
        capture = read(write(tmp_path, data), polygon=str(tmp_path / "floor.json"))
        assert (capture.height, capture.boxes[0].center[2]) == (3.0, pytest.approx(0.45))


def test_without_a_floor_the_rectangle_around_all_is_taken(tmp_path: Path) -> None:
    capture = read(write(tmp_path, BOXES))
    assert capture.floor is not None
    low, high = capture.floor.min(axis=0), capture.floor.max(axis=0)
    for box in capture.boxes:
        corners = np.array([[i, j, 0] for i in (-0.5, 0.5) for j in (-0.5, 0.5)]) * box.size
        plan = (corners @ box.rotation.T + box.center)[:, :2]
        assert (plan > low).all()
        assert (plan < high).all()
    assert any("no floor" in note for note in capture.notes)


def test_what_is_far_away_gets_an_origin_of_its_own(tmp_path: Path) -> None:
    far = [{**box, "center": np.add(box["center"], [4e6, 5e6, 0]).tolist()} for box in BOXES]
    capture = read(write(tmp_path, far))
    assert np.abs(capture.boxes[0].center).max() < 100
    found = capture.source_from_world @ [*capture.boxes[0].center, 1]
    assert found[:3] == pytest.approx(far[0]["center"], abs=1e-6)


@pytest.mark.slow
def test_ten_thousand_boxes_are_read(tmp_path: Path) -> None:
    rows = "".join(
        f"o{i},chair,{i % 100},{i // 100},0,0.5,0.5,0.9,{i % 360}\n" for i in range(10_000)
    )
    assert (
        len(read(write(tmp_path, TABLE.splitlines()[0] + "\n" + rows, "many.csv")).boxes) == 10_000
    )


def changed(**more: Any) -> list[Any]:
    return [BOXES[0] | more, BOXES[1]]


ROTATION = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]


@pytest.mark.parametrize(
    ("data", "said"),
    [
        ([{"label": "chair"}], "objects[0]: "),
        (changed(center=None), "objects[0]: "),
        (changed(size=[1, 0, 1]), "objects[0].size: a side is not positive"),
        (changed(size=[1, 1]), "3 numbers expected"),
        (changed(size=[1e-6, 1, 1]), "--unit cm"),
        (changed(center=[1, "2", 0]), "objects[0].center: a number expected"),
        (changed(id="b"), "objects[1]: the id 'b' repeats that of objects[0]"),
        (changed(label=""), "objects[0].label: a text expected"),
        (changed(rotation=[[1, 0, 0], [0, 1, 0], [0, 0, -1]]), "left-handed"),
        (changed(rotation=[[1, 0.4, 0], [0, 1, 0], [0, 0, 1]]), "scales or shears"),
        (changed(rotation=[[0, 0, 0]] * 3), "scales or shears"),
        (changed(yaw="left"), "objects[0].yaw: a number expected"),
        ({"objects": BOXES, "floor": [[0, 0], [1, 0]]}, "floor: 3 to"),
        ({"objects": BOXES, "floor": [[0, 0], [2, 2], [2, 0], [0, 2]]}, "floor: the polygon"),
        ({"objects": BOXES, "up": "X"}, "up: 'X' is not one of: Y, Z"),
        ({"objects": BOXES, "unit": "mile"}, "unit: 'mile' is not one of"),
        ({"objects": BOXES, "frames": [{"resolution": [0, 4]}]}, "frames[0].resolution: "),
        ({"boxes": BOXES}, "not a list of boxes"),
        ([5], "an object expected"),
        ("[{", "not readable as JSON"),
        ("[NaN]", "NaN"),
    ],
)
def test_nonsense_in_json_is_refused_with_its_place(tmp_path: Path, data: Any, said: str) -> None:
    path = write(tmp_path, data)
    with pytest.raises(InputError) as caught:
        read(path)
    assert said in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("id,label,x", "id,label,q"), "line 1: the header lacks x"),
        (("label,x", "label,x,x"), "line 1: the header repeats x"),
        ((",chair,1,", ",chair,nan,"), "line 2.x: nan is out of range"),
        ((",chair,1,", ",chair,inf,"), "out of range"),
        ((",chair,1,", ",chair,one,"), "line 2.x: a number expected"),
        ((",chair,1,", ",chair,,"), "line 2: 'x' is missing"),
        (("0.5,0.6", "0.5,-0.6"), "line 2.depth: -0.6 is not a size"),
        (("0.5,0.6", "0.5"), "line 2: 9 fields expected, found 8"),
        (("b,desk", "a,desk"), "line 3: the id 'a' repeats that of line 2"),
        (("a,chair", '"a,chair'), "CSV"),
        (("yaw", "unit"), "line 3: its unit is not that of the first line"),
    ],
)
def test_nonsense_in_csv_is_refused_with_its_line(tmp_path, change, said) -> None:
    path = write(tmp_path, TABLE.replace(*change), "boxes.csv")
    with pytest.raises(InputError) as caught:
        read(path)
    assert said in str(caught.value)


def test_other_ways_a_file_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read(tmp_path / "none.csv")
    (tmp_path / "latin.csv").write_bytes(b"id,label\xe9")
    with pytest.raises(InputError, match="the header lacks"):
        read(tmp_path / "latin.csv")
    with pytest.raises(InputError, match="no option 'colour'"):
        read(write(tmp_path, BOXES), colour="red")
