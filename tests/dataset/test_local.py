"""The executor of this machine: processes that keep what they loaded, and may die."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from openrooms_usd.dataset.executor import Lost, WorkerDemand
from openrooms_usd.dataset.local import LocalExecutor


@pytest.fixture(autouse=True)
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes import what they work by its name."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent))


def work() -> Any:
    return import_module("executor_tasks").work


def told(names: list[str], workers: int) -> list[tuple[str, Any]]:
    tasks = [{"name": name} for name in names]
    with LocalExecutor().hired(WorkerDemand(workers)) as crew:
        return [(task["name"], what) for task, what in crew.run(tasks, work())]


def test_one_worker_does_all_and_tells_in_order() -> None:
    found = told(["a", "b"], 1)
    assert [name for name, _ in found] == ["a", "a", "b", "b"]
    assert found[1][1] == {"ended": "a"}
    assert len({what["process"] for _, what in found if "process" in what}) == 1


def test_a_worker_that_dies_is_told_and_replaced() -> None:
    found = told(["a", "dies", "raises", "b"], 1)
    lost = {name: what.reason for name, what in found if isinstance(what, Lost)}
    assert lost == {"dies": "the worker died (SIGKILL)", "raises": "ValueError: no such thing"}
    assert ("b", {"ended": "b"}) in found
    began = [what for _, what in found if not isinstance(what, Lost) and "process" in what]
    assert len({what["process"] for what in began}) == 2


def test_tasks_are_taken_when_a_worker_is_free() -> None:
    taken = []

    def tasks() -> Iterator[dict[str, str]]:
        for name in "abcdef":
            taken.append(name)
            yield {"name": name}

    with (
        LocalExecutor().hired(WorkerDemand(2)) as crew,
        closing(crew.run(tasks(), work())) as running,
    ):
        next(running)
        assert len(taken) <= 3


@pytest.mark.parametrize("names", [[], ["a"]])
def test_fewer_tasks_than_workers(names: list[str]) -> None:
    assert [name for name, _ in told(names, 3)] == [name for name in names for _ in range(2)]


def test_a_script_without_a_guard_runs_once(tmp_path: Path) -> None:
    """As people paste it: nothing asks for ``if __name__ == "__main__"``."""
    script = tmp_path / "t.py"
    script.write_text(
        "from openrooms_usd.dataset.executor import WorkerDemand\n"
        "from openrooms_usd.dataset.local import LocalExecutor\n"
        "from executor_tasks import work\n"
        "print('begun')\n"
        "with LocalExecutor().hired(WorkerDemand(1)) as crew:\n"
        "    print([told for _, told in crew.run([{'name': 'a'}], work)][1:])\n"
    )
    path = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    done = subprocess.run(
        [sys.executable, script],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": path},
    )
    assert (done.stdout, done.stderr) == ("begun\n[{'ended': 'a'}]\n", "")
