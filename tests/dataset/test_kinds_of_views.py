"""Frames of a walk, stereo pairs and panoramas as a dataset has them: files, and what is told."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.dataset.run import run_dataset
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.reading import RenderedView, read_render

VIEWS = "{count: 2, resolution: [24, 18]}"
Made = Callable[[str], list[RenderedView]]


@pytest.fixture
def made(tmp_path: Path, write_source: Callable[[Path], Path]) -> Made:
    """The views of the small room that a section asks for."""

    def of(views: str) -> list[RenderedView]:
        file = write_source(tmp_path / "source")
        text = file.read_text().replace(", poisoned/room.yaml", "").replace(", mainDiffMat", "")
        text = text.replace("[radiance, depth, instance, valid]", "[depth, distance, position]")
        file.write_text(text.replace(VIEWS, views))
        assert not run_dataset(file, tmp_path / "out").failed
        (render,) = {path.parent for path in (tmp_path / "out/renders").rglob("manifest.json")}
        return list(read_render(render).views.values())

    return of


def told(view: RenderedView) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((view.folder.parent / "manifest.json").read_text())
    return found["views"][view.name]


@pytest.mark.slow
def test_frames_of_a_walk_have_the_flow_to_the_next_one(made: Made) -> None:
    views = made("{from: path, count: 2, rate: 2, resolution: [24, 18], stereo: 10 cm}")
    assert len(views) == 4
    frames, pairs = ([told(view)[key] for view in views] for key in ("frame", "stereo"))
    assert [(frame["number"], frame["seconds"]) for frame in frames] == [
        (0, 0),
        (0, 0),
        (1, 0.5),
        (1, 0.5),
    ]
    assert [(pair["eye"], pair["pair"]) for pair in pairs] == [
        ("left", 0),
        ("right", 0),
        ("left", 1),
        ("right", 1),
    ]
    column, row = np.meshgrid(np.arange(24) + 0.5, np.arange(18) + 0.5)
    for view, after in zip(views[:2], views[2:], strict=True):
        # To the same eye of the next frame, from the positions that the files have.
        pose = after.world_from_camera
        local = (view.pixels["position"] - pose[:3, 3]) @ pose[:3, :3]
        place = local @ after.K.T / local[..., 2:]
        there = np.dstack([column, row]) + view.pixels["flow"]
        ahead = (local[..., 2] > 0.1) & (view.pixels["depth"][..., 0] > 0.0)
        assert ahead.mean() > 0.5
        np.testing.assert_allclose(there[ahead], place[ahead][:, :2], atol=2e-3)
    # Of the last frame, too, whose next one is nowhere.
    assert all(np.abs(view.pixels["flow"]).max() > 0.0 for view in views)
    assert all(set(np.unique(view.pixels["flow_visible"])) <= {0.0, 1.0} for view in views)
    # The right eye is to the right: disparity is f b / depth, of what both of them see.
    left, right = views[:2]
    moved = np.linalg.inv(left.world_from_camera) @ right.world_from_camera
    np.testing.assert_allclose(moved[:3, 3], [0.1, 0.0, 0.0], atol=1e-9)


@pytest.mark.slow
def test_panoramas_are_told_and_refused_by_what_works_with_pinholes(made: Made) -> None:
    (view, _) = made("{projection: equirectangular, count: 2, resolution: [32, 16]}")
    assert told(view)["projection"] == "equirectangular"
    np.testing.assert_allclose(told(view)["K"][0][0], 32 / (2 * np.pi))
    # What is left out where it follows from depth is there: nothing follows as of a pinhole.
    away = view.pixels["position"] - view.world_from_camera[:3, 3]
    length = np.linalg.norm(away, axis=-1, keepdims=True)
    seen = view.pixels["depth"] > 0.0
    np.testing.assert_allclose(length[seen], view.pixels["depth"][seen], rtol=1e-4)
    np.testing.assert_array_equal(view.pixels["depth"], view.pixels["distance"])
    with pytest.raises(InputError, match="works with pinhole cameras alone"):
        assert view.K is None
