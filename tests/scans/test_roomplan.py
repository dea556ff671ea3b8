import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from openrooms_usd.capture import Capture
from openrooms_usd.errors import InputError
from tests.scans.roomplan_usdz import CORNERS, read

HEIGHT = 2.45


def to_source(capture: Capture, points: np.ndarray) -> np.ndarray:
    M = capture.source_from_world
    return np.asarray(points @ M[:3, :3].T + M[:3, 3])


def same_ring(a: np.ndarray, b: np.ndarray, tolerance: float) -> bool:
    """Whether two rings have the same corners, whatever their start and direction."""
    turned = [np.roll(ring, k, axis=0) for ring in (b, b[::-1]) for k in range(len(b))]
    return len(a) == len(b) and any(np.abs(a - ring).max() < tolerance for ring in turned)


def floor_in_source(capture: Capture) -> np.ndarray:
    assert capture.floor is not None
    return to_source(capture, np.column_stack([capture.floor, np.zeros(len(capture.floor))]))


def expected_floor(scanner) -> np.ndarray:
    return scanner.source(np.column_stack([CORNERS, np.zeros(len(CORNERS))]))


def test_floor_and_height_come_back_to_the_source(scanner) -> None:
    capture = read(scanner.write(scanner.room(CORNERS, HEIGHT)))
    assert same_ring(floor_in_source(capture), expected_floor(scanner), 1e-8)
    assert capture.height == pytest.approx(HEIGHT)
    assert capture.source == "Room.json"
    assert capture.notes == ()
    floor = shapely.Polygon(capture.floor)
    assert floor.exterior.is_ccw
    assert floor.bounds[:2] == pytest.approx((0, 0), abs=1e-8)
    # The longest wall, of 5 m, runs along an axis.
    along = np.roll(capture.floor, -1, axis=0) - capture.floor
    longest = along[np.argmax(np.linalg.norm(along, axis=1))]
    assert np.abs(longest).min() < 1e-8


def test_the_way_back_is_a_rigid_motion_with_up_along_y(scanner) -> None:
    M = read(scanner.write(scanner.room(CORNERS, HEIGHT))).source_from_world
    assert M[:3, :3] @ M[:3, :3].T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(M[:3, :3]) == pytest.approx(1.0)
    assert M[:3, :3] @ [0, 0, 1] == pytest.approx([0, 1, 0], abs=1e-12)


def test_coordinates_far_from_the_origin_lose_nothing(scanner) -> None:
    near = read(scanner.write(scanner.room(CORNERS, HEIGHT)))
    scanner.origin = scanner.origin + np.array([1e6, 250.0, -3e6])
    far = read(scanner.write(scanner.room(CORNERS, HEIGHT)))
    assert far.floor == pytest.approx(near.floor, abs=1e-8)
    assert np.abs(floor_in_source(far) - expected_floor(scanner)[:1]).max() < 10
    assert same_ring(floor_in_source(far), expected_floor(scanner), 1e-8)


@pytest.mark.parametrize("shuffle", [0, 1, 2])
def test_without_a_floor_the_walls_enclose_it(scanner, shuffle: int) -> None:
    """What iOS 16 writes: no floors, no corners, walls in any order and direction."""
    rng = np.random.default_rng(shuffle)
    data = scanner.room(CORNERS, HEIGHT)
    walls = [
        scanner.surface("wall", *(pair if rng.random() < 0.5 else pair[::-1]), 0.0, HEIGHT)
        for pair in zip(CORNERS, np.roll(CORNERS, -1, axis=0), strict=True)
    ]
    # Walls that were seen twice, one of them inexactly.
    walls.append(scanner.surface("wall", [5.02, 0.03], [5.01, 2.46], 0.0, HEIGHT))
    walls += walls[:3]
    keep = ("identifier", "category", "confidence", "dimensions", "transform")
    data["walls"] = [{k: walls[i][k] for k in keep} for i in rng.permutation(len(walls))]
    for key in ("floors", "sections", "story", "coreModel", "version", "openings"):
        del data[key]
    capture = read(scanner.write(data))
    assert same_ring(floor_in_source(capture), expected_floor(scanner), 1e-6)
    assert capture.height == pytest.approx(HEIGHT)


