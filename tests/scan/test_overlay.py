"""The plan of a scan for people: where things are drawn, and that the file is a PNG."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from openrooms_usd.errors import OutputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.report.canvas import PAPER, Canvas
from openrooms_usd.scan.report.overlay import _outline, overlay, plan_axes, write_overlay
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
