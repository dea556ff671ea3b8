"""Shards of a small dataset, read by the package webdataset and by tarfile alone."""

import hashlib
import io
import json
import re
import tarfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenImageIO
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.rendering import exr
from openrooms_usd.rendering.datasets import DatasetOptions, FinishedRoom
from openrooms_usd.rendering.reading import read_render
from orusd_webdataset import WebDataset

# The package leaves the last shard open until it is collected.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]

VIEWS = ("view_0", "view_1", "view_2")
SPLITS = ("train", "val", "train", "test")


def write_render(folder: Path, seed: int, names: tuple[str, ...] = VIEWS) -> None:
    """A render of few pixels, as the manifest has them."""
    views = {}
    for number, name in enumerate(names):
        (folder / name).mkdir(parents=True)
        depth = np.random.default_rng([seed, number]).random((6, 8, 1)).astype(np.float32)
        exr.write_channels(folder / name / "channels.exr", {"depth": depth})
        np.save(folder / name / "environment_sg.npy", depth)
        (folder / name / "depth.png").write_bytes(b"a picture")
        views[name] = {
            "resolution": [8, 6],
            "K": [[9.0, 0, 4], [0, 9.0, 3], [0, 0, 1]],
            "world_from_camera": np.eye(4).tolist(),
            "files": {"channels": f"{name}/channels.exr"},
            "fits": {"files": {"environment_sg": f"{name}/environment_sg.npy"}},
            "channels": {"depth": {"preview": f"{name}/depth.png"}},
        }
    manifest = {
        "generator": "openrooms_usd 0.2.0",
        "format": 1,
        "views": views,
        "report": {"losses": []},
        "legend": {"semantic": {"1": "wall"}},
        "lights": [],
    }
    (folder / "manifest.json").write_text(json.dumps(manifest))


@pytest.fixture(scope="module")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> list[FinishedRoom]:
    folder = tmp_path_factory.mktemp("renders")
    found = []
    for number, split in enumerate(SPLITS):
        renders = {}
        for index, variant in enumerate(("main", "mainDiffMat")):
            write_render(folder / f"room_{number}" / variant, 10 * number + index)
            renders[variant] = read_render(folder / f"room_{number}" / variant)
        found.append(FinishedRoom(f"room_{number}", number, split, renders))  # type: ignore[arg-type]
    return found


def written(rooms: list[FinishedRoom], root: Path, **options: object) -> dict[str, str]:
    """Write shards; the checksum of each file but the ledger."""
    WebDataset().write_rooms(iter(rooms), root, DatasetOptions(**options))  # type: ignore[arg-type]
    files = sorted(p for p in root.rglob("*") if p.is_file() and not p.name.startswith("."))
    return {
        path.relative_to(root).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in files
    }


def samples(root: Path, split: str) -> Iterator[dict[str, object]]:
    webdataset = pytest.importorskip("webdataset")
    shards = sorted(str(path) for path in root.glob(f"{split}/*.tar"))
    return iter(webdataset.WebDataset(shards, shardshuffle=False).decode())


def test_webdataset_reads_every_view_once(rooms: list[FinishedRoom], tmp_path: Path) -> None:
    written(rooms, tmp_path)
    seen = {split: list(samples(tmp_path, split)) for split in ("train", "val", "test")}
    assert {split: len(found) for split, found in seen.items()} == {
        "train": 12,
        "val": 6,
        "test": 6,
    }
    for split, found in seen.items():
        keys = [str(sample["__key__"]) for sample in found]
        assert keys == sorted(set(keys))
        for sample in found:
            about = sample["json"]
            assert isinstance(about, dict) and about["split"] == split
            room = rooms[int(about["room"].rpartition("_")[2])]
            assert room.split == split
            view = room.renders[about["variant"]].views[about["view"]]
            assert about["K"] == view.K.tolist() and about["render"]["legend"]
            data = sample["channels.exr"]
            assert data == (view.folder / "channels.exr").read_bytes()
            # The package decodes what it knows.
            np.testing.assert_array_equal(
                sample["environment_sg.npy"], np.load(view.folder / "environment_sg.npy")
            )
            assert not any("png" in name for name in sample)


