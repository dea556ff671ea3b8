"""The exception tree: what can go wrong, said so that a person can mend it.

::

    OrusdError
    ├── DescriptionError    a mistake in room.yaml (one error lists all of them)
    ├── InputError          a file that is read is missing, unreadable or holds nonsense
    │   ├── UnknownNameError    a result holds nothing of that name; a KeyError too
    │   └── SparseScanError     a scan can be read and shows too little of a room
    ├── OutputError         a file cannot be written
    ├── StageError          a USD stage or prim is not what the operation needs
    ├── RenderError         a renderer cannot do what is asked of it
    └── MissingPackageError an optional package or system library is not installed

Every error carries a stable code, the message, the place (file, field or prim) and a remedy. The
command line prints ``str(error)`` and exits with ``exit_code``; users never need a traceback.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

# What moves a terminal's cursor, colours it, changes the direction of writing or is not a
# character.
_UNPRINTABLE: Final = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ud800-\udfff]"
)


def printable(text: object, *, lines: bool = True) -> str:
    """A text that holds names from files, such that a terminal only shows it.

    Args:
        text: Anything.
        lines: Whether line breaks stay; in a name alone they are escaped too.

    Returns:
        The text with control characters, marks of direction and lone surrogates as escapes.
    """
    shown = _UNPRINTABLE.sub(_escaped, str(text))
    return shown if lines else shown.replace("\n", "\\n")


def _escaped(found: re.Match[str]) -> str:
    code = ord(found[0])
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"


class OrusdError(Exception):
    """Anything this package refuses, with its place and its remedy.

    Args:
        message: What is wrong, in one sentence.
        place: The file, ``file:line:column``, field path or prim path that is to blame.
        remedy: What to do about it.
    """

    code = "orusd"
    exit_code = 1

    def __init__(self, message: str, *, place: object = None, remedy: str | None = None) -> None:
        self.message = message
        self.place = None if place is None else str(place)
        self.remedy = remedy
        super().__init__(message)

    def __str__(self) -> str:
        # Lists in a message have lines of their own; a place is one name.
        place = f"{printable(self.place, lines=False)}: " if self.place else ""
        remedy = f"\n  remedy: {printable(self.remedy)}" if self.remedy else ""
        return f"{place}{printable(self.message)}{remedy}"

    def as_dict(self) -> dict[str, str | None]:
        """The error as plain data, for ``--json``."""
        return {
            "code": self.code,
            "message": self.message,
            "place": self.place,
            "remedy": self.remedy,
        }


class DescriptionError(OrusdError):
    """A room description is not valid; the message lists every mistake in it."""

    code = "description"
    exit_code = 2


class InputError(OrusdError):
    """A file or value that is read is missing, unreadable or holds nonsense."""

    code = "input"
    exit_code = 2


class UnknownNameError(InputError, KeyError):
    """A result that reads like a mapping holds nothing of that name."""


class SparseScanError(InputError):
    """A scan shows too little of a room to find one."""


class OutputError(OrusdError):
    """A file or folder cannot be written."""

    code = "output"
    exit_code = 3


class StageError(OrusdError):
    """A USD stage or prim is not what the operation needs."""

    code = "stage"
    exit_code = 4


class RenderError(OrusdError):
    """A renderer cannot do what is asked of it."""

    code = "render"
    exit_code = 5


class MissingPackageError(OrusdError):
    """An optional package or a system library is not installed."""

    code = "missing-package"
    exit_code = 6


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn the operating system's refusal to write into an `OutputError`.

    Args:
        path: The file or folder that is written inside the ``with`` block.

    Raises:
        OutputError: The folder is read-only, the disk is full, or the path is taken.
    """
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(
            f"cannot write: {reason}",
            place=path,
            remedy="choose another output folder, or free space and set its permissions",
        ) from error
