"""Taxonomies as data: the lists as they were published, and a class for whatever we can make."""

from collections.abc import Callable
from pathlib import Path
from typing import get_args

import pytest
from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.description.categories import LibraryCategory
from openrooms_usd.usd.semantics import label, read_label, read_number
from openrooms_usd.usd.taxonomies import (
    NYU40,
    OPENROOMS45,
    TAXONOMIES,
    UNLABELED,
    class_of,
    classes,
    number_of,
)

# Numbers that users of ScanNet and NYU Depth V2 know by heart, from the benchmark's own list.
SCANNET20 = {
    1: "wall", 2: "floor", 3: "cabinet", 4: "bed", 5: "chair", 6: "sofa", 7: "table", 8: "door",
    9: "window", 10: "bookshelf", 11: "picture", 12: "counter", 14: "desk", 16: "curtain",
    24: "refridgerator", 28: "shower_curtain", 33: "toilet", 34: "sink", 36: "bathtub",
    39: "otherfurniture",
}  # fmt: skip


def test_the_lists_have_the_published_length_and_no_name_twice() -> None:
    assert (len(NYU40), len(OPENROOMS45)) == (41, 46)
    for listed in TAXONOMIES.values():
        assert len(set(listed)) == len(listed)
        assert listed[0] == UNLABELED


def test_nyu40_numbers_are_those_of_the_benchmarks() -> None:
    assert {number: NYU40[number] for number in SCANNET20} == SCANNET20


def test_openrooms45_is_the_released_list(real: Callable[[str], Path]) -> None:
    rows = real("labels/openrooms45.txt").read_text("utf-8").split()
    numbered = {0: rows[0]} | {
        int(number): name for name, _, number in (row.rpartition("_") for row in rows[1:])
    }
    assert numbered == dict(enumerate(OPENROOMS45))


def test_every_category_has_a_row_and_every_row_names_classes_that_exist() -> None:
    shell = {"wall", "floor", "ceiling", "door", "window", "opening"}
    assert set(classes()) >= {*get_args(LibraryCategory), *shell}
    assert list(classes()) == sorted(classes())
    for row in classes().values():
        for taxonomy, name in row._asdict().items():
            assert name in TAXONOMIES[taxonomy]


@pytest.mark.parametrize("taxonomy", TAXONOMIES)
def test_a_class_of_our_own_name_is_that_class(taxonomy: str) -> None:
    same = set(classes()) & set(TAXONOMIES[taxonomy])
    assert {name: class_of(name, taxonomy) for name in same} == {name: name for name in same}


def test_words_that_are_none_of_ours() -> None:
    assert class_of("mirror", names.NYU40) == "mirror"
    assert class_of("mirror", names.OPENROOMS45) == UNLABELED
    assert number_of("no such class", names.NYU40) == 0


def test_a_prim_is_labelled_in_every_taxonomy() -> None:
    stage = Usd.Stage.CreateInMemory()
    lamp = UsdGeom.Xform.Define(stage, "/lamp").GetPrim()
    shade = UsdGeom.Mesh.Define(stage, "/lamp/shade").GetPrim()
    label(lamp, "floor_lamp")
    assert stage.GetPrimAtPath("/lamp").GetAttribute("semantics:labels:nyu40").Get()[0] == "lamp"
    for taxonomy, number in ((names.NYU40, 35), (names.OPENROOMS45, 32)):
        assert read_label(shade, taxonomy) == "lamp"
        assert read_number(shade, taxonomy) == number


def test_what_a_label_says_counts_more_than_the_table() -> None:
    stage = Usd.Stage.CreateInMemory()
    prim = UsdGeom.Xform.Define(stage, "/thing").GetPrim()
    label(prim, "side_table")
    assert read_number(prim, names.NYU40) == NYU40.index("table")
    prim.GetAttribute("semantics:labels:nyu40").Set(["night_stand"])
    assert read_number(prim, names.NYU40) == NYU40.index("night_stand") == 32
    bare = UsdGeom.Xform.Define(stage, "/bare").GetPrim()
    assert read_number(bare, names.NYU40) == 0
