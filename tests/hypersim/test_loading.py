"""Views of Hypersim's layout load as what was written, each with its camera."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.loading import open_source
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
