"""LAS, LAZ and E57 files of laser scanners, through laspy and pye57."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError, MissingPackageError
from orusd_scans.scanned import Scanned, broken, cloud_of, counted, opened

_LAS: Final = ("x", "y", "z", "red", "green", "blue")
_REMEDY: Final = "pip install 'openrooms_usd[scans]'"


def read_las(path: Path) -> Scanned:
    """Read a LAS or LAZ file; its classes are those of maps, and left out.

    Raises:
        InputError: It is no such file, is cut off, or holds no points.
        MissingPackageError: laspy, or lazrs for LAZ, is not installed.
    """
    laspy = _package("laspy")
    if path.suffix.lower() == ".laz":
        _package("lazrs")
    with opened(path) as stream, _blamed(path, "LAS"), laspy.open(stream, closefd=False) as reader:
        header = reader.header
        counted(path, str(header.point_count))
        room = path.stat().st_size - header.offset_to_point_data
        if not header.are_points_compressed:
            room -= header.point_count * header.point_format.size
        if room < 0:
            raise broken(path, f"it ends too early: {header.point_count:,} points are announced")
        points = reader.read()
        known = {"x", "y", "z", *points.point_format.dimension_names}
        columns = {name: np.asarray(points[name]) for name in _LAS if name in known}
    return Scanned(cloud_of(columns, path, []))


def read_e57(path: Path) -> Scanned:
    """Read all scans of an E57 file, in its common frame; where each stood is an eye.

    Raises:
        InputError: It is no such file, is cut off, or holds no points.
        MissingPackageError: pye57 is not installed.
    """
    pye57 = _package("pye57")
    with opened(path):
        pass
    with _blamed(path, "E57"):
        file = pye57.E57(str(path))
        try:
            counted(path, str(sum(file.get_header(i).point_count for i in range(file.scan_count))))
            scans = [
                file.read_scan(i, colors=True, ignore_missing_fields=True)
                for i in range(file.scan_count)
            ]
            eyes = [file.get_header(i) for i in range(file.scan_count)]
            places = [np.asarray(head.translation, np.float64) for head in eyes if head.has_pose()]
        finally:
            file.close()
    if not scans:
        raise broken(path, "it holds no scans")
    cloud = cloud_of(_joined(scans), path, [])
    return Scanned(replace(cloud, eyes=np.array(places)) if places else cloud)


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
def _blamed(path: Path, kind: str) -> Iterator[None]:
    """Whatever the libraries stumble over is the file's fault."""
    try:
        yield
    except (InputError, MemoryError):
        raise
    except Exception as error:
        reason = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise broken(path, f"not a readable {kind} file: {reason[:200]}") from error
