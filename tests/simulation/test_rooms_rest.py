"""Generated rooms of all types rest as they are composed, in both engines."""

from collections.abc import Iterator
from pathlib import Path
from typing import Final, get_args

import pytest

from openrooms_usd import adapters
from openrooms_usd.composing import compose_room
from openrooms_usd.description.room import RoomType
from openrooms_usd.generation import generate, write
from openrooms_usd.generation.rooms import USUAL_CLUTTER
from openrooms_usd.physics.world import World
from openrooms_usd.simulation.settling import displacements
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world
from tests.engines import ENGINES

SECONDS, MOST_MM, MOST_DEG = 0.5, 2.0, 0.2
# Lights and cameras have no bodies.
STAGES = ("layout", "alignment", "materials", "physics")
QUICK = {("closet", 1)}
ROOMS = [
    pytest.param(kind, seed, marks=[] if (kind, seed) in QUICK else pytest.mark.long)
    for seed in (1, 2)
    for kind in get_args(RoomType)
]
# Categories that move farther, and why.
EXCUSED: Final[dict[str, str]] = {
    "towel": "on a hook: the shapes of both its sides, true to 1 cm, clasp the hook",
    "bag": "on a hook, as a towel",
    "paper": "a crumpled ball turns onto a face between the floor and the wall of a bin",
    "laptop": "the dry friction of its hinge gives by 0.2 degrees in MuJoCo, once",
    "pillow": "its hulls of 64 corners lie up to 5 mm inside of what is round: it sinks, once",
    "throw": "the shapes of cloth over an edge, true to 1 cm, part from what carries it by 2 mm",
    "fruit": "the shapes of a bowl, true to 1 cm, touch it beside where it lies",
}


@pytest.fixture(scope="module")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, int], World]:
    """Each is composed once, for both engines."""
    return {}


def world(kind: str, seed: int, folder: Path) -> World:
    path = folder / "room.yaml"
    text = write(generate(kind, seed, clutter=USUAL_CLUTTER))
    path.write_text(f"{text}\nphysics: {{}}\n", encoding="utf-8")
    for stage in STAGES:
        scene = compose_room(path, folder / "out", only=stage).scene
    return read_world(open_stage(scene))


def restless(world: World, engine: str) -> Iterator[str]:
    """What moves or turns, its joints too."""
    categories = {body.name: body.category for body in world.bodies}
    simulation = adapters.load(adapters.ENGINES, engine).open(world)
    simulation.step(SECONDS)
    for row in displacements(world, simulation):
        far = row.millimetres > MOST_MM or row.degrees > MOST_DEG
        if far and categories[row.body] not in EXCUSED:
            yield f"{row.body}: {row.millimetres:.1f} mm, {row.degrees:.2f} degrees"
    simulation.close()


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("kind", "seed"), ROOMS)
def test_a_composed_room_rests(
    rooms: dict[tuple[str, int], World], kind: str, seed: int, engine: str, tmp_path: Path
) -> None:
    if (kind, seed) not in rooms:
        rooms[kind, seed] = world(kind, seed, tmp_path)
    assert list(restless(rooms[kind, seed], engine)) == []
