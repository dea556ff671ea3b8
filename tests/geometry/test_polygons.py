import numpy as np
import pytest
import shapely

from openrooms_usd.geometry.polygons import counter_clockwise, defect, grown, triangulated, turns

SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])


@pytest.mark.parametrize(
    ("corners", "reason"),
    [
        ([(0, 0), (1, 0)], "2 corners"),
        ([(0, 0), (1, 0), (np.nan, 1)], "corner 2"),
        ([(0, 0), (1, 0), (1, 0), (0, 1)], "corners 1 and 2"),
        ([(0, 0), (2, 2), (2, 0), (0, 2)], r"crosses or touches itself near \(1.000, 1.000\)"),
        ([(0, 0), (2, 0), (1, 0), (0, 1)], "crosses or touches itself"),
        ([(0, 0), (4, 0), (4, 3), (2, 1e-5), (0, 3)], "nearer than 1 mm"),
    ],
)
def test_defects_are_named_with_their_place(corners: list, reason: str) -> None:
    import re

    found = defect(corners)
    assert found is not None
    assert re.search(reason, found)


def test_a_polygon_with_collinear_and_sharp_corners_has_no_defect() -> None:
    assert defect([(0, 0), (1, 0), (4, 0), (8, 0.05), (4, 0.1), (0, 3)]) is None


def test_turning_round_keeps_the_number_of_every_edge() -> None:
    given = SQUARE[::-1]
    corners, numbers = counter_clockwise(given)
    assert shapely.Polygon(corners).exterior.is_ccw
    for a, b, number in zip(corners, np.roll(corners, -1, axis=0), numbers, strict=True):
        edge = {tuple(given[number]), tuple(given[(number + 1) % 4])}
        assert edge == {tuple(a), tuple(b)}


def test_turns_add_up_to_a_full_turn_and_are_negative_at_reflex_corners() -> None:
    corners = np.array([[0, 0], [5, 0], [5, 2], [2, 2], [2, 4], [0, 4.0]])
    assert np.allclose(turns(corners).sum(), 2 * np.pi)
    assert np.allclose(np.degrees(turns(corners)), [90, 90, 90, -90, 90, 90])


def test_growing_a_rectangle() -> None:
    assert np.allclose(shapely.Polygon(grown(SQUARE, 0.2, 2.0)).area, 2.4 * 1.4)


def test_triangles_use_every_corner_of_aligned_holes_and_meet_edge_to_edge() -> None:
    """Windows with equal sills in a row: corners that are collinear across holes."""
    outline = np.array([[0, 0], [9, 0], [9, 3], [0, 3.0]])
    holes = tuple(np.array([[x, 1], [x + 1, 1], [x + 1, 2], [x, 2.0]]) for x in (1, 3, 5, 7))
    rings = triangulated(outline, holes)
    edges: dict[tuple, int] = {}
    for ring in rings.tolist():
        for a, b in zip(ring, ring[1:] + ring[:1], strict=True):
            edges[tuple(a), tuple(b)] = edges.get((tuple(a), tuple(b)), 0) + 1
    assert set(edges.values()) == {1}
    open_edges = sum((b, a) not in edges for a, b in edges)
    assert open_edges == 4 + 4 * len(holes)
    assert np.isclose(sum(shapely.Polygon(ring).area for ring in rings), 27 - 4)
