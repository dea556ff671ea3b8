"""Taxonomies as data: the lists as they were published, and a class for whatever we can make."""

from collections.abc import Callable
from pathlib import Path
from typing import get_args

import pytest
from pxr import Sdf, Usd, UsdGeom, UsdSemantics

from openrooms_usd import names
from openrooms_usd.description.categories import LibraryCategory
from openrooms_usd.usd.semantics import (
    COCO,
    COCO_GROUPS,
    NYU40,
    OPENROOMS45,
    TAXONOMIES,
    UNLABELED,
    class_of,
    classes,
    is_labelled,
    label,
    number_of,
    read_category,
    read_label,
    read_number,
    unread_labels,
)


def numbered(text: str) -> dict[int, str]:
    """Names by their numbers, written in turn."""
    words = text.split()
    return {int(number): name for number, name in zip(words[::2], words[1::2], strict=True)}


# Numbers that users of ScanNet and NYU Depth V2 know by heart, from the benchmark's own list.
SCANNET20 = numbered(
    """
    1 wall 2 floor 3 cabinet 4 bed 5 chair 6 sofa 7 table 8 door 9 window 10 bookshelf
    11 picture 12 counter 14 desk 16 curtain 24 refridgerator 28 shower_curtain 33 toilet
    34 sink 36 bathtub 39 otherfurniture
    """
)

# Every tenth row of ADE20K's objectInfo150, and all rows that share a word with another.
OBJECT_INFO_150 = numbered(
    """
    1 wall 4 floor 6 ceiling 9 windowpane 10 grass 15 door 20 chair 30 field 31 armchair
    32 seat 40 cushion 41 base 45 chest_of_drawers 46 counter 50 fireplace 54 stairs 58 pillow
    59 screen_door 60 stairway 64 blind 65 coffee_table 70 bench 71 countertop 80 hovel
    83 light 90 television_receiver 100 buffet 110 swimming_pool 120 ball 122 step 126 pot
    130 dishwasher 131 screen 140 fan 142 crt_screen 144 monitor 150 flag
    """
)

# The end of COCO's list, where rooms are, and the numbers that it skips.
COCO_FROM_60 = numbered(
    """
    60 donut 61 cake 62 chair 63 couch 64 potted_plant 65 bed 67 dining_table 70 toilet 72 tv
    73 laptop 74 mouse 75 remote 76 keyboard 77 cell_phone 78 microwave 79 oven 80 toaster
    81 sink 82 refrigerator 84 book 85 clock 86 vase 87 scissors 88 teddy_bear 89 hair_drier
    90 toothbrush
    """
)
COCO_NEVER_USED = {12, 26, 29, 30, 45, 66, 68, 69, 71, 83}


def test_the_lists_have_the_published_length_and_no_name_twice() -> None:
    lengths = {names.OPENROOMS45: 45, names.NYU40: 40, names.ADE20K: 150, names.COCO: 80}
    assert {taxonomy: len(listed) - 1 for taxonomy, listed in TAXONOMIES.items()} == lengths
    for listed in TAXONOMIES.values():
        assert len(set(listed.values())) == len(listed)
        assert listed[0] == UNLABELED


def test_numbers_of_ade20k_and_coco_are_the_published_ones() -> None:
    assert {number: TAXONOMIES[names.ADE20K][number] for number in OBJECT_INFO_150} == (
        OBJECT_INFO_150
    )
    assert {n: c for n, c in COCO.items() if n >= 60} == COCO_FROM_60
    assert set(range(91)) - set(COCO) == COCO_NEVER_USED
    grouped = [name for members in COCO_GROUPS.values() for name in members]
    assert [UNLABELED, *grouped] == list(COCO.values())


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
            assert name in TAXONOMIES[taxonomy].values()


# Some of each list: what rooms are made of, what has a word of its own, and what has none.
MEANT = {
    "skirting": ("wall", UNLABELED),
    "window": ("windowpane", UNLABELED),
    "floor": ("floor", UNLABELED),
    "ceiling": ("ceiling", UNLABELED),
    "door": ("door", UNLABELED),
    "sofa": ("sofa", "couch"),
    "television": ("television_receiver", "tv"),
    "office_chair": ("swivel_chair", "chair"),
    "worktop": ("countertop", UNLABELED),
    "plant_pot": ("plant", "potted_plant"),
    "trash_bin": ("ashcan", UNLABELED),
    "mug": (UNLABELED, "cup"),
    "blinds": ("blind", UNLABELED),
    "cable": (UNLABELED, UNLABELED),
}


def test_what_things_are_in_ade20k_and_coco() -> None:
    row = {name: (classes()[name].ade20k, classes()[name].coco) for name in MEANT}
    assert row == MEANT


