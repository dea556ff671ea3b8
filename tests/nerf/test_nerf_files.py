"""What is written and what is refused: pictures under one exposure, folders of others, losses."""

import json
import shutil
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.errors import InputError, OutputError
from openrooms_usd.render import color
from openrooms_usd.render.datasets import DatasetOptions, DatasetSummary
from openrooms_usd.render.reading import RenderedScene, read_render
from orusd_nerf import NerfDataset
from tests.openrooms.synthetic import make_render, write_exr


def write(render: RenderedScene, root: Path, **options: object) -> DatasetSummary:
    return NerfDataset().write([render], root, DatasetOptions(**options))


def changed(folder: Path, name: str, change) -> RenderedScene:
    """A render whose manifest says otherwise of one view."""
    make_render(folder, views=2)
    manifest = json.loads((folder / "manifest.json").read_text())
    change(manifest["views"][name])
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return read_render(folder)


def files(root: Path) -> dict[str, bytes]:
    paths = (path for path in root.rglob("*") if path.is_file())
    return {path.relative_to(root).as_posix(): path.read_bytes() for path in paths}


def test_the_same_render_gives_the_same_bytes(render: RenderedScene, tmp_path: Path) -> None:
    for name in "ab":
        assert write(render, tmp_path / name).files == 13
    write(render, tmp_path / "a")
    assert files(tmp_path / "a") == files(tmp_path / "b")


def test_all_images_have_one_exposure(render: RenderedScene, dataset: Path) -> None:
    fitted = [color.fitted_exposure(view.pixels["radiance"]) for view in render.views.values()]
    assert max(fitted) > 1.001 * min(fitted)
    common = np.exp(np.mean(np.log(fitted)))
    for name, view in render.views.items():
        image = OpenImageIO.ImageBuf(str(dataset / f"images/{name}.png")).get_pixels("uint8")
        linear = color.film(view.pixels["radiance"] * common)
        expected = 255 * np.where(
            linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055
        )
        assert abs(image - expected).max() < 0.51


def test_what_a_render_lacks_is_told(tmp_path: Path) -> None:
    make_render(tmp_path / "day", views=1)
    write_exr(tmp_path / "day/view_0/channels.exr", {"roughness": np.ones((48, 64, 1))})
    summary = write(read_render(tmp_path / "day"), tmp_path / "data")
    assert set(summary.missing) == {"images", "depths", "points"}
    frame = json.loads((tmp_path / "data/transforms.json").read_text())["frames"][0]
    assert "depth_file_path" not in frame
    assert (tmp_path / "data/sparse/0/images.txt").read_text().endswith("view_0.png\n\n")


def test_what_is_too_far_away_has_no_depth_and_is_counted(tmp_path: Path) -> None:
    make_render(tmp_path / "day", views=1)
    depth = np.full((48, 64, 1), 2.0)
    depth[:2, :5] = 66.0
    write_exr(tmp_path / "day/view_0/channels.exr", {"depth": depth})
    summary = write(read_render(tmp_path / "day"), tmp_path / "data")
    assert any(note.startswith("10 pixels lie farther") for note in summary.notes)
    found = OpenImageIO.ImageBuf(str(tmp_path / "data/depths/view_0.png")).get_pixels("uint16")
    np.testing.assert_array_equal(found, np.where(depth > 60, 0, 2000))


def test_files_of_views_that_are_gone_go_too(render: RenderedScene, tmp_path: Path) -> None:
    write(render, tmp_path / "data")
    (tmp_path / "data/images/own.png").write_bytes(b"mine")
    write(make_render(tmp_path / "one", views=1), tmp_path / "data")
    names = sorted(path.name for path in (tmp_path / "data/images").iterdir())
    assert names == ["own.png", "view_0.png"]


@pytest.mark.parametrize("name", ["transforms.json", "images/1.png"])
def test_a_capture_of_somebody_else_is_not_replaced(
    name: str, render: RenderedScene, tmp_path: Path
) -> None:
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("theirs")
    with pytest.raises(OutputError, match="not of an earlier run"):
        write(render, tmp_path)
    assert files(tmp_path) == {name: b"theirs"}


def test_nothing_appears_when_something_fails(render: RenderedScene, tmp_path: Path) -> None:
    shutil.copytree(render.folder, tmp_path / "day")
    (tmp_path / "day/view_1/channels.exr").write_bytes(b"damaged")
    with pytest.raises(InputError):
        write(read_render(tmp_path / "day"), tmp_path / "data")
    assert not (tmp_path / "data").exists()


def test_several_renders_and_options_of_another_dataset_are_refused(
    render: RenderedScene, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match="2 renders"):
        NerfDataset().write([render, render], tmp_path / "data", DatasetOptions())
    with pytest.raises(InputError, match="are of OpenRooms"):
        write(render, tmp_path / "data", first=0)


def test_cameras_that_these_files_cannot_say_are_refused(tmp_path: Path) -> None:
    def skewed(view: dict) -> None:
        view["K"][0][1] = 0.5

    with pytest.raises(InputError, match="skewed"):
        write(changed(tmp_path / "day", "view_1", skewed), tmp_path / "data")
