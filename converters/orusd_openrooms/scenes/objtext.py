"""Meshes as OBJ files, as OpenRooms' loaders read them: triangles, single blanks, ``usemtl``."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array

_DECIMALS: Final = 6


@dataclass(frozen=True, eq=False)
class Faces:
    """Triangles of one material.

    Attributes:
        material: What ``usemtl`` calls it.
        corners: (M, 3, 3) metres, counter-clockwise seen from the front.
        normals: (M, 3, 3) unit normal at each corner.
        st: (M, 3, 2) texture coordinates at each corner.
    """

    material: str
    corners: Array
    normals: Array
    st: Array


def obj_bytes(parts: Iterable[Faces]) -> bytes:
    """An OBJ file; corners of one part that share a point, a normal or coordinates share a line."""
    lines: list[str] = []
    offsets = np.zeros(3, dtype=np.int64)
    for part in parts:
        columns = []
        values = (("v", part.corners), ("vt", part.st), ("vn", part.normals))
        for number, (word, rows) in enumerate(values):
            rounded = np.round(rows.reshape(-1, rows.shape[-1]), _DECIMALS) + 0.0
            own, index = np.unique(rounded, axis=0, return_inverse=True)
            lines += [
                f"{word} {' '.join(f'{x:.{_DECIMALS}f}' for x in row)}" for row in own.tolist()
            ]
            columns.append(index.reshape(-1) + 1 + offsets[number])
            offsets[number] += len(own)
        lines.append(f"usemtl {part.material}")
        v, vt, vn = (column.reshape(-1, 3).tolist() for column in columns)
        for a, b, c in zip(v, vt, vn, strict=True):
            words = (f"{i}/{j}/{k}" for i, j, k in zip(a, b, c, strict=True))
            lines.append(f"f {' '.join(words)}")
    return ("\n".join(lines) + "\n").encode()
