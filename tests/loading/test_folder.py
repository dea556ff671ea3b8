"""Views of renders and datasets: what is stored is what comes out, and mistakes are told."""

import importlib
import json
import pickle
import shutil
import sys
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.loading.opening import open_source
from openrooms_usd.loading.resizing import Resize
from openrooms_usd.loading.sample import Sample
from openrooms_usd.loading.transforms import Compose, Crop, HorizontalFlip
from openrooms_usd.rendering import exr


def stored(path: Path, layer: str) -> np.ndarray:
    """(height, width, parts) of a layer, by OpenImageIO alone."""
    buffer = OpenImageIO.ImageBuf(str(path))
    names = [n for n in buffer.spec().channelnames if n.rpartition(".")[0] == layer]
    order = sorted(names, key=lambda name: "RGBXYZ".find(name[-1]))
    pixels = buffer.get_pixels(OpenImageIO.FLOAT)
    return pixels[..., [buffer.spec().channelnames.index(name) for name in order]]


def test_a_render_is_read_as_it_is_stored(rendered: Path, sample: Sample) -> None:
    view = rendered / "view_0"
    manifest = json.loads((rendered / "manifest.json").read_text())
    entry = manifest["views"]["view_0"]
    assert (sample.name, sample.size) == ("view_0", (48, 36))
    np.testing.assert_array_equal(sample.K, entry["K"])
    np.testing.assert_array_equal(sample.world_from_camera, entry["world_from_camera"])
    for name in ("radiance", "depth", "normal"):
        np.testing.assert_array_equal(sample.images[name], stored(view / "channels.exr", name))
    labels = sample.images["instance"]
    assert labels.dtype == np.int64 and labels.shape == (36, 48, 1)
    np.testing.assert_array_equal(labels, stored(view / "channels.exr", "instance"))
    lamps = manifest["lights"]
    assert sample.light_numbers == tuple(range(len(lamps)))
    for number, lamp in enumerate(lamps):
        layer = stored(view / "lights.exr", f"direct_{number}")
        np.testing.assert_array_equal(sample.lights["direct_i"][number], layer)
        np.testing.assert_array_equal(sample.world_from_box[number], lamp["world_from_box"])
        np.testing.assert_array_equal(sample.box_size[number], lamp["size"])
    tiles = OpenImageIO.ImageBuf(str(view / "environment.exr")).get_pixels(OpenImageIO.FLOAT)
    grid = sample.grids["environment"]
    assert grid.shape == (9, 12, 16, 32, 3)
    np.testing.assert_array_equal(grid[3, 5], tiles[48:64, 160:192])


def test_a_dataset_is_chosen_from(dataset: Path) -> None:
    rows = [json.loads(line) for line in (dataset / "index.jsonl").read_text().splitlines()]
    whole = open_source(dataset)
    assert len(whole) == len(rows) == 8
    names = [whole.read(i, ["valid"]).name for i in range(8)]
    assert names == [row["unit"] for row in rows]
    train = open_source(dataset, split="train", variants=["mainDiffMat"], views=["view_1"])
    expected = [
        row
        for row in rows
        if row["split"] == "train" and row["unit"].endswith("mainDiffMat/view_1")
    ]
    assert len(train) == len(expected) == 1
    found = train.read(0, ["radiance", "depth"])
    assert found.about == {key: expected[0][key] for key in ("room", "variant", "split")}
    np.testing.assert_array_equal(found.K, expected[0]["K"])
    path = dataset / expected[0]["folder"] / "channels.exr"
    np.testing.assert_array_equal(found.images["radiance"], stored(path, "radiance"))
    again = pickle.loads(pickle.dumps(train))
    np.testing.assert_array_equal(again.read(0, ["depth"]).images["depth"], found.images["depth"])


