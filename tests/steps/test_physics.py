"""The physics step: what is authored is what USD's own parser reads, and what the meshes say."""

from collections.abc import Iterator
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from openrooms_usd import names
from openrooms_usd.description.room import Room
from openrooms_usd.library.construction import mass_of_part
from openrooms_usd.library.friction import friction_of
from openrooms_usd.physics.mass import combined
from openrooms_usd.steps import runner
from openrooms_usd.steps.alignment.step import AlignmentStep
from openrooms_usd.steps.draft import drafting
from openrooms_usd.steps.layout.step import LayoutStep
from openrooms_usd.steps.materials.step import MaterialsStep
from openrooms_usd.steps.physics.step import PhysicsStep
from openrooms_usd.usd.rigid.reading import read_world
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading import physics
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.materials import bound_material
from openrooms_usd.usd.shading.textures import read_texture
from openrooms_usd.usd.shapes.meshes import PlacedMesh, read_meshes

Kind = UsdPhysics.ObjectType
ROOM = {
    "room": "living_room",
    "seed": 4,
    "layout": {
        "openings": [
            {"kind": "door", "name": "door", "wall": 0, "open": 30, "at": 1.0},
            {"kind": "window", "name": "window", "wall": 1},
        ]
    },
    "furniture": {
        "objects": [
            {"name": "board", "category": "cabinet", "at": [2, 3.5], "style": "sideboard"},
            {"name": "picture", "category": "picture", "at": [4.9, 2]},
            {"name": "chair_a", "category": "chair", "at": [1, 1], "style": "slat"},
            {"name": "chair_b", "category": "chair", "at": [2, 1], "style": "slat", "yaw": 30},
            {"name": "chair_c", "category": "chair", "at": [3, 1], "style": "slat"},
        ]
    },
    "materials": {"resolution": 16},
    "physics": {"shapes": "hull"},
}


def compose(folder: Path, workers: int = 1, **sections: object) -> tuple[Usd.Stage, list[str]]:
    room = Room.model_validate(ROOM | sections)
    with drafting(folder) as draft:
        runner.create_edits(draft)
        for step in (LayoutStep(), AlignmentStep(), MaterialsStep(), PhysicsStep()):
            notes = runner.run(step, room, folder, draft, "fingerprint", workers)
        runner.write_scene(draft)
    stage = Usd.Stage.Open(str(folder / names.SCENE))
    stage.Reload()
    return stage, list(notes)


@pytest.fixture(scope="module")
def stage(tmp_path_factory: pytest.TempPathFactory) -> Usd.Stage:
    return compose(tmp_path_factory.mktemp("room"))[0]


def parsed(stage: Usd.Stage, kind: Kind) -> Iterator[tuple[Sdf.Path, object]]:
    found = UsdPhysics.UsdPhysicsLoadStageFromPrimRange(stage, ["/"])
    yield from zip(*found[kind], strict=True)


def meshes_below(stage: Usd.Stage, path: str) -> list[PlacedMesh]:
    return [mesh for mesh in read_meshes(stage) if mesh.path.startswith(f"{path}/")]


def test_what_moves_and_what_stays(stage: Usd.Stage) -> None:
    moving = {str(path) for path, _ in parsed(stage, Kind.RigidBody)}
    chairs = {f"{names.FURNITURE}/chair_{x}" for x in "abc"}
    assert chairs < moving
    assert f"{names.FURNITURE}/board/Geometry/Body" in moving
    assert f"{names.OPENINGS}/door/Leaf" in moving
    assert not any("picture" in path or path.endswith("/board") for path in moving)
    owners = {str(path): desc.rigidBody for path, desc in parsed(stage, Kind.MeshShape)}
    for part in ("Room/Physics", "Furniture/picture", "Openings/door/Physics"):
        found = [body for path, body in owners.items() if f"/{part}/" in path]
        assert found and all(body.isEmpty for body in found), part
    (scene,) = parsed(stage, Kind.Scene)
    assert scene[1].gravityMagnitude == pytest.approx(9.81)


