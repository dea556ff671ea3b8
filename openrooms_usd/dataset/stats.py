"""What a dataset holds, in numbers: rooms, objects, pixels, lights, seconds and errors."""

import math
from array import array
from collections import Counter, defaultdict
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from typing import Any, Final

import numpy as np

from openrooms_usd import names
from openrooms_usd.channels import definition
from openrooms_usd.dataset.plan import Job
from openrooms_usd.dataset.records import Record
from openrooms_usd.dataset.scratch import Root, fetch_all, store_at
from openrooms_usd.dataset.status import DEPTH_STEP_M
from openrooms_usd.dataset.store import Store

DESCRIBED: Final = "described"
"""How rooms of unknown type are counted."""
PHASES: Final = ("compose", "translation", "render", "output")
"""What a view takes its time for, in order."""
KELVIN_STEP: Final = 500
"""The width of a bin of colour temperatures."""

# What all views of a job share; the rest each view has for itself.
_SHARED: Final = frozenset({"compose", "translation"})
_LAMP: Final = "lamp"
# Where bins of what spans decades begin in each of them.
_STEPS: Final = (1, 2, 5)
_HIGH_PERCENT: Final = 90

_Numbers = Mapping[str, "array[float]"]


@dataclass
class Stats:
    """What a dataset holds; of every view that is finished.

    Histograms name each bin by its lower end.

    Attributes:
        rooms: How many rooms of each type.
        splits: How many rooms of each split.
        views: How many views of each variant.
        objects: How many objects of each category, without the shell; each room counted once.
        pixels: How many pixels of each class, in views whose channels tell.
        materials: How many pixels of each substance.
        families: How many pixels of each family of textures.
        depth_m: How many pixels of each depth, metres.
        lights: How many lights of each kind, of all rooms in all variants.
        lamps_a_room: In how many rooms and variants so many lamps are on.
        lamp_lumen: How many lamps of each power that is on.
        lamp_kelvin: How many lamps of each colour temperature.
        opening_lumen: How many openings through which so much light comes.
        licences: In how many rooms something under which licence is shown.
        faults: How many views have each fault.
        errors: Median estimated robust error of each channel that has one.
        high_errors: What nine tenths of the views stay below, as ``errors``.
        channel_seconds: Mean seconds a view of each channel; those that share rays each count them.
        seconds: Of each phase, of all views together.
        core_seconds: The same, each with the threads that it could use.
        bytes: Of all files of views.
    """

    rooms: dict[str, int] = field(default_factory=dict)
    splits: dict[str, int] = field(default_factory=dict)
    views: dict[str, int] = field(default_factory=dict)
    objects: dict[str, int] = field(default_factory=dict)
    pixels: dict[str, int] = field(default_factory=dict)
    materials: dict[str, int] = field(default_factory=dict)
    families: dict[str, int] = field(default_factory=dict)
    depth_m: dict[str, int] = field(default_factory=dict)
    lights: dict[str, int] = field(default_factory=dict)
    lamps_a_room: dict[str, int] = field(default_factory=dict)
    lamp_lumen: dict[str, int] = field(default_factory=dict)
    lamp_kelvin: dict[str, int] = field(default_factory=dict)
    opening_lumen: dict[str, int] = field(default_factory=dict)
    licences: dict[str, int] = field(default_factory=dict)
    faults: dict[str, int] = field(default_factory=dict)
    errors: dict[str, float] = field(default_factory=dict)
    high_errors: dict[str, float] = field(default_factory=dict)
    channel_seconds: dict[str, float] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    core_seconds: float = 0.0
    bytes: int = 0

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        return asdict(self)


def stats_of(root: Root) -> Stats:
    """Count what a dataset holds, from its records alone.

    Args:
        root: Its folder, or a URL.

    Raises:
        InputError: There is no dataset.
    """
    with store_at(root) as store:
        fetch_all(store)
        return _counted(store)


def _counted(store: Store) -> Stats:
    count = _Count()
    licences: dict[int, set[str]] = defaultdict(set)
    for job in store.jobs():
        views = dict(store.records(job))
        if not views:
            continue
        shared = store.scene_record(job) or {}
        if job.room.number not in licences:
            count.room(job, shared)
        licences[job.room.number] |= set(shared.get("licences", ()))
        count.lit_room(shared)
        count.named["views"][job.variant] += len(views)
        for view, record in views.items():
            count.view(record)
            count.timing(store.timing(job, view), is_first=view == min(views))
    for found in licences.values():
        count.named["licences"].update(found)
    return count.stats()


