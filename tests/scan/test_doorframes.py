"""Closed doors by their frames' relief."""

import numpy as np
import pytest

from openrooms_usd.scan.openings.judgement import frames
from openrooms_usd.scan.openings.wallpicture import CELL_M, WallGrid, wall_grids
from openrooms_usd.scan.points.sightlines import sight_of
from tests.scan.walled_rooms import CORNERS, DOOR, HEIGHT, SENSOR_ORIGINS, Sheet, casing_of, room


def wall(sheets: list[Sheet], noise: float = 0.003) -> WallGrid:
    """The picture of the first wall."""
    cloud = room(sheets, labels=False, noise=noise)
    return next(wall_grids(cloud, CORNERS, HEIGHT, sight_of(cloud.points, SENSOR_ORIGINS)))


@pytest.mark.parametrize(("proud", "noise"), [(0.01, 0.003), (0.015, 0.01), (0.03, 0.005)])
def test_boards_around_a_leaf(proud: float, noise: float) -> None:
    grid = wall(casing_of(0, (1.5, 2.4), 2.05, proud), noise)
    ((where, clear),) = frames(grid)
    edges = CELL_M * np.array([where.left, where.right, where.top])
    np.testing.assert_allclose(edges, [1.5, 2.4, 2.05], atol=CELL_M)
    assert where.bottom == 0
    assert 0 < clear <= 1


def test_a_leaf_that_lies_deeper_than_the_wall() -> None:
    grid = wall([Sheet(0, (1.5, 2.4), (0.0, 2.05), 0.02, DOOR)])
    ((where, _),) = frames(grid)
    edges = CELL_M * np.array([where.left, where.right, where.top])
    np.testing.assert_allclose(edges, [1.5, 2.4, 2.05], atol=2 * CELL_M)


@pytest.mark.parametrize(
    "sheets",
    [
        [],
        # A picture, a board that ends above the floor, a shelf as high as a hip, and a step.
        [Sheet(0, (1.5, 2.4), (1.0, 2.0), -0.02)],
        [s for s in casing_of(0, (1.5, 2.4), 2.05, 0.015) if s.z[0] > 0],
        casing_of(0, (1.5, 2.4), 1.0, 0.015),
        [Sheet(0, (2.0, 4.0), (0.0, HEIGHT), -0.02)],
    ],
)
def test_what_is_no_door(sheets: list[Sheet]) -> None:
    assert list(frames(wall(sheets))) == []


def test_a_low_wall_has_no_door() -> None:
    cloud = room([])
    grid = next(wall_grids(cloud, CORNERS, 1.5, sight_of(cloud.points, SENSOR_ORIGINS)))
    assert list(frames(grid)) == []
