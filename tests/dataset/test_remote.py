"""Datasets behind a URL: on a server of objects, killed and begun again, with the same bytes."""

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from openrooms_usd.dataset import scratch as leases
from openrooms_usd.dataset.plan import Job, PlannedRoom
from openrooms_usd.dataset.remote import RemoteFolder
from openrooms_usd.dataset.scratch import Lease, leased, root_of, store_at
from openrooms_usd.dataset.status import CHANGED, EXTRA, MISSING, Damage, status_of, verify
from openrooms_usd.errors import InputError, MissingPackageError, OutputError
from tests.dataset.conftest import Checksums, Made, Start

pytest.importorskip("fsspec")

BUCKET = "s3://bucket"
_PATIENCE_S = 300.0


@pytest.fixture
def remote(tmp_path: Path) -> RemoteFolder:
    """A remote folder in memory, which knows no conditions."""
    return RemoteFolder(f"memory://{tmp_path.name}")


def test_what_is_put_is_read_again(remote: RemoteFolder, tmp_path: Path) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    (here / "a b").mkdir(parents=True)
    (here / "a b" / "[1].txt").write_text("one")
    remote.put(here, ["a b/[1].txt"])
    assert remote.put_text("two.txt", "two")
    assert remote.names("") == ["a b/[1].txt", "two.txt"]
    assert (remote.read("two.txt"), remote.read("three.txt")) == (b"two", None)
    remote.get(["two.txt", "three.txt"], there)
    assert sorted(path.name for path in there.rglob("*")) == ["two.txt"]
    remote.get_all("a b/", there)
    assert (there / "a b" / "[1].txt").read_text() == "one"
    remote.remove(["two.txt", "three.txt"])
    assert remote.names("") == ["a b/[1].txt"]


def test_names_that_leave_the_folder_are_refused(remote: RemoteFolder, tmp_path: Path) -> None:
    remote.put_text("../out.txt", "out")
    with pytest.raises(InputError, match="leads out of the folder"):
        remote.get(["../out.txt"], tmp_path / "here")


def test_urls_that_nobody_knows_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="not known"):
        RemoteFolder("nowhere://at/all")
    monkeypatch.setitem(sys.modules, "fsspec", None)
    with pytest.raises(MissingPackageError, match="cannot be imported"):
        RemoteFolder("memory://no-package")


def test_a_dataset_that_is_not_there_is_named() -> None:
    with pytest.raises(InputError, match="there is no dataset"):
        status_of("memory://not-there")
    assert root_of("s3://a/b") == "s3://a/b"
    assert root_of("a/b") == Path("a/b")


def test_what_is_known_of_views_is_the_same_behind_a_url(remote: RemoteFolder) -> None:
    rooms = [PlannedRoom(f"room_{n}", n, {"type": "office"}, "train") for n in range(3)]
    jobs = [Job(room, "main", 4, f"key_{room.number}", (0, 1)) for room in rooms]
    entry = {"resolution": [1, 1], "K": [], "world_from_camera": [], "channels": {}}
    view = {
        "unit": "u",
        "room": "r",
        "variant": "main",
        "split": "train",
        "source": {},
        "entry": entry,
        "told": [],
        "rejected": [],
        "pixels": {},
        "files": {},
        "quality": {"measures": {}, "faults": ["it is dark"]},
    }
    with store_at(remote.url) as store:
        store.write_plan(jobs)
        store.fail(jobs[0], 0, {"code": "render", "reason": "no light"})
        store.fail(jobs[0], 1, {"code": "render", "reason": "no light"})
        # What is finished after all is no failure.
        store.finish(jobs[0], 0, view, {})
    assert remote.folders("records") == remote.folders("failures") == {"room_0"}
    found = status_of(remote.url)
    assert (found.units, found.finished, found.left) == (6, 1, 4)
    assert [failure.unit for failure in found.failures] == ["room_0/main/view_1"]
    assert found.faults == {"it is dark": 1}


