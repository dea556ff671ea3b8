"""One case: a planted input is copied, one of its files is spoilt, a command reads it, and we look.

A case is fixed by the campaign's seed, its kind and its number. The first numbers of a kind leave
the input as it was planted, so that a campaign whose own inputs are refused is seen.
"""

import os
import re
import shutil
import stat
import sys
import traceback
import zlib
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from random import Random
from typing import Any, Final, Literal

from benchmarks.fuzz import bytewise, containers, structure
from benchmarks.fuzz.hostile import plant_beside, replace_file
from benchmarks.fuzz.kinds import INPUT, OUT, Kind, Run

Verdict = Literal[
    "refused", "accepted", "traceback", "crash", "hang", "memory", "half-written",
    "outside touched", "control codes",
]  # fmt: skip
BAD: Final[tuple[Verdict, ...]] = (
    "traceback", "crash", "hang", "memory", "half-written", "outside touched", "control codes",
)  # fmt: skip
# Files that nobody may remove, wherever they lie.
KEEP: Final = "keep"
_OURS: Final = ("openrooms_usd", "orusd_")
# What a terminal acts upon.
_CODES: Final = frozenset(range(32)) - frozenset(b"\t\n\r") | {127}
_HOSTILE: Final = 0.05
# How often what is spoilt is among what the command is told to read, where that is known.
_READ: Final = 0.85
_WORD: Final = re.compile(r"[\s/{}]+")
_HASHED: Final = 8 << 20  # bytes

Seen = dict[str, tuple[int, int, int]]


@dataclass
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
    verdict: Verdict
    what: str = ""
    where: str = ""
    said: str = ""
    run: int = 0
    seconds: float = 0.0
    mebibytes: float = 0.0
    sound: bool = False

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


def prepare(kind: Kind, number: int, seed: int, planted: Path, folder: Path) -> tuple[int, Run]:
    """Copy what was planted into an empty folder, and spoil it.

    Args:
        kind: Of input.
        number: The case's, within its kind.
        seed: The campaign's.
        planted: Where the kind was planted.
        folder: Empty; receives ``in``, perhaps ``out``, and what lies beside.

    Returns:
        The number of the run, and the run.
    """
    shutil.copytree(planted, folder, symlinks=True, dirs_exist_ok=True)
    (folder / INPUT).mkdir(exist_ok=True)
    (folder / "here").mkdir()
    plant_beside(folder)
    if number < len(kind.runs):
        return number, kind.runs[number][1]
    rng = Random(f"{seed} {kind.name} {number}")
    files = kind.files(planted)
    chosen = rng.choices(range(len(kind.runs)), [share for share, _ in kind.runs])[0]
    run = kind.runs[chosen][1]
    read = [file for file in files if named(file, run)]
    files = read if read and rng.random() < _READ else files
    if rng.random() < _HOSTILE:
        replace_file(folder / rng.choice(files), rng)
    else:
        for name in rng.sample(files, min(len(files), rng.choice((1, 1, 1, 2)))):
            path = folder / name
            others = [other for other in files if Path(other).suffix == path.suffix]
            other = (planted / rng.choice(others)).read_bytes()
            path.write_bytes(spoilt(name, path.read_bytes(), other, rng))
    return chosen, run


def named(file: str, run: Run) -> bool:
    """Whether a run names a file, or a folder that it lies in.

    Args:
        file: Relative to the folder that was planted.
        run: Words, or a function with its arguments.
    """
    text = run if isinstance(run, str) else " ".join(getattr(run, "args", ()))
    return not {*_WORD.split(text)}.isdisjoint(Path(file).parts[1:])