@dataclass
class _Count:
    """What has been counted so far."""

    named: dict[str, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))
    bins: dict[str, Counter[float]] = field(default_factory=lambda: defaultdict(Counter))
    errors: dict[str, "array[float]"] = field(default_factory=lambda: defaultdict(_doubles))
    of_channels: dict[str, "array[float]"] = field(default_factory=lambda: defaultdict(_doubles))
    seconds: dict[str, float] = field(default_factory=lambda: dict.fromkeys(PHASES, 0.0))
    core_seconds: float = 0.0
    bytes: int = 0

    def room(self, job: Job, shared: Record) -> None:
        """Count a room, in whatever variant it is met first."""
        kind = job.room.source.get("type") or shared.get("type") or DESCRIBED
        self.named["rooms"][str(kind)] += 1
        self.named["splits"][job.room.split] += 1
        legend = shared.get("entry", {}).get("legend", {})
        paths = legend.get("instance", {})
        self.named["objects"].update(
            category
            for number, category in legend.get("category", {}).items()
            # Walls, floors and what is built in are the room's shell.
            if not str(paths.get(number, "")).startswith(f"{names.ROOM}/")
        )

    def lit_room(self, shared: Record) -> None:
        """Count the lights of a room in a variant."""
        lights = shared.get("entry", {}).get("lights", ())
        for light in lights:
            kind = str(light["kind"])
            self.named["lights"][kind if light["on"] else f"{kind}, off"] += 1
            if light["on"] and light["lumen"] >= 1.0:
                self.bins[f"{kind}_lumen"][_lower_end(light["lumen"])] += 1
            if light["on"] and kind == _LAMP and light.get("kelvin"):
                self.bins["lamp_kelvin"][light["kelvin"] // KELVIN_STEP * KELVIN_STEP] += 1
        if lights:
            self.bins["lamps_a_room"][
                sum(one["on"] and one["kind"] == _LAMP for one in lights)
            ] += 1

    def view(self, record: Record) -> None:
        """Count what the record of a view says."""
        self.named["pixels"].update(record["pixels"])
        for name, pixels in record.get("materials", {}).items():
            self.named["materials"][name.partition("/")[0]] += pixels
            self.named["families"][name.replace("/", ": ")] += pixels
        for number, pixels in enumerate(record.get("depth", ())):
            self.bins["depth_m"][number * DEPTH_STEP_M] += pixels
        self.named["faults"].update(record["quality"]["faults"])
        self.bytes += sum(file["bytes"] for file in record["files"].values())
        for name, channel in record["entry"]["channels"].items():
            if error := channel["estimated_robust_error"]:
                self.errors[_table_name(name)].append(error)

    def timing(self, told: Record, *, is_first: bool) -> None:
        """Count the seconds of a view; those that views share with the first of them."""
        for phase in PHASES:
            if is_first or phase not in _SHARED:
                seconds = told.get(phase, 0.0)
                self.seconds[phase] += seconds
                self.core_seconds += seconds * told.get("threads", 1)
        for name, seconds in told.get("channels", {}).items():
            self.of_channels[name].append(seconds)

    def stats(self) -> Stats:
        """All of it; names by how often, bins and channels in order."""
        named = {name: dict(counted.most_common()) for name, counted in self.named.items()}
        bins = {
            name: {f"{end:g}": counted[end] for end in sorted(counted)}
            for name, counted in self.bins.items()
            if name in Stats.__dataclass_fields__
        }
        return Stats(
            **named,
            **bins,
            errors=_percentiles(self.errors, 50),
            high_errors=_percentiles(self.errors, _HIGH_PERCENT),
            channel_seconds={name: float(np.mean(rows)) for name, rows in self.of_channels.items()},
            seconds=self.seconds,
            core_seconds=self.core_seconds,
            bytes=self.bytes,
        )


def _doubles() -> "array[float]":
    # Millions of them: a list would take four times as much.
    return array("d")


def _percentiles(numbers: _Numbers, percent: float) -> dict[str, float]:
    return {name: float(np.percentile(numbers[name], percent)) for name in sorted(numbers)}


def _table_name(channel: str) -> str:
    """That of the table: one name for a channel of all lights."""
    with suppress(KeyError):
        return definition(channel).name
    return channel


def _lower_end(value: float) -> float:
    """Where the bin of a value of at least 1 begins: 1, 2, 5, 10, 20, 50 and so on."""
    decade = 10.0 ** math.floor(math.log10(value))
    return max(step * decade for step in _STEPS if step * decade <= value or step == 1)
