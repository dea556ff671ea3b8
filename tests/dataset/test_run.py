"""The story of a run, told by an executor that only pretends, and the records it leaves."""

import errno
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar

import pytest

from openrooms_usd import adapters, atomic
from openrooms_usd.dataset import run
from openrooms_usd.dataset.executor import Lost, Task, WorkerDemand
from openrooms_usd.dataset.plan import Job, PlannedRoom, job_of
from openrooms_usd.dataset.records import SCENE
from openrooms_usd.dataset.status import CHANGED, EXTRA, MISSING, Damage, status_of, verify
from openrooms_usd.dataset.store import Store, write_json
from openrooms_usd.dataset.work import BEGUN, FAILED, FINISHED
from openrooms_usd.errors import InputError, OutputError

Fate = Callable[[str, int], str]
Pretend = Callable[[Fate], "Pretending"]


class Pretending:
    """Finishes what its fate lets it; counts how often each view was begun."""

    options: ClassVar[dict[str, str]] = {}
    threads = 1

    def __init__(self, fate: Fate) -> None:
        self.fate = fate
        self.begun: Counter[str] = Counter()

    @contextmanager
    def hired(self, wanted: WorkerDemand) -> Iterator["Pretending"]:
        yield self

    def run(self, tasks: Iterable[Task], work: Any) -> Iterator[tuple[Task, Any]]:
        for task in tasks:
            yield from ((task, told) for told in self._told(task))

    def _told(self, task: Task) -> Iterator[Any]:
        job, store = job_of(task["job"]), Store(Path(task["root"]))
        if self.fate(job.name, -1) == "dies":
            yield Lost("the worker died")
            return
        share(store, job)
        for view in job.views:
            unit = f"{job.name}/{view}"
            self.begun[unit] += 1
            fate = self.fate(job.name, view)
            yield {"event": BEGUN, "view": view}
            if fate == "dies":
                yield Lost("the worker died")
                return
            if fate == "fails":
                reason = {"code": "render", "reason": "no light"}
                yield {"event": FAILED, "view": view, "reason": reason}
                continue
            finish(store, job, view)
            if fate == "dies before it says so":
                yield Lost("the worker died")
                return
            yield {"event": FINISHED, "view": view}
        if self.fate(job.name, -1) == "dies at the end":
            yield Lost("the worker died")


def share(store: Store, job: Job) -> None:
    report = {"approximated": 0, "losses": []}
    record = {"key": job.key, "entry": {}, "report": report, "licences": ["CC0"], "files": {}}
    write_json(store.record_path(job, SCENE), record)


def finish(store: Store, job: Job, view: int) -> None:
    entry = {"resolution": [1, 1], "K": [], "world_from_camera": [], "channels": {}}
    record = {
        "unit": f"{job.name}/view_{view}",
        "room": job.room.name,
        "variant": job.variant,
        "split": job.room.split,
        "source": {},
        "entry": entry,
        "told": [],
        "quality": {"measures": {}, "faults": []},
        "rejected": [],
        "pixels": {},
        "files": {},
    }
    store.finish(job, view, record, {})


@pytest.fixture
def pretend(monkeypatch: pytest.MonkeyPatch) -> Pretend:
    def install(fate: Fate) -> Pretending:
        crew, load = Pretending(fate), adapters.load
        monkeypatch.setattr(
            adapters, "load", lambda g, n: crew if g == adapters.EXECUTORS else load(g, n)
        )
        return crew

    return install


GOOD, BAD = "room_good/main", "room_poisoned/main"


@pytest.mark.parametrize(("fate", "reason"), [("fails", "no light"), ("dies", "the worker died")])
def test_what_fails_or_dies_is_recorded_and_the_rest_goes_on(
    fate: str, reason: str, source: Path, tmp_path: Path, pretend: Pretend
) -> None:
    crew = pretend(lambda job, view: fate if (job, view) == (GOOD, 0) else "")
    done = run.run_dataset(source, tmp_path / "out")
    assert done.failed == {f"{GOOD}/view_0": reason}
    assert (done.made, done.kept) == (7, 0)
    assert set(crew.begun.values()) == {1}