BOX = ((0, 0), (5, 0), (5, 4), (0, 4))
ELL = ((0, 0), (5, 0), (5, 2), (2, 2), (2, 4), (0, 4))
LINES = {ring: list(zip(ring, ring[1:] + ring[:1], strict=True)) for ring in (BOX, ELL)}
SHORT = (((0, 4), (0, 2.6)), ((0, 1.4), (0, 0)), ((0, 3), (0, 1.6)), ((0.01, 4), (0.02, 2.6)))
# Walls that leave gaps, and the ring around what they enclose.
OPEN: dict[str, tuple[list, tuple]] = {
    **{f"box without {i}": (LINES[BOX][:i] + LINES[BOX][i + 1 :], BOX) for i in range(4)},
    **{
        f"ell without {i} and {j}": (
            [line for k, line in enumerate(LINES[ELL]) if k not in (i, j)],
            (*ELL[:j], *ELL[j + 1 :]) if j - i == 1 else ELL,
        )
        for i in range(6)
        for j in range(i, 6)
        if (i, j) != (0, 5)  # what is left faces away from the corner that is missing
    },
    **{f"short wall {i}": ([*LINES[BOX][:3], wall], BOX) for i, wall in enumerate(SHORT)},
    "a shelf inside": ([*LINES[BOX][:3], ((1, 1), (2, 1)), ((0, 3), (1.5, 3))], BOX),
    "a gap in the middle": ([*LINES[BOX][1:], ((0, 0), (1, 0)), ((3.5, 0), (5, 0))], BOX),
}


@pytest.mark.parametrize("name", OPEN)
def test_open_sides_are_closed_straight_with_a_note(scanner, name: str) -> None:
    lines, ring = OPEN[name]
    rng = np.random.default_rng(len(name))
    ways = [line if rng.random() < 0.5 else line[::-1] for line in lines]
    data = scanner.room(BOX, HEIGHT, floors=[])
    data["walls"] = [
        scanner.surface("wall", *ways[i], 0, HEIGHT) for i in rng.permutation(len(ways))
    ]
    capture = read(scanner.write(data))
    expected = shapely.Polygon(ring)
    assert shapely.Polygon(capture.floor).area == pytest.approx(expected.area, rel=0.01)
    assert len(capture.floor) == len(ring)
    assert any("closed straight" in note for note in capture.notes)
    assert not any("left out" in note for note in capture.notes)


def test_walls_that_do_not_close_give_their_hull_with_a_note(scanner) -> None:
    data = scanner.room(CORNERS, HEIGHT, floors=[])
    cross = [([0, 0], [4, 3]), ([4, 0], [0, 3]), ([2, -1], [2, 4])]
    data["walls"] = [scanner.surface("wall", a, b, 0, HEIGHT) for a, b in cross]
    capture = read(scanner.write(data))
    hull = shapely.MultiPoint([p for wall in cross for p in wall]).convex_hull
    assert shapely.Polygon(capture.floor).area == pytest.approx(hull.area)
    assert any("convex hull" in note for note in capture.notes)


def test_a_floor_that_crosses_itself_gives_its_largest_part_with_a_note(scanner) -> None:
    corners = [[0, 0], [5, 0], [5, 3], [0.5, 3], [0.5, 3.3], [0, 2.9]]
    capture = read(scanner.write(scanner.room(corners, HEIGHT, walls=[])))
    assert shapely.Polygon(capture.floor).area == pytest.approx(15.0, abs=0.3)
    bow = read(scanner.write(scanner.room([[0, 0], [4, 3], [4, 0], [0, 3.2]], HEIGHT, walls=[])))
    assert shapely.Polygon(bow.floor).is_valid
    assert any("crossed itself" in note for note in bow.notes)
    assert bow.height is None


