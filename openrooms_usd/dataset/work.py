"""What a worker does: make the room of a job, open it once, and render its views one by one.

All of it can be done again at any moment, with the same bytes; what is finished stays. A view that
fails is reported, and the next one is started.
"""

import gc
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from openrooms_usd import atomic, claims, ledger
from openrooms_usd.channels import each
from openrooms_usd.composing import compose_room
from openrooms_usd.dataset.executor import Task, WorkerMessage
from openrooms_usd.dataset.plan import Job, code_of, job_of, view_name
from openrooms_usd.dataset.quality import assess
from openrooms_usd.dataset.scratch import Root, root_of, store_at
from openrooms_usd.dataset.shots import Shot, shot, shots_of
from openrooms_usd.dataset.status import channel_seconds, material_names, tally
from openrooms_usd.dataset.store import Store
from openrooms_usd.dataset.variants import coverage_of, realised
from openrooms_usd.description import Dataset
from openrooms_usd.errors import InputError, OrusdError
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.folder import OPENINGS_FOLDER
from openrooms_usd.rendering.manifest import by_light
from openrooms_usd.rendering.run import check_view, describe_view, write_openings, write_view
from openrooms_usd.rendering.sensors.recording import record_sensor
from openrooms_usd.rendering.storage import storing
from openrooms_usd.validation.licences import licences
from openrooms_usd.version import __version__

# What a worker tells of a view.
BEGUN: Final = "begun"
FINISHED: Final = "finished"
FAILED: Final = "failed"

ReportRow = tuple[str, Any, str]


def task_of(job: Job, dataset: Dataset, root: Root, threads: int) -> Task:
    """A job as plain data, with all that a worker must know.

    Args:
        job: The job; its views are those that are to be made.
        dataset: What it is of.
        root: Where the dataset lies.
        threads: How many threads it may use.
    """
    return {
        "job": job.as_dict(),
        "dataset": dataset.model_dump(mode="json", by_alias=True),
        "folder": str(dataset.folder.absolute()),
        "root": str(root.absolute()) if isinstance(root, Path) else root,
        "threads": threads,
        "code": code_of(dataset.rendering.renderer),
    }


def work(task: Task) -> Iterator[WorkerMessage]:
    """Make the views of a task.

    Yields:
        What becomes of each: it is begun, finished, or has failed for a reason.
    """
    job, left = job_of(task["job"]), list(task["job"]["views"])
    try:
        with ExitStack() as held:
            room = _OpenRoom.of(task, job, held)
            while left:
                yield {"event": BEGUN, "view": left[0]}
                yield room.attempt(left.pop(0))
            if room.store.remote is None:
                # All views that are finished by now, not these alone.
                views = tuple(range(room.dataset.views.units))
                room.store.write_manifest(replace(job, views=views))
    except Exception as error:
        # Where the room itself fails, none of its views can be made.
        yield from ({"event": FAILED, "view": view, "reason": reason_of(error)} for view in left)
    finally:
        # A room holds gigabytes; the next one shall find them free.
        gc.collect()


def reason_of(error: BaseException) -> dict[str, str]:
    """Why something failed, as plain data."""
    if isinstance(error, OrusdError):
        return {"code": error.code, "reason": str(error)}
    return {"code": "unexpected", "reason": f"{type(error).__name__}: {error}"}


