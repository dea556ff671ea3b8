"""Captured things keep their names in every import, and get what the library has for them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrooms_usd.capture import Capture, CapturedBox
from openrooms_usd.categories.words import library_words, plain
from openrooms_usd.description.naming import captured_names
from openrooms_usd.library.furniture import category
from openrooms_usd.stages.alignment.captured import Captured, captured_objects, substitute

THINGS = st.lists(
    st.tuples(st.sampled_from(["chair", "table"]), st.text(max_size=12)), unique=True, max_size=20
)


def test_short_words_are_names_and_others_are_hashed() -> None:
    assert captured_names([("chair", "a7"), ("chair", "B9F64B1B-5B7C-498F")]) == [
        "chair_a7",
        "chair_441e04",
    ]
    # Bare numbers are those of described things.
    assert captured_names([("chair", "0")]) == ["chair_5feceb"]


@given(THINGS, st.randoms())
def test_names_do_not_depend_on_order_nor_on_others(
    things: list[tuple[str, str]], random: object
) -> None:
    names = dict(zip(things, captured_names(things), strict=True))
    assert len(set(names.values())) == len(things)
    shuffled = list(things)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    assert dict(zip(shuffled, captured_names(shuffled), strict=True)) == names


def test_names_that_collide_get_longer_and_equal_things_a_number() -> None:
    # Two identifiers whose digests begin alike, found by trying.
    pair = [("c", "id 6461"), ("c", "id 7432")]
    assert [captured_names([thing]) for thing in pair] == [["c_17d6b9"], ["c_17d6b9"]]
    names = captured_names(pair)
    assert names == captured_names(pair[::-1])[::-1]
    assert [len(name) for name in names] == [10, 10]
    same = captured_names([("chair", "x"), ("chair", "x"), ("chair", "y")])
    assert same == ["chair_x", "chair_x_1", "chair_y"]
    assert captured_names([("chair", "x")], taken={"chair_x"})[0] != "chair_x"


def box(label: str, identifier: str, x: float = 0.0) -> CapturedBox:
    return CapturedBox(identifier, label, np.array([x, 0, 0.5]), np.eye(3), np.ones(3))


def objects(*boxes: CapturedBox) -> tuple[list[Captured], list[str]]:
    notes: list[str] = []
    return captured_objects(Capture("a", np.eye(4), boxes=boxes), 0.0, (), notes), notes


def test_a_reimport_keeps_all_paths() -> None:
    boxes = [box("chair", f"{i:08X}-AAAA", float(i)) for i in range(20)]
    before = {thing.box.id: thing.name for thing in objects(*boxes)[0]}
    rng = np.random.default_rng(0)
    shuffled = [boxes[i] for i in rng.permutation(20)][1:]
    after = {thing.box.id: thing.name for thing in objects(*shuffled)[0]}
    assert len(after) == 19
    assert after.items() <= before.items()


def test_unknown_things_are_boxes_with_their_own_label() -> None:
    (thing, other, known), notes = objects(
        box("Church Organ!", "p"), box("3D", "q"), box("box", "b")
    )
    assert (thing.category, thing.label, thing.name) == ("box", "church_organ", "church_organ_p")
    assert (other.category, other.name) == ("box", "thing_3d_q")
    assert known.name == "box_b"
    assert len(notes) == 2
    assert "'Church Organ!' is unknown" in notes[1]


def test_every_word_has_a_category_that_can_be_built() -> None:
    for word, name in library_words().items():
        assert category(name), word
        assert plain(word) == word


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        ("washerDryer", "washing_machine"),
        ("night_stand", "night_stand"),
        ("trash can", "trash_bin"),
        ("Kitchen-Cabinet", "kitchen_cabinet"),
        ("couch", "sofa"),
        ("tv", "television"),
        ("TV Stand", "cabinet"),
        ("bookcase", "bookshelf"),
        ("refridgerator", "refrigerator"),
        ("Toaster", "toaster"),
        ("pool table", "pool_table"),
        ("", None),
    ],
)
def test_words_of_other_data_sets_are_understood(label: str, expected: str | None) -> None:
    assert substitute(label, {}, 0.0) == expected


@pytest.mark.parametrize(
    ("label", "key", "value", "expected"),
    [
        ("chair", "ChairType", "swivel", "office_chair"),
        ("chair", "ChairType", "stool", "stool"),
        ("chair", "ChairType", "dining", "chair"),
        ("sofa", "SofaType", "singleSeat", "armchair"),
        ("storage", "StorageType", "shelf", "bookshelf"),
        ("storage", "StorageType", "cabinet", "cabinet"),
        ("table", "TableType", "coffee", "coffee_table"),
        ("table", "TableType", "desk", "desk"),
    ],
)
def test_attributes_choose_better(label: str, key: str, value: str, expected: str) -> None:
    assert substitute(label, {key: value}, 0.0) == expected


def test_lamps_are_told_by_their_height() -> None:
    heights = {0.0: "floor_lamp", 0.7: "table_lamp", 2.0: "ceiling_lamp"}
    for height, expected in heights.items():
        assert substitute("lamp", {}, height) == expected


def test_the_words_are_those_of_the_data_sets() -> None:
    """RoomPlan's categories and the furniture of NYU40 and SUN RGB-D, all but what is no thing."""
    roomplan = "bathtub bed chair dishwasher fireplace oven refrigerator sink sofa stairs storage"
    roomplan += " stove table television toilet washerDryer"
    nyu = "cabinet bed chair sofa table door window bookshelf picture counter blinds desk shelves"
    nyu += " curtain dresser pillow floor_mat refridgerator television box whiteboard night_stand"
    nyu += " toilet sink lamp bathtub"
    unknown = [word for word in (roomplan + " " + nyu).split() if not substitute(word, {}, 0.0)]
    assert unknown == []


def test_sizes_that_no_such_thing_has_are_boxes() -> None:
    """A chair of 3 m is a box that is called chair; a deep bookshelf a cabinet."""
    chair = CapturedBox("a", "chair", np.array([0, 0, 1.5]), np.eye(3), np.full(3, 3.0))
    shelf = CapturedBox("b", "bookshelf", np.array([4, 0, 1.0]), np.eye(3), np.array([2, 1.5, 2.0]))
    screen = CapturedBox("c", "tv", np.array([8, 0, 1.0]), np.eye(3), np.array([1.2, 0.02, 0.7]))
    things, notes = objects(chair, shelf, screen)
    assert [thing.category for thing in things] == ["box", "cabinet", "television"]
    assert things[0].name == "chair_a"
    assert notes == ["captured 'chair' has a size that no such thing has: a box stands for it"]
