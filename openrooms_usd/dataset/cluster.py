"""Runs tasks on a cluster of Ray, or with a new local Ray on this machine.

Each worker is an actor, which keeps what it has loaded from task to task. Ray places it where there
is room for what it needs and repeats nothing: whether a task is begun again is for the run to say.
"""

import math
import os
import secrets
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any, ClassVar, Final

from openrooms_usd.dataset import executor
from openrooms_usd.errors import InputError, MissingPackageError

# What Ray keeps of objects that are handed over: tasks are small.
_OBJECT_STORE_BYTES: Final = 128 * 2**20
_CLIENT: Final = "ray://"
# Else it says on standard output who has died, and warns of workers without a GPU.
_QUIET: Final = {"RAY_DEDUP_LOGS_SKIP_REGEX": ".", "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0"}
_GIB: Final = 2**30
_MOST: Final = 1e6
_LONGEST_REASON: Final = 300  # characters
Needs = dict[str, Any]


"""Of each worker, as Ray calls it."""


class RayExecutor:
    """One actor of Ray for each worker."""

    options: ClassVar[Mapping[str, str]] = {
        "address": "a running cluster, as HOST:PORT, or auto: that of this machine",
        "cpus": "processors of each worker; by default an equal share of all",
        "gpus": "GPUs of each worker; by default 1 where the renderer is asked for cuda, else 0",
        "memory": "memory of each worker in GiB",
        "resources": "what else a node must have for a worker, as NAME:AMOUNT,NAME:AMOUNT",
    }

    @contextmanager
    def hired(self, wanted: executor.WorkerDemand) -> Iterator["_Crew"]:
        """See `openrooms_usd.dataset.executor.Executor.hired`."""
        workers, address = max(1, wanted.workers), wanted.options.get("address")
        needs = _needs(wanted)
        with connected(address, _processors_for(needs, workers)) as ray:
            nodes = [node["Resources"] for node in ray.nodes() if node["Alive"]]
            needs.setdefault("num_cpus", _share(nodes, workers))
            _check_place(nodes, needs)
            yield _Crew(ray, workers, needs)


@dataclass(frozen=True)
class _Crew:
    ray: ModuleType
    workers: int
    needs: Needs

    @property
    def threads(self) -> int:
        """How many threads each worker shall use."""
        cpus: float = self.needs["num_cpus"]
        return max(1, int(cpus))

    def run(
        self, tasks: Iterable[executor.Task], work: executor.Work
    ) -> Iterator[tuple[executor.Task, executor.WorkerMessage | executor.Lost]]:
        """See `openrooms_usd.dataset.executor.Crew.run`."""
        actor = self.ray.remote(max_restarts=0, max_task_retries=0, **self.needs)(WorkerActor)

        def ready(crew: list[_Worker]) -> list[_Worker]:
            found, _ = self.ray.wait([worker.stream for worker in crew], fetch_local=False)
            return [worker for worker in crew if worker.stream in found]

        return executor.worked_off(
            tasks, self.workers, lambda task: _Worker(self.ray, actor.remote(work), task), ready
        )


class WorkerActor:
    """What runs on a node: does its work, task after task.

    Args:
        work: The work.
    """

    def __init__(self, work: executor.Work) -> None:
        # Its node; else it goes on for seconds when that is killed.
        executor.end_with_parent()
        self._work = work

    def messages(self, task: executor.Task) -> Iterator[tuple[str, Any]]:
        """What it says of a task, as it happens."""
        yield from executor.messages(self._work, task)


class _Worker:
    """An actor and what it is working on."""

    def __init__(self, ray: ModuleType, actor: Any, task: executor.Task) -> None:
        self._ray, self._actor, self._is_gone = ray, actor, False
        self.give(task)

    def give(self, task: executor.Task) -> bool:
        """Give it a task; whether it is there to take it."""
        self.task = task
        if not self._is_gone:
            # One thing at a time: messages before a death are received.
            call = self._actor.messages.options(
                num_returns="streaming", _generator_backpressure_num_objects=1
            )
            self.stream = call.remote(dict(task))
        return not self._is_gone

    def hear(self) -> executor.WorkerMessage | executor.Lost | None:
        """What it says next; None when it is done with its task."""
        try:
            return executor.understood(self._ray.get(next(self.stream)))
        except self._ray.exceptions.RayError as error:
            self._is_gone = True
            return executor.Lost(f"the worker died ({_reason(error)})")

    def stop(self) -> None:
        """End it: the next worker there removes what it has not finished."""
        with suppress(self._ray.exceptions.RayError):
            self._ray.kill(self._actor, no_restart=True)


