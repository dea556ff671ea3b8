"""Runs cases in processes of their own, bounded in time and memory; some end with their process."""

import contextlib
import faulthandler
import os
import re
import shutil
import signal
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import TimeoutError as TookTooLong
from dataclasses import dataclass, replace
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Final

from pebble import ProcessExpired, ProcessPool

from tests.fuzz.case import Outcome, changes, execute, innermost_of_ours, judged, look
from tests.fuzz.kinds import Kind
from tests.fuzz.spoiling import prepare

Case = tuple[str, int]

_READERS: Final = ("captures", "clouds", "models", "materials", "stages")
SOURCES: Final = (*_READERS, "renders", "targets")
# A process that does not even end itself gets these seconds more.
_GRACE: Final = 10.0
# Libraries keep what they have read: a fresh process now and then bounds that.
_LIFE: Final = 1500
_MIB: Final = 1 << 20
# Beyond the limit of what counts as too much, so that a case rather is measured than stopped.
_SPARE_MIB: Final = 3072
# What libraries say that end the process where they get no memory.
_NO_MEMORY: Final = ("bad_alloc", "MemoryError", "memory allocation of")
_FRAME: Final = re.compile(r'File "([^"]+)", line (\d+)')


@dataclass(frozen=True)
class Campaign:
    """What all cases share.

    Attributes:
        sources: The modules of this package whose ``KINDS`` are run.
        seed: Decides how input is spoilt.
        planted: Where the sound input of every kind lies, by name.
        folder: Where cases have their folders meanwhile.
        seconds: What a case may take.
        mebibytes: What it may take beyond what its process had before.
    """

    sources: tuple[str, ...]
    seed: int
    planted: Path
    folder: Path
    seconds: float = 20.0
    mebibytes: float = 2048.0

    def place(self, case: Case) -> Path:
        """The folder of a case."""
        return self.folder / f"{case[0]}-{case[1]}"


def kinds_of(sources: Sequence[str]) -> dict[str, Kind]:
    """By name."""
    modules = (import_module(f"tests.fuzz.{source}") for source in sources)
    return {kind.name: kind for module in modules for kind in module.KINDS}


def run(campaign: Campaign, cases: Sequence[Case], workers: int = 2) -> Iterator[Outcome]:
    """Run cases; outcomes come in their order."""
    # Threads of libraries must not be forked: workers come of a process that has none.
    context: Any = get_context("forkserver")
    context.set_forkserver_preload([f"{__package__}.{name}" for name in campaign.sources])
    pool = ProcessPool(workers, _LIFE, _begin, (campaign,), context)
    try:
        outcomes = pool.map(_one, cases, timeout=campaign.seconds + _GRACE).result()
        for case in cases:
            try:
                yield next(outcomes)
            except (TookTooLong, ProcessExpired) as ended:
                yield _post_mortem(campaign, case, ended)
                clear(campaign.place(case))
        pool.close()
    finally:
        pool.stop()
        pool.join()


# In a worker.

_CAMPAIGN: list[tuple[Campaign, dict[str, Kind]]] = []


def _begin(campaign: Campaign) -> None:
    import resource  # not on Windows

    import openrooms_usd.cli  # noqa: F401
    from tests.fuzz.fakes import install

    install()
    _CAMPAIGN[:] = [(campaign, kinds_of(campaign.sources))]
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * os.sysconf("SC_PAGE_SIZE") + int((campaign.mebibytes + _SPARE_MIB) * _MIB)
    resource.setrlimit(resource.RLIMIT_AS, (most, resource.getrlimit(resource.RLIMIT_AS)[1]))


def _one(case: Case) -> Outcome:
    """Run a case; a process that hangs ends itself, and leaves where it was."""
    ((campaign, kinds),) = _CAMPAIGN
    own = campaign.place(case)
    clear(own)
    (own / "case").mkdir(parents=True)
    with (own / "fault").open("wb", buffering=0) as fault:
        faulthandler.enable(fault)
        faulthandler.dump_traceback_later(campaign.seconds, exit=True, file=fault)
        try:
            return _outcome(campaign, kinds[case[0]], case[1], own)
        finally:
            faulthandler.cancel_dump_traceback_later()
            faulthandler.disable()
            os.chdir(campaign.folder)
            clear(own)


def _outcome(campaign: Campaign, kind: Kind, number: int, own: Path) -> Outcome:
    folder, output = own / "case", own / "printed"
    try:
        index, read = prepare(kind, number, campaign.seed, campaign.planted / kind.name, folder)
    except Exception as error:
        return Outcome(kind.name, number, "crash", "the campaign itself", said=repr(error)[:300])
    before, had = look(folder), _reset_peak()
    began = time.perf_counter()
    accepted, what, where, said = execute(read, folder, output)
    seconds, grown = time.perf_counter() - began, max(_status("VmHWM") - had, 0.0)
    verdict = "accepted" if accepted else "refused"
    sound = number < len(kind.runs) and not kind.hostile
    found = Outcome(kind.name, number, verdict, what, where, said, index, seconds, grown, sound)
    with output.open("rb") as stream:
        found = judged(found, stream.read(1 << 20), campaign.mebibytes)
    if found.verdict in ("accepted", "refused"):
        bad, changed = changes(before, look(folder), accepted)
        if bad:
            return replace(found, verdict=bad, what=changed, where=f"run {index}")
    return found


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


# In the parent.


def _post_mortem(campaign: Campaign, case: Case, ended: Exception) -> Outcome:
    """What became of the case with which a process died."""
    stacks, printed = (_text(campaign.place(case) / name) for name in ("fault", "printed"))
    said = printed[:300].strip()
    where = innermost_of_ours([(file, int(line)) for file, line in _FRAME.findall(stacks)])
    if isinstance(ended, TookTooLong) or "Timeout (" in stacks:
        return Outcome(*case, "hang", "hang", where, said, seconds=campaign.seconds)
    code = getattr(ended, "exitcode", 0)
    name = signal.Signals(-code).name if code < 0 else f"exit {code}"
    lacked = any(word in printed + stacks for word in _NO_MEMORY)
    return Outcome(*case, "memory" if lacked else "crash", name, where, said)


def _text(path: Path) -> str:
    try:
        return path.read_bytes()[: 1 << 20].decode("utf-8", "replace")
    except OSError:
        return ""
