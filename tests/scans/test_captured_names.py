"""Captured things keep their names in every import, and get what the library has for them."""

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from openrooms_usd.capture import Capture, CapturedBox, read_capture
from openrooms_usd.description.naming import captured_names
from openrooms_usd.errors import InputError
from openrooms_usd.furniture import category
from openrooms_usd.furniture.registry import BUILT
from openrooms_usd.furniture.words import Meaning, library_words, meaning, named_in, plain
from openrooms_usd.names import SHELL
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.steps.alignment.captured import Captured, captured_objects, substitute
from openrooms_usd.steps.alignment.instances import instances_of, told_left_out
from openrooms_usd.usd.semantics import NYU40

THINGS = st.lists(
    st.tuples(st.sampled_from(["chair", "table"]), st.text(max_size=12)), unique=True, max_size=20
)
Real = Callable[[str], Path]
# What class lists say of things that they do not know.
BINS = """otherstructure otherfurniture otherprop other_furniture clutter object objects unknown
    other misc furniture unlabeled unannotated appliances seating gym_equipment stuff item thing"""
S3DIS = "beam table chair sofa bookcase board column"
ARKIT = """cabinet refrigerator shelf stove bed sink washer toilet bathtub oven dishwasher fireplace
    stool chair table tv_monitor sofa"""
MATTERPORT = """chair table picture cabinet cushion sofa bed curtain chest_of_drawers plant sink
    stairs toilet stool mirror tv_monitor bathtub counter fireplace lighting
    shelving blinds board_panel"""
SUN = """bed table sofa chair toilet desk dresser night_stand bookshelf bathtub garbage_bin endtable
    sofa_chair recycle_bin fridge tv file_cabinet"""


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
    assert notes == [
        "captured 'chair' has an impossible size for its category: a box stands for it"
    ]


def first(*words: str, bottom: float = 0.0) -> str:
    choices = meaning(words, bottom).choices
    return choices[0][0] if choices else "box"


@pytest.mark.parametrize("word", BINS.split())
def test_bins_of_class_lists_are_never_named_things(word: str) -> None:
    for spelling in (word, word.replace("_", " "), word.title()):
        assert meaning((spelling,), 0.0) == Meaning("thing")


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        ("trash can", "trash_bin"),
        ("trashcan", "trash_bin"),
        ("toaster", "toaster"),
        ("toaster oven", "microwave"),
        ("night stand", "night_stand"),
        ("office chair", "office_chair"),
        ("laundry basket", "basket"),
        ("flat-screen television", "television"),
        ("kitchen cabinets", "kitchen_cabinet"),
        ("wooden stool", "stool"),
        ("stack of chairs", "box"),
        ("sink counter", "counter"),
        ("counter top for sink", "counter"),
        ("shower curtain", "curtain"),
        ("shower curtain rod", "box"),
        ("mirror", "mirror"),
        ("floor mat", "rug"),
        ("guitar", "guitar"),
        ("guitar case", "box"),
        ("backpack", "backpack"),
        ("shower", "shower"),
        ("scale", "scales"),
        ("tissue box", "tissue_box"),
        ("paper towel", "toilet_paper"),
        ("toilet paper", "toilet_paper"),
        ("paper towel dispenser", "box"),
        ("ironing board", "ironing_board"),
        ("dish rack", "dish_rack"),
        ("hair dryer", "box"),
        ("storage bin", "basket"),
    ],
)
def test_words_are_what_their_last_noun_says(word: str, expected: str) -> None:
    assert first(word) == expected


def test_the_lists_of_data_sets_are_understood() -> None:
    said = [word for text in (S3DIS, ARKIT, MATTERPORT, SUN) for word in text.split()]
    assert [word for word in said if first(word) == "box"] == ["beam", "column"]
    unknown = {word for word in NYU40 if meaning((word,), 0.0) == Meaning("thing")}
    assert unknown == {"unlabeled", "box", "otherstructure", "otherfurniture", "otherprop"}


def test_the_building_is_left_to_the_layout_and_people_are_left_out() -> None:
    for word in ("wall", "floor", "window frame", "doorframe", "closet door", "shower wall"):
        assert meaning((word,), 0.0).kind == "building"
    assert meaning(("person",), 0.0).kind == "nothing"


def test_the_first_word_that_means_something_counts() -> None:
    assert first("poubelle", "ashcan", "otherfurniture") == "trash_bin"
    assert first("guitar", "table") == "guitar"
    assert first("gibberish", "otherprop") == "box"


