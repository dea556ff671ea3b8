"""Our MJCF through NVIDIA's and DeepMind's converter to USD: the bodies that come out are ours.

Runs where `.ci/install-mujoco-usd` has been, or where ORUSD_MUJOCO_USD names the converter's
command: it brings a USD of its own.
"""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd.physics.world import Joint, Link, World
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world
from orusd_urdf import MjcfExporter

ROOT = Path(__file__).parents[2]
COMMAND = os.environ.get(
    "ORUSD_MUJOCO_USD", str(ROOT / ".venv-mujoco-usd/bin/mujoco_usd_converter")
)

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not Path(COMMAND).exists(),
        reason=f"no converter: {COMMAND} is missing (.ci/install-mujoco-usd, ORUSD_MUJOCO_USD)",
    ),
]


@pytest.fixture(scope="module")
def exported(composed_bodies: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("mjcf")
    # The converter knows no pairs: it says so, and leaves them out.
    MjcfExporter().convert(open_stage(composed_bodies), folder, {"pairs": "none"})
    return folder


@pytest.fixture(scope="module")
def converted(exported: Path) -> Usd.Stage:
    words = [COMMAND, str(exported / "scene.xml"), str(exported / "usd")]
    done = subprocess.run(words, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-3000:]
    lines = (done.stdout + done.stderr).splitlines()
    # It warns of functions of its own that are old, and of nothing in our file.
    assert [line for line in lines if "[Warning]" in line and "deprecat" not in line] == []
    return open_stage(exported / "usd/room.usda")


def links(world: World) -> dict[str, Link]:
    return {link.path: link for body in world.bodies for link in body.links}


def joints(world: World) -> dict[str, Joint]:
    """By the path of what they move."""
    found = {}
    for body in world.bodies:
        paths = {link.name: link.path for link in body.links}
        found |= {paths[joint.child]: joint for joint in body.joints if joint.kind != "fixed"}
    return found


def named(stage: Usd.Stage, path: str) -> str:
    """The name in the MJCF file; prims have others where USD allows no such name."""
    prim = stage.GetPrimAtPath(path)
    return prim.GetDisplayName() or prim.GetName()


def test_bodies_and_joints_are_ours(
    composed_bodies: Path, exported: Path, converted: Usd.Stage
) -> None:
    ours, theirs = read_world(open_stage(composed_bodies)), read_world(converted)
    prims = json.loads((exported / "names.json").read_text())["bodies"]
    others = {
        prims[name]: link
        for path, link in links(theirs).items()
        if (name := named(converted, path)) in prims
    }
    moving = {path: link for path, link in links(ours).items() if link.mass is not None}
    assert moving and set(moving) <= set(others)
    for path, link in moving.items():
        twin = others[path]
        assert twin.mass is not None
        assert twin.mass.mass == pytest.approx(link.mass.mass, rel=1e-5)
        np.testing.assert_allclose(twin.mass.centre, link.mass.centre, atol=1e-5)
        near = 1e-4 * np.trace(link.mass.inertia)
        np.testing.assert_allclose(twin.mass.inertia, link.mass.inertia, atol=near)
        assert len(twin.shapes) == len(link.shapes)

    moved = {prims[named(converted, path)]: joint for path, joint in joints(theirs).items()}
    assert set(moved) == set(joints(ours)) != set()
    for path, joint in joints(ours).items():
        assert moved[path].kind == joint.kind
        np.testing.assert_allclose(moved[path].limits, joint.limits, atol=1e-4)
        np.testing.assert_allclose(moved[path].axis, joint.axis, atol=1e-4)
