"""Shards of views: the views that are in them, whoever reads how many of them at once."""

import io
import json
import shutil
import tarfile
from collections import Counter
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.loading.opening import open_source
from openrooms_usd.loading.transforms import HorizontalFlip
from tests.loading.test_remote import serving

CHANNELS = ("radiance", "position", "instance")
SHARE = 2


def add(archive: tarfile.TarFile, name: str, data: bytes) -> None:
    header = tarfile.TarInfo(name)
    header.size = len(data)
    archive.addfile(header, io.BytesIO(data))


@pytest.fixture(scope="session")
def shards(dataset: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The views of the dataset, two a shard, as docs/webdataset.md has them."""
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
    with pytest.raises(InputError, match=r"holds 1 views, shards\.json says 2"):
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
        with pytest.raises(InputError, match="this is no l"):
            open_source(tmp_path)


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("../../out.exr", b"x", "is no file of a view"),
        ("0-main-0.json", b"[]", "no view of a dataset"),
        ("0-main-0.json", b'{"room": 1}', "no view of a dataset"),
        ("0-main-0.channels.exr", b"x", "no view of a dataset"),
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