@pytest.mark.parametrize("taxonomy", TAXONOMIES)
def test_a_class_of_our_own_name_is_that_class(taxonomy: str) -> None:
    same = set(classes()) & set(TAXONOMIES[taxonomy].values())
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
    numbers = {names.NYU40: 35, names.OPENROOMS45: 32, names.ADE20K: 37}
    for taxonomy, number in numbers.items():
        assert read_label(shade, taxonomy) == "lamp"
        assert read_number([shade, lamp], taxonomy) == number
    assert read_label(shade, names.COCO) == UNLABELED


def test_what_a_label_says_counts_more_than_the_table() -> None:
    stage = Usd.Stage.CreateInMemory()
    prim = UsdGeom.Xform.Define(stage, "/thing").GetPrim()
    label(prim, "side_table")
    assert read_number([prim], names.NYU40) == NYU40.index("table")
    prim.GetAttribute("semantics:labels:nyu40").Set(["night_stand"])
    assert read_number([prim], names.NYU40) == NYU40.index("night_stand") == 32
    bare = UsdGeom.Xform.Define(stage, "/bare").GetPrim()
    assert read_number([bare], names.NYU40) == 0


# What others label.

KNOWN = {
    ("category", ("chair",)): "chair",
    ("class", ("chair",)): "chair",
    ("class", ("Chair",)): "chair",
    ("category", ("couch",)): "sofa",
    ("class", ("Dining Table",)): "table",
    ("class", ("officeChair",)): "office_chair",
    ("class", ("light",)): "lamp",
    ("class", ("Person",)): "person",
    ("category", ("furniture", "chair")): "chair",
    ("category", ("chair", "furniture")): "chair",
    ("category", ("armchair", "chair")): "armchair",
    ("category", ("chair", "armchair")): "armchair",
    ("category", ("furniture", "lamp", "floor_lamp")): "floor_lamp",
}


@pytest.mark.parametrize(("taxonomy", "words"), KNOWN)
def test_words_of_others_are_read(taxonomy: str, words: tuple[str, ...]) -> None:
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/thing")
    UsdSemantics.LabelsAPI.Apply(prim, taxonomy).CreateLabelsAttr(list(words))
    expected = KNOWN[taxonomy, words]
    assert read_category([prim]) == expected
    ours = stage.DefinePrim("/ours")
    label(ours, expected)
    for listed in TAXONOMIES:
        assert read_number([prim], listed) == read_number([ours], listed)
    assert (is_labelled(prim), list(unread_labels(prim))) == (True, [])


def _of_old_isaac(prim: Usd.Prim, *said: tuple[str, str]) -> None:
    applied = Sdf.TokenListOp()
    applied.explicitItems = [f"SemanticsAPI:Semantics_{n}" for n in range(len(said))]
    prim.SetMetadata("apiSchemas", applied)
    for number, pair in enumerate(said):
        for end, value in zip(("Type", "Data"), pair, strict=True):
            name = f"semantic:Semantics_{number}:params:semantic{end}"
            prim.CreateAttribute(name, Sdf.ValueTypeNames.String).Set(value)


def test_labels_of_isaac_before_5_are_read() -> None:
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/thing")
    _of_old_isaac(prim, ("class", "furniture"), ("class", "Sofa"), ("color", "red"))
    assert read_category([prim]) == "sofa"
    assert read_number([prim], names.COCO) == 63
    (told,) = unread_labels(prim)
    assert "red" in told and "color" in told


@pytest.mark.parametrize(
    ("taxonomy", "words", "expected"),
    [
        ("wikidata_qcode", ["Q15026"], "Q15026"),
        ("class", ["frob", "nicator"], "nicator"),
        ("nyu40", ["no_such"], "no_such"),
    ],
)
def test_labels_that_nobody_knows_are_told(taxonomy: str, words: list[str], expected: str) -> None:
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/thing")
    UsdSemantics.LabelsAPI.Apply(prim, taxonomy).CreateLabelsAttr(words)
    assert read_number([prim], names.NYU40) == 0
    (told,) = unread_labels(prim)
    assert expected in told


def test_a_label_without_its_schema_is_told() -> None:
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/thing")
    kind = Sdf.ValueTypeNames.TokenArray
    prim.CreateAttribute("semantics:labels:class", kind).Set(["chair"])
    assert not is_labelled(prim)
    (told,) = unread_labels(prim)
    assert "semantics:labels:class" in told


def test_the_nearest_prim_that_says_anything_counts() -> None:
    stage = Usd.Stage.CreateInMemory()
    bed, chair = stage.DefinePrim("/bed"), stage.DefinePrim("/bed/chair")
    label(bed, "bed")
    UsdSemantics.LabelsAPI.Apply(chair, "class").CreateLabelsAttr(["chair"])
    assert read_number([chair, bed], names.NYU40) == NYU40.index("chair")
    assert not list(unread_labels(bed))