def test_what_moves_with_joints_is_an_articulation_of_its_base(stage: Usd.Stage) -> None:
    """And what hangs on something that stays, a door on its frame, is none: that is no body."""
    found = {str(path): desc for path, desc in parsed(stage, Kind.Articulation)}
    board = f"{names.FURNITURE}/board/Geometry"
    assert list(found) == [f"{board}/Body"]
    assert list(found[f"{board}/Body"].rootPrims) == [f"{board}/Body"]
    joints = {
        str(path)
        for kind in (Kind.RevoluteJoint, Kind.PrismaticJoint)
        for path, _ in parsed(stage, kind)
    }
    members = {str(path) for path in found[f"{board}/Body"].articulatedJoints}
    assert members == {path for path in joints if "/board/" in path} < joints
    apart = {str(path) for path in found[f"{board}/Body"].articulatedBodies}
    assert apart == {str(p) for p, _ in parsed(stage, Kind.RigidBody) if "/board/" in str(p)}


def test_a_fixed_cabinet_has_joints_and_no_articulation(tmp_path: Path) -> None:
    physics = {"shapes": "hull", "objects": {"board": {"body": "fixed"}}}
    stage, _ = compose(tmp_path, physics=physics)
    assert any("/board/" in str(path) for path, _ in parsed(stage, Kind.PrismaticJoint))
    assert Kind.Articulation not in UsdPhysics.UsdPhysicsLoadStageFromPrimRange(stage, ["/"])


def test_nothing_of_it_is_drawn(stage: Usd.Stage) -> None:
    shapes = [path for path, _ in parsed(stage, Kind.MeshShape)]
    assert len(shapes) > 30
    drawn = {mesh.path for mesh in read_meshes(stage)}
    assert not drawn & {str(path) for path in shapes}
    usual = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default", "render"])
    for path in shapes:
        prim = stage.GetPrimAtPath(path)
        assert UsdGeom.Imageable(prim).ComputePurpose() == UsdGeom.Tokens.guide
        assert usual.ComputeWorldBound(prim).GetRange().IsEmpty()


def test_masses_are_those_of_the_composed_meshes(stage: Usd.Stage) -> None:
    world = {body.name: body for body in read_world(stage).bodies}
    for name in ("chair_a", "chair_b"):
        path = f"{names.FURNITURE}/{name}"
        parts = []
        for mesh in meshes_below(stage, path):
            material = bound_material(mesh.prim)
            assert material is not None
            substance = physics.read_category(material.GetPrim())
            part = read_label(mesh.prim, names.PART) or mesh.prim.GetName()
            points, rows = mesh.world_points(), mesh.mesh.triangles
            parts.append(mass_of_part("chair", part, substance, points, rows))
        expected = combined(parts)
        found = world[name].links[0].mass
        assert found is not None
        moved = found.transformed(world[name].world_from_body)
        assert moved.mass == pytest.approx(expected.mass, rel=1e-6)
        np.testing.assert_allclose(moved.centre, expected.centre, atol=1e-6)
        np.testing.assert_allclose(moved.inertia, expected.inertia, atol=1e-6)


def test_repeats_share_a_prototype_and_jointed_things_are_none(stage: Usd.Stage) -> None:
    chairs = [stage.GetPrimAtPath(f"{names.FURNITURE}/chair_{x}") for x in "abc"]
    assert len({chair.GetPrototype().GetPath() for chair in chairs}) == 1
    assert not stage.GetPrimAtPath(f"{names.FURNITURE}/board").IsInstance()


def test_shapes_are_of_their_parts_materials(stage: Usd.Stage) -> None:
    for path, desc in parsed(stage, Kind.MeshShape):
        if path.name.startswith("Floor"):
            continue
        (material,) = desc.materials
        known = physics.read(stage.GetPrimAtPath(material))
        assert known is not None and known.static_friction > 0.0, path
    seat = next(p for p, _ in parsed(stage, Kind.MeshShape) if "chair_a" in str(p))
    bound, _ = UsdShade.MaterialBindingAPI(stage.GetPrimAtPath(seat)).ComputeBoundMaterial(
        "physics"
    )
    assert str(bound.GetPath()).startswith(f"{names.FURNITURE}/chair_a/Materials/")


def test_the_floor_has_the_mean_of_its_friction_map(stage: Usd.Stage) -> None:
    floor = bound_material(stage.GetPrimAtPath(names.FLOOR))
    assert floor is not None
    surface, _ = read_preview_surface(floor)
    albedo = read_texture(surface.base_color.file)[..., :3]
    linear = np.where(albedo <= 0.04045, albedo / 12.92, ((albedo + 0.055) / 1.055) ** 2.4)
    rough = read_texture(surface.roughness.file)[..., 0]
    category = physics.read_category(floor.GetPrim())
    expected = friction_of(category, linear, rough).static.mean()
    shape = next(d for p, d in parsed(stage, Kind.MeshShape) if p.name.startswith("Floor"))
    found = physics.read(stage.GetPrimAtPath(shape.materials[0]))
    assert found is not None
    assert found.static_friction == pytest.approx(expected, abs=6e-4)


