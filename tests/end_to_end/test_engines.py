"""Rooms in engines that read USD themselves: Newton, and PhysX, which is that of Isaac Sim.

Bodies, masses, inertias, friction and limits are ours by number, and rooms stay as they stand.
Runs where `.ci/install-newton` and `.ci/install-physx` have been, or where ORUSD_NEWTON_PYTHON and
ORUSD_PHYSX_PYTHON name Pythons that have them: both are large and bring their own USD.
"""

import json
import os
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdShade

from openrooms_usd.physics.world import Link, World
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world
from orusd_urdf import UsdPhysicsExporter

ROOT = Path(__file__).parents[2]
SECONDS = 2.0
# Between the two anchors of a joint, across its axis; seen: 5 micrometres.
APART_M = 1e-4
# Of the slope down which a box slides.
LEAN_DEG = 35.0
FRICTION = (("staticFriction", "static_friction"), ("dynamicFriction", "dynamic_friction"))


@dataclass(frozen=True)
class Engine:
    """An engine in an environment of its own.

    Attributes:
        name: As its environment is named.
        moved: Metres that nothing in a room may move in `SECONDS`.
        turned: Degrees that nothing may turn.
        ajar: Degrees that what hangs on a joint may.
        copies: Whether it takes the copy that is made for it; else the room as it was composed.
    """

    name: str
    moved: float
    turned: float
    ajar: float
    copies: bool = False

    @property
    def python(self) -> str:
        own = str(ROOT / f".venv-{self.name}/bin/python")
        return os.environ.get(f"ORUSD_{self.name.upper()}_PYTHON", own)

    def play(self, scene: Path) -> dict[str, Any]:
        if not Path(self.python).exists():
            reason = f".ci/install-{self.name}, ORUSD_{self.name.upper()}_PYTHON"
            pytest.skip(f"{self.name} is missing ({reason})")
        script = Path(__file__).with_name(f"{self.name}_episode.py")
        words = [self.python, str(script), str(scene), str(SECONDS)]
        done = subprocess.run(words, capture_output=True, text=True, timeout=900)
        assert done.returncode == 0, done.stderr[-3000:]
        # Engines say things of their own, before it, and when they close even in its line.
        said = [line for line in done.stdout.splitlines() if line.startswith('{"bodies"')]
        assert said, done.stdout[-3000:]
        return dict(json.JSONDecoder().raw_decode(said[-1])[0])


ENGINES = (
    # Seen, by its solver of positions with 16 rounds: 2.7 mm in the example, 4.8 (a towel on one)
    # in the bedroom; jars turn by 2.8 degrees about their own axes. It knows no friction in joints:
    # a wardrobe's doors of 13 and 29 kg swing by 0.6 degrees a second.
    Engine("newton", 8e-3, 5.0, 2.0),
    # Seen: 3.1 mm; a pen rolls by 13 degrees.
    Engine("physx", 6e-3, 20.0, 0.5, copies=True),
)
# And what each has of doors and drawers.
ROOMS = {
    "demo": ("sideboard/Physics/Joints/drawer_2_rail", "door/Physics"),
    "bedroom-12": ("night_stand/Physics/Joints/drawer_0_rail", "door_0/Physics"),
    "kitchen-1": ("refrigerator/Physics/Joints/door_0_hinge", "door_0/Physics"),
}

pytestmark = pytest.mark.slow


def marked(name: str) -> Any:
    """A room with its worker; of those that are generated an episode takes a minute."""
    long = [] if name == "demo" else [pytest.mark.long]
    return pytest.param(name, marks=[pytest.mark.xdist_group(name), *long])


@pytest.fixture(params=map(marked, ROOMS))
def room(request: pytest.FixtureRequest, with_physics: Callable[[str], Path]) -> tuple[str, Path]:
    return request.param, with_physics(request.param)


@pytest.mark.parametrize(
    "engine",
    # Newton compiles for a minute on a machine that has not run it before.
    [pytest.param(engine, marks=[] if engine.copies else pytest.mark.long) for engine in ENGINES],
    ids=lambda engine: engine.name,
)
def test_a_room_rests_and_its_numbers_are_ours(
    engine: Engine, room: tuple[str, Path], tmp_path: Path
) -> None:
    name, scene = room
    if engine.copies:
        UsdPhysicsExporter().convert(open_stage(scene), tmp_path, {})
        scene = tmp_path / "scene.usdc"
    stage = open_stage(scene)
    found, world = engine.play(scene), read_world(stage)
    check_bodies(found["bodies"], world)
    check_joints(found["joints"], stage)
    for joint in ROOMS[name]:
        assert any(joint in path for path in found["joints"]), joint
    check_rest(engine, found, world)


