"""PCD files of the Point Cloud Library: ``ascii``, ``binary`` and ``binary_compressed`` (LZF)."""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from orusd_scans.formats.rows import Counted, lines_before, read_rows
from orusd_scans.scanned import (
    LONGEST_HEADER,
    Scanned,
    broken,
    cloud_of,
    counted,
    lines_of,
    opened,
    size_of,
)

_KEYS: Final = (
    "VERSION",
    "FIELDS",
    "SIZE",
    "TYPE",
    "COUNT",
    "WIDTH",
    "HEIGHT",
    "VIEWPOINT",
    "POINTS",
    "DATA",
)
_SIZES: Final = {"F": ("4", "8"), "I": ("1", "2", "4", "8"), "U": ("1", "2", "4", "8")}
_PACKED: Final = ("rgb", "rgba")
_LONGEST_ROW: Final = 1 << 16  # bytes
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


def read_pcd(path: Path) -> Scanned:
    """Read the points of a PCD file.

    A viewpoint away from the origin is where the scanner stood; one at the origin may just be
    what writers put there.

    Raises:
        InputError: It is not a PCD file, is truncated, or holds nonsense.
    """
    with opened(path) as stream:
        header = _header(stream, path)
        row, count = _row(header, path), _count(header, path)
        kind = " ".join(header["DATA"])
        if kind != "ascii" and kind not in _READERS:
            raise broken(path, f"data of the form {kind[:40]!r} is not known")
        notes: list[str] = []
        if kind == "ascii":
            values = _ascii(stream, row, count, path, notes)
        else:
            values = _READERS[kind](stream, row, count, path)
    named = {n: v for n, v in values.items() if not n.startswith("_")}
    columns = {n: v for n, v in named.items() if v.ndim == 1}
    cloud = cloud_of(_with_colors(columns), path, notes, named.keys() - columns.keys())
    origin = _viewpoint(header, path)
    if origin.any():
        cloud = replace(cloud, sensor_origins=origin[None])
    return Scanned(cloud, notes=tuple(notes))


def _header(stream: BinaryIO, path: Path) -> dict[str, list[str]]:
    found: dict[str, list[str]] = {}
    while "DATA" not in found:
        line = stream.readline(LONGEST_HEADER)
        if not line.endswith(b"\n") or stream.tell() > LONGEST_HEADER:
            raise broken(path, f"this is not a PCD file: no DATA within {LONGEST_HEADER >> 10} KB")
        key, *words = line.decode("latin-1").split() or ["#"]
        if key.startswith("#"):
            continue
        if key not in _KEYS:
            raise broken(path, f"this is not a PCD file: its header has a line {key[:20]!r}")
        found[key] = words
    if missing := [key for key in ("FIELDS", "SIZE", "TYPE") if key not in found]:
        raise broken(path, f"the header lacks {', '.join(missing)}")
    return found


def _row(header: Mapping[str, list[str]], path: Path) -> np.dtype[Any]:
    names, sizes, types = header["FIELDS"], header["SIZE"], header["TYPE"]
    counts = header.get("COUNT", ["1"] * len(names))
    if not len(names) == len(sizes) == len(types) == len(counts):
        raise broken(path, "FIELDS, SIZE, TYPE and COUNT of the header differ in length")
    fields: list[Any] = []
    for i, (name, size, kind, count) in enumerate(zip(names, sizes, types, counts, strict=True)):
        if size not in _SIZES.get(kind, ()):
            raise broken(path, f"a field of the type {kind[:9]} and {size[:9]} bytes is not known")
        times = counted(path, count, "values")
        if times < 1:
            raise broken(path, f"the field {name[:60]!r} holds nothing")
        # Padding is called _ each time.
        known = name.lower() if name != "_" else f"_{i}"
        fields.append((known, f"<{kind.lower()}{size}", () if times == 1 else (times,)))
    try:
        row = np.dtype(fields)
    except ValueError as error:
        raise broken(path, f"the header's fields make no row: {error}") from error
    if row.itemsize > _LONGEST_ROW:
        raise broken(path, f"points of {row.itemsize:,} bytes make no sense")
    return row


