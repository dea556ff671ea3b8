"""One case: a command reads what was prepared, and we look at all that it did."""

import contextlib
import os
import stat
import sys
import traceback
import zlib
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from tests.fuzz.kinds import INPUT, OUT, Run

# The first two are as it should be.
VERDICTS: Final = (
    *("refused", "accepted", "traceback", "crash", "hang", "memory", "half-written"),
    *("outside touched", "control codes"),
)
BAD: Final = VERDICTS[2:]
# Files that nobody may remove, wherever they lie.
_KEEP: Final = "keep"
_OURS: Final = ("openrooms_usd", "orusd_")
# What a terminal acts upon.
_CODES: Final = frozenset(range(32)) - frozenset(b"\t\n\r") | {127}
_HASHED: Final = 8 << 20  # bytes
_SHOWN: Final = 300

Seen = dict[str, tuple[int, int, int]]


@dataclass(frozen=True)
class Outcome:
    """What became of a case.

    Attributes:
        kind: Of input.
        number: The case's, within its kind.
        verdict: What became of it.
        what: The exception, or what was left or touched; defects that are alike say the same.
        where: File and line, where that is known.
        said: The beginning of the message.
        run: Which of the kind's runs it was.
        seconds: What it took.
        mebibytes: By how much its memory grew, at most.
        sound: Whether the input was as planted.
    """

    kind: str
    number: int
    verdict: str
    what: str = ""
    where: str = ""
    said: str = ""
    run: int = 0
    seconds: float = 0.0
    mebibytes: float = 0.0
    sound: bool = False


def judged(found: Outcome, printed: bytes, mebibytes: float) -> Outcome:
    """The verdict by the exception, what was printed and what it took.

    Args:
        found: With the verdict ``accepted`` or ``refused``.
        printed: On both streams.
        mebibytes: What a case may take.
    """
    if not found.said:
        found = replace(found, said=printed[:_SHOWN].decode("utf-8", "replace").strip())
    if found.what in ("MemoryError", "bad_alloc") or found.mebibytes > mebibytes:
        return replace(found, verdict="memory", what=found.what or "too much memory")
    if found.what:
        return replace(found, verdict="traceback")
    if b"Traceback (most recent call last)" in printed:
        lines = printed[printed.rindex(b"Traceback") :].decode("utf-8", "replace").splitlines()
        places = [line.strip() for line in lines if line.lstrip().startswith('File "')]
        where = places[-1][-120:] if places else ""
        return replace(found, verdict="traceback", what="printed traceback", where=where)
    if codes := control_codes(printed):
        what, where = "printed control codes", f"run {found.run}"
        return replace(found, verdict="control codes", what=what, where=where, said=repr(codes))
    return found


def execute(run: Run, folder: Path, output: Path) -> tuple[bool, str, str, str]:
    """Let a run read what was prepared.

    Args:
        run: Words of the command line, or a function.
        folder: Of the case.
        output: A file that receives what is printed.

    Returns:
        Whether it was accepted; the exception, its place and message, where one came through that
        is no refusal.
    """
    from openrooms_usd import cli
    from openrooms_usd.errors import OrusdError

    with output.open("wb") as stream, _captured(stream.fileno()):
        os.chdir(folder / "here")
        try:
            if callable(run):
                run(folder)
                return True, "", "", ""
            words = [
                word.format(**{INPUT: folder / INPUT, OUT: folder / OUT}) for word in run.split()
            ]
            sys.argv = ["orusd", *words]
            cli.main()
        except OrusdError as error:
            # As the command line prints it.
            sys.stderr.write(f"error: {error}\n".encode("utf-8", "backslashreplace").decode())
            return False, "", "", ""
        except SystemExit as ended:
            # 1: the command has read it, and says what is wrong with it.
            return ended.code in (None, 0, 1), "", "", ""
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            return False, type(error).__name__, _place(error), _message(error)
        return True, "", "", ""


