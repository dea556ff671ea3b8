"""Ctrl-C acts at once, also while a renderer computes.

Python tells the main thread of a signal only when that runs Python again, which may take many
seconds inside of a renderer. A thread beside it is woken by the signal itself; where the main
thread does not answer in time, it leaves the folders as after any interruption and ends the
process.
"""

import os
import signal
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Final, NoReturn

from openrooms_usd.cli.console import echo

EXIT_CODE: Final = 130
_SAID: Final = "Interrupted. What was finished is kept."
_IMPORTING: Final = "<frozen importlib._bootstrap>"
_SHOW_CURSOR: Final = "\x1b[?25h"
# How long the main thread has to answer; and then, to leave as it likes.
_ANSWER_SECONDS: Final = 1.0
_LEAVE_SECONDS: Final = 10.0


@contextmanager
def prompt_interrupts() -> Iterator[None]:
    """Let Ctrl-C end the process within a second or so, whatever the main thread does.

    Where signals are ignored (``nohup``), or another handler is installed, nothing changes.
    """
    ours = threading.current_thread() is threading.main_thread()
    if not ours or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    answered = threading.Event()

    def answer(number: int, frame: FrameType | None) -> None:
        if answered.is_set():  # it is leaving: a second signal would stop it from tidying up
            return
        answered.set()
        if _is_importing(frame):
            _abandon()
        raise KeyboardInterrupt

    woken, waker = socket.socketpair()
    waker.setblocking(False)
    before = signal.set_wakeup_fd(waker.fileno(), warn_on_full_buffer=False)
    signal.signal(signal.SIGINT, answer)
    threading.Thread(target=_watch, args=(woken, answered), daemon=True).start()
    try:
        yield
    except Exception:
        # Code in C++ makes errors of its own of an interruption.
        if answered.is_set():
            leave()
        raise
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.set_wakeup_fd(before)
        waker.close()


def _watch(woken: socket.socket, answered: threading.Event) -> None:
    with woken:
        while numbers := woken.recv(1):
            if numbers[0] == signal.SIGINT:
                break
        else:
            return
        # Open until the end: further signals are written to it.
        if answered.wait(_ANSWER_SECONDS):
            # It is leaving; it may still wait for threads of its own.
            threading.Event().wait(_LEAVE_SECONDS)
        _abandon()


def _is_importing(frame: FrameType | None) -> bool:
    """Whether a module is being loaded: libraries take what is raised there for errors of it."""
    while frame is not None:
        if frame.f_code.co_filename == _IMPORTING:
            return True
        frame = frame.f_back
    return False


def _abandon() -> NoReturn:
    # What was not loaded yet holds nothing.
    if abandon := getattr(sys.modules.get("openrooms_usd.claims"), "abandon", None):
        abandon()
    leave()


def leave() -> NoReturn:
    """Say that the command was interrupted, and end the process without waiting for anything."""
    with suppress(OSError, ValueError):
        if sys.stderr.isatty():
            sys.stderr.write(_SHOW_CURSOR)
        echo(_SAID, err=True)
        sys.stdout.flush()
    os._exit(EXIT_CODE)
