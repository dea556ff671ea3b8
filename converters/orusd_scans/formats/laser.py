"""LAS, LAZ and E57 files of laser scanners, through laspy and pye57."""

import re
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import MissingPackageError, OrusdError
from orusd_scans.formats.laz_reader import check_laz_reads
from orusd_scans.scanned import Scanned, broken, cloud_of, counted, opened, size_of

_LAS: Final = ("x", "y", "z", "red", "green", "blue")
_LAS_HEAD: Final = 375  # bytes
_PACKED_BITS: Final = 0xC0  # of the byte that says the point format
# Packed points have a byte each, and more; so few may have less.
_HARMLESS_POINTS: Final = 1 << 16
# A record of the header up to the size of chunks, where it says how points are packed.
_RECORD: Final = struct.Struct("<2x16sHH32x12xI")
_LASZIP_RECORD: Final = 22204
_MOST_IN_CHUNK: Final = 1 << 20
_CHUNKS_VARY: Final = 0xFFFFFFFF
_E57_HEAD: Final = struct.Struct("<8sIIQQQQ")
_E57_PAGE: Final = 1024
_MOST_XML: Final = 1 << 26
_ENTITIES: Final = re.compile(rb"<!\s*(DOCTYPE|ENTITY)", re.IGNORECASE)
_REMEDY: Final = "pip install 'openrooms_usd[scans]'"


def read_las(path: Path) -> Scanned:
    """Read a LAS or LAZ file; its classes are those of maps, and left out.

    Raises:
        InputError: It is not such a file, is truncated, or holds no points.
        MissingPackageError: laspy, or lazrs for LAZ, is not installed.
    """
    laspy = _package("laspy")
    if path.suffix.lower() == ".laz":
        _package("lazrs")
    with opened(path) as stream, _blaming_the_file(path, "LAS"):
        _check_las(stream, path)
        with laspy.open(stream, closefd=False) as reader:
            header = reader.header
            count = counted(path, str(header.point_count))
            room = size_of(stream) - header.offset_to_point_data
            packed = header.are_points_compressed
            needed = count - _HARMLESS_POINTS if packed else count * header.point_format.size
            if room < max(needed, 0):
                raise broken(path, f"it ends too early: {count:,} points are announced")
            if packed:
                check_laz_reads(str(path), size_of(stream))
            points = reader.read()
        known = {"x", "y", "z", *points.point_format.dimension_names}
        columns = {name: np.asarray(points[name]) for name in _LAS if name in known}
    return Scanned(cloud_of(columns, path, []))


def _check_las(stream: BinaryIO, path: Path) -> None:
    """Refuse numbers of records that laspy would go on counting after the end of the file.

    (ASPRS, "LAS Specification 1.4 - R15", 2019, table 3.)
    """
    head = stream.read(_LAS_HEAD).ljust(_LAS_HEAD, b"\0")
    length, start, records = struct.unpack_from("<HII", head, 94)
    more_start, more = struct.unpack_from("<QI", head, 235) if head[25] >= 4 else (0, 0)
    ends = (length + 54 * records, start, more_start + 60 * more)
    if max(ends) > size_of(stream) or ends[0] > start:
        raise broken(path, "it ends too early, or its header is damaged")
    if head[104] & _PACKED_BITS:
        _check_chunks(stream, start, path)
        _check_chunk_size(stream, length, records, path)
    stream.seek(0)


def _check_chunks(stream: BinaryIO, start: int, path: Path) -> None:
    """Refuse a table of more chunks than there are bytes: its reader ends the whole process.

    (Isenburg, "LASzip: lossless compression of LiDAR data", 2013; the table's place stands before
    the points, or at the file's end where the writer could not go back.)
    """
    size = size_of(stream)
    for where in (start, size - 8):
        stream.seek(max(where, 0))
        (table,) = struct.unpack("<q", stream.read(8).ljust(8, b"\0"))
        if table != -1:
            break
    if not start <= table <= size - 8:
        raise broken(path, "its table of chunks lies outside the file")
    stream.seek(table)
    _, chunks = struct.unpack("<II", stream.read(8))
    if chunks > size - start:
        raise broken(path, f"it announces {chunks:,} chunks, more than the file can hold")


