"""Run lengths and their short text, read back by decoders written from the format alone."""

import numpy as np
import pytest

from openrooms_usd.rendering.rle import compressed, run_lengths


def paint(counts: list[int], height: int, width: int) -> np.ndarray:
    """The mask of run lengths: a pen that goes down the columns and changes after every run."""
    mask = np.zeros((height, width), bool)
    at, black = 0, False
    for count in counts:
        for position in range(at, at + count):
            mask[position % height, position // height] = black
        at, black = at + count, not black
    assert at == height * width
    return mask


def read_text(text: str) -> list[int]:
    """COCO's text as numbers: groups of five bits, sign by the last group's highest bit."""
    counts: list[int] = []
    bits: list[int] = []
    for character in text.encode("ascii"):
        group = character - 48
        bits += [group >> k & 1 for k in range(5)]
        if group & 32:
            continue
        value = sum(bit << k for k, bit in enumerate(bits)) - (bits[-1] << len(bits))
        counts.append(value + (counts[-2] if len(counts) > 2 else 0))
        bits = []
    return counts


def masks() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(3)
    y, x = np.mgrid[:60, :80]
    return {
        "noise": rng.random((13, 17)) < 0.5,
        "disc": (y - 30) ** 2 + (x - 33) ** 2 < 400,
        "empty": np.zeros((4, 5), bool),
        "full": np.ones((4, 5), bool),
        "first": np.eye(1, 12, dtype=bool).reshape(3, 4),
        "last": np.eye(1, 12, 11, dtype=bool).reshape(3, 4),
        "long": np.arange(2_000_000).reshape(1000, 2000) > 1_234_567,
    }


@pytest.mark.parametrize("name", masks())
def test_both_forms_give_the_mask_back(name: str) -> None:
    mask = masks()[name]
    counts = run_lengths(mask)
    assert read_text(compressed(counts)) == counts
    assert sum(counts[1::2]) == mask.sum()
    if mask.size < 10_000:
        np.testing.assert_array_equal(paint(counts, *mask.shape), mask)


def test_an_example_by_hand() -> None:
    # Down the columns: 0 1 1 | 1 0 0.
    mask = np.array([[0, 1], [1, 0], [1, 0]], bool)
    assert run_lengths(mask) == [1, 3, 2]
    assert compressed([1, 3, 2]) == "132"
    # 40 = 8 + 1 * 32: the group 8 with the flag (8 + 32 + 48 = X), then 1.
    assert compressed([40]) == "X1"
    # From the third run on, differences: 2 - 3 = -1, one group of ones.
    assert compressed([5, 3, 7, 2]) == "537O"
