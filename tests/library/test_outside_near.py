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
from openrooms_usd.library.outside.foliage import PLANTS, lobe
from openrooms_usd.library.outside.houses import House
from openrooms_usd.library.outside.near import Window, parted
from openrooms_usd.library.outside.plants import Hedge
from openrooms_usd.library.outside.solid import even_light, painted, solid

ROOM = ((0.0, 0.0), (4.4, 0.0), (4.4, 3.6), (0.0, 3.6))
EYE = 1.75
ALL_ROUND = [Window(0.0, 0.0, *way) for way in ((1, 0), (0, 1), (-1, 0), (0, -1))]


def scene_of(name: str, seed: int):
    return SCENES[name](Site(name, seed).nursery(drawn=False))


def length(hedges) -> float:
    return sum(math.dist(hedge.start, hedge.end) for hedge in hedges)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("name", SCENES)
def test_a_thing_is_near_or_far_and_never_both(name: str, seed: int) -> None:
    whole = scene_of(name, seed)
    near, far = parted(whole, EYE, np.array(ROOM) - [2.2, 1.8], ALL_ROUND)
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
    near, far = parted(scene_of(name, 3), EYE, outline, ALL_ROUND)
    for thing in (*near.plants, *near.houses, *near.hedges, *far.things):
        if isinstance(thing, House):
            assert shapely.Polygon(thing.plan()).distance(room) > 1.0
        elif isinstance(thing, Hedge):
            assert shapely.LineString([thing.start, thing.end]).distance(room) > 1.0
        else:
            assert shapely.Point(thing.x, thing.y).distance(room) > 1.0


@pytest.mark.one_in(2)
@pytest.mark.parametrize("name", SCENES)
def test_it_has_few_triangles(name: str) -> None:
    for seed in range(6):
        near, _ = parted(scene_of(name, seed), EYE, np.array(ROOM) - [2.2, 1.8], ALL_ROUND)
        surfaces = Surfaces(generator(seed, "outside", "surfaces"))
        made = solid(near, surfaces, generator(seed))
        kinds = {placed.kind for placed in made.placed}
        grown = [PLANTS[kind](generator(seed, kind)) for kind in kinds]
        meshes = [part.mesh for part in made.parts]
        meshes += [mesh for plant in grown for mesh in plant[:2] if mesh is not None]
        meshes.append(lobe(generator(seed)))
        assert sum(len(mesh.triangles()[0]) for mesh in meshes) < 3_000


@pytest.mark.parametrize("kind", PLANTS)
def test_plants_are_one_unit_high_and_stand_on_the_land(kind: str) -> None:
    grown, again = (PLANTS[kind](generator(1, kind)) for _ in range(2))
    points = [mesh.points for mesh in grown[:2] if mesh is not None]
    ball = lobe(generator(1, "lobe")).points
    points += [ball @ place[:3, :3].T + place[:3, 3] for place in grown.lobes]
    low, high = np.concatenate(points).min(axis=0), np.concatenate(points).max(axis=0)
    assert -0.2 < low[2] < 0.1 and 0.9 < high[2] < 1.15
    assert again.lobes.tobytes() == grown.lobes.tobytes()


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


@pytest.mark.parametrize("name", ["street", "garden"])
def test_what_no_window_shows_is_left_to_the_panorama(name: str) -> None:
    outline, front = np.array(ROOM) - [2.2, 1.8], Window(0.0, 1.8, 0.0, 1.0)
    near, far = parted(scene_of(name, 2), EYE, outline, [front])
    every, rest = parted(scene_of(name, 2), EYE, outline, ALL_ROUND)
    assert near.hedges and len(near.hedges) < len(every.hedges)
    assert all(max(hedge.start[1], hedge.end[1]) > 1.8 for hedge in near.hedges)
    assert all(plant.y > 1.8 for plant in near.plants)
    assert len(far.things) > len(rest.things)
    blind, _ = parted(scene_of(name, 2), EYE, outline, [])
    assert not (blind.plants or blind.hedges or blind.houses)


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
