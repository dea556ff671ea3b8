"""Rooms of a scan that stand wall to wall are composed as one, where that is asked."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from pxr import Usd

from openrooms_usd import names
from openrooms_usd.description import parse_room
from openrooms_usd.description.furniture import ScanFurniture
from openrooms_usd.description.layout import ScanLayout
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.reconstruction import elsewhere, find_rooms
from openrooms_usd.scan.results import FoundOpening, FoundRoom
from openrooms_usd.scan.rooms.flat import flat_of
from openrooms_usd.steps.alignment.furnished import segmented
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.layout.scanned import scanned
from openrooms_usd.steps.layout.step import LayoutStep
from tests.scan.scanned_rooms import RoomScan

HALL = ((0.0, 0.0), (4.0, 0.0), (4.0, 5.0), (0.0, 5.0))
ROOM = ((4.2, 1.0), (7.4, 1.0), (7.4, 5.0), (4.2, 5.0))
FAR = ((12.0, 0.0), (15.0, 0.0), (15.0, 3.0), (12.0, 3.0))


def found(corners: Any, *openings: FoundOpening, **more: Any) -> FoundRoom:
    floor = np.column_stack([np.array(corners), np.zeros(len(corners))])
    room = FoundRoom(np.array([0.0, 0, 1]), np.zeros(3), floor, ceiling=2.5, openings=openings)
    return replace(room, **more)


def hole(
    kind: Any, x: float, y0: float, y1: float, wall: int, sure: float = 0.8, top: float = 2.0
) -> FoundOpening:
    """In a wall along Y."""
    low = 0.0 if kind == "door" else 1.0
    corners = [[x, y0, low], [x, y1, low], [x, y1, top], [x, y0, top]]
    return FoundOpening(kind, np.array(corners, float), sure, wall)


def test_a_door_found_from_both_sides_is_one_and_the_surer_stays() -> None:
    one, other = hole("door", 4.0, 2.0, 2.9, 1, 0.6), hole("door", 4.2, 2.05, 2.95, 3, 0.9)
    flat = flat_of([found(HALL, one), found(ROOM, other)])
    assert flat is not None
    (kept,) = flat.openings
    assert kept.opening is other
    assert kept.between == 0
    assert flat.walls[0].thickness == pytest.approx(0.2)
    assert shapely.Polygon(flat.corners).area == pytest.approx(20.0 + 12.8 + 0.2 * 4)


@pytest.mark.parametrize("turned", [False, True])
def test_a_door_is_as_wide_as_both_its_sides_are_open(turned: bool) -> None:
    # One side is open 30 cm farther; at the other end both say the same but for the scan's drift.
    ends = (3.2, 2.0) if turned else (2.0, 3.2)
    one, other = hole("door", 4.0, *ends, 1, 0.9), hole("door", 4.2, 1.96, 2.9, 3, 0.6)
    flat = flat_of([found(HALL, one), found(ROOM, other)])
    assert flat is not None
    (kept,) = flat.openings
    np.testing.assert_allclose(
        kept.opening.corners, hole("door", 4.0, *np.clip(ends, 2.0, 2.9), 1).corners
    )


def test_openings_beside_the_inner_wall_are_in_the_outer_one() -> None:
    """The hall is longer than the room: its wall goes on outdoors."""
    inner, outer = hole("door", 4.0, 2.0, 2.9, 1), hole("window", 4.0, 0.1, 0.8, 1)
    flat = flat_of([found(HALL, inner, outer), found(ROOM)])
    assert flat is not None
    assert {(o.opening.type, o.between) for o in flat.openings} == {("door", 0), ("window", None)}
    assert not flat.notes


def test_a_window_of_an_inner_wall_is_seen_from_both_sides_or_is_none() -> None:
    here, there = hole("window", 4.0, 2.0, 2.9, 1), hole("window", 4.2, 2.0, 2.9, 3, 0.3)
    alone = flat_of([found(HALL, here), found(ROOM)])
    assert alone is not None
    assert not alone.openings
    assert "left out 1 window" in alone.notes[0]
    doubted = flat_of([found(HALL, here), found(ROOM, doubtful=(there,))])
    assert doubted is not None
    assert [o.opening for o in doubted.openings] == [here]


def test_rooms_that_touch_nothing_are_named() -> None:
    flat = flat_of([found(HALL), found(FAR), found(ROOM)])
    assert flat is not None
    assert flat.members == (0, 2)
    assert flat.notes == ("left out, because they touch no other room: room 1 (9.0 m2)",)
    assert flat_of([found(HALL), found(FAR)]) is None
    assert flat_of([found(HALL)]) is None


def two_rooms(tmp_path: Path, *, boxes: bool = False) -> Path:
    """A hall and a room with a passage between them, as points in a file."""
    here, there = (1.0, 1.0, 0.8, 0.5, 0.0, 0.9), (5.5, 2.5, 0.8, 0.5, 0.0, 0.9)
    scans = (
        RoomScan(HALL, holes=[(1, 2.0, 2.9, 0.0, 2.05)], boxes=[here] if boxes else ()),
        RoomScan(ROOM, holes=[(3, 2.1, 3.0, 0.0, 2.05)], boxes=[there] if boxes else ()),
    )
    clouds = [scan.cloud(seed) for seed, scan in enumerate(scans)]
    file = tmp_path / "flat.npz"
    points = np.concatenate([cloud.points for cloud in clouds])
    labels = np.concatenate([cloud.label for cloud in clouds if cloud.label is not None])
    np.savez(file, points=points, label=labels)
    return file


def author(file: Path, more: str) -> tuple[Usd.Stage, list[str]]:
    room = parse_room(f"layout: {{from: scan, scan: {file.name}, {more}}}")
    stage = Usd.Stage.CreateInMemory()
    context = StepContext(room, file.parent, stage, file.parent / "layout")
    LayoutStep().author(context)
    return stage, context.notes


@pytest.mark.slow
def test_a_scan_of_two_rooms_becomes_one_stage_with_the_wall_and_its_passage(
    tmp_path: Path,
) -> None:
    file = two_rooms(tmp_path)
    stage, notes = author(file, "room: all")
    assert any("the rooms 0, 1 are composed as one" in note for note in notes)
    floor = np.array(stage.GetPrimAtPath("/World/Room").GetAttribute("openrooms:room:floor").Get())
    assert shapely.Polygon(floor).area == pytest.approx(33.6, abs=0.4)
    walls = stage.GetPrimAtPath("/World/Room/Walls").GetChildren()
    (inner,) = [prim for prim in walls if prim.HasAttribute(names.PARTITION_OUTLINE)]
    outline = shapely.Polygon(inner.GetAttribute(names.PARTITION_OUTLINE).Get())
    assert outline.area == pytest.approx(0.2 * 4.0, abs=0.1)
    (passage,) = stage.GetPrimAtPath("/World/Room/Openings").GetChildren()
    assert passage.GetRelationship("openrooms:opening:wall").GetTargets() == [inner.GetPath()]
    assert passage.GetAttribute("openrooms:opening:width").Get() == pytest.approx(0.9, abs=0.1)
    alone, notes = author(file, "room: 0")
    floor = np.array(alone.GetPrimAtPath("/World/Room").GetAttribute("openrooms:room:floor").Get())
    assert shapely.Polygon(floor).area == pytest.approx(20.0, abs=0.3)
    assert any("`room` selects one of them, or `all` that touch" in note for note in notes)


@pytest.mark.slow
@pytest.mark.parametrize(("wanted", "count", "beyond"), [("all", 2, 0), ("0", 1, 1)])
def test_what_stands_in_a_joined_room_is_not_elsewhere(
    tmp_path: Path, wanted: str, count: int, beyond: int
) -> None:
    file = two_rooms(tmp_path, boxes=True)
    room = parse_room(
        f"layout: {{from: scan, scan: {file.name}, room: {wanted}}}\nfurniture: {{from: scan}}"
    )
    context = StepContext(room, file.parent, Usd.Stage.CreateInMemory(), tmp_path / "alignment")
    assert isinstance(room.layout, ScanLayout)
    assert isinstance(room.furniture, ScanFurniture)
    found = scanned(room.layout, file, file.parent).found()
    scan = segmented(context, room.furniture, found)
    assert len(scan.composed) == count
    cloud = scan.cloud
    assert cloud.instance is not None
    assert cloud.instance.max() == 2
    assert len(elsewhere(cloud, None, scan.composed)) == beyond


@pytest.mark.slow
def test_all_rooms_of_a_scan_with_one_are_that_room(tmp_path: Path) -> None:
    file = tmp_path / "hall.npz"
    np.savez(file, points=RoomScan(HALL).cloud().points)
    (one, _), (every, notes) = author(file, "room: 0"), author(file, "room: all")
    assert one.ExportToString() == every.ExportToString()
    assert not any("composed as one" in note for note in notes)


@pytest.mark.slow
def test_rooms_that_stand_apart_are_told(tmp_path: Path) -> None:
    file = tmp_path / "apart.npz"
    points = [RoomScan(corners).cloud().points for corners in (HALL, FAR)]
    np.savez(file, points=np.concatenate(points))
    _, notes = author(file, "room: all")
    assert notes[-1] == "no other room shares a wall with room 0, so room 0 is composed alone"


@pytest.mark.slow
def test_both_rooms_of_a_laser_scan_with_the_door_between_them(real: Callable[[str], Path]) -> None:
    from openrooms_usd.capture import read_capture

    scan = real("real_dev") / "data/laser_offset/scan.ply"
    capture = read_capture("scan", scan, {})
    assert capture.cloud is not None
    flat = flat_of(find_rooms(capture.cloud).rooms)
    assert flat is not None
    assert flat.members == (0, 1)
    (wall,) = flat.walls
    # By eye: from 8.31 m to 8.49 m, and a door of 0.87 m in it.
    assert wall.thickness == pytest.approx(0.18, abs=0.03)
    (door,) = [o.opening for o in flat.openings if o.between == 0]
    width = np.linalg.norm(door.corners[1] - door.corners[0])
    assert door.type == "door"
    assert width == pytest.approx(0.87, abs=0.25)


def test_no_such_storey_is_said() -> None:
    from openrooms_usd.scan.rooms.layout import LayoutOptions

    cloud: Cloud = RoomScan(FAR).cloud()
    with pytest.raises(InputError, match="shows 1 storey, there is no storey 1") as caught:
        find_rooms(cloud, LayoutOptions(storey=1))
    assert "count from 0" in str(caught.value.remedy)
