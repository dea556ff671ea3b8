"""Unpacks untrusted LAZ files, in a process that may crash (see `isolation`).

The library that unpacks them ends the whole process where a chunk claims more than there is memory.
"""

from pathlib import Path
from typing import Final

from openrooms_usd.isolation import check_reads, serve
from openrooms_usd.untrusted import opened

_POINTS_AT_ONCE: Final = 1_000_000


def check_laz_reads(name: str, size: int) -> None:
    """See that another process can unpack a file, and lives.

    Args:
        name: The file.
        size: How many bytes it has.

    Raises:
        InputError: The process crashed, hung, or took too much memory.
    """
    check_reads("orusd_scans.formats.laz_reader", name, size, what="LAZ")


def _read(name: str) -> None:
    import laspy

    with opened(Path(name), "points") as stream, laspy.open(stream, closefd=False) as reader:
        for _ in reader.chunk_iterator(_POINTS_AT_ONCE):
            pass


if __name__ == "__main__":
    serve(_read)
