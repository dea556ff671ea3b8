"""A robot's cameras translate and open a room once, and see what has moved since."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd import adapters
from openrooms_usd.geometry.pinhole import look_at
from openrooms_usd.rendering import opening
from openrooms_usd.simulation.robot_cameras import RobotCameras, robot_camera
from openrooms_usd.simulation.robots import rover, with_robot
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world

CHANNELS = ("depth", "semantic")


def test_many_pictures_of_one_translation(
    composed_bodies: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = with_robot(read_world(open_stage(composed_bodies)), rover((0.6, 2.2)))
    simulation = adapters.load(adapters.ENGINES, "mujoco").open(world)
    onlooker = {"onlooker": look_at((3.8, 0.3, 2.2), (0.8, 2.0, 0.2))}
    translations: list[object] = []
    translate = opening.translate
    monkeypatch.setattr(
        opening,
        "translate",
        lambda stage, **how: (translations.append(stage), translate(stage, **how))[1],
    )

    def cameras() -> RobotCameras:
        return RobotCameras(composed_bodies, world, renderer="preview", resolution=(96, 72))

    kept = cameras()
    depths = []
    for x in (0.6, 0.9, 1.2):
        pose = simulation.poses()["rover"].world_from_body.copy()
        pose[0, 3] = x
        simulation.place("rover", pose, {})
        view = kept.see(simulation, onlooker, CHANNELS)["onlooker"]
        fresh = cameras().see(simulation, onlooker, CHANNELS)["onlooker"]
        for name in CHANNELS:
            assert np.allclose(view.images[name].pixels, fresh.images[name].pixels, atol=1e-5)
        depths.append(view.images["depth"].pixels)
    # One for what was kept, and one for each that was made anew to compare with.
    assert len(translations) == 1 + 3
    assert all(np.abs(a - b).max() > 0.1 for a, b in pairwise(depths))


def test_a_camera_on_the_robot_goes_with_it(composed_bodies: Path) -> None:
    """Depth of the wall ahead falls by as much as the robot has come nearer."""
    world = with_robot(read_world(open_stage(composed_bodies)), rover((0.6, 2.7)))
    simulation = adapters.load(adapters.ENGINES, "mujoco").open(world)
    cameras = RobotCameras(composed_bodies, world, renderer="preview", resolution=(33, 25))

    def ahead(x: float) -> float:
        pose = np.eye(4)
        pose[:3, 3] = x, 2.7, 0.0
        simulation.place("rover", pose, {})
        camera = {"robot": robot_camera(simulation, "rover")}
        view = cameras.see(simulation, camera, ("depth",))["robot"]
        return float(view.images["depth"].pixels[12, 16, 0])

    assert ahead(0.6) - ahead(1.35) == pytest.approx(0.75, abs=1e-5)
