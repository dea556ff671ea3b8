"""One record a category, beside its builder."""

import re
from dataclasses import MISSING, fields
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from openrooms_usd.description.categories import LibraryCategory
from openrooms_usd.description.room import RoomType
from openrooms_usd.furniture import CATEGORIES, category
from openrooms_usd.furniture.joinery.pieces import Style
from openrooms_usd.furniture.others import OTHERS
from openrooms_usd.furniture.placements import Place, Pose
from openrooms_usd.furniture.record import BuiltCategory
from openrooms_usd.furniture.registry import BUILT, module_of, modules, record, records
from openrooms_usd.furniture.words import library_words, meaning
from openrooms_usd.scan.placement.support import CEILING, FLOOR, OBJECT, WALL, usual_support
from openrooms_usd.usd.semantics import TAXONOMIES, classes


@pytest.mark.parametrize("name", BUILT)
def test_records_hold_together(name: str) -> None:
    told = CATEGORIES[name]
    assert told.description[0].islower() and not told.description.endswith(".")
    low, size, high = np.array([told.min_size, told.size, told.max_size])
    assert (low <= size).all() and (size <= high).all() and (low > 0.0).all()
    assert told.support not in told.alternative_supports
    assert (told.support == "wall") == (told.mount_height > 0.0)
    masses = filter(None, [told.mass_range, *map(told.mass_range_of, told.styles)])
    assert all(0.0 < light < heavy for light, heavy in masses)
    assert 0.0 <= told.on_worktop_probability <= 1.0 and told.lumen >= 0.0


def test_a_plain_record_says_what_its_category_is_and_nothing_else() -> None:
    plain = BuiltCategory(description="a thing", size=(0.4, 0.2, 1.0), styles={"one": Style(dict)})
    required = [
        field.name
        for field in fields(plain)
        if field.default is MISSING and field.default_factory is MISSING
    ]
    assert required == ["description", "size", "styles"]
    assert (plain.min_size, plain.max_size) == ((0.2, 0.1, 0.5), (0.8, 0.4, 2.0))
    assert plain.support == "floor" and not plain.emits and plain.mass_range_of("one") is None


@pytest.mark.parametrize("name", BUILT)
def test_where_things_lie_is_said_in_known_words(name: str) -> None:
    told = CATEGORIES[name]
    for placement in told.placements:
        assert placement.on and set(placement.on) <= set(get_args(Place)), name
        assert set(placement.rooms) <= set(get_args(RoomType)), name
        assert set(placement.styles) <= set(told.styles), name
        assert placement.pose in get_args(Pose) and 0.0 < placement.weight <= 10.0, name
        least, most = placement.count
        assert 1 <= least <= most and 1 <= placement.clutter <= 3, name
    assert set(told.offers_surfaces) <= set(get_args(Place)), name


def test_every_module_of_categories_is_a_category() -> None:
    assert set(BUILT) == set(get_args(LibraryCategory)) == set(CATEGORIES)
    assert list(BUILT) == sorted(BUILT) and len(BUILT) >= 148
    assert modules() == tuple(f"openrooms_usd.furniture.categories.{name}" for name in BUILT)
    assert all(module_of(name).endswith(f".{name}") for name in BUILT)
    assert not set(BUILT) & set(OTHERS)
    assert record("no such thing") is None and record("") is None


def test_words_and_synsets_mean_one_category() -> None:
    said = [word for _, told in records() for word in told.words.split()]
    assert len(said) == len(set(said))
    assert not set(said) & set(BUILT)
    synsets = [synset for _, told in records() for synset in told.synsets]
    assert len(synsets) == len(set(synsets))
    assert all(len(synset) == 8 and synset.isdigit() for synset in synsets)
    for name in BUILT:
        assert library_words()[name] == name


def test_classes_are_those_of_the_lists() -> None:
    assert set(classes()) == {*BUILT, *OTHERS}
    for name, row in classes().items():
        for taxonomy, word in row._asdict().items():
            assert word in TAXONOMIES[taxonomy].values(), name


def test_what_carries_a_thing_is_said_once() -> None:
    # By what stands in a record: the floor alone, an object, either, a wall, and what must be seen.
    assert usual_support("sofa") == FLOOR
    assert usual_support("laptop") == OBJECT
    assert usual_support("basket") == usual_support("box") == OBJECT
    box = category("box")
    assert (box.support, box.alternative_supports) == ("floor", ("surface",))
    assert usual_support("picture") == usual_support("mirror") == WALL
    assert usual_support("chandelier") == CEILING
    assert usual_support("cabinet") is usual_support("television") is None
    assert usual_support("bag") is usual_support("no such thing") is None


def test_the_table_of_the_words_of_captures_is_true() -> None:
    """Each word is built as the table of docs/howto/captures.md has it, or is a box, or nothing."""
    text = (Path(__file__).parents[2] / "docs/howto/captures.md").read_text(encoding="utf-8")
    table = text[text.index("| a capture says |") :].partition("\n\n")[0].splitlines()[2:]
    for row in table:
        words, seen = (cell.strip() for cell in row.strip("|").split("|"))
        named = re.findall(r"`(\w+)`", seen)
        found = [meaning([word], 0.3) for word in words.split(", ")]
        first = {one.choices[0][0] for one in found if one.choices}
        assert first == set(named), row
        assert all((one.kind != "thing") == seen.startswith("nothing") for one in found), row
    assert len(table) > 20
