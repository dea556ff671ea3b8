"""The world outside: what falls on its faces, what they send back, and equal bytes."""

import math
from functools import cache

import numpy as np
import pytest
import shapely

from openrooms_usd.colorimetry import luminance
from openrooms_usd.draws import generator
from openrooms_usd.library.surroundings.environments import directions, horizontal_illuminance
from openrooms_usd.library.surroundings.outside import SCENES, Site, outside_panorama
from openrooms_usd.library.surroundings.outside.canvas import Canvas
from openrooms_usd.library.surroundings.outside.daylight import Daylight, daylight_of
from openrooms_usd.library.surroundings.outside.facades import FacadeMaterials, Plain
from openrooms_usd.library.surroundings.outside.faces import Face, World
from openrooms_usd.library.surroundings.outside.foliage import PLANTS, lobe
from openrooms_usd.library.surroundings.outside.houses import House
from openrooms_usd.library.surroundings.outside.near import Window, parted
from openrooms_usd.library.surroundings.outside.noise import fractal_tile, sampled
from openrooms_usd.library.surroundings.outside.plants import Hedge
from openrooms_usd.library.surroundings.outside.shadows import Shadows
from openrooms_usd.library.surroundings.outside.solid import even_light, painted, solid
from openrooms_usd.library.surroundings.sky import Air, daylight
from openrooms_usd.library.surroundings.sunlight import SunPosition, refraction

HEIGHT = 240


def standing(elevation: float, azimuth: float = 180.0) -> SunPosition:
    return SunPosition(azimuth, elevation, elevation + refraction(elevation), 1.0)


@cache
def day(elevation: float = 40.0, *, clouds: float = 0.0, overcast: bool = False) -> Daylight:
    rng, air = generator(1, "test"), Air(overcast=overcast)
    return daylight_of(rng, standing(elevation), air, north=0.0, clouds=clouds, height=HEIGHT)


def made(scene: str = "street", **changes: object) -> np.ndarray:
    given = {"height": HEIGHT, **changes}
    keys = ("seed", "storey", "facing", "outline")
    site = Site(scene, **{"seed": 3, **{key: given.pop(key) for key in keys if key in given}})
    position, air = given.pop("position", standing(40.0)), given.pop("air", Air())
    return outside_panorama(position, air, site, **given)


