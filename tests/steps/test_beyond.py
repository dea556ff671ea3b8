"""Hallways behind openings: closed, clear of the room and of windows, lit, no way for the sky."""

from pathlib import Path

import numpy as np
import pytest
import shapely
from pxr import Usd, UsdGeom, UsdLux

from openrooms_usd import names
from openrooms_usd.building.hallways import Hallway, door_space, hallway
from openrooms_usd.description import parse_room
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.layout.beyond import author_beyond_lamps, decor
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.steps.lights.daylight import author_portals
from openrooms_usd.usd.files.layers import apply_metadata
from openrooms_usd.usd.light.emitters import world_area
from openrooms_usd.usd.light.lights import MeshLight, read_lights
from openrooms_usd.usd.shapes.meshes import read_meshes, world_triangles

L_SHAPE = "[[0, 0], [6, 0], [6, 2.5], [2.5, 2.5], [2.5, 6], [0, 6]]"
ROOM = """
layout:
  polygon: {polygon}
  openings:
    - {{kind: opening, wall: 0, at: 2, beyond: hallway}}
    - {{kind: door, wall: 1, at: 1.2, open: 60, beyond: hallway}}
    - {{kind: door, wall: 5, at: 1.0, beyond: hallway}}
    - {{kind: window, wall: 0, at: 4.5}}
    {more}
"""


def author(more: str = "", polygon: str = L_SHAPE) -> tuple[Usd.Stage, StepContext]:
    stage = Usd.Stage.CreateInMemory()
    apply_metadata(stage.GetRootLayer())
    text = ROOM.format(polygon=polygon, more=more)
    context = StepContext(parse_room(text), Path(), stage, Path("layout"))
    LayoutStep().author(context)
    UsdGeom.Scope.Define(stage, names.LIGHTS)
    stage.DefinePrim(names.ENVIRONMENT, "DomeLight")
    return stage, context


def beyond(stage: Usd.Stage) -> set[str]:
    found = stage.GetPrimAtPath(names.BEYOND)
    return {prim.GetName() for prim in found.GetChildren()} if found else set()


def plan(stage: Usd.Stage, name: str) -> shapely.Polygon:
    """What a hallway covers of the land."""
    points = [
        world_triangles([mesh])[0]
        for mesh in read_meshes(stage)
        if str(mesh.path).startswith(f"{names.BEYOND}/{name}/")
    ]
    flat = np.concatenate([p.reshape(-1, 3) for p in points])[:, :2]
    return shapely.MultiPoint(flat).convex_hull


def test_only_what_can_be_looked_through_has_one() -> None:
    """A shut door shows nothing; what leads outside is as it was."""
    stage, context = author()
    assert beyond(stage) == {"opening_0", "door_0"}
    assert context.notes == []


def test_the_sky_comes_in_by_the_window_alone() -> None:
    stage, context = author("- {kind: opening, wall: 5, at: 3.5}")
    author_portals(context)
    portals = {prim.GetName() for prim in stage.GetPrimAtPath(names.PORTALS).GetChildren()}
    assert portals == {"window_0", "opening_1"}
    stage.GetPrimAtPath(f"{names.BEYOND}/opening_0").SetActive(False)
    author_portals(context)
    assert stage.GetPrimAtPath(f"{names.PORTALS}/opening_0")


def test_it_is_clear_of_the_room_and_of_what_windows_see() -> None:
    """In the notch of an L, where there is little space, too."""
    stage, _ = author("- {kind: opening, wall: 2, at: 1.75, width: 1.2, beyond: hallway}")
    room = shapely.Polygon([(0, 0), (6, 0), (6, 2.5), (2.5, 2.5), (2.5, 6), (0, 6)])
    hallways = {name: plan(stage, name) for name in beyond(stage)}
    assert "opening_1" in hallways
    for name, one in hallways.items():
        assert one.intersection(room.buffer(0.18, join_style="mitre")).area < 1e-6, name
        assert one.intersection(shapely.box(3.8, -3.0, 5.2, -0.2)).area < 1e-6, name
        others = [two for other, two in hallways.items() if other != name]
        assert all(one.intersection(two).area < 1e-6 for two in others)


def test_where_there_is_no_space_it_leads_outside_and_a_note_says_so() -> None:
    narrow = "[[0, 0], [6, 0], [6, 6], [5, 6], [5, 1.5], [4.2, 1.5], [4.2, 6], [0, 6]]"
    stage, context = author("- {kind: opening, wall: 3, at: 2.0, beyond: hallway}", polygon=narrow)
    assert "opening_1" not in beyond(stage)
    assert context.notes == ["opening_1: no space for a hallway behind it; it leads outside"]


def test_no_ray_leaves_it_but_by_the_opening() -> None:
    size = Hallway(-1.0, 1.5, 0.2, 1.6, 2.5)
    meshes = [mesh for _, _, mesh in hallway(size)]
    points = np.concatenate(
        [mesh.points[mesh.indices[mesh.triangles()[0]].ravel()] for mesh in meshes]
    )
    caster = RayCaster(points, np.arange(len(points)).reshape(-1, 3))
    rng = np.random.default_rng(0)
    ways = rng.standard_normal((4000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    middle = np.array([0.2, 0.9, 1.2])
    missed = caster.first_hit(middle, ways).triangle < 0
    # They leave through the face of the room's wall, and all that go there do.
    t = (size.near - middle[1]) / np.minimum(ways[:, 1], -1e-9)
    x, _, z = (middle + t[:, None] * ways).T
    to_the_room = (ways[:, 1] < 0) & (x > -1.0) & (x < 1.5) & (z > 0.0) & (z < 2.5)
    assert np.array_equal(missed, to_the_room)


def test_its_lamp_gives_its_lumens() -> None:
    stage, _ = author()
    author_beyond_lamps(stage)
    lights = [light for light in read_lights(stage) if isinstance(light, MeshLight)]
    assert {str(light.path) for light in lights} == {
        f"{names.BEYOND}/{name}/Lamp" for name in beyond(stage)
    }
    for light in lights:
        area = world_area(stage.GetPrimAtPath(light.path))
        weights = np.array([0.2126, 0.7152, 0.0722])
        assert np.pi * area * float(light.radiance @ weights) == pytest.approx(800.0, rel=1e-3)
    assert UsdLux.MeshLightAPI(stage.GetPrimAtPath(lights[0].path))


def test_what_it_holds_stays_within_it_and_clear_of_its_door() -> None:
    size, kinds = Hallway(-2.0, 2.2, 0.2, 1.9, 2.5), set()
    for seed in range(12):
        place = size._replace(door=(seed % 5) / 4)
        door = door_space(place)
        assert door is not None and size.left < door[0] < door[1] < size.right
        for thing in decor(place, np.random.default_rng(seed)):
            (wide, deep, tall), (x, y, z) = thing.size, thing.at
            kinds.add(thing.category)
            assert size.left <= x - 0.5 * wide and x + 0.5 * wide <= size.right
            assert size.near <= y - 0.5 * deep and y + 0.5 * deep <= size.far
            assert z >= 0.0 and z + tall < size.height
            if thing.category == "picture":
                assert x + 0.5 * wide < door[0] or x - 0.5 * wide > door[1]
    assert kinds == {"picture", "rug"}
