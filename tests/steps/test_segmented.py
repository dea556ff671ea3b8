"""Scans that nobody labelled: what finds their things, what is noted, and what can be asked."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from openrooms_usd import adapters
from openrooms_usd.description.furniture import ScanFurniture
from openrooms_usd.errors import InputError
from openrooms_usd.scan.artefact import FoundScan
from openrooms_usd.scan.placement.settling import Unresolved
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.reconstruction import FoundFurniture
from openrooms_usd.scan.registration.hints import Box
from openrooms_usd.scan.results import FoundObject, FoundRoom, Pose
from openrooms_usd.scan.segmentation.contract import Segments
from openrooms_usd.steps.alignment.captured import UNKNOWN
from openrooms_usd.steps.alignment.furnished import _furniture_notes, segmented


def scan_of(cloud: Cloud, **known: Any) -> FoundScan:
    corners = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], float)
    room = FoundRoom(np.array([0.0, 0, 1]), np.zeros(3), corners, ceiling=2.5)
    return FoundScan("scan.ply", cloud, (room,), (0,), np.eye(4), **known)


def asked(**keys: Any) -> ScanFurniture:
    return ScanFurniture(**{"from": "scan", **keys})


def carton() -> Cloud:
    """The top and the sides of a carton in the middle of the room."""
    steps = np.arange(0.0, 0.6001, 0.02)
    u, v = (grid.ravel() for grid in np.meshgrid(steps, steps))
    low, high = np.zeros_like(u), np.full_like(u, 0.6)
    faces = [(u, v, high), (u, low, v), (u, high, v), (low, u, v), (high, u, v)]
    return Cloud(
        np.concatenate([np.column_stack(face) for face in faces]) + np.array([1.7, 1.7, 0.0])
    )


def run(cloud: Cloud, furniture: ScanFurniture, **known: Any) -> tuple[Cloud, list[str]]:
    context = SimpleNamespace(notes=[])
    found = segmented(context, furniture, scan_of(cloud, **known))  # type: ignore[arg-type]
    return found.cloud, context.notes


def test_things_are_found_and_people_are_told() -> None:
    cloud, notes = run(carton(), asked())
    assert cloud.words == {1: ("object",)}
    assert cloud.instance is not None
    assert (cloud.instance == 1).mean() > 0.8
    assert "the scan has no labels" in notes[0]
    assert "1 without a name" in notes[0]
    assert "--segments FILE" in notes[0]


def test_a_desk_of_no_desk_s_size_is_a_box_for_its_size_alone() -> None:
    pose = Pose(np.eye(3), np.zeros(3), np.ones(3))
    boxes = [
        FoundObject(number, UNKNOWN, "box", pose, 0.0, 1.0, word=word)
        for number, word in enumerate(("desk", "small desk", "sculpture"), 1)
    ]
    assert list(_furniture_notes(FoundFurniture(tuple(boxes)), 0)) == [
        "no category fits, so boxes replace: sculpture",
        "impossible sizes for their categories, so boxes replace: desk, small desk",
    ]


@pytest.mark.parametrize(
    ("kind", "support", "said"),
    [
        ("floats", "wall", "0.03 m away from the wall that it hangs on"),
        ("floats", "floor", "0.03 m above everything that can carry it"),
        ("in a wall", "wall", "0.03 m beyond the walls"),
    ],
)
def test_what_is_wrong_still_is_said_with_its_place(kind: Any, support: str, said: str) -> None:
    pose = Pose(np.eye(3), np.zeros(3), np.ones(3))
    thing = FoundObject(1, "pillow", "pillow", pose, 0.0, 1.0, word="pillow", support=support)
    found = FoundFurniture((thing,), unresolved=(Unresolved(kind, 1, None, 0.03),))
    assert list(_furniture_notes(found, 0)) == [f"not resolved: the pillow (instance 1) is {said}"]


def test_nothing_is_looked_for_where_that_is_asked_but_it_is_said() -> None:
    cloud, notes = run(carton(), asked(unlabelled="leave_out"))
    assert cloud.instance is None
    assert "the scan has no labels" in notes[0]


def test_an_empty_room_is_told_too() -> None:
    cloud, notes = run(Cloud(np.random.default_rng(0).uniform(0, 4, (200, 3)) * [1, 1, 0]), asked())
    assert not cloud.words
    assert "nothing was found by their shape" in notes[0]


@pytest.mark.parametrize("kind", ["instances", "boxes", "objects"])
def test_what_the_scan_or_the_description_says_counts(kind: str) -> None:
    cloud = carton()
    marked = replace(cloud, instance=np.ones(len(cloud), "i4"))
    box = ("sofa", Box(np.zeros(3), np.ones(3), np.array([1.0, 0, 0, 0])))
    found, notes = {
        "instances": lambda: run(marked, asked()),
        "boxes": lambda: run(cloud, asked(), captured=(box,)),
        "objects": lambda: run(cloud, asked(objects=({"instance": 1, "category": "sofa"},))),
    }[kind]()
    assert found.words is None
    assert notes == []


def test_labels_without_numbers_make_things_of_connected_points() -> None:
    cloud = carton()
    label = np.full(len(cloud), 29, "i4")
    label[:5] = 2
    found, notes = run(replace(cloud, label=label), asked())
    assert found.words == {1: ("box",)}
    assert found.instance is not None
    assert not found.instance[:5].any()
    assert "connected points of one label" in notes[0]


class _Halves:
    """A segmenter that cuts the scan in two."""

    def segment(self, cloud: Cloud, rooms: tuple[FoundRoom, ...]) -> Segments:
        assert len(rooms) == 1
        left = cloud.points[:, 0] < 2.0
        return Segments(np.where(left, 1, 2).astype("i8"), {1: "guitar", 2: "sofa"})


def test_a_segmenter_of_somebody_else_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(adapters, "load", lambda group, name: {"halves": _Halves}[name]())
    cloud, notes = run(carton(), asked(segmenter="halves"))
    assert cloud.words == {1: ("guitar",), 2: ("sofa",)}
    assert "found by 'halves': 1 guitar, 1 sofa" in notes[0]
    boxes, _ = run(carton(), asked(segmenter="halves", unlabelled="boxes"))
    assert boxes.words == {1: ("object",), 2: ("object",)}


def test_a_segmenter_that_is_not_there_is_named() -> None:
    with pytest.raises(InputError, match="no segmenter is named 'sahpes'"):
        run(carton(), asked(segmenter="sahpes"))


def test_our_own_needs_no_installation() -> None:
    cloud, _ = run(carton(), asked(segmenter="shapes"))
    assert cloud.words == {1: ("object",)}
