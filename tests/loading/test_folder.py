"""Views of renders, datasets and shards: what is stored comes out, and mistakes are told."""

import importlib
import io
import json
import pickle
import shutil
import sys
import tarfile
from collections import Counter
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.loading.opening import open_source
from openrooms_usd.loading.resizing import Resize
from openrooms_usd.loading.sample import Sample
from openrooms_usd.loading.transforms import Compose, Crop, HorizontalFlip
from openrooms_usd.rendering import exr
from tests.loading.test_remote import serving


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
        "generator": "openrooms_usd 0.2.0",
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
    with pytest.raises(InputError, match="there is no view of"):
        open_source(rendered, split="train")


def test_mistakes_are_told(dataset: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"neither index.jsonl nor .* nor manifest.json"):
        open_source(tmp_path)
    with pytest.raises(InputError, match="no source is named 'openroms'"):
        open_source(dataset, form="openroms")
    with pytest.raises(InputError, match="there is no view of"):
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
    with pytest.raises(InputError, match=r"index.jsonl:1: this is not a line of an index"):
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


CHANNELS = ("radiance", "position", "instance")
SHARE = 2


def add(archive: tarfile.TarFile, name: str, data: bytes) -> None:
    header = tarfile.TarInfo(name)
    header.size = len(data)
    archive.addfile(header, io.BytesIO(data))


