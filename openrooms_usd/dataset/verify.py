"""Is everything there as it was written? Every file of every finished view, by its checksum."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from openrooms_usd.dataset.plan import Job, view_name
from openrooms_usd.dataset.records import Record
from openrooms_usd.dataset.scratch import Root, fetch_all, fetched, store_at
from openrooms_usd.dataset.store import Store
from openrooms_usd.errors import InputError
from openrooms_usd.progress import Progress, silent
from openrooms_usd.rendering.folder import MANIFEST
from openrooms_usd.untrusted import read_text

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
        progress(job.name, number / max(1, total))
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
