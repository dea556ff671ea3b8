"""Distinct rows are those of numpy."""

import numpy as np
import pytest

from openrooms_usd.geometry.topology import distinct_rows


@pytest.mark.parametrize("columns", [1, 2, 3])
@pytest.mark.parametrize("values", [1, 2, 50])
def test_distinct_rows_are_those_of_numpy(columns: int, values: int) -> None:
    rows = np.random.default_rng(columns).integers(-values, values, (200, columns)) / 2.0
    first, which = distinct_rows(rows)
    expected, places, inverse = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    assert first.tolist() == places.tolist()
    assert which.tolist() == inverse.reshape(-1).tolist()
    assert (rows[first] == expected).all()


def test_zero_has_no_sign_and_nothing_has_no_rows() -> None:
    first, which = distinct_rows(np.array([[0.0, 1.0], [-0.0, 1.0]]))
    assert (first.tolist(), which.tolist()) == ([0], [0, 0])
    first, which = distinct_rows(np.empty((0, 3)))
    assert (len(first), len(which)) == (0, 0)