@pytest.fixture(scope="session")
def shards(dataset: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The views of the dataset, two a shard, as docs/howto/webdataset.md has them."""
    root = tmp_path_factory.mktemp("shards")
    rows = [json.loads(line) for line in (dataset / "index.jsonl").read_text().splitlines()]
    listed: dict[str, list[dict[str, Any]]] = {}
    for split in ("train", "val"):
        (root / split).mkdir()
        own = [row for row in rows if row["split"] == split]
        for number, first in enumerate(range(0, len(own), SHARE)):
            name = f"{split}/{split}-{number:06d}.tar"
            views = own[first : first + SHARE]
            with tarfile.open(root / name, "w") as archive:
                for place, row in enumerate(views):
                    folder = dataset / row["folder"]
                    manifest = json.loads((folder.parent / "manifest.json").read_text())
                    entry = manifest.pop("views")[folder.name]
                    about = {key: row[key] for key in ("room", "variant", "split")}
                    told = {**about, "view": folder.name, "entry": entry, "render": manifest}
                    key = f"{number:07d}-{row['variant']}-{place:04d}"
                    exr = (folder / "channels.exr").read_bytes()
                    add(archive, f"{key}.channels.exr", exr)
                    add(archive, f"{key}.json", json.dumps(told).encode())
            listed.setdefault(split, []).append({"file": name, "samples": len(views)})
    (root / "shards.json").write_text(json.dumps(listed))
    return root


def test_shards_hold_the_views_of_the_dataset(shards: Path, dataset: Path) -> None:
    there, here = open_source(shards), open_source(dataset)
    assert len(there) == len(here) == 8 and len(there.names) == 4
    found = {s.name: s for name in there.names for s in there.stream(name, CHANNELS)}
    for index in range(len(here)):
        expected = here.read(index, CHANNELS)
        sample = found[expected.name]
        assert sample.about == expected.about
        np.testing.assert_array_equal(sample.K, expected.K)
        np.testing.assert_array_equal(sample.world_from_camera, expected.world_from_camera)
        for name in CHANNELS:
            np.testing.assert_array_equal(sample.images[name], expected.images[name])
    some = open_source(shards, split="val", variants=["main"])
    names = [s.name for name in some.names for s in some.stream(name, ("valid",))]
    assert len(names) == 2 and all("/main/" in name for name in names)


def test_shards_come_through_http(shards: Path, tmp_path: Path) -> None:
    pytest.importorskip("aiohttp")
    with serving(shards) as server:
        there = open_source(server.url, split="train", cache=tmp_path)
        views = [s.name for name in there.names for s in there.stream(name, ("valid",))]
    assert len(views) == 4


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_workers_and_replicas_share_the_shards(shards: Path, torch: ModuleType) -> None:
    """Together they have every view once, and each looks the same for any number of them."""
    from openrooms_usd.loading.training import loader

    source = open_source(shards)

    def seen(**how: Any) -> dict[str, Any]:
        views = loader(source, CHANNELS, HorizontalFlip(), seed=3, start="fork", **how)
        views.dataset.set_epoch(1)
        return {batch["name"][0]: batch for batch in views}

    alone = seen()
    assert len(alone) == 8
    two = [seen(rank=rank, replicas=2) for rank in range(2)]
    assert Counter(name for one in two for name in one) == Counter(list(alone))
    for shared in (*two, seen(workers=2)):
        for name, batch in shared.items():
            assert bool(batch["mirrored"]) == bool(alone[name]["mirrored"])
            torch.testing.assert_close(batch["radiance"], alone[name]["radiance"], rtol=0, atol=0)
    assert {bool(batch["mirrored"]) for batch in alone.values()} == {True, False}


def test_epochs_and_seeds_draw_another_order(shards: Path, torch: ModuleType) -> None:
    from openrooms_usd.loading.streaming import ViewStream

    def names(seed: int, epoch: int, **how: Any) -> list[str]:
        stream = ViewStream(open_source(shards), ("valid",), seed=seed, **how)
        stream.set_epoch(epoch)
        return [view["name"] for view in stream]

    assert names(1, 0) == names(1, 0)
    assert len({tuple(names(seed, epoch)) for seed in (1, 2) for epoch in (0, 1)}) == 4
    source = open_source(shards)
    stored = [s.name for name in source.names for s in source.stream(name, ("valid",))]
    assert names(1, 0, shuffle=1) == names(2, 5, shuffle=1) == stored
    with pytest.raises(InputError, match="no replica 2 of 2"):
        names(1, 0, rank=2, replicas=2)


def test_a_shard_that_ends_too_early_is_told(shards: Path, tmp_path: Path) -> None:
    """Also between two views, where a tar file without its end looks whole."""
    copy = tmp_path / "copy"
    shutil.copytree(shards, copy)
    source = open_source(copy)
    shard = copy / source.names[0]
    with tarfile.open(shard) as archive:
        second = archive.getmembers()[2].offset
    whole = shard.read_bytes()
    shard.write_bytes(whole[:second])
    with pytest.raises(InputError, match=r"holds 1 views, but shards\.json says 2"):
        list(source.stream(source.names[0], ("valid",)))
    shard.write_bytes(whole[: second + 700])
    with pytest.raises(InputError, match="a damaged shard"):
        list(source.stream(source.names[0], ("valid",)))


def test_nothing_nests_without_end(shards: Path, tmp_path: Path) -> None:
    """Neither lists in JSON nor headers of tar that another one follows."""
    longer = tarfile.TarInfo("a")
    longer.type, longer.size = tarfile.GNUTYPE_LONGNAME, 2
    block = longer.tobuf(tarfile.GNU_FORMAT) + b"a".ljust(512, b"\0")
    (tmp_path / "a.tar").write_bytes(block * 5000)
    (tmp_path / "shards.json").write_text('{"train": [{"file": "a.tar", "samples": 1}]}')
    with pytest.raises(InputError, match="a damaged shard"):
        list(open_source(tmp_path).stream("a.tar", ("depth",)))
    for name in ("shards.json", "index.jsonl"):
        (tmp_path / name).write_text("[" * 100_000)
        with pytest.raises(InputError, match="this is not a l"):
            open_source(tmp_path)


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("../../out.exr", b"x", "is not a file of a view"),
        ("0-main-0.json", b"[]", "not a view of a dataset"),
        ("0-main-0.json", b'{"room": 1}', "not a view of a dataset"),
        ("0-main-0.channels.exr", b"x", "not a view of a dataset"),
    ],
)
def test_hostile_shards_are_refused(name: str, data: bytes, said: str, tmp_path: Path) -> None:
    with tarfile.open(tmp_path / "a.tar", "w") as archive:
        add(archive, name, data)
    (tmp_path / "shards.json").write_text('{"train": [{"file": "a.tar", "samples": 1}]}')
    source = open_source(tmp_path)
    with pytest.raises(InputError, match=said):
        list(source.stream("a.tar", ("depth",)))
    (tmp_path / "a.tar").write_bytes(b"nonsense")
    with pytest.raises(InputError, match="a damaged shard"):
        list(source.stream("a.tar", ("depth",)))
    (tmp_path / "shards.json").write_text('{"train": [{"file": "../a.tar", "samples": 1}]}')
    with pytest.raises(InputError, match="leads elsewhere"):
        open_source(tmp_path)
