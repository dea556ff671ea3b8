"""Spoils what lies inside of archives and checked formats, so that their sums still agree."""

import io
import struct
import warnings
import zipfile
import zlib
from collections.abc import Callable
from random import Random
from typing import Final

Inner = Callable[[str, bytes], bytes]
"""The spoilt content of a member with a name."""

_PNG: Final = 8
_PAGE: Final = 1024


def spoil_zip(data: bytes, rng: Random, inner: Inner) -> bytes:
    """Change one member, or its name.

    Raises:
        ValueError: It is no archive.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = [(item.filename, archive.read(item)) for item in archive.infolist()]
    except (zipfile.BadZipFile, RuntimeError, EOFError) as error:
        raise ValueError("no archive") from error
    if not members:
        raise ValueError("an empty archive")
    at = rng.randrange(len(members))
    name, content = members[at]
    what = rng.random()
    if what < 0.8:
        members[at] = (name, inner(name, content))
    elif what < 0.9:
        members[at] = (
            rng.choice(("../x.usda", "/x.usda", "a" * 300, "", "x\x1b[31m", name)),
            content,
        )
    else:
        members.insert(at, members[rng.randrange(len(members))])
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of names that are there twice
        for name, content in members:
            archive.writestr(zipfile.ZipInfo(name or "_"), content)
    return made.getvalue()


def spoil_glb(data: bytes, rng: Random, inner: Inner) -> bytes:
    """Change the JSON or the binary chunk.

    Raises:
        ValueError: It is no GLB file.
    """
    if data[:4] != b"glTF" or len(data) < 20:
        raise ValueError("no GLB file")
    size = struct.unpack_from("<I", data, 12)[0]
    text, rest = data[20 : 20 + size], data[20 + size :]
    if rng.random() < 0.8 or len(rest) < 8:
        text = inner("chunk.json", text)
    else:
        rest = rest[:8] + inner("chunk.bin", rest[8:])
        rest = struct.pack("<I", len(rest) - 8) + rest[4:]
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON")
    return head + text + rest


def spoil_png(data: bytes, rng: Random, inner: Inner) -> bytes:
    """Change one chunk and mend its sum.

    Raises:
        ValueError: It is no PNG file.
    """
    if data[1:4] != b"PNG":
        raise ValueError("no PNG file")
    chunks, at = [], _PNG
    while at + 12 <= len(data):
        size = struct.unpack_from(">I", data, at)[0]
        chunks.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + size]))
        at += 12 + size
    if not chunks:
        raise ValueError("no chunks")
    i = rng.randrange(len(chunks))
    kind, content = chunks[i]
    chunks[i] = (kind, inner("chunk.bin", content))
    made = [data[:_PNG]]
    for kind, content in chunks:
        sum_ = zlib.crc32(kind + content)
        made.append(struct.pack(">I", len(content)) + kind + content + struct.pack(">I", sum_))
    return b"".join(made)


def spoil_e57(data: bytes, rng: Random, inner: Inner) -> bytes:
    """Change the pages and mend their sums."""
    body = b"".join(data[i : i + _PAGE - 4] for i in range(0, len(data), _PAGE))
    at = body.find(b"<?xml")
    if at > 0 and rng.random() < 0.6:
        body = body[:at] + inner("head.xml", body[at:])
    else:
        body = inner("pages.bin", body)
    pages = (body[i : i + _PAGE - 4] for i in range(0, len(body), _PAGE - 4))
    padded = (page.ljust(_PAGE - 4, b"\0") for page in pages)
    return b"".join(page + struct.pack(">I", _crc32c(page)) for page in padded)


def _row(byte: int) -> int:
    for _ in range(8):
        byte = (byte >> 1) ^ (0x82F63B78 if byte & 1 else 0)
    return byte


_ROWS: Final = tuple(map(_row, range(256)))


def _crc32c(data: bytes) -> int:
    """Castagnoli's sum, which E57 has after each page."""
    found = 0xFFFFFFFF
    for byte in data:
        found = (found >> 8) ^ _ROWS[(found ^ byte) & 255]
    return found ^ 0xFFFFFFFF


BY_SUFFIX: Final[dict[str, Callable[[bytes, Random, Inner], bytes]]] = {
    ".usdz": spoil_zip,
    ".npz": spoil_zip,
    ".glb": spoil_glb,
    ".png": spoil_png,
    ".e57": spoil_e57,
}
