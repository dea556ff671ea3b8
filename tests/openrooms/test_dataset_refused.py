"""What makes no dataset: it is refused before anything appears; and the command that says so."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from openrooms_usd.cli import orusd
from openrooms_usd.errors import InputError, OrusdError
from openrooms_usd.render.reading import RenderedScene, RenderedView, read_render
from tests.openrooms.synthetic import make_render, write_exr
from tests.openrooms.synthetic import write_dataset as write

VARIANTS = ("main_xml", "mainDiffMat_xml", "mainDiffLight_xml")


def test_nothing_appears_when_something_fails(render: RenderedScene, tmp_path: Path) -> None:
    shutil.copytree(render.folder, tmp_path / "day")
    (tmp_path / "day/view_1/lights.exr").write_bytes(b"damaged")
    with pytest.raises(OrusdError):
        write([read_render(tmp_path / "day")], tmp_path / "data")
    assert not (tmp_path / "data").exists()


def test_variants_share_their_views(render: RenderedScene, tmp_path: Path) -> None:
    other = make_render(tmp_path / "other", views=1)
    with pytest.raises(InputError, match="its views are not those"):
        write([render, other], tmp_path / "data", splits=VARIANTS[:2])
    # The views of xml1 are others.
    write([render, other], tmp_path / "data", splits=("main_xml", "main_xml1"))
    assert (tmp_path / "data/scenes/xml1/scene0000_00/cam.txt").is_file()


@pytest.mark.parametrize("key", ["K", "world_from_camera", "resolution"])
def test_variants_share_their_cameras(key: str, render: RenderedScene, tmp_path: Path) -> None:
    entries = {name: view.entry for name, view in render.views.items()}
    changed = np.array(getattr(entries["view_1"], key))
    changed.flat[0] += 1
    entries["view_1"] = entries["view_1"].model_copy(update={key: changed.tolist()})
    views = {name: RenderedView(name, render.folder / name, entries[name]) for name in entries}
    other = RenderedScene(render.folder, render.manifest, views)
    with pytest.raises(InputError, match="its views are not those"):
        write([render, other], tmp_path / "data", splits=VARIANTS[:2])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"scene": "../scene0"}, "no name of a scene"),
        ({"scene": "room"}, "no name of a scene"),
        ({"splits": ("main",)}, "no split is named 'main'"),
        ({"splits": ("main_xml", "main_xml1")}, "1 renders and 2 splits"),
        ({"first": -1}, "cannot be number -1"),
    ],
)
def test_options_that_make_no_sense(
    options: dict[str, object], message: str, render: RenderedScene, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=message):
        write([render], tmp_path / "data", **options)
    assert not (tmp_path / "data").exists()


def test_a_damaged_light_is_named(render: RenderedScene, tmp_path: Path) -> None:
    shutil.copytree(render.folder, tmp_path / "day")
    manifest = json.loads((tmp_path / "day/manifest.json").read_text())
    del manifest["lights"][1]["size"]
    (tmp_path / "day/manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(InputError, match=r"manifest.json: lights\[1\].size: it is missing"):
        write([read_render(tmp_path / "day")], tmp_path / "data")


def test_the_command(render: RenderedScene, tmp_path: Path) -> None:
    out = tmp_path / "mask_data"
    arguments = ["dataset", "write", str(render.folder), "-o", str(out), "--layout", "merged"]
    done = CliRunner().invoke(orusd, arguments)
    assert done.exit_code == 0, done.output
    assert "of 2 views" in done.output
    assert "note: the released loaders expect pictures of 640x480" in done.output
    assert "holds 'mask', which the released loaders replace" in done.output
    done = CliRunner().invoke(orusd, [*arguments, "--json", "--scene", "scene0001_00"])
    assert json.loads(done.output)["frames"] == {"main_xml": [1, 2]}


def test_a_folder_that_is_no_render(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no finished render"):
        read_render(tmp_path)


def test_scenes_of_others_stay_in_the_lists_whatever_their_names(
    render: RenderedScene, tmp_path: Path
) -> None:
    (tmp_path / "train.txt").write_bytes(b"r\xe9sidence\n")
    write([render], tmp_path)
    assert (tmp_path / "train.txt").read_bytes() == b"r\xe9sidence\nscene0000_00\n"


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 3e38, -3e38])
def test_pixels_may_be_any_number(render: RenderedScene, tmp_path: Path, value: float) -> None:
    """All but labels: a renderer may find no number, and its manifest says where."""
    shutil.copytree(render.folder, tmp_path / "day")
    view = render.views["view_1"]
    kept = ("instance", "material", "semantic", "emission_mask")
    layers = {name: pixels.copy() for name, pixels in view.pixels.items()}
    for name in layers.keys() - {*kept}:
        layers[name][10:20, 30:40] = value
    write_exr(tmp_path / "day/view_1/channels.exr", layers)
    lights = {f"{name}_{n}": np.full_like(p, value) for name, of in view.lights.items()
              for n, p in of.items()}  # fmt: skip
    write_exr(tmp_path / "day/view_1/lights.exr", lights)
    write([read_render(tmp_path / "day")], tmp_path / "data")
    layers["semantic"][3, 3] = value
    write_exr(tmp_path / "day/view_1/channels.exr", layers)
    with pytest.raises(InputError, match="'semantic' holds what is no whole number"):
        write([read_render(tmp_path / "day")], tmp_path / "data")
