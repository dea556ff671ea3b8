"""A capture through the layout stage: its openings are made to fit, never refused."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from openrooms_usd.description import parse_room
from openrooms_usd.errors import DescriptionError, InputError
from openrooms_usd.steps.alignment.surroundings import surroundings
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.validation.roomview import RoomView

CORNERS = [[0, 0], [5, 0], [5, 4], [0, 4]]


def author(path: Path, more: str = "") -> tuple[Usd.Stage, list[str]]:
    room = parse_room(f"layout: {{from: roomplan, file: {path.name}{more}}}")
    stage = Usd.Stage.CreateInMemory()
    context = StepContext(room, path.parent, stage, path.parent / "layout")
    LayoutStep().author(context)
    return stage, context.notes


def openings(stage: Usd.Stage) -> dict[str, tuple[str, float, float, float]]:
    found = stage.GetPrimAtPath("/World/Room/Openings")
    return {
        prim.GetName(): tuple(
            prim.GetAttribute(f"openrooms:opening:{key}").Get()
            for key in ("kind", "width", "height", "sill")
        )
        for prim in (found.GetChildren() if found else [])
    }


def test_openings_are_cut_where_they_were_captured(scanner) -> None:
    data = scanner.room(CORNERS, 2.5)
    ajar = {"category": {"door": {"isOpen": True}}, "identifier": "the door"}
    data["doors"] = [scanner.surface("door", [5, 1], [5, 1.9], 0.003, 2.1, **ajar)]
    # Twelve centimetres before its wall.
    data["windows"] = [scanner.surface("window", [1, 0.12], [2.5, 0.12], 0.9, 2.1, identifier="w1")]
    stage, notes = author(scanner.write(data))
    assert notes == []
    assert openings(stage) == {
        "door_3a55d6": ("door", pytest.approx(0.9), pytest.approx(2.1), 0.0),
        "window_w1": ("window", pytest.approx(1.5), pytest.approx(1.2), pytest.approx(0.9)),
    }
    door = stage.GetPrimAtPath("/World/Room/Openings/door_3a55d6")
    assert door.GetAttribute("openrooms:source:id").Get() == "the door"
    assert door.GetAttribute("openrooms:source:confidence").Get() == "high"
    assert stage.GetPrimAtPath("/World/Room/Openings/door_3a55d6/Leaf").GetAttribute(
        "xformOp:rotateZ"
    ).Get() == pytest.approx(-60)
    room = stage.GetPrimAtPath("/World/Room")
    assert room.GetAttribute("openrooms:source:file").Get() == "Room.json"
    assert room.GetAttribute("openrooms:room:height").Get() == pytest.approx(2.5)
    # Row vectors: a corner of the floor goes back to one of the source.
    matrix = np.array(room.GetAttribute("openrooms:source:fromWorld").Get())
    corner = [*room.GetAttribute("openrooms:room:floor").Get()[0], 0.0, 1.0]
    source = scanner.source(np.column_stack([CORNERS, np.zeros(4)]))
    assert np.linalg.norm(source - (corner @ matrix)[:3], axis=1).min() < 1e-6


def test_openings_that_do_not_fit_are_clamped_merged_or_dropped_with_notes(scanner) -> None:
    data = scanner.room(CORNERS, 2.5)
    data["windows"] = [
        scanner.surface("window", [0.5, 0], [2.0, 0], 0.9, 2.1, identifier="w1"),
        scanner.surface("window", [3, 2], [4, 2], 0.9, 2.1, identifier="inside"),
    ]
    data["doors"] = [scanner.surface("door", [1.8, 0], [2.7, 0], 0.0, 2.0, identifier="d1")]
    data["openings"] = [
        scanner.surface("opening", [0, 4], [0, 0], 0.0, 2.5, identifier="whole"),
        scanner.surface("opening", [4.99, 0], [5.5, 0], 0.0, 2.0, identifier="outside"),
    ]
    stage, notes = author(scanner.write(data))
    found = openings(stage)
    assert found == {
        "door_d1": ("door", pytest.approx(2.2), pytest.approx(2.1), 0.0),
        "opening_whole": ("opening", pytest.approx(3.96), pytest.approx(2.48), 0.0),
    }
    text = "\n".join(notes)
    assert "merged" in text
    for word in ("w1", "d1", "inside", "outside", "whole"):
        assert word in text


def test_what_is_dropped_or_shuffled_renames_no_other(scanner) -> None:
    data = scanner.room(CORNERS, 2.5)
    data["windows"] = [
        scanner.surface("window", [3, 2], [4, 2], 0.9, 2.1, identifier="inside"),
        scanner.surface("window", [1, 0], [2, 0], 0.9, 2.1, identifier="kept"),
    ]
    path = scanner.write(data)
    stage, _ = author(path)
    assert list(openings(stage)) == ["window_kept"]
    # Described openings count among themselves.
    stage, _ = author(path, ", openings: [{kind: window, wall: 1, height: 1}]")
    assert sorted(openings(stage)) == ["window_0", "window_kept"]
    data["windows"] = data["windows"][::-1]
    stage, _ = author(scanner.write(data))
    assert list(openings(stage)) == ["window_kept"]


def test_further_openings_keep_their_names_and_may_not_overlap(scanner) -> None:
    data = scanner.room(CORNERS, 2.5)
    data["windows"] = [scanner.surface("window", [1, 0], [2, 0], 0.9, 2.1, identifier="a1")]
    path = scanner.write(data)
    stage, _ = author(path, ", openings: [{kind: window, wall: 1, name: window_a1, height: 1}]")
    assert openings(stage)["window_a1"][2] == pytest.approx(1.0)
    # What was captured makes way for what is described.
    assert openings(stage)["window_f55ff16f"][2] == pytest.approx(1.2)
    walls = [p for p in range(4) if _overlaps(path, p)]
    assert len(walls) == 1
    with pytest.raises(DescriptionError, match="there is no wall 7"):
        author(path, ", openings: [{kind: window, wall: 7}]")


def _overlaps(path: Path, wall: int) -> bool:
    try:
        author(path, f", openings: [{{kind: opening, wall: {wall}, width: 3}}]")
    except DescriptionError as error:
        assert "overlap" in str(error)
        return True
    return False


def test_the_height_may_be_given_or_is_guessed_with_a_note(scanner) -> None:
    path = scanner.write(scanner.room(CORNERS, 2.5))
    stage, _ = author(path, ", height: 3 m")
    assert stage.GetPrimAtPath("/World/Room").GetAttribute("openrooms:room:height").Get() == 3.0
    stage, notes = author(scanner.write(scanner.room(CORNERS, 2.5, walls=[]), "flat.json"))
    assert stage.GetPrimAtPath("/World/Room").GetAttribute("openrooms:room:height").Get() == 2.6
    assert any("no height" in note for note in notes)


def test_a_capture_without_a_floor_is_refused(scanner) -> None:
    with pytest.raises(InputError, match="no floor"):
        author(scanner.write({"walls": []}))


def test_doors_and_passages_reach_the_floor(scanner) -> None:
    data = scanner.room(CORNERS, 2.5)
    data["openings"] = [scanner.surface("opening", [1, 0], [2, 0], 0.07, 2.1, identifier="o")]
    data["doors"] = [scanner.surface("door", [5, 1], [5, 2], -0.04, 2.1, identifier="d")]
    data["windows"] = [scanner.surface("window", [0, 3], [0, 2], 0.07, 2.1, identifier="w")]
    stage, _ = author(scanner.write(data))
    sills = {name: sill for name, (_, _, _, sill) in openings(stage).items()}
    assert sills == {"opening_o": 0.0, "door_d": 0.0, "window_w": pytest.approx(0.07)}
    # A passage has neither frame nor leaf.
    assert not stage.GetPrimAtPath("/World/Room/Openings/opening_o").GetChildren()


# The two gables of a room of 5 m by 4 m: 2 m at the eaves, 3 m at the ridge.
GABLE = [[-2, -1, 0], [2, -1, 0], [2, 1, 0], [0, 2, 0], [-2, 1, 0]]


def attic(scanner, **more: object) -> Path:
    data = scanner.room(CORNERS, 2.0, **more)
    for i in (1, 3):
        data["walls"][i]["polygonCorners"] = GABLE
    return scanner.write(data)


def heights(stage: Usd.Stage, name: str) -> tuple[float, float]:
    z = np.array(stage.GetAttributeAtPath(f"/World/Room/{name}.points").Get())[:, 2]
    return float(z.min()), float(z.max())


def test_gables_are_built_with_a_ceiling_that_follows_them(scanner) -> None:
    window = scanner.surface("window", [5, 1.5], [5, 2.5], 1.0, 2.9, identifier="high")
    path = attic(scanner, windows=[window])
    stage, notes = author(path, ", trim: {cornice: {}, skirting: {}}, ceiling: beams")
    assert heights(stage, "Walls/wall_0") == pytest.approx((0, 2))
    assert heights(stage, "Walls/wall_1") == pytest.approx((0, 3))
    assert heights(stage, "Ceiling") == pytest.approx((2, 3.2))
    trim = stage.GetPrimAtPath("/World/Room/Trim").GetChildren()
    assert [prim.GetName() for prim in trim] == ["Skirting"]
    assert openings(stage)["window_high"][2] == pytest.approx(1.73)
    assert notes[1:] == [
        "left out the cornice and the beams: the ceiling slopes; `height` makes it level",
        "made the window high 17.0 cm smaller, to fit wall 1",
    ]
    # What hangs, and what is held against the ceiling, sees it where it is.
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    room, view = surroundings(stage), RoomView(stage)
    assert [room.ceiling_over(2.5, y) for y in (0.5, 2.0, 3.5)] == pytest.approx([2.25, 3.0, 2.25])
    assert view.ceiling == pytest.approx(3.0)
    assert view.above_ceiling(np.array([[2.5, 2.0, 2.9]])) == pytest.approx(-0.1)
    assert view.above_ceiling(np.array([[2.5, 0.5, 2.5], [2.5, 2.0, 2.9]])) == pytest.approx(0.25)


@pytest.mark.parametrize(
    ("more", "told"),
    [(", height: 2.5", None), (", polygon: [[0, 0], [5, 0], [5, 4], [0, 4]]", "level, at 3.00 m")],
)
def test_a_given_height_or_a_drawn_outline_makes_the_ceiling_level(
    scanner, more: str, told: str | None
) -> None:
    stage, notes = author(attic(scanner), more)
    level = 3.0 if told else 2.5
    assert heights(stage, "Ceiling") == pytest.approx((level, level + 0.2))
    tops = [heights(stage, f"Walls/wall_{i}")[1] for i in range(4)]
    assert tops == pytest.approx([level] * 4)
    assert (told or "follows") in notes[-1]
