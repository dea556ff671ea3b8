"""What captures call things becomes what the library builds, and nothing that nobody said."""

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.capture import read_capture
from openrooms_usd.categories.registry import BUILT
from openrooms_usd.categories.words import Meaning, meaning, named_in, plain
from openrooms_usd.errors import InputError
from openrooms_usd.names import SHELL
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.stages.instances import instances_of, told_left_out
from openrooms_usd.usd.semantics import NYU40

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
    assert unknown == {
        "unlabeled", "box", "otherstructure", "otherfurniture",
        "otherprop",
    }  # fmt: skip


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
        (1, "guitar", "thing"), (2, "otherfurniture", "thing"), (3, "wall", "building"),
    ]  # fmt: skip
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
    with pytest.raises(InputError, match="no table of words"):
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
