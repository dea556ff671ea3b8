"""The checks of generated rooms find what is planted: in a real room, and in closed forms."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.composing import compose_room
from openrooms_usd.description import parse_room
from openrooms_usd.furniture import category
from openrooms_usd.generation import generate, write
from openrooms_usd.generation.shapes import Shapes
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box
from tests.generation import checks, resting
from tests.generation.assembled import assembled
from tests.generation.scenes import Body, Form, Scene, fans, read

DOWN, UP = np.array([0.0, 0.0, -0.006]), np.array([0.0, 0.0, 0.006])


class Room:
    """A generated room whose things are moved."""

    def __init__(self, folder: Path) -> None:
        shapes = Shapes(3)
        self.text = write(generate("kitchen", 3, clutter=1, shapes=shapes))
        self.scene = assembled(self.text, shapes, folder)
        rows = parse_room(self.text).furniture.objects
        self.supports = checks.described_supports(rows, lambda name: category(name).support)
        self.hanging = checks.described_hanging(rows, lambda name: category(name).placements)

    def found(self, scene: Scene) -> list[str]:
        return checks.violations(scene, self.supports, self.hanging)

    def first(self, *names: str, on: str = "") -> Body:
        """The first of some categories, on something."""
        return next(
            body
            for body in self.scene.objects
            if (body.category in names or not names)
            and (not on or self.supports[body.name].startswith(on))
        )

    def moved(self, body: Body, offset: np.ndarray) -> Scene:
        return self.put(body, body.moved(offset))

    def put(self, body: Body, other: Body) -> Scene:
        objects = [other if old is body else old for old in self.scene.objects]
        return replace(self.scene, objects=objects)


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Room:
    return Room(tmp_path_factory.mktemp("kitchen"))


def small(room: Room) -> Body:
    """Something on the worktop that is let into nothing."""
    return next(
        body
        for body in room.scene.objects
        if room.supports[body.name].startswith("worktop")
        and body.category not in ("sink", "hob")
        and body.high[2] - body.low[2] > 0.05
    )


def door(room: Room) -> tuple[np.ndarray, np.ndarray]:
    way = next(opening for opening in room.scene.openings if opening.walked)
    return way.middle, way.inward


def before_door(room: Room, away: float) -> Scene:
    body, (middle, inward) = room.first("chair", on="floor"), door(room)
    x, y = middle + away * inward - 0.5 * (body.low + body.high)[:2]
    return room.moved(body, np.array([x, y, 0.0]))


def half_outside(room: Room) -> Scene:
    body, (middle, _) = room.first("chair", on="floor"), door(room)
    x, y = middle - 0.5 * (body.low + body.high)[:2]
    return room.moved(body, np.array([x, y, 0.0]))


def half_over_the_edge(room: Room) -> Scene:
    body, top = small(room), room.first("worktop")
    front = -top.frame[:3, 1]
    ahead = float((top.points @ front).max() - 0.5 * ((body.low + body.high) @ front))
    return room.moved(body, (ahead - 0.005) * front)


def unit_out_of_line(room: Room) -> Scene:
    body = room.first("kitchen_unit", on="floor")
    return room.moved(body, -0.01 * body.frame[:3, 1])


def board_across_door(room: Room) -> Scene:
    middle, inward = door(room)
    x, y = middle + 0.008 * inward
    mesh = box((0.4, 0.4, 0.08), (0.0, 0.0, 0.04))
    board = Body("skirting", "", form(mesh), at(x, y, 0.0))
    return replace(room.scene, trim=[*room.scene.trim, board])


def cupboard_before_socket(room: Room) -> Scene:
    socket, body = room.first("socket"), room.first("refrigerator", "chair", on="floor")
    place = (
        0.5 * (socket.low + socket.high)
        - (0.5 * np.ptp(body.form.points[:, 1]) + 0.02) * (socket.frame[:3, 1])
    )
    frame = socket.frame.copy()
    frame[:3, 3] = place
    return room.put(body, Body(body.name, body.category, body.form, frame))


PLANTED: dict[str, tuple[Callable[[Room], Scene], str]] = {
    "6 mm into what carries it": (lambda room: room.moved(small(room), DOWN), "penetrates"),
    "6 mm above its rest": (lambda room: room.moved(small(room), UP), "does not touch"),
    "6 mm above the floor": (
        lambda room: room.moved(room.first("chair", on="floor"), UP),
        "does not touch floor",
    ),
    "half over the edge": (half_over_the_edge, "stands over the edge of worktop"),
    "sink out of its hole": (
        lambda room: room.moved(room.first("sink"), 0.03 * room.first("sink").frame[:3, 0]),
        "penetrates",
    ),
    "sink above its hole": (lambda room: room.moved(room.first("sink"), UP), "does not touch"),
    "before a door": (lambda room: before_door(room, 0.35), "stands before"),
    "half out of the room": (half_outside, "outside of the room"),
    "unit out of line": (unit_out_of_line, "is out of line"),
    "worktop off its units": (
        lambda room: room.moved(room.first("worktop"), UP),
        "does not touch kitchen_unit",
    ),
    "board across a door": (board_across_door, "skirting runs across door"),
    "socket off its wall": (
        lambda room: room.moved(room.first("socket"), -0.006 * room.first("socket").frame[:3, 1]),
        "does not touch wall",
    ),
    "socket behind a cupboard": (cupboard_before_socket, "is behind"),
}


def test_the_room_itself_is_sound(room: Room) -> None:
    assert room.found(room.scene) == []


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", PLANTED)
def test_what_is_planted_in_a_room_is_found(room: Room, name: str) -> None:
    plant, wanted = PLANTED[name]
    problems = room.found(plant(room))
    assert any(wanted in problem for problem in problems), problems


@pytest.mark.slow
def test_what_is_assembled_is_what_is_composed(room: Room, tmp_path: Path) -> None:
    path = tmp_path / "room.yaml"
    path.write_text(room.text)
    for step in ("layout", "alignment"):
        composed = compose_room(path, tmp_path / "out", only=step).scene
    scene = read(composed)
    assert [(body.name, body.category) for body in scene.objects] == [
        (body.name, body.category) for body in room.scene.objects
    ]
    for body, other in zip(scene.objects, room.scene.objects, strict=True):
        assert np.sort(body.points, axis=0) == pytest.approx(
            np.sort(other.points, axis=0), abs=1e-6
        )


def form(mesh: Mesh) -> Form:
    return Form(mesh.points, fans(mesh.counts, mesh.indices))


def at(x: float, y: float, z: float) -> np.ndarray:
    frame = np.eye(4)
    frame[:3, 3] = x, y, z
    return frame


def cuboid(name: str, kind: str, size: tuple[float, float, float], *place: float) -> Body:
    return Body(name, kind, form(box(size, (0.0, 0.0, 0.5 * size[2]))), at(*place))


def fallen(*bodies: Body, on: str) -> list[str]:
    """What is said of the first body, which lies on the second one."""
    scene = Scene(
        [*bodies],
        [cuboid("Floor", "", (9, 9, 0.1), 0, 0, -0.1)],
        [],
        [],
        [],
        np.array([[-4, -4], [4, -4], [4, 4], [-4, 4]]),
        3.0,
    )
    supports = {body.name: "floor" for body in bodies} | {bodies[0].name: on}
    return [
        found for found in resting.floating(scene, supports, frozenset()) if bodies[0].name in found
    ]


@pytest.mark.parametrize(("shift", "stands"), [(0.03, True), (0.096, True), (0.104, False)])
def test_stacks_stand_while_their_middle_of_mass_is_held(shift: float, stands: bool) -> None:
    lower = cuboid("lower", "box", (0.2, 0.2, 0.1), 0, 0, 0)
    upper = cuboid("upper", "box", (0.2, 0.2, 0.1), shift, 0, 0.1)
    assert (fallen(upper, lower, on="lower") == []) == stands
    # Over the edge of anything but its like nothing reaches.
    table = cuboid("table", "table", (0.2, 0.2, 0.1), 0, 0, 0)
    assert fallen(upper, table, on="table") != []


@pytest.mark.parametrize(("shift", "stands"), [(0.008, True), (0.045, True), (0.058, False)])
def test_stacks_stand_on_corners_of_what_is_below_them(shift: float, stands: bool) -> None:
    tile = Shapes(2).of("coaster", (0.1, 0.1, 0.006), "tile").meshes[0]
    lower = Body("lower", "coaster", form(tile), at(0, 0, 0))
    upper = Body("upper", "coaster", form(tile), at(shift, 0.1 * shift, 0.006))
    assert (fallen(upper, lower, on="lower") == []) == stands


def test_what_stands_on_one_foot_tips() -> None:
    foot, weight = box((0.05, 0.05, 0.1), (0, 0, 0.05)), box((0.4, 0.4, 0.1), (0.15, 0, 0.15))
    lamp = Body("lamp", "table_lamp", form(joined([foot, weight])), at(0, 0, 0))
    assert fallen(lamp, on="floor") == ["lamp would tip over on floor"]


@pytest.mark.parametrize(
    ("gap", "width", "stands"), [(0.025, 0.2, True), (0.05, 0.2, False), (0.025, 0.02, False)]
)
def test_things_stand_over_narrow_gaps_between_slats(
    gap: float, width: float, stands: bool
) -> None:
    slats = [
        box((0.06, 0.3, 0.02), (k * (0.06 + gap) - 0.5 * (0.06 + gap), 0, 0.01))
        for k in range(-2, 4)
    ]
    crate = Body("crate", "box", form(joined(slats)), at(0, 0, 0))
    thing = cuboid("thing", "jar", (width, 0.05, 0.1), 0, 0, 0.02)
    assert (fallen(thing, crate, on="crate") == []) == stands


@pytest.mark.parametrize(
    ("gap", "beyond", "held"), [(0.6, 0.1, True), (0.7, 0.1, False), (0.3, 0.35, False)]
)
def test_worktops_are_held_along_their_length(gap: float, beyond: float, held: bool) -> None:
    top = cuboid("top", "worktop", (1.2 + gap + 2 * beyond, 0.6, 0.04), 0, 0, 0.87)
    units = [
        cuboid(f"unit_{k}", "kitchen_unit", (0.6, 0.6, 0.87), s * 0.5 * (0.6 + gap), 0, 0)
        for k, s in enumerate((-1, 1))
    ]
    assert (fallen(top, *units, on="unit_0") == []) == held


@pytest.mark.parametrize("rim", [True, False])
def test_what_is_let_in_hangs_by_a_rim_all_around(rim: bool) -> None:
    hole, bowl = 0.5, box((0.46, 0.46, 0.15), (0, 0, -0.075))
    slab = joined([box((0.2, 0.9, 0.04), (s * (0.5 * hole + 0.1), 0, -0.02)) for s in (-1, 1)])
    plates = [box((0.1, 0.46, 0.005), (s * 0.26, 0, 0.0025)) for s in ((-1, 1) if rim else (1,))]
    middle = box((0.42, 0.46, 0.005), (0, 0, 0.0025))
    sink = Body("sink", "sink", form(joined([bowl, middle, *plates])), at(0, 0, 0.9))
    top = Body("top", "worktop", form(slab), at(0, 0, 0.9))
    problems = fallen(sink, top, on="top")
    assert problems == ([] if rim else ["the rim of sink does not lie on top"])
