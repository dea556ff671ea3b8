"""One case's input: what was planted is copied, and one or two of its files are spoilt or replaced.

A case is fixed by the campaign's seed, its kind and its number. The first numbers of a kind leave
the input as it was planted, so that a campaign whose own inputs are refused is seen.
"""

import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Final

from tests.fuzz import bytewise, containers, structure
from tests.fuzz.kinds import INPUT, Kind, Run

BESIDE: Final = "beside"


def plant_beside(folder: Path) -> None:
    """What lies beside input and output: files to keep, a pipe, a link without end."""
    beside = folder / BESIDE
    (beside / "view").mkdir(parents=True)
    (beside / "keep.txt").write_text("keep this\n")
    (beside / "view/channels.exr").write_bytes(b"keep this too")
    os.mkfifo(beside / "pipe")
    (beside / "endless").symlink_to("/dev/zero")
    (beside / "circle").symlink_to("circle")


def _folder(path: Path) -> None:
    path.mkdir()
    (path / "within.txt").write_text("x")


def _forbidden(path: Path) -> None:
    path.write_bytes(b"x")
    path.chmod(0)


def _linked(target: str) -> Callable[[Path], None]:
    return lambda path: path.symlink_to(target)


def _beside(name: str) -> Callable[[Path], None]:
    """A link to what lies beside the input, however deep the file is in it."""

    def put(path: Path) -> None:
        root = path.parent
        while not (root / BESIDE).is_dir():
            root = root.parent
        path.symlink_to(root / BESIDE / name)

    return put


_WAYS: Final[tuple[Callable[[Path], None], ...]] = (
    os.mkfifo,
    _folder,
    _forbidden,
    lambda path: None,
    lambda path: path.write_bytes(b""),
    _linked("/dev/zero"),
    _linked("/dev/null"),
    _linked("/dev/full"),
    _linked("/proc/self/mem"),
    _linked("nowhere"),
    lambda path: path.symlink_to(path.name),
    _beside("keep.txt"),
    _beside("pipe"),
    _beside("endless"),
)


def replace_file(path: Path, rng: Random) -> None:
    """Put something else in place of a file."""
    path.unlink()
    rng.choice(_WAYS)(path)


_HOSTILE: Final = 0.05
# How often what is spoilt is among what the command is told to read, where that is known.
_READ: Final = 0.85
_WORD: Final = re.compile(r"[\s/{}]+")


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
