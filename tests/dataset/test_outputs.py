"""Forms of a whole dataset: written of what is finished, once, and again when that is other."""

import json
import shutil
import tarfile
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.dataset import outputs
from openrooms_usd.dataset.remote import RemoteFolder
from openrooms_usd.dataset.run import finish, run_dataset
from openrooms_usd.dataset.scratch import fetch_all, store_at
from openrooms_usd.dataset.store import Store
from openrooms_usd.description import load_dataset
from openrooms_usd.description.dataset import Dataset, Output
from openrooms_usd.errors import InputError, OutputError
from openrooms_usd.loading import open_source
from openrooms_usd.rendering.datasets import write_dataset
from openrooms_usd.rendering.reading import read_render
from tests.dataset.conftest import Checksums, Made

SENSOR = """\
sensor:
  distortion: {k1: -0.1}
  noise: {iso: 800}
  depth: {}
  seed: 1
"""
NAMES = {"sensor.exr", "sensor.png", "sensor_depth.exr", "sensor_depth.png"}
Finished = tuple[Store, Dataset]
CHANNELS = ("radiance", "depth", "instance", "valid")


@pytest.fixture
def finished(made: Made, tmp_path: Path) -> Finished:
    """A copy of a dataset that was made, one of whose rooms cannot be."""
    file, out = made
    shutil.copytree(out, tmp_path / "made")
    return Store(tmp_path / "made"), load_dataset(file)


def asking(dataset: Dataset, **output: object) -> Dataset:
    return dataset.model_copy(update={"outputs": (Output.model_validate(output),)})


def there(store: Store, tmp_path: Path) -> RemoteFolder:
    """A copy of a dataset behind a URL."""
    remote = RemoteFolder(f"memory://{tmp_path.name}")
    files = [store.name_of(path) for path in store.root.rglob("*") if path.is_file()]
    remote.put(store.root, [name for name in files if "/.orusd." not in f"/{name}"])
    return remote


def test_shards_have_every_finished_view(finished: Finished) -> None:
    store, dataset = finished
    wished = asking(dataset, **{"as": "webdataset"})
    assert finish(store, wished) == ()
    folder = store.root / "outputs/webdataset"
    listed = json.loads((folder / "shards.json").read_text())
    assert sum(row["samples"] for rows in listed.values() for row in rows) == 4
    # What trains on them sees what lies there as renders.
    shards, views = open_source(folder), open_source(store.root)
    found = {view.name: view for name in shards.names for view in shards.stream(name, CHANNELS)}
    assert len(found) == len(views) == 4
    for number in range(4):
        view = views.read(number, CHANNELS)
        assert found[view.name].about == view.about
        np.testing.assert_array_equal(found[view.name].K, view.K)
        for name in CHANNELS:
            np.testing.assert_array_equal(found[view.name].images[name], view.images[name])
    shard = folder / next(iter(listed.values()))[0]["file"]
    before = (shard.read_bytes(), shard.stat().st_mtime_ns)
    finish(store, wished)
    assert (shard.read_bytes(), shard.stat().st_mtime_ns) == before
    # What is asked for is other: so are the files.
    finish(store, asking(dataset, **{"as": "webdataset", "files": ["channels.exr"]}))
    assert shard.stat().st_size < len(before[0])


@pytest.mark.slow
def test_a_room_that_moves_on_is_written_by_its_new_number(finished: Finished) -> None:
    """As where another one is put before it: its views stay, what forms call it does not."""
    store, dataset = finished
    wished = asking(dataset, **{"as": "webdataset"})
    finish(store, wished)
    jobs = [
        replace(job, room=replace(job.room, number=job.room.number + 5)) for job in store.jobs()
    ]
    store.write_plan(jobs)
    finish(store, wished)
    (shard,) = (store.root / "outputs/webdataset").glob("*/*.tar")
    with tarfile.open(shard) as archive:
        assert {name.partition("-")[0] for name in archive.getnames()} == {"0000005"}


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["webdataset", "nerf"])
def test_a_form_that_somebody_removed_is_written_again(kind: str, finished: Finished) -> None:
    store, dataset = finished
    wished, home = asking(dataset, **{"as": kind}), store.root / "outputs" / kind
    finish(store, wished)
    files = sorted(path.relative_to(home) for path in home.rglob("*"))
    shutil.rmtree(home)
    finish(store, wished)
    assert sorted(path.relative_to(home) for path in home.rglob("*")) == files


