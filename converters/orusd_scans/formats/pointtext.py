"""Points as text (XYZ, PTS, CSV), and as the arrays of an NPZ file."""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.unpickling.arrays import read_arrays
from orusd_scans.scanned import Scanned, broken, cloud_of, lines_of, opened, table

# What columns without a header mean, by their number; more are passed over.
_BY_WIDTH: Final[dict[int, tuple[str, ...]]] = {
    3: ("x", "y", "z"),
    4: ("x", "y", "z", "intensity"),
    6: ("x", "y", "z", "red", "green", "blue"),
    7: ("x", "y", "z", "intensity", "red", "green", "blue"),
}
_NORMALS: Final = ("x", "y", "z", "nx", "ny", "nz")
_LONGEST_LINE: Final = 1 << 16
_UNIT_NORMAL_TOLERANCE: Final = 1e-2
# Arrays of an NPZ file that are (N, 3), and what their columns are.
_TRIPLES: Final = {
    "points": ("x", "y", "z"),
    "xyz": ("x", "y", "z"),
    "pc": ("x", "y", "z"),
    "normals": ("nx", "ny", "nz"),
    "colors": ("red", "green", "blue"),
}
_SINGLES: Final = ("label", "instance", "confidence")
# Where the sensor stood; the second name is an earlier one.
_ORIGINS: Final = ("sensor_origins", "eyes")


def read_text(path: Path) -> Scanned:
    """Read one point a line: numbers between spaces, commas or semicolons.

    A first line of words names the columns. Without one, three columns are x, y and z, four have an
    intensity, and six a colour, or a normal where those numbers have unit length; a first line with
    a single number is the count of points that PTS files begin with.

    Raises:
        InputError: It is no such table.
    """
    with opened(path) as stream:
        first = stream.readline(_LONGEST_LINE).decode("latin-1").strip().lstrip("#/ ")
        words = re.split(r"[\s,;]+", first)
        named = not _is_number(words[0])
        if not named and len(words) > 1:
            stream.seek(0)
        values = table((re.sub(rb"[,;]", b" ", line) for line in lines_of(stream)), path)
    if len(values) == 0:
        raise broken(path, "it holds no points")
    names = tuple(word.strip('"').lower() for word in words) if named else _names(values, path)
    if len(names) > values.shape[1]:
        raise broken(path, f"{len(names)} columns are named, but {values.shape[1]} are there")
    notes: list[str] = []
    columns = {name: values[:, i] for i, name in enumerate(names)}
    return Scanned(cloud_of(columns, path, notes), notes=tuple(notes))


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _names(values: NDArray[np.float64], path: Path) -> tuple[str, ...]:
    width = values.shape[1]
    if width < 3:
        raise broken(path, f"{width} columns are no points", "give x, y and z in each line")
    names = _BY_WIDTH.get(width, _BY_WIDTH[3])
    if (
        width == 6
        and (np.abs(np.linalg.norm(values[:, 3:], axis=1) - 1.0) < _UNIT_NORMAL_TOLERANCE).all()
    ):
        return _NORMALS
    return names


def read_npz(path: Path) -> Scanned:
    """Read the arrays ``points``, ``normals``, ``colors`` (N, 3), ``label`` and ``instance`` (N,).

    ``sensor_origins`` (V, 3), or ``eyes``, may say where the points were seen from.

    Raises:
        InputError: It is no NPZ file, holds objects, or its arrays do not fit each other.
    """
    found = read_arrays(path, (*_TRIPLES, *_SINGLES, *_ORIGINS), "points")
    given = {name: found.pop(name) for name in _ORIGINS if name in found}
    notes: list[str] = []
    cloud = cloud_of(_columns(found, path), path, notes)
    for name, origins in given.items():
        if origins.dtype.kind != "f" or origins.ndim != 2 or origins.shape[1] != 3:
            raise broken(path, f"{name!r} has the shape {origins.shape}")
        finite = origins[np.isfinite(origins).all(axis=1)]
        cloud = replace(cloud, sensor_origins=finite.astype(np.float64))
    return Scanned(cloud, notes=tuple(notes))


def _columns(arrays: Mapping[str, NDArray[Any]], path: Path) -> dict[str, NDArray[Any]]:
    columns: dict[str, NDArray[Any]] = {}
    for name, values in arrays.items():
        wide = name in _TRIPLES
        if values.ndim != 1 + wide or (wide and values.shape[1] < 3):
            raise broken(path, f"{name!r} has the shape {values.shape}")
        for i, column in enumerate(_TRIPLES.get(name, ())):
            columns[column] = values[:, i]
        if not wide:
            columns[name] = values
    if len({len(values) for values in columns.values()}) > 1:
        raise broken(path, "its arrays differ in length")
    return columns
