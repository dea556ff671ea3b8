"""A furnished room in both engines, from its exported files: it rests, is pushed, and is seen."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from openrooms_usd import adapters
from openrooms_usd.simulation.robot_cameras import RobotCameras, robot_camera
from openrooms_usd.simulation.robots import ALONG, pusher, with_robot
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world
from tests.engines import ENGINES

CHAIR = "chair_0"
# The widest that a ray and its neighbour lie apart on what the robot sees, metres.
PIXEL = 0.01


def own_box(stage: Usd.Stage, path: str) -> np.ndarray:
    """(2, 3) bounds of what is drawn of a prim, in its own frame, by USD."""
    cache = UsdGeom.BBoxCache(0.0, [UsdGeom.Tokens.default_, UsdGeom.Tokens.render])
    found = cache.ComputeUntransformedBound(stage.GetPrimAtPath(path)).ComputeAlignedRange()
    return np.array([found.GetMin(), found.GetMax()])


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_it_rests_is_pushed_and_is_seen_where_it_is(engine: str, composed_bodies: Path) -> None:
    stage = open_stage(composed_bodies)
    world = with_robot(read_world(stage), pusher((0.9, 0.6)))
    simulation = adapters.load(adapters.ENGINES, engine).open(world)
    placed = [body.name for body in world.bodies if body.path and not body.fixed]
    begun = {body.name: body.world_from_body for body in world.bodies}

    def ways() -> dict[str, float]:
        poses = simulation.poses()
        moved = {name: poses[name].world_from_body - begun[name] for name in placed}
        return {name: float(np.linalg.norm(way[:3, 3])) for name, way in moved.items()}

    simulation.step(2.0)
    assert max(ways().values()) < 0.005
    simulation.drive("pusher", ALONG, 0.5, 60.0)
    simulation.step(1.0)
    simulation.drive("pusher", ALONG, 0.0, 60.0)
    simulation.step(0.5)
    moved = ways()
    assert 0.1 < moved.pop(CHAIR) < 0.5
    assert max(moved.values()) < 0.005

    cameras = RobotCameras(composed_bodies, world, resolution=(120, 90), samples=1)
    camera = robot_camera(simulation, "pusher")
    view = cameras.see(simulation, {"robot": camera}, ("depth", "semantic"))["robot"]
    (chair,) = [number for number, name in cameras.legend.items() if name == "chair"]
    depth = view.images["depth"].pixels.reshape(90, 120)
    row, column = np.nonzero(view.images["semantic"].pixels.reshape(90, 120) == chair)
    assert len(row) > 100
    focal = 60.0 / np.tan(np.radians(35.0))
    ray = np.stack([(column + 0.5 - 60.0) / focal, (row + 0.5 - 45.0) / focal, 1.0 + 0.0 * row])
    points = camera[:3, :3] @ (ray * depth[row, column]) + camera[:3, 3:]
    # What is labelled a chair, and is not the other one, lies within the chair that was pushed.
    near = np.abs(points[1] - 0.8) < 0.4
    pose = simulation.poses()[CHAIR].world_from_body
    local = pose[:3, :3].T @ (points[:, near] - pose[:3, 3:])
    low, high = own_box(stage, f"/World/Furniture/{CHAIR}")
    assert near.sum() > 100
    assert (local > low[:, None] - PIXEL).all() and (local < high[:, None] + PIXEL).all()
    # It would not, had the picture shown it where it was.
    stale = begun[CHAIR][:3, :3].T @ (points[:, near] - begun[CHAIR][:3, 3:])
    assert ((stale < low[:, None]) | (stale > high[:, None])).any()
    simulation.close()
