"""What is written once the views are there: what is told of all rooms, and their other forms."""

import hashlib
import json
import os
from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import Any, Final

from openrooms_usd import adapters, removal
from openrooms_usd.dataset.plan import Job
from openrooms_usd.dataset.scratch import brought
from openrooms_usd.dataset.store import Store, write_json, write_lines
from openrooms_usd.description import Dataset
from openrooms_usd.description.dataset import Output
from openrooms_usd.errors import InputError, OrusdError
from openrooms_usd.names import SCENE
from openrooms_usd.progress import Progress, silent
from openrooms_usd.render.datasets import DatasetOptions, DatasetWriter
from openrooms_usd.render.folder import MANIFEST
from openrooms_usd.render.reading import RenderedScene, read_render
from openrooms_usd.untrusted import read_text

INDEX: Final = "index.jsonl"
SPLITS: Final = "splits.json"
LICENCES: Final = "licences.json"
OUTPUTS: Final = "outputs"
# Of all that one release calls its own, the names of variants; others have one render a folder.
_OPENROOMS: Final = "openrooms"
# What is told of views of paths, stereo cameras and photographs.
_OF_SHOTS: Final = ("frame", "stereo", "photograph")
_RELEASED: Final = {
    "main": "main_xml",
    "mainDiffMat": "mainDiffMat_xml",
    "mainDiffLight": "mainDiffLight_xml",
}


def finish(store: Store, dataset: Dataset, progress: Progress = silent) -> tuple[str, ...]:
    """Write the manifests, the index, the splits and the licences, and the forms asked for.

    All of it follows from the records: what is there already is written again with the same bytes.

    Args:
        store: Where everything lies.
        dataset: What it is.
        progress: Called with what is written and the finished fraction.

    Returns:
        Sentences for people: forms that rooms could not be written in, and why.

    Raises:
        OutputError: A file cannot be written.
    """
    splits: dict[str, list[str]] = defaultdict(list)
    licences: Counter[str] = Counter()
    for rooms in _rooms(store):
        found = [job for job in rooms if store.write_manifest(job)]
        if found:
            splits[found[0].room.split].append(found[0].room.name)
        licences.update(_licences(store, found))
    write_json(store.root / SPLITS, splits)
    write_json(store.root / LICENCES, {"rooms": licences})
    write_lines(store.root / INDEX, _index(store))
    store.put(store.render(job) / MANIFEST for job in store.jobs())
    store.put(path for path in store.root.iterdir() if path.is_file())
    notes = []
    for output in dataset.outputs:
        progress(output.kind, 1.0)
        with _whole(store, output):
            notes += [note for rooms in _rooms(store) for note in _write(store, output, rooms)]
    return tuple(dict.fromkeys(notes))


def _rooms(store: Store) -> Iterator[list[Job]]:
    """The jobs of each room."""
    for _, jobs in groupby(store.jobs(), key=lambda job: job.room.number):
        yield list(jobs)


def _licences(store: Store, jobs: list[Job]) -> set[str]:
    """The terms of all that went into a room."""
    found: set[str] = set()
    for job in jobs:
        record = store.scene_record(job)
        found |= set(record["licences"]) if record else set()
    return found


def _index(store: Store) -> Iterator[str]:
    """One line for each finished view: what it is, its camera, its errors and its checksums."""
    for job in store.jobs():
        for _, record in store.records(job):
            entry = record["entry"]
            row = {
                "unit": record["unit"],
                "room": record["room"],
                "variant": record["variant"],
                "split": record["split"],
                "source": record["source"],
                "folder": f"renders/{record['unit']}",
                "resolution": entry["resolution"],
                "K": entry["K"],
                "world_from_camera": entry["world_from_camera"],
                "errors": {
                    name: channel["estimated_robust_error"]
                    for name, channel in entry["channels"].items()
                    if channel["estimated_robust_error"]
                },
                "quality": record["quality"],
                "rejected": record["rejected"],
                **{name: entry[name] for name in _OF_SHOTS if name in entry},
                "files": {name: file["sha256"] for name, file in record["files"].items()},
            }
            yield json.dumps(row, sort_keys=True, ensure_ascii=False, allow_nan=False)


