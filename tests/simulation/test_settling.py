"""A composed room settles in both engines, and its layer says where everything is."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd import adapters
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.geometry.quaternions import pose_of
from openrooms_usd.physics.world import World
from openrooms_usd.simulation.settling import run, settle
from openrooms_usd.usd.files import layers
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.places.frames import TIME, local_to_world, world_from_stage
from openrooms_usd.usd.places.settled import Motion, author_motions
from openrooms_usd.usd.rigid.reading import read_world
from tests.engines import ENGINES, needs_pybullet

from .conftest import at, brick, floor


@pytest.fixture(scope="module")
def room(composed_bodies: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy, because simulating adds a layer to it."""
    folder = tmp_path_factory.mktemp("settling") / "room"
    return Path(shutil.copytree(composed_bodies.parent, folder)) / composed_bodies.name


@pytest.mark.one_in(4)
@pytest.mark.parametrize("engine", ENGINES)
def test_nothing_placed_moves_more_than_5_mm(room: Path, engine: str, tmp_path: Path) -> None:
    settled = settle(room, engine=engine, out=tmp_path / "settled.usda")
    assert len(settled.moved) >= 4
    assert {row.body: row.millimetres for row in settled.moved if row.millimetres > 5.0} == {}
    assert max(row.speed for row in settled.moved) < 0.01
    assert not settled.held


@needs_pybullet
@pytest.mark.slow
def test_engines_agree_where_things_rest(room: Path, tmp_path: Path) -> None:
    """Within 2 mm, through the URDF files of one and the MJCF file of the other."""
    world = read_world(open_stage(room))
    found = []
    for engine in ("pybullet", "mujoco"):
        simulation = adapters.load(adapters.ENGINES, engine).open(world)
        simulation.step(1.0)
        found.append(simulation.poses())
        simulation.close()
    for body in world.bodies:
        a, b = (poses[body.name].world_from_body for poses in found)
        assert np.linalg.norm(a[:3, 3] - b[:3, 3]) < 2e-3


@pytest.mark.slow
def test_the_layer_lies_in_the_room_and_a_second_run_writes_the_same(room: Path) -> None:
    layer = room.parent / "layers" / "settled.usda"
    first = settle(room, engine="mujoco", seconds=0.2)
    assert first.out == layer
    text = layer.read_bytes()
    assert b"settled.usda" in room.read_bytes()
    assert settle(room, engine="mujoco", seconds=0.2).as_dict() == first.as_dict()
    assert layer.read_bytes() == text


@pytest.mark.slow
def test_edits_stay_above_and_are_what_is_simulated(room: Path, tmp_path: Path) -> None:
    """A lamp that a person has lifted falls; the layer brings it down from there."""
    edits = tmp_path / "lifted.usda"
    stage = open_stage(room)
    lamp = next(body for body in read_world(stage).bodies if body.category == "table_lamp")
    height = lamp.world_from_body[2, 3]
    edited = Usd.Stage.CreateNew(str(edits))
    layers.apply_metadata(edited.GetRootLayer())
    edited.GetRootLayer().subLayerPaths = [str(room)]
    prim = edited.OverridePrim(lamp.path)
    own = list(UsdGeom.Xformable(prim).GetXformOpOrderAttr().Get())
    lift = prim.CreateAttribute("xformOp:translate:lifted", Sdf.ValueTypeNames.Double3)
    lift.Set(Gf.Vec3d(0.0, 0.0, 0.05))
    UsdGeom.Xformable(prim).CreateXformOpOrderAttr(["xformOp:translate:lifted", *own])
    edited.Save()
    out = tmp_path / "settled.usda"
    settled = settle(edits, engine="mujoco", seconds=1.0, out=out)
    fallen = next(row for row in settled.moved if row.path == lamp.path)
    assert fallen.millimetres == pytest.approx(50.0, abs=3.0)
    both = tmp_path / "both.usda"
    joined = Sdf.Layer.CreateNew(str(both))
    layers.apply_metadata(joined)
    joined.subLayerPaths = [str(out), str(edits)]
    joined.Save()
    shown = open_stage(both)
    pose = local_to_world(shown.GetPrimAtPath(lamp.path), UsdGeom.XformCache(TIME))
    assert pose[2, 3] == pytest.approx(height, abs=6e-3)


@pytest.mark.parametrize("engine", ENGINES)
def test_what_falls_out_of_the_world_is_named(engine: str) -> None:
    world = World((floor(size=(1.0, 1.0, 0.2)), brick("lost", (0.1,) * 3, 1.0, at(2.0, 0.0, 0.5))))
    simulation = adapters.load(adapters.ENGINES, engine).open(world)
    with pytest.raises(StageError, match=r"'lost'.*left the world") as caught:
        run(world, simulation, 5.0)
    assert caught.value.place == "/lost"
    simulation.close()


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"seconds": 0.0}, "seconds"),
        ({"timestep": 1.0}, "time step"),
        ({"engine": "bullet"}, "pybullet"),
        ({"look": "nothing_has_this"}, "look"),
        ({"out": Path("poses.txt")}, "poses"),
    ],
)
def test_mistakes_are_said(room: Path, how: dict[str, object], message: str) -> None:
    with pytest.raises(InputError) as caught:
        settle(room, **how)  # type: ignore[arg-type]
    assert message in str(caught.value)


