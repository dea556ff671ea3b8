"""Two processes that run cases; those that die are counted with their case, and replaced."""

import re
import signal
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Final

from benchmarks.fuzz.case import Outcome, is_ours, short
from benchmarks.fuzz.kinds import Kind
from benchmarks.fuzz.worker import FAULT, PRINTED, Limits, clear, serve

Case = tuple[str, int]

# A process that does not even end itself gets these seconds more.
_GRACE: Final = 10.0
# Libraries keep what they have read: a fresh process now and then bounds that.
_LIFE: Final = 1500
# What libraries say that end the process where they get no memory.
_NO_MEMORY: Final = ("bad_alloc", "MemoryError", "memory allocation of")
_FRAME: Final = re.compile(r'File "([^"]+)", line (\d+)')


@dataclass
class _Seat:
    """A process, its link and what it is doing."""

    process: BaseProcess
    link: Connection
    own: Path
    case: Case | None = None
    began: float = 0.0
    done: int = 0


class Pool:
    """Runs cases in processes of its own.

    Args:
        kinds: By name.
        seed: The campaign's.
        planted: Where the kinds were planted.
        folder: For the processes' own folders.
        limits: What a case may take.
        workers: How many processes.
    """

    def __init__(
        self,
        kinds: dict[str, Kind],
        seed: int,
        planted: Path,
        folder: Path,
        limits: Limits,
        workers: int = 2,
    ) -> None:
        self._arguments = (kinds, seed, planted)
        self._folder, self._limits, self._workers = folder, limits, workers
        self._context = get_context("fork")

    def run(self, cases: Sequence[Case]) -> Iterator[Outcome]:
        """Run cases; outcomes come in the order in which they end."""
        waiting = list(reversed(cases))
        seats = [self._seat(i) for i in range(min(self._workers, max(len(waiting), 1)))]
        try:
            while waiting or any(seat.case for seat in seats):
                for i, seat in enumerate(seats):
                    if seat.case is None and waiting:
                        if seat.done >= _LIFE:
                            self._leave(seat)
                            seats[i] = seat = self._seat(i)
                        self._give(seat, waiting.pop())
                busy = [seat for seat in seats if seat.case]
                wait([thing for s in busy for thing in (s.link, s.process.sentinel)], timeout=1.0)
                for i, seat in enumerate(seats):
                    outcome = self._taken(seat)
                    if outcome:
                        yield outcome
                    if seat.case is None and not seat.process.is_alive():
                        seats[i] = self._seat(i)
        finally:
            for seat in seats:
                self._leave(seat)

    def _seat(self, number: int) -> _Seat:
        own = self._folder / f"worker{number}"
        clear(own)
        own.mkdir(parents=True)
        here, there = self._context.Pipe()
        process = self._context.Process(
            target=serve, args=(there, *self._arguments, own, self._limits), daemon=True
        )
        process.start()
        there.close()
        return _Seat(process, here, own)

    def _give(self, seat: _Seat, case: Case) -> None:
        seat.case, seat.began = case, time.monotonic()
        seat.done += 1
        seat.link.send(case)

    def _taken(self, seat: _Seat) -> Outcome | None:
        """The outcome of a seat's case, if there is one by now."""
        if seat.case is None:
            return None
        try:
            if seat.link.poll():
                outcome: Outcome = seat.link.recv()
                seat.case = None
                return outcome
        except (EOFError, OSError):
            pass
        took = time.monotonic() - seat.began
        late = took > self._limits.seconds + _GRACE
        if late:
            seat.process.kill()
        elif seat.process.is_alive():
            return None
        seat.process.join()
        outcome = _post_mortem(seat, late)
        seat.case = None
        return outcome

    def _leave(self, seat: _Seat) -> None:
        with suppress(OSError):
            seat.link.send(None)
        seat.process.join(0.2 if seat.case else 5)
        if seat.process.is_alive():
            seat.process.kill()
            seat.process.join()
        seat.link.close()


def _post_mortem(seat: _Seat, late: bool) -> Outcome:
    """What became of the case with which a process died."""
    assert seat.case is not None
    kind, number = seat.case
    seconds = time.monotonic() - seat.began
    stacks = _text(seat.own / FAULT)
    printed = _text(seat.own / PRINTED)
    said = printed[:300].strip()
    frames = _FRAME.findall(stacks)
    ours = [f"{short(file)}:{line}" for file, line in frames if is_ours(file)]
    where = (ours or [f"{short(file)}:{line}" for file, line in frames] or ["unknown"])[0]
    if late or "Timeout (" in stacks:
        return Outcome(kind, number, "hang", "hang", where, said, seconds=seconds)
    code = seat.process.exitcode or 0
    name = signal.Signals(-code).name if code < 0 else f"exit {code}"
    if any(word in printed + stacks for word in _NO_MEMORY):
        return Outcome(kind, number, "memory", name, where, said, seconds=seconds)
    return Outcome(kind, number, "crash", name, where, said, seconds=seconds)


def _text(path: Path) -> str:
    try:
        return path.read_bytes()[: 1 << 20].decode("utf-8", "replace")
    except OSError:
        return ""
