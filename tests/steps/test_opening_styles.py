"""Styles of doors and windows from the description to the stage, and how they move."""

from pathlib import Path

import pytest
from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.description import parse_room
from openrooms_usd.errors import DescriptionError
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.steps.lights.daylight import author_portals
from openrooms_usd.usd.files.layers import apply_metadata
from openrooms_usd.usd.places.frames import author_placement

OPENINGS = """
layout:
  openings:
    - {kind: door, wall: 0, at: 1.0, style: glazed}
    - {kind: door, wall: 0, at: 3.5, width: 1.6, open: 20 deg}
    - {kind: window, wall: 1, style: sliding}
    - {kind: window, wall: 2, width: 1.6}
    - {kind: door, wall: 3, at: 1.0, style: flush, hinge: right}
    - {kind: door, wall: 3, at: 2.5, width: 1.6}
"""


def author(text: str) -> tuple[Usd.Stage, StepContext]:
    stage = Usd.Stage.CreateInMemory()
    apply_metadata(stage.GetRootLayer())
    context = StepContext(parse_room(text), Path(), stage, Path("layout"))
    LayoutStep().author(context)
    return stage, context


def opening(stage: Usd.Stage, name: str, below: str = "") -> Usd.Prim:
    return stage.GetPrimAtPath(f"{names.OPENINGS}/{name}{below}")


def joint(prim: Usd.Prim) -> tuple[str, list[float], float, float]:
    assert names.JOINT_API in prim.GetPrimTypeInfo().GetAppliedAPISchemas()
    kind, axis, lower, upper = (
        prim.GetAttribute(name).Get()
        for name in (names.JOINT_TYPE, names.JOINT_AXIS, names.JOINT_LOWER, names.JOINT_UPPER)
    )
    return kind, list(axis), lower, upper


def test_leaves_and_sashes_say_how_they_move() -> None:
    stage, _ = author(OPENINGS)
    kind, axis, lower, upper = joint(opening(stage, "door_0", "/Leaf"))
    assert (kind, axis, lower) == ("hinge", [0, 0, -1], 0)
    assert 80 < upper <= 170
    assert joint(opening(stage, "door_2", "/Leaf"))[1] == [0, 0, 1]
    assert joint(opening(stage, "window_0", "/Sash_0"))[:2] == ("rail", [0, 0, 1])
    sashes = [joint(opening(stage, "window_1", f"/Sash_{i}")) for i in range(2)]
    assert [axis for _, axis, *_ in sashes] == [[0, 0, -1], [0, 0, 1]]
    assert not opening(stage, "window_1", "/Sash_2")


def test_wide_doors_open_both_leaves_against_each_other() -> None:
    stage, context = author(OPENINGS)
    turns = []
    for name in ("/Leaf", "/Leaf_1"):
        leaf = opening(stage, "door_1", name)
        rotation = UsdGeom.Xformable(leaf).GetLocalTransformation().ExtractRotation()
        turns.append(rotation.GetAngle() * rotation.GetAxis()[2])
        # The rotation is counted along the joint's axis, from shut.
        assert turns[-1] * joint(leaf)[1][2] == pytest.approx(20)
    assert turns[0] == pytest.approx(-turns[1])
    assert not opening(stage, "door_0", "/Leaf_1")
    assert context.notes == []


def test_styles_are_recorded_and_differ() -> None:
    stage, _ = author(OPENINGS)
    style = {
        name: opening(stage, name).GetAttribute(names.OPENING_STYLE).Get() or ""
        for name in ("door_0", "door_1", "door_2", "window_0", "window_1")
    }
    assert style == {
        "door_0": "glazed",
        "door_1": "",
        "door_2": "flush",
        "window_0": "sliding",
        "window_1": "",
    }
    sizes = {
        name: len(UsdGeom.Mesh(opening(stage, name, "/Leaf/Panel")).GetPointsAttr().Get())
        for name in ("door_0", "door_1", "door_2")
    }
    assert sizes["door_2"] < sizes["door_1"]
    assert len(set(sizes.values())) == 3


def test_light_comes_in_where_it_can() -> None:
    """Portals: not behind shut doors, but behind glazed ones, open ones and all windows."""
    stage, context = author(OPENINGS)
    UsdGeom.Scope.Define(stage, names.LIGHTS)
    stage.DefinePrim(names.ENVIRONMENT, "DomeLight")
    author_portals(context)
    portals = {prim.GetName() for prim in stage.GetPrimAtPath(names.PORTALS).GetChildren()}
    assert portals == {"door_0", "door_1", "window_0", "window_1"}


def test_a_wide_door_lets_light_in_when_one_leaf_stands_open() -> None:
    stage, context = author(OPENINGS)
    second = opening(stage, "door_3", "/Leaf_1")
    hinge = UsdGeom.Xformable(second).GetLocalTransformation().ExtractTranslation()
    author_placement(second, hinge, 30.0)
    stage.DefinePrim(names.ENVIRONMENT, "DomeLight")
    author_portals(context)
    assert stage.GetPrimAtPath(f"{names.PORTALS}/door_3")


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("{kind: door, wall: 0, style: casement}", ["no door is 'casement'", "panelled, flush or"]),
        ("{kind: window, wall: 0, style: flush}", ["no window is 'flush'", "sliding or fixed"]),
        ("{kind: opening, wall: 0, style: flush}", ["an opening has no style"]),
        ("{kind: door, wall: 0, style: panneled}", ["'panneled'", "did you mean 'panelled'"]),
        ("{kind: door, wall: 0, style: 3}", ["layout.openings[0].style"]),
    ],
)
def test_styles_of_others_are_refused(row: str, words: list[str]) -> None:
    with pytest.raises(DescriptionError) as caught:
        parse_room(f"layout:\n  openings: [{row}]")
    assert all(word in str(caught.value) for word in words), str(caught.value)
