"""The only way to open untrusted files: regular, of a plausible size, with a valid path.

Readers of every format come through here before a byte is interpreted. A pipe would hang, a device
has no end, a link may lead to either; a path may hold what no file system takes. Callers that need
the bytes call `read_bytes` or `opened`; callers that pass the path to a library call `checked`
first.
"""

import codecs
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path, PurePosixPath
from typing import Final, Literal

from openrooms_usd.errors import InputError

Kind = Literal[
    "text",
    "description",
    "json",
    "annotations",
    "table",
    "pickle",
    "usd",
    "archive",
    "picture",
    "model",
    "array",
    "points",
    "frames",
]

_MIB: Final = 1 << 20
# Far beyond what real files of a kind need; points and frames are read in pieces.
MOST_BYTES: Final[dict[Kind, int]] = {
    "text": 16 * _MIB,
    "description": 16 * _MIB,
    "json": 64 * _MIB,
    "annotations": 1024 * _MIB,
    "table": 64 * _MIB,
    "pickle": 64 * _MIB,
    "usd": 1024 * _MIB,
    "archive": 2048 * _MIB,
    "picture": 512 * _MIB,
    "model": 512 * _MIB,
    "array": 512 * _MIB,
    "points": 65_536 * _MIB,
    "frames": 262_144 * _MIB,
}
# What Git LFS leaves in place of a file is shorter.
_MOST_OF_A_POINTER: Final = 1024
_POINTER: Final = b"version https://git-lfs.github.com/spec/"
# What Linux, macOS and Windows take at most.
_LONGEST_NAME_BYTES: Final = 255
_LONGEST_PATH_BYTES: Final = 4095
# Without waiting: opening a pipe without a writer would never return.
_FLAGS: Final = (
    os.O_RDONLY
    | getattr(os, "O_NONBLOCK", 0)
    | getattr(os, "O_CLOEXEC", 0)
    | getattr(os, "O_BINARY", 0)
)
_KINDS: Final = (
    (stat.S_ISREG, "a file"),
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)


def checked(path: Path, kind: Kind, *, remedy: str = "check the path") -> int:
    """See that a path leads to a regular file of a sensible size.

    Args:
        path: The file; links are followed.
        kind: What it should be.
        remedy: What to do where there is no such file.

    Returns:
        Its size, bytes.

    Raises:
        InputError: It is missing, unreadable, no regular file, too large, or the path is unsound.
    """
    with opened(path, kind, remedy=remedy) as stream:
        return os.fstat(stream.fileno()).st_size


@contextmanager
def opened(path: Path, kind: Kind, *, remedy: str = "check the path") -> Iterator[BufferedReader]:
    """A file to read bytes from; what is read inside the block may fail for the same reasons.

    Args:
        path: The file; links are followed.
        kind: What it should be.
        remedy: What to do where there is no such file.

    Raises:
        InputError: It is missing, unreadable, no regular file, too large, or the path is unsound.
    """
    check_path(path)
    try:
        with _descriptor(path) as handle:
            _check_file(path, kind, os.fstat(handle))
            with open(handle, "rb", closefd=False) as stream:
                if os.fstat(handle).st_size < _MOST_OF_A_POINTER:
                    check_head(stream.peek(), path)
                yield stream
    except FileNotFoundError as error:
        raise InputError("no such file", place=path, remedy=remedy) from error
    except OSError as error:
        if os.path.isdir(path):  # noqa: PTH112 - never raises; Windows opens no folder
            raise _no_file(path, "a folder") from error
        reason = f"cannot read it: {error.strerror or error}"
        raise InputError(reason, place=path, remedy=remedy) from error


def check_head(data: bytes, path: object) -> None:
    """Refuse what stands in place of a file where Git LFS has not fetched it.

    Raises:
        InputError: The data begin as such a pointer does.
    """
    if data.startswith(_POINTER):
        raise InputError(
            "a Git LFS pointer stands in place of this file",
            place=path,
            remedy="run `git lfs pull` in its repository",
        )


@contextmanager
def _descriptor(path: Path) -> Iterator[int]:
    handle = os.open(path, _FLAGS)
    try:
        yield handle
    finally:
        os.close(handle)