def test_a_stage_without_physics_is_refused(tmp_path: Path) -> None:
    bare = tmp_path / "bare.usda"
    bare.write_text('#usda 1.0\ndef Cube "Cube" {}\n')
    with pytest.raises(StageError):
        settle(bare, out=tmp_path / "settled.usda")
    assert not (tmp_path / "settled.usda").exists()


def test_worlds_are_not_changed_by_simulating(room: Path) -> None:
    world = read_world(open_stage(room))
    copy = replace(world)
    simulation = adapters.load(adapters.ENGINES, "mujoco").open(world)
    simulation.step(0.1)
    simulation.close()
    for a, b in zip(world.bodies, copy.bodies, strict=True):
        assert (a.world_from_body == b.world_from_body).all()


MOTION = pose_of([0.1, -0.02, 0.3], [0.1, -0.2, 0.3, 0.9])
OTHER = pose_of([-0.3, 0.2, 0.05], [0.4, 0.1, -0.2, 0.8])


def stage_with(y_up: bool = False, scale: float = 1.0) -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y if y_up else UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, scale)
    world = UsdGeom.Xform.Define(stage, "/World")
    world.AddRotateZOp().Set(20.0)
    thing = UsdGeom.Xform.Define(stage, "/World/thing")
    # As aligned things are: what corrects them stands before what was measured.
    thing.AddTranslateOp(opSuffix="placed").Set(Gf.Vec3d(1, 2, 3))
    thing.AddOrientOp(opSuffix="placed").Set(Gf.Quatf(0.8, 0.6, 0, 0))
    thing.AddTranslateOp().Set(Gf.Vec3d(0.5, 0, 0))
    thing.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, 30))
    thing.AddScaleOp().Set(Gf.Vec3f(1, 2, -1))
    leaf = UsdGeom.Xform.Define(stage, "/World/thing/leaf")
    leaf.AddTranslateOp().Set(Gf.Vec3d(0.2, 0, 0))
    return stage


def poses(stage: Usd.Stage, *paths: str) -> list[np.ndarray]:
    cache = UsdGeom.XformCache(TIME)
    S = world_from_stage(stage)
    return [S @ local_to_world(stage.GetPrimAtPath(path), cache) for path in paths]


@pytest.mark.parametrize(("y_up", "scale"), [(False, 1.0), (True, 0.01)])
@pytest.mark.parametrize("side", ["before", "after"])
def test_a_thing_and_its_part_move_as_they_should(y_up: bool, scale: float, side: str) -> None:
    stage = stage_with(y_up, scale)
    paths = "/World/thing", "/World/thing/leaf"
    before = poses(stage, *paths)
    motions = [Motion(paths[1], OTHER, "after"), Motion(paths[0], MOTION, side)]  # type: ignore[arg-type]
    assert author_motions(stage, motions) == []
    after = poses(stage, *paths)
    assert after[0] == pytest.approx(MOTION @ before[0], abs=1e-6)
    assert after[1] == pytest.approx(OTHER @ before[1], abs=1e-6)


def test_a_prims_own_operations_stay() -> None:
    stage = stage_with()
    prim = stage.GetPrimAtPath("/World/thing")
    own = list(UsdGeom.Xformable(prim).GetXformOpOrderAttr().Get())
    author_motions(stage, [Motion("/World/thing", MOTION, "before")])
    order = list(UsdGeom.Xformable(prim).GetXformOpOrderAttr().Get())
    assert order == ["xformOp:translate:settled", "xformOp:orient:settled", *own]


def test_what_has_not_moved_gets_no_opinion(tmp_path: Path) -> None:
    stage = stage_with()
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage.GetSessionLayer().subLayerPaths.append(layer.identifier)
    with Usd.EditContext(stage, layer):
        author_motions(stage, [Motion("/World/thing", np.eye(4), "before")])
    assert not layer.GetPrimAtPath("/World/thing")


def test_a_stronger_order_of_operations_is_told() -> None:
    stage = stage_with()
    edits = Sdf.Layer.CreateAnonymous(".usda")
    stage.GetSessionLayer().subLayerPaths.append(edits.identifier)
    with Usd.EditContext(stage, edits):
        prim = stage.GetPrimAtPath("/World/thing")
        UsdGeom.Xformable(prim).CreateXformOpOrderAttr(["xformOp:translate"])
    assert author_motions(stage, [Motion("/World/thing", MOTION, "before")]) == ["/World/thing"]