def test_openings_keep_their_place_size_and_state(scanner) -> None:
    data = scanner.room(CORNERS, HEIGHT)
    state = {"category": {"door": {"isOpen": True}}, "confidence": {"low": {}}}
    data["doors"] = [scanner.surface("door", [5, 0.5], [5, 1.4], 0.0, 2.1, **state)]
    data["windows"] = [scanner.surface("window", [3, 0], [1, 0], 0.8, 2.2, curve={})]
    data["openings"] = [scanner.surface("opening", [0, 3], [0, 2], 0.0, 2.0)]
    door, window, opening = read(scanner.write(data)).openings
    assert (door.kind, window.kind, opening.kind) == ("door", "window", "opening")
    assert (door.is_open, window.is_open) == (True, None)
    assert (door.confidence, window.confidence) == ("low", "high")
    capture = read(scanner.write(data))
    for found, middle, along, size in (
        (door, [5, 0.95, 1.05], [0, 1, 0], (0.9, 2.1)),
        (window, [2, 0, 1.5], [-1, 0, 0], (2.0, 1.4)),
        (opening, [0, 2.5, 1.0], [0, -1, 0], (1.0, 2.0)),
    ):
        assert to_source(capture, found.center) == pytest.approx(scanner.source(middle))
        turned = capture.source_from_world[:3, :3] @ found.direction
        assert turned == pytest.approx(scanner.rotation @ along)
        assert (found.width, found.height) == pytest.approx(size)


def test_openings_seen_twice_become_the_surer_one_with_a_note(scanner) -> None:
    data = scanner.room(CORNERS, HEIGHT)
    low = {"confidence": {"low": {}}, "identifier": "unsure"}
    data["openings"] = [
        scanner.surface("opening", [1, 0.02], [2.02, 0.01], 0.0, 2.0, **low),
        scanner.surface("opening", [2, 0], [1, 0], 0.0, 2.02, identifier="sure"),
        scanner.surface("opening", [3, 0], [4, 0], 0.0, 2.02, identifier="other"),
    ]
    capture = read(scanner.write(data))
    assert [opening.id for opening in capture.openings] == ["sure", "other"]
    assert any("unsure" in note and "seen twice" in note for note in capture.notes)


@pytest.mark.parametrize("yaw", [0.0, 30.0, 90.0, 215.0])
def test_boxes_have_their_width_right_depth_back_and_height_up(scanner, yaw: float) -> None:
    data = scanner.room(CORNERS, HEIGHT)
    attributes = {"ChairType": "dining", "ChairLegType": "four"}
    data["objects"] = [
        scanner.box("chair", [1, 2, 0.45], [0.5, 0.6, 0.9], yaw, attributes=attributes)
    ]
    capture = read(scanner.write(data))
    box = capture.boxes[0]
    assert (box.label, box.confidence, box.attributes) == ("chair", "medium", attributes)
    assert box.size == pytest.approx([0.5, 0.6, 0.9])
    assert box.rotation.T @ box.rotation == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(box.rotation) == pytest.approx(1.0)
    # Its front looks along -Y of its own frame: at yaw 0 along -Y of the room.
    c, s = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
    in_room = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    assert capture.source_from_world[:3, :3] @ box.rotation == pytest.approx(
        scanner.rotation @ in_room
    )
    assert to_source(capture, box.center) == pytest.approx(scanner.source([1, 2, 0.45]))


# Outlines of the second wall of a box, 4 m by 2 m about its middle, and the tops of all walls where
# the ceiling follows them.
GABLE = [[-2, -1, 0], [2, -1, 0], [2, 1, 0], [0, 2, 0], [-2, 1, 0]]
SHED = [[-2, -1, 0], [2, -1, 0], [2, 1.6, 0], [-2, 1, 0]]
SQUARE = [[-2, -1, 0], [2, -1, 0], [2, 1, 0], [-2, 1, 0]]
CORNER_IN_A_TOP = [*SQUARE[:3], [0.5, 1, 0], SQUARE[3]]
PEAK = [(0, 0, 2), (5, 0, 2), (5, 2, 3), (5, 4, 2), (0, 4, 2)]
FOLLOWS = r"follows the tops of the walls, from 2.00 m to {} m \(`height` makes it level\)"
RISE = ", and lower walls rise to it beside higher ones: {} 2.00 m high"


