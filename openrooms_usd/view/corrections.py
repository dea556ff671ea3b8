"""What all pages share in which people correct a room: taking back, composing, telling."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from openrooms_usd import names
from openrooms_usd.compose import compose_room
from openrooms_usd.description import load_room
from openrooms_usd.description.alignment import ScanAlignment
from openrooms_usd.edits.history import History
from openrooms_usd.errors import InputError
from openrooms_usd.usd.diagnostics import quiet
from openrooms_usd.view.app import Command, Nothing
from openrooms_usd.view.targets import Edits, Target


@dataclass
class Corrections:
    """A room that somebody corrects.

    Attributes:
        target: Where the corrections are written.
        description: The room.yaml that it is composed from; None where nobody has named it.
        history: What was done to the file that the corrections are written to.
        notes: What the last composition said.
    """

    target: Target
    description: Path | None
    history: History
    notes: list[str] = field(default_factory=list)
    _composed: bool = False

    def told(self) -> dict[str, Any]:
        """What can be taken back and composed, and the version of the file."""
        return {
            **self.history.told(),
            "composes": self.description is not None,
            "notes": self.notes,
        }

    def done(
        self, change: Callable[[], Mapping[str, Any]], *, bares: bool = False
    ) -> dict[str, Any]:
        """Do something that can be taken back, and tell what came of it.

        Args:
            change: What is done.
            bares: Whether stages may have left something out because of what is no more.
        """
        with quiet(), self.history.step():
            found = change()
        if bares:
            self._follow()
        return {**found, **self.told()}

    def _follow(self) -> None:
        """Stages leave out what edits say: without the edit it must be made again."""
        if self._composed and self.description is not None:
            self.compose()

    def compose(self) -> dict[str, Any]:
        """Compose the room again, so that everything follows what was changed.

        Raises:
            InputError: Nobody has said by which description.
            OrusdError: It does not compose.
        """
        if self.description is None:
            raise InputError(
                "nobody has said which description this room is composed from",
                place=self.target.scene,
                remedy="open the page with --description room.yaml, or run orusd compose",
            )
        with quiet():
            done = compose_room(self.description, self.target.scene.parent)
        self._composed = True
        self.notes = [*(note for row in done.stages for note in row.notes), *done.notes]
        return self.told()

    def _undo(self, _: Nothing) -> dict[str, Any]:
        self.history.undo()
        self._follow()
        return self.told()

    def _redo(self, _: Nothing) -> dict[str, Any]:
        self.history.redo()
        self._follow()
        return self.told()

    def commands(self) -> dict[str, Command[Any]]:
        """Those that every page of corrections has."""
        return {
            "version": Command(Nothing, lambda _: self.told()),
            "undo": Command(Nothing, self._undo),
            "redo": Command(Nothing, self._redo),
            "compose": Command(Nothing, lambda _: self.compose()),
        }


def corrections(
    room: Path, description: Path | None = None, out: Path | None = None
) -> Corrections:
    """Corrections of a composed room, which go to its edits, or of a description, which go there.

    Args:
        room: The ``scene.usda`` of a composed room, or a room.yaml, which is composed first.
        description: What a composed room is composed from, to compose it again.
        out: Where a room.yaml is composed to; by default ``composed`` beside it.

    Raises:
        InputError: It is no composed room.
        OrusdError: The description does not compose.
    """
    if room.suffix in (".yaml", ".yml"):
        from openrooms_usd.view.describing import Described
        from openrooms_usd.view.fields import Fields
        from openrooms_usd.view.hints import Hints

        is_scan = isinstance(load_room(room).alignment, ScanAlignment)
        described = Described(room, (out or room.parent / "composed") / names.SCENE)
        with quiet():
            described.compose()
        fields = Hints(described) if is_scan else Fields(described)
        return Corrections(fields, room, History(room), _composed=True)
    target = Edits(room, description.parent if description else None)
    if not (room.is_file() and target.file.is_file()):
        raise InputError(
            "this is no composed room",
            place=room,
            remedy="compose a room first: `orusd compose room.yaml -o out`",
        )
    return Corrections(target, description, History(target.file))
