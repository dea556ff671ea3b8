"""How far a dataset is: what is finished, what has failed and why, what is left."""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from openrooms_usd import names
from openrooms_usd.channels import CHANNELS, definition
from openrooms_usd.dataset.plan import Job, view_name
from openrooms_usd.dataset.records import LEFT_OUT, Record
from openrooms_usd.dataset.scratch import Root, fetch_all, fetched, store_at
from openrooms_usd.dataset.store import Store
from openrooms_usd.errors import InputError
from openrooms_usd.progress import Counted, Progress, silent
from openrooms_usd.rendering.contract import View
from openrooms_usd.rendering.folder import MANIFEST
from openrooms_usd.untrusted import read_text

if TYPE_CHECKING:
    from pxr import Usd


@dataclass(frozen=True)
class Failure:
    """A view that could not be made.

    Attributes:
        unit: Its name.
        code: What kind of error it was.
        reason: Why.
        attempts: How often it has been tried.
    """

    unit: str
    code: str
    reason: str
    attempts: int


@dataclass(frozen=True)
class Status:
    """How far a dataset is.

    Attributes:
        root: Its folder.
        units: How many views it shall have.
        finished: How many it has.
        failures: Those that could not be made.
        faults: How many finished views have each fault, by what is wrong with them.
        left_out: Why rooms were left out on purpose, by their name.
        rejected: The cameras in whose place others were taken, with what is wrong with their views.
        unwanted: How many views the rooms have that were left out.
    """

    root: Root
    units: int
    finished: int
    failures: tuple[Failure, ...] = ()
    faults: dict[str, int] = field(default_factory=dict)
    rejected: tuple[dict[str, Any], ...] = ()
    left_out: dict[str, str] = field(default_factory=dict)
    unwanted: int = 0

    @property
    def left(self) -> int:
        """How many views have not been tried, or not by this plan."""
        return self.units - self.finished - len(self.failures) - self.unwanted

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        return {
            "root": str(self.root),
            "units": self.units,
            "finished": self.finished,
            "failed": len(self.failures),
            "left": self.left,
            "failures": [vars(failure) for failure in self.failures],
            "faults": self.faults,
            "rejected": list(self.rejected),
            "left_out": self.left_out,
        }


def status_of(root: Root) -> Status:
    """Count what a dataset has.

    Args:
        root: Its folder, or a URL.

    Raises:
        InputError: There is no dataset.
    """
    with store_at(root) as store:
        fetch_all(store)
        return _counted(root, store)


def _counted(root: Root, store: Store) -> Status:
    units, finished = 0, 0
    failures: list[Failure] = []
    faults: Counter[str] = Counter()
    rejected: list[dict[str, Any]] = []
    left_out: dict[str, str] = {}
    unwanted = 0
    for job in store.jobs():
        for view in job.views:
            units += 1
            if record := store.record(job, view):
                finished += 1
                faults.update(record["quality"]["faults"])
                rejected += [{"unit": record["unit"], **row} for row in record["rejected"]]
            elif (found := store.failure(job, view)) and found["code"] == LEFT_OUT:
                left_out[job.room.name] = str(found["reason"])
                unwanted += 1
            elif found:
                failures.append(
                    Failure(
                        f"{job.name}/{view_name(view)}",
                        str(found["code"]),
                        str(found["reason"]),
                        int(found["attempts"]),
                    )
                )
    counted = dict(sorted(faults.items()))
    rest = tuple(rejected), left_out, unwanted
    return Status(root, units, finished, tuple(failures), counted, *rest)


# What a record tells of the pixels of a view, small enough for a million views.

DEPTH_STEP_M: Final = 0.25
"""The width of a bin of depths."""
DEPTH_BINS: Final = 41
"""How many there are; the last one takes all that is farther."""
OTHER: Final = "other"
"""How materials of unknown kind are counted."""


def material_names(stage: "Usd.Stage", paths: Mapping[int, str]) -> dict[int, str]:
    """What materials are counted as: ``substance/family``, as far as a stage says so.

    Args:
        stage: The composed stage.
        paths: The materials' prim paths by number.
    """
    return {number: _material_name(stage, path) for number, path in paths.items()}


def _material_name(stage: "Usd.Stage", path: str) -> str:
    prim = stage.GetPrimAtPath(path)
    said = (names.MATERIAL_CATEGORY, names.MATERIAL_FAMILY)
    found = [prim.GetAttribute(name).Get() for name in said if prim and prim.HasAttribute(name)]
    return "/".join(str(word) for word in found if word) or OTHER


def tally(view: View, classes: Mapping[int, str], materials: Mapping[int, str]) -> dict[str, Any]:
    """Counts of a view's pixels; empty where its channels do not tell.

    Args:
        view: What was rendered.
        classes: Names of OpenRooms' classes, by number.
        materials: As `material_names` gives them.

    Returns:
        ``pixels`` by class, how many ``instances``, ``materials`` by name, and ``depth``: how many
        lie in each bin of `DEPTH_STEP_M`, up to the last that has any.
    """
    return {
        "pixels": _labelled(view, "semantic", classes),
        "instances": _instances(view),
        "materials": _labelled(view, "material", materials),
        "depth": _depths(view),
    }


