"""PTX files of laser scanners: stations one after the other, each with its own frame.

A station has the numbers of its columns and rows, the position and axes of the scanner, and a
matrix for row vectors that takes its points to the common frame. Then it has a line for each
direction: x, y, z, an intensity and perhaps a colour, zeros where nothing came back.
"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from orusd_scans.formats.rows import read_rows
from orusd_scans.scanned import Scanned, broken, cloud_of, counted

_NAMES: Final = ("x", "y", "z", "intensity", "red", "green", "blue")
# Numbers in the lines of a station's head, without the two counts before them.
_HEAD: Final = (3, 3, 3, 3, 4, 4, 4, 4)


def is_ptx(lines: list[str]) -> bool:
    """Whether a text begins as a station does."""
    counts, head = lines[:2], lines[2 : 2 + len(_HEAD)]
    return all(line.strip().isdecimal() for line in counts) and (
        tuple(len(line.split()) for line in head) == _HEAD
    )


def read_stations(lines: Iterator[str], path: Path) -> Scanned:
    """Read all stations.

    Args:
        lines: Of the whole file.
        path: The file, for messages.

    Raises:
        InputError: A station is cut, or half of its lines are damaged.
    """
    stations, origins, notes, number = list[Array](), list[Array](), list[str](), 1
    while head := list(islice(lines, 2 + len(_HEAD))):
        if not is_ptx(head):
            if not "".join(head).strip():
                break
            raise broken(path, f"no station of a PTX file begins at line {number}")
        wide, high = (counted(path, line.strip(), "directions") for line in head[:2])
        count = counted(path, str(wide * high))
        matrix = read_rows(head[-4:], 4, path, first=number + 6).values
        if not np.isfinite(matrix).all():
            raise broken(path, f"the matrix from line {number + 6} on is not of numbers")
        number += len(head)
        first = next(lines, "")
        width = min(len(first.split()), len(_NAMES))
        if width not in (4, len(_NAMES)):
            raise broken(path, f"line {number} is not a point: {first.strip()[:60]!r}")
        station = [first, *islice(lines, count - 1)]
        if len(station) < count:
            raise broken(path, f"it ends too early: {count:,} points of a station are announced")
        rows = read_rows(station, width, path, first=number)
        number, notes = number + count, [*notes, *rows.told]
        values = rows.values[~rows.lost & rows.values[:, :3].any(axis=1)]
        values[:, :3] = values[:, :3] @ matrix[:3, :3] + matrix[3, :3]
        stations.append(values)
        origins.append(matrix[3, :3])
    table = np.full((sum(map(len, stations)), max(one.shape[1] for one in stations)), np.nan)
    for end, found in zip(np.cumsum([len(one) for one in stations]), stations, strict=True):
        # Points of stations without colours are grey, where others have some.
        table[end - len(found) : end, : found.shape[1]] = found
    cloud = cloud_of(dict(zip(_NAMES, table.T, strict=False)), path, notes)
    return Scanned(replace(cloud, sensor_origins=np.array(origins)), notes=tuple(notes))
