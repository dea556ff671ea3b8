"""What a step is, what it is given, and what its layer depends on; `runner` runs it."""

import hashlib
import json
import re
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol

import numpy as np

from openrooms_usd import adapters, names
from openrooms_usd.codedigest import code_digest
from openrooms_usd.description.mistakes import FieldsError
from openrooms_usd.description.room import Room
from openrooms_usd.description.scanned import CapturedSection
from openrooms_usd.draws import generator
from openrooms_usd.errors import InputError
from openrooms_usd.progress import Progress, silent
from openrooms_usd.spelling import did_you_mean
from openrooms_usd.untrusted import check_path, kind_of

if TYPE_CHECKING:
    from pxr import Sdf, Usd

# What writes the layer of every step, beside the step itself.
_RUNNER: Final = "openrooms_usd.steps.runner"
# A section counts as it is, whatever else a description might say.
_APART: Final = ("openrooms_usd.description.categories",)
# A module that a step asked for by name, as `codedigest.count` takes it.
_COUNTED: Final = re.compile(r"openrooms_usd(\.[a-z_]\w*)+(\.\*)?")


@dataclass(frozen=True)
class StepContext:
    """What a step is given.

    Attributes:
        room: The whole description; a step reads its own section, the room type and the seed.
        source: The folder of the description: its relative file names start here.
        stage: The composed stage of all weaker layers, the layer to write and ``edits.usda``. All
            edits go to the layer to write.
        folder: ``layers/<step name>``, for the files that only this layer refers to. Asset paths
            in the layer are relative to the layer: ``./<step name>/<file>``.
        workers: How many threads the step may use. The result never depends on it.
        progress: Called with what is being done, and the finished fraction of the step.
        notes: Sentences for the user: what was approximated or guessed.
    """

    room: Room
    source: Path
    stage: "Usd.Stage"
    folder: Path
    workers: int = 1
    progress: Progress = silent
    notes: list[str] = field(default_factory=list)
    _kept: set[str] = field(default_factory=set)

    def rng(self, *key: str) -> np.random.Generator:
        """A generator that depends on the seed and the key alone.

        Key it by the step and the object's name, so that adding one object changes no other.
        """
        return generator(self.room.seed, *key)

    def keep(self, relative: str) -> Path:
        """Name a file (or a folder of files) that the layer refers to.

        What is not kept is removed from ``folder`` after the layer was saved. Name files by their
        content or by what determines it: a file that is already there is then not written again.

        Args:
            relative: The path below ``folder``, with forward slashes.

        Returns:
            ``folder / relative``.
        """
        self._kept.add(relative)
        return self.folder / relative

    def asset(self, relative: str) -> str:
        """The anchored asset path for the layer of a kept file: ``./<step name>/<relative>``."""
        return f"./{self.folder.name}/{relative}"

    def kept(self) -> frozenset[str]:
        """Everything that was named by `keep`."""
        return frozenset(self._kept)

    def input(self, relative: str) -> Path:
        """An input file of the description.

        Raises:
            InputError: It does not exist, or cannot be read.
        """
        return input_file(self.source, relative)

    def check_named(
        self, key: str, known: Collection[str], off: str, kind: str = "", lacking: str = ""
    ) -> None:
        """Refuse objects of the description that are not there; note those that are deactivated.

        Args:
            key: Where their names stand, such as ``lights.lamps``: keys of a mapping.
            known: The names that may stand there.
            off: What follows of one that is deactivated.
            kind: What they are.
            lacking: What is wrong with an existing object that is not one of these.

        Raises:
            DescriptionError: One is not there.
        """
        from openrooms_usd.usd.files.layers import is_deactivated

        wrong = []
        for name in attrgetter(key)(self.room):
            path = f"{names.FURNITURE}/{name}"
            if name in known:
                continue
            if is_deactivated(self.stage, path):
                self.notes.append(f"{name}: deactivated, {off}")
                continue
            said = f"there is no {kind or 'object'} {name!r}{did_you_mean(name, known)}"
            if lacking and self.stage.GetPrimAtPath(path):
                said = f"{name} {lacking}"
            there = ", ".join(list(known)[:30]) or "none"
            given = f"{said}; {f'{kind}s' if kind else 'there'} are: {there}"
            wrong.append(((*key.split("."), name), given))
        if wrong:
            raise FieldsError(*wrong)