def _count(header: Mapping[str, list[str]], path: Path) -> int:
    width, height, points = (
        counted(path, " ".join(header.get(key, [default])))
        for key, default in (("WIDTH", "0"), ("HEIGHT", "1"), ("POINTS", "0"))
    )
    if "POINTS" in header and "WIDTH" in header and points != width * height:
        raise broken(path, f"the header announces {points:,} points, but {width:,} x {height:,}")
    return counted(path, str(points or width * height))


def _viewpoint(header: Mapping[str, list[str]], path: Path) -> Array:
    """(3,) where the scanner stood."""
    try:
        origin = np.array([float(word) for word in header.get("VIEWPOINT", ["0"] * 7)[:3]])
    except ValueError as error:
        raise broken(path, "the header's VIEWPOINT is not of numbers") from error
    if origin.shape != (3,) or not np.isfinite(origin).all():
        raise broken(path, "the header's VIEWPOINT is not a position")
    return origin


def _ascii(
    stream: BinaryIO, row: np.dtype[Any], count: int, path: Path, notes: list[str]
) -> dict[str, NDArray[Any]]:
    width = sum(int(np.prod(row[name].shape, dtype=int)) for name in row.names or ())
    lines = map(partial(str, encoding="latin-1"), lines_of(stream))
    first = lines_before(stream) + 1
    rows = read_rows(Counted(lines, count), width, path, first=first)
    values = rows.values
    notes += rows.told
    if len(values) != count:
        raise broken(path, f"{count:,} lines are announced, but {len(values):,} are there")
    found, start = dict[str, NDArray[Any]](), 0
    for name in row.names or ():
        shape = row[name].shape
        size = int(np.prod(shape, dtype=int))
        column = values[:, start] if shape == () else values[:, start : start + size]
        found[name] = _as_stored(column, row[name].base) if name in _PACKED else column
        start += size
    return found


def _as_stored(column: NDArray[Any], kind: np.dtype[Any]) -> NDArray[Any]:
    """A packed colour as binary files hold it: its bits are what counts."""
    with np.errstate(invalid="ignore", over="ignore"):
        return column.astype(kind)


def _binary(stream: BinaryIO, row: np.dtype[Any], count: int, path: Path) -> Any:
    left = size_of(stream) - stream.tell()
    if left < count * row.itemsize:
        raise broken(path, f"it ends too early: {count:,} points are announced")
    values = np.fromfile(stream, row, count)
    return {name: values[name] for name in row.names or ()}


def _compressed(stream: BinaryIO, row: np.dtype[Any], count: int, path: Path) -> Any:
    """Column by column, packed as one block."""
    head = stream.read(8)
    packed, size = (int(n) for n in np.frombuffer(head, "<u4")) if len(head) == 8 else (0, 0)
    if size != count * row.itemsize:
        raise broken(path, f"it holds {size:,} bytes, but {count:,} points are announced")
    data = stream.read(packed)
    if len(data) < packed:
        raise broken(path, "it ends too early")
    try:
        plain = unpacked(data, size)
    except UnpackError as error:
        raise broken(path, f"its packed data is damaged: {error}") from error
    found, start = {}, 0
    for name in row.names or ():
        kind = row[name]
        values = np.frombuffer(plain, kind.base, kind.itemsize // kind.base.itemsize * count, start)
        found[name] = values.reshape(count, *kind.shape)
        start += kind.itemsize * count
    return found


def _with_colors(columns: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Packed colours (0xRRGGBB, as a whole number or in the bits of a float) taken apart."""
    packed = next((columns[name] for name in _PACKED if name in columns), None)
    if packed is None or packed.dtype.itemsize != 4:
        return dict(columns)
    bits = np.ascontiguousarray(packed).view(np.uint32)
    channels = {"red": 16, "green": 8, "blue": 0}
    rest = {name: column for name, column in columns.items() if name not in _PACKED}
    return rest | {n: (bits >> s & 255).astype(np.uint8) for n, s in channels.items()}


_READERS: Final = {"binary": _binary, "binary_compressed": _compressed}