def _write(store: Store, output: Output, jobs: list[Job]) -> Iterator[str]:
    """Write a room in one form, unless it is written so already; what is to be said of that."""
    found = _shown(store, output, jobs)
    if not found:
        return
    done, key = _done(store, output, jobs), _key(store, output, found)
    if _is_written(done, key):
        return
    try:
        with brought(store, *found):
            summaries = list(_forms(store, output, found))
    except OrusdError as error:
        yield f"{output.kind}: {found[0].room.name}: {error.message}"
        return
    for missing in summaries:
        yield from (f"{output.kind}: no {name}: {why}" for name, why in sorted(missing.items()))
    write_json(done, {"key": key})


def _shown(store: Store, output: Output, jobs: list[Job]) -> list[Job]:
    """The jobs of a room that a form has."""
    found = [job for job in jobs if store.scene_record(job) and next(store.records(job), None)]
    return [job for job in found if output.kind != _OPENROOMS or job.variant in _RELEASED]


def _done(store: Store, output: Output, jobs: list[Job]) -> Path:
    """Where it stands that a room is written in one form."""
    return store.root / "records" / jobs[0].room.name / f"{output.kind}.json"


@contextmanager
def _whole(store: Store, output: Output) -> Iterator[None]:
    """Behind a URL a form is written whole, or not at all: its rooms may share files.

    Here is room for all of it, and it stands that a room is written when everything is there.
    """
    if store.shelf is None or _is_whole(store, output):
        yield
        return
    done = [_done(store, output, jobs) for jobs in _rooms(store)]
    for path in done:
        removal.remove_file(path)
    yield
    folder = store.root / OUTPUTS / output.kind
    before = store.shelf.names(f"{store.name_of(folder)}/")
    store.put([folder])
    store.shelf.remove(name for name in before if not (store.root / name).is_file())
    store.put(path for path in done if path.is_file())
    removal.remove_tree(folder)


def _is_whole(store: Store, output: Output) -> bool:
    """Whether all rooms are written in one form."""
    if store.shelf is not None:
        store.shelf.get((store.name_of(_done(store, output, r)) for r in _rooms(store)), store.root)
    return all(
        _is_written(_done(store, output, jobs), _key(store, output, found))
        for jobs in _rooms(store)
        if (found := _shown(store, output, jobs))
    )


def _forms(store: Store, output: Output, jobs: list[Job]) -> Iterator[dict[str, str]]:
    """Write a room: all its variants as one scene of OpenRooms, else each render by itself."""
    writer: DatasetWriter = adapters.load(adapters.DATASETS, output.kind)
    root = store.root / OUTPUTS / output.kind
    renders = [read_render(store.render(job)) for job in jobs]
    if output.kind != _OPENROOMS:
        for job, render in zip(jobs, renders, strict=True):
            yield writer.write([render], root / job.name, DatasetOptions()).missing
        return
    room = jobs[0].room
    options = DatasetOptions(
        scene=f"scene{room.number:04d}_00",
        splits=tuple(_RELEASED[job.variant] for job in jobs),
        subset=room.split,
        layout=output.layout,
        crowded=output.crowded,
        stages=tuple(store.scene(job) / SCENE for job in jobs) if output.scenes else (),
    )
    yield writer.write(_shared_views(renders), root, options).missing


def _shared_views(renders: list[RenderedScene]) -> list[RenderedScene]:
    """The renders with the views that all of them have: variants of a scene share them."""
    names = [name for name in renders[0].views if all(name in one.views for one in renders)]
    return [replace(one, views={name: one.views[name] for name in names}) for one in renders]


def _key(store: Store, output: Output, jobs: list[Job]) -> str:
    """What determines a form of a room: the files of its views, and what is asked for."""
    files = [record["files"] for job in jobs for _, record in store.records(job)]
    told: list[Any] = [output.model_dump(mode="json"), jobs[0].room.split, files]
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


def _is_written(path: Path, key: str) -> bool:
    with suppress(InputError, ValueError):
        if os.path.lexists(path):
            return bool(json.loads(read_text(path)).get("key") == key)
    return False
