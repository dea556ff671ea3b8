"""The plan of a dataset: what there is to do, as data that follows from its file and the code.

A unit is one view of one variant of one room. A job is what is opened together: the views of one
variant of one room. Jobs come one after the other and are never held all at once: a million units
take no memory.
"""

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from itertools import groupby
from operator import itemgetter
from pathlib import Path, PurePosixPath
from typing import Any, Final

from openrooms_usd import adapters
from openrooms_usd.codedigest import code_digest
from openrooms_usd.description import load_room
from openrooms_usd.description.dataset import (
    SPLITS,
    CapturedRooms,
    Dataset,
    DescribedRooms,
    GeneratedRooms,
    Split,
)
from openrooms_usd.errors import InputError, OrusdError
from openrooms_usd.furniture import registry
from openrooms_usd.names import STEPS
from openrooms_usd.portable import in_order
from openrooms_usd.untrusted import check_path, opened

# What makes the views of a job, but for what is loaded by name.
_MAKERS: Final = ("openrooms_usd.dataset.work", "openrooms_usd.generation")
_STEPS: Final = "openrooms_usd.steps"
# The fractional part of the golden ratio: multiples of it fill 0 to 1 evenly, however many.
_GOLDEN: Final = 0.6180339887498949
# The parts of a dataset.yaml that its views depend on, beside their room.
_OF_VIEWS: Final = {"views", "channels", "budget", "rendering", "sensor", "storage"}
_LARGEST_SEED: Final = 2**31
_KEY_DIGITS: Final = 32


@dataclass(frozen=True)
class PlannedRoom:
    """A room of the plan.

    Attributes:
        name: What its folders are called.
        number: Its place among all rooms of the dataset.
        source: What makes it: ``type``, ``seed``, ``clutter`` and ``style`` of a generated room,
            ``file`` and its ``sha256`` of a described or captured one, and that of the ``inputs``
            it names.
        split: What it is for.
    """

    name: str
    number: int
    source: Mapping[str, Any]
    split: Split


@dataclass(frozen=True)
class Job:
    """The views of one variant of one room.

    Attributes:
        room: The room.
        variant: As what it is rendered.
        seed: Draws what is other in the variant.
        key: Names all that determines its files: unequal where they may differ.
        views: The numbers of its views.
    """

    room: PlannedRoom
    variant: str
    seed: int
    key: str
    views: tuple[int, ...]

    @property
    def name(self) -> str:
        """The room and the variant, as a path."""
        return f"{self.room.name}/{self.variant}"

    def units(self) -> list[str]:
        """The names of its units, as paths."""
        return [f"{self.name}/{view_name(number)}" for number in self.views]

    def as_dict(self) -> dict[str, Any]:
        """Plain data that `job_of` makes the job of again."""
        return asdict(self)


def job_of(data: Mapping[str, Any]) -> Job:
    """A job from plain data."""
    rest = {**data, "room": PlannedRoom(**data["room"]), "views": tuple(data["views"])}
    return Job(**rest)


def view_name(number: int) -> str:
    """What the folder of a view is called."""
    return f"view_{number}"


def plan_rooms(dataset: Dataset) -> Iterator[PlannedRoom]:
    """The rooms of a dataset, in its order.

    Rooms that are added at the end change nothing of those before them.

    Raises:
        InputError: A description is not there.
    """
    number = 0
    taken: dict[str, int] = {}
    for part, rooms in enumerate(dataset.rooms):
        if isinstance(rooms, GeneratedRooms):
            for index in range(rooms.count):
                kind = rooms.types[index % len(rooms.types)]
                seed = _derive_seed(dataset.seed, "room", part, kind, index) % _LARGEST_SEED
                source: dict[str, Any] = {
                    "type": kind,
                    "seed": seed,
                    "clutter": rooms.clutter,
                    "style": rooms.style,
                }
                yield PlannedRoom(f"{kind}_{number}", number, source, _split(dataset, number))
                number += 1
            continue
        for file in rooms.files:
            name = _room_name(file, taken)
            # A room.yaml that is wrong is found when its turn comes: the rest goes on.
            source = _source(dataset, rooms, file)
            yield PlannedRoom(name, number, source, _split(dataset, number))
            number += 1


def plan_jobs(dataset: Dataset) -> Iterator[Job]:
    """The jobs of a dataset, room by room.

    Raises:
        InputError: A description is not there, or there is no such renderer.
    """
    settings = {
        **dataset.model_dump(mode="json", include=_OF_VIEWS),
        "code": code_of(dataset.rendering.renderer),
    }
    # Sorted and written once: jobs are many.
    shared = json.dumps(settings, sort_keys=True)
    views = tuple(range(dataset.views.units))
    for room in plan_rooms(dataset):
        source = json.dumps(room.source, sort_keys=True)
        for variant in dataset.variants:
            seed = _derive_seed(dataset.seed, "variant", room.name, variant) % _LARGEST_SEED
            text = f"{shared}\n{room.name}\n{source}\n{variant}\n{seed}"
            key = hashlib.sha256(text.encode()).hexdigest()[:_KEY_DIGITS]
            yield Job(room, variant, seed, key, views)


