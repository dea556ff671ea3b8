"""A large scene is framed by its renderer's tracer as the stage's own meshes frame it."""

from typing import Any

import numpy as np
import pytest
from pxr import Gf

from openrooms_usd.rendering.scene import framing
from openrooms_usd.usd.cameras import framing_camera
from tests import small
from tests.crowd import crowd


def closed_room() -> small.Stage:
    made = small.Stage(metres=0.01)
    room = made.box("/World/room", 1.0, inside=True, at=(250, 200, 125))
    room.AddScaleOp().Set(Gf.Vec3f(500, 400, 250))
    made.box("/World/table", 80.0, at=(300, 250, 40))
    return made


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", ["room", "crowd"])
def test_it_is_the_same_camera(open_stage: Any, name: str, tmp_path: Any) -> None:
    stage = closed_room().stage if name == "room" else crowd(str(tmp_path / "none.png")).stage
    opened = open_stage(stage)
    tracer = opened.session.tracer or opened._caster
    expected = framing_camera(stage, 64, 48)
    found = framing.framed(opened.scene, tracer, 64, 48)
    assert np.allclose(found.K, expected.K)
    assert np.allclose(found.world_from_camera, expected.world_from_camera, atol=1e-4)
    eye = found.world_from_camera[:3, 3]
    if name == "room":
        assert (eye > 0.0).all()
        assert (eye < [5.0, 4.0, 2.5]).all()


def test_only_large_scenes_are(
    open_stage: Any, tmp_path: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = open_stage(crowd(str(tmp_path / "none.png")).stage).scene
    assert not framing.is_framed_here(scene)
    monkeypatch.setattr(framing, "_MANY_TRIANGLES", len(scene.triangles) - 1)
    assert framing.is_framed_here(scene)