def test_other_code_writes_a_form_anew(finished: Finished, monkeypatch: pytest.MonkeyPatch) -> None:
    store, dataset = finished
    wished, done = asking(dataset, **{"as": "coco"}), store.root / "records/coco.json"
    finish(store, wished)
    before = done.read_text()
    finish(store, wished)
    assert done.read_text() == before
    monkeypatch.setattr(outputs, "code_digest", lambda *modules: "other")
    (annotations,) = (store.root / "outputs/coco/annotations").iterdir()
    annotations.unlink()
    finish(store, wished)
    assert done.read_text() != before
    assert "images" in json.loads(annotations.read_text())


def test_behind_a_url_a_form_that_is_half_put_counts_as_none(
    finished: Finished, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also when what is asked for is later what it was before."""
    pytest.importorskip("fsspec")
    store, dataset = finished
    remote = there(store, tmp_path)
    first, other = (asking(dataset, **{"as": "webdataset", **how}) for how in ({}, {"shard_mb": 9}))
    put = Store.put

    def breaks(store: Store, paths: Iterable[Path]) -> None:
        listed = list(paths)
        put(store, listed)
        if any(path.name == "webdataset" for path in listed):
            raise OutputError("the line is cut")

    def written(wished: Dataset) -> None:
        with store_at(remote.url) as store:
            fetch_all(store)
            finish(store, wished)

    written(first)
    assert remote.read("records/webdataset.json")
    with monkeypatch.context() as patch, pytest.raises(OutputError, match="the line is cut"):
        patch.setattr(Store, "put", breaks)
        written(other)
    assert remote.read("records/webdataset.json") is None
    written(first)
    assert remote.read("records/webdataset.json")


@pytest.mark.slow
def test_behind_a_url_forms_have_the_composed_rooms_too(finished: Finished, tmp_path: Path) -> None:
    pytest.importorskip("fsspec")
    store, dataset = finished
    remote = there(store, tmp_path)
    wished = asking(dataset, **{"as": "openrooms", "scenes": True})
    notes = finish(store, wished)
    with store_at(remote.url) as far:
        fetch_all(far)
        assert finish(far, wished) == notes
    home = store.root / "outputs/openrooms"
    files = {
        p.relative_to(store.root).as_posix(): p.read_bytes()
        for p in home.rglob("*")
        if p.is_file() and not p.name.startswith(".orusd.")
    }
    assert any(name.endswith("main.xml") for name in files)
    assert {name: remote.read(name) for name in remote.names("outputs/openrooms/")} == files


def test_each_render_is_a_form_of_its_own(finished: Finished) -> None:
    store, dataset = finished
    assert finish(store, asking(dataset, **{"as": "nerf"})) == ()
    for variant in ("main", "mainDiffMat"):
        folder = store.root / "outputs/nerf/room_good" / variant
        frames = json.loads((folder / "transforms.json").read_text())["frames"]
        assert len(frames) == 2
        assert (folder / "sparse/0/cameras.txt").is_file()


def test_what_cannot_be_written_is_told(finished: Finished) -> None:
    store, dataset = finished
    notes = finish(store, asking(dataset, **{"as": "webdataset", "files": ["lights.exr"]}))
    assert len(notes) == 1 and "no file 'lights.exr'" in notes[0]
    assert not (store.root / "records/webdataset.json").exists()


def test_what_hinders_readers_is_told(finished: Finished) -> None:
    store, dataset = finished
    notes = finish(store, asking(dataset, **{"as": "openrooms", "layout": "merged"}))
    assert "openrooms: the released loaders expect pictures of 640x480" in notes
    assert any(note.startswith("openrooms: the field of view is") for note in notes)
    assert "openrooms: no imbaseColor: the render has no base_color" in notes


@pytest.mark.parametrize("crowded", ["leave-out", "keep"])
def test_a_room_whose_variants_share_no_view_is_told(finished: Finished, crowded: str) -> None:
    store, dataset = finished
    (store.root / "records/room_good/main/view_1.json").unlink()
    (store.root / "records/room_good/mainDiffMat/view_0.json").unlink()
    notes = finish(store, asking(dataset, **{"as": "openrooms", "crowded": crowded}))
    assert notes == ("openrooms: room_good: no view is finished in all its variants",)
    assert not (store.root / "outputs").exists()


def test_one_table_has_all_views(finished: Finished) -> None:
    parquet, duckdb = pytest.importorskip("pyarrow.parquet"), pytest.importorskip("duckdb")
    store, dataset = finished
    assert finish(store, asking(dataset, **{"as": "parquet"})) == ()
    path = store.root / "outputs/parquet/views.parquet"
    rows = parquet.read_table(path).to_pylist()
    index = [json.loads(line) for line in (store.root / "index.jsonl").read_text().splitlines()]
    assert [row["unit"] for row in rows] == [line["unit"] for line in index]
    for row, line in zip(rows, index, strict=True):
        assert row["K"] == [number for part in line["K"] for number in part]
        assert row["world_from_camera"] == [n for part in line["world_from_camera"] for n in part]
        assert dict(row["files"]) == line["files"] and row["split"] == line["split"]
        assert (row["width"], row["height"]) == (24, 18)
        view = read_render(store.root / line["folder"] / "..").views[f"view_{row['view']}"]
        shown = {*view.labels("instance").ravel().tolist()} - {0}
        assert row["instances"] == len(shown) > 0
    asked = f"select count(*), min(width), max(instances) from '{path}' where variant = 'main'"
    found = duckdb.sql(asked).fetchall()
    assert found == [(2, 24, max(r["instances"] for r in rows if r["variant"] == "main"))]
    before = path.read_bytes()
    (store.root / "records/parquet.json").unlink()
    finish(store, asking(dataset, **{"as": "parquet"}))
    assert path.read_bytes() == before


def test_renders_of_one_name_are_told_apart(made: Made, tmp_path: Path) -> None:
    renders = [tmp_path / name / "main" for name in ("a", "b")]
    for render in renders:
        shutil.copytree(made[1] / "renders/room_good/main", render)
    write_dataset(renders, tmp_path / "coco", kind="coco")
    found = json.loads((tmp_path / "coco/annotations/train.json").read_text())["images"]
    names = {image["file_name"] for image in found}
    assert len(names) == 4
    assert all((tmp_path / name).is_file() for name in names)
    with pytest.raises(InputError, match="given twice"):
        write_dataset([*renders, tmp_path / "a/../b/main"], tmp_path / "more", kind="coco")


# pycocotools' own code speaks of numpy 2.
@pytest.mark.filterwarnings("ignore:__array__ implementation")
def test_annotations_of_all_rooms_are_one_file_a_split(finished: Finished) -> None:
    coco = pytest.importorskip("pycocotools.coco")
    store, dataset = finished
    assert finish(store, asking(dataset, **{"as": "coco"})) == ()
    files = sorted((store.root / "outputs/coco/annotations").iterdir())
    assert [path.stem for path in files] == [*json.loads((store.root / "splits.json").read_text())]
    found = coco.COCO(str(files[0]))
    assert len(found.getImgIds()) == 4
    for image in found.loadImgs(found.getImgIds()):
        assert (store.root / image["file_name"]).is_file()
        view = read_render((store.root / image["file_name"]).parents[1]).views[
            Path(image["file_name"]).parts[-2]
        ]
        labels = view.labels("instance")
        for row in found.loadAnns(found.getAnnIds(imgIds=image["id"])):
            mask = found.annToMask(row).astype(bool)
            assert (mask == (labels == row["instance"])).all()
            word = found.loadCats(row["category_id"])[0]["name"]
            assert row["area"] == mask.sum() and word


@pytest.mark.slow
def test_no_file_of_the_truth_changes_by_a_bit(
    tmp_path: Path, write_source: Callable[[Path], Path], checksums: Checksums
) -> None:
    file = write_source(tmp_path / "source")
    text = (
        file.read_text()
        .replace(", poisoned/room.yaml", "")
        .replace("[main, mainDiffMat]", "[main]")
    )
    needed = "[radiance, depth, normal_geometric, base_color, roughness, metallic]"
    text = text.replace("[radiance, depth, instance, valid]", needed)
    found, entries = {}, {}
    for name, more in (("plain", ""), ("seen", SENSOR), ("again", SENSOR.replace("1\n", "2\n"))):
        file.write_text(text + more)
        assert run_dataset(file, tmp_path / name).made == 2
        renders = tmp_path / name / "renders"
        found[name] = checksums(renders)
        (manifest,) = renders.rglob("manifest.json")
        entries[name] = json.loads(manifest.read_text())["views"]
        del found[name][manifest.relative_to(renders).as_posix()]
    truth = found["plain"]
    assert {name: found["seen"][name] for name in truth} == truth
    added = found["seen"].keys() - truth.keys()
    assert {Path(name).name for name in added} == NAMES and len(added) == 2 * len(NAMES)
    # Another seed changes the noise and nothing else; no two views have the same.
    assert found["again"].keys() == found["seen"].keys()
    assert {name for name in truth if found["again"][name] != truth[name]} == set()
    assert all(found["again"][name] != found["seen"][name] for name in added)
    assert len({found["seen"][name] for name in added}) == len(added)
    for view, entry in entries["seen"].items():
        told = {**entry, "files": {k: v for k, v in entry["files"].items() if "sensor" not in k}}
        assert told.pop("sensor")["noise"]["iso"] == 800
        assert told == entries["plain"][view]
        assert {Path(v).name for k, v in entry["files"].items() if "sensor" in k} == NAMES