def test_doors_swing_and_drawers_slide_as_their_parts_say(stage: Usd.Stage) -> None:
    world = {body.name: body for body in read_world(stage).bodies}
    board = world["board"]
    assert board.links[0].path.endswith("/Geometry/Body")
    for joint in board.joints:
        prim = stage.GetPrimAtPath(f"{names.FURNITURE}/board/Geometry/{joint.child}")
        assert joint.kind == prim.GetAttribute(names.JOINT_TYPE).Get()
        axis = np.array(prim.GetAttribute(names.JOINT_AXIS).Get())
        np.testing.assert_allclose(joint.axis, axis / np.linalg.norm(axis), atol=1e-6)
        unit = np.pi / 180.0 if joint.kind == "hinge" else 1.0
        upper = prim.GetAttribute(names.JOINT_UPPER).Get() * unit
        np.testing.assert_allclose(joint.limits, [0.0, upper], atol=1e-5)
        assert joint.damping > 0.0
    assert {joint.kind for joint in board.joints} == {"hinge", "rail"}
    (leaf,) = world["door"].joints
    # It stands 30 degrees open.
    assert np.degrees(leaf.limits[0]) == pytest.approx(-30.0, abs=1e-3)


def filtered(prim: Usd.Prim) -> set[str]:
    relation = UsdPhysics.FilteredPairsAPI(prim).GetFilteredPairsRel()
    return {str(path) for path in relation.GetTargets()} if relation else set()


def test_what_moves_in_one_thing_passes_the_rest_of_it(stage: Usd.Stage) -> None:
    board = stage.GetPrimAtPath(f"{names.FURNITURE}/board")
    bodies = [p for p in Usd.PrimRange(board) if p.HasAPI(UsdPhysics.RigidBodyAPI)]
    movers = [p for p in bodies if p.HasAttribute(names.JOINT_TYPE)]
    assert len(movers) > 1
    for one, other in combinations(movers, 2):
        assert str(one.GetPath()) in filtered(other) or str(other.GetPath()) in filtered(one)
    # A frame is no body: its colliders are told one by one.
    door = stage.GetPrimAtPath(f"{names.OPENINGS}/door")
    (leaf,) = [p for p in Usd.PrimRange(door) if p.HasAPI(UsdPhysics.RigidBodyAPI)]
    colliders = {p for p in Usd.PrimRange(door) if p.HasAPI(UsdPhysics.CollisionAPI)}
    own = {p for p in Usd.PrimRange(leaf) if p.HasAPI(UsdPhysics.CollisionAPI)}
    assert colliders - own
    assert filtered(leaf) == {str(p.GetPath()) for p in colliders - own}


@pytest.mark.slow
def test_an_opened_drawer_counts_from_where_it_is(tmp_path: Path) -> None:
    stage, _ = compose(tmp_path)
    board = next(b for b in read_world(stage).bodies if b.name == "board")
    rail = next(joint for joint in board.joints if joint.kind == "rail")
    layer = Sdf.Layer.FindOrOpen(str(tmp_path / "layers" / "edits.usda"))
    stage.SetEditTarget(layer)
    prim = stage.GetPrimAtPath(f"{names.FURNITURE}/board/Geometry/{rail.child}")
    moved = prim.GetAttribute("xformOp:translate")
    moved.Set(moved.Get() + Gf.Vec3d(*(0.1 * rail.axis)))
    layer.Save()
    again, _ = compose(tmp_path)
    board = next(b for b in read_world(again).bodies if b.name == "board")
    after = next(joint for joint in board.joints if joint.name == rail.name)
    np.testing.assert_allclose(after.limits, np.array(rail.limits) - 0.1, atol=1e-6)


def test_the_room_has_a_floor_and_walls_that_are_open_where_they_are(stage: Usd.Stage) -> None:
    shell = next(b for b in read_world(stage).bodies if b.name == "Room")
    assert shell.fixed and len(shell.links) == 1
    floor = [s for s in shell.links[0].shapes if s.name.startswith("Floor")]
    assert len(floor) == 1
    assert floor[0].mesh.points[:, 2].max() == pytest.approx(0.0, abs=1e-7)
    walls = [s for s in shell.links[0].shapes if s.name.startswith("wall")]
    # Three around the door: left, right, above; four around the window.
    assert len(walls) == 3 + 4 + 2
