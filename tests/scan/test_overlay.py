"""The plan of a scan for people: what is drawn where, its words, and that the file is a PNG."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.errors import OutputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.report.canvas import PAPER, Canvas, beside
from openrooms_usd.scan.report.overlay import (
    LEGEND,
    _outline,
    captions,
    overlay,
    panel,
    plan_axes,
    write_overlay,
)
from openrooms_usd.scan.results import FoundObject, FoundOpening, FoundRoom, Pose

DOOR_COLOR, WALL_COLOR, PLACED_COLOR = (20, 150, 60), (200, 30, 30), (150, 40, 170)
DOOR = FoundOpening("door", np.array([[2.0, 0, 0], [1.0, 0, 0], [1.0, 0, 2], [2.0, 0, 2]]), 0.9, 0)


def a_room(guessed: tuple[int, ...] = (), openings: tuple[FoundOpening, ...] = ()) -> FoundRoom:
    corners = np.array([[0.0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]])
    return FoundRoom(np.array([0.0, 0, 1]), corners[0], corners, guessed, 2.5, openings)


def count(pixels: np.ndarray, color: tuple[int, int, int]) -> int:
    return int((pixels == color).all(axis=-1).sum())


def points() -> Cloud:
    return Cloud(np.random.default_rng(0).uniform(0, 3, (2000, 3)))


# The room with its paper is wider than high; its captions stand to the right of it.
WIDTH = 1300
SCALE = WIDTH / 6.4


def drawn(room: FoundRoom, *objects: FoundObject) -> np.ndarray:
    """The plan without its captions."""
    bounds = {"box": np.array([[-0.5, -0.25, 0], [0.5, 0.25, 1.0]])}
    return overlay(points(), [room], objects, bounds)[:, :WIDTH]


@pytest.mark.slow
def test_guessed_walls_are_dashed() -> None:
    whole, dashed = (count(drawn(a_room(guessed)), WALL_COLOR) for guessed in ((), (0, 2)))
    # The two long walls lose about 9/20 of their ink.
    assert 0.62 * whole < dashed < 0.82 * whole


@pytest.mark.slow
def test_doors_are_drawn_in_their_wall() -> None:
    pixels = drawn(a_room(openings=(DOOR,)))
    without = drawn(a_room())
    assert count(without, DOOR_COLOR) == 0
    rows, columns = np.nonzero((pixels == DOOR_COLOR).all(axis=-1))
    # The lower long wall of the room, on the page in its lower part, a metre wide.
    assert np.median(rows) > 0.6 * len(pixels)
    assert np.ptp(columns) == pytest.approx(SCALE, rel=0.1)


@pytest.mark.slow
def test_objects_turn_with_their_pose() -> None:
    sizes = []
    for angle in (0.0, 90.0):
        turn = Rotation.from_euler("z", angle, degrees=True).as_quat(scalar_first=True)
        pose = Pose(np.array([2.0, 1.5, 0.0]), turn, np.ones(3))
        pixels = drawn(a_room(), FoundObject(1, "", "box", pose, 0.0, 1.0))
        rows, columns = np.nonzero((pixels == PLACED_COLOR).all(axis=-1))
        sizes.append((np.ptp(columns), np.ptp(rows)))
    assert sizes[0] == pytest.approx(sizes[1][::-1], abs=2)
    assert sizes[0][0] == pytest.approx(2 * sizes[0][1], rel=0.05)


def test_objects_of_unknown_size_are_marked() -> None:
    pose = Pose(np.array([2.0, 1.5, 0.0]), np.array([1.0, 0, 0, 0]), np.ones(3))
    item = FoundObject(7, "lamp", "nobody", pose, 0.0, 1.0)
    assert not np.array_equal(drawn(a_room(), item), drawn(a_room()))


def test_a_tilted_floor_is_seen_from_above() -> None:
    normal = np.array([0.1, -0.2, 1.0]) / np.linalg.norm([0.1, -0.2, 1.0])
    axes = plan_axes(normal)
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(axes[:, 2], normal)
    assert np.linalg.det(axes) == pytest.approx(1.0)


def test_nothing_at_all_is_a_picture_too(tmp_path: Path) -> None:
    for cloud in (Cloud(np.zeros((0, 3))), points()):
        write_overlay(tmp_path / "empty.png", cloud, [])
        assert (tmp_path / "empty.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_the_same_plan_has_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        write_overlay(tmp_path / name, points(), [a_room((1,), (DOOR,))])
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_where_no_file_can_be_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        write_overlay(tmp_path / "file" / "a.png", points(), [a_room()])


def test_lines_have_their_width_and_length() -> None:
    canvas = Canvas.over(np.zeros(2), np.array([2.0, 1.0]), 1000, 100.0)
    canvas.line(np.array([0.5, 0.5]), np.array([1.5, 0.5]), (0, 0, 0), 4.0)
    ink = 1.0 - canvas.pixels[..., 0] / PAPER[0]
    assert ink.sum() == pytest.approx(100 * 4, rel=0.06)
    assert ink[:44].sum() == ink[56:].sum() == 0


@pytest.mark.parametrize("up", [0, 1, 2])
def test_boxes_are_drawn_around_what_stands_upright(up: int) -> None:
    """A box of 1 x 2 x 3 m along the axes after its own vertical covers 1 x 2 m of the plan."""

    size = np.roll([1.0, 2.0, 3.0], up - 2)
    turn = Rotation.from_matrix(np.roll(np.eye(3), (2 - up) % 3, axis=0)).as_quat(scalar_first=True)
    pose = Pose(np.array([4.0, 5.0, 0.0]), turn, np.ones(3))
    edges = np.array(list(_outline(pose, np.stack([np.zeros(3), size])))[:4])
    lengths = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1)
    np.testing.assert_allclose(np.sort(lengths), [1.0, 1.0, 2.0, 2.0])
    np.testing.assert_allclose(edges[..., 2], 0.0, atol=1e-12)


WINDOW = FoundOpening(
    "window", np.array([[3.0, 0, 1], [1.5, 0, 1], [1.5, 0, 2], [3, 0, 2]]), 0.8, 0
)


def tilted_room(ceiling: float | None, guessed: tuple[int, ...] = ()) -> FoundRoom:
    tilt = np.array([0.0, 0.6, 0.8])
    across, ahead = np.array([1.0, 0, 0]), np.array([0.0, 0.8, -0.6])
    corners = np.stack([0 * tilt, 4 * across, 4 * across + 3 * ahead, 3 * ahead]) + 5.0
    return FoundRoom(tilt, corners[0], corners, guessed, ceiling, (WINDOW,))


def an_object(shift: float) -> FoundObject:
    measured = Pose(np.zeros(3), np.array([1.0, 0, 0, 0]), np.ones(3))
    placed = Pose(np.array([shift, 0.0, 0.0]), measured.rotation, measured.scale)
    return FoundObject(7, "chair", "a", measured, 0.0, 1.0, placed=placed)


def test_captions_say_what_was_found() -> None:
    rooms = [tilted_room(2.5, (1, 3)), tilted_room(None)]
    told = [line.text for line in captions(rooms, [an_object(0.08), an_object(0.001)])]
    assert "room 0: 12.0 m2, 2.50 m high" in told
    assert "  guessed: wall 1, 3" in told
    assert "  window in wall 0: 1.50 x 1.00 m, 80%" in told
    assert "room 1: 12.0 m2, no ceiling seen" in told
    assert told[-3:] == ["2 objects", "  7 chair, moved 8 cm", "  7 chair"]
    assert "no room was found" in [line.text for line in captions([], [])]


def test_many_captions_stand_in_columns_that_are_not_higher_than_the_plan() -> None:
    lines = captions([tilted_room(2.5)], [an_object(0.1)] * 60)
    one, many = panel(LEGEND, 600), panel(lines, 600)
    assert many.shape[0] <= 600
    assert many.shape[1] > 2 * one.shape[1]
    # Every line prints something in its own row.
    assert (one < 255).any(axis=(1, 2)).sum() >= 10 * len(LEGEND)


def test_words_keep_clear_of_each_other() -> None:
    canvas = Canvas.over(np.zeros(2), np.full(2, 4.0), 800, 200.0)
    for _ in range(12):
        canvas.write("wall 3", np.array([2.0, 2.0]), (0, 0, 0))
    for a, b in itertools.combinations(canvas.words, 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
    # The first one stands where it was asked for.
    left, top, right, bottom = canvas.words[0]
    assert abs((left + right) / 2 - 400) <= 1
    assert abs((top + bottom) / 2 - 400) <= 1


def test_points_are_counted_in_blocks() -> None:
    canvas = Canvas.over(np.zeros(2), np.array([1.0, 0.5]), 100, 100.0)
    fine, coarse = (canvas.counts(np.array([[0.505, 0.255]]), grain) for grain in (1, 4))
    assert fine.shape == coarse.shape == (50, 100)
    assert (fine.sum(), coarse.sum()) == (1, 16)
    assert coarse[24, 50] == fine[24, 50] == 1


def test_pictures_beside_each_other_are_as_high_as_the_highest() -> None:
    low, high = np.zeros((2, 3, 3), np.uint8), np.zeros((5, 4, 3), np.uint8)
    both = beside([low, high])
    assert both.shape == (5, 7, 3)
    assert (both[2:, :3] == PAPER).all()
    assert not both[:, 3:].any()
