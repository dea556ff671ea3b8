"""The story of a run: what is not finished is worked off, what fails is tried again, and told."""

import json
import os
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from openrooms_usd import adapters, atomic
from openrooms_usd.dataset import work
from openrooms_usd.dataset.executor import Crew, Executor, Lost, WorkerDemand, WorkerMessage
from openrooms_usd.dataset.outputs import rooms_of, write_outputs
from openrooms_usd.dataset.plan import Job, job_of, plan_jobs, view_name
from openrooms_usd.dataset.records import LEFT_OUT, Record
from openrooms_usd.dataset.scratch import Root, exclusive_store, fetch_known, fetch_unit
from openrooms_usd.dataset.store import Store, write_json, write_lines
from openrooms_usd.description import Dataset, load_dataset
from openrooms_usd.errors import OrusdError, OutputError
from openrooms_usd.progress import Counted, Progress, silent
from openrooms_usd.rendering.datasets import check_needs
from openrooms_usd.rendering.folder import MANIFEST
from openrooms_usd.untrusted import read_bytes
from openrooms_usd.urls import shown

INDEX: Final = "index.jsonl"
SPLITS: Final = "splits.json"
LICENCES: Final = "licences.json"
# Progress messages for views of paths, stereo cameras and photographs.
_OF_SHOTS: Final = ("frame", "stereo", "photograph")
LOCAL: Final = "local"
_CUDA: Final = "cuda"


@dataclass(frozen=True)
class RunSummary:
    """What a run did.

    Attributes:
        root: The dataset's folder.
        made: How many views it made.
        kept: How many were finished before.
        failed: Why views could not be made, by unit.
        notes: What is worth saying of the forms that were written besides.
    """

    root: Root
    made: int
    kept: int
    failed: dict[str, str]
    notes: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """The summary as plain data."""
        return {
            "root": str(self.root),
            "made": self.made,
            "kept": self.kept,
            "failed": self.failed,
            "notes": list(self.notes),
        }


def run_dataset(
    file: Path,
    root: Root,
    *,
    workers: int = 1,
    executor: str = LOCAL,
    options: Mapping[str, str] | None = None,
    progress: Progress = silent,
) -> RunSummary:
    """Make a dataset, or finish one: see `openrooms_usd.api.datasets.run_dataset`.

    Finished views stay, whichever run made them; run again after any interruption. The
    same file gives the same bytes with any number of workers.
    """
    dataset = load_dataset(file)
    hirer: Executor = adapters.load(adapters.EXECUTORS, executor)
    adapters.check_options(adapters.EXECUTORS, executor, hirer.options, options or {})
    check_wishes(dataset)
    with exclusive_store(root) as (store, check):
        _keep_file(store, file, dataset)
        # What is written at the end is known to be free at the beginning.
        atomic.check_free(store.root / name for name in (SPLITS, LICENCES, INDEX))
        run = _Run(root, store, dataset, progress, check)
        run.total = store.write_plan(plan_jobs(dataset))
        fetch_known(store)
        run.count()
        if run.kept < run.total:
            with hirer.hired(WorkerDemand(workers, _gpus(dataset), options or {})) as crew:
                run.work_off(crew)
        notes = finish(store, dataset, progress)
    return RunSummary(root, run.made, run.kept, run.failed, notes)


def _gpus(dataset: Dataset) -> int:
    """How many GPUs a worker computes on."""
    return int(dataset.rendering.options.get("variant") == _CUDA)


def check_wishes(dataset: Dataset) -> None:
    """Refuse what no room could give, before any is made.

    Raises:
        InputError: A channel, a renderer or a form of files is unknown.
    """
    from openrooms_usd.rendering.opening import check_settings
    from openrooms_usd.rendering.sensors.recording import check_sensor

    plan = check_settings(dataset.settings())
    if dataset.sensor:
        check_sensor(dataset.sensor, plan.asked)
    for output in dataset.outputs:
        check_needs(output.kind)


def _keep_file(store: Store, file: Path, dataset: Dataset) -> None:
    """Keep a copy of the file that the dataset is made by, for people."""
    data = read_bytes(file, "description")
    if os.path.lexists(store.file):
        known = read_bytes(store.file, "description")
        if known != data and load_dataset(store.file).name != dataset.name:
            raise OutputError(
                "this folder belongs to another dataset",
                place=shown(store.remote.url) if store.remote else store.file,
                remedy="choose another folder, or give the dataset its name",
            )
        if known == data:
            return
    atomic.write_bytes(store.file, data)
    store.put([store.file])


