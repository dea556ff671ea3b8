"""Fields of a room.yaml, changed as people say: objects and materials; the rest of it stays.

Every change is composed before it counts: what compose refuses is refused in its words, and the
file is as it was. Names stay: what had none, and would be called otherwise now, gets its own.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from openrooms_usd import atomic, untrusted
from openrooms_usd.composing import ComposeSummary, compose_room
from openrooms_usd.description.files import parse_room
from openrooms_usd.description.former import name_in
from openrooms_usd.description.furniture import object_names
from openrooms_usd.description.reading import read_yaml
from openrooms_usd.description.rewriting import rewritten
from openrooms_usd.errors import InputError

# Which key of the furniture lists objects, by where it comes from; elsewhere it is ``objects``.
_LISTS: Final = {"scan": "further"}

Change = Callable[[dict[str, Any]], Mapping[str, Any]]


@dataclass(frozen=True)
class Described:
    """A room by its description.

    Attributes:
        file: The room.yaml.
        scene: The ``scene.usda`` that it is composed to.
    """

    file: Path
    scene: Path

    def compose(self) -> ComposeSummary:
        """Compose it.

        Raises:
            OrusdError: It does not compose.
        """
        return compose_room(self.file, self.scene.parent)

    def section(self, name: str) -> dict[str, Any]:
        """A section as plain data, as it is written."""
        data, _ = read_yaml(self._text(), self.file.name)
        held = data.get(name_in(data, name))
        return dict(held) if isinstance(held, Mapping) else {}

    def change(self, section: str, change: Change) -> ComposeSummary:
        """Give keys of a section other values, and compose.

        Args:
            section: Such as ``materials``.
            change: Gives the new values of keys, of the section as it is; None leaves a key out.

        Raises:
            OrusdError: The description would be invalid, or does not compose: it stays as it was.
        """
        text = self._text()
        made = rewritten(text, section, change(self.section(section)), self.file.name)
        parse_room(made, str(self.file), folder=self.file.parent)
        before = untrusted.read_bytes(self.file, "description")
        atomic.write_bytes(self.file, made.encode())
        try:
            return self.compose()
        except BaseException:
            atomic.write_bytes(self.file, before)
            raise

    def change_objects(self, change: Callable[["Objects"], None]) -> ComposeSummary:
        """Change the list of objects, and compose.

        Raises:
            InputError: An object is not in the list.
            OrusdError: The description would be invalid, or does not compose: it stays as it was.
        """

        def listed(section: dict[str, Any]) -> dict[str, Any]:
            key = _LISTS.get(section.get("from", "objects"), "objects")
            found = Objects(self.file, [dict(thing) for thing in section.get(key) or ()])
            change(found)
            return {key: found.pinned()}

        return self.change("furniture", listed)

    def _text(self) -> str:
        return untrusted.read_bytes(self.file, "description").decode("utf-8")


class Objects:
    """The objects that a description lists, by their names."""

    def __init__(self, file: Path, rows: list[dict[str, Any]]) -> None:
        self._file = file
        self._names = object_names(rows) or []
        self.rows = dict(zip(self._names, rows, strict=False))

    def __getitem__(self, name: str) -> dict[str, Any]:
        if name not in self.rows:
            raise InputError(
                f"{name} is not in this description's list of objects",
                place=self._file,
                remedy="correct the composed room: orusd edit objects out/scene.usda",
            )
        return self.rows[name]

    def pinned(self) -> list[dict[str, Any]]:
        """The rows; those that would be called otherwise now have their names of before."""
        rows = list(self.rows.values())
        while (names := object_names(rows)) != list(self.rows):
            for name, was, row in zip(names or (), self.rows, rows, strict=True):
                if name != was:
                    row.setdefault("name", was)
        return [{"name": row["name"], **row} if "name" in row else row for row in rows]