def channel_seconds(view: View) -> dict[str, float]:
    """Seconds of each channel, by its name in the table; those that share rays each count them."""
    seconds: dict[str, float] = {}
    for name, image in view.images.items():
        table = definition(name).name
        seconds[table] = max(seconds.get(table, 0.0), image.seconds)
    return {name: seconds[name] for name in CHANNELS if name in seconds}


def _labelled(view: View, channel: str, named: Mapping[int, str]) -> dict[str, int]:
    if channel not in view.images:
        return {}
    pixels = view.images[channel].pixels.astype(np.int64)
    numbers, counts = np.unique(pixels, return_counts=True)
    found: Counter[str] = Counter()
    for number, count in zip(numbers.tolist(), counts.tolist(), strict=True):
        if number in named:
            found[named[number]] += count
    return dict(sorted(found.items()))


def _instances(view: View) -> int | None:
    if "instance" not in view.images:
        return None
    return int(np.count_nonzero(np.unique(view.images["instance"].pixels)))


def _depths(view: View) -> list[int]:
    if "depth" not in view.images:
        return []
    depth = view.images["depth"].pixels
    bins = np.minimum(depth[depth > 0.0] / DEPTH_STEP_M, DEPTH_BINS - 1).astype(np.int64)
    return [int(count) for count in np.bincount(bins)]


# Is everything there as it was written? Every file of every finished view, by its checksum.

MISSING: Final = "missing"
CHANGED: Final = "changed"
EXTRA: Final = "no view has it"


@dataclass(frozen=True, order=True)
class Damage:
    """A file that is not as it was written.

    Attributes:
        file: Relative to the dataset's folder.
        what: Missing, changed, or one that nothing names.
    """

    file: str
    what: str


@dataclass(frozen=True)
class Verification:
    """What a look at all files found.

    Attributes:
        root: The dataset's folder.
        views: How many finished views were looked at.
        files: How many files.
        damages: Those that are not as they were written.
        unfinished: How many views of the plan are not finished.
    """

    root: Root
    views: int
    files: int
    damages: tuple[Damage, ...]
    unfinished: int

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        return {
            "root": str(self.root),
            "views": self.views,
            "files": self.files,
            "damages": [vars(damage) for damage in self.damages],
            "unfinished": self.unfinished,
        }


def verify(root: Root, progress: Progress = silent) -> Verification:
    """Compare all files of a dataset with their records.

    Args:
        root: Its folder, or a URL.
        progress: Called with each room and the finished fraction.

    Raises:
        InputError: There is no dataset.
    """
    with store_at(root) as store:
        fetch_all(store)
        return _verified(root, store, progress)


def _verified(root: Root, store: Store, progress: Progress) -> Verification:
    views = files = unfinished = 0
    damages: list[Damage] = []
    total = sum(1 for _ in store.jobs())
    for number, job in enumerate(store.jobs()):
        progress(Counted(job.name, number + 1, total), number / max(1, total))
        records = dict(store.records(job))
        unfinished += len(job.views) - len(records)
        if not records:
            continue
        views, files = views + len(records), files + sum(len(r["files"]) for r in records.values())
        with fetched(store, job):
            damages += _damages(store, job, records)
    return Verification(root, views, files, tuple(sorted(damages)), unfinished)


def _damages(store: Store, job: Job, records: Mapping[int, Record]) -> Iterator[Damage]:
    for view, record in records.items():
        yield from _compared(store, job, record["files"], view_name(view))
    shared = store.scene_record(job)
    yield from _compared(store, job, shared["files"]) if shared else [_no_record(job)]
    yield from _manifest(store, job)


def _compared(
    store: Store, job: Job, known: Mapping[str, Mapping[str, Any]], folder: str | None = None
) -> Iterator[Damage]:
    """What differs of files from their record, and what lies in their folder besides."""
    home = store.render(job).relative_to(store.root).as_posix()
    for name, said in known.items():
        try:
            found = store.digests(job, name)
        except InputError:
            found = {name: {}}
        if found.get(name) != said:
            yield Damage(f"{home}/{name}", CHANGED if found else MISSING)
    if folder is not None:
        there = (path for path in (store.render(job) / folder).rglob("*") if not path.is_dir())
        names = {path.relative_to(store.render(job)).as_posix() for path in there}
        yield from (Damage(f"{home}/{name}", EXTRA) for name in names - set(known))


def _manifest(store: Store, job: Job) -> Iterator[Damage]:
    path = store.render(job) / MANIFEST
    name = path.relative_to(store.root).as_posix()
    try:
        text = read_text(path, "annotations")
    except InputError:
        yield Damage(name, MISSING)
        return
    if text != store.manifest_text(job):
        yield Damage(name, CHANGED)


def _no_record(job: Job) -> Damage:
    return Damage(f"records/{job.name}/scene.json", MISSING)
