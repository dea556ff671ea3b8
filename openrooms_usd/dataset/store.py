"""Where everything of a dataset lies, and the records of what is finished.

::

    dataset.yaml, plan.jsonl  the file that it was made by, and what follows from it
    scenes/ROOM/VARIANT/      the composed room
    renders/ROOM/VARIANT/     its render: manifest.json, and a folder for each view
    records/ROOM/VARIANT/     what is finished: scene.json, and VIEW.json with its checksums
    failures/ROOM/VARIANT/    VIEW.json: what could not be made, and why
    timing/ROOM/VARIANT/      VIEW.json: seconds; the only files that differ between equal runs

A record is written after all that it names: what has none is not finished, whatever lies there.
"""

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

from openrooms_usd import atomic, ledger, removal
from openrooms_usd.dataset.plan import Job, jobs_of, lines, view_name
from openrooms_usd.dataset.records import (
    SCENE,
    FailureRecord,
    Record,
    SceneRecord,
    TimingRecord,
    ViewRecord,
    read_record,
)
from openrooms_usd.dataset.remote import RemoteFolder
from openrooms_usd.errors import InputError, writing
from openrooms_usd.rendering.folder import MANIFEST
from openrooms_usd.untrusted import opened, read_text

FILE: Final = "dataset.yaml"
PLAN: Final = "plan.jsonl"
KNOWN: Final = ("records", "failures", "timing")
"""Where it stands what is known of units: in folders by room."""

# Lists of what may be removed again, and what one process keeps for others of this machine.
_OWN: Final = ".orusd."
_REMEDY: Final = "run it again: damaged parts are made again"


