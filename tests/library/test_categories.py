"""One record a category: complete, beside its builder, and the only place that lists it."""

import ast
import re
from dataclasses import MISSING, fields
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from openrooms_usd.categories.makes import ANY
from openrooms_usd.categories.others import OTHERS
from openrooms_usd.categories.record import Category, Without, given
from openrooms_usd.categories.registry import BUILT, module_of, modules, record, records
from openrooms_usd.categories.words import library_words
from openrooms_usd.description.categories import LibraryCategory
from openrooms_usd.description.room import RoomType
from openrooms_usd.library.furniture import CATEGORIES, category
from openrooms_usd.library.furniture.built import BuiltCategory
from openrooms_usd.library.furniture.lying import Place, Pose
from openrooms_usd.scan.placement.support import CEILING, FLOOR, OBJECT, WALL, usual_support
from openrooms_usd.usd.semantics import TAXONOMIES, classes

ROOT = Path(__file__).parents[2]
FURNITURE = ROOT / "openrooms_usd/library/furniture"
NAME = "openrooms_usd/description/categories.py"
# Most things neither lie about nor carry what does, and their size says how they are photographed.
_USUALLY_NOTHING = ("lies", "carries", "photographed")


@pytest.mark.parametrize("name", BUILT)
def test_every_record_is_complete(name: str) -> None:
    told = record(name)
    assert isinstance(told, BuiltCategory)
    for field in fields(told):
        value = getattr(told, field.name)
        if isinstance(value, Without):
            assert len(value.reason.split()) >= 4, f"{name}: {field.name} is without a reason"
        elif field.name not in ("also", "fixed", "round", "alike", "worktop", *_USUALLY_NOTHING):
            assert value not in (None, "", (), {}), f"{name}: {field.name} is empty"
    assert told.description[0].islower() and not told.description.endswith(".")
    least, size, most = np.array([told.least, told.size, told.most])
    assert (least <= size).all() and (size <= most).all()
    assert told.support not in told.also
    assert (told.support == "wall") == (not isinstance(told.level, Without))
    assert set(given(told.weighs, {ANY: (0, 1)})) - {ANY} <= set(told.styles)
    assert all(low < high for low, high in given(told.weighs, {}).values())


def test_nothing_of_a_record_is_optional() -> None:
    for kind in (Category, BuiltCategory):
        for field in fields(kind):
            if field.name not in _USUALLY_NOTHING:
                assert field.default is MISSING and field.default_factory is MISSING, field.name


@pytest.mark.parametrize("name", BUILT)
def test_where_things_lie_is_said_in_known_words(name: str) -> None:
    told = CATEGORIES[name]
    for lies in told.lies:
        assert lies.on and set(lies.on) <= set(get_args(Place)), name
        assert set(lies.rooms) <= set(get_args(RoomType)), name
        assert set(lies.styles) <= set(told.styles), name
        assert lies.pose in get_args(Pose) and 0.0 < lies.weight <= 10.0, name
        assert 1 <= lies.count[0] <= lies.count[1] and 1 <= lies.clutter <= 3, name
    assert set(told.carries) <= set(get_args(Place)), name


def test_every_record_stands_in_the_module_of_its_name_and_has_its_name_in_the_list() -> None:
    holding = {
        path.stem
        for path in FURNITURE.glob("*.py")
        for node in ast.parse(path.read_text("utf-8")).body
        if isinstance(node, ast.AnnAssign) and ast.unparse(node.target) == "CATEGORY"
    }
    assert holding == set(BUILT) == set(get_args(LibraryCategory)) == set(CATEGORIES)
    assert list(BUILT) == sorted(BUILT)
    assert modules() == tuple(f"openrooms_usd.library.furniture.{name}" for name in BUILT)
    assert all(module_of(name).endswith(f".{name}") for name in BUILT)
    assert not set(BUILT) & set(OTHERS)
    assert record("no such thing") is None and record("") is None


def tables(path: Path) -> list[str]:
    """Places where five categories or more are the keys or the members of one table."""
    known = {name for name, _ in records()}
    text = path.read_text("utf-8")
    if len(known & set(re.findall(r"\w+", text))) < 5:
        return []
    found = []
    for node in ast.walk(ast.parse(text)):
        members: list[ast.expr | None] = []
        if isinstance(node, ast.Dict):
            members = [*node.keys]
        elif isinstance(node, ast.Tuple | ast.List | ast.Set):
            members = [*node.elts]
        words = [m.value for m in members if isinstance(m, ast.Constant)]
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            words = node.value.split() if len(node.value) < 500 else []
        words = sorted({str(word) for word in words})
        if len(words) >= 5 and sum(word in known for word in words) >= 0.8 * len(words):
            found.append(f"{path.relative_to(ROOT)}:{node.lineno}")
    return found


def test_no_table_of_categories_stands_beside_the_records() -> None:
    allowed = {
        NAME,
        "openrooms_usd/categories/others.py",
        # What may stand for each other: said of several at once.
        "openrooms_usd/categories/words.py",
        # The shell of rooms, which several stages leave alone.
        "openrooms_usd/names.py",
        # What is fixed to the shell: which key says its material.
        "openrooms_usd/stages/surfaces.py",
        "openrooms_usd/view/fields.py",
        # The class lists of others, in their own words and numbers.
        "openrooms_usd/usd/semantics.py",
        "converters/orusd_scans/sunrgbd/files.py",
        # RoomPlan's words for the shell.
        "converters/orusd_scans/roomplan/usdz.py",
        "converters/orusd_scans/roomplan/components.py",
        # What is special about objects of the OpenRooms release.
        "converters/orusd_openrooms/scenes/sceneobjects.py",
        # NYU40's numbers for the shell.
        "openrooms_usd/scan/segmentation/labelled.py",
    }
    found = [
        place
        for folder in ("openrooms_usd", "schemas", "converters")
        for path in sorted((ROOT / folder).rglob("*.py"))
        if str(path.relative_to(ROOT)) not in allowed
        for place in tables(path)
    ]
    assert found == []


def test_no_document_lists_the_categories() -> None:
    for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/*.md")):
        for paragraph in path.read_text("utf-8").split("\n\n"):
            named = set(re.findall(r"`([a-z_]+)`", paragraph)) & set(BUILT)
            assert len(named) < 7, f"{path.name}: {sorted(named)}"


def test_words_and_synsets_mean_one_category() -> None:
    said = [word for _, told in records() for word in given(told.words, "").split()]
    assert len(said) == len(set(said))
    assert not set(said) & set(BUILT)
    synsets = [synset for _, told in records() for synset in given(told.synsets, ())]
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
    assert (category("box").support, category("box").also) == ("floor", ("surface",))
    assert usual_support("picture") == usual_support("mirror") == WALL
    assert usual_support("chandelier") == CEILING
    assert usual_support("cabinet") is usual_support("television") is None
    assert usual_support("bag") is usual_support("no such thing") is None
