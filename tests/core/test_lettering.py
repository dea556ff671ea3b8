"""Words on pictures: that they can be read, and where they stand."""

import string

import numpy as np
import pytest

from openrooms_usd.lettering import lettered, stamp


def test_letters_differ_from_each_other() -> None:
    every = string.ascii_letters + string.digits + ".,:-+%/_()=?"
    assert len({lettered(letter, 20).tobytes() for letter in every}) == len(every)
    # Views are named in any language.
    assert not np.array_equal(lettered("\u00fc", 20), lettered("u", 20))


def test_words_are_as_long_as_their_letters_and_stand_on_their_line() -> None:
    assert lettered("wall wall", 20).shape[1] == pytest.approx(
        2.2 * lettered("wall", 20).shape[1], rel=0.1
    )
    for size in (10, 13, 20, 28):
        capital, hanging = lettered("H", size), lettered("g", size)
        assert capital.shape[0] == hanging.shape[0] >= 1.25 * size
        rows = np.flatnonzero(capital.max(axis=1) > 0.5)
        assert rows[-1] == size - 1 and len(rows) == pytest.approx(0.71 * size, abs=1)
        assert hanging[size:].max() > 0.5
        assert capital.min() >= 0.0 and capital.max() <= 1.0


def test_what_has_no_words_has_no_ink() -> None:
    for text in ("", "  "):
        assert not lettered(text, 20).any()


def test_ink_is_cut_off_at_the_edges_and_mixes_with_the_paper() -> None:
    ink = np.array([[1.0, 0.5], [0.25, 1.0]])
    for row in range(-3, 5):
        for column in range(-3, 6):
            pixels = np.full((3, 4, 3), 100, np.uint8)
            stamp(pixels, ink, column, row, (200.0, 0.0, 100.0))
            expected = np.pad(np.full((3, 4, 3), 100.0), ((3, 3), (3, 3), (0, 0)))
            cut = expected[row + 3 : row + 5, column + 3 : column + 5]
            share = ink[: len(cut), : cut.shape[1], None]
            cut += share * (np.array([200.0, 0.0, 100.0]) - cut)
            np.testing.assert_array_equal(pixels, np.round(expected[3:6, 3:7]))
