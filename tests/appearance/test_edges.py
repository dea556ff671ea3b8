"""Edges of pictures and of geometry: where they are, and which of them meet."""

import numpy as np
import pytest

from openrooms_usd.appearance.edges import EdgeMap, geometry_edges, match_edges, photograph_edges

HEIGHT, WIDTH = 120, 160
FACING = np.broadcast_to([0.0, 0.0, -1.0], (HEIGHT, WIDTH, 3))
ALONE = np.ones((HEIGHT, WIDTH))


def stepped(column: int) -> np.ndarray:
    """A picture that is dark to the left of a column."""
    pixels = np.full((HEIGHT, WIDTH, 3), 60, np.uint8)
    pixels[:, column:] = 200
    return pixels


def edges_at(column: int) -> EdgeMap:
    """The edges of a step in depth at a column."""
    depth = np.full((HEIGHT, WIDTH), 2.0)
    depth[:, column:] = 3.0
    return geometry_edges(depth, FACING, ALONE)


def test_a_tilted_plane_has_no_edges() -> None:
    columns = np.arange(WIDTH) + 0.5 - 0.5 * WIDTH
    # z of a plane whose points are (x, y, z) with z = 3 + x: 1 / z is linear in the pixel.
    depth = 3.0 / (1.0 - columns / 100.0)
    assert not geometry_edges(np.tile(depth, (HEIGHT, 1)), FACING, ALONE).mask.any()


def test_steps_creases_and_objects_are_edges() -> None:
    bent = FACING.copy()
    bent[:, 80:] = [1.0, 0.0, 0.0]
    objects = ALONE.copy()
    objects[60:] = 2
    flat = np.full((HEIGHT, WIDTH), 2.0)
    assert set(np.nonzero(edges_at(50).mask)[1]) <= {49, 50}
    assert set(np.nonzero(geometry_edges(flat, bent, ALONE).mask)[1]) == {79}
    assert set(np.nonzero(geometry_edges(flat, FACING, objects).mask)[0]) == {59}


def test_where_nothing_is_there_is_only_a_rim() -> None:
    depth = np.full((HEIGHT, WIDTH), 2.0)
    depth[40:80, 40:120] = 0.0
    normal = np.where(depth[..., None] > 0, FACING, 0.0)
    found = geometry_edges(depth, normal, ALONE).mask
    assert found.any()
    assert not found[42:78, 42:118].any()


def test_the_edge_of_a_photograph_is_a_line_at_its_step() -> None:
    found = photograph_edges(stepped(70))
    assert set(np.nonzero(found.mask)[1]) <= {69, 70}
    assert found.mask[10:-10].any(axis=1).all()
    assert not photograph_edges(np.full((HEIGHT, WIDTH, 3), 90, np.uint8)).mask.any()


@pytest.mark.parametrize(("column", "share"), [(70, 1.0), (71, 1.0), (85, 0.0)])
def test_edges_meet_where_they_are_near(column: int, share: float) -> None:
    match = match_edges(edges_at(70), photograph_edges(stepped(column)))
    assert match is not None
    assert match.share == pytest.approx(share, abs=0.03)
    # Shifts across the edge meet nothing; those along it meet all but what is shifted around.
    assert match.chance == pytest.approx(0.5 * share, abs=0.05)


def test_edges_of_another_direction_do_not_meet() -> None:
    lying = np.swapaxes(stepped(70), 0, 1)
    square = np.full((HEIGHT, HEIGHT), 2.0)
    square[:, 70:] = 3.0
    upright = geometry_edges(square, FACING[:, :HEIGHT], ALONE[:, :HEIGHT])
    match = match_edges(upright, photograph_edges(lying[:HEIGHT, :HEIGHT]))
    assert match is not None
    assert match.share < 0.1


def test_a_render_without_edges_has_no_share() -> None:
    plain = geometry_edges(np.full((HEIGHT, WIDTH), 2.0), FACING, ALONE)
    assert match_edges(plain, photograph_edges(stepped(70))) is None
