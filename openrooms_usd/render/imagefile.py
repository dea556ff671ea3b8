"""Whether a picture really reached the disk, which OpenImageIO's calls alone do not say."""

from pathlib import Path
from typing import Any

from openrooms_usd.errors import OutputError


def finish(output: Any, done: bool, path: Path) -> None:
    """Close an image writer and see that the file is whole.

    On a full disk the writer's calls may all succeed: some failures show only in its error text,
    and that of the last buffer nowhere but in the file.

    Args:
        output: The ``OpenImageIO.ImageOutput``.
        done: Whether every call before succeeded.
        path: The file.

    Raises:
        OutputError: It is not.
    """
    closed = output.close()
    error = output.geterror() or ("" if done and closed else "unknown reason") or _damage(path)
    if error:
        raise OutputError(
            f"cannot write: {error.strip().splitlines()[0]}",
            place=path,
            remedy="free space, or choose another output folder",
        )


def _damage(path: Path) -> str:
    """What keeps the last row from being read; empty where nothing does."""
    import OpenImageIO

    source: Any = OpenImageIO.ImageInput.open(str(path))
    if source is None:
        return OpenImageIO.geterror() or "the file is cut off"
    last = source.spec().height - 1
    row = source.read_scanlines(last, last + 1, 0, 0, 1, OpenImageIO.FLOAT)
    error = source.geterror()
    source.close()
    return error or ("the file is cut off" if row is None else "")
