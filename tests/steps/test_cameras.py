"""The cameras step on small rooms made by hand."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdRender, Vt

from openrooms_usd import names
from openrooms_usd.description.cameras import Cameras
from openrooms_usd.description.room import Room
from openrooms_usd.geometry.composition import BARE
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.geometry.viewpoints import PITCH_DEG
from openrooms_usd.geometry.views import clear
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.cameras import selection as stage_module
from openrooms_usd.steps.cameras.selection import ViewCandidates
from openrooms_usd.steps.cameras.step import CamerasStep
from openrooms_usd.usd.cameras import list_cameras, read_camera
from openrooms_usd.usd.files.layers import apply_metadata
from openrooms_usd.usd.semantics import label
from openrooms_usd.usd.shapes.meshes import define_mesh, read_meshes, world_triangles

POLYGON = np.array([[0.0, 0], [5, 0], [5, 4], [0, 4]])
QUADS = np.array(
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
)


def cuboid(low: tuple[float, ...], high: tuple[float, ...]) -> Mesh:
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    points = np.array(low) + corners * (np.array(high) - np.array(low))
    return Mesh(points, np.full(6, 4, dtype=np.int32), QUADS.astype(np.int32).reshape(-1))


def face(stage: Usd.Stage, path: str, points: list[Any]) -> None:
    ring = np.array(points, dtype=np.float64)
    count = np.array([len(ring)], dtype=np.int32)
    define_mesh(stage, path, Mesh(ring, count, np.arange(len(ring), dtype=np.int32)))


def room_stage(height: float = 2.6, *, polygon: bool = True) -> Usd.Stage:
    """A closed room with two pieces of furniture, and an empty layer on top to write to."""
    weak = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(weak)
    apply_metadata(weak)
    UsdGeom.Xform.Define(stage, names.WORLD)
    room = UsdGeom.Xform.Define(stage, names.ROOM).GetPrim()
    if polygon:
        attribute = room.CreateAttribute("openrooms:room:floor", Sdf.ValueTypeNames.Double2Array)
        attribute.Set(Vt.Vec2dArray.FromNumpy(POLYGON))
    face(stage, names.FLOOR, [[*corner, 0] for corner in POLYGON])
    face(stage, names.CEILING, [[*corner, height] for corner in POLYGON[::-1]])
    for k, (a, b) in enumerate(zip(POLYGON, np.roll(POLYGON, -1, axis=0), strict=True)):
        ring = [[*b, 0], [*a, 0], [*a, height], [*b, height]]
        face(stage, f"{names.WALLS}/wall_{k}", ring)
    define_mesh(stage, f"{names.FURNITURE}/table/top", cuboid((2, 1.5, 0.7), (3.2, 2.5, 0.75)))
    define_mesh(stage, f"{names.FURNITURE}/shelf/body", cuboid((0.1, 1, 0), (0.5, 2, 2)))
    root = Sdf.Layer.CreateAnonymous(".usda")
    apply_metadata(root)
    root.subLayerPaths = [weak.identifier]
    composed = Usd.Stage.Open(root)
    composed.SetEditTarget(root)
    return composed


def author(stage: Usd.Stage, *views: dict[str, Any], seed: int = 0, **cameras: Any) -> StepContext:
    section = {"views": list(views), **cameras} if views else cameras
    room = Room.model_validate({"seed": seed, "cameras": section})
    context = StepContext(room, Path(), stage, Path("cameras"))
    CamerasStep().author(context)
    return context


def test_views_are_where_the_description_says() -> None:
    stage = room_stage()
    author(
        stage,
        {"eye": [1, 1, 1.5], "target": [4, 3, 0.5], "fov": 75},
        {
            "from": "pose",
            "name": "door",
            "exposure_value": 7,
            "world_from_camera": [[1, 0, 0, 2], [0, 0, 1, 1], [0, -1, 0, 1.6]],
        },
        resolution=[320, 180],
    )
    door, first = (read_camera(prim, 320, 180) for prim in list_cameras(stage))
    ahead = np.array([3, 2, -1]) / np.sqrt(14)
    np.testing.assert_allclose(first.world_from_camera[:3, 2], ahead, atol=1e-9)
    np.testing.assert_allclose(first.world_from_camera[:3, 3], [1, 1, 1.5])
    assert first.K[0, 0] == pytest.approx(160 / np.tan(np.radians(37.5)), rel=1e-6)
    assert first.exposure is None
    np.testing.assert_allclose(
        door.world_from_camera[:3], [[1, 0, 0, 2], [0, 0, 1, 1], [0, -1, 0, 1.6]]
    )
    assert door.exposure == pytest.approx(1 / (1.2 * 2**7), rel=1e-6)


@pytest.mark.slow
def test_names_are_given_or_the_next_free() -> None:
    stage = room_stage()
    look = {"eye": [1, 1, 1.5], "target": [4, 3, 0.5]}
    author(
        stage,
        look,
        {**look, "name": "view_1"},
        look,
        {"from": "select", "count": 2},
        {"from": "select", "name": "best", "count": 1},
    )
    found = [prim.GetName() for prim in stage.GetPrimAtPath(names.CAMERAS).GetChildren()]
    assert found == ["view_0", "view_1", "view_2", "view_3", "view_4", "best_0"]


def test_render_settings_name_the_first_camera() -> None:
    stage = room_stage()
    author(stage, {"eye": [1, 1, 1.5], "target": [4, 3, 0.5], "name": "main"}, resolution=[64, 48])
    settings = UsdRender.Settings(stage.GetPrimAtPath(names.RENDER_SETTINGS))
    assert tuple(settings.GetResolutionAttr().Get()) == (64, 48)
    assert settings.GetCameraRel().GetTargets() == [f"{names.CAMERAS}/main"]
    assert list(settings.GetIncludedPurposesAttr().Get()) == ["default", "render"]


@pytest.mark.parametrize(
    ("polygon", "prefer", "heights"),
    [
        (True, "photograph", (1.2, 1.6)),
        (False, "photograph", (1.2, 1.6)),
        (True, "paper", (1.4, 1.8)),
    ],
)
def test_selected_views_stand_free_in_the_room(
    polygon: bool, prefer: str, heights: tuple[float, float]
) -> None:
    stage = room_stage(polygon=polygon)
    context = author(stage, {"from": "select", "count": 4, "prefer": prefer})
    assert context.notes == []
    poses = [read_camera(prim, 64, 48).world_from_camera for prim in list_cameras(stage)]
    eyes = np.array([pose[:3, 3] for pose in poses])
    assert len(eyes) == 4
    assert (eyes > [0.29, 0.29, heights[0]]).all()
    assert (eyes < [4.71, 3.71, heights[1]]).all()
    rise = np.degrees(np.arcsin([pose[2, 2] for pose in poses]))
    level = (PITCH_DEG[0] - 1e-3 <= rise) & (rise <= 1e-3)
    assert level.all() if prefer == "photograph" else not level.all()
    points, triangles, _ = world_triangles(read_meshes(stage))
    assert clear(RayCaster(points, triangles), eyes).all()
    away = np.linalg.norm(eyes[:, None] - eyes[None], axis=2)
    turned = np.array([[a[:3, 2] @ b[:3, 2] for b in poses] for a in poses])
    different = (away > 0.5) | (turned < np.cos(np.radians(15)))
    assert different[~np.eye(4, dtype=bool)].all()


def test_under_a_low_ceiling_eyes_stay_below_it() -> None:
    stage = room_stage(height=1.5)
    author(stage, {"from": "select", "count": 3})
    heights = [read_camera(prim, 4, 3).world_from_camera[2, 3] for prim in list_cameras(stage)]
    assert len(heights) == 3
    assert max(heights) <= 1.25


@pytest.mark.slow
def test_the_seed_decides_and_the_bytes_are_the_same() -> None:
    texts = []
    for seed in (1, 1, 2):
        stage = room_stage()
        author(stage, {"from": "select", "count": 2}, seed=seed)
        texts.append(stage.GetRootLayer().ExportToString().partition("def ")[2])
    assert texts[0] == texts[1] != texts[2]


@pytest.mark.slow
def test_each_selection_draws_its_own_candidates() -> None:
    stage = room_stage()
    author(stage, {"from": "select", "count": 1}, {"from": "select", "count": 1})
    first, second = (read_camera(prim, 4, 3).world_from_camera for prim in list_cameras(stage))
    assert not np.allclose(first, second)


@pytest.mark.slow
def test_edits_below_count() -> None:
    """What a person moved into the way is in the way."""
    stage = room_stage()
    author(stage, {"from": "select", "count": 1}, seed=5)
    eye = read_camera(list_cameras(stage)[0], 4, 3).world_from_camera[:3, 3]
    again = room_stage()
    define_mesh(again, "/World/Furniture/moved/body", cuboid(tuple(eye - 0.3), tuple(eye + 0.3)))
    author(again, {"from": "select", "count": 1}, seed=5)
    moved = read_camera(list_cameras(again)[0], 4, 3).world_from_camera[:3, 3]
    assert np.abs(moved - eye).max() > 0.3


def test_a_camera_that_was_moved_by_hand_stays_moved() -> None:
    stage = room_stage()
    with Usd.EditContext(stage, stage.GetSessionLayer()):
        camera = UsdGeom.Camera(stage.OverridePrim(f"{names.CAMERAS}/view_0"))
        camera.AddTransformOp().Set(Gf.Matrix4d().SetTranslate((1, 2, 3)))
    author(stage, {"eye": [1, 1, 1.5], "target": [4, 3, 0.5]})
    prim = stage.GetPrimAtPath(f"{names.CAMERAS}/view_0")
    np.testing.assert_allclose(read_camera(prim, 4, 3).world_from_camera[:3, 3], [1, 2, 3])
    stage.GetSessionLayer().Clear()
    np.testing.assert_allclose(read_camera(prim, 4, 3).world_from_camera[:3, 3], [1, 1, 1.5])


def test_a_room_without_space_is_framed_with_a_note() -> None:
    stage = room_stage()
    define_mesh(stage, "/World/Furniture/block/body", cuboid((0.1, 0.1, 0), (4.9, 3.9, 2.5)))
    context = author(stage, {"from": "select", "count": 3})
    assert len(list_cameras(stage)) == 1
    assert "the camera frames the whole room" in context.notes[0]


def test_walls_and_ceilings_are_bare_and_furniture_is_what_is_photographed() -> None:
    stage = room_stage()
    for path, category in ((f"{names.WALLS}/wall_0", "wall"), (names.CEILING, "ceiling")):
        label(stage.GetPrimAtPath(path), category)
    found = ViewCandidates.of(stage)
    heights = found.points[found.subjects.of_triangle == BARE][..., 2]
    assert heights.min() == 0.0
    assert heights.max() == pytest.approx(2.6)
    assert (found.subjects.of_triangle == BARE).sum() == 4
    assert len(found.subjects.weights) == 2


@pytest.mark.slow
def test_many_triangles_are_chosen_by_their_boxes(monkeypatch: pytest.MonkeyPatch) -> None:
    stage = room_stage()
    exact = author(stage, {"from": "select", "count": 3, "prefer": "paper"})
    assert exact.notes == []
    expected = [read_camera(prim, 4, 3).world_from_camera for prim in list_cameras(stage)]
    monkeypatch.setattr(stage_module, "MANY_TRIANGLES", 10)
    boxed = room_stage()
    author(boxed, {"from": "select", "count": 3, "prefer": "paper"})
    # The furniture here is boxes already: nothing may change.
    found = [read_camera(prim, 4, 3).world_from_camera for prim in list_cameras(boxed)]
    np.testing.assert_allclose(found, expected)


def test_every_prim_is_owned_and_written_once() -> None:
    stage = room_stage()
    author(stage, {"from": "select", "count": 1})
    layer = stage.GetEditTarget().GetLayer()
    assert [spec.name for spec in layer.GetPrimAtPath("/World").nameChildren] == ["Cameras"]
    assert layer.GetPrimAtPath("/World").specifier == Sdf.SpecifierOver
    assert layer.GetPrimAtPath(names.CAMERAS).typeName == "Scope"
    assert layer.GetPrimAtPath(names.RENDER).typeName == "Scope"


def test_a_lens_is_focused_on_its_target_or_as_described() -> None:
    stage = room_stage()
    eye, target = [0.5, 0.5, 1.5], [2.5, 2.0, 1.0]
    looks = {"eye": eye, "target": target, "f_stop": 2.8}
    author(
        stage,
        {"name": "aimed", **looks},
        {"name": "near", "focus": 0.9, **looks},
        {"name": "sharp", "eye": eye, "target": target},
    )
    aimed, near, sharp = (
        read_camera(stage.GetPrimAtPath(f"{names.CAMERAS}/{name}"), 640, 480)
        for name in ("aimed", "near", "sharp")
    )
    assert aimed.focus_distance == pytest.approx(np.linalg.norm(np.subtract(target, eye)))
    assert near.focus_distance == pytest.approx(0.9) and sharp.lens_radius == 0.0
    # Film 36 mm wide, 60 degrees: a focal length of 31.2 mm.
    assert aimed.lens_radius == pytest.approx(0.018 / np.tan(np.radians(30)) / 2.8 / 2, rel=1e-5)


def test_a_lens_without_a_target_is_focused_on_the_subject_of_the_picture() -> None:
    stage = room_stage()
    # Level, before the shelf's front at x = 0.5; and before nothing but the wall at x = 5.
    shelf = [[0, 0, -1, 3.0], [1, 0, 0, 1.5], [0, -1, 0, 1.2]]
    wall = [[0, 0, 1, 3.5], [-1, 0, 0, 3.4], [0, -1, 0, 1.2]]
    author(
        stage,
        {"name": "shelf", "world_from_camera": shelf, "f_stop": 2.8},
        {"name": "wall", "world_from_camera": wall, "f_stop": 2.8, "focus": "subject", "fov": 30},
        {"from": "select", "count": 1, "f_stop": 2.8},
    )
    found = [
        read_camera(stage.GetPrimAtPath(f"{names.CAMERAS}/{name}"), 64, 48).focus_distance
        for name in ("shelf", "wall", "view_0")
    ]
    assert found[:2] == pytest.approx([2.5, 1.5], abs=0.01)
    assert found[2] > 0.3
    for wrong in ("object", -2.0):
        with pytest.raises(ValueError, match="focus"):
            Cameras.model_validate({"views": [{"from": "select", "focus": wrong}]})
