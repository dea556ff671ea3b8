"""What a dataset holds, in numbers: rooms, objects and pixels of each class, seconds and errors."""

import json
import os
import statistics
from collections import Counter, defaultdict
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd.dataset.plan import Job
from openrooms_usd.dataset.records import Record
from openrooms_usd.dataset.store import Store
from openrooms_usd.errors import InputError
from openrooms_usd.render.contract import View
from openrooms_usd.untrusted import read_text

DESCRIBED: Final = "described"
"""What rooms that nobody generated are counted as."""

_CLASSES: Final = "semantic"
_PHASES: Final = ("compose", "translation", "render", "output")
# What all views of a job share; the rest each view has for itself.
_SHARED: Final = frozenset({"compose", "translation"})


@dataclass
class Stats:
    """What a dataset holds; of every view that is finished.

    Attributes:
        rooms: How many rooms of each type.
        splits: How many rooms of each split.
        views: How many views of each variant.
        objects: How many objects of each category, each room counted once.
        pixels: How many pixels of each class, in views whose channels tell.
        errors: Median estimated robust error of each channel that has one.
        seconds: Of each phase, of all views together.
        bytes: Of all files of views.
    """

    rooms: dict[str, int] = field(default_factory=dict)
    splits: dict[str, int] = field(default_factory=dict)
    views: dict[str, int] = field(default_factory=dict)
    objects: dict[str, int] = field(default_factory=dict)
    pixels: dict[str, int] = field(default_factory=dict)
    errors: dict[str, float] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    bytes: int = 0

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        return asdict(self)


def class_pixels(view: View, names: Mapping[int, str]) -> dict[str, int]:
    """How many pixels of a view each class has; empty where its channels do not tell.

    Args:
        view: What was rendered.
        names: Of the classes, by number.
    """
    if _CLASSES not in view.images:
        return {}
    numbers, counts = np.unique(view.images[_CLASSES].pixels.astype(np.int64), return_counts=True)
    rows = zip(numbers.tolist(), counts.tolist(), strict=True)
    return {names[number]: count for number, count in rows if number in names}


def stats_of(root: Path) -> Stats:
    """Count what a dataset holds, from its records alone.

    Args:
        root: Its folder.

    Raises:
        InputError: There is no dataset.
    """
    store, found = Store(root), Stats()
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    errors: dict[str, list[float]] = defaultdict(list)
    seconds = dict.fromkeys(_PHASES, 0.0)
    known: set[int] = set()
    for job in store.jobs():
        records = dict(store.records(job))
        if not records:
            continue
        if job.room.number not in known:
            known.add(job.room.number)
            counts["rooms"][str(job.room.source.get("type", DESCRIBED))] += 1
            counts["splits"][job.room.split] += 1
            counts["objects"].update(_objects(store, job))
        counts["views"][job.variant] += len(records)
        for view, record in records.items():
            counts["pixels"].update(record.get("pixels", {}))
            found.bytes += sum(file["bytes"] for file in record["files"].values())
            _take_errors(errors, record)
            _take_seconds(seconds, store.timing_path(job, view), view == min(records))
    for name, counted in counts.items():
        setattr(found, name, dict(counted.most_common()))
    found.errors = {name: statistics.median(errors[name]) for name in sorted(errors)}
    found.seconds = seconds
    return found


def _objects(store: Store, job: Job) -> Counter[str]:
    """The categories of a room's objects; the shell has none."""
    shared = store.scene_record(job)
    legend = shared["entry"].get("legend", {}) if shared else {}
    return Counter(legend.get("category", {}).values())


def _take_errors(errors: Mapping[str, list[float]], record: Record) -> None:
    for name, channel in record["entry"].get("channels", {}).items():
        if error := channel["estimated_robust_error"]:
            errors[name].append(error)


def _take_seconds(seconds: dict[str, float], path: Path, is_first: bool) -> None:
    with suppress(InputError, ValueError):
        timing = json.loads(read_text(path)) if os.path.lexists(path) else {}
        for phase in _PHASES:
            if is_first or phase not in _SHARED:
                seconds[phase] += float(timing.get(phase, 0.0))
