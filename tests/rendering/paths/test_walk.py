"""Automatic walks: through gaps, around what stands in the way, never through it."""

import numpy as np
import pytest

from openrooms_usd.errors import RenderError
from openrooms_usd.geometry.pinhole import look_at
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.rotations import is_rotation
from openrooms_usd.rendering.paths.camera_path import frame_times
from openrooms_usd.rendering.paths.free_space import FreeSpace
from openrooms_usd.rendering.paths.walk import check_passable, walk

TIMES = frame_times(8.0, 10)


def room(*boxes: tuple[tuple[float, ...], tuple[float, ...]]) -> RayCaster:
    """A room of 5 x 3 x 2.5 m with boxes in it, each from a low to a high corner."""
    faces = [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 7, 3],
    ]
    points, triangles = [], []
    for low, high in (((0, 0, 0), (5, 3, 2.5)), *boxes):
        triangles += [[8 * (len(points) // 8) + k for k in face] for face in faces]
        points += [[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)]
    return RayCaster(points, triangles)


# A wall across the room that leaves a gap of 0.9 m, and a low sofa before it.
WALL = ((2.4, 0.0, 0.0), (2.5, 2.1, 2.5))
SOFA = ((1.2, 0.9, 0.0), (2.2, 2.0, 0.7))
CAMERAS = [look_at((0.8, 0.6, 1.6), (2.0, 1.5, 1.0)), look_at((4.2, 0.6, 1.5), (3.0, 2.0, 1.2))]


def test_a_walk_goes_round_walls_and_furniture() -> None:
    caster = room(WALL, SOFA)
    poses = walk(caster, CAMERAS, TIMES)
    assert poses.shape == (len(TIMES), 4, 4)
    eyes = poses[:, :3, 3]
    # From one half to the other through the gap.
    assert eyes[0, 0] < 1.5 and eyes[:, 0].max() > 3.5
    crossing = np.interp(2.45, np.maximum.accumulate(eyes[:, 0]), eyes[:, 1])
    assert crossing > 2.2
    check_passable(caster, eyes)
    assert ((eyes > 0.2) & (eyes < [4.8, 2.8, 2.3])).all()
    # Not over the sofa either, but for its corners, which cells of the plan do not see.
    over = (eyes[:, :2] > np.array(SOFA[0][:2]) + 0.1) & (eyes[:, :2] < np.array(SOFA[1][:2]) - 0.1)
    assert not over.all(axis=1).any()
    np.testing.assert_allclose(eyes[:, 2], 1.55)
    # Smooth: upright, without jumps, standing at both ends.
    assert all(is_rotation(pose[:3, :3]) for pose in poses)
    steps = np.linalg.norm(np.diff(eyes, axis=0), axis=1)
    assert steps.max() < 0.25 and steps[[0, -1]].max() < 0.02
    turned = np.einsum("ij,ij->i", poses[1:, :3, 2], poses[:-1, :3, 2])
    assert np.degrees(np.arccos(np.clip(turned, -1, 1))).max() < 12.0
    np.testing.assert_array_equal(walk(caster, CAMERAS, TIMES), poses)


@pytest.mark.parametrize("seconds", [2.0, 5.0, 20.0])
def test_nobody_runs(seconds: float) -> None:
    poses = walk(room(WALL, SOFA), CAMERAS, frame_times(seconds, 10))
    steps = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
    assert 0.3 < steps.max() * 10 <= 1.2  # as docs/howto/datasets.md says


def test_what_cannot_be_reached_is_left_out() -> None:
    closed = ((2.4, 0.0, 0.0), (2.5, 3.0, 2.5))
    poses = walk(room(closed), CAMERAS, TIMES)
    assert poses[:, 0, 3].max() < 2.2


def test_where_there_is_no_room_there_is_no_walk() -> None:
    cupboard = RayCaster([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    with pytest.raises(RenderError, match="no space"):
        FreeSpace(cupboard, np.array([5.0, 5.0, 1.5]))


def test_a_path_through_a_wall_is_refused() -> None:
    through = np.linspace([1.0, 1.0, 1.5], [4.0, 1.0, 1.5], 10)
    with pytest.raises(RenderError, match=r"at \(2\.33"):
        check_passable(room(WALL), through)
