"""How faces hang together, against definitions written out and another library."""

import numpy as np
import pytest
import trimesh

from openrooms_usd.arrays import Ints
from openrooms_usd.geometry.topology import connected, open_edges, parts, weld

CUBE = trimesh.creation.box()
FACES = np.asarray(CUBE.faces, dtype=np.int64)


@pytest.mark.parametrize("shift", [0.0, 0.11, -3.5, 1e6])
def test_points_are_one_where_they_share_a_cell(shift: float) -> None:
    random = np.random.default_rng(1)
    # Well within their cells, so that no rounding decides.
    cells = random.integers(-9, 9, (400, 3))
    points = 0.25 * (cells + random.uniform(-0.3, 0.3, cells.shape) * (cells > cells.min(axis=0)))
    first, places = weld(points + shift, 0.25)
    expected, index = np.unique(cells, axis=0, return_inverse=True)
    np.testing.assert_array_equal(places, index.reshape(-1))
    np.testing.assert_array_equal(cells[first], expected)
    for place, point in enumerate(first):
        assert point == np.flatnonzero(places == place)[0]


def test_no_points_are_no_places() -> None:
    assert [found.tolist() for found in weld(np.empty((0, 3)), 0.1)] == [[], []]
    assert parts(np.empty((0, 3), dtype=np.int64)).tolist() == []


def test_soup_of_a_mesh_is_welded_to_its_points() -> None:
    ball = trimesh.creation.icosphere(3)
    first, places = weld(ball.triangles.reshape(-1, 3) + 100.0, 1e-6)
    assert len(first) == len(ball.vertices)
    assert not len(open_edges(places.reshape(-1, 3))[0])


def by_hand(count: int, links: Ints) -> list[set[int]]:
    """Components by merging sets."""
    found = [{node} for node in range(count)]
    for a, b in links.tolist():
        touched = [one for one in found if a in one or b in one]
        found = [one for one in found if one not in touched] + [set().union(*touched)]
    return sorted(found, key=min)


def test_components_are_those_of_merged_sets() -> None:
    links = np.random.default_rng(2).integers(0, 60, (35, 2))
    labels = connected(60, *links.T)
    found = [set(np.flatnonzero(labels == label).tolist()) for label in range(labels.max() + 1)]
    assert found == by_hand(60, links)


def test_parts_share_points_and_are_counted_without_gaps() -> None:
    # Two cubes that touch in one corner, and one apart; its points stand between unused ones.
    touching = np.where(FACES == 0, 7, FACES + 10)
    faces = np.concatenate([FACES, touching, FACES + 40])
    found = parts(faces)
    assert found.tolist() == [0] * 24 + [1] * 12


def test_edges_without_an_opposite_are_open() -> None:
    assert not len(open_edges(FACES)[0])
    rows, starts, stops = open_edges(FACES[1:])
    missing = FACES[0]
    opposite = {(int(b), int(a)) for a, b in zip(missing, np.roll(missing, -1), strict=True)}
    assert set(zip(starts.tolist(), stops.tolist(), strict=True)) == opposite
    for row, start, stop in zip(rows, starts, stops, strict=True):
        assert {start, stop} < set(FACES[1:][row].tolist())
    # Twice the same triangle: each of its edges is open twice; with its back, none is.
    triangle = np.array([[0, 1, 2], [0, 1, 2]])
    assert len(open_edges(triangle)[0]) == 6
    assert not len(open_edges(np.array([[0, 1, 2], [2, 1, 0]]))[0])
