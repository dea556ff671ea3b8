"""Rooms in Newton, the physics engine of its own: they load, and stay as they stand.

Runs where `.ci/install-newton` has been, or where ORUSD_NEWTON_PYTHON names a Python that has it:
Newton takes 0.9 GB and brings its own pxr. Its kernels are compiled at their first use: a minute.
"""

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from openrooms_usd.compose import compose_room
from openrooms_usd.usd.layers import open_stage
from openrooms_usd.usd.rigid.reading import read_world

ROOT = Path(__file__).parents[2]
PYTHON = os.environ.get("ORUSD_NEWTON_PYTHON", str(ROOT / ".venv-newton/bin/python"))
SECONDS = 2.0
# Seen: 2.7 mm in the example, 4.0 in the bedroom, by Newton's solver of positions with 8 rounds.
MOVED = 6e-3
# Between the two anchors of a joint, across its axis; seen: 5 micrometres.
APART = 1e-4

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not Path(PYTHON).exists(),
        reason=f"no Newton: {PYTHON} is missing (.ci/install-newton, ORUSD_NEWTON_PYTHON)",
    ),
]


def rest(scene: Path) -> dict[str, Any]:
    words = [PYTHON, str(Path(__file__).with_name("newton_episode.py")), str(scene), str(SECONDS)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr[-3000:]
    return dict(json.loads(done.stdout.splitlines()[-1]))


def check(scene: Path, *joints: str) -> None:
    """What we read as bodies and joints is there, nothing moves, and no joint comes apart."""
    found, world = rest(scene), read_world(open_stage(scene))
    ours = [link.path for body in world.bodies for link in body.links if link.mass is not None]
    assert set(found["moved"]) == {path.removeprefix("/World/") for path in ours}
    assert len(found["joints"]) == sum(len(body.joints) for body in world.bodies)
    for joint in joints:
        assert any(joint in name for name in found["joints"]), joint
    assert {k: v for k, v in found["moved"].items() if not v < MOVED} == {}
    assert {k: v for k, v in found["joints"].items() if not v < APART} == {}


def test_the_example_rests(demo: Path) -> None:
    check(demo, "sideboard/Physics/Joints/door_0_hinge", "drawer_2_rail", "door/Physics")


def test_a_generated_room_rests(generated: Callable[[str, int], Path], tmp_path: Path) -> None:
    source = generated("bedroom", 12).parent / "source" / "room.yaml"
    room = source.with_name("robots.yaml")
    room.write_text(f"{source.read_text()}\nphysics: {{}}\n")
    scene = compose_room(room, tmp_path).scene
    check(scene, "wardrobe/Physics/Joints/drawer_0_rail", "door_0/Physics")
