"""Views of Hypersim's layout load as what was written, each with its camera."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.loading import open_source
from orusd_hypersim.hdf5 import write_array
from tests.hypersim.test_hypersim import HALF, HEIGHT, WIDTH, K, channels, pose, root

__all__ = ["root"]  # the fixture


def test_a_frame_has_its_channels_and_its_camera(root: Path) -> None:
    source = open_source(root, form="hypersim", split="val")
    assert len(source) == 2
    names = ["depth", "distance", "position", "normal", "irradiance", "instance", "valid"]
    found, truth = source.read(1, names), channels(1)
    np.testing.assert_allclose(found.K, K, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(found.world_from_camera, pose(1), atol=1e-12)
    assert found.size == (WIDTH, HEIGHT)
    for name in ("depth", "distance", "position"):
        np.testing.assert_allclose(found.images[name], truth[name], rtol=1e-6, atol=1e-5)
    for name in ("normal", "irradiance"):
        np.testing.assert_allclose(found.images[name], truth[name], rtol=HALF, atol=HALF)
    assert (found.images["instance"] == truth["instance"]).all()
    assert (found.images["valid"] == (truth["depth"] > 0)).all()
    assert found.about == {"room": "ai_001_007", "variant": "cam_00", "split": "val"}


def test_colour_is_diffuse_and_residual(root: Path) -> None:
    found = open_source(root, form="hypersim").read(0, ["radiance", "diffuse", "residual"]).images
    off = np.abs(found["diffuse"] + found["residual"] - found["radiance"])
    assert (off <= 1e-3 + HALF * np.abs(found["residual"])).all()


def test_what_is_not_there_is_told(root: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no view is there"):
        open_source(root, form="hypersim", split="train")
    source = open_source(root, form="hypersim")
    with pytest.raises(InputError, match="do not tell 'base_color'"):
        source.read(0, ["base_color"])


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("metadata_camera_parameters.csv", "M_cam_from_uv_00", "another"),
        ("metadata_camera_parameters.csv", f"{HEIGHT},{WIDTH}", f"{HEIGHT},wide"),
        ("metadata_camera_parameters.csv", f"{HEIGHT},{WIDTH}", f"{HEIGHT},inf"),
        ("metadata_camera_parameters.csv", f"{HEIGHT},{WIDTH}", f"{HEIGHT},0"),
        ("metadata_camera_parameters.csv", "scene_name", "scene"),
        ("scenes/ai_001_007/_detail/metadata_scene.csv", "meters_per_asset_unit", "unit"),
        ("analysis/metadata_images_split_scene_v1.csv", "frame_id", "frame"),
    ],
)
def test_a_table_that_is_none_is_named(
    file: str, old: str, new: str, root: Path, tmp_path: Path
) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(root, copy)
    text = (copy / file).read_text()
    assert old in text
    (copy / file).write_text(text.replace(old, new))
    with pytest.raises(InputError, match=Path(file).name):
        open_source(copy, form="hypersim").read(0, ["depth"])


def test_arrays_that_are_no_pictures_or_cameras_are_refused(root: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(root, copy)
    scene = copy / "scenes/ai_001_007"
    depth = scene / "images/scene_cam_00_geometry_hdf5/frame.0000.depth_meters.hdf5"
    write_array(depth, np.ones((HEIGHT, WIDTH, 3)))
    source = open_source(copy, form="hypersim")
    with pytest.raises(InputError, match=r"depth_meters\.hdf5: 'distance' has the shape"):
        source.read(0, ["depth"])
    write_array(scene / "_detail/cam_00/camera_keyframe_positions.hdf5", np.ones((2, 1)))
    with pytest.raises(InputError, match=r"cam_00: its arrays are no cameras"):
        open_source(copy, form="hypersim").read(1, ["depth"])


@pytest.mark.parametrize("kind", ["text", "group", "outside", "words"])
def test_foreign_files_stay_data(kind: str, tmp_path: Path) -> None:
    from orusd_hypersim.hdf5 import read_array

    path = tmp_path / "a.hdf5"
    if kind == "text":
        path.write_text("no HDF5")
    else:
        with h5py.File(path, "w") as file:
            if kind == "group":
                file.create_group("dataset")
            elif kind == "outside":
                file["dataset"] = h5py.ExternalLink("other.hdf5", "/dataset")
            else:
                file["dataset"] = "words"
    with pytest.raises(InputError):
        read_array(path)
