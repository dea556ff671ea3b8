"""The table of contents of a binary USD file, weighed before USD takes memory for what it claims.

USD makes room for as many names, paths and fields as a crate announces, and only then looks whether
they are there. (OpenUSD, ``pxr/usd/sdf/crateFile.h``: a head, sections, and a table of them.)
"""

import struct
from typing import BinaryIO, Final

from openrooms_usd.errors import InputError

MAGIC: Final = b"PXR-USDC"
_HEAD: Final = struct.Struct("<8s8sq")
_COUNT: Final = struct.Struct("<Q")
_SECTION: Final = struct.Struct("<16sqq")
_MOST_SECTIONS: Final = 64
# LZ4 packs 255 bytes into one at most, and USD's coding of whole numbers 16 into one before.
_MOST_GAIN: Final = 255 * 16
_MOST_TEXT_GAIN: Final = 256
_STRING_BYTES: Final = 4  # bytes; the only ones that are never packed


def check_crate(stream: BinaryIO, size: int, place: object) -> None:
    """See that a crate's sections lie in it and announce no more than they can hold.

    Args:
        stream: The file, or its bytes; what is no crate is not looked at.
        size: How many bytes there are.
        place: Where they are from, for messages.

    Raises:
        InputError: They do not, or it is cut off.
    """
    stream.seek(0)
    head = stream.read(_HEAD.size)
    if not head.startswith(MAGIC):
        return
    try:
        _, _, table = _HEAD.unpack(head)
        for name, start, length in _sections(stream, table, size):
            if min(start, length) < 0 or start + length > size:
                raise ValueError("a section lies outside the file")
            _check_section(stream, name, start, length)
    except (struct.error, ValueError) as error:
        raise InputError(
            f"not a readable USD file: {error}",
            place=place,
            remedy="copy it again, or export it again",
        ) from error


def _sections(stream: BinaryIO, table: int, size: int) -> list[tuple[bytes, int, int]]:
    if not 0 < table <= size - _COUNT.size:
        raise ValueError("its table of contents lies outside the file")
    stream.seek(table)
    (count,) = _COUNT.unpack(stream.read(_COUNT.size))
    if count > _MOST_SECTIONS:
        raise ValueError(f"it announces {count:,} sections")
    return [_SECTION.unpack(stream.read(_SECTION.size)) for _ in range(count)]


def _check_section(stream: BinaryIO, name: bytes, start: int, length: int) -> None:
    name = name.rstrip(b"\0")
    stream.seek(start)
    (count,) = _COUNT.unpack(stream.read(_COUNT.size))
    most = length // _STRING_BYTES if name == b"STRINGS" else _MOST_GAIN * length
    if name == b"TOKENS":
        (text,) = _COUNT.unpack(stream.read(_COUNT.size))
        count = max(count, text)
        most = _MOST_TEXT_GAIN * length
    if count > most:
        said = name.decode("ascii", "replace")
        raise ValueError(f"its section {said} announces {count:,} entries in {length:,} bytes")
