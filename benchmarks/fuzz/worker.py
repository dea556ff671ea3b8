"""A process that runs one case after another, watched by its own limits and by its parent."""

import contextlib
import faulthandler
import os
import resource
import shutil
import signal
import time
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Final

from benchmarks.fuzz.case import Outcome, changes, control_codes, execute, look, prepare
from benchmarks.fuzz.kinds import Kind

_MIB: Final = 1 << 20
# Beyond the limit of what counts as too much, so that a case rather is measured than stopped.
_SPARE_MIB: Final = 3072
_SHOWN: Final = 300
# Files of a worker, beside the folder of its case.
PRINTED, FAULT = "printed", "fault"


@dataclass(frozen=True)
class Limits:
    """What a case may take: seconds, and MiB beyond what its process had before."""

    seconds: float = 20.0
    mebibytes: float = 2048.0


def serve(
    link: Connection, kinds: dict[str, Kind], seed: int, planted: Path, own: Path, limits: Limits
) -> None:
    """Run the cases that come through a link until None comes."""
    import openrooms_usd.cli  # noqa: F401
    from benchmarks.fuzz.fakes import install

    install()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends
    parent = os.getppid()
    own.mkdir(parents=True, exist_ok=True)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    _bound_memory(limits)
    with (own / FAULT).open("wb", buffering=0) as fault:
        faulthandler.enable(fault)
        while (asked := _asked(link, parent)) is not None:
            name, number = asked
            fault.truncate(0)
            fault.seek(0)
            faulthandler.dump_traceback_later(limits.seconds, exit=True, file=fault)
            outcome = _one(kinds[name], number, seed, planted / name, own, limits)
            faulthandler.cancel_dump_traceback_later()
            link.send(outcome)


def _asked(link: Connection, parent: int) -> tuple[str, int] | None:
    """The next case; None at the end, or when the parent is gone without a word."""
    while not link.poll(5.0):
        if os.getppid() != parent:
            return None
    asked: tuple[str, int] | None = link.recv()
    return asked


def _bound_memory(limits: Limits) -> None:
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * os.sysconf("SC_PAGE_SIZE") + int((limits.mebibytes + _SPARE_MIB) * _MIB)
    resource.setrlimit(resource.RLIMIT_AS, (most, resource.getrlimit(resource.RLIMIT_AS)[1]))


def _one(
    kind: Kind, number: int, seed: int, planted: Path, own: Path, limits: Limits
) -> Outcome:  # fmt: skip
    folder = own / "case"
    clear(folder)
    folder.mkdir()
    try:
        index, run = prepare(kind, number, seed, planted, folder)
    except Exception as error:
        return Outcome(kind.name, number, "crash", "the campaign itself", said=repr(error)[:_SHOWN])
    before, had = look(folder), _reset_peak()
    began = time.perf_counter()
    accepted, what, where, said = execute(run, folder, own / PRINTED)
    seconds = time.perf_counter() - began
    os.chdir(own)
    found = Outcome(
        kind.name, number, "accepted" if accepted else "refused", what, where, said, index, seconds,
        max(_status("VmHWM") - had, 0.0), number < len(kind.runs) and not kind.hostile,
    )  # fmt: skip
    printed = _beginning(own / PRINTED)
    if not found.said:
        found.said = printed[:_SHOWN].decode("utf-8", "replace").strip()
    _judge(found, printed, limits)
    if found.verdict in ("accepted", "refused"):
        verdict, changed = changes(before, look(folder), accepted)
        if verdict:
            found.verdict, found.what, found.where = verdict, changed, f"run {index}"
    return found


def _judge(found: Outcome, printed: bytes, limits: Limits) -> None:
    """Correct a verdict by the exception, what was printed and what it took."""
    if found.what in ("MemoryError", "bad_alloc") or found.mebibytes > limits.mebibytes:
        found.verdict, found.what = "memory", found.what or "too much memory"
    elif found.what:
        found.verdict = "traceback"
    elif b"Traceback (most recent call last)" in printed:
        found.verdict, found.what = "traceback", "printed traceback"
        lines = printed[printed.rindex(b"Traceback") :].decode("utf-8", "replace").splitlines()
        places = [line.strip() for line in lines if line.lstrip().startswith('File "')]
        found.where = places[-1][-120:] if places else ""
    elif codes := control_codes(printed):
        found.verdict, found.what = "control codes", "printed control codes"
        found.where, found.said = f"run {found.run}", repr(codes)


def _beginning(path: Path) -> bytes:
    with path.open("rb") as stream:
        return stream.read(1 << 20)


def _reset_peak() -> float:
    """Forget the greatest memory so far; what there is now, MiB."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")
    return _status("VmRSS")


def _status(key: str) -> float:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(f"{key}:"):
            return int(line.split()[1]) / 1024
    return 0.0


def clear(folder: Path) -> None:
    """Remove the folder of a case, whatever its permissions."""
    if folder.is_dir():
        shutil.rmtree(folder, ignore_errors=True)
    if folder.exists():
        for path in (folder, *folder.rglob("*")):
            if path.is_dir() and not path.is_symlink():
                path.chmod(0o700)
        shutil.rmtree(folder)
