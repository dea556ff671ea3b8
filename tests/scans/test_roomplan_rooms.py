"""Several rooms in one export, and what each version of iOS writes of them."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import shapely
from pxr import Usd

from openrooms_usd import names
from openrooms_usd.capture import Capture
from openrooms_usd.composing import compose_room
from openrooms_usd.errors import InputError
from openrooms_usd.usd.places.partitions import read_partitions
from tests.commands import output_of
from tests.scans.roomplan_usdz import read

HEIGHT = 2.5
SMALL = [[0, 0], [3, 0], [3, 3], [0, 3]]
LARGE = [[3.2, 0], [8.2, 0], [8.2, 3], [3.2, 3]]


def section(scanner, label: str, center: list[float], story: int = 0) -> dict:
    return {"label": label, "center": scanner.source(center).tolist(), "story": story}


def flat(scanner) -> dict:
    """One CapturedRoom with two floors: a bedroom and a larger kitchen that share a passage."""
    small, large = scanner.room(SMALL, HEIGHT), scanner.room(LARGE, HEIGHT)
    data = {key: [*small[key], *large[key]] for key in ("walls", "floors", "doors")}
    data["floors"] = [floor | {"story": 0} for floor in data["floors"]]
    data["openings"] = [scanner.surface("opening", [3.1, 1], [3.1, 2], 0, 2, identifier="passage")]
    data["windows"] = [scanner.surface("window", [5, 0], [6, 0], 0.9, 2, identifier="far")]
    data["objects"] = [
        scanner.box("bed", [1, 1.2, 0.3], [1.6, 2, 0.6], 0, identifier="bed"),
        scanner.box("table", [5, 1.5, 0.35], [1, 1, 0.7], 0, identifier="table"),
        scanner.box("stove", [7.9, 1.5, 0.45], [0.6, 0.6, 0.9], 90, identifier="upstairs", story=1),
    ]
    data["sections"] = [
        section(scanner, "bedroom", [1.5, 1.5, 1]),
        section(scanner, "kitchen", [5, 1, 1]),
    ]
    return data


def ids(capture: Capture) -> tuple[list[str], list[str]]:
    return [o.id for o in capture.openings], [b.id for b in capture.boxes]


def area(capture: Capture) -> float:
    return float(shapely.Polygon(capture.floor).area)


def test_the_largest_floor_is_taken_and_the_others_are_named(scanner) -> None:
    capture = read(scanner.write(flat(scanner)))
    assert area(capture) == pytest.approx(15.0)
    assert ids(capture) == (["far", "passage"], ["table"])
    assert capture.use == "kitchen"
    assert capture.height == pytest.approx(HEIGHT)
    (note,) = capture.notes
    for words in ("2 rooms", "0 bedroom (9.0 m2)", "1 kitchen (15.0 m2)", "1 was taken"):
        assert words in note
    # The bed, the stove of another story, and the walls of the bedroom but the one beside.
    assert note.endswith("left out with the others: 3 walls, 2 objects")


@pytest.mark.parametrize("wanted", ["bedroom", "Bedroom", "0", "bed_room"])
def test_a_room_is_taken_by_its_label_or_number(scanner, wanted: str) -> None:
    capture = read(scanner.write(flat(scanner)), wanted)
    assert area(capture) == pytest.approx(9.0)
    assert ids(capture) == (["passage"], ["bed"])


def test_of_several_rooms_with_a_label_the_largest_is_taken(scanner) -> None:
    data = flat(scanner)
    for row in data["sections"]:
        row["label"] = "bedroom"
    assert area(read(scanner.write(data), "bedroom")) == pytest.approx(15.0)
    assert area(read(scanner.write(data), "0")) == pytest.approx(9.0)


def test_a_room_that_is_not_there_is_refused_with_those_that_are(scanner) -> None:
    path = scanner.write(flat(scanner))
    with pytest.raises(InputError, match="no room 'attic'") as error:
        read(path, "attic")
    assert "bedroom" in str(error.value.remedy)
    assert str(path) in str(error.value.place)
    with pytest.raises(InputError, match="no room '7'"):
        read(path, "7")


def test_stories_are_told_apart(scanner) -> None:
    data = storeys(scanner)
    data["sections"].append(section(scanner, "study", [5, 1, 3.8], story=1))
    assert ids(read(scanner.write(data), "study"))[1] == ["upstairs"]
    assert ids(read(scanner.write(data), "kitchen"))[1] == ["table"]
    for row in [row for rows in data.values() for row in rows]:
        row.pop("story", None)
    assert ids(read(scanner.write(data), "2"))[1] == ["upstairs"]


def structure(scanner) -> dict:
    """A CapturedStructure: the rooms with all that they have, and everything once more."""
    data = flat(scanner)
    rooms = []
    for corners, label, thing in ((SMALL, "bedroom", 0), (LARGE, "kitchen", 1)):
        center = [corners[0][0] + 1, 1, 1]
        rooms.append(
            scanner.room(corners, HEIGHT, objects=[data["objects"][thing]])
            | {"sections": [section(scanner, label, center)], "identifier": label}
        )
    return {**data, "rooms": rooms, "version": 2, "identifier": "structure"}


def test_rooms_of_a_structure_have_their_own_records(scanner) -> None:
    path = scanner.write(structure(scanner))
    assert ids(read(path)) == ([], ["table"])
    assert ids(read(path, "bedroom")) == ([], ["bed"])
    assert "2 rooms" in read(path).notes[0]


def test_what_ios_16_writes_of_several_rooms_is_told_apart_by_their_walls(scanner) -> None:
    data = structure(scanner)
    for room in data["rooms"]:
        for key in ("floors", "sections", "story", "coreModel", "version"):
            del room[key]
        for row in [row for rows in room.values() if isinstance(rows, list) for row in rows]:
            for key in ("polygonCorners", "parentIdentifier", "story", "completedEdges"):
                row.pop(key, None)
    path = scanner.write({"rooms": data["rooms"]})
    assert area(read(path)) == pytest.approx(15.0)
    assert area(read(path, "0")) == pytest.approx(9.0)
    with pytest.raises(InputError, match="no room 'bedroom'"):
        read(path, "bedroom")


def test_vectors_with_named_coordinates_are_read(scanner) -> None:
    """As apps write them that encode RoomPlan's values themselves."""
    data = scanner.room(SMALL, HEIGHT)
    plain = read(scanner.write(data))
    for row in [*data["walls"], *data["floors"]]:
        row["dimensions"] = dict(zip("xyz", row["dimensions"], strict=True))
        row["polygonCorners"] = [dict(zip("xyz", c, strict=True)) for c in row["polygonCorners"]]
        columns = [row["transform"][i : i + 4] for i in range(0, 16, 4)]
        row["transform"] = columns
        row["category"] = next(iter(row["category"]))
        row["confidence"] = "high"
    again = read(scanner.write(data))
    assert again.floor == pytest.approx(plain.floor)
    assert again.height == plain.height


