"""From where rooms are seen, and frames of walks, stereo pairs and panoramas in a dataset."""

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.composing import compose_room
from openrooms_usd.dataset.run import run_dataset
from openrooms_usd.dataset.shots import shot, shots_of
from openrooms_usd.dataset.variants import with_cameras
from openrooms_usd.description import parse_room
from openrooms_usd.description.dataset import Dataset, DatasetViews
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError, RenderError
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.opening import open_for_rendering
from openrooms_usd.rendering.reading import RenderedView, read_render

ROOM = """\
name: small
room: office
layout: {polygon: [[0, 0], [4, 0], [4, 3], [0, 3]], height: 2.5}
furniture:
  objects:
    - {category: chair, at: [2.0, 1.4], yaw: 180 deg}
materials: {resolution: 16}
cameras:
  views:
    - {eye: [0.5, 0.5, 1.5], target: [2.0, 1.4, 0.5]}
    - {eye: [3.97, 1.0, 1.5], target: [5.0, 1.0, 1.5]}
    - {eye: [3.9, 1.0, 1.5], target: [5.0, 1.0, 1.5]}
    - {eye: [3.5, 2.5, 1.5], target: [2.0, 1.4, 0.5]}
    - {eye: [0.5, 2.5, 1.5], target: [2.0, 1.4, 0.5]}
"""

Open = Callable[..., RenderContext]


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Open:
    """The small room with the cameras that a dataset asks for."""

    def of(views: DatasetViews, text: str = ROOM) -> RenderContext:
        room = with_cameras(parse_room(text, "room.yaml"), views)
        out = tmp_path_factory.mktemp("room")
        made = compose_room(room, out, base=out)
        settings = RenderSettings(
            channels=("depth",), resolution=views.resolution, renderer="preview"
        )
        return open_for_rendering(made.scene, settings, spares=True)

    return of


def views(**given: object) -> DatasetViews:
    return DatasetViews.model_validate({"resolution": [24, 18], **given})


def test_cameras_of_no_use_give_way_to_the_next_ones(opened: Open) -> None:
    asked = views(**{"from": "described", "count": 3, "replace": 2})
    room = opened(asked)
    found = shots_of(asked, room)
    assert [one.view for one in found] == ["view_0", "view_3", "view_4"]
    assert [len(one.rejected) for one in found] == [0, 1, 1]
    (first,) = found[1].rejected
    assert first["camera"] == "view_1"
    assert first["faults"] == ["the camera is inside an object", "it shows only one object"]
    assert first["world_from_camera"][0][3] == 3.97
    assert found[2].rejected[0]["faults"][0] == "an object blocks the camera"
    # Where too few are left, the camera stays that was asked for; who wants no judgement has none.
    asked = views(**{"from": "described", "count": 3, "replace": 1})
    assert [one.view for one in shots_of(asked, room)] == ["view_0", "view_3", "view_2"]
    asked = views(**{"from": "described", "count": 3, "replace": 0})
    assert [one.view for one in shots_of(asked, room)] == ["view_0", "view_1", "view_2"]
    with pytest.raises(RenderError, match="3 views, but no view 3"):
        shot(found, 3, "small")


def test_spare_cameras_leave_the_chosen_ones_as_they_are(opened: Open) -> None:
    few, more = views(count=2, replace=0), views(count=2, replace=3)
    chosen, both = opened(few), opened(more)
    assert sorted(chosen.views) == ["view_0", "view_1"]
    assert sorted(both.views) == ["spare_0", "spare_1", "spare_2", "view_0", "view_1"]
    for name in chosen.views:
        one, other = chosen.camera(chosen.views[name]), both.camera(both.views[name])
        np.testing.assert_array_equal(one.world_from_camera, other.world_from_camera)
    assert [one.view for one in shots_of(more, both)] == ["view_0", "view_1"]


def test_a_path_is_walked_at_a_human_pace_and_height(opened: Open) -> None:
    asked = views(**{"from": "path", "count": 12, "rate": 3, "fov": 70})
    found = shots_of(asked, opened(asked))
    assert [one.told["frame"]["seconds"] for one in found] == pytest.approx(np.arange(12) / 3)
    eyes = np.array([one.camera.world_from_camera[:3, 3] for one in found])
    assert ((eyes[:, 2] > 1.1) & (eyes[:, 2] < 1.8)).all()
    assert (np.linalg.norm(np.diff(eyes, axis=0), axis=1) * 3 < 1.4).all()
    for before, now in pairwise(found):
        assert before.after is not None
        np.testing.assert_array_equal(before.after.world_from_camera, now.camera.world_from_camera)


