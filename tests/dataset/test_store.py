"""Records, status and verification, of a store that was filled by hand."""

from pathlib import Path
from typing import Any

import pytest

from openrooms_usd.dataset.plan import Job, PlannedRoom
from openrooms_usd.dataset.records import SCENE
from openrooms_usd.dataset.status import CHANGED, EXTRA, MISSING, Damage, status_of, verify
from openrooms_usd.dataset.store import Store, write_json
from openrooms_usd.errors import InputError

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
    with pytest.raises(InputError, match="no plan"):
        status_of(tmp_path)
