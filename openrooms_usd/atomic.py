"""Files and folders appear whole or not at all: write beside the target, then rename.

Where a command keeps a ledger of its folder, what appears there is noted in it, and only unchanged
files of an earlier run are replaced.
"""

import filecmp
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from openrooms_usd import ledger, removal, unfinished, untrusted
from openrooms_usd.errors import OutputError, writing


@contextmanager
def making_folder(folder: Path) -> Iterator[None]:
    """Make a folder and its parents; when the block raises, those that are new go again.

    A new folder with other files in it stays.

    Raises:
        OutputError: It cannot be made.
    """
    with writing(folder):
        new = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        with writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
        yield
    except BaseException:
        for path in new:
            if not removal.remove_if_empty(path):
                break
        raise


@contextmanager
def naming_target(target: Path, beside: Path) -> Iterator[None]:
    """Let errors speak of ``target``, not of what is written in its place for the moment."""
    try:
        yield
    except OutputError as error:
        error.message = error.message.replace(str(beside), str(target))
        error.place = error.place and error.place.replace(str(beside), str(target))
        raise


def rename_into_place(beside: Path, target: Path) -> None:
    """Give what was written whole its final name; a file of that name is replaced.

    Args:
        beside: A file or a folder on the same disk.
        target: Its name to be; no folder may have it.

    Raises:
        OSError: It cannot be done.
    """
    ledger.note(beside, target)
    removal.rename(beside, target)


@contextmanager
def replacing(target: Path) -> Iterator[Path]:
    """Give a path beside ``target`` to write to, and rename it to ``target`` on success.

    The temporary name keeps the suffix, because USD and OpenImageIO choose the format by it. When
    the block raises, the temporary file is removed and ``target`` is as it was.

    Args:
        target: The file that shall appear. Its folder is made when it is missing.

    Yields:
        The path to write to.

    Raises:
        OutputError: The file cannot be written, the target is a device, a pipe or a folder, or a
            file would give way that is not ours.
    """
    check_replaceable(target)
    beside = unfinished.beside(target)
    with writing(target), making_folder(target.parent), naming_target(target, beside):
        try:
            yield beside
            take_places([(beside, target)])
        finally:
            removal.remove_file(beside)


def take_places(files: Iterable[tuple[Path, Path]]) -> None:
    """Let new files take their places; a foreign file with the same contents stays foreign.

    Args:
        files: Each new one and its target, in their order.

    Raises:
        OutputError: A foreign file would be replaced; no file has taken its place then.
        OSError: It cannot be renamed.
    """
    files = list(files)
    foreign = {target for _, target in files if not ledger.may_replace(target)}
    same = {new for new, target in files if target in foreign and _is_same(new, target)}
    _refuse([target for new, target in files if target in foreign and new not in same])
    for new, target in files:
        if new not in same:
            target.parent.mkdir(parents=True, exist_ok=True)
            rename_into_place(new, target)


def _is_same(new: Path, target: Path) -> bool:
    is_file = target.is_file() and not target.is_symlink()
    return is_file and filecmp.cmp(new, target, shallow=False)


def _refuse(lost: Sequence[Path]) -> None:
    if lost:
        more = f" (and {len(lost) - 1} more)" if len(lost) > 1 else ""
        raise OutputError(
            f"this would be replaced{more}, but it is not as an earlier run wrote it",
            place=lost[0],
            remedy="move it away, or choose another output (older versions kept no list of it)",
        )


def write_text(target: Path, text: str) -> None:
    """Write ``text`` as UTF-8 with Unix line ends; the file appears whole or not at all."""
    with replacing(target) as beside:
        beside.write_text(text, encoding="utf-8", newline="\n")


def write_bytes(target: Path, data: bytes) -> None:
    """Write ``data``; the file appears whole or not at all."""
    with replacing(target) as beside:
        beside.write_bytes(data)


def check_replaceable(target: Path) -> None:
    """See that no device, pipe or folder would give way to a file, also behind a link.

    Raises:
        OutputError: It would.
    """
    with writing(target):
        what = untrusted.kind_of(target)
    if what and what != "a file":
        raise OutputError(
            f"this is {what}, and will not be replaced by a file",
            place=target,
            remedy="choose another output file",
        )


def check_free(targets: Iterable[Path]) -> None:
    """Check that no foreign file would be replaced; a folder must hold only our files.

    Files are free where no ledger is kept.

    Raises:
        OutputError: Something would; it is named.
    """
    lost = []
    for target in targets:
        if target.is_dir() and not target.is_symlink():
            check_own(target)
        elif not ledger.may_replace(target):
            lost.append(target)
    _refuse(lost)


@contextmanager
def replacing_files(folder: Path) -> Iterator[Path]:
    """Give an empty folder to write files to, and move them all into ``folder`` on success.

    Files of the same names are replaced where they are ours, others stay. When the block raises,
    what was written is removed and ``folder`` is as it was.

    Args:
        folder: Where the files shall appear. It is made when it is missing.

    Yields:
        The folder to write to.

    Raises:
        OutputError: A file cannot be written, or one that is not ours would give way.
    """
    beside = unfinished.beside(folder / "new")
    with writing(folder), making_folder(folder), naming_target(folder, beside):
        try:
            beside.mkdir()
            yield beside
            files = [path.relative_to(beside) for path in beside.rglob("*") if path.is_file()]
            for file in files:
                check_replaceable(folder / file)
            # Files in subfolders first: those at the top refer to them.
            ordered = sorted(files, key=lambda path: (-len(path.parts), path))
            take_places((beside / file, folder / file) for file in ordered)
        finally:
            removal.remove_tree(beside)


@contextmanager
def replacing_folder(target: Path) -> Iterator[Path]:
    """Give an empty folder beside ``target`` to fill, which then becomes ``target``.

    One that has the name gives way, provided that all in it was written here (see `check_own`).
    When the block raises, what was written is removed.

    Args:
        target: The folder that shall appear; its parent is made when it is missing.

    Yields:
        The folder to write to.

    Raises:
        OutputError: It cannot be written, or the one that is there cannot be replaced.
    """
    beside = unfinished.beside(target)
    with writing(target), making_folder(target.parent), naming_target(target, beside):
        try:
            beside.mkdir()
            yield beside
            _swap(beside, target)
        finally:
            removal.remove_tree(beside)


def _swap(beside: Path, target: Path) -> None:
    """Let a folder take a name; one that has it goes, provided that all in it was written here."""
    if not target.is_symlink() and not target.exists():
        rename_into_place(beside, target)
        return
    check_own(target)
    old = unfinished.parking_name(target)
    ledger.note(beside, target)
    try:
        removal.rename(target, old)
        removal.rename(beside, target)
    finally:
        if old.exists() and not target.exists():
            removal.rename(old, target)
    removal.remove_tree(old)


def check_own(target: Path) -> None:
    """See that all in a folder was written by the command that has it to itself, and unchanged.

    Raises:
        OutputError: Something was not; it is named.
    """
    foreign = ledger.foreign(target)
    if foreign:
        first = (
            "it is not a folder that this tool made"
            if foreign[0] == "."
            else f"{foreign[0]!r} in it"
        )
        more = f" (and {len(foreign) - 1} more)" if len(foreign) > 1 else ""
        was = (
            ""
            if foreign[0] == "."
            else " was not written by an earlier run (older versions kept no list), or was "
            "changed since"
        )
        raise OutputError(
            f"this will not be replaced: {first}{more}{was}",
            place=target,
            remedy="move it away, or choose another output folder",
        )
