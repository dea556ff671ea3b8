"""The same scan without its labels, lying on its side, or in millimetres: another PLY file."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from benchmarks.real.captures import Change

# Z up to Y up: x stays, what was up is y.
ON_ITS_SIDE: Final = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
_COLORS: Final = ("red", "green", "blue")


def variant(source: Path, change: Change, target: Path) -> None:
    """Write the points (and triangles) of a scan anew, without what says what they are.

    Args:
        source: Any scan that `orusd import scan` reads.
        change: What is done to it, beside.
        target: A PLY file.
    """
    from orusd_scans.plainscan import read_scanned

    scanned = read_scanned(source)
    cloud = scanned.cloud
    points = cloud.points * (1000.0 if change == "millimetres" else 1.0)
    turn = ON_ITS_SIDE if change == "on its side" else np.eye(3)
    places = points @ turn.T
    columns: dict[str, NDArray[Any]] = {name: places[:, k] for k, name in enumerate("xyz")}
    if cloud.normals is not None:
        normals = cloud.normals @ turn.T
        columns |= {f"n{name}": normals[:, k] for k, name in enumerate("xyz")}
    if cloud.colors is not None:
        columns |= {name: cloud.colors[:, k] for k, name in enumerate(_COLORS)}
    write_ply(target, columns, scanned.faces)


def write_ply(
    target: Path, columns: Mapping[str, NDArray[Any]], faces: NDArray[np.int64] | None = None
) -> None:
    """A binary PLY file: bytes stay bytes, all else becomes float (places: double)."""
    kinds = {
        name: "u1" if values.dtype == np.uint8 else "<f8" if name in "xyz" else "<f4"
        for name, values in columns.items()
    }
    count = len(next(iter(columns.values())))
    rows = np.zeros(count, dtype=list(kinds.items()))
    for name, values in columns.items():
        rows[name] = values
    words = {"u1": "uchar", "<f4": "float", "<f8": "double"}
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {count}"]
    lines += [f"property {words[kind]} {name}" for name, kind in kinds.items()]
    body = rows.tobytes()
    if faces is not None:
        lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
        polygons = np.zeros(len(faces), dtype=[("n", "u1"), ("rows", "<i4", 3)])
        polygons["n"], polygons["rows"] = 3, faces
        body += polygons.tobytes()
    target.write_bytes("\n".join([*lines, "end_header", ""]).encode() + body)
