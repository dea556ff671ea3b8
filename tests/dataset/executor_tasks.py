"""Work for the processes of an executor: importable by them."""

import os
import signal
from collections.abc import Iterator, Mapping
from typing import Any


def work(task: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    yield {"began": task["name"], "process": os.getpid()}
    if task["name"] == "dies":
        os.kill(os.getpid(), signal.SIGKILL)
    if task["name"] == "raises":
        raise ValueError("no such thing")
    yield {"ended": task["name"]}
