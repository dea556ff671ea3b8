"""The executor of Ray, with the real one: on this machine, and on a cluster of two nodes."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from openrooms_usd.dataset.cluster import RayExecutor
from openrooms_usd.dataset.executor import WorkerDemand
from openrooms_usd.dataset.status import status_of
from openrooms_usd.errors import InputError, MissingPackageError
from tests.dataset.conftest import PATIENCE_S, Checksums, Made, Start, wait_for

HERE = Path(__file__).parent


@pytest.mark.parametrize(
    ("options", "said"),
    [({"cpus": "many"}, "not an amount"), ({"address": "ray://head:10001"}, "Ray's client")],
)
def test_options_that_make_no_sense_are_refused(options: dict[str, str], said: str) -> None:
    with pytest.raises(InputError, match=said), RayExecutor().hired(WorkerDemand(options=options)):
        pass


def test_without_the_package_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with (
        pytest.raises(MissingPackageError, match="'ray'") as raised,
        RayExecutor().hired(WorkerDemand()),
    ):
        pass
    assert "openrooms-usd[ray]" in str(raised.value)


@pytest.fixture(scope="module")
def own() -> dict[str, Any]:
    """What workers of a Ray of one's own do."""
    pytest.importorskip("ray")
    done = subprocess.run(
        [sys.executable, "on_ray.py"],
        cwd=HERE,
        env={**os.environ, "PYTHONPATH": str(HERE)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.mark.slow
def test_a_worker_that_dies_is_told_and_replaced(own: dict[str, Any]) -> None:
    lost = {name: what["reason"] for name, what in own["told"] if "reason" in what}
    assert lost.keys() == {"dies", "raises"}
    assert lost["raises"] == "ValueError: no such thing"
    assert lost["dies"].startswith("the worker died (")
    assert {name for name, what in own["told"] if what.get("ended") == name} == {"a", "b", "c"}
    # Each one tells in order, and nobody begins what another has lost.
    assert [name for name, _ in own["told"]].count("dies") == 2


@pytest.mark.slow
def test_tasks_are_taken_when_a_worker_is_free(own: dict[str, Any]) -> None:
    # Each tells two things: of 20 ten tasks are done, and two workers have another.
    assert own["taken"] <= 12


@pytest.mark.slow
def test_only_this_machine_reaches_it(own: dict[str, Any]) -> None:
    assert {address.removeprefix("::ffff:") for address in own["listening"]} == {"127.0.0.1"}
    assert len(own["listening"]) > 3


@pytest.mark.slow
def test_a_dataset_has_the_same_bytes_whoever_works(
    made: Made, tmp_path: Path, checksums: Checksums, start: Start
) -> None:
    """Killed in the middle with all that is Ray's, and begun again."""
    pytest.importorskip("ray")
    file, local = made
    process = start(file, tmp_path / "out", 2, "--executor", "ray")
    wait_for(process, tmp_path / "out", "renders/*/*/.view_1.*")
    hands = [pid for pid in descendants(process.pid) if b"WorkerActor" in command_of(pid)]
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    assert len(hands) == 2
    # Nobody writes when the next run begins.
    deadline = time.monotonic() + PATIENCE_S
    while any(b"WorkerActor" in command_of(pid) for pid in hands):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    process = start(file, tmp_path / "out", 4, "--executor", "ray")
    said, wrong = process.communicate()
    assert (process.returncode, wrong) == (1, "")
    assert {unit.partition("/")[0] for unit in json.loads(said)["failed"]} == {"room_poisoned"}
    assert checksums(tmp_path / "out") == checksums(local)


@pytest.mark.long
def test_a_node_that_dies_takes_its_views_alone(
    made: Made, tmp_path: Path, checksums: Checksums, start: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("ray")
    file, local = made
    # As macOS and Windows have it: on the loopback interface alone.
    monkeypatch.setenv("RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER", "0")
    monkeypatch.setenv("RAY_USAGE_STATS_ENABLED", "0")
    pipe = subprocess.PIPE
    with subprocess.Popen(
        [sys.executable, str(HERE / "two_nodes.py")],
        stdin=pipe,
        stdout=pipe,
        stderr=pipe,
        text=True,
    ) as cluster:
        assert cluster.stdin is not None
        assert cluster.stdout is not None
        address = cluster.stdout.readline().strip()
        out, words = tmp_path / "out", ("--executor", "ray", "--address", address)
        first = start(file, out, 2, *words)
        wait_for(first, out, "renders/*/*/.view_0.*")
        print("kill", file=cluster.stdin, flush=True)
        said, wrong = first.communicate()
        assert first.returncode == 1, wrong
        assert json.loads(said)["made"] >= 2
        again = start(file, out, 1, *words)
        _, wrong = again.communicate()
        assert again.returncode == 1, wrong
        cluster.stdin.close()
    assert status_of(out).finished == 4
    assert checksums(out) == checksums(local)


def descendants(pid: int) -> list[int]:
    """All processes that a process has begun, and those that these have begun."""
    begun: dict[int, list[int]] = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            begun.setdefault(_parent(stat), []).append(int(stat.parent.name))
    found = list(begun.get(pid, []))
    for child in found:
        found += begun.get(child, [])
    return found


def command_of(pid: int) -> bytes:
    with suppress(OSError):
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    return b""


def _parent(stat: Path) -> int:
    return int(stat.read_text().rpartition(")")[2].split()[1])