class Clock(threading.Event):
    """Time that passes at once; something may happen meanwhile."""

    def __init__(self, meanwhile: Callable[[], object] = lambda: None) -> None:
        super().__init__()
        self.meanwhile, self.seconds = meanwhile, 0.0

    def wait(self, timeout: float | None = None) -> bool:
        self.seconds += timeout or 0.0
        self.meanwhile()
        return self.is_set()


def test_one_run_has_it_at_a_time(remote: RemoteFolder) -> None:
    first = Lease(remote, Clock())
    first.take()
    with pytest.raises(OutputError, match="is running this dataset"):
        Lease(remote, Clock(first.beat)).take()
    first.check()
    first.give_back()
    second = Lease(remote, Clock())
    second.take()
    second.check()
    second.give_back()
    assert remote.names("") == []


@pytest.mark.parametrize(
    ("row", "waited_s"),
    [
        ({"host": "elsewhere", "process": 1}, leases.STALE_S),
        ({"host": socket.gethostname(), "process": 2**22}, 0.0),
    ],
)
def test_the_lease_of_the_dead_is_taken_over(
    row: dict[str, object], waited_s: float, remote: RemoteFolder
) -> None:
    """On another machine once it rests; on this one as soon as its process is gone."""
    remote.put_text(leases.LEASE, json.dumps({**row, "run": "x", "beat": 3}))
    own = Lease(remote, clock := Clock())
    own.take()
    own.check()
    assert clock.seconds == waited_s + leases.REST_S


def test_of_two_that_take_over_together_one_is_told(remote: RemoteFolder) -> None:
    other = json.dumps({"host": "elsewhere", "process": 1, "run": "x"})
    own = Lease(remote, Clock(lambda: remote.put_text(leases.LEASE, other)))
    with pytest.raises(OutputError, match="process 1 of elsewhere is running"):
        own.take()


def test_who_loses_it_is_told(remote: RemoteFolder) -> None:
    own = Lease(remote, Clock())
    own.take()
    own.beat()
    own.check()
    remote.put_text(leases.LEASE, json.dumps({"host": "elsewhere", "process": 1, "run": "x"}))
    own.keep()
    with pytest.raises(OutputError, match="taken over this dataset"):
        own.check()
    own.give_back()
    assert remote.names("") == [leases.LEASE]