def input_file(source: Path, relative: str, *, folders: bool = False) -> Path:
    """A file that a description names, relative to the description's folder.

    Args:
        source: The description's folder.
        relative: What it names.
        folders: Whether a folder will do.

    Raises:
        InputError: It does not exist, or cannot be looked at.
    """
    path = source / relative
    check_path(path)
    with _reading(path):
        what = kind_of(path)
    if what != "a file" and not (folders and what == "a folder"):
        raise InputError(
            f"this is {what}, not a file" if what else "no such file",
            place=path,
            remedy="name a file in it"
            if what == "a folder"
            else "paths in a description are relative to the folder that it lies in",
        )
    return path


class Step(Protocol):
    """One step of the pipeline: writes one layer and the files that only this layer refers to."""

    name: str
    """One of `openrooms_usd.names.STEPS`."""

    reads: tuple[str, ...]
    """The weaker steps whose prims this one looks at."""

    def inputs(self, room: Room, source: Path) -> Iterable[str]:
        """The files that this step reads, relative to the description.

        Args:
            room: The description, which names them.
            source: The description's folder, for what the named files refer to in turn.
        """
        ...

    def author(self, context: StepContext) -> None:
        """Write the layer through ``context.stage``.

        Raises:
            OrusdError: The description asks for something impossible.
        """
        ...


def fingerprint(step: Step, room: Room, source: Path, layer: Callable[[str], Path]) -> str:
    """A hash of everything that a step's layer depends on, before it has run.

    That is: the code that it runs, the step's section, the room type, the seed, the style, its
    input files, the layers that it reads, and the human edits. The room's name is read by no step.

    Args:
        step: The step.
        room: The description.
        source: The description's folder.
        layer: Where the layer of a name lies.

    Returns:
        64 hexadecimal digits.

    Raises:
        InputError: An input file is missing, or cannot be read.
    """
    section = getattr(room, names.section_of(step.name))
    parts: dict[str, Any] = {
        "stage": step.name,
        "code": code_digest(*code_of(step), *_adapters(room), apart=_APART),
        "section": section and section.model_dump(mode="json"),
        "room": [room.room, room.seed, room.style],
        "inputs": {
            name: file_digest(input_file(source, name)) for name in step.inputs(room, source)
        },
        "reads": {
            name: file_digest(path)
            for name in (*step.reads, names.EDITS)
            if (path := layer(name)).is_file()
        },
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def completed(before: str, counted: Iterable[str]) -> str:
    """The fingerprint of a step's layer, with the modules that the step asked for by name.

    Equal code on equal inputs asks for equal modules: so a layer is current when those of its last
    run, and all that its `fingerprint` covers, are what they were.

    Args:
        before: The `fingerprint`.
        counted: What `codedigest.counting` found; names that are not our modules are left out.

    Returns:
        64 hexadecimal digits.
    """
    names = sorted(name for name in counted if _COUNTED.fullmatch(str(name)))
    code = code_digest(*names, apart=_APART) if names else ""
    return hashlib.sha256(f"{before} {code}".encode()).hexdigest()


def record_of(layer: "Sdf.Layer", step: str) -> dict[str, Any]:
    """What a step noted in its layer when it wrote it; nothing in other layers."""
    data: Any = layer.customLayerData
    for key in (names.NAMESPACE, "stages", step):
        data = data.get(key, {}) if isinstance(data, dict) else {}
    return data if isinstance(data, dict) else {}


def code_of(step: Step) -> tuple[str, ...]:
    """The modules that a step's layer hangs on, beside those that it asks for by name."""
    return type(step).__module__, _RUNNER


def _adapters(room: Room) -> Iterator[str]:
    """The modules of importers and segmenters that fill sections; what is missing is said later."""
    sections = [s for s in (room.layout, room.furniture) if isinstance(s, CapturedSection)]
    known = adapters.available(adapters.IMPORTERS) if sections else {}
    yield from (known[s.reader].module for s in sections if s.reader in known)
    segmenter = getattr(room.furniture, "segmenter", None)
    known = adapters.available(adapters.SEGMENTERS) if segmenter else {}
    yield from (known[name].module for name in (segmenter,) if name in known)


def file_digest(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal.

    Raises:
        InputError: It cannot be read.
    """
    with _reading(path), path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@contextmanager
def _reading(path: Path) -> Iterator[None]:
    """Turn the operating system's refusal to read into an `InputError`."""
    try:
        yield
    except OSError as error:
        raise InputError(
            f"cannot read: {error.strerror or error}",
            place=path,
            remedy="check that it is a file, and its permissions",
        ) from error
