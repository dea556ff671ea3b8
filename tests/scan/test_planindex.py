"""Points above a rectangle of the plan: the same as by looking at all of them."""

import numpy as np
import pytest

from openrooms_usd.scan.points.planindex import PlanIndex


@pytest.mark.parametrize(
    ("low", "high"),
    [
        ((-0.3, 0.2), (0.4, 0.25)),
        ((-9.0, -9.0), (9.0, 9.0)),
        ((1.9, 1.9), (7.0, 2.0)),
        ((5.0, 5.0), (6.0, 6.0)),
        ((-6.0, -0.5), (-5.0, 0.5)),
        ((0.25, -0.5), (0.5, 0.5)),
    ],
)
def test_no_point_of_a_rectangle_is_missed(low: tuple[float, ...], high: tuple[float, ...]) -> None:
    points = np.random.default_rng(0).uniform(-2.0, 2.0, (4000, 3))
    points[::7] = np.round(points[::7], 2)
    found = PlanIndex(points).rows(np.array(low), np.array(high))
    plan = points[:, :2]
    wanted = np.flatnonzero(((plan >= low) & (plan <= high)).all(axis=1))
    assert np.isin(wanted, found).all()
    assert (np.diff(found) > 0).all()
    # Few others: those of the cells of a quarter metre that it touches.
    least, most = np.subtract(low, 0.25), np.add(high, 0.25)
    assert ((plan[found] >= least) & (plan[found] <= most)).all()


def test_without_points_there_is_nothing() -> None:
    assert not len(PlanIndex(np.zeros((0, 3))).rows(np.zeros(2), np.ones(2)))