def irradiance(pixels: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """(3,) of a surface, pixel by pixel."""
    height = len(pixels)
    edges = np.sin(math.pi * (0.5 - np.arange(height + 1) / height))
    angles = (edges[:-1] - edges[1:]) * math.pi / height
    cosine = np.clip(directions(height) @ normal, 0, None) * angles[:, None]
    return np.einsum("hw,hwc->c", cosine, pixels)


@pytest.mark.parametrize("overcast", [False, True])
def test_its_open_sky_gives_the_light_of_the_plain_one(overcast: bool) -> None:
    air = Air(overcast=overcast)
    plain = horizontal_illuminance(daylight(standing(40.0), air, height=HEIGHT))
    assert float(luminance(day(overcast=overcast).level)) == pytest.approx(plain, rel=0.01)


@pytest.mark.parametrize("normal", [(0, 0, 1), (1, 0, 0), (0, -1, 0), (0.6, 0, 0.8)])
def test_a_face_gathers_what_the_sky_and_the_land_send(normal: tuple[float, ...]) -> None:
    """Summed over a panorama of that sky and that land, pixel by pixel."""
    moment = day(clouds=0.4)
    whole = np.concatenate([moment.sky, np.broadcast_to(moment.land, moment.sky.shape)])
    expected = irradiance(whole, np.array(normal))
    assert moment.ambient(np.array(normal)) == pytest.approx(expected, rel=0.01)


def test_clouds_are_brighter_than_the_sky_and_leave_the_sun_alone() -> None:
    cloudy, clear = day(clouds=0.5), day()
    assert luminance(cloudy.sky).mean() > luminance(clear.sky).mean()
    way = directions(HEIGHT)[: HEIGHT // 2]
    about = np.arccos(np.clip(way @ clear.sun, -1, 1)) < 0.1
    assert np.allclose(cloudy.sky[about], clear.sky[about], rtol=0.02)
    # Nothing in the sky is brighter than a white sheet that faces the sun, but the sun's own glare.
    far = np.arccos(np.clip(way @ clear.sun, -1, 1)) > 0.6
    assert luminance(cloudy.sky)[far].max() < float(luminance(cloudy.beam)) / math.pi + 1e4


@pytest.mark.parametrize("elevation", [15.0, 40.0, 70.0])
def test_a_wall_sends_back_its_albedo_times_irradiance_over_pi(elevation: float) -> None:
    """A wall 20 m before the eye, lit by a sun before it; nothing stands between."""
    moment, flat = day(elevation), FacadeMaterials(generator(1, "test"))
    flat.rough[:] = 0.0
    canvas, albedo = Canvas(HEIGHT, -1.0, 1.0), (0.5, 0.4, 0.3)
    # The sun stands in the south, along -Y; the wall looks there from the north.
    first, up = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    outline = np.array([(0, 0), (40, 0), (40, 8), (0, 8)])
    face = Face(np.array([-20.0, 20.0, -1.7]), first, up, outline, Plain(flat, albedo))
    shadows = Shadows()
    shadows.cast(moment.sun)
    face.draw(canvas, World(moment, shadows, 1.7))
    picture = np.zeros((HEIGHT, 2 * HEIGHT, 3), np.float32)
    canvas.over(picture)
    toward = np.array([0.0, -1.0, 0.0])
    falls = moment.ambient(toward) + moment.beam * max(0.0, float(moment.sun @ toward))
    row, column = np.unravel_index((directions(HEIGHT) @ [0, 1, 0]).argmax(), picture.shape[:2])
    # The air before it adds a little.
    assert picture[row - 3, column] == pytest.approx(np.array(albedo) * falls / math.pi, rel=0.01)


def test_a_shadow_is_as_long_as_the_sun_says() -> None:
    shadows = Shadows()
    wall = (np.abs(shadows.x) < 20) & (np.abs(shadows.y - 10) < 0.6)
    shadows.stand((6.0 * wall).astype(np.float32))
    elevation = math.radians(35.0)
    shadows.cast(np.array([0.0, math.cos(elevation), math.sin(elevation)]))
    away = np.linspace(0.9, 20.0, 400).astype(np.float32)
    lit = shadows.lit(0.0 * away, 10.0 - away, np.zeros_like(away))
    edge = away[np.argmax(lit > 0.5)]
    assert edge == pytest.approx(6.0 / math.tan(elevation), abs=0.9)
    assert lit[0] == 0.0 and lit[-1] > 0.9
    # Above the line to the sun it is light.
    assert shadows.lit(away[:1] * 0, 10.0 - away[:1], np.full(1, 6.5, np.float32)) == 1.0


def test_noise_repeats_without_a_seam() -> None:
    tile = fractal_tile(generator(1, "test"), 1.5)
    assert tile.mean() == pytest.approx(0.0, abs=1e-5) and tile.std() == pytest.approx(1.0)
    u = np.array([0.25, 0.9990234], dtype=np.float32)
    assert sampled(tile, u, u) == pytest.approx(sampled(tile, u - 3, u + 2), abs=1e-3)
    jump = np.abs(tile[0] - tile[-1]).mean()
    assert jump < 1.5 * np.abs(np.diff(tile, axis=0)).mean()


@pytest.mark.slow
@pytest.mark.parametrize("scene", SCENES)
def test_every_scene_is_finite_positive_and_has_sky_and_land(scene: str) -> None:
    # High enough that no house of a city stands before the sun.
    pixels = made(scene, storey=1, clouds=0.3, position=standing(60.0))
    assert pixels.shape == (HEIGHT, 2 * HEIGHT, 3) and pixels.dtype == np.float32
    assert np.isfinite(pixels).all() and pixels.min() >= 0.0
    nits = luminance(pixels)
    # The brightest is the sun; the land by day has the luminance of things in daylight.
    assert nits.max() > 1e7
    below = np.median(nits[HEIGHT * 5 // 9 : HEIGHT * 7 // 9])
    assert 300 < below < 20_000


@pytest.mark.slow
def test_equal_seeds_give_equal_bytes_and_others_another_place() -> None:
    first, again = made(height=120), made(height=120)
    assert first.tobytes() == again.tobytes()
    assert made(height=120, seed=4).tobytes() != first.tobytes()


@pytest.mark.slow
def test_facing_turns_the_land_under_the_same_sun() -> None:
    """A turn by whole pixels: houses move along, the sun stays."""
    overcast = Air(overcast=True)
    still = made(height=120, air=overcast)
    turned = made(height=120, air=overcast, facing=180.0)
    # Facing +X instead of +Y ... is a quarter to the left.
    assert np.array_equal(turned, np.roll(still, -60, axis=1))
    sunny, other = made(height=120), made(height=120, facing=0.0)
    place = [np.unravel_index(luminance(p).argmax(), p.shape[:2]) for p in (sunny, other)]
    assert place[0] == place[1]


@pytest.mark.slow
def test_illuminance_scales_sky_and_land_alike() -> None:
    plain, wanted = made(height=120), made(height=120, illuminance=5_000.0)
    ratio = 5_000.0 / float(luminance(day().level))
    seen = plain > 1.0
    assert np.median(wanted[seen] / plain[seen]) == pytest.approx(ratio, rel=0.02)


@pytest.mark.slow
def test_a_night_is_dark_but_for_lamps_behind_windows() -> None:
    nits = luminance(made("city", position=standing(-30.0), storey=2))
    assert np.median(nits) < 0.01
    assert 5 < nits.max() < 200


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
        surfaces = FacadeMaterials(generator(seed, "outside", "surfaces"))
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
    flat = FacadeMaterials(generator(1, "test"))
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