def test_the_command_takes_a_room(scanner, tmp_path: Path) -> None:
    path = scanner.write(structure(scanner))
    out = tmp_path / "out"
    said = output_of("import", "roomplan", path, "-o", out, "--room", "bedroom", "--json")
    assert json.loads(said)["objects"] == 1
    assert "bedroom" in (out / "room.yaml").read_text()


def storeys(scanner) -> dict:
    """The flat with a passage between its rooms, and a storey above it."""
    data = flat(scanner)
    above = scanner.room(LARGE, HEIGHT)
    for key in ("walls", "floors"):
        for row in above[key]:
            row["story"] = 1
            row["transform"][13] += 2.8
            row["identifier"] += "-above"
        data[key] += above[key]
    data["objects"][2]["transform"][13] += 2.8
    return data


def test_all_rooms_of_a_storey_become_one_with_the_wall_between_them(scanner) -> None:
    capture = read(scanner.write(storeys(scanner)), "all")
    assert shapely.Polygon(capture.floor).equals_exact(
        shapely.box(0, 0, 8.2, 3), 1e-6, normalize=True
    )
    assert sorted(ids(capture)[0]) == ["far", "passage"]
    assert sorted(ids(capture)[1]) == ["bed", "table"]
    # Its two faces, which both rooms have, are one wall.
    [wall] = capture.partitions
    assert wall.thickness == pytest.approx(0.2)
    assert np.sort(wall.ends, axis=0) == pytest.approx(np.array([[3.1, 0], [3.1, 3]]))
    (note,) = capture.notes
    assert "2 of them were taken as one, as asked" in note
    assert note.endswith("left out with the others: 4 walls, 1 object")


def test_all_rooms_of_a_structure_become_one(scanner) -> None:
    capture = read(scanner.write(structure(scanner)), "all")
    assert area(capture) == pytest.approx(24.6)
    assert sorted(ids(capture)[1]) == ["bed", "table"]
    assert len(capture.partitions) == 1


def test_rooms_that_do_not_touch_are_not_joined(scanner) -> None:
    data = flat(scanner)
    away = [[x + 5.0, y] for x, y in LARGE]
    data["floors"][1] = scanner.room(away, HEIGHT)["floors"][0]
    capture = read(scanner.write(data), "all")
    assert area(capture) == pytest.approx(15.0)
    assert "1 of them were taken" not in capture.notes[0]
    assert "1 was taken" in capture.notes[0]