@pytest.mark.parametrize(
    ("outline", "tall", "tops", "told"),
    [
        (GABLE, 2.0, PEAK, FOLLOWS + "$"),
        (GABLE[::-1], 2.0, PEAK, FOLLOWS + "$"),
        (SHED, 2.0, [(0, 0, 2), (5, 0, 2), (5, 4, 2.6), (0, 4, 2)], FOLLOWS + RISE),
        ([], 2.8, [(0, 0, 2), (5, 0, 2.8), (5, 4, 2.8), (0, 4, 2)], FOLLOWS + RISE),
        ([], 1.2, None, "level at 2.00 m.*: 1 wall is 1.20 m high \\(tall\\)"),
        ([], 2.06, None, ""),
        (SQUARE, 2.0, None, ""),
        (CORNER_IN_A_TOP, 2.0, None, ""),
    ],
)
def test_the_ceiling_follows_the_tops_of_walls_and_says_so(
    scanner, outline: list, tall: float, tops: list | None, told: str
) -> None:
    data = scanner.room(BOX, 2.0)
    data["walls"][1] = scanner.surface("wall", BOX[1], BOX[2], 0.0, tall, identifier="tall")
    data["walls"][1]["polygonCorners"] = outline
    capture = read(scanner.write(data))
    highest = max(z for _, _, z in tops or [(0, 0, 2)])
    assert capture.height == pytest.approx(highest)
    assert len(capture.notes) == bool(told)
    walls = "1 wall is" if outline else "2 walls are"
    assert re.search(told.format(f"{highest:.2f}", walls), " ".join(capture.notes))
    if tops is None:
        assert capture.roof is None
    else:
        assert same_ring(to_source(capture, capture.roof), scanner.source(tops), 1e-8)


def test_of_rooms_with_corners_inside_only_slopes_change_the_ceiling(scanner) -> None:
    """Higher walls by themselves may be those of a part of the room with a level of its own."""
    ell = ((0, 0), (5, 0), (5, 2), (2, 2), (2, 4), (0, 4))
    data = scanner.room(ell, 2.0)
    data["walls"][5] = scanner.surface("wall", ell[5], ell[0], 0.0, 2.8, identifier="tall")
    capture = read(scanner.write(data))
    assert capture.roof is None
    assert re.search(r"level at 2.00 m.*: 1 wall is 2.80 m high \(tall\)", capture.notes[0])
    data["walls"][5]["polygonCorners"] = [[-2, -1.4, 0], [2, -1.4, 0], [0, 1.4, 0]]
    capture = read(scanner.write(data))
    tops = [*((*corner, 2.0) for corner in ell), (0, 2, 2.8)]
    assert same_ring(to_source(capture, capture.roof), scanner.source(tops), 1e-8)


def test_the_ceiling_of_two_rooms_side_by_side_does_not_lean(scanner) -> None:
    data = scanner.room(BOX, 2.0)
    data["walls"][1] = scanner.surface("wall", BOX[1], BOX[2], 0.0, 2.8)
    data["walls"].append(scanner.surface("wall", [3, 0], [3, 4], 0.0, 2.0))
    capture = read(scanner.write(data))
    assert (capture.roof, len(capture.partitions)) == (None, 1)
    assert "1 wall is 2.80 m high" in capture.notes[0]


def spoiled(data: dict, **changes: object) -> dict:
    data["walls"][2] |= changes
    return data


BAD_WALLS = {
    "NaN": ({"dimensions": [float("nan"), 1, 0]}, "NaN is not a JSON number"),
    "huge": ({"dimensions": [1e30, 1, 0]}, r"walls\[2\].dimensions: 1e\+30 is out of range"),
    "negative": ({"dimensions": [-1, 1, 0]}, r"walls\[2\].dimensions: a dimension is negative"),
    "two numbers": ({"dimensions": [1, 2]}, r"walls\[2\].dimensions: 3 numbers expected, found 2"),
    "text": ({"dimensions": ["a", 2, 3]}, r"walls\[2\].dimensions: a number expected, found a tex"),
    "true": ({"dimensions": [True, 2, 3]}, r"a number expected, found true or false"),
    "missing": ({"transform": None}, r"walls\[2\]: 'transform' is missing"),
    "scaled": (
        {"transform": [2, *[0] * 4, 1, *[0] * 4, 1, *[0] * 4, 1]},
        "scales the axes by 2, 1",
    ),
    "sheared": ({"transform": [1, *[0] * 3, 0.6, 0.8, *[0] * 4, 1, *[0] * 4, 1]}, "shears"),
    "mirrored": ({"transform": [-1, *[0] * 4, 1, *[0] * 4, 1, *[0] * 4, 1]}, "left-handed"),
    "by rows": ({"transform": [1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 2, *[0] * 3, 1]}, "row by row"),
    "perspective": (
        {"transform": [1, 0, 0, 5, *[0, 1, 0, 0], *[0, 0, 1, 2], 7, 0, 0, 1]},
        r"last row is not 0 0 0 1",
    ),
    "zero": ({"dimensions": [0, 2, 0]}, r"walls\[2\].dimensions: a dimension is zero"),
    "corners": ({"polygonCorners": 7}, r"walls\[2\].polygonCorners: a list expected, found a num"),
    "category": ({"category": 7}, r"walls\[2\].category: a name or an object"),
}