def slope(path: Path, below: float, above: float) -> None:
    """A floor and a box on it, of two frictions; gravity leans by `LEAN_DEG` towards +x."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    gravity = UsdPhysics.Scene.Define(stage, "/World/Scene")
    lean = np.radians(LEAN_DEG)
    gravity.CreateGravityDirectionAttr(Gf.Vec3f(float(np.sin(lean)), 0.0, float(-np.cos(lean))))
    gravity.CreateGravityMagnitudeAttr(9.81)
    for name, friction, size, height in (
        ("floor", below, (10.0, 10.0, 1.0), -0.5),
        ("box", above, (0.4, 0.4, 0.2), 0.1),
    ):
        cube = UsdGeom.Cube.Define(stage, f"/World/{name}")
        cube.CreateSizeAttr(1.0)
        cube.AddTranslateOp().Set((0.0, 0.0, height))
        cube.AddScaleOp().Set(size)
        UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
        material = UsdShade.Material.Define(stage, f"/World/{name}_material")
        api = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
        api.CreateStaticFrictionAttr(friction)
        api.CreateDynamicFrictionAttr(friction)
        UsdShade.MaterialBindingAPI.Apply(cube.GetPrim()).Bind(
            material, UsdShade.Tokens.weakerThanDescendants, "physics"
        )
    box = stage.GetPrimAtPath("/World/box")
    UsdPhysics.RigidBodyAPI.Apply(box)
    UsdPhysics.MassAPI.Apply(box).CreateMassAttr(5.0)
    stage.GetRootLayer().Save()


@pytest.mark.parametrize(("below", "above"), [(0.2, 0.8), (0.8, 0.2), (0.4, 0.4)])
def test_a_pair_rubs_in_physx_by_its_geometric_mean(
    below: float, above: float, tmp_path: Path
) -> None:
    """A box slides down by Coulomb's law; the arithmetic mean would be 0.5."""
    slope(tmp_path / "slope.usda", below, above)
    UsdPhysicsExporter().convert(open_stage(tmp_path / "slope.usda"), tmp_path / "copy", {})
    found = ENGINES[1].play(tmp_path / "copy/scene.usdc")["bodies"]["/World/box"]
    lean = np.radians(LEAN_DEG)
    way = 0.5 * 9.81 * (np.sin(lean) - 0.4 * np.cos(lean)) * SECONDS**2
    assert found["moved"] == pytest.approx(way, rel=0.02)


def moving(world: World) -> dict[str, Link]:
    links = (link for body in world.bodies for link in body.links)
    return {link.path: link for link in links if link.mass is not None}


def check_bodies(found: dict[str, Any], world: World) -> None:
    ours = moving(world)
    assert set(found) == set(ours)
    for path, link in ours.items():
        row = found[path]
        assert row["mass"] == pytest.approx(link.mass.mass, rel=1e-5), path
        np.testing.assert_allclose(row["centre"], link.mass.centre, atol=1e-5, err_msg=path)
        near = 1e-4 * np.trace(link.mass.inertia)
        np.testing.assert_allclose(row["inertia"], link.mass.inertia, atol=near, err_msg=path)
        for key, of in FRICTION:
            if key in row:
                expected = sorted(getattr(shape.contact, of) for shape in link.shapes)
                np.testing.assert_allclose(sorted(row[key]), expected, atol=1e-6, err_msg=path)


def check_joints(found: dict[str, Any], stage: Usd.Stage) -> None:
    """Those of the stage, and their limits, degrees or metres, where an engine says them."""
    ours = {str(prim.GetPath()): prim for prim in stage.Traverse() if prim.IsA(UsdPhysics.Joint)}
    assert set(found) == set(ours)
    for path, row in found.items():
        limits = [
            ours[path].GetAttribute(f"physics:{end}Limit").Get() for end in ("lower", "upper")
        ]
        np.testing.assert_allclose(row.get("limits", limits), limits, atol=1e-3, err_msg=path)


def check_rest(engine: Engine, found: dict[str, Any], world: World) -> None:
    hung = {link.path for body in world.bodies if body.joints for link in body.links if link.mass}
    for path, row in found["bodies"].items():
        # So written that what is no number fails.
        assert row["moved"] < engine.moved, (path, row["moved"])
        most = engine.ajar if path in hung else engine.turned
        assert row["turned"] < most, (path, row["turned"])
    for path, row in found["joints"].items():
        assert row.get("apart", 0.0) < APART_M, (path, row["apart"])
