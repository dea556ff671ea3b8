"""Voids that somebody looked through, and what nobody looked at; two holes or one."""

import numpy as np
import pytest

from openrooms_usd.scan.openings.cellcounts import CELL_M
from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallholes import rectangles
from openrooms_usd.scan.openings.wallpicture import enclosed

ROWS, COLUMNS = 100, 160


def test_a_void_goes_no_farther_up_than_the_wall_beside_it() -> None:
    standing = np.zeros((ROWS, COLUMNS), dtype=bool)
    standing[:84] = True
    door = np.s_[:82, 60:95]
    standing[door] = False
    # Above 2.1 m nobody looked, and beside the door's upper part something hides the wall.
    void = np.zeros_like(standing)
    void[:, 60:95] = True
    kept = enclosed(void, standing)
    assert kept[:84, 60:95].all()
    assert not kept[84:].any()
    # Where one side was never seen that high, neither is known the other side's height.
    standing[70:, :95] = False
    assert not enclosed(void, standing)[70:].any()


def test_what_is_wider_than_doors_up_to_the_top_was_not_looked_at() -> None:
    standing = np.ones((ROWS, COLUMNS), dtype=bool)
    void = np.zeros_like(standing)
    void[60:, 20:130] = True
    void[:60, 60:95] = True
    kept = enclosed(void, standing & ~void)
    assert kept[:60, 60:95].all()
    assert not kept[60:].any()


def test_slits_are_no_holes_and_windows_stay_whole() -> None:
    void = np.zeros((ROWS, COLUMNS), dtype=bool)
    void[30:80, 10:13] = True
    void[40:80, 40:150] = True
    kept = enclosed(void, ~void)
    assert not kept[:, :20].any()
    assert kept[40:80, 40:150].all()


@pytest.mark.parametrize(("apart", "count"), [(4, 1), (6, 2)])
def test_holes_that_a_mullion_parts_are_one(apart: int, count: int) -> None:
    weights = np.full((ROWS, COLUMNS), -1.0)
    weights[40:88, 20:50] = weights[40:88, 50 + apart : 90] = 1.0
    found = list(rectangles(weights))
    assert len(found) == count
    assert found[0].top - found[0].bottom == pytest.approx(1.2 / CELL_M)


def test_holes_at_different_heights_are_two() -> None:
    weights = np.full((ROWS, COLUMNS), -1.0)
    # What a curtain between them hides says nothing.
    weights[30:90, 50:53] = -0.03
    weights[20:70, 20:50] = weights[40:90, 53:83] = 1.0
    assert list(rectangles(weights)) == [Rectangle(20, 70, 20, 50), Rectangle(40, 90, 53, 83)]
