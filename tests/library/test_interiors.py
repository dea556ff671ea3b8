"""Styles of rooms: every name in the tables is one that the library has."""

from typing import get_args

import numpy as np
import pytest

from openrooms_usd.description.styles import InteriorStyle
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import CATEGORIES
from openrooms_usd.furniture.schemes import METALS
from openrooms_usd.generation import generate
from openrooms_usd.generation.rooms import style_of
from openrooms_usd.library.styles.ensembles import ensemble_of
from openrooms_usd.library.styles.finishes import FINISHES
from openrooms_usd.library.styles.interiors import INTERIORS, Interior
from openrooms_usd.library.textures import FAMILIES

FAMILY_NAMES = {name for families in FAMILIES.values() for name in families}
each_style = pytest.mark.parametrize("interior", INTERIORS.values(), ids=INTERIORS)


def test_the_table_has_the_styles_of_the_description() -> None:
    assert set(INTERIORS) == set(get_args(InteriorStyle))


@each_style
def test_the_tables_name_what_there_is(interior: Interior) -> None:
    for category, factors in interior.furniture.items():
        assert set(factors) <= set(CATEGORIES[category].styles), category
        assert any(factors.get(style, 1.0) for style in CATEGORIES[category].styles), category
    assert set(interior.families) <= FAMILY_NAMES
    assert {wood for pair in interior.woods for wood in pair} <= set(FAMILIES["wood"])
    assert set(interior.metals) <= set(METALS)
    assert set(interior.finishes) <= set(FINISHES) | {"metal"}


@each_style
def test_colours_reflect_no_more_than_paint_and_cloth_do(interior: Interior) -> None:
    neutrals = [color for pair in interior.neutrals for color in pair]
    colors = np.array([*interior.accents, *neutrals, *interior.walls, *interior.ceilings])
    assert (colors >= 0.02).all() and (colors <= 0.85).all()


def test_styles_are_taken_as_often_as_their_factors_say() -> None:
    rng = np.random.Generator(np.random.PCG64(1))
    interior, styles = INTERIORS["industrial"], tuple(CATEGORIES["chair"].styles)
    taken = [interior.style_of("chair", dict.fromkeys(styles, 1.0), rng) for _ in range(2000)]
    factors = [interior.furniture["chair"].get(style, 1.0) for style in styles]
    shares = [taken.count(style) / 2000 for style in styles]
    assert np.allclose(shares, np.array(factors) / sum(factors), atol=0.04)


def test_a_room_has_a_style_and_furniture_that_follows() -> None:
    made = {style: generate("closet", 2, style=style) for style in INTERIORS}
    assert {room.style for room in made.values()} == set(INTERIORS)
    drawn = generate("closet", 2)
    assert drawn.style == style_of("closet", 2)
    assert len({style_of("bedroom", seed) for seed in range(40)}) == len(INTERIORS)


def test_an_unknown_style_is_refused() -> None:
    with pytest.raises(InputError, match="no style is named 'baroque'"):
        generate("closet", 2, style="baroque")  # type: ignore[arg-type]


@each_style
def test_what_a_room_has_in_common_is_of_its_style(interior: Interior) -> None:
    for seed in range(10):
        shared = ensemble_of(interior, np.random.default_rng(seed))
        assert shared.woods in interior.woods and shared.metal in interior.metals
        assert (shared.light, shared.deep) in interior.neutrals
        for name in FINISHES:
            finish = shared.finish(name)
            for variant in range(finish.choices):
                family = shared.family(name, variant, np.random.default_rng(variant))
                assert family in finish.families if finish.families else family is None
                liked = [interior.families.get(each, 1.0) for each in finish.families]
                if any(liked):
                    assert interior.families.get(str(family), 1.0) > 0.0, (name, family)
                assert name != "bent_wood" or "stave" not in str(family)
                color = np.array(shared.color(name, variant, np.random.default_rng(0)) or 0.0)
                assert (color >= 0.0).all() and color.max() + finish.transmission <= 1.0
