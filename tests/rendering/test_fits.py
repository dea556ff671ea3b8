"""The files of fits, as those who read them expect."""

from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import OutputError
from openrooms_usd.geometry import spherical_harmonics
from openrooms_usd.rendering.fits import write_fits
from openrooms_usd.rendering.reading import RenderedView


def test_fits_are_read_back_as_the_view_gives_them(tmp_path: Path) -> None:
    grid = np.random.default_rng(0).random((2, 3, 16, 32, 3)).astype(np.float32)
    grid[1, 2] = 0.0
    entry = write_fits(tmp_path, grid, order=3)
    view = RenderedView("left", tmp_path, {})
    lobes, harmonics = view.fit("environment_sg"), view.fit("environment_sh")
    assert lobes is not None
    assert harmonics is not None
    assert (lobes.shape, lobes.dtype) == ((2, 3, 12, 6), np.float32)
    assert (harmonics.shape, harmonics.dtype) == ((2, 3, 16, 3), np.float32)
    assert not harmonics[1, 2].any()
    assert not lobes[1, 2, :, 3:].any()
    # The mean of all light is in the first harmonic: half of the sphere is lit, by 1/2.
    assert harmonics[0, 0, 0] == pytest.approx(np.sqrt(4 * np.pi) / 4, rel=0.1)
    assert np.sqrt(harmonics.shape[2]) == entry["environment_sh"]["order"] + 1
    assert 0.0 < entry["environment_sg"]["median_error"] < 1.0
    assert spherical_harmonics.irradiance(harmonics).shape == harmonics.shape


def test_where_nothing_is_seen_there_is_no_error_to_tell(tmp_path: Path) -> None:
    entry = write_fits(tmp_path, np.zeros((1, 2, 16, 32, 3), np.float32))
    assert entry["environment_sg"]["median_error"] is None
    assert not np.load(tmp_path / "environment_sg.npy")[..., 3:].any()


def test_equal_grids_give_equal_files_and_no_others(tmp_path: Path) -> None:
    grid = np.random.default_rng(4).random((2, 2, 16, 32, 3)).astype(np.float32)
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        assert write_fits(tmp_path / name, grid)["files"].keys() == {
            "environment_shading",
            "environment_sg",
            "environment_sh",
        }
    files = [{p.name: p.read_bytes() for p in (tmp_path / n).iterdir()} for n in ("a", "b")]
    assert files[0] == files[1]
    assert sorted(files[0]) == [
        "environment_sg.npy",
        "environment_sh.npy",
        "environment_shading.exr",
    ]


def test_a_folder_that_is_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        write_fits(tmp_path / "file", np.ones((1, 1, 16, 32, 3), np.float32))
