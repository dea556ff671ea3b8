"""Whether a picture really reached the disk, which OpenImageIO's calls alone do not say."""

from pathlib import Path
from typing import Any, Final

from openrooms_usd.errors import OutputError

_PNG_END: Final = b"IEND\xaeB\x60\x82"


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
    error = output.geterror() or ("" if done and closed else "unknown reason")
    if error or not is_whole(path):
        reason = error.strip().splitlines()[0] if error else "the disk took only a part of it"
        raise OutputError(
            f"cannot write the picture: {reason}",
            place=path,
            remedy="free space, or choose another output folder",
        )


def is_whole(path: Path) -> bool:
    """Whether the end of a picture is there."""
    if path.suffix == ".png":
        # Its reader would complain on standard error.
        with path.open("rb") as file:
            file.seek(max(0, path.stat().st_size - len(_PNG_END)))
            return file.read(len(_PNG_END)) == _PNG_END
    import OpenImageIO

    source: Any = OpenImageIO.ImageInput.open(str(path))
    if source is None:
        OpenImageIO.geterror()
        return False
    last = source.spec().height - 1
    row = source.read_scanlines(last, last + 1, 0, 0, 1, OpenImageIO.FLOAT)
    damaged = bool(source.geterror())
    source.close()
    return row is not None and not damaged