@dataclass
class _Run:
    """What is worked off, and what became of it."""

    root: Root
    store: Store
    dataset: Dataset
    progress: Progress
    check: Callable[[], None]
    made: int = 0
    kept: int = 0
    total: int = 0
    failed: dict[str, str] = field(default_factory=dict)

    def count(self) -> None:
        """See how much is finished already."""
        for job in self.store.jobs():
            self.kept += sum(self.store.is_finished(job, view) for view in job.views)

    def work_off(self, crew: Crew) -> None:
        """Try all views that are not finished, and again those that fail."""
        for _ in range(self.dataset.retries + 1):
            self.failed = {}
            waiting: Iterable[Job] = self._open()
            while waiting:
                # A worker that dies takes one view with it, and not those after it.
                waiting = list(self._run_jobs(crew, waiting))
            if not self.failed:
                return

    def _open(self) -> Iterator[Job]:
        """The jobs with views that are not finished, and with these alone."""
        for job in self.store.jobs():
            left = [view for view in job.views if not self._is_done_with(job, view)]
            if left:
                yield replace(job, views=tuple(left))

    def _is_done_with(self, job: Job, view: int) -> bool:
        """Whether a view is finished, or was left out on purpose."""
        if self.store.is_finished(job, view):
            return True
        failure = self.store.failure(job, view)
        return failure is not None and failure["code"] == LEFT_OUT

    def _run_jobs(self, crew: Crew, waiting: Iterable[Job]) -> Iterator[Job]:
        """Have jobs worked off.

        Yields:
            What is left of jobs whose workers died.
        """
        left: dict[str, list[int]] = {}
        begun: dict[str, int] = {}
        given = self.dataset, self.root, crew.threads
        tasks = (work.task_of(job, *given) for job in waiting)
        for task, told in crew.run(tasks, work.work):
            job = job_of(task["job"])
            views = left.setdefault(job.key, list(job.views))
            if isinstance(told, Lost):
                lost = begun.pop(job.key, None)
                # Before the first view is begun it is the room that kills its worker.
                for view in list(views) if lost is None else [lost]:
                    self._lose(job, view, told.reason, was_begun=lost is not None)
                    views.remove(view)
                if views:
                    yield replace(job, views=tuple(views))
                    views.clear()
            else:
                self._hear(job, told, views, begun)
            if not views:
                # Of a million jobs only those that are worked on are kept in mind.
                left.pop(job.key)

    def _lose(self, job: Job, view: int, reason: str, *, was_begun: bool) -> None:
        """Take note of a worker that died; what it had finished or told in this round stands."""
        if was_begun:
            fetch_unit(self.store, job, view)
        if self.store.is_finished(job, view):
            # Told already, unless it died between the record and the word of it.
            self.made += was_begun
            self._show(job, view)
        elif f"{job.name}/{view_name(view)}" not in self.failed:
            self._fail(job, view, {"code": "lost", "reason": reason})

    def _hear(self, job: Job, told: WorkerMessage, views: list[int], begun: dict[str, int]) -> None:
        self.check()
        view = int(told["view"])
        if told["event"] == work.BEGUN:
            begun[job.key] = view
            return
        begun.pop(job.key, None)
        views.remove(view)
        if told["event"] == work.FAILED:
            self._fail(job, view, dict(told["reason"]))
            return
        fetch_unit(self.store, job, view)
        self.made += 1
        self._show(job, view)

    def _fail(self, job: Job, view: int, reason: dict[str, str]) -> None:
        if reason["code"] != LEFT_OUT:
            self.failed[f"{job.name}/{view_name(view)}"] = reason["reason"]
        # A full disk takes no record either: then the run itself says it.
        with suppress(OrusdError, OSError):
            self.store.fail(job, view, {"unit": f"{job.name}/{view_name(view)}", **reason})
        self._show(job, view)

    def _show(self, job: Job, view: int) -> None:
        done = self.kept + self.made + len(self.failed)
        what = Counted(f"{job.name}/{view_name(view)}", done, self.total)
        self.progress(what, min(1.0, done / max(1, self.total)))


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