@dataclass(frozen=True, eq=False)
class _OpenRoom:
    """A room that is made and opened, ready for its views.

    Attributes:
        job: The job.
        store: Where everything lies.
        opened: The opened room.
        dataset: What it is of.
        shots: From where they are seen.
        rows: What the report says of the room itself.
        materials: What pixels of each material are counted as, by its number.
        took: Seconds for what all views share, and how many threads there were.
    """

    job: Job
    store: Store
    opened: RenderContext
    dataset: Dataset
    shots: Sequence[Shot]
    rows: tuple[ReportRow, ...]
    materials: Mapping[int, str]
    took: Mapping[str, float]

    @classmethod
    def of(cls, task: Task, job: Job, held: ExitStack) -> "_OpenRoom":
        """Compose the room and open it; say what its views share.

        Args:
            task: The task.
            job: Its job.
            held: Takes the claim of the render's folder.
        """
        from openrooms_usd.rendering.opening import open_for_rendering
        from openrooms_usd.usd.files.diagnostics import quiet

        held.enter_context(quiet())
        store = held.enter_context(store_at(root_of(task["root"])))
        dataset = Dataset.model_validate(task["dataset"])
        if code_of(dataset.rendering.renderer) != task["code"]:
            raise InputError(
                "this machine has different code than the one that planned the dataset",
                place=f"openrooms_usd {__version__}",
                remedy="install the same version everywhere: records name the code by its digest",
            )
        folder, began = Path(task["folder"]), time.perf_counter()
        held.enter_context(claims.claimed(store.render(job), ledger.RENDER_FILE))
        described = realised(job, dataset.views, folder)
        base = described.folder or folder
        coverage = coverage_of(job, described, base, store.scene(job))
        made = compose_room(described, store.scene(job), base=base, workers=task["threads"])
        composed = time.perf_counter() - began
        opened = open_for_rendering(
            # Rooms that share a seed would share the pattern of their noise.
            made.scene,
            dataset.settings(job.seed),
            views=dataset.views.units,
            spares=True,
            flow=dataset.has_flow,
        )
        # Lights are worked out when they are first asked for; all views share them, too.
        assert opened.lights is not None
        shots = shots_of(dataset.views, opened)
        took = {"compose": composed, "translation": time.perf_counter() - began - composed}
        took["threads"] = task["threads"]
        rows = tuple(opened.report.rows)
        materials = material_names(opened.stage, opened.legend.material)
        room = cls(job, store, opened, dataset, shots, rows, materials, took)
        room._share({"type": described.room, "coverage": coverage})
        return room

    def _share(self, told: Mapping[str, Any]) -> None:
        """Write what all views share: what openings see, and the record of the scene."""
        folder, job = self.store.render(self.job), self.job
        if by_light(self.opened.listed):
            with atomic.replacing_files(folder) as beside:
                write_openings(beside, self.opened.lights)
        found = sorted({one.licence for one in licences(self.opened.stage)})
        record = {
            **told,
            "entry": self.opened.entry(),
            "report": self.opened.report.as_dict(),
            "licences": found,
            "files": self.store.digests(job, OPENINGS_FOLDER),
        }
        self.store.share(job, record)

    def attempt(self, view: int) -> WorkerMessage:
        """Make one view; what became of it."""
        try:
            self._make(view)
        except Exception as error:
            return {"event": FAILED, "view": view, "reason": reason_of(error)}
        return {"event": FINISHED, "view": view}

    def _make(self, number: int) -> None:
        """Render a view, write it whole, and then its record."""
        name, opened, store, job = view_name(number), self.opened, self.store, self.job
        taken, unit = shot(self.shots, number, job.room.name), f"{job.name}/{name}"
        # The report on one view does not enter another's record, whichever came first.
        opened.report.rows[:] = self.rows
        began = time.perf_counter()
        view = opened.shoot(taken.camera, taken.name, after=taken.after)
        rendered = time.perf_counter()
        request, lights, settings = opened.listed, opened.lights, opened.settings
        check_view(name, view, request, len(lights))
        with atomic.replacing_folder(store.render(job) / name) as beside:
            stored = storing(view, settings.storage)
            previews = write_view(beside, view, stored, settings.tone)
            shown = opened.photograph(taken.view) if taken.view else None
            entry = describe_view(beside, name, view, stored, previews, lights, shown)
            entry = {**entry, **taken.told}
            if sensor := self.dataset.sensor:
                entry = record_sensor(beside, name, view, sensor, entry, unit)
        told = [row for row in opened.report.rows if row not in self.rows]
        record = {
            "unit": unit,
            "room": job.room.name,
            "variant": job.variant,
            "split": job.room.split,
            "source": dict(job.room.source),
            "entry": entry,
            "rejected": [dict(one) for one in taken.rejected],
            "told": [{"prim": row[0], "outcome": row[1], "reason": row[2]} for row in told],
            "quality": assess(view, self.dataset.budget.error, each(request.channels, len(lights))),
            **tally(view, opened.legend.semantic, self.materials),
            "files": store.digests(job, name),
        }
        took = {"render": rendered - began, "output": time.perf_counter() - rendered}
        timing = {**self.took, **took, "channels": channel_seconds(view)}
        store.finish(job, number, record, timing)
