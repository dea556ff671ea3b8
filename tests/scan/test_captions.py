"""Words on and beside the plan of a scan."""

import itertools

import numpy as np

from openrooms_usd.scan.report.canvas import PAPER, Canvas, beside
from openrooms_usd.scan.report.overlay import LEGEND, captions, panel
from openrooms_usd.scan.results import FoundObject, FoundOpening, FoundRoom, Pose

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
