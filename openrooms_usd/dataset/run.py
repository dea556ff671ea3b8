"""The story of a run: what is not finished is worked off, what fails is tried again, and told."""

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from openrooms_usd import adapters, atomic, claims
from openrooms_usd.dataset import work
from openrooms_usd.dataset.executor import Executor, Lost, Task, Told
from openrooms_usd.dataset.finish import finish
from openrooms_usd.dataset.plan import Job, job_of, plan_jobs, view_name
from openrooms_usd.dataset.store import Store
from openrooms_usd.description import Dataset, load_dataset
from openrooms_usd.errors import OrusdError, OutputError
from openrooms_usd.progress import Progress, silent
from openrooms_usd.render.folder import check_writable
from openrooms_usd.untrusted import read_bytes

LOCAL: Final = "local"


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

    root: Path
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
    root: Path,
    *,
    workers: int = 1,
    executor: str = LOCAL,
    progress: Progress = silent,
) -> RunSummary:
    """Make a dataset, or what is left of it.

    What is finished stays, whoever made it; run again after whatever has ended a run before. The
    same file gives the same bytes with any number of workers.

    Args:
        file: The dataset.yaml.
        root: The dataset's folder.
        workers: How many rooms are worked on at once.
        executor: The name of who works them off.
        progress: Called with each view and the finished fraction.

    Returns:
        What was done.

    Raises:
        InputError: A file is missing, or a name is unknown.
        DescriptionError: The dataset.yaml has mistakes.
        OutputError: The folder cannot be written, or is that of another dataset.
    """
    dataset = load_dataset(file)
    crew: Executor = adapters.load(adapters.EXECUTORS, executor)
    check_wishes(dataset)
    check_writable(root)
    with claims.locked(root):
        store = Store(root)
        _keep_file(store, file)
        run = _Run(store, dataset, crew, max(1, workers), progress)
        run.total = store.write_plan(plan_jobs(dataset))
        run.count()
        for _ in range(dataset.retries + 1):
            run.work_off()
            if not run.failed:
                break
        notes = finish(store, dataset, progress)
    return RunSummary(root, run.made, run.kept, run.failed, notes)


def check_wishes(dataset: Dataset) -> None:
    """Refuse what no room could give, before any is made.

    Raises:
        InputError: A channel, a renderer or a form of files is unknown.
    """
    from openrooms_usd.render.job import RenderJob

    light = dataset.rendering
    RenderJob.of(
        channels=dataset.channels,
        renderer=light.renderer,
        options=light.options,
        method=light.method,
        denoise=light.denoise,
    )
    for output in dataset.outputs:
        adapters.find(adapters.DATASETS, output.kind)


def _keep_file(store: Store, file: Path) -> None:
    """Keep a copy of the file that the dataset is made by, for people."""
    data = read_bytes(file, "description")
    if os.path.lexists(store.file):
        known = read_bytes(store.file, "description")
        if known != data and load_dataset(store.file).name != load_dataset(file).name:
            raise OutputError(
                "this is the folder of another dataset",
                place=store.file,
                remedy="choose another folder, or give the dataset its name",
            )
        if known == data:
            return
    atomic.write_bytes(store.file, data)


@dataclass
class _Run:
    """What is worked off, and what became of it."""

    store: Store
    dataset: Dataset
    crew: Executor
    workers: int
    progress: Progress
    made: int = 0
    kept: int = 0
    total: int = 0
    failed: dict[str, str] = field(default_factory=dict)

    def count(self) -> None:
        """See how much is finished already."""
        for job in self.store.jobs():
            self.kept += sum(self.store.is_finished(job, view) for view in job.views)

    def work_off(self) -> None:
        """Try all views that are not finished, once."""
        self.failed = {}
        waiting: Iterable[Task] = self._open()
        while True:
            # A worker that dies takes one view with it, and not those after it.
            waiting = list(self._worked(waiting))
            if not waiting:
                return

    def _open(self) -> Iterator[Task]:
        """The jobs with views that are not finished."""
        for job in self.store.jobs():
            left = [view for view in job.views if not self.store.is_finished(job, view)]
            if left:
                yield self._task(job, left)

    def _task(self, job: Job, views: Iterable[int]) -> Task:
        threads = max(1, (os.cpu_count() or 1) // self.workers)
        part = replace(job, views=tuple(views))
        return work.task_of(part, self.dataset, self.store.root, threads)

    def _worked(self, waiting: Iterable[Task]) -> Iterator[Task]:
        """Have tasks worked off.

        Yields:
            What is left of tasks whose workers died.
        """
        left: dict[str, list[int]] = {}
        begun: dict[str, int] = {}
        for task, told in self.crew.run(waiting, work.work, self.workers):
            job = job_of(task["job"])
            views = left.setdefault(job.key, list(job.views))
            if isinstance(told, Lost):
                lost = begun.pop(job.key, None)
                reason = {"code": "lost", "reason": told.reason}
                # Before the first view is begun it is the room that kills its worker.
                for view in list(views) if lost is None else [lost]:
                    self._fail(job, view, reason)
                    views.remove(view)
                if views:
                    yield self._task(job, left.pop(job.key))
                continue
            self._hear(job, told, views, begun)

    def _hear(self, job: Job, told: Told, views: list[int], begun: dict[str, int]) -> None:
        view = int(told["view"])
        if told["event"] == work.BEGUN:
            begun[job.key] = view
            return
        begun.pop(job.key, None)
        views.remove(view)
        if told["event"] == work.FAILED:
            self._fail(job, view, dict(told["reason"]))
            return
        self.made += 1
        self._show(job, view)

    def _fail(self, job: Job, view: int, reason: dict[str, str]) -> None:
        self.failed[f"{job.name}/{view_name(view)}"] = reason["reason"]
        # A full disk takes no record either: then the run itself says it.
        with suppress(OrusdError, OSError):
            self.store.fail(job, view, {"unit": f"{job.name}/{view_name(view)}", **reason})
        self._show(job, view)

    def _show(self, job: Job, view: int) -> None:
        done = self.kept + self.made + len(self.failed)
        self.progress(f"{job.name}/{view_name(view)}", min(1.0, done / max(1, self.total)))
