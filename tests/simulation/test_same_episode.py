"""Another look or another light is the same episode in another picture; friction is another one."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Sdf, Usd, UsdLux, UsdShade

from openrooms_usd import adapters
from openrooms_usd.engines import Pose, Simulation
from openrooms_usd.geometry.pinhole import look_at
from openrooms_usd.physics.world import World
from openrooms_usd.rendering.contract import View
from openrooms_usd.simulation.driving import Action, act
from openrooms_usd.simulation.floors import with_friction
from openrooms_usd.simulation.robot_cameras import RGB, RobotCameras
from openrooms_usd.simulation.robots import rover
from openrooms_usd.usd.files import layers
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world
from openrooms_usd.usd.shading.materials import PreviewSurface, define_preview_surface
from tests.engines import ENGINES


def episode(world: World) -> tuple[Mapping[str, Pose], object]:
    """Everything that stands on the floor gets a shove."""
    simulation = adapters.load(adapters.ENGINES, "mujoco").open(world)
    for body in world.bodies:
        if not body.fixed and not body.joints:
            simulation.set_velocity(body.name, np.array([0.8, 0.0, 0.0]), np.zeros(3))
    simulation.step(0.3)
    return simulation.poses(), simulation


ACTIONS = (Action(forward=0.4), Action(left=0.6, forward=0.3), Action(right=0.4, backward=0.2))


def replayed(world: World, engine: str) -> tuple[list[Mapping[str, Pose]], Simulation]:
    """What a rover that carries out the recorded actions leaves behind, after each of them."""
    robots = replace(world, bodies=(*world.bodies, rover((0.6, 2.2))))
    simulation = adapters.load(adapters.ENGINES, engine).open(robots)
    poses = []
    for action in ACTIONS:
        act(simulation, "rover", action)
        poses.append(simulation.poses())
    return poses, simulation


def painted(scene: Path, folder: Path) -> Path:
    """The same scene, whose furniture has one more look: all of it is red."""
    out = folder / "painted.usda"
    stage = Usd.Stage.CreateNew(str(out))
    layers.apply_metadata(stage.GetRootLayer())
    stage.GetRootLayer().subLayerPaths = [str(scene)]
    red = define_preview_surface(
        stage, "/World/Materials/red", PreviewSurface(base_color=(0.8, 0.02, 0.02), roughness=0.5)
    )
    for prim in stage.GetPrimAtPath("/World/Furniture").GetChildren():
        looks = prim.GetVariantSets().AddVariantSet("look")
        chosen = looks.GetVariantSelection()
        looks.AddVariant("red")
        looks.SetVariantSelection("red")
        with looks.GetVariantEditContext():
            binding = UsdShade.MaterialBindingAPI.Apply(prim)
            binding.Bind(red, UsdShade.Tokens.strongerThanDescendants)
        looks.SetVariantSelection(chosen) if chosen else looks.ClearVariantSelection()
    stage.Save()
    return out


def difference(one: Mapping[str, Pose], other: Mapping[str, Pose]) -> float:
    return max(
        float(np.abs(pose.world_from_body - other[name].world_from_body).max())
        for name, pose in one.items()
    )


def darker(scene: Path, folder: Path) -> Path:
    """The same scene under a tenth of its light."""
    out = folder / "darker.usda"
    layer = Sdf.Layer.CreateNew(str(out))
    layers.apply_metadata(layer)
    layer.subLayerPaths = [str(scene)]
    stage = open_stage(scene)
    for prim in stage.Traverse():
        if prim.HasAPI(UsdLux.LightAPI):
            own = UsdLux.LightAPI(prim).GetIntensityAttr().Get()
            over = Sdf.CreatePrimInLayer(layer, prim.GetPath())
            value = Sdf.AttributeSpec(over, "inputs:intensity", Sdf.ValueTypeNames.Float)
            value.default = 0.1 * own
    layer.Save()
    return out


@pytest.fixture(scope="module")
def world(composed_bodies: Path) -> World:
    return read_world(open_stage(composed_bodies))


def seen(path: Path, world: World, simulation: object, look: str | None = None) -> View:
    cameras = RobotCameras(path, world, resolution=(48, 36), samples=4, look=look)
    camera = {"onlooker": look_at((0.5, 0.5, 1.5), (2.0, 2.0, 0.3))}
    return cameras.see(simulation, camera, (RGB, "depth"))["onlooker"]  # type: ignore[arg-type]


@pytest.mark.slow
def test_another_light_shows_the_same_episode(
    composed_bodies: Path, world: World, tmp_path: Path
) -> None:
    """A tenth of the light is a tenth of the radiance, and every surface is where it was."""
    dim = darker(composed_bodies, tmp_path)
    first, simulation = episode(world)
    second, other = episode(read_world(open_stage(dim)))
    assert difference(first, second) == 0.0
    bright = seen(composed_bodies, world, simulation)
    dark = seen(dim, world, other)
    means = [view.images[RGB].pixels.mean(dtype=np.float64) for view in (bright, dark)]
    assert means[0] > 0.0 and means[1] == pytest.approx(0.1 * means[0], rel=0.05)
    a, b = (view.images["depth"].pixels for view in (bright, dark))
    np.testing.assert_allclose(b, a, rtol=1e-5)


@pytest.mark.slow
def test_a_recorded_episode_in_another_look(
    composed_bodies: Path, world: World, tmp_path: Path
) -> None:
    """The same actions give the same poses, bit for bit; red furniture where it was another."""
    scene = painted(composed_bodies, tmp_path)
    recorded, simulation = replayed(world, "mujoco")
    again, other = replayed(read_world(open_stage(scene)), "mujoco")
    for one, two in zip(recorded, again, strict=True):
        assert difference(one, two) == 0.0
    own, red = seen(composed_bodies, world, simulation), seen(scene, world, other, look="red")
    np.testing.assert_array_equal(own.images["depth"].pixels, red.images["depth"].pixels)
    rows = [view.images[RGB].pixels.mean(axis=(0, 1), dtype=np.float64) for view in (own, red)]
    ratios = [row[0] / row[1] for row in rows]
    assert ratios[1] > 1.05 * ratios[0]


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_a_recorded_episode_on_another_floor(world: World, engine: str) -> None:
    """The same actions: equal bits on the same floor; wheels that slip on ice get less far."""
    recorded, first = replayed(world, engine)
    again, second = replayed(world, engine)
    icy, third = replayed(with_friction(world, "floor", 1e-4), engine)
    for simulation in (first, second, third):
        simulation.close()
    assert [difference(a, b) for a, b in zip(recorded, again, strict=True)] == [0.0] * len(ACTIONS)
    start = np.array([0.6, 2.2])
    ways = [np.linalg.norm(p[0]["rover"].world_from_body[:2, 3] - start) for p in (recorded, icy)]
    assert ways[0] == pytest.approx(ACTIONS[0].forward, abs=0.02)
    assert ways[1] < 0.7 * ways[0]


@pytest.mark.slow
def test_another_friction_is_another_episode_and_the_same_one_is_the_same(world: World) -> None:
    first, _ = episode(world)
    again, _ = episode(world)
    waxed, _ = episode(with_friction(world, "floor", 0.05))
    assert difference(first, again) == 0.0
    moving = [body.name for body in world.bodies if not body.fixed and not body.joints]
    begun = {body.name: body.world_from_body for body in world.bodies}
    ways = [
        [np.linalg.norm((p[name].world_from_body - begun[name])[:2, 3]) for name in moving]
        for p in (first, waxed)
    ]
    assert max(np.subtract(ways[1], ways[0])) > 0.03