@pytest.mark.parametrize("name", BAD_WALLS)
def test_nonsense_in_a_record_is_refused_with_its_place(scanner, name: str) -> None:
    changes, message = BAD_WALLS[name]
    path = scanner.write(spoiled(scanner.room(CORNERS, HEIGHT), **changes))
    with pytest.raises(InputError) as error:
        read(path)
    assert error.value.place
    assert str(path) in error.value.place
    import re

    assert re.search(message, str(error.value))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda M: M.T, "row by row"),
        (lambda M: M @ np.diag([1, 1, -1, 1]), "left-handed"),
        (lambda M: M @ np.diag([1, 2, 1, 1]), "scales the axes by 1, 2, 1"),
        (lambda M: M @ (np.eye(4) + np.eye(4, k=1) * [0, 0.5, 0, 0]), "scales|shears"),
    ],
)
def test_transforms_that_are_no_motion_are_named(scanner, change: Any, message: str) -> None:
    data = scanner.room(CORNERS, 2.5)
    row = scanner.box("chair", [1, 1, 0.4], [0.5, 0.5, 0.8], 20)
    M = np.array(row["transform"]).reshape(4, 4).T
    data["objects"] = [row | {"transform": change(M).T.ravel().tolist()}]
    with pytest.raises(InputError, match=message) as error:
        read(scanner.write(data))
    assert "objects[0].transform" in str(error.value.place)


BAD_FILES = {
    "empty": b"",
    "binary": bytes(range(256)) * 4,
    "truncated": b'{"walls": [{"dimensions": [1, 2',
    "a number": b"42",
    "a list": b"[]",
    "other JSON": b'{"rooms": []}',
    "a record is a number": b'{"walls": [3]}',
    "walls are an object": b'{"walls": {"a": 1}}',
    "nested without end": b'{"walls":' + b"[" * 200_000,
    "nested whole": b'{"walls":' + b"[" * 100_000 + b"]" * 100_000 + b"}",
    "infinite": b'{"walls": [{"dimensions": [1e999, 1, 1], "transform": []}]}',
    "an endless integer": b'{"walls": [{"dimensions": [' + b"9" * 10_000 + b"]}]}",
    "a long integer": b'{"walls": [{"dimensions": [' + b"9" * 400 + b", 1, 1]}]}",
}


@pytest.mark.parametrize("name", BAD_FILES)
def test_what_is_no_export_is_refused(tmp_path: Path, name: str) -> None:
    path = tmp_path / "bad.json"
    path.write_bytes(BAD_FILES[name])
    with pytest.raises(InputError) as error:
        read(path)
    assert "bad.json" in str(error.value)
    assert error.value.remedy


def test_missing_files_and_folders_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read(tmp_path / "none.json")
    with pytest.raises(InputError, match="this is a folder"):
        read(tmp_path)


def test_a_file_that_is_too_large_is_not_even_read(tmp_path: Path) -> None:
    path = tmp_path / "large.json"
    with path.open("wb") as file:
        file.truncate(1 << 40)  # sparse
    with pytest.raises(InputError, match="at most 64 MiB"):
        read(path)


def test_a_room_without_anything_has_no_floor(scanner) -> None:
    capture = read(scanner.write({"walls": []}))
    assert capture.floor is None
    assert capture.height is None


def test_a_real_capture(real) -> None:
    capture = read(real("roomplan_libroom/Room.json"))
    assert capture.floor is not None
    assert len(capture.floor) == 7
    assert shapely.Polygon(capture.floor).area == pytest.approx(11.24, abs=0.01)
    assert capture.height == pytest.approx(2.414, abs=1e-3)
    assert [opening.kind for opening in capture.openings] == ["opening"]
    assert [box.label for box in capture.boxes] == ["chair", "table", "chair"]
    chairs, table = capture.boxes[::2], capture.boxes[1]
    for chair in chairs:
        assert chair.center[2] - 0.5 * chair.size[2] == pytest.approx(0.0, abs=1e-3)
        front = -chair.rotation[:, 1]
        assert front @ (table.center - chair.center) > 0.1, "chairs look at the table"