def test_what_its_keeper_was_saying_is_not_said_after_the_end(
    remote: RemoteFolder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(leases, "REST_S", 0.0)
    monkeypatch.setattr(leases, "BEAT_S", 0.0)
    put, began, ended = remote.put_text, threading.Event(), threading.Event()

    def late(name: str, text: str, *, new: bool = False) -> bool:
        if not new:
            began.set()
            ended.wait()
        return put(name, text, new=new)

    monkeypatch.setattr(remote, "put_text", late)
    with leased(remote) as own:
        assert began.wait(_PATIENCE_S)
        end = own.end
        monkeypatch.setattr(own, "end", lambda: (end(), ended.set()))
    assert remote.names("") == []


def test_what_goes_while_it_is_fetched_is_told(
    remote: RemoteFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(remote, "names", lambda prefix: ["gone/a.txt"])
    with pytest.raises(InputError, match="no such file"):
        remote.get_all("gone/", tmp_path)


def test_scratch_goes_and_that_of_the_dead_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    left = tmp_path / "orusd.scratch.left"
    left.mkdir()
    (left / ".orusd.lock").touch()
    with store_at("memory://scratch") as store, store_at("memory://scratch") as other:
        assert not left.exists()
        assert store.root != other.root
        assert store.root.is_dir()
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A server of objects on this machine, with a bucket."""
    pytest.importorskip("s3fs")
    pytest.importorskip("moto.server")
    with socket.create_server(("127.0.0.1", 0)) as probe:
        port = probe.getsockname()[1]
    words = [sys.executable, "-m", "moto.server", "-H", "127.0.0.1", "-p", str(port)]
    quiet = subprocess.DEVNULL
    with (
        pytest.MonkeyPatch.context() as patch,
        subprocess.Popen(words, stdout=quiet, stderr=quiet) as process,
    ):
        patch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{port}")
        patch.setenv("AWS_ACCESS_KEY_ID", "nobody")
        patch.setenv("AWS_SECRET_ACCESS_KEY", "nothing")
        patch.setenv("AWS_DEFAULT_REGION", "us-east-1")
        deadline = time.monotonic() + _PATIENCE_S
        while not answers(port):
            assert process.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
        RemoteFolder(BUCKET)._system.mkdir("bucket")
        yield
        process.terminate()


def answers(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@pytest.mark.slow
@pytest.mark.usefixtures("server")
def test_a_run_behind_a_url_has_the_same_bytes(
    made: Made, tmp_path: Path, start: Start, checksums: Checksums
) -> None:
    """Killed in the middle, begun again, with another form of files; then damaged."""
    file, local = made
    url, remote = f"{BUCKET}/one", RemoteFolder(f"{BUCKET}/one")
    first = start(file, url, 2)
    deadline = time.monotonic() + _PATIENCE_S
    while not remote.names("renders/"):
        assert first.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)
    os.kill(first.pid, signal.SIGKILL)
    first.communicate()
    again = start(file, url, 2)
    said, wrong = again.communicate()
    assert (again.returncode, wrong) == (1, "")
    assert len(json.loads(said)["failed"]) == 4
    remote.get_all("", tmp_path / "there")
    assert checksums(tmp_path / "there") == checksums(local)
    assert not [name for name in remote.names("") if "/.orusd." in f"/{name}"]

    assert status_of(url).as_dict() | {"root": 0} == status_of(local).as_dict() | {
        "root": 0,
        "failures": status_of(url).as_dict()["failures"],
    }
    assert verify(url).damages == ()

    home = "renders/room_good/main/view_0"
    changed, missing, *_ = remote.names(f"{home}/")
    remote.put_text(changed, "no picture")
    remote.remove([missing])
    remote.put_text(f"{home}/none.txt", "")
    assert verify(url).damages == tuple(
        sorted(
            (Damage(changed, CHANGED), Damage(missing, MISSING), Damage(f"{home}/none.txt", EXTRA))
        )
    )


@pytest.mark.slow
@pytest.mark.usefixtures("server")
def test_of_two_that_begin_together_one_gets_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """The server decides: both have looked, and found nothing there."""
    remote = RemoteFolder(f"{BUCKET}/together")
    monkeypatch.setattr(remote._system, "exists", lambda path: False)
    assert remote.put_text("lease", "first", new=True)
    assert not remote.put_text("lease", "second", new=True)
    assert remote.read("lease") == b"first"


@pytest.mark.slow
@pytest.mark.usefixtures("server")
def test_other_forms_are_the_same_behind_a_url(
    made: Made, tmp_path: Path, start: Start, checksums: Checksums
) -> None:
    file, local = made
    shutil.copytree(local, tmp_path / "local", ignore=shutil.ignore_patterns(".orusd.lock"))
    remote = RemoteFolder(f"{BUCKET}/forms")
    files = [path for path in (tmp_path / "local").rglob("*") if path.is_file()]
    names = (path.relative_to(tmp_path / "local").as_posix() for path in files)
    remote.put(tmp_path / "local", (name for name in names if "/.orusd." not in f"/{name}"))
    text = file.read_text() + "outputs: [{as: nerf}]\n"
    other = file.parent / "forms.yaml"
    other.write_text(text.replace(", poisoned/room.yaml", ""))
    for out in (tmp_path / "local", remote.url):
        process = start(other, out)
        said, wrong = process.communicate()
        assert (process.returncode, wrong) == (0, "")
        done = json.loads(said)
        assert (done["made"], done["kept"]) == (0, 4)
    remote.get_all("", tmp_path / "there")
    found = checksums(tmp_path / "there")
    assert any(name.startswith("outputs/nerf/") for name in found)
    assert found == checksums(tmp_path / "local")
