"""Generated rooms of all types rest as they are composed, in both engines."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final, get_args

import pytest

from openrooms_usd import adapters
from openrooms_usd.composing import compose_room
from openrooms_usd.description.files import load_room
from openrooms_usd.description.room import RoomType
from openrooms_usd.generation import generate, write
from openrooms_usd.generation.rooms import USUAL_CLUTTER
from openrooms_usd.physics.world import World
from openrooms_usd.simulation.settling import displacements
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world
from tests.engines import ENGINES

SECONDS = 0.5
# Millimetres and degrees.
USUAL: Final = (2.0, 0.2)
# Lights and cameras have no bodies.
STAGES = ("layout", "alignment", "materials", "physics")
QUICK = {("closet", 1)}
ROOMS = [
    pytest.param(kind, seed, marks=[] if (kind, seed) in QUICK else pytest.mark.long)
    for seed in (1, 2)
    for kind in get_args(RoomType)
]
# Categories that move farther, by at most so many millimetres and degrees, and why.
EXCUSED: Final[dict[str, tuple[float, float, str]]] = {
    "towel": (50.0, 10.0, "on a hook: the shapes of both its sides, true to 1 cm, clasp the hook"),
    "bag": (60.0, 10.0, "on a hook, as a towel"),
    "paper": (25.0, 90.0, "a crumpled ball turns onto a face between floor and wall of a bin"),
    "laptop": (5.0, 0.5, "the dry friction of its hinge gives by 0.2 degrees in MuJoCo, once"),
    "fruit": (100.0, 180.0, "round: it rolls where the shapes of a bowl, true to 1 cm, let it"),
    "pillow": (25.0, 5.0, "hulls of 64 corners lie inside of what is round, by up to 9 mm"),
    "throw": (20.0, 5.0, "the shapes of cloth over an edge, true to 1 cm, part from what is below"),
    "umbrella": (70.0, 10.0, "on its tip in a corner: it slides, in Bullet farther"),
    "coaster": (1.0, 0.5, "a stack of thin discs: 0.3 mm at an edge are 0.2 degrees"),
    "napkin": (1.0, 1.0, "folded, of 2 mm: half a millimetre at an edge is half a degree"),
    "photo_frame": (2.0, 0.5, "Bullet: the strut behind it ends in an edge"),
    "dish_cloth": (10.0, 2.5, "50 g of cloth on cloth tremble in MuJoCo"),
}
# What lies on upholstery lies level in it: a cushion gives way, its shapes do not.
UPHOLSTERY: Final = ("sofa", "armchair", "bed", "chair", "office_chair")
ON_UPHOLSTERY: Final = (12.0, 6.0)


@dataclass(frozen=True)
class Composed:
    """A room.

    Attributes:
        world: Its bodies.
        limits: Millimetres and degrees by which each may move.
    """

    world: World
    limits: Mapping[str, tuple[float, float]]


@pytest.fixture(scope="module")
def rooms() -> dict[tuple[str, int], Composed]:
    """Each is composed once, for both engines."""
    return {}


def composed(kind: str, seed: int, folder: Path) -> Composed:
    path = folder / "room.yaml"
    text = write(generate(kind, seed, clutter=USUAL_CLUTTER))
    path.write_text(f"{text}\nphysics: {{}}\n", encoding="utf-8")
    for stage in STAGES:
        scene = compose_room(path, folder / "out", only=stage).scene
    world = read_world(open_stage(scene))
    categories = {body.name: body.category for body in world.bodies}
    limits = {name: EXCUSED.get(kind, (*USUAL, ""))[:2] for name, kind in categories.items()}
    for thing in load_room(path).furniture.objects or ():
        carrier = categories.get(str(getattr(thing, "on", None)))
        if carrier in UPHOLSTERY and thing.category not in EXCUSED:
            limits[str(getattr(thing, "name", None))] = ON_UPHOLSTERY
    return Composed(world, limits)


def restless(room: Composed, engine: str) -> Iterator[str]:
    """What moves or turns farther than it may, its joints too."""
    simulation = adapters.load(adapters.ENGINES, engine).open(room.world)
    simulation.step(SECONDS)
    for row in displacements(room.world, simulation):
        most_mm, most_degrees = room.limits[row.body]
        if row.millimetres > most_mm or row.degrees > most_degrees:
            yield f"{row.body}: {row.millimetres:.1f} mm, {row.degrees:.2f} degrees"
    simulation.close()


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("kind", "seed"), ROOMS)
def test_a_composed_room_rests(
    rooms: dict[tuple[str, int], Composed], kind: str, seed: int, engine: str, tmp_path: Path
) -> None:
    if (kind, seed) not in rooms:
        rooms[kind, seed] = composed(kind, seed, tmp_path)
    assert list(restless(rooms[kind, seed], engine)) == []
