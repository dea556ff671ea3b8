"""One run a dataset behind a URL: a file there says who has it, and that who has it is alive.

The file is put on condition that it is not there, where the server knows conditions (S3 does:
``If-None-Match``); else somebody looks for it before. Its holder writes it anew every few seconds.
Who finds one that does not change for a while takes it over: only changes are looked at, so that no
clock counts. Two that take over at the same moment are told apart when each reads it again.
"""

import json
import os
import secrets
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Final

from openrooms_usd.dataset.remote import RemoteFolder
from openrooms_usd.errors import OrusdError, OutputError
from openrooms_usd.urls import shown

FILE: Final = ".orusd.lease.json"
# How often the holder writes, how long one waits for that, and how long a claim is let rest.
BEAT_S: Final = 5.0
STALE_S: Final = 30.0
REST_S: Final = 1.0


class Lease:
    """What a run has as long as it lasts.

    Args:
        remote: Where the dataset lies.
        ended: The clock: what the holder waits by, until it is set.

    Attributes:
        lost: Whether somebody else has taken it.
    """

    def __init__(self, remote: RemoteFolder, ended: threading.Event | None = None) -> None:
        self.lost = False
        self._remote, self._beats, self._ended = remote, 0, ended or threading.Event()
        # Whose it is, for people, and which of their runs.
        self._who = {"host": socket.gethostname(), "process": os.getpid()}
        self._run = secrets.token_hex(8)

    def check(self) -> None:
        """See that the run still has it.

        Raises:
            OutputError: Somebody else has taken it.
        """
        if self.lost:
            raise OutputError(
                "another run has taken this dataset over",
                place=shown(self._remote.url),
                remedy="let that one go on; what was finished here stays",
            )

    def take(self) -> None:
        """Get it.

        Raises:
            OutputError: Another run has it.
        """
        if not self._remote.put_text(FILE, self._text(), new=True):
            self._await_end()
            self._remote.remove([FILE])
            if not self._remote.put_text(FILE, self._text(), new=True):
                raise self._held()
        self._ended.wait(REST_S)
        if not self._is_ours():
            raise self._held()

    def keep(self) -> None:
        """Say that its holder is alive, until it is given back or lost."""
        while not self._ended.wait(BEAT_S) and not self.lost:
            # A server that does not answer for a moment takes nothing away.
            with suppress(OrusdError):
                self.beat()

    def beat(self) -> None:
        """Say once that its holder is alive, or find that somebody else has taken it."""
        self.lost = not self._is_ours()
        if not self.lost:
            self._beats += 1
            self._remote.put_text(FILE, self._text())

    def end(self) -> None:
        """Say no more that its holder is alive."""
        self._ended.set()

    def give_back(self) -> None:
        """Let others have it, once nobody keeps it."""
        with suppress(OrusdError):
            if self._is_ours():
                self._remote.remove([FILE])

    def _await_end(self) -> None:
        """Wait until who has it is gone.

        Raises:
            OutputError: It is alive.
        """
        before = self._remote.read(FILE)
        if self._is_of_the_dead(before):
            return
        for _ in range(int(STALE_S / REST_S)):
            self._ended.wait(REST_S)
            now = self._remote.read(FILE)
            if now is None:
                return
            if now != before:
                raise self._held(now)

    def _is_of_the_dead(self, data: bytes | None) -> bool:
        """Whether it is of a process of this machine that is gone: nobody need wait for it."""
        try:
            told = json.loads(data or b"{}")
            if told["host"] == self._who["host"]:
                os.kill(int(told["process"]), 0)
        except ProcessLookupError:
            return True
        except (ValueError, KeyError, TypeError, OSError, OverflowError):
            return False
        return False

    def _is_ours(self) -> bool:
        data = self._remote.read(FILE)
        with suppress(ValueError, KeyError, TypeError):
            return bool(json.loads(data or b"{}")["run"] == self._run)
        return False

    def _text(self) -> str:
        return json.dumps({**self._who, "run": self._run, "beat": self._beats}, sort_keys=True)

    def _held(self, data: bytes | None = None) -> OutputError:
        holder = "another run"
        with suppress(ValueError, KeyError, TypeError):
            told = json.loads(data or self._remote.read(FILE) or b"{}")
            holder = f"process {int(told['process'])} of {str(told['host'])[:80]}"
        return OutputError(
            f"{holder} is making this dataset",
            place=shown(self._remote.url),
            remedy="wait until it has ended, or choose another URL",
        )


@contextmanager
def leased(remote: RemoteFolder) -> Iterator[Lease]:
    """Have a dataset behind a URL to oneself.

    Raises:
        OutputError: Another run has it, or it cannot be written.
    """
    lease = Lease(remote)
    lease.take()
    keeper = threading.Thread(target=lease.keep, daemon=True)
    keeper.start()
    try:
        yield lease
    finally:
        # What its keeper was writing would stand there again after it is removed.
        lease.end()
        keeper.join(STALE_S)
        lease.give_back()
