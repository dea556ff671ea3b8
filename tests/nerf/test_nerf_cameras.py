"""Depth through the cameras of ``transforms.json`` lies on the surfaces, by its readers' rules."""

import json
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.rendering.datasets import DatasetOptions
from openrooms_usd.rendering.reading import RenderedScene
from orusd_nerf import NerfDataset, cameras
from tests.openrooms.synthetic import make_render

Array = np.ndarray


def depth_of(path: Path) -> Array:
    source = OpenImageIO.ImageInput.open(str(path))
    pixels = source.read_image(OpenImageIO.UINT16)
    source.close()
    return pixels[..., 0]


def nerfstudio_rays(meta: dict, frame: dict) -> tuple[Array, Array]:
    """Origins and directions of nerfstudio's ``Cameras.generate_rays``, before it normalises them.

    Image coordinates are pixels + 0.5, directions (x, -y, -1) in the camera; planar depth counts
    along these, for it is multiplied by the norm of the direction that was normalised.
    """
    lens = meta | frame
    x, y = np.meshgrid(np.arange(lens["w"]) + 0.5, np.arange(lens["h"]) + 0.5)
    rays = np.stack(
        [(x - lens["cx"]) / lens["fl_x"], -(y - lens["cy"]) / lens["fl_y"], -np.ones_like(x)], -1
    )
    matrix = np.array(frame["transform_matrix"])
    return matrix[:3, 3], rays @ matrix[:3, :3].T


def ngp_rays(meta: dict, frame: dict) -> tuple[Array, Array]:
    """The same by instant-ngp: its matrices have y and z turned around, and axes permuted.

    ``nerf_matrix_to_ngp``, then ``uv_to_ray`` of a perspective lens: the principal point is over
    the resolution, and uv = (pixel + 0.5) / resolution.
    """
    lens = meta | frame
    size = np.array([lens["w"], lens["h"]])
    matrix = np.array(frame["transform_matrix"])[:3] * [1, -1, -1, 1]
    low, high = np.array(meta["aabb"])
    scale = 1.0 / (high - low).max()
    matrix[:, 3] = matrix[:, 3] * scale + 0.5 - 0.5 * (low + high) * scale
    matrix = matrix[[1, 2, 0]]
    x, y = np.meshgrid(np.arange(lens["w"]) + 0.5, np.arange(lens["h"]) + 0.5)
    uv = np.stack([x, y], -1) / size
    middle = np.array([lens["cx"], lens["cy"]]) / size
    focal = np.array([lens["fl_x"], lens["fl_y"]])
    rays = np.concatenate([(uv - middle) * size / focal, np.ones((*uv.shape[:2], 1))], -1)
    origin, rays = matrix[:, 3], rays @ matrix[:, :3].T
    # Back from its unit cube to our metres.
    inverse = [2, 0, 1]
    return (origin[inverse] - 0.5 + 0.5 * (low + high) * scale) / scale, rays[..., inverse]


def check(root: Path, rule=nerfstudio_rays) -> None:
    meta = json.loads((root / "transforms.json").read_text())
    assert meta["frames"]
    for frame in meta["frames"]:
        steps = depth_of(root / frame["depth_file_path"])
        assert frame["depth_path"] == frame["depth_file_path"]
        metres = steps * 1e-3
        assert meta["integer_depth_scale"] == 1e-3
        origin, rays = rule(meta, frame)
        points = (origin + metres[..., None] * rays)[steps > 0]
        assert len(points) > 0.5 * steps.size
        away = np.minimum(abs(points[:, 2]), abs(points[:, 1] - 4.0))
        # Half a step of depth, along rays of at most a length of 1.5.
        assert away.max() < 1e-3


@pytest.mark.parametrize("rule", [nerfstudio_rays, ngp_rays])
def test_depth_lies_on_the_surfaces(rule, dataset: Path) -> None:
    check(dataset, rule)


@pytest.mark.parametrize("turn", [(1, 1, 1), (-1, -1, 1), (1, -1, 1), (1, 1, -1)])
def test_a_flipped_axis_is_noticed(
    turn: tuple, render: RenderedScene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cameras, "_OPENCV_FROM_OPENGL", np.diag([*turn, 1.0]))
    NerfDataset().write([render], tmp_path, DatasetOptions())
    with pytest.raises(AssertionError):
        check(tmp_path)


def test_cameras_that_differ_stand_in_their_frames(tmp_path: Path) -> None:
    render = make_render(tmp_path / "day", views=2)
    other = make_render(tmp_path / "wide", size=(80, 48), views=1)
    (tmp_path / "wide/view_0").rename(tmp_path / "day/wide")
    manifest = json.loads((tmp_path / "day/manifest.json").read_text())
    manifest["views"]["wide"] = json.loads((other.folder / "manifest.json").read_text())["views"][
        "view_0"
    ]
    (tmp_path / "day/manifest.json").write_text(json.dumps(manifest))
    from openrooms_usd.rendering.reading import read_render

    NerfDataset().write([read_render(render.folder)], tmp_path / "data", DatasetOptions())
    meta = json.loads((tmp_path / "data/transforms.json").read_text())
    assert not {"w", "h", "fl_x", "cx"} & set(meta)
    assert [frame["w"] for frame in meta["frames"]] == [64, 64, 80]
    check(tmp_path / "data")


def test_matrices_are_those_of_the_render(render: RenderedScene, dataset: Path) -> None:
    found = json.loads((dataset / "cameras.json").read_text())["cameras"]
    arrays = np.load(dataset / "cameras.npz")
    assert list(found) == list(render.views) == arrays["name"].tolist()
    for number, (name, view) in enumerate(render.views.items()):
        assert found[name]["K"] == view.K.tolist()
        assert (found[name]["width"], found[name]["height"]) == (64, 48)
        for stored in (found[name]["world_from_camera"], arrays["world_from_camera"][number]):
            np.testing.assert_allclose(stored, view.world_from_camera, atol=1e-12)
        both = arrays["camera_from_world"][number] @ view.world_from_camera
        np.testing.assert_allclose(both, np.eye(4), atol=1e-12)
