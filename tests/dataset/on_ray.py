"""What workers of a Ray of one's own do, as JSON; in a process of its own, which Ray likes best."""

import json
import sys
from collections.abc import Iterator
from contextlib import closing, suppress
from typing import Any

from executor_tasks import work

from openrooms_usd.dataset.cluster import RayExecutor
from openrooms_usd.dataset.executor import Crew, Lost, WorkerDemand


def told(crew: Crew, names: list[str]) -> list[tuple[str, Any]]:
    rows = crew.run([{"name": name} for name in names], work)
    return [(task["name"], vars(what) if isinstance(what, Lost) else what) for task, what in rows]


def taken(crew: Crew, heard: int) -> int:
    """How many of a million tasks are taken until so many things are told."""
    count = 0

    def tasks() -> Iterator[dict[str, str]]:
        nonlocal count
        for number in range(1_000_000):
            count += 1
            yield {"name": str(number)}

    with closing(crew.run(tasks(), work)) as running:
        for _ in range(heard):
            next(running)
    return count


def listening() -> list[str]:
    """The addresses at which processes of this one listen."""
    import psutil

    found = []
    for one in (psutil.Process(), *psutil.Process().children(recursive=True)):
        with suppress(psutil.NoSuchProcess):
            rows = one.net_connections("tcp")
            found += [row.laddr.ip for row in rows if row.status == psutil.CONN_LISTEN]
    return found


if __name__ == "__main__":
    with RayExecutor().hired(WorkerDemand(2, options={"cpus": "1"})) as crew:
        found = {
            "told": told(crew, ["a", "dies", "raises", "b", "c"]),
            "taken": taken(crew, 20),
            "listening": listening(),
            "threads": crew.threads,
        }
    json.dump(found, sys.stdout)
