"""Which ``room.yaml`` a plan is drawn in: one that is there, or that of a scan that is imported."""

from pathlib import Path
from typing import Final

from openrooms_usd.errors import InputError
from openrooms_usd.importing import ROOM, import_capture

_DESCRIPTIONS: Final = (".yaml", ".yml")


def room_file(source: Path, out: Path | None = None, importer: str = "scan") -> Path:
    """The description to draw in.

    Args:
        source: A ``room.yaml``, a folder with one, or a scan.
        out: The folder that a scan is imported to.
        importer: What reads a scan.

    Raises:
        InputError: The scan cannot be read, or there is no folder to import it to.
        OutputError: There is a room in that folder already.
    """
    if (source / ROOM).is_file():
        source = source / ROOM
    if source.suffix in _DESCRIPTIONS:
        if out is not None:
            raise InputError(
                "a room.yaml is changed where it is",
                place=source,
                remedy="leave --out away, or copy its folder first",
            )
        return source
    if out is None:
        raise InputError(
            "a scan needs a folder in which its room.yaml is written",
            place=source,
            remedy="give one: `--out DIR`",
        )
    return import_capture(importer, source, out).file