class Store:
    """The folder of a dataset.

    Args:
        root: The folder; where the dataset lies behind a URL, what of it is here.
        remote: What is behind the URL.
    """

    def __init__(self, root: Path, remote: RemoteFolder | None = None) -> None:
        self.root, self.remote = root, remote

    def name_of(self, path: Path) -> str:
        """What a path in the folder is called, with forward slashes."""
        return path.relative_to(self.root).as_posix()

    def put(self, paths: Iterable[Path]) -> None:
        """Put files, or all in folders but what only programs here need, behind the URL, if any.

        Raises:
            OutputError: It cannot be done.
        """
        if self.remote is not None:
            found = (f for path in paths for f in (path.rglob("*") if path.is_dir() else [path]))
            names = (self.name_of(path) for path in found if path.is_file())
            self.remote.put(self.root, (name for name in names if f"/{_OWN}" not in f"/{name}"))

    @property
    def file(self) -> Path:
        """The copy of the dataset.yaml."""
        return self.root / FILE

    def write_plan(self, jobs: Iterable[Job]) -> int:
        """Write the plan; how many units it has.

        Raises:
            InputError: A room of it is not there.
            OutputError: It cannot be written.
        """
        count = write_lines(self.root / PLAN, lines(jobs))
        self.put([self.root / PLAN])
        return count

    def share(self, job: Job, record: Record) -> None:
        """Say what the views of a job share: all that it names is there.

        Raises:
            OutputError: It cannot be said.
        """
        self.put([self.scene(job), self.render(job)])
        self._say(self.record_path(job, SCENE), {"key": job.key, **record})

    def jobs(self) -> Iterator[Job]:
        """The jobs of the plan.

        Raises:
            InputError: There is no plan, or it is damaged.
        """
        path = self.root / PLAN
        with opened(path, "frames", remedy="give the folder of a dataset") as stream:
            try:
                yield from jobs_of(line.decode() for line in stream)
            except (ValueError, KeyError, TypeError) as error:
                raise InputError(
                    f"this is not a plan: {error}", place=path, remedy=_REMEDY
                ) from error

    def scene(self, job: Job) -> Path:
        """The folder of a composed room."""
        return self.root / "scenes" / job.name

    def render(self, job: Job) -> Path:
        """The folder of a job's render."""
        return self.root / "renders" / job.name

    def record_path(self, job: Job, name: str) -> Path:
        """Where the record of a view lies, or that of the scene."""
        return self.root / "records" / job.name / f"{name}.json"

    def failure_path(self, job: Job, view: int) -> Path:
        """Where it stands why a view could not be made."""
        return self.root / "failures" / job.name / f"{view_name(view)}.json"

    def timing_path(self, job: Job, view: int) -> Path:
        """Where it stands how long a view took."""
        return self.root / "timing" / job.name / f"{view_name(view)}.json"

    def scene_record(self, job: Job) -> Record | None:
        """What the views of a job share; None where it is not written, or of another plan."""
        return read_record(self.record_path(job, SCENE), job.key, SceneRecord)

    def record(self, job: Job, view: int) -> Record | None:
        """The record of a finished view; None where it is not finished, or of another plan."""
        return read_record(self.record_path(job, view_name(view)), job.key, ViewRecord)

    def failure(self, job: Job, view: int) -> Record | None:
        """Why a view could not be made; None where nothing is known of that."""
        return read_record(self.failure_path(job, view), job.key, FailureRecord)

    def timing(self, job: Job, view: int) -> Record:
        """How long a view took; empty where nothing sound is known of that."""
        return read_record(self.timing_path(job, view), job.key, TimingRecord) or {}

    def is_finished(self, job: Job, view: int) -> bool:
        """Whether a view is finished."""
        return self.record(job, view) is not None

    def records(self, job: Job) -> Iterator[tuple[int, Record]]:
        """The finished views of a job."""
        for view in job.views:
            if record := self.record(job, view):
                yield view, record

    def finish(self, job: Job, view: int, record: Record, timing: Mapping[str, Any]) -> None:
        """Say that a view is finished: all that the record names is there.

        Raises:
            OutputError: It cannot be said.
        """
        self._put_view(job, view, record)
        self._say(self.timing_path(job, view), {"key": job.key, **timing})
        self._say(self.record_path(job, view_name(view)), {"key": job.key, **record})
        failure = self.failure_path(job, view)
        with writing(failure):
            removal.remove_file(failure)
        if self.remote is not None:
            self.remote.remove([self.name_of(failure)])

    def _put_view(self, job: Job, view: int, record: Record) -> None:
        """Put the files of a view behind the URL instead of what lies there; none stays here."""
        if self.remote is not None:
            folder = self.render(job) / view_name(view)
            before = self.remote.names(f"{self.name_of(folder)}/")
            self.put([folder])
            removal.remove_tree(folder)
            known = {f"{self.name_of(self.render(job))}/{name}" for name in record["files"]}
            self.remote.remove(name for name in before if name not in known)

    def _say(self, path: Path, data: Mapping[str, Any]) -> None:
        write_json(path, data)
        self.put([path])

    def fail(self, job: Job, view: int, reason: Record) -> int:
        """Say why a view could not be made; how often it has been tried by now.

        Raises:
            OutputError: It cannot be said.
        """
        before = self.failure(job, view) or {}
        attempts = int(before.get("attempts", 0)) + 1
        self._say(self.failure_path(job, view), {"key": job.key, "attempts": attempts, **reason})
        return attempts

    def digests(self, job: Job, *inner: str) -> dict[str, dict[str, Any]]:
        """Checksum and size of files of a render, or of all in its folders, by path.

        Args:
            job: The job.
            *inner: Paths in the folder of its render; what is not there has none.

        Raises:
            InputError: A file cannot be read.
        """
        folder = self.render(job)
        paths = [folder / name for name in inner]
        files = [f for path in paths for f in (path.rglob("*") if path.is_dir() else [path])]
        return {
            path.relative_to(folder).as_posix(): _digest(path)
            for path in sorted(files)
            if os.path.lexists(path) and not path.is_dir()
        }

    def write_manifest(self, job: Job) -> bool:
        """Write the manifest of a job's render: of all views that are finished.

        Returns:
            Whether there are any.

        Raises:
            OutputError: It cannot be written.
        """
        text = self.manifest_text(job)
        if text is not None:
            _write_where_other(self.render(job) / MANIFEST, text)
        return text is not None

    def manifest_text(self, job: Job) -> str | None:
        """The manifest of a job's render; None where no view is finished."""
        shared, views = self.scene_record(job), dict(self.records(job))
        if shared is None or not views:
            return None
        report = dict(shared["report"])
        told = [row for record in views.values() for row in record["told"]]
        report["losses"] = [*report["losses"], *told]
        report["approximated"] += len(told)
        entries = {view_name(view): record["entry"] for view, record in views.items()}
        return _text({**shared["entry"], "views": entries, "report": report})


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write data with sorted keys; the file appears whole or not at all."""
    atomic.write_text(path, _text(data))


def write_lines(path: Path, rows: Iterable[str]) -> int:
    """Write lines one by one; the file appears whole or not at all.

    Returns:
        How many.
    """
    count = 0
    with atomic.replacing(path) as beside, beside.open("w", encoding="utf-8", newline="\n") as file:
        for line in rows:
            file.write(f"{line}\n")
            count += 1
    return count


def _write_where_other(path: Path, text: str) -> None:
    """Write a file unless it says so already."""
    with suppress(InputError):
        if os.path.lexists(path) and read_text(path, "annotations") == text:
            return
    with ledger.kept(path.parent, ledger.RENDER_FILE):
        atomic.write_text(path, text)


def _text(data: Mapping[str, Any]) -> str:
    return json.dumps(data, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False) + "\n"


def _digest(path: Path) -> dict[str, Any]:
    with opened(path, "frames", remedy=_REMEDY) as stream:
        digest = hashlib.file_digest(stream, "sha256").hexdigest()
        return {"sha256": digest, "bytes": os.fstat(stream.fileno()).st_size}
