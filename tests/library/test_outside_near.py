"""What is near a room: no thing twice, none in the room, the same colours, few triangles."""

import math

import numpy as np
import pytest
import shapely

from openrooms_usd.draws import generator
from openrooms_usd.library.environments import directions
from openrooms_usd.library.outside import SCENES, Site
from openrooms_usd.library.outside.facades import Plain, Surfaces
from openrooms_usd.library.outside.faces import Face
from openrooms_usd.library.outside.foliage import PLANTS
from openrooms_usd.library.outside.houses import House
from openrooms_usd.library.outside.land import tile
from openrooms_usd.library.outside.near import parted
from openrooms_usd.library.outside.plants import Hedge
from openrooms_usd.library.outside.solid import even_light, painted, solid

ROOM = ((0.0, 0.0), (4.4, 0.0), (4.4, 3.6), (0.0, 3.6))
EYE = 1.75


def scene_of(name: str, seed: int):
    return SCENES[name](Site(name, seed).nursery(drawn=False))


def length(hedges) -> float:
    return sum(math.dist(hedge.start, hedge.end) for hedge in hedges)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("name", SCENES)
def test_a_thing_is_near_or_far_and_never_both(name: str, seed: int) -> None:
    whole = scene_of(name, seed)
    near, far = parted(whole, EYE, np.array(ROOM) - [2.2, 1.8])
    single = [thing for thing in whole.things if not isinstance(thing, Hedge)]
    left = [thing for thing in far.things if not isinstance(thing, Hedge)]
    found = [*near.plants, *near.houses, *left]
    assert len({id(thing) for thing in found}) == len(found)
    assert {id(thing) for thing in found} == {id(thing) for thing in single}
    hedges = [thing for thing in far.things if isinstance(thing, Hedge)]
    there = [thing for thing in whole.things if isinstance(thing, Hedge)]
    assert length([*near.hedges, *hedges]) == pytest.approx(length(there), abs=1.0)


@pytest.mark.parametrize("name", SCENES)
def test_nothing_stands_in_a_large_room_or_at_its_walls(name: str) -> None:
    outline = np.array([(-9.0, -7.0), (9.0, -7.0), (9.0, 7.0), (-9.0, 7.0)])
    room = shapely.Polygon(outline)
    near, far = parted(scene_of(name, 3), EYE, outline)
    for thing in (*near.plants, *near.houses, *near.hedges, *far.things):
        if isinstance(thing, House):
            assert shapely.Polygon(thing.plan()).distance(room) > 1.0
        elif isinstance(thing, Hedge):
            assert shapely.LineString([thing.start, thing.end]).distance(room) > 1.0
        else:
            assert shapely.Point(thing.x, thing.y).distance(room) > 1.0


@pytest.mark.parametrize("name", SCENES)
def test_it_has_few_triangles(name: str) -> None:
    for seed in range(6):
        near, _ = parted(scene_of(name, seed), EYE, np.array(ROOM) - [2.2, 1.8])
        surfaces = Surfaces(generator(seed, "outside", "surfaces"))
        made = solid(near, surfaces, generator(seed))
        kinds = {placed.kind for placed in made.placed}
        grown = [PLANTS[kind](generator(seed, kind)) for kind in kinds]
        meshes = [part.mesh for part in made.parts]
        meshes += [mesh for plant in grown for mesh in plant if mesh is not None]
        assert sum(len(mesh.triangles()[0]) for mesh in meshes) < 3_200


@pytest.mark.parametrize("kind", PLANTS)
def test_plants_are_one_unit_high_and_stand_on_the_land(kind: str) -> None:
    grown = PLANTS[kind](generator(1, kind))
    low, high = grown.leaves.extent
    foot = low[2] if grown.wood is None else grown.wood.extent[0, 2]
    assert -0.15 < foot < 0.3 and 0.9 < high[2] < 1.12
    assert np.isfinite(grown.leaves.st).all()
    again = PLANTS[kind](generator(1, kind))
    assert again.leaves.points.tobytes() == grown.leaves.points.tobytes()


def test_scenes_are_the_same_without_pictures_of_plants() -> None:
    site = Site("garden", 4)
    drawn, blank = (SCENES["garden"](site.nursery(drawn=way)) for way in (True, False))
    assert len(drawn.things) == len(blank.things)
    for one, two in zip(drawn.things, blank.things, strict=True):
        assert one.distance == two.distance


def test_the_picture_of_a_face_is_its_reflectance() -> None:
    """Whatever way it looks: it is lit by the scene, not by its picture."""
    flat = Surfaces(generator(1, "test"))
    flat.rough[:] = 0.0
    for normal in ((0.0, -1.0), (1.0, 0.0)):
        first = np.array([-normal[1], normal[0], 0.0])
        outline = np.array([(0, 0), (6, 0), (6, 4), (0, 4)], dtype=float)
        paint = Plain(flat, (0.5, 0.4, 0.3))
        face = Face(np.array([1.0, 5.0, 0.0]), first, np.array([0, 0, 1.0]), outline, paint)
        pixels = painted(face, even_light(), outline[[0, 2]])
        assert pixels == pytest.approx(np.broadcast_to([0.5, 0.4, 0.3], pixels.shape), rel=0.01)


@pytest.mark.parametrize("kind", ["lawn", "paving", "asphalt"])
def test_land_repeats_without_a_seam(kind: str) -> None:
    pixels = tile(kind, Surfaces(generator(2, "test")), 64)
    inner = np.abs(np.diff(pixels, axis=1)).mean()
    assert np.abs(pixels[:, 0] - pixels[:, -1]).mean() < 2.0 * inner
    assert pixels.mean() == pytest.approx(tile(kind, Surfaces(generator(5)), 64).mean(), rel=0.05)


@pytest.mark.parametrize("facing", [90.0, 180.0, 305.0])
def test_from_the_middle_of_the_room_near_things_stand_where_the_panorama_had_them(
    facing: float,
) -> None:
    height = 240
    site = Site("garden", 3, storey=1, facing=facing, outline=ROOM)
    frame = site.world_from_scene(height, 0.2)
    place = np.array([3.0, 8.0, 5.5])
    seen = frame @ [*place, 1.0] - [2.2, 1.8, 0.2 + 1.5, 0.0]
    from_eye = place - [0.0, 0.0, site.eye]
    before = directions(height) @ from_eye
    row, column = np.unravel_index(before.argmax(), before.shape)
    after = directions(height)[row, (column - site.turn(height)) % (2 * height)]
    cosine = float(after @ seen[:3]) / float(np.linalg.norm(seen[:3]))
    assert math.degrees(math.acos(min(cosine, 1.0))) < 1.0
