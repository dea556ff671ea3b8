"""What stands near the windows: labelled, lit by the panorama, and no part of the room."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdPhysics, UsdShade

from openrooms_usd import names
from openrooms_usd.description import parse_room
from openrooms_usd.library.surroundings.outside.ledges import NET, NET_PASSES, ledges
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.steps.lights.daylight import author_nearby, portals, site_of
from openrooms_usd.usd.files.layers import apply_metadata
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shapes.meshes import is_outside, read_meshes

# One room of five has screens; this seed's is one, at storey 0.
SCREENED = 3
ROOM = """
seed: {seed}
layout:
  polygon: [[0, 0], [4.4, 0], [4.4, 3.6], [0, 3.6]]
  openings: [{{kind: window, wall: 2, sill: {sill}}}, {{kind: door, wall: 0, open: 40}}]
lights:
  environment: {{from: outside, scene: {scene}, storey: {storey}, near: {near}}}
"""


def author(
    folder: Path,
    scene: str = "garden",
    storey: int = 0,
    near: str = "true",
    sill: float = 0.9,
    seed: int = 3,
) -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    apply_metadata(stage.GetRootLayer())
    room = parse_room(ROOM.format(scene=scene, storey=storey, near=near, sill=sill, seed=seed))
    context = StepContext(room, Path(), stage, folder)
    LayoutStep().author(context)
    site = site_of(context, room.lights.environment, portals(stage))
    windows = {Path(portal.path).name: portal for portal in portals(stage, "window")}
    assert list(windows) == ["window_0"]
    author_nearby(context, site, windows)
    return stage


def test_it_is_labelled_and_neither_collides_nor_belongs_to_the_room(tmp_path: Path) -> None:
    stage = author(tmp_path)
    outside = [mesh for mesh in read_meshes(stage) if is_outside(mesh.path)]
    found = {read_label(mesh.prim, names.CATEGORY) for mesh in outside}
    assert {"hedge", "tree", "windowsill"} <= found and None not in found
    for prim in stage.GetPrimAtPath(names.OUTSIDE).GetChildren():
        assert not prim.HasAPI(UsdPhysics.CollisionAPI)
    rooms = read_meshes(stage, outside=False)
    assert not any(is_outside(mesh.path) for mesh in rooms)
    named = {path for path, outcome, _ in rooms.losses if outcome == "skipped"}
    assert {mesh.path for mesh in outside} <= named


def test_the_scene_tells_what_is_indoors(tmp_path: Path) -> None:
    scene = translate(author(tmp_path))
    points = scene.triangles.corners[scene.indoors].reshape(-1, 3)
    # The door stands open.
    assert (points > -1.5).all() and (points < [5.5, 5.0, 3.5]).all()
    assert scene.room_radius < 5.0 < scene.radius
    room = translate(author(tmp_path), outside=False)
    assert scene.indoors.sum() == len(room.triangles)
    assert np.array_equal(scene.origin, room.origin)


@pytest.mark.parametrize("storey", [0, 1, 2])
def test_the_land_lies_below_the_floor_by_its_storeys(tmp_path: Path, storey: int) -> None:
    stage = author(tmp_path, scene="city", storey=storey)
    frame = UsdGeom.Xformable(stage.GetPrimAtPath(names.OUTSIDE)).GetLocalTransformation()
    assert frame.ExtractTranslation()[2] == pytest.approx(-0.25 - 3.0 * storey)


def test_a_low_window_high_up_has_a_rail(tmp_path: Path) -> None:
    rails = []
    for storey, sill in ((0, 0.1), (2, 0.9), (2, 0.1)):
        stage = author(tmp_path, "city", storey, sill=sill)
        rails.append(bool(stage.GetPrimAtPath(f"{names.OUTSIDE}/window_0/Rail")))
    assert rails == [False, False, True]


def test_the_sill_is_outside_and_below_its_window(tmp_path: Path) -> None:
    stage = author(tmp_path, sill=0.8)
    path = f"{names.OUTSIDE}/window_0/Sill"
    mesh = next(mesh for mesh in read_meshes(stage) if mesh.path == path)
    low, high = mesh.world_points().min(0), mesh.world_points().max(0)
    assert high[2] == pytest.approx(0.8, abs=1e-4) and low[1] > 3.6


def test_plants_wear_their_looks_inside_of_their_prototypes(tmp_path: Path) -> None:
    """Blender, for one, hands no binding of an instance down to its meshes."""
    stage = author(tmp_path)
    shown = [prim for prim in stage.GetPrimAtPath(names.OUTSIDE).GetChildren() if prim.IsInstance()]
    assert shown and not any(prim.HasAPI(UsdShade.MaterialBindingAPI) for prim in shown)
    for prototype in stage.GetPrototypes():
        meshes = [prim for prim in Usd.PrimRange(prototype) if prim.IsA(UsdGeom.Mesh)]
        assert all(mesh.HasAPI(UsdShade.MaterialBindingAPI) for mesh in meshes)


def test_it_can_be_left_away(tmp_path: Path) -> None:
    stage = author(tmp_path, near="false")
    assert not stage.GetPrimAtPath(names.OUTSIDE)


def test_equal_seeds_give_equal_bytes(tmp_path: Path) -> None:
    stages = [author(tmp_path, "street") for _ in range(2)]
    one, two = (stage.GetRootLayer().ExportToString() for stage in stages)
    assert one == two


@pytest.mark.parametrize(("width", "covered"), [(1.0, 1.0), (2.2, 0.75)])
def test_a_screen_covers_a_window_or_one_part_of_a_wide_one(width: float, covered: float) -> None:
    made = ledges(width, 1.2, 0.9, high=False, flowers=False, screen=True)
    (net,) = (ledge for ledge in made if ledge.look == NET)
    low, high = net.mesh.extent
    assert high[0] - low[0] == pytest.approx(covered) and high[1] - low[1] == pytest.approx(1.2)
    assert low[0] == pytest.approx(-0.5 * width) and high[2] < 0.0


def test_a_screen_is_a_pane_that_mirrors_nothing(tmp_path: Path) -> None:
    scene = translate(author(tmp_path, seed=SCREENED))
    nets = [pane for pane in scene.panes if pane.surface.pane == pytest.approx(NET_PASSES)]
    assert len(nets) == 1 and nets[0].is_sheet and nets[0].surface.ior < 1.03