def read_bytes(path: Path, kind: Kind, *, remedy: str = "check the path") -> bytes:
    """A whole file.

    Args:
        path: The file; links are followed.
        kind: What it should be.
        remedy: What to do where there is no such file.

    Raises:
        InputError: It is missing, unreadable, no regular file, too large, or the path is unsound.
    """
    with opened(path, kind, remedy=remedy) as stream:
        data = stream.read(os.fstat(stream.fileno()).st_size)
        # Some files say that they are empty, and have no end.
        pieces, size = [data], len(data)
        while piece := stream.read(_MIB):
            pieces.append(piece)
            size += len(piece)
            if size > MOST_BYTES[kind]:
                raise _too_large(path, kind, size)
    return data if len(pieces) == 1 else b"".join(pieces)


def read_text(path: Path, kind: Kind = "text", *, remedy: str = "check the path") -> str:
    """A whole text, as `decoded` has it.

    Raises:
        InputError: It is missing, unreadable, no regular file, too large, or the path is unsound.
    """
    return decoded(read_bytes(path, kind, remedy=remedy))


def decoded(data: bytes) -> str:
    """Text in UTF-8, or in UTF-16 with a byte order mark; U+FFFD replaces invalid bytes."""
    return data.decode(encoding_of(data), errors="replace")


def encoding_of(start: bytes) -> str:
    """How a text is written that begins so; what reads it leaves out the byte order mark."""
    wide = start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    return "utf-16" if wide else "utf-8-sig"


def check_path(path: Path) -> None:
    """See that a file system could know a path; nothing is looked up.

    Raises:
        InputError: It holds a NUL byte or lone surrogates, or a name or the whole is too long.
    """
    try:
        name = os.fsencode(path)
    except UnicodeEncodeError:
        raise _unsound(path, "it is not the text of a path") from None
    if b"\0" in name:
        raise _unsound(path, "it holds a NUL byte")
    if len(name) > _LONGEST_PATH_BYTES:
        raise _unsound(path, f"it is longer than {_LONGEST_PATH_BYTES} bytes")
    if any(len(os.fsencode(part)) > _LONGEST_NAME_BYTES for part in path.parts):
        raise _unsound(path, f"a name in it is longer than {_LONGEST_NAME_BYTES} bytes")


def inside(folder: Path, relative: str) -> Path:
    """The path of a file that must lie in a folder, whatever links there are on the way.

    Args:
        folder: The folder.
        relative: A path in an untrusted file; forward slashes.

    Returns:
        ``folder / relative``; it need not exist.

    Raises:
        InputError: The path is absolute, unsound, or leaves the folder.
    """
    path = folder / relative
    check_path(path)
    parts = PurePosixPath(relative.replace("\\", "/")).parts
    try:
        leaves = not path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError):  # links in a circle
        leaves = True
    if not parts or Path(relative).is_absolute() or ".." in parts or leaves:
        raise _unsound(path, f"it leads out of the folder {folder}")
    return path


def is_plain_name(name: str) -> bool:
    """Whether a text can be the name of one file or folder: no separator, no ``..``, not empty."""
    if name in ("", ".", "..") or any(sign in name for sign in "/\\\0:"):
        return False
    try:
        return len(os.fsencode(name)) <= _LONGEST_NAME_BYTES
    except UnicodeEncodeError:
        return False


def kind_of(path: Path) -> str:
    """What a path leads to, links followed: ``a file``, ``a folder``; empty where nothing is.

    Raises:
        OSError: It cannot be looked at.
    """
    try:
        return _named(path.stat().st_mode)
    except (FileNotFoundError, NotADirectoryError):
        return ""


def _named(mode: int) -> str:
    return next((name for is_it, name in _KINDS if is_it(mode)), "something else")


def _check_file(path: Path, kind: Kind, found: os.stat_result) -> None:
    what = _named(found.st_mode)
    if what != "a file":
        raise _no_file(path, what)
    if found.st_size > MOST_BYTES[kind]:
        raise _too_large(path, kind, found.st_size)


def _no_file(path: Path, what: str) -> InputError:
    return InputError(
        f"this is {what}, not a file", place=path, remedy="give the path of a regular file"
    )


def _too_large(path: Path, kind: Kind, size: int) -> InputError:
    most = MOST_BYTES[kind] // _MIB
    return InputError(
        f"the file has {size / _MIB:,.0f} MiB; at most {most:,} MiB are read as {kind}",
        place=path,
        remedy="is this the right file?",
    )


def _unsound(path: Path, why: str) -> InputError:
    shown = str(path).encode("utf-8", "backslashreplace").decode()
    shown = shown if len(shown) <= 200 else f"{shown[:100]}...{shown[-60:]}"
    return InputError(
        f"this cannot be the path of a file: {why}",
        place=shown.replace("\0", "\\0"),
        remedy="check the path",
    )