def test_a_stereo_pair_looks_the_same_way_side_by_side(opened: Open) -> None:
    asked = views(count=2, replace=0, stereo="12 cm")
    found = shots_of(asked, opened(asked))
    assert [one.told["stereo"]["eye"] for one in found] == ["left", "right"] * 2
    assert asked.units == len({one.name for one in found}) == 4
    for left, right in zip(found[::2], found[1::2], strict=True):
        moved = np.linalg.inv(left.camera.world_from_camera) @ right.camera.world_from_camera
        wanted = np.eye(4)
        wanted[0, 3] = 0.12
        np.testing.assert_allclose(moved, wanted, atol=1e-12)
        np.testing.assert_array_equal(left.camera.K, right.camera.K)


def test_both_eyes_of_a_pair_are_judged_and_the_second_is_no_camera_of_the_stage(
    opened: Open,
) -> None:
    # The first camera stands in a corner: 60 cm to its right is the outside.
    asked = views(**{"from": "described", "count": 1, "replace": 4, "stereo": "60 cm"})
    room = opened(asked)
    left, right = shots_of(asked, room)
    alone = views(**{"from": "described", "count": 1, "replace": 4})
    assert [one.view for one in shots_of(alone, room)] == ["view_0"]
    assert (left.view, right.view) == ("view_3", None)
    assert [one["camera"] for one in left.rejected] == ["view_0", "view_1", "view_2"]
    assert not right.rejected


def test_described_cameras_come_in_the_order_of_the_room(opened: Open) -> None:
    named = ROOM.replace("- {eye: [0.5, 0.5", "- {name: window, eye: [0.5, 0.5")
    named = named.replace("- {eye: [3.5, 2.5", "- {name: door, eye: [3.5, 2.5")
    asked = views(**{"from": "described", "count": 5, "replace": 0})
    found = [one.view for one in shots_of(asked, opened(asked, named))]
    assert found == ["window", "view_0", "view_1", "door", "view_2"]


def test_frames_a_second_are_of_a_path() -> None:
    with pytest.raises(ValueError, match="only paths"):
        views(rate=4)


def test_panoramas_are_level_and_look_where_the_view_does(opened: Open) -> None:
    given = {"from": "described", "count": 1, "replace": 0, "resolution": [48, 24]}
    pinhole, round_about = views(**given), views(**given, projection="equirectangular")
    room = opened(round_about)
    (narrow,), (wide,) = shots_of(pinhole, room), shots_of(round_about, room)
    assert wide.camera.projection == "equirectangular"
    before, after = narrow.camera.world_from_camera, wide.camera.world_from_camera
    np.testing.assert_array_equal(after[:3, 3], before[:3, 3])
    np.testing.assert_allclose(after[:3, 1], [0.0, 0.0, -1.0], atol=1e-12)
    heading = before[:2, 2] / np.linalg.norm(before[:2, 2])
    np.testing.assert_allclose(after[:2, 2], heading, atol=1e-12)
    depth = room.shoot(wide.camera, "here").images["depth"].pixels
    assert (depth > 0.0).all()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"resolution": [48, 36]}, "twice as wide"),
        ({"resolution": [None, {}]}, "valid integer"),
        ({"stereo": 0.1}, "stereo is not available"),
    ],
)
def test_what_no_panorama_has_is_refused(wrong: dict[str, object], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        views(**{"resolution": [48, 24], "projection": "equirectangular", **wrong})


def test_generated_rooms_have_no_photographs() -> None:
    rooms = [{"files": ["a/room.yaml"]}, {"types": ["bathroom"], "count": 2}]
    with pytest.raises(ValueError, match="no photographs"):
        Dataset.model_validate({"rooms": rooms, "views": {"from": "capture"}})
    Dataset.model_validate({"rooms": rooms[:1], "views": {"from": "capture"}})


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
    with pytest.raises(InputError, match="this needs pinhole cameras"):
        assert view.K is None
