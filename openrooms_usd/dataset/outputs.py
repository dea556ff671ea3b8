"""The forms in which finished rooms are written besides EXR and manifest.

What a form is written of, it says itself (`openrooms_usd.rendering.datasets`). Each writing leaves
a key of all that went into it, and is not repeated until that is other.
"""

import hashlib
import json
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any, Final

from openrooms_usd import adapters, removal
from openrooms_usd.codedigest import code_digest
from openrooms_usd.dataset.plan import Job, view_name
from openrooms_usd.dataset.scratch import fetched
from openrooms_usd.dataset.store import Store, write_json
from openrooms_usd.description import Dataset
from openrooms_usd.description.dataset import Output
from openrooms_usd.errors import InputError, OrusdError
from openrooms_usd.names import SCENE
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering.datasets import (
    DatasetOptions,
    DatasetSummary,
    DatasetWriter,
    FinishedRoom,
    RoomsWriter,
)
from openrooms_usd.rendering.reading import RenderedScene, read_render
from openrooms_usd.untrusted import read_text

OUTPUTS: Final = "outputs"

Row = dict[str, Any]


@dataclass(frozen=True)
class _Piece:
    """What is written of a form at once: a room, or all of them.

    Attributes:
        what: What it is called for people.
        done: Where it stands that it is written.
        key: What determines it.
        write: Writes it.
    """

    what: str
    done: Path
    key: str
    write: Callable[[], list[DatasetSummary]]

    @property
    def is_written(self) -> bool:
        """Whether it is written as it shall be."""
        with suppress(InputError, ValueError):
            if os.path.lexists(self.done):
                return bool(json.loads(read_text(self.done)).get("key") == self.key)
        return False


def write_outputs(
    store: Store, dataset: Dataset, row: Callable[[Row], Row], progress: Progress = silent
) -> Iterator[str]:
    """Write the forms that are asked for, unless they are written so already.

    Args:
        store: Where everything lies; the manifests are written.
        dataset: What it is.
        row: What the index says of a view, by its record.
        progress: Called with what is written and the finished fraction.

    Yields:
        Sentences for people: what could not be written, and why.
    """
    for output in dataset.outputs:
        progress(output.kind, 1.0)
        writer: Any = adapters.load(adapters.DATASETS, output.kind)

        def pieces(output: Output = output, writer: Any = writer) -> Iterator[_Piece]:
            if writer.takes == "rooms":
                return iter([_of_all(store, output, writer, row)])
            return _by_room(store, output, writer)

        with _whole(store, output, pieces):
            for piece in pieces():
                yield from _written(piece, output.kind)


def rooms_of(store: Store) -> Iterator[list[Job]]:
    """The jobs of each room, in the order of the plan."""
    for _, jobs in groupby(store.jobs(), key=lambda job: job.room.number):
        yield list(jobs)


@contextmanager
def _whole(store: Store, output: Output, pieces: Callable[[], Iterator[_Piece]]) -> Iterator[None]:
    """Behind a URL a form is written whole, or not at all: its rooms may share files.

    Here is room for all of it, and it stands that a room is written when everything is there.
    """
    folder = store.root / OUTPUTS / output.kind
    if store.remote is None:
        if not folder.is_dir():
            # It may have been removed: none of its rooms is written then.
            for piece in pieces():
                removal.remove_file(piece.done)
        yield
        return
    store.remote.get((store.name_of(piece.done) for piece in pieces()), store.root)
    if all(piece.is_written for piece in pieces()):
        yield
        return
    stale = [piece.done for piece in pieces() if os.path.lexists(piece.done)]
    for done in stale:
        removal.remove_file(done)
    yield
    # From here on it is neither the old one nor the new one, until the new one stands there.
    store.remote.remove(store.name_of(done) for done in stale)
    before = store.remote.names(f"{store.name_of(folder)}/")
    store.put([folder])
    store.remote.remove(name for name in before if not (store.root / name).is_file())
    store.put(piece.done for piece in pieces() if piece.done.is_file())
    removal.remove_tree(folder)


def _written(piece: _Piece, kind: str) -> Iterator[str]:
    """Write a piece unless it is written so already; what is to be said of that."""
    if piece.is_written:
        return
    try:
        summaries = piece.write()
    except OrusdError as error:
        remedy = f" ({error.remedy})" if error.remedy else ""
        yield f"{piece.what}: {error.message}{remedy}"
        return
    for summary in summaries:
        missing = (f"no {name}: {why}" for name, why in sorted(summary.missing.items()))
        yield from (f"{kind}: {note}" for note in (*missing, *summary.notes))
    write_json(piece.done, {"key": piece.key})


