"""How far a dataset is: what is finished, what has failed and why, what is left."""

from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from openrooms_usd.dataset.plan import view_name
from openrooms_usd.dataset.records import LEFT_OUT
from openrooms_usd.dataset.scratch import Root, fetch_all, store_at
from openrooms_usd.dataset.store import Store


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
