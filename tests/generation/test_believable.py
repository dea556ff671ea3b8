"""Rooms that a person believes: nothing hangs or stands as nobody has it; checks find plants."""

import numpy as np
import pytest

from openrooms_usd.description import parse_room
from openrooms_usd.generation import expanded, generate
from openrooms_usd.generation.programs import PROGRAMS
from openrooms_usd.generation.shapes import Shapes
from openrooms_usd.geometry.solids import box
from tests.generation.assembled import arranged
from tests.generation.hanging import misplaced
from tests.generation.oddities import odd
from tests.generation.scenes import Body, Form, Scene, fans

# Small rooms that are made at once, and where most hangs in a little space.
QUICK = [
    *(("bathroom", seed) for seed in range(100, 112)),
    *((kind, 100) for kind in ("closet", "stairs", "hallway", "laundry_room", "kitchen")),
    *((kind, 101) for kind in ("hallway", "stairs", "mail_room")),
]


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("room_type", "seed"), QUICK)
def test_a_person_believes_a_room(room_type: str, seed: int) -> None:
    assert unbelievable(room_type, seed, Shapes(seed)) == []


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("seed", range(38))
def test_a_person_believes_a_thousand_rooms(seed: int) -> None:
    shapes = Shapes(seed)
    assert [row for kind in PROGRAMS for row in unbelievable(kind, seed, shapes)] == []


def unbelievable(room_type: str, seed: int, shapes: Shapes) -> list[str]:
    room = generate(room_type, seed, clutter=2, shapes=shapes)
    items = [item for _, group in room.furnishing.groups for item in group]
    wrong = [*misplaced(*arranged(room, shapes)), *odd(room_type, items)]
    return [f"{room_type} {seed}: {sentence}" for sentence in wrong]


def thing(name: str, size: tuple[float, float, float], x: float, y: float, z: float) -> Body:
    """A box, its front towards -y."""
    mesh = box(size, (0.0, 0.0, 0.5 * size[2]))
    frame = np.eye(4)
    frame[:3, 3] = x, y, z
    return Body(
        name, name.rstrip("0123456789_"), Form(mesh.points, fans(mesh.counts, mesh.indices)), frame
    )


def picture(x: float = 0.0, z: float = 1.4) -> Body:
    return thing("picture", (0.5, 0.03, 0.6), x, -0.015, z)


SHOWER = thing("shower", (1.0, 1.0, 2.05), 0.0, -0.5, 0.0)
BATH = thing("bathtub", (1.7, 0.75, 0.58), 0.0, -0.4, 0.0)
RADIATOR = thing("radiator", (1.0, 0.1, 0.6), 0.0, -0.06, 0.12)
SWITCH = thing("light_switch", (0.08, 0.01, 0.08), 0.9, -0.005, 1.1)
HANGS = {
    "in a shower": ([SHOWER, picture()], "picture hangs above shower"),
    "beside a shower": ([SHOWER, picture(0.8)], ""),
    "a switch near a shower": ([SHOWER, SWITCH], "light_switch is in the spray of shower"),
    "over a bath": ([BATH, picture()], "picture hangs above bathtub"),
    "over a radiator": ([RADIATOR, picture()], "picture hangs above radiator"),
    "below a radiator": ([RADIATOR, picture(z=-0.7)], ""),
    "over a hob": ([thing("hob", (0.6, 0.5, 0.05), 0.0, -0.3, 0.9), picture()], "above hob"),
    "behind a wardrobe": (
        [thing("wardrobe", (1.2, 0.6, 2.1), 0.5, -0.4, 0.0), picture()],
        "71% of picture is hidden",
    ),
    "before a wardrobe far off": (
        [thing("wardrobe", (1.2, 0.6, 2.1), 0.5, -0.9, 0.0), picture()], "",
    ),
    "over a sideboard": ([thing("cabinet", (1.2, 0.4, 0.9), 0.0, -0.2, 0.0), picture()], ""),
}  # fmt: skip


@pytest.mark.parametrize("name", HANGS)
def test_what_hangs_wrong_is_found(name: str) -> None:
    bodies, wanted = HANGS[name]
    scene = Scene(bodies, [], [], [], [], np.zeros((0, 2)), 2.5)
    supports = {
        body.name: "wall" if body.category in ("picture", "light_switch") else "floor"
        for body in bodies
    }
    found = list(misplaced(scene, supports))
    assert len(found) == bool(wanted)
    assert all(wanted in sentence for sentence in found)


DESCRIBED = """\
room: bathroom
clutter: 3
seed: {seed}
layout: {{polygon: [[0, 0], [3.2, 0], [3.2, 1.6], [0, 1.6]], openings: [{{kind: door, wall: 1}}]}}
furniture:
  objects:
    - {{name: shower, category: shower, at: [0.6, 0.8], size: [1.2, 1.6, 2.05], style: walk_in}}
"""


def test_nothing_hangs_in_a_shower_of_a_description() -> None:
    """What of a shower are panes is thin: between them the wall is free."""
    hung = [
        row
        for seed in range(4)
        for row in expanded(parse_room(DESCRIBED.format(seed=seed))).furniture.objects
        if row.category in ("picture", "clock")
    ]
    assert hung and all(row.at[0] - 0.5 * row.size[0] > 1.2 for row in hung)
