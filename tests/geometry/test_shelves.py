"""Rectangles on shelves: none over another, and little room is lost."""

import numpy as np
import pytest

from openrooms_usd.geometry.unwrap import shelved


@pytest.mark.parametrize("width", [None, 40])
def test_rectangles_do_not_overlap(width: int | None) -> None:
    sizes = np.random.default_rng(1).integers(1, 20, size=(60, 2))
    corners, (across, high) = shelved(sizes, width)
    taken = np.zeros((high, across), dtype=int)
    for (x, y), (w, h) in zip(corners, sizes, strict=True):
        taken[y : y + h, x : x + w] += 1
        assert x + w <= across and y + h <= high
    assert taken.max() == 1
    assert (taken == 1).mean() > 0.75
    assert across <= (width or across)


def test_nothing_needs_no_room() -> None:
    assert shelved(np.zeros((0, 2), np.int64))[1] == (0, 0)
