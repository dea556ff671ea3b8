"""Every part of what the library makes has a finish that exists; a few draw one for each."""

import numpy as np
import pytest

from openrooms_usd.furniture import CATEGORIES, part_of
from openrooms_usd.furniture.registry import records
from openrooms_usd.library.finishes import FINISHES, METALS, PARTS, finishes_of
from tests.furniture.pieces import piece


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", sorted(CATEGORIES))
def test_every_part_of_every_style_has_a_finish(name: str) -> None:
    spec = CATEGORIES[name]
    for style in spec.styles:
        parts = {part_of(part) for part in piece(name, style).parts}
        for seed in range(6):
            finishes = finishes_of(name, parts, np.random.default_rng(seed))
            assert set(finishes) == parts
            assert set(finishes.values()) <= set(FINISHES)


def test_schemes_name_categories_and_finishes_that_exist() -> None:
    known = {*FINISHES, "metal"}
    for name, told in records():
        for scheme in told.schemes:
            assert set(scheme.finishes.values()) <= known, name
    assert set(PARTS.values()) <= known
    assert set(METALS) <= set(FINISHES)


def test_what_is_drawn_for_each_differs() -> None:
    assert FINISHES[PARTS["book"]].each
    for finish in FINISHES.values():
        if finish.each:
            assert len(finish.colors) > 1
            assert finish.choices > 1