def lines(jobs: Iterable[Job]) -> Iterator[str]:
    """A plan as text: one line of JSON for each unit."""
    for job in jobs:
        shared = json.dumps(
            {
                "key": job.key,
                "number": job.room.number,
                "room": job.room.name,
                "seed": job.seed,
                "source": job.room.source,
                "split": job.room.split,
                "variant": job.variant,
            }
        )
        for number, unit in zip(job.views, job.units(), strict=True):
            yield f'{shared[:-1]}, "unit": "{unit}", "view": {number}}}'


def jobs_of(text: Iterable[str]) -> Iterator[Job]:
    """The jobs of a plan as text.

    Raises:
        ValueError: It is not such a text.
        KeyError: As ValueError.
    """
    rows = (json.loads(line) for line in text)
    for key, units in groupby(rows, key=itemgetter("key")):
        found = list(units)
        row = found[0]
        room = PlannedRoom(row["room"], row["number"], row["source"], row["split"])
        views = tuple(int(unit["view"]) for unit in found)
        yield Job(room, row["variant"], row["seed"], key, views)


def _derive_seed(seed: int, *key: str | int) -> int:
    """A whole number that depends on a seed and a key alone."""
    text = json.dumps([seed, "dataset", *key]).encode()
    return int.from_bytes(hashlib.sha256(text).digest()[:8], "big")


def _split(dataset: Dataset, number: int) -> Split:
    """What a room is for: any run of rooms in their order has nearly the shares that are asked."""
    at = (_derive_seed(dataset.seed, "split") / 2**64 + number * _GOLDEN) % 1.0
    total = 0.0
    for name in SPLITS:
        total += getattr(dataset.splits, name)
        if at < total:
            return name
    return next(name for name in reversed(SPLITS) if getattr(dataset.splits, name) > 0.0)


def _room_name(file: str, taken: dict[str, int]) -> str:
    """A name that no other room has: its folder's, and a number where that repeats."""
    path = PurePosixPath(file)
    words = path.parent.name if path.stem == "room" and path.parent.name else path.stem
    plain = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in words)
    first = name = f"room_{plain}"
    while name in taken:
        taken[first] += 1
        name = f"{first}_again_{taken[first]}"
    taken[name] = 1
    return name


def _source(dataset: Dataset, rooms: DescribedRooms | CapturedRooms, file: str) -> dict[str, Any]:
    """What makes a described or captured room."""
    told = rooms.model_dump(mode="json", exclude={"source", "files"}, exclude_none=True)
    if isinstance(rooms, CapturedRooms):
        digest = capture_digest(dataset.folder, file, rooms.options)
        return {"file": file, "sha256": digest, **told}
    source = {"file": file, "sha256": file_digest(dataset.folder / file), **told}
    if inputs := inputs_digest(dataset.folder / file):
        source["inputs"] = inputs
    return source


@cache
def code_of(renderer: str) -> str:
    """A digest of all code that makes views.

    Args:
        renderer: The name of the renderer.

    Raises:
        InputError: There is no such renderer.
    """
    drawing = adapters.find(adapters.RENDERERS, renderer).module
    importers = sorted(point.module for point in adapters.available(adapters.IMPORTERS).values())
    steps = [f"{_STEPS}.runner", *(f"{_STEPS}.{name}.step" for name in STEPS)]
    return code_digest(*_MAKERS, *steps, *registry.modules(), *importers, drawing)


def file_digest(path: Path) -> str:
    """The SHA-256 of a file.

    Raises:
        InputError: It is not there, or cannot be read.
    """
    remedy = "paths in a dataset.yaml are relative to its folder"
    with opened(path, "frames", remedy=remedy) as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def capture_digest(folder: Path, file: str, options: Mapping[str, str]) -> str:
    """A digest of a capture, and of the files that its importer's options name.

    Args:
        folder: Where names of files begin.
        file: What the importer reads; of a folder the names and the sizes of its files count, for
            it may hold gigabytes.
        options: What is asked of the importer.

    Raises:
        InputError: It is not there, or cannot be read.
    """
    root = folder / file
    check_path(root)
    if not root.is_dir():
        own = file_digest(root)
    else:
        found = in_order(path for path in root.rglob("*") if path.is_file())
        rows = [(path.relative_to(root).as_posix(), path.stat().st_size) for path in found]
        own = hashlib.sha256(json.dumps(rows).encode()).hexdigest()
    named = [folder / value for _, value in sorted(options.items()) if _is_file(folder / value)]
    digests = [own, *map(file_digest, named)]
    return own if not named else hashlib.sha256(json.dumps(digests).encode()).hexdigest()


def _is_file(path: Path) -> bool:
    """Whether a value names a file; most are something else."""
    with suppress(InputError):
        check_path(path)
        return path.is_file()
    return False


def inputs_digest(description: Path) -> str | None:
    """A digest of all files that a room is made of because its room.yaml names them.

    Returns:
        None where there are none; and where the room.yaml is wrong or a file is missing, which is
        said when the room's turn comes.
    """
    from openrooms_usd.steps import runner

    with suppress(OrusdError):
        room, folder = load_room(description), description.parent
        names = sorted({name for step in runner.steps() for name in step.inputs(room, folder)})
        digest = hashlib.sha256()
        for name in names:
            digest.update(f"{file_digest(folder / name)}  {name}\n".encode())
        return digest.hexdigest() if names else None
    return None