def test_what_a_shard_holds_opens_in_other_programs(
    rooms: list[FinishedRoom], tmp_path: Path
) -> None:
    written(rooms, tmp_path / "out")
    sample = next(samples(tmp_path / "out", "val"))
    data = sample["channels.exr"]
    assert isinstance(data, bytes)
    (tmp_path / "a.exr").write_bytes(data)
    pixels = OpenImageIO.ImageBuf(str(tmp_path / "a.exr")).get_pixels()
    expected = rooms[1].renders["main"].views["view_0"].pixels["depth"]
    np.testing.assert_array_equal(np.asarray(pixels).reshape(expected.shape), expected)


def test_headers_say_nothing_of_who_wrote_them(rooms: list[FinishedRoom], tmp_path: Path) -> None:
    first = written(rooms, tmp_path / "a")
    assert first == written(rooms, tmp_path / "b")
    with tarfile.open(tmp_path / "a/train/train-000000.tar") as file:
        members = file.getmembers()
    assert {(m.mtime, m.uid, m.gid, m.uname, m.gname) for m in members} == {(0, 0, 0, "", "")}
    assert [m.name for m in members] == sorted(m.name for m in members)


def test_shards_are_no_larger_than_asked(rooms: list[FinishedRoom], tmp_path: Path) -> None:
    big = io.BytesIO()
    np.save(big, np.random.default_rng(0).random(30_000))
    for room in rooms:
        for render in room.renders.values():
            for view in render.views.values():
                (view.folder / "big.npy").write_bytes(big.getvalue())
    wanted = {"files": ("big.npy",), "shard_mb": 1}
    written(rooms, tmp_path, **wanted)
    sizes = {
        path.relative_to(tmp_path).as_posix(): path.stat().st_size
        for path in tmp_path.rglob("*.tar")
    }
    listed = json.loads((tmp_path / "shards.json").read_text())
    assert {row["file"] for rows in listed.values() for row in rows} == {*sizes}
    assert all(size <= 1_000_000 for size in sizes.values())
    assert {row["file"]: row["bytes"] for rows in listed.values() for row in rows} == sizes
    # Four views of 240 kB have room in one.
    assert [row["samples"] for row in listed["train"]] == [4, 4, 4]
    # What is no shard any more goes.
    again = written(rooms, tmp_path, files=("channels.exr",))
    assert [*again] == [
        "shards.json",
        "test/test-000000.tar",
        "train/train-000000.tar",
        "val/val-000000.tar",
    ]


@pytest.mark.parametrize("name", ["light.exr", "../manifest.json", "/etc/hostname", ""])
def test_a_file_that_no_view_has_is_refused(
    name: str, rooms: list[FinishedRoom], tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=re.escape(f"no file {name!r}")):
        written(rooms, tmp_path, files=(name,))
    assert not list(tmp_path.rglob("*.tar"))


def test_views_of_any_names_have_a_key_each(tmp_path: Path) -> None:
    """Also where one is called as another one is counted."""
    names = ("hall", "kitchen", "view_1", "view_01")
    write_render(tmp_path / "render", 0, names)
    room = FinishedRoom("room", 0, "train", {"main": read_render(tmp_path / "render")})
    written([room], tmp_path / "out")
    found = list(samples(tmp_path / "out", "train"))
    assert sorted(sample["json"]["view"] for sample in found) == sorted(names)  # type: ignore[index]
    assert [sample["__key__"] for sample in found] == [f"0000000-main-000{n}" for n in range(4)]


def test_a_room_that_moves_to_another_split_leaves_the_first(
    rooms: list[FinishedRoom], tmp_path: Path
) -> None:
    written(rooms, tmp_path)
    moved = [replace(room, split="test") for room in rooms]
    assert [*written(moved, tmp_path)] == ["shards.json", "test/test-000000.tar"]