@pytest.mark.parametrize("name", [run.SPLITS, run.LICENCES, run.INDEX])
def test_what_would_be_replaced_at_the_end_is_refused_at_the_beginning(
    name: str, source: Path, tmp_path: Path, pretend: Pretend
) -> None:
    crew = pretend(lambda job, view: "")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / name).write_text("mine")
    with pytest.raises(OutputError, match=name):
        run.run_dataset(source, tmp_path / "out")
    assert not crew.begun and (tmp_path / "out" / name).read_text() == "mine"


def test_what_fails_is_tried_so_often(source: Path, tmp_path: Path, pretend: Pretend) -> None:
    source.write_text(source.read_text().replace("retries: 0", "retries: 3"))
    tries: Counter[int] = Counter()

    def fate(job: str, view: int) -> str:
        tries[view] += (job, view) == (GOOD, 1)
        soon = tries[1] < 3 and (job, view) == (GOOD, 1)
        return "fails" if (job, view) == (GOOD, 0) or soon else ""

    crew = pretend(fate)
    done = run.run_dataset(source, tmp_path / "out")
    assert done.failed == {f"{GOOD}/view_0": "no light"}
    assert crew.begun[f"{GOOD}/0"] == 4
    assert crew.begun[f"{GOOD}/1"] == 3
    assert crew.begun[f"{BAD}/0"] == 1
    again = run.run_dataset(source, tmp_path / "out")
    assert (again.made, again.kept) == (0, 7)


def test_a_room_that_kills_its_worker_takes_its_views_alone(
    source: Path, tmp_path: Path, pretend: Pretend
) -> None:
    pretend(lambda job, view: "dies" if job == GOOD and view < 0 else "")
    done = run.run_dataset(source, tmp_path / "out")
    assert sorted(done.failed) == [f"{GOOD}/view_0", f"{GOOD}/view_1"]
    assert done.made == 6


@pytest.mark.parametrize(("view", "fate"), [(0, "dies before it says so"), (-1, "dies at the end")])
def test_what_a_dead_worker_had_finished_is_finished(
    view: int, fate: str, source: Path, tmp_path: Path, pretend: Pretend
) -> None:
    crew = pretend(lambda job, at: fate if (job, at) == (GOOD, view) else "")
    done = run.run_dataset(source, tmp_path / "out")
    assert (done.failed, done.made) == ({}, 8)
    assert set(crew.begun.values()) == {1}
    assert not list((tmp_path / "out").glob("failures/**/*.json"))


def test_what_has_failed_is_not_lost_besides(
    source: Path, tmp_path: Path, pretend: Pretend
) -> None:
    fates = {(GOOD, 1): "fails", (GOOD, -1): "dies at the end"}
    pretend(lambda job, view: fates.get((job, view), ""))
    done = run.run_dataset(source, tmp_path / "out")
    assert (done.failed, done.made) == ({f"{GOOD}/view_1": "no light"}, 7)
    (failure,) = status_of(tmp_path / "out").failures
    assert (failure.reason, failure.attempts) == ("no light", 1)


def test_a_disk_that_takes_no_record_of_a_failure_stops_nothing(
    source: Path, tmp_path: Path, pretend: Pretend, monkeypatch: pytest.MonkeyPatch
) -> None:
    pretend(lambda job, view: "fails" if (job, view) == (GOOD, 0) else "")
    write = atomic.write_text

    def full(target: Path, text: str) -> None:
        if "failures" in target.parts:
            raise OSError(errno.ENOSPC, "No space left on device")
        write(target, text)

    monkeypatch.setattr(atomic, "write_text", full)
    done = run.run_dataset(source, tmp_path / "out")
    assert done.failed == {f"{GOOD}/view_0": "no light"}
    assert done.made == 7


def test_the_folder_of_another_dataset_is_refused(
    source: Path, tmp_path: Path, pretend: Pretend
) -> None:
    pretend(lambda job, view: "")
    run.run_dataset(source, tmp_path / "out")
    source.write_text(source.read_text().replace("name: small", "name: other"))
    with pytest.raises(Exception, match="another dataset"):
        run.run_dataset(source, tmp_path / "out")


JOB = Job(PlannedRoom("room_a", 0, {"file": "a.yaml", "sha256": "0"}, "train"), "main", 4, "k", (0, 1, 2))  # fmt: skip # noqa: E501