def test_what_is_outside_the_only_floor_is_left_out_and_said(scanner) -> None:
    data = scanner.room(SMALL, HEIGHT)
    data["objects"] = [
        scanner.box("bed", [1, 1.2, 0.3], [1.6, 2, 0.6], 0, identifier="bed"),
        scanner.box("chair", [3.2, 2, 0.4], [0.5, 0.5, 0.8], 0, identifier="at the door"),
        scanner.box("sofa", [6, 2, 0.4], [2, 0.9, 0.8], 0, identifier="elsewhere"),
    ]
    data["doors"] = [scanner.surface("door", [6, 0], [7, 0], 0, 2, identifier="far")]
    capture = read(scanner.write(data))
    assert ids(capture) == ([], ["bed", "at the door"])
    assert capture.notes == ("left out what lies outside the floor: 1 door, 1 object",)


def test_an_opening_between_two_rooms_is_where_its_wall_is(scanner) -> None:
    """Both rooms are near it; only one has its wall."""
    data = flat(scanner)
    own = next(row for row in data["walls"] if "[3.0, 0.0]-[3.0, 3.0]" in row["identifier"])
    data["openings"][0]["parentIdentifier"] = own["identifier"]
    data["floors"][1] = scanner.room([[x + 1.0, y] for x, y in LARGE], HEIGHT)["floors"][0]
    path = scanner.write(data)
    assert ids(read(path, "bedroom"))[0] == ["passage"]


def test_a_floor_without_corners_has_those_of_the_walls(scanner) -> None:
    """Its sides alone would be the rectangle around it."""
    corners = [[0, 0], [5, 0], [5, 2], [2, 2], [2, 4], [0, 4]]
    data = scanner.room(corners, HEIGHT)
    whole = read(scanner.write(data))
    data["floors"][0]["polygonCorners"] = []
    capture = read(scanner.write(data))
    assert area(capture) == pytest.approx(area(whole)) == pytest.approx(14.0)
    assert not capture.partitions
    assert capture.notes == ()


@pytest.mark.slow
def test_a_real_one_is_built_with_its_door_and_window(
    real: Callable[[str], Path], tmp_path: Path
) -> None:
    file = real("real_dev/data/roomplan_library/Room.json")
    (tmp_path / "room.yaml").write_text(f"layout: {{from: roomplan, file: '{file}'}}\n")
    compose_room(tmp_path / "room.yaml", tmp_path / "out", only="layout")
    stage = Usd.Stage.Open(str(tmp_path / "out" / names.SCENE))
    [wall] = read_partitions(stage)
    walls = {
        prim.GetAttribute(names.SOURCE_ID).Get()[:8]: prim.GetRelationship(
            names.OPENING_WALL
        ).GetTargets()
        for prim in stage.GetPrimAtPath(names.OPENINGS).GetChildren()
    }
    assert len(walls) == 4
    # The export names this wall as the parent of one door and of its window.
    assert {key for key, targets in walls.items() if targets == [wall.path]} == {
        "8FE05A62",
        "50A692E7",
    }


def test_a_wall_inside_the_floor_is_a_partition_with_its_door(scanner) -> None:
    """And one outside of it is left out, which is said; the door's own wall wins."""
    corners = np.array([[0, 0], [5, 0], [5, 4], [0, 4]], dtype=float)
    data = scanner.room(corners, 2.5)
    inner = scanner.surface("wall", (4.7, 0), (4.7, 4), 0.0, 2.5, identifier="inner")
    outer = scanner.surface("wall", (6, 1), (6, 3), 0.0, 2.5, identifier="outer")
    data["walls"] += [inner, outer]
    # Nearer to the wall of the outline than to its own.
    data["doors"] = [
        scanner.surface("door", (4.9, 1), (4.9, 1.9), 0.0, 2.0, parentIdentifier="inner")
    ]
    path = scanner.write(data)
    capture = read(path)
    [one] = capture.partitions
    assert one.id == "inner"
    assert np.linalg.norm(one.ends[1] - one.ends[0]) == pytest.approx(4.0)
    assert one.height == pytest.approx(2.5)
    assert capture.notes == ("left out 1 wall that is outside the floor: outer (2.00 m)",)
    (path.parent / "room.yaml").write_text(f"layout: {{from: roomplan, file: {path.name}}}\n")
    compose_room(path.parent / "room.yaml", path.parent / "out", only="layout")
    stage = Usd.Stage.Open(str(path.parent / "out" / names.SCENE))
    [wall] = read_partitions(stage)
    [door] = stage.GetPrimAtPath(names.OPENINGS).GetChildren()
    assert door.GetRelationship(names.OPENING_WALL).GetTargets() == [wall.path]
    assert stage.GetPrimAtPath(wall.path).GetAttribute(names.SOURCE_ID).Get() == "inner"
