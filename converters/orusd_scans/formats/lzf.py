"""LZF, the packing of compressed PCD files (Marc Lehmann's LibLZF), unpacked."""

from typing import Final

# One literal needs two bytes; a copy of up to 264 bytes needs three.
_MOST_GAIN: Final = 264


class UnpackError(ValueError):
    """Packed data is damaged."""


def unpacked(data: bytes, size: int) -> bytes:
    """Unpack a block.

    Args:
        data: The packed block.
        size: How many bytes it must give.

    Raises:
        UnpackError: It gives another number of bytes, or refers to what is not there.
    """
    if size > _MOST_GAIN * len(data):
        raise UnpackError(f"{len(data):,} bytes cannot hold {size:,}")
    out = bytearray()
    at, end = 0, len(data)
    try:
        while at < end:
            control = data[at]
            at += 1
            if control < 32:
                out += data[at : at + control + 1]
                at += control + 1
                continue
            length = (control >> 5) + 2
            if length == 9:
                length += data[at]
                at += 1
            back = ((control & 31) << 8) + data[at] + 1
            at += 1
            _copy(out, back, length)
    except IndexError as error:
        raise UnpackError("it ends too early") from error
    if at > end or len(out) != size:
        raise UnpackError(f"it gives {len(out):,} bytes, not {size:,}")
    return bytes(out)


def _copy(out: bytearray, back: int, length: int) -> None:
    """Repeat what stands some bytes back; it may reach into what is being written."""
    start = len(out) - back
    if start < 0:
        raise UnpackError("it refers to bytes before its beginning")
    piece = out[start : start + length]
    out += (piece * (length // len(piece) + 1))[:length] if len(piece) < length else piece