def test_a_room_without_lights_has_none_of_each(tmp_path: Path) -> None:
    """They were asked for: that is not the same as a channel that was never rendered."""
    (tmp_path / "view_0").mkdir()
    depth = np.ones((6, 8, 1), np.float32)
    exr.write_channels(tmp_path / "view_0" / "channels.exr", {"depth": depth})
    manifest = {
        "generator": "openrooms_usd 0.1.0",
        "lights": [],
        "channels": {"depth": {}, "direct_i": {}, "mask_i": {}},
        "views": {
            "view_0": {
                "resolution": [8, 6],
                "K": [[9.0, 0, 4], [0, 9.0, 3], [0, 0, 1]],
                "world_from_camera": np.eye(4).tolist(),
                "files": {"channels": "view_0/channels.exr"},
                "channels": {"depth": {}},
            }
        },
    }
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    source = open_source(tmp_path)
    found = source.read(0, ("depth", "direct_i", "mask_i"))
    assert found.lights["direct_i"].shape == (0, 6, 8, 3)
    assert found.lights["mask_i"].shape == (0, 6, 8, 1)
    assert found.light_numbers == () and found.world_from_box.shape == (0, 4, 4)
    change = Compose([Crop(0, 0, 4, 4), HorizontalFlip(1.0), Resize(2, 2)])
    changed = change(found, np.random.default_rng(0))
    assert changed.lights["direct_i"].shape == (0, 2, 2, 3)
    with pytest.raises(InputError, match="has no channel 'visibility_i'"):
        source.read(0, ("visibility_i",))


def test_what_is_opened_again_is_read_again(rendered: Path, tmp_path: Path) -> None:
    """A render in the place of another one has its own camera, in the same process too."""
    shutil.copytree(rendered, tmp_path / "render")
    path = tmp_path / "render" / "manifest.json"
    before = open_source(tmp_path / "render").read(0, ("depth",))
    manifest = json.loads(path.read_text())
    manifest["views"]["view_0"]["K"][0][0] *= 2.0
    path.write_text(json.dumps(manifest))
    after = open_source(tmp_path / "render").read(0, ("depth",))
    assert after.K[0, 0] == 2.0 * before.K[0, 0]


def test_a_render_has_no_splits_to_choose_by(rendered: Path) -> None:
    assert len(open_source(rendered, views=["view_0"])) == 1
    with pytest.raises(InputError, match="no view is there of"):
        open_source(rendered, split="train")


def test_mistakes_are_told(dataset: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"neither index.jsonl nor .* nor manifest.json"):
        open_source(tmp_path)
    with pytest.raises(InputError, match="no source is named 'openroms'"):
        open_source(dataset, form="openroms")
    with pytest.raises(InputError, match="no view is there of"):
        open_source(dataset, split="test")
    source = open_source(dataset)
    with pytest.raises(InputError, match="no channel 'depht'"):
        source.read(0, ["depht"])
    with pytest.raises(InputError, match="has no channel 'normal'"):
        source.read(0, ["normal"])
    with pytest.raises(InputError, match="has no channel 'direct_i'"):
        source.read(0, ["direct_i"])
    with pytest.raises(InputError, match="has no channel 'environment'"):
        source.read(0, ["environment"])


@pytest.mark.parametrize(
    "line",
    ["[]", "{}", "nonsense", '{"folder": "../../x"}', '{"folder": "/etc/x"}', '{"folder": 3}'],
)
def test_an_index_leads_nowhere_else(line: str, dataset: Path, tmp_path: Path) -> None:
    first = json.loads((dataset / "index.jsonl").read_text().splitlines()[0])
    try:
        told = json.dumps({**first, **json.loads(line)}) if line.startswith('{"') else line
    except ValueError:
        told = line
    (tmp_path / "index.jsonl").write_text(told + "\n")
    with pytest.raises(InputError, match=r"index.jsonl:1: this is no line of an index"):
        open_source(tmp_path)


def test_a_damaged_view_is_told_by_its_path(dataset: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(dataset, copy)
    row = json.loads((copy / "index.jsonl").read_text().splitlines()[0])
    path = copy / row["folder"] / "channels.exr"
    path.write_bytes(path.read_bytes()[:300])
    with pytest.raises(InputError, match=r"view_0/channels.exr"):
        open_source(copy).read(0, ["depth"])


def test_batches_without_torch_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    for name in ("tensors", "training"):
        monkeypatch.delitem(sys.modules, f"openrooms_usd.loading.{name}", raising=False)
    with pytest.raises(MissingPackageError, match=r"pip install 'openrooms-usd\[torch\]'"):
        importlib.import_module("openrooms_usd.loading.training")