def test_lamps_and_wall_cabinets_are_told_by_their_height() -> None:
    assert first("desk lamp", bottom=0.75) == "table_lamp"
    assert first("bed lamp", bottom=2.0) == "ceiling_lamp"
    assert "kitchen_cabinet" not in meaning(("cabinet",), 0.0).choices[0]
    assert "kitchen_cabinet" in meaning(("cabinet",), 1.5).choices[0]


def test_file_names_say_what_a_cad_is() -> None:
    assert named_in("couch-medium") == "sofa"
    assert named_in("floor-lamp") == "floor_lamp"
    assert named_in("model_17") is None


def test_instances_go_by_their_words_and_else_by_their_classes() -> None:
    points = np.zeros((6, 3))
    label = np.array([40, 40, 39, 39, 1, 5], np.int32)
    instance = np.array([1, 1, 2, 2, 3, 0], np.int32)
    cloud = Cloud(points, label=label, instance=instance, words={1: ("guitar", "otherprop")})
    found = instances_of(cloud)
    assert found is not None
    assert [(one.number, one.words[0], one.meaning.kind) for one in found] == [
        (1, "guitar", "thing"),
        (2, "otherfurniture", "thing"),
        (3, "wall", "building"),
    ]
    # A folder of CADs may have a guitar; the library has none.
    assert found[0].hint.choices == (("guitar",),)
    assert not any("40" in note or "NYU" in note for note in told_left_out(found))
    assert instances_of(Cloud(points, instance=instance)) is None
    assert instances_of(Cloud(points, label=label)) is None


def test_words_of_scannet(real: Real) -> None:
    """Nothing becomes part of the building but what the table files there, and no bin is named."""
    path = real("real_dev/data/scannet_0000_00/scannet-labels.combined.tsv")
    with path.open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines, delimiter="\t"))
    known = 0
    for row in rows:
        found = meaning((row["category"],), 0.0)
        shell = row["nyu40class"] in (*SHELL, "otherstructure", "otherprop")
        assert found.kind != "building" or shell, row["category"]
        known += int(row["count"]) if found.choices or found.kind != "thing" else 0
        for group in found.choices:
            assert set(group) <= set(BUILT)
    # Of all things that are annotated in ScanNet seven in eight are of the library or the building.
    assert known > 0.875 * sum(int(row["count"]) for row in rows)
    assert plain("washerDryer") == "washer_dryer"


def test_a_plain_scan_may_have_words(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    points, instance = rng.random((90, 3)), np.repeat(np.array([0, 1, 2], np.int32), 30)
    np.savez(tmp_path / "a.npz", points=points, instance=instance)
    table = tmp_path / "words.json"
    table.write_text('{"1": "guitar", "2": "trash can"}')
    cloud = read_capture("scan", tmp_path / "a.npz", {"words": str(table)}).cloud
    assert cloud is not None
    found = instances_of(cloud)
    assert found is not None
    assert [one.words[0] for one in found] == ["guitar", "trash can"]
    table.write_text('["guitar"]')
    with pytest.raises(InputError, match="not a table of words"):
        read_capture("scan", tmp_path / "a.npz", {"words": str(table)})


def test_labels_may_be_numbers_of_another_list(tmp_path: Path) -> None:
    """S3DIS counts ceilings from 0; NYU40 would take its floor for a wall."""
    side = np.arange(0.0, 1.0, 0.02)
    plane = np.stack(np.meshgrid(side, side), -1).reshape(-1, 2)
    heights, label = np.array([2.5, 0.0, 0.5]), np.array([0, 1, 8], np.int32)
    points = np.concatenate([np.column_stack([plane, np.full(len(plane), z)]) for z in heights])
    np.savez(tmp_path / "a.npz", points=points, label=np.repeat(label, len(plane)))
    table = tmp_path / "s3dis.json"
    table.write_text('{"0": "ceiling", "1": "floor", "8": "chair"}')
    cloud = read_capture("scan", tmp_path / "a.npz", {"classes": str(table)}).cloud
    assert cloud is not None
    assert cloud.label is not None
    assert [NYU40[n] for n in cloud.label[:: len(plane)]][:2] == ["ceiling", "floor"]
    assert cloud.words == {1: ("chair",)}
    with pytest.raises(InputError, match="no labels"):
        np.savez(tmp_path / "b.npz", points=points)
        read_capture("scan", tmp_path / "b.npz", {"classes": str(table)})
