"""What the head of a crate (``.usdc``) claims, weighed before USD takes memory for it.

A crate ends in a table of sections, and each section begins with how much it holds. USD believes
both. The layout is that of ``pxr/usd/sdf/crateFile.h``.
"""

import struct
from typing import BinaryIO, Final

MAGIC: Final = b"PXR-USDC"

# Magic, eight bytes of version, and where the table of sections begins.
_HEAD: Final = struct.Struct("<8s8sq")
_COUNT: Final = struct.Struct("<Q")
_SECTION: Final = struct.Struct("<16sqq")
# Number, size and compressed size of the tokens.
_TOKENS: Final = struct.Struct("<QQQ")
_MOST_SECTIONS: Final = 64
# LZ4 makes at most 255 bytes of one; whole numbers are first packed to at least two bits.
_LZ4: Final = 255
_DENSEST: Final = {b"STRINGS": 1, b"FIELDS": 4 * _LZ4, b"FIELDSETS": 4 * _LZ4,
                   b"PATHS": 4 * _LZ4, b"SPECS": 4 * _LZ4}  # fmt: skip


def is_sound(stream: BinaryIO, size: int) -> bool:
    """Whether a crate's sections lie in the file and could hold what they claim.

    Args:
        stream: The crate, which may be read anywhere.
        size: Its length, bytes.
    """
    try:
        stream.seek(0)
        start = _HEAD.unpack(stream.read(_HEAD.size))[2]
        stream.seek(start)
        (count,) = _COUNT.unpack(stream.read(_COUNT.size))
        if count > _MOST_SECTIONS:
            return False
        table = stream.read(count * _SECTION.size)
        return all(_holds(stream, size, *row) for row in _SECTION.iter_unpack(table))
    except (struct.error, ValueError, OSError):
        # Cut off, or a place before the beginning or beyond what a file can have.
        return False


def _holds(stream: BinaryIO, size: int, name: bytes, start: int, length: int) -> bool:
    if start < 0 or length < 0 or start + length > size:
        return False
    kind = name.rstrip(b"\0")
    stream.seek(start)
    if kind == b"TOKENS":
        count, whole, packed = _TOKENS.unpack(stream.read(_TOKENS.size))
        return bool(count <= whole <= _LZ4 * (packed + 1) and packed <= length)
    if kind in _DENSEST:
        (count,) = _COUNT.unpack(stream.read(_COUNT.size))
        return bool(count <= _DENSEST[kind] * length)
    return True