ENTRY = {"resolution": [1, 1], "K": [], "world_from_camera": [], "channels": {}}
RECORD: dict[str, Any] = {
    "unit": "room_a/main/view_0",
    "room": "room_a",
    "variant": "main",
    "split": "train",
    "source": {},
    "entry": ENTRY,
    "told": [],
    "pixels": {},
    "files": {},
    "quality": {"measures": {}, "faults": ["it is dark"]},
    "rejected": [],
}


@pytest.fixture
def store(tmp_path: Path) -> Store:
    """Of three views one is finished, one has failed, one is left."""
    store = Store(tmp_path / "made")
    store.write_plan([JOB])
    folder = store.render(JOB)
    (folder / "view_0" / "lights").mkdir(parents=True)
    (folder / "view_0" / "channels.exr").write_bytes(b"pixels")
    (folder / "view_0" / "lights" / "a.png").write_bytes(b"picture")
    (folder / "openings").mkdir()
    (folder / "openings" / "window.exr").write_bytes(b"sky")
    shared: dict[str, Any] = {
        "key": "k",
        "entry": {"generator": "openrooms_usd"},
        "report": {"approximated": 1, "losses": []},
        "licences": [],
        "files": store.digests(JOB, "openings"),
    }
    write_json(store.record_path(JOB, SCENE), shared)
    record = {**RECORD, "files": store.digests(JOB, "view_0")}
    store.finish(JOB, 0, record, {"render": 1.0})
    for _ in range(2):
        store.fail(JOB, 1, {"code": "render", "reason": "no light"})
    store.write_manifest(JOB)
    return store


def test_the_plan_comes_back(store: Store) -> None:
    assert list(store.jobs()) == [JOB]


def test_status_counts_and_tells_reasons(store: Store) -> None:
    found = status_of(store.root)
    assert (found.units, found.finished, found.left) == (3, 1, 1)
    (failure,) = found.failures
    assert (failure.unit, failure.reason, failure.attempts) == ("room_a/main/view_1", "no light", 2)
    assert found.faults == {"it is dark": 1}
    assert found.as_dict()["failed"] == 1


def test_what_is_made_at_last_has_failed_no_more(store: Store) -> None:
    store.finish(JOB, 1, RECORD, {})
    assert not status_of(store.root).failures
    assert store.failure(JOB, 1) is None


def test_records_of_another_plan_count_for_nothing(store: Store) -> None:
    other = Job(JOB.room, JOB.variant, JOB.seed, "other", JOB.views)
    store.write_plan([other])
    found = status_of(store.root)
    assert (found.finished, found.left) == (0, 3)


def test_a_dataset_that_is_whole_verifies(store: Store) -> None:
    found = verify(store.root)
    assert (found.damages, found.views, found.files, found.unfinished) == ((), 1, 2, 2)


@pytest.mark.parametrize(
    ("file", "what"),
    [
        ("view_0/channels.exr", CHANGED),
        ("view_0/channels.exr", MISSING),
        ("view_0/lights/a.png", MISSING),
        ("view_0/more.exr", EXTRA),
        ("openings/window.exr", CHANGED),
        ("manifest.json", CHANGED),
        ("manifest.json", MISSING),
    ],
)
def test_every_damage_is_named(store: Store, file: str, what: str) -> None:
    path = store.render(JOB) / file
    if what == MISSING:
        path.unlink()
    else:
        path.write_bytes(b"something else")
    assert verify(store.root).damages == (Damage(f"renders/room_a/main/{file}", what),)


@pytest.mark.parametrize(
    "text", ['{"key": "k", "fil', '{"key": "k"}', "[]", "3", "\x00", '{"key": ["k"]}', "[" * 9999]
)
def test_a_damaged_record_makes_its_view_unfinished(store: Store, text: str) -> None:
    store.record_path(JOB, "view_0").write_text(text)
    assert status_of(store.root).finished == 0
    store.record_path(JOB, SCENE).write_text(text)
    store.failure_path(JOB, 1).write_text(text)
    assert status_of(store.root).left == 3
    assert verify(store.root).views == 0


def test_a_folder_without_a_dataset_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        status_of(tmp_path)
    (tmp_path / "plan.jsonl").write_text('{"key": 1}\n')
    with pytest.raises(InputError, match="not a plan"):
        status_of(tmp_path)