def _reason(error: Exception) -> str:
    """What Ray says of a death, without the names of its own parts."""
    lines = [line.strip() for line in str(error).splitlines() if not line.startswith("\t")]
    said = " ".join(lines)
    _, found, detail = said.partition("exit detail: ")
    return (detail.partition(" Some common causes")[0] if found else said)[:_LONGEST_REASON]


def _processors_for(needs: Needs, workers: int) -> int:
    """The processors of a local Ray: all workers have a place, also on a small machine."""
    each: float = needs.get("num_cpus", max(1, (os.cpu_count() or 1) // workers))
    return math.ceil(each * workers)


def _needs(wanted: executor.WorkerDemand) -> Needs:
    """What each worker needs, as far as it is said."""
    given = wanted.options
    needs: Needs = {"num_gpus": _amount("gpus", given.get("gpus", str(wanted.gpus)))}
    if "cpus" in given:
        needs["num_cpus"] = _amount("cpus", given["cpus"])
    if "memory" in given:
        needs["memory"] = int(_amount("memory", given["memory"]) * _GIB)
    rows = [row.partition(":") for row in given.get("resources", "").split(",") if row]
    needs["resources"] = {name: _amount("resources", amount or "1") for name, _, amount in rows}
    return needs


def _amount(option: str, text: str) -> float:
    with suppress(ValueError):
        if 0.0 <= float(text) <= _MOST:
            return float(text)
    raise InputError(f"{text!r} is not an amount", place=option, remedy="give a number, such as 1")


def _share(nodes: list[Mapping[str, float]], workers: int) -> int:
    """The processors of a worker where nothing is said: all of them, for all workers alike."""
    counts = [int(node.get("CPU", 0)) for node in nodes]
    return max(1, min(max(counts, default=1), sum(counts) // workers))


def _check_place(nodes: list[Mapping[str, float]], needs: Needs) -> None:
    """Refuse workers that no node could ever take: they would be waited for without end."""
    asked = {"CPU": needs["num_cpus"], "GPU": needs["num_gpus"], "memory": needs.get("memory", 0)}
    asked |= needs["resources"]
    if any(all(node.get(name, 0) >= value for name, value in asked.items()) for node in nodes):
        return
    named = ", ".join(f"{value:g} {name}" for name, value in asked.items() if value)
    raise InputError(
        f"none of the {len(nodes)} nodes has what a worker needs: {named}",
        place="the cluster of Ray",
        remedy="request less: --option cpus=1, --option gpus=0",
    )


@contextmanager
def connected(address: str | None, cpus: int) -> Iterator[ModuleType]:
    """Ray, connected to a cluster, or to one that lasts as long as the block.

    Args:
        address: The cluster, as Ray writes it; None for one of our own on this machine.
        cpus: Processors that this one has for its workers.

    Yields:
        The package.

    Raises:
        InputError: No cluster is there.
        MissingPackageError: Ray is not installed.
    """
    if address is not None and address.startswith(_CLIENT):
        raise InputError(
            "workers cannot report through Ray's client",
            place=address,
            remedy="run this on a machine of the cluster, with --address auto",
        )
    quiet: dict[str, Any] = {"log_to_driver": False, "logging_level": "critical"}
    with _environment({} if address else _own()):
        ray = _package()
        try:
            if address is not None:
                ray.init(address=address, **quiet)
            else:
                ray.init(
                    address="local",
                    num_cpus=cpus,
                    object_store_memory=_OBJECT_STORE_BYTES,
                    include_dashboard=False,
                    _node_ip_address="127.0.0.1",
                    **quiet,
                )
        except (ConnectionError, ValueError, RuntimeError, OSError) as error:
            raise InputError(
                f"no cluster of Ray is running: {str(error).partition(chr(10))[0]}",
                place=address or "this machine",
                remedy="start one (ray start --head), and give its HOST:PORT",
            ) from error
        try:
            yield ray
        finally:
            ray.shutdown()


@cache
def _own() -> Mapping[str, str]:
    """The environment of a local Ray."""
    return {
        # What Ray does for macOS and Windows: listen on the loopback interface alone.
        "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0",
        "RAY_AUTH_MODE": "token",
        "RAY_AUTH_TOKEN": secrets.token_hex(32),
        "RAY_USAGE_STATS_ENABLED": "0",
    }


@contextmanager
def _environment(added: Mapping[str, str]) -> Iterator[None]:
    before = {name: os.environ.get(name) for name in added}
    os.environ.update(added)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _package() -> ModuleType:
    for name, value in _QUIET.items():
        os.environ.setdefault(name, value)
    try:
        import ray
    except ImportError as error:
        raise MissingPackageError(
            f"the executor 'ray' needs the package 'ray', which cannot be imported ({error})",
            remedy="pip install openrooms-usd[ray], or omit --executor",
        ) from error
    found: ModuleType = ray
    return found
