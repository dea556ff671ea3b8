"""Points as the arrays of an NPZ file."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.unpickling.arrays import read_arrays
from orusd_scans.scanned import Scanned, broken, cloud_of

# Arrays that are (N, 3), and what their columns are.
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


def read_npz(path: Path) -> Scanned:
    """Read the arrays ``points``, ``normals``, ``colors`` (N, 3), ``label`` and ``instance`` (N,).

    ``sensor_origins`` (V, 3), or ``eyes``, may say where the points were seen from.

    Raises:
        InputError: It is not an NPZ file, holds objects, or its arrays do not fit each other.
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
