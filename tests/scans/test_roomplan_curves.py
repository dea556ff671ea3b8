"""Curved walls: facets on the arc, and a floor whose area is known in closed form."""

from pathlib import Path

import numpy as np
import pytest
import shapely

from openrooms_usd.description import parse_room
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.layout.step import LayoutStep
from tests.scans.roomplan_usdz import read

WIDTH, DEPTH, HEIGHT, RADIUS = 4.0, 3.0, 2.5, 2.5
HALF = np.arcsin(0.5 * WIDTH / RADIUS)  # half of the arc's angle
CORNERS = [[0, 0], [WIDTH, 0], [WIDTH, DEPTH], [0, DEPTH]]


def measurement(radians: float, unit: str = "rad") -> dict:
    """As Foundation writes a Measurement<UnitAngle>: the coefficient leads to degrees."""
    factor = {"rad": 180 / np.pi, "°": 1.0}[unit]
    converter = {"coefficient": factor, "constant": 0}
    return {"value": np.degrees(radians) / factor, "unit": {"symbol": unit, "converter": converter}}


def bulging(outward: bool, unit: str = "rad", convention: tuple[float, float] = (1, 0)) -> dict:
    """The curve of a wall whose local z is its normal to the outside.

    An angle of this test's own, counted from x to z, is written as ``sense * angle + offset``.
    """
    sense, offset = convention
    side = 1.0 if outward else -1.0
    angles = [side * 0.5 * np.pi + HALF, side * 0.5 * np.pi - HALF]
    start, end = (measurement(sense * a + offset, unit) for a in angles)
    center = [0, -side * RADIUS * np.cos(HALF)]
    return {"radius": RADIUS, "startAngle": start, "endAngle": end, "center": center}


def curved_room(scanner, curve: dict, **more: object) -> dict:
    data = scanner.room(CORNERS, HEIGHT, **more)
    # The scanner's wall over an edge has its normal along (along.y, -along.x): outwards.
    data["walls"][2]["curve"] = curve
    return data


def segment_area() -> float:
    return float(0.5 * RADIUS**2 * (2 * HALF - np.sin(2 * HALF)))


@pytest.mark.parametrize("floors", ["floors", "no floors"])
@pytest.mark.parametrize("outward", [True, False])
def test_the_floor_follows_the_arc(scanner, outward: bool, floors: str) -> None:
    more = {} if floors == "floors" else {"floors": []}
    capture = read(scanner.write(curved_room(scanner, bulging(outward), **more)))
    assert capture.notes == ()
    floor = shapely.Polygon(capture.floor)
    facets = len(capture.floor) - 3
    # Of n equal facets each cuts off a segment of the arc's n-th part.
    part = 2 * HALF / facets
    cut = 0.5 * RADIUS**2 * facets * (part - np.sin(part))
    side = 1 if outward else -1
    expected = WIDTH * DEPTH + side * (segment_area() - cut)
    assert floor.area == pytest.approx(expected, abs=1e-6)
    sagitta = RADIUS * (1 - np.cos(0.5 * part))
    assert sagitta < 0.005
    assert facets < 30, "no finer than it must be"


@pytest.mark.parametrize("unit", ["rad", "°"])
@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("quarters", [0, 1, 2, 3])
def test_any_way_to_count_the_angles_gives_the_same_floor(
    scanner, unit: str, sense: float, quarters: int
) -> None:
    plain = read(scanner.write(curved_room(scanner, bulging(True))))
    curve = bulging(True, unit, (sense, 0.5 * np.pi * quarters))
    assert read(scanner.write(curved_room(scanner, curve))).floor == pytest.approx(
        plain.floor, abs=1e-6
    )


def test_without_a_centre_the_arc_stands_on_the_wall(scanner) -> None:
    curve = bulging(True)
    with_center = read(scanner.write(curved_room(scanner, curve)))
    del curve["center"]
    without = read(scanner.write(curved_room(scanner, curve)))
    assert without.floor == pytest.approx(with_center.floor, abs=1e-6)
    assert any("no centre" in note for note in without.notes)


def test_a_floor_that_follows_the_arc_already_is_not_bent_twice(scanner) -> None:
    angles = np.linspace(0.5 * np.pi - HALF, 0.5 * np.pi + HALF, 9)[1:-1]
    middle = [0.5 * WIDTH, DEPTH - RADIUS * np.cos(HALF)]
    arc = middle + RADIUS * np.column_stack([np.cos(angles), np.sin(angles)])
    data = curved_room(scanner, bulging(True))
    once = read(scanner.write(data))
    data["floors"] = [scanner.floor([*CORNERS[:3], *arc.tolist(), CORNERS[3]])]
    assert read(scanner.write(data)).floor == pytest.approx(once.floor, abs=1e-6)


def test_an_opening_gets_a_facet_of_its_own(scanner) -> None:
    top = DEPTH + RADIUS * (1 - np.cos(HALF))
    data = curved_room(scanner, bulging(True))
    window = scanner.surface("window", [2.5, top], [1.5, top], 0.9, 2.1, identifier="w")
    data["windows"] = [window | {"parentIdentifier": data["walls"][2]["identifier"]}]
    path = scanner.write(data)
    for parent in (data["walls"][2]["identifier"], None):
        window["parentIdentifier"] = parent
        data["windows"] = [window]
        path = scanner.write(data)
        stage = _authored(path)
        prim = stage.GetPrimAtPath("/World/Room/Openings/window_w")
        assert prim.GetAttribute("openrooms:opening:width").Get() == pytest.approx(1.0)
        assert prim.GetAttribute("openrooms:opening:height").Get() == pytest.approx(1.2)


def _authored(path: Path):
    from pxr import Usd

    stage = Usd.Stage.CreateInMemory()
    room = parse_room(f"layout: {{from: roomplan, file: {path.name}}}")
    LayoutStep().author(StepContext(room, path.parent, stage, path.parent / "layout"))
    return stage


@pytest.mark.parametrize(
    ("change", "note"),
    [
        ({"radius": None}, "lacks its radius"),
        ({"endAngle": None}, "lacks its radius or an angle"),
        ({"center": [3.0, 1.0]}, "does not end where"),
    ],
)
def test_what_is_known_too_little_is_built_straight(scanner, change: dict, note: str) -> None:
    capture = read(scanner.write(curved_room(scanner, bulging(True) | change)))
    assert shapely.Polygon(capture.floor).area == pytest.approx(WIDTH * DEPTH)
    assert any(note in text for text in capture.notes)


def test_an_arc_as_good_as_straight_is_straight(scanner) -> None:
    curve = {"radius": 1e6, "startAngle": 1.570, "endAngle": 1.571, "center": [0, 0]}
    capture = read(scanner.write(curved_room(scanner, curve)))
    assert len(capture.floor) == 4
    assert capture.notes == ()
