"""Simple polygons, against shapely, which decides by other means (exact predicates of GEOS)."""

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pydantic import ValidationError
from shapely.geometry import Polygon

from openrooms_usd.description.polygon import simple_polygon

Corners = list[tuple[float, float]]
corner = st.tuples(st.integers(0, 6), st.integers(0, 6))


def is_simple(corners: Corners) -> bool:
    try:
        simple_polygon(tuple(corners))
    except ValidationError:
        return False
    return True


@given(st.lists(corner, min_size=3, max_size=9))
def test_shapely_agrees(corners: Corners) -> None:
    # shapely lets corners repeat, and we do not.
    assume(all(a != b for a, b in zip(corners, corners[1:] + corners[:1], strict=True)))
    assert is_simple(corners) == Polygon(corners).is_valid


@given(st.lists(corner, min_size=3, max_size=9), st.floats(0, 6.3), st.integers(0, 8))
def test_turning_and_renumbering_change_nothing(corners: Corners, angle: float, shift: int) -> None:
    c, s = math.cos(angle), math.sin(angle)
    turned = [(c * x - s * y, s * x + c * y) for x, y in corners]
    shift %= len(corners)
    expected = is_simple(corners)
    assert is_simple(turned) == expected
    assert is_simple(corners[shift:] + corners[:shift]) == expected
    assert is_simple(corners[::-1]) == expected


@pytest.mark.one_in(9)
@pytest.mark.parametrize("count", [3, 50, 10_000])
def test_large_polygons_pass(count: int) -> None:
    turn = [2.0 * math.pi * i / count for i in range(count)]
    star = [((9 + i % 2) * math.cos(t), (9 + i % 2) * math.sin(t)) for i, t in enumerate(turn)]
    assert is_simple(star)


@pytest.mark.parametrize(
    ("corners", "blamed"),
    [
        ([(0, 0), (4, 4), (4, 0), (0, 4)], (2,)),
        ([(0, 0), (4, 0), (4, 4), (4, 4), (0, 4)], (3,)),
        ([(0, 0), (4, 0), (0, 0), (0, 4)], (1,)),
        ([(0, 0), (4, 0), (4, 4), (2, 0), (0, 4)], (3,)),
    ],
)
def test_the_corner_to_blame_is_named(corners: Corners, blamed: tuple[int, ...]) -> None:
    with pytest.raises(ValidationError) as caught:
        simple_polygon(tuple(corners))
    assert caught.value.errors()[0]["loc"] == blamed
