"""Renders as arrays by name, written here with OpenImageIO alone."""

import json
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.rendering.exr import read_channels, read_picture
from openrooms_usd.rendering.manifest_schema import ViewEntry
from openrooms_usd.rendering.reading import RenderedView, read_render
from tests.pictures import save_picture

ENTRY = {"resolution": [8, 6], "K": np.eye(3).tolist(), "world_from_camera": np.eye(4).tolist()}
LIGHT = {
    "kind": "lamp",
    "on": True,
    "world_from_box": np.eye(4).tolist(),
    "size": [1.0, 1.0, 1.0],
    "radiance": [1.0, 1.0, 1.0],
}


@pytest.fixture
def pixels() -> np.ndarray:
    return np.random.default_rng(0).random((6, 8, 7)).astype(np.float32)


def view(folder: Path) -> RenderedView:
    return RenderedView("view", folder, ViewEntry.model_validate_json(json.dumps(ENTRY)))


def test_layers_keep_their_parts_in_order(pixels: np.ndarray, tmp_path: Path) -> None:
    """Files list parts as they like, the alphabet's order among them: B, G, R."""
    names = ["a.B", "a.G", "a.R", "n.Z", "n.X", "n.Y", "d.Y"]
    save_picture(tmp_path / "a.exr", pixels, names=names)
    found = read_channels(tmp_path / "a.exr")
    np.testing.assert_array_equal(found["a"], pixels[..., [2, 1, 0]])
    np.testing.assert_array_equal(found["n"], pixels[..., [4, 5, 3]])
    np.testing.assert_array_equal(found["d"], pixels[..., [6]])


def test_lights_are_found_by_number(pixels: np.ndarray, tmp_path: Path) -> None:
    names = ["mask_0.Y", "mask_12.Y", *(f"direct_2.{part}" for part in "RGB"), "odd.Y", "x_.Y"]
    save_picture(tmp_path / "lights.exr", pixels, names=names)
    found = view(tmp_path).lights
    assert {name: [*lights] for name, lights in found.items()} == {"mask": [0, 12], "direct": [2]}
    np.testing.assert_array_equal(found["mask"][12], pixels[..., [1]])
    np.testing.assert_array_equal(found["direct"][2], pixels[..., 2:5])


def test_a_view_without_lights_and_grids(tmp_path: Path) -> None:
    assert view(tmp_path).lights == {}
    assert view(tmp_path).grid("environment") is None
    assert view(tmp_path).fit("environment_sg") is None


def test_a_grid_has_its_hemispheres(tmp_path: Path) -> None:
    picture = np.random.default_rng(1).random((2 * 16, 3 * 32, 3)).astype(np.float32)
    save_picture(tmp_path / "environment.exr", picture, names=["R", "G", "B"])
    grid = view(tmp_path).grid("environment")
    assert grid is not None and grid.shape == (2, 3, 16, 32, 3)
    np.testing.assert_array_equal(grid[1, 2, 5, 7], picture[16 + 5, 64 + 7])


def test_a_grid_of_another_size_is_refused(tmp_path: Path) -> None:
    save_picture(
        tmp_path / "environment.exr", np.zeros((16, 33, 3), np.float32), names=["R", "G", "B"]
    )
    with pytest.raises(InputError, match="not a grid of hemispheres"):
        view(tmp_path).grid("environment")


def test_a_fit_of_objects_is_not_loaded(tmp_path: Path) -> None:
    np.save(tmp_path / "environment_sg.npy", np.array([None]), allow_pickle=True)
    with pytest.raises(InputError, match="not a readable array"):
        view(tmp_path).fit("environment_sg")


def test_what_is_no_picture_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.exr").write_bytes(b"nothing")
    for name, said in (("a.exr", "not a readable image"), ("none.exr", "no such file")):
        with pytest.raises(InputError, match=said):
            read_picture(tmp_path / name)


def test_views_and_lights_come_in_order(tmp_path: Path) -> None:
    entries = dict.fromkeys(("view_10", "view_9", "b", "a"), ENTRY)
    lights = [{**LIGHT, "number": number, "name": str(number)} for number in (1, 0)]
    legend = {"instance": {"3": "/World/Room"}}
    manifest = {
        "views": entries,
        "lights": lights,
        "legend": legend,
        "generator": "openrooms_usd 1",
    }
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    scene = read_render(tmp_path)
    assert [*scene.views] == ["a", "b", "view_9", "view_10"]
    assert scene.views["a"].folder == tmp_path / "a"
    assert [light.number for light in scene.lights] == [0, 1]
    assert scene.legend("instance") == {3: "/World/Room"} and scene.legend("none") == {}