def spoilt(name: str, data: bytes, other: bytes, rng: Random) -> bytes:
    """The spoilt content of a file.

    Args:
        name: Its name, by whose ending ways are chosen that know its format.
        data: What it holds.
        other: What a file of the same ending holds, to be joined with.
        rng: Decides.
    """
    suffix = Path(name).suffix.lower()
    if rng.random() < 0.04:
        at, to = rng.randrange(len(data) + 1), rng.randrange(len(other) + 1)
        return data[:at] + other[to:]
    structured, container = structure.BY_SUFFIX.get(suffix), containers.BY_SUFFIX.get(suffix)
    try:
        if container is not None and rng.random() < 0.75:
            return container(data, rng, lambda inner, part: spoilt(inner, part, part, rng))
        if structured is not None and rng.random() < 0.5:
            return structured(data, rng)
    except (ValueError, OverflowError, RecursionError):
        pass  # not what its name says, or spoilt so far that it cannot be written
    return bytewise.spoil(data, rng)


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


class _captured:  # noqa: N801
    """Standard output and error of this process into a file, also what libraries print."""

    def __init__(self, target: int) -> None:
        self._target = target

    def __enter__(self) -> None:
        sys.stdout.flush()
        sys.stderr.flush()
        self._kept = [os.dup(1), os.dup(2)]
        os.dup2(self._target, 1)
        os.dup2(self._target, 2)

    def __exit__(self, *_: object) -> None:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        for number, kept in zip((1, 2), self._kept, strict=True):
            os.dup2(kept, number)
            os.close(kept)


def _message(error: BaseException) -> str:
    """What an exception says; those of USD may fail to say it."""
    try:
        return str(error)[:300]
    except Exception as other:
        return f"no message: {other!r}"[:300]


def _place(error: BaseException) -> str:
    """The innermost of our lines that an exception came through, else the innermost of all."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if is_ours(frame.filename)]
    frame = (ours or list(frames))[-1]
    return f"{short(frame.filename)}:{frame.lineno}"


def is_ours(file: str) -> bool:
    """Whether a source file is of the project."""
    return any(part.startswith(_OURS) for part in Path(file).parts[:-1])


def short(file: str) -> str:
    """A source file from the package's folder on."""
    parts = Path(file).parts
    at = [i for i, part in enumerate(parts) if part.startswith(_OURS)]
    return "/".join(parts[at[-1] :] if at else parts[-2:])


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


def changes(before: Seen, after: Seen, accepted: bool) -> tuple[Verdict | None, str]:
    """Whether a case has touched what it must not, or left something half done.

    Args:
        before: The case's folder.
        after: The same, after it.
        accepted: Whether the case was.
    """
    changed = sorted(
        path
        for path in before.keys() | after.keys()
        if before.get(path) != after.get(path)
    )  # fmt: skip
    # A list of what is ours may lose what is no longer there, whatever else becomes of a case.
    changed = [path for path in changed if not (_is_ledger(path) and path in before)]
    for path in changed:
        inside = path == OUT or path.startswith(f"{OUT}/")
        kept = Path(path).name.startswith(KEEP) and path in before
        if not inside or kept:
            return "outside touched", _said(path, before, after)
    if not accepted and changed:
        return "half-written", _said(changed[0], before, after)
    hidden = [path for path in changed if path in after and _is_draft(path)]
    return ("half-written", _said(hidden[0], before, after)) if hidden else (None, "")


def _is_ledger(path: str) -> bool:
    """Whether a file in ``out`` is the list of what was written there."""
    return path.startswith(f"{OUT}/.orusd")


def _is_draft(path: str) -> bool:
    """Whether a file has the name of one that is not finished."""
    return Path(path).name.startswith(".") and not _is_ledger(path)


def _said(path: str, before: Seen, after: Seen) -> str:
    did = "made" if path not in before else "removed" if path not in after else "changed"
    top = "/".join(Path(path).parts[:3])
    return f"{did} {top}"


def control_codes(printed: bytes) -> bytes:
    """The first control codes that were printed, with what surrounds them; else nothing."""
    at = next((i for i, byte in enumerate(printed) if byte in _CODES), None)
    return b"" if at is None else printed[max(at - 60, 0) : at + 20]
