"""Changes of one file taken back, and made again: the bytes that it had before each of them."""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from openrooms_usd import atomic, untrusted
from openrooms_usd.errors import InputError


@dataclass
class History:
    """What a file was before each change that a person made here.

    Attributes:
        file: The file, such as ``layers/edits.usda``.
    """

    file: Path
    _before: list[bytes] = field(default_factory=list)
    _after: list[bytes] = field(default_factory=list)
    _left: bytes = b""

    @contextmanager
    def step(self) -> Iterator[None]:
        """Remember what the file was, if the block changes it; nothing when the block raises."""
        before = self._content()
        yield
        now = self._content()
        if now == before:
            return
        if self._before and before != self._left:
            # Another program has written meanwhile: its work is not ours to take back.
            self._before.clear()
        self._before.append(before)
        self._after.clear()
        self._left = now

    def undo(self) -> None:
        """Take the last change back.

        Raises:
            InputError: There is none, or another program has written the file since.
            OutputError: The file cannot be written.
        """
        self._go(self._before, self._after, "there is nothing to take back")

    def redo(self) -> None:
        """Make the change again that was taken back last.

        Raises:
            InputError: There is none, or another program has written the file since.
            OutputError: The file cannot be written.
        """
        self._go(self._after, self._before, "there is nothing to make again")

    def told(self) -> dict[str, int | str]:
        """How many changes can be taken back and made again, and which version the file is."""
        version = hashlib.sha256(self._content()).hexdigest()[:16]
        return {"undo": len(self._before), "redo": len(self._after), "version": version}

    def _content(self) -> bytes:
        return untrusted.read_bytes(self.file, "usd" if self.file.suffix == ".usda" else "text")

    def _go(self, source: list[bytes], other: list[bytes], nothing: str) -> None:
        if not source:
            raise InputError(nothing)
        now = self._content()
        if now != self._left:
            source.clear()
            other.clear()
            raise InputError(
                "another program has changed this file since: taking back would lose that",
                place=self.file,
                remedy="change it there, or go on from what it is now",
            )
        atomic.write_bytes(self.file, source[-1])
        self._left = source.pop()
        other.append(now)
