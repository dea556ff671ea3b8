"""Instances that share their triangles are seen as what is expanded."""

from typing import Any

import numpy as np
import pytest
from pxr import Usd

from openrooms_usd.rendering import RenderRequest
from openrooms_usd.rendering.scene import gathering
from openrooms_usd.rendering.scene.instances import Instances, joined
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.rendering.scene.triangles import Triangles
from tests.crowd import crowd

EXACT = ("depth", "position", "normal", "base_color", "instance", "part", "material")


@pytest.fixture
def keep(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Say from how many triangles on instances share theirs."""

    def set_least(kept: bool) -> None:
        for name in ("LEAST_SAVED_TRIANGLES", "_LEAST_SAVED_BY_ONE"):
            monkeypatch.setattr(gathering, name, 1 if kept else 1 << 40)

    return set_least


@pytest.fixture
def picture(tmp_path: Any) -> str:
    from PIL import Image

    pixels = np.random.default_rng(5).integers(40, 220, (8, 8, 3)).astype(np.uint8)
    Image.fromarray(pixels).save(tmp_path / "paper.png")
    return str(tmp_path / "paper.png")


def shared(stage: Usd.Stage) -> list[Instances]:
    return [
        part
        for patch in translate(stage).patches
        for part in patch.triangles.parts
        if isinstance(part, Instances)
    ]


def test_what_is_seen_is_the_same(open_stage: Any, keep: Any, picture: str) -> None:
    stage = crowd(picture).stage
    request: Any = RenderRequest("/Camera", EXACT, width=64, height=48, samples=1)
    keep(False)
    assert not shared(stage)
    expected = open_stage(stage).render(request).images
    keep(True)
    # The lid, the sides and the tip, of either way to say it.
    assert [len(one.owners) for one in shared(stage)] == [5, 3] * 3
    found = open_stage(stage).render(request).images
    for name in EXACT:
        a, b = expected[name].pixels.astype(np.float64), found[name].pixels.astype(np.float64)
        # In single precision a ray beside an edge may choose the neighbour.
        alike = np.isclose(a, b, atol=1e-4).all(axis=-1)
        assert alike.mean() > 0.997, name
    assert len(np.unique(expected["instance"].pixels)) > 8


def test_radiance_is_the_same(open_stage: Any, keep: Any, picture: str) -> None:
    stage = crowd(picture).stage
    request: Any = RenderRequest("/Camera", ("radiance",), width=32, height=24, samples=16)
    pictures = []
    for kept in (False, True):
        keep(kept)
        pictures.append(open_stage(stage).render(request).images["radiance"].pixels)
    assert pictures[0].mean() == pytest.approx(pictures[1].mean(), rel=2e-3, abs=1e-9)
    assert np.isclose(*pictures, rtol=0.05, atol=1e-3).mean() > 0.97


def test_they_move(open_stage: Any, keep: Any, picture: str) -> None:
    motion = np.eye(4)
    motion[:3, :3] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    motion[:3, 3] = 0.0, 1.5, 0.4
    request: Any = RenderRequest("/Camera", ("depth", "instance"), width=64, height=48, samples=1)
    pictures = []
    for kept in (False, True):
        keep(kept)
        opened = open_stage(crowd(picture).stage)
        still = opened.render(request).images["depth"].pixels
        opened.move({"/World/i2": motion})
        pictures.append(opened.render(request).images["depth"].pixels)
        assert (pictures[-1] != still).mean() > 0.01
    assert np.isclose(*pictures, atol=1e-4).mean() > 0.997


def test_rows_are_found_by_numbers_flags_and_slices() -> None:
    """Whichever way they are asked for, they are those of the triangles that lie in memory."""
    own = Triangles(
        np.arange(27.0).reshape(3, 3, 3),
        np.tile(np.float32([0.0, 0.0, 1.0]), (3, 3, 1)),
        np.zeros((3, 3, 2), np.float32),
        np.zeros(3, np.int32),
    )
    matrices = np.tile(np.eye(4), (4, 1, 1))
    matrices[:, 0, 3] = np.arange(4) * 100.0
    instances = Instances(own, matrices, np.arange(4, dtype=np.int32))
    several = joined([own, instances])
    for triangles in (instances, several):
        every = triangles.corners
        flags = np.arange(len(triangles)) % 3 == 1
        for which in ([5, 0, 7], [-1, 2], flags, slice(2, None, 3), slice(0, 0)):
            chosen = np.array(which) if isinstance(which, list) else which
            found = triangles.rows(chosen)
            assert np.array_equal(found.corners, every[chosen])
