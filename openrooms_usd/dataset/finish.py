"""What is written once the views are there: what is told of all rooms, and their other forms."""

import json
from collections import Counter, defaultdict
from collections.abc import Iterator
from typing import Final

from openrooms_usd.dataset.outputs import rooms_of, write_outputs
from openrooms_usd.dataset.plan import Job
from openrooms_usd.dataset.records import Record
from openrooms_usd.dataset.store import Store, write_json, write_lines
from openrooms_usd.description import Dataset
from openrooms_usd.progress import Progress, silent
from openrooms_usd.render.folder import MANIFEST

INDEX: Final = "index.jsonl"
SPLITS: Final = "splits.json"
LICENCES: Final = "licences.json"
# What is told of views of paths, stereo cameras and photographs.
_OF_SHOTS: Final = ("frame", "stereo", "photograph")


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
    for rooms in rooms_of(store):
        found = [job for job in rooms if store.write_manifest(job)]
        if found:
            splits[found[0].room.split].append(found[0].room.name)
        licences.update(_licences(store, found))
    write_json(store.root / SPLITS, splits)
    write_json(store.root / LICENCES, {"rooms": licences})
    write_lines(store.root / INDEX, _index(store))
    store.put(store.render(job) / MANIFEST for job in store.jobs())
    store.put(path for path in store.root.iterdir() if path.is_file())
    return tuple(dict.fromkeys(write_outputs(store, dataset, _row, progress)))


def _licences(store: Store, jobs: list[Job]) -> set[str]:
    """The terms of all that went into a room."""
    found: set[str] = set()
    for job in jobs:
        record = store.scene_record(job)
        found |= set(record["licences"]) if record else set()
    return found


def _index(store: Store) -> Iterator[str]:
    """One line for each finished view."""
    for job in store.jobs():
        for _, record in store.records(job):
            yield json.dumps(_row(record), sort_keys=True, ensure_ascii=False, allow_nan=False)


def _row(record: Record) -> Record:
    """What the index says of a view: what it is, its camera, its errors and its checksums."""
    entry = record["entry"]
    return {
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