def _of_all(store: Store, output: Output, writer: RoomsWriter, row: Callable[[Row], Row]) -> _Piece:
    """All rooms in one form."""
    root = store.root / OUTPUTS / output.kind
    jobs = (job for jobs in rooms_of(store) for job in _finished(store, jobs))
    return _Piece(
        output.kind,
        store.root / "records" / f"{output.kind}.json",
        _key(store, output, jobs),
        lambda: [writer.write_rooms(_rooms(store, row), root, _options(output))],
    )


def _rooms(store: Store, row: Callable[[Row], Row]) -> Iterator[FinishedRoom]:
    """The finished rooms; each is available until the next one is requested."""
    for jobs in rooms_of(store):
        if found := _finished(store, jobs):
            with fetched(store, *found):
                yield _room(store, found, row)


def _room(store: Store, jobs: list[Job], row: Callable[[Row], Row]) -> FinishedRoom:
    room = jobs[0].room
    rows = {
        f"{job.variant}/{view_name(view)}": row(record) | _counts(record)
        for job in jobs
        for view, record in store.records(job)
    }
    renders = {job.variant: read_render(store.render(job)) for job in jobs}
    return FinishedRoom(room.name, room.number, room.split, renders, rows)


def _counts(record: Row) -> Row:
    """What a record counts of a view beside what the index says."""
    counts = {name: record.get(name) for name in ("pixels", "instances")}
    return counts | {"lights": len(record["entry"].get("lights", ()))}


def _by_room(store: Store, output: Output, writer: DatasetWriter) -> Iterator[_Piece]:
    """Each room in one form."""
    for jobs in rooms_of(store):
        found = _finished(store, jobs)
        if writer.takes == "variants":
            found = [job for job in found if job.variant in writer.called]
        if found:
            yield _of_room(store, output, writer, found)


def _of_room(store: Store, output: Output, writer: DatasetWriter, jobs: list[Job]) -> _Piece:
    def write() -> list[DatasetSummary]:
        with fetched(store, *jobs, scenes=output.scenes):
            return list(_forms(store, output, writer, jobs))

    name = jobs[0].room.name
    done = store.root / "records" / name / f"{output.kind}.json"
    return _Piece(f"{output.kind}: {name}", done, _key(store, output, jobs), write)


def _forms(
    store: Store, output: Output, writer: DatasetWriter, jobs: list[Job]
) -> Iterator[DatasetSummary]:
    root, options = store.root / OUTPUTS / output.kind, _options(output)
    renders = [read_render(store.render(job)) for job in jobs]
    if writer.takes == "render":
        for job, render in zip(jobs, renders, strict=True):
            yield writer.write([render], root / job.name, DatasetOptions())
        return
    options = replace(
        options,
        scene=f"scene{jobs[0].room.number:04d}_00",
        splits=tuple(writer.called[job.variant] for job in jobs),
        subset=jobs[0].room.split,
        stages=tuple(store.scene(job) / SCENE for job in jobs) if output.scenes else (),
    )
    yield writer.write(_shared_views(renders), root, options)


def _options(output: Output) -> DatasetOptions:
    return DatasetOptions(
        layout=output.layout,
        crowded=output.crowded,
        taxonomy=output.taxonomy,
        shard_mb=output.shard_mb,
        files=output.files,
    )


def _finished(store: Store, jobs: list[Job]) -> list[Job]:
    """Those of which a view is finished."""
    return [job for job in jobs if store.scene_record(job) and next(store.records(job), None)]


def _shared_views(renders: list[RenderedScene]) -> list[RenderedScene]:
    """The renders with the views that all of them have: variants of a scene share them."""
    names = [name for name in renders[0].views if all(name in one.views for one in renders)]
    if not names:
        raise InputError("no view is finished in all its variants", place=renders[0].folder)
    return [replace(one, views={name: one.views[name] for name in names}) for one in renders]


def _key(store: Store, output: Output, jobs: Iterable[Job]) -> str:
    """What determines a form: code, what is asked for, and the rooms with the files of all views.

    A room's number is part of what many forms call it: one that is put before it moves it on.
    """
    code = code_digest(adapters.find(adapters.DATASETS, output.kind).module)
    digest = hashlib.sha256(json.dumps([code, output.model_dump(mode="json")]).encode())
    for job in jobs:
        for _, record in store.records(job):
            told = [job.room.number, job.room.split, record["unit"], record["files"]]
            digest.update(json.dumps(told, sort_keys=True).encode())
    return digest.hexdigest()