@contextlib.contextmanager
def _captured(target: int) -> Any:
    """Standard output and error of this process into a file, also what libraries print."""
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(1), os.dup(2)]
    os.dup2(target, 1)
    os.dup2(target, 2)
    try:
        yield
    finally:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        for number, old in zip((1, 2), kept, strict=True):
            os.dup2(old, number)
            os.close(old)


def _message(error: BaseException) -> str:
    """What an exception says; those of USD may fail to say it."""
    try:
        return str(error)[:_SHOWN]
    except Exception as other:
        return f"no message: {other!r}"[:_SHOWN]


def _place(error: BaseException) -> str:
    """The innermost of our lines that an exception came through, else the innermost of all."""
    frames = traceback.extract_tb(error.__traceback__)
    return innermost_of_ours([(frame.filename, frame.lineno or 0) for frame in frames][::-1])


def innermost_of_ours(frames: list[tuple[str, int]]) -> str:
    """The first place of the project, else the first of all, from the package's folder on."""
    ours = [frame for frame in frames if _folder_of_ours(frame[0])]
    file, line = (ours or frames or [("unknown", 0)])[0]
    parts, at = Path(file).parts, _folder_of_ours(file)
    return f"{'/'.join(parts[at:] if at else parts[-2:])}:{line}"


def _folder_of_ours(file: str) -> int:
    """Where among the parts of a path our package begins; 0 where it is not ours."""
    parts = Path(file).parts[:-1]
    return max((i for i, part in enumerate(parts) if part.startswith(_OURS)), default=0)


def look(folder: Path) -> Seen:
    """Everything below a folder: its type, size and, of what lies in ``out``, its content.

    Files elsewhere have the time of their last change instead: nobody may write to them at all.
    """
    found: Seen = {}
    for root, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = os.path.join(root, name)  # noqa: PTH118
            about = os.lstat(path)
            short_path = path[len(str(folder)) + 1 :]
            regular = stat.S_ISREG(about.st_mode)
            if stat.S_ISDIR(about.st_mode):
                more = (0, 0)
            elif regular and short_path.startswith(f"{OUT}/") and about.st_size <= _HASHED:
                more = (about.st_size, zlib.crc32(Path(path).read_bytes()))
            else:
                more = (about.st_size, about.st_mtime_ns)
            found[short_path] = (stat.S_IFMT(about.st_mode), *more)
    return found


def changes(before: Seen, after: Seen, accepted: bool) -> tuple[str | None, str]:
    """Whether a case has touched what it must not, or left something half done.

    Args:
        before: The case's folder.
        after: The same, after it.
        accepted: Whether the case was.
    """
    everything = sorted(before.keys() | after.keys())
    changed = [path for path in everything if before.get(path) != after.get(path)]
    # A list of what is ours may lose what is no longer there, whatever else becomes of a case.
    changed = [path for path in changed if not (_is_ledger(path) and path in before)]
    for path in changed:
        inside = path == OUT or path.startswith(f"{OUT}/")
        kept = Path(path).name.startswith(_KEEP) and path in before
        if not inside or kept:
            return "outside touched", _said(path, before, after)
    if not accepted and changed:
        return "half-written", _said(changed[0], before, after)
    drafts = [path for path in changed if path in after and _is_draft(path)]
    return ("half-written", _said(drafts[0], before, after)) if drafts else (None, "")


def _is_ledger(path: str) -> bool:
    """Whether a file in ``out`` is the list of what was written there."""
    return path.startswith(f"{OUT}/.orusd")


def _is_draft(path: str) -> bool:
    """Whether a file has the name of one that is not finished."""
    return Path(path).name.startswith(".") and not _is_ledger(path)


def _said(path: str, before: Seen, after: Seen) -> str:
    did = "made" if path not in before else "removed" if path not in after else "changed"
    return f"{did} {'/'.join(Path(path).parts[:3])}"


def control_codes(printed: bytes) -> bytes:
    """The first control codes that were printed, with what surrounds them; else nothing."""
    at = next((i for i, byte in enumerate(printed) if byte in _CODES), None)
    return b"" if at is None else printed[max(at - 60, 0) : at + 20]