def _check_chunk_size(stream: BinaryIO, start: int, records: int, path: Path) -> None:
    """Refuse chunks of more points than the file has bytes: memory is taken for a whole one."""
    for _ in range(records):
        stream.seek(start)
        record = stream.read(_RECORD.size).ljust(_RECORD.size, b"\0")
        author, kind, length, points = _RECORD.unpack(record)
        if author.rstrip(b"\0") == b"laszip encoded" and kind == _LASZIP_RECORD:
            if _MOST_IN_CHUNK + size_of(stream) < points < _CHUNKS_VARY:
                raise broken(path, f"it announces chunks of {points:,} points")
            return
        start += 54 + length


def read_e57(path: Path) -> Scanned:
    """Read all scans of an E57 file, in its common frame; where each stood is a sensor.

    Raises:
        InputError: It is not such a file, is truncated, or holds no points.
        MissingPackageError: pye57 is not installed.
    """
    pye57 = _package("pye57")
    with opened(path) as stream:
        size = size_of(stream)
        _check_e57(stream, path)
    with _blaming_the_file(path, "E57"):
        file = pye57.E57(str(path))
        try:
            points = sum(file.get_header(i).point_count for i in range(file.scan_count))
            if counted(path, str(points)) > size:
                raise broken(path, f"it ends too early: {points:,} points are announced")
            scans = [
                file.read_scan(i, colors=True, ignore_missing_fields=True)
                for i in range(file.scan_count)
            ]
            headers = [file.get_header(i) for i in range(file.scan_count)]
            places = [
                np.asarray(head.translation, np.float64) for head in headers if head.has_pose()
            ]
        finally:
            file.close()
    if not scans:
        raise broken(path, "it holds no scans")
    cloud = cloud_of(_joined(scans), path, [])
    return Scanned(replace(cloud, sensor_origins=np.array(places)) if places else cloud)


def _check_e57(stream: BinaryIO, path: Path) -> None:
    """Refuse a description that declares entities, which its reader would look up and unfold.

    (ASTM E2807, clause 7: the XML section, in pages that end in checksums.)
    """
    head = stream.read(_E57_HEAD.size)
    if len(head) < _E57_HEAD.size or not head.startswith(b"ASTM-E57"):
        raise broken(path, "this is not an E57 file")
    _, _, _, _, offset, length, page = _E57_HEAD.unpack(head)
    if page != _E57_PAGE or offset + length > size_of(stream) or length > _MOST_XML:
        raise broken(path, "it ends too early, or its header is damaged")
    stream.seek(offset - offset % page)
    pages = stream.read((length // (page - 4) + 2) * page)
    text = b"".join(pages[i : i + page - 4] for i in range(0, len(pages), page))
    text = text[offset % page :][:length]
    if not text.lstrip(b"\xef\xbb\xbf").startswith(b"<?xml") or _ENTITIES.search(text):
        raise broken(path, "its description is not XML, or declares entities")


def _joined(scans: list[dict[str, NDArray[Any]]]) -> dict[str, NDArray[Any]]:
    names = {"cartesianX": "x", "cartesianY": "y", "cartesianZ": "z"}
    names |= {"colorRed": "red", "colorGreen": "green", "colorBlue": "blue"}
    shared = [name for name in names if all(name in scan for scan in scans)]
    return {names[name]: np.concatenate([scan[name] for scan in scans]) for name in shared}


def _package(name: str) -> Any:
    import importlib

    try:
        return importlib.import_module(name)
    except ImportError as error:
        raise MissingPackageError(f"{name} is not installed", remedy=_REMEDY) from error


@contextmanager
def _blaming_the_file(path: Path, kind: str) -> Iterator[None]:
    """Whatever the libraries stumble over is the file's fault."""
    try:
        yield
    except (OrusdError, KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:  # a library in Rust raises a BaseException
        reason = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise broken(path, f"not a readable {kind} file: {reason[:200]}") from error
