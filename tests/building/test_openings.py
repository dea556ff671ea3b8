import numpy as np
import pytest

from openrooms_usd.building.openings import MARGIN, around, clamped, free_span, misfit, too_close
from openrooms_usd.building.shell import Hole
from openrooms_usd.building.walls import walls_of
from openrooms_usd.geometry.polygons import counter_clockwise

# The edges at the inner corner (2, 2) are shorter outside than inside.
CONCAVE = [(0, 0), (5, 0), (5, 2), (2, 2), (2, 4), (0, 4)]
WALLS = walls_of(*counter_clockwise(CONCAVE), 0.2)
HEIGHT = 2.6


def test_the_free_span_ends_at_the_shorter_face() -> None:
    assert free_span(WALLS[0]) == pytest.approx((MARGIN, 5.0 - MARGIN))
    # Wall 2 runs from (5, 2) to the inner corner (2, 2), which is on its left from inside.
    assert free_span(WALLS[2]) == pytest.approx((0.2 + MARGIN, 3.0 - MARGIN))


@pytest.mark.parametrize(
    ("hole", "reason"),
    [
        (Hole(1, 2, 0, 2), None),
        (Hole(0.22, 2.98, 0, 2.58), None),
        (Hole(0.1, 1, 0, 2), "beyond the left end"),
        (Hole(2, 2.99, 0, 2), "beyond the right end"),
        (Hole(-1, 4, 0, 2), "is 5.000 m wide, but only 2.760 m of its 3.000 m"),
        (Hole(1, 2, 1, 2.6), "reaches up to 2.600 m, but the ceiling is at 2.600 m"),
    ],
)
def test_what_does_not_fit_is_said_with_numbers(hole: Hole, reason: str | None) -> None:
    found = misfit(WALLS[2], HEIGHT, hole)
    assert (found is None) == (reason is None)
    assert reason is None or reason in str(found)


def test_nothing_fits_into_a_wall_that_tapers_to_a_point() -> None:
    partition = [(0, 0), (2, 0), (2, 1.5), (2.3, 1.5), (2.3, 0), (5, 0), (5, 4), (0, 4)]
    wall = walls_of(*counter_clockwise(partition), 0.2)[2]
    assert wall.outer is None
    assert misfit(wall, HEIGHT, Hole(0.1, 0.2, 0, 2)) is not None
    assert clamped(wall, HEIGHT, Hole(0.1, 0.2, 0, 2)) is None


def test_clamping_gives_what_fits_and_drops_what_hardly_does() -> None:
    fitting = clamped(WALLS[2], HEIGHT, Hole(-1.0, 1.0, 0.01, 3.0))
    assert fitting is not None
    assert np.allclose(fitting.ring[[0, 2]], [[0.2 + MARGIN, 0.0], [1.0, HEIGHT - MARGIN]])
    assert misfit(WALLS[2], HEIGHT, fitting) is None
    assert clamped(WALLS[2], HEIGHT, Hole(-1.0, 0.3, 0.0, 2.0)) is None


@pytest.mark.parametrize(
    ("other", "close"),
    [
        (Hole(2.01, 3, 0, 2), True),
        (Hole(2.03, 3, 0, 2), False),
        (Hole(1, 2, 2.03, 2.5), False),
        (Hole(1.5, 3, 1, 2.5), True),
    ],
)
def test_holes_are_too_close_when_less_than_the_margin_is_between_them(
    other: Hole, close: bool
) -> None:
    hole = Hole(1, 2, 0, 2)
    assert too_close(hole, other) is close
    assert too_close(other, hole) is close


def test_the_hole_around_some_contains_them() -> None:
    assert around([Hole(1, 2, 0.5, 2), Hole(1.5, 3, 0, 1)]) == Hole(1, 3, 0, 2)
    assert np.allclose(Hole(1, 2, 0.5, 2).ring[[0, 2]], [[1, 0.5], [2, 2]])
