"""Files appear whole or not at all: write beside the target, then rename."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from openrooms_usd.errors import OutputError, writing


@contextmanager
def making(folder: Path) -> Iterator[None]:
    """Make a folder and its parents; when the block raises, those that are new go again.

    A new folder that somebody else has put something into stays.

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
            try:
                path.rmdir()
            except FileNotFoundError:
                continue
            except OSError:
                break
        raise


@contextmanager
def naming(target: Path, beside: Path) -> Iterator[None]:
    """Let errors speak of ``target``, not of what is written in its place for the moment."""
    try:
        yield
    except OutputError as error:
        error.message = error.message.replace(str(beside), str(target))
        error.place = error.place and error.place.replace(str(beside), str(target))
        raise


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
        OutputError: The file cannot be written.
    """
    beside = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    with writing(target), making(target.parent), naming(target, beside):
        try:
            yield beside
            beside.replace(target)
        finally:
            beside.unlink(missing_ok=True)


@contextmanager
def filling(folder: Path) -> Iterator[Path]:
    """Give an empty folder to write files to, and move them all into ``folder`` on success.

    Files of the same names are replaced, others stay. When the block raises, what was written is
    removed and ``folder`` is as it was.

    Args:
        folder: Where the files shall appear. It is made when it is missing.

    Yields:
        The folder to write to.

    Raises:
        OutputError: A file cannot be written.
    """
    beside = folder / f".new.{os.getpid()}"
    with writing(folder), making(folder), naming(folder, beside):
        try:
            # A run of this number that was killed may have left one.
            shutil.rmtree(beside, ignore_errors=True)
            beside.mkdir()
            yield beside
            files = [path.relative_to(beside) for path in beside.rglob("*") if path.is_file()]
            # Files in subfolders first: those at the top refer to them.
            for file in sorted(files, key=lambda path: (-len(path.parts), path)):
                (folder / file).parent.mkdir(parents=True, exist_ok=True)
                (beside / file).replace(folder / file)
        finally:
            shutil.rmtree(beside, ignore_errors=True)


def write_text(target: Path, text: str) -> None:
    """Write ``text`` as UTF-8 with Unix line ends; the file appears whole or not at all."""
    with replacing(target) as beside:
        beside.write_text(text, encoding="utf-8", newline="\n")


def write_bytes(target: Path, data: bytes) -> None:
    """Write ``data``; the file appears whole or not at all."""
    with replacing(target) as beside:
        beside.write_bytes(data)
