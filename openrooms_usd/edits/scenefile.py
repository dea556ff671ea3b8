"""A USD file that is read as it is now, and what it holds by name."""

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Final, Generic, TypeVar

from pxr import Usd

from openrooms_usd.edits.editing import being_edited
from openrooms_usd.errors import UnknownNameError
from openrooms_usd.spelling import did_you_mean
from openrooms_usd.usd.files.diagnostics import quiet
from openrooms_usd.usd.files.layers import open_stage

Value = TypeVar("Value")
_NUMBERED: Final = re.compile(r"\[\d+\]$")


class ByName(Mapping[str, Value], Generic[Value]):
    """What a scene holds of a kind, by name or by the path of its prim.

    Where several prims have one name, their paths stand in its place.
    """

    def __init__(
        self,
        what: str,
        place: Path,
        found: Mapping[str, Value],
        also: Mapping[str, Value] = MappingProxyType({}),
    ) -> None:
        """Name what was found.

        Args:
            what: What it is, for messages.
            place: The scene.
            found: By the path of its prim.
            also: What has no name here, and is found by its path alone.
        """
        self._what, self._place, self._found = what, place, {**also, **found}
        short = [getattr(value, "name", path) for path, value in found.items()]
        self._names = {
            name if short.count(name) == 1 else path: path
            for name, path in zip(short, found, strict=True)
        }

    def __getitem__(self, name: str) -> Value:
        # One of many that an instancer draws goes by its number: /World/Chairs[3].
        plain = _NUMBERED.sub("", name) if isinstance(name, str) else name
        path = self._names.get(plain, plain)
        if path in self._found:
            return self._found[path]
        near = did_you_mean(name, list(self._names))
        there = f"there are: {', '.join(list(self._names)[:30])}" if self._names else None
        raise UnknownNameError(
            f"no {self._what} is named {name!r}{near}", place=self._place, remedy=there
        )

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __len__(self) -> int:
        return len(self._names)

    def __repr__(self) -> str:
        return f"{{{', '.join(f'{name!r}: {value!r}' for name, value in self.items())}}}"


@dataclass
class SceneFile:
    """A USD file that is read again when it, or what it is made of, has changed.

    Attributes:
        path: The file.
    """

    path: Path
    _stage: Usd.Stage | None = field(default=None, repr=False)
    _files: tuple[Path, ...] = field(default=(), repr=False)
    _stamps: list[tuple[int, int]] = field(default_factory=list, repr=False)

    def stage(self) -> Usd.Stage:
        """The stage as it is now, or as a block of `editing` has it.

        Raises:
            InputError: The file is missing or no readable USD.
        """
        if (open_now := being_edited(self.path)) is not None:
            return open_now
        if self._stage is None or self._stamps != _stamps(self._files):
            with quiet():
                self._stage = open_stage(self.path)
            layers = self._stage.GetUsedLayers()
            real = sorted(layer.realPath for layer in layers if layer.realPath)
            self._files = tuple(map(Path, real))
            self._stamps = _stamps(self._files)
        return self._stage


def _stamps(files: Iterable[Path]) -> list[tuple[int, int]]:
    """When each file was written, and its size; files inside of packages have none."""
    found = []
    for file in files:
        with suppress(OSError):
            status = file.stat()
            found.append((status.st_mtime_ns, status.st_size))
    return found
