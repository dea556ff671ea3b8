"""OBJ files as scans: all vertices in the file's order, their colours, and faces as triangles.

Groups, materials, normals and texture coordinates say nothing of a room, and are passed over.
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.scan.models.objtext import KNOWN, standard_obj
from orusd_scans.formats.rows import read_rows
from orusd_scans.scanned import MOST_POINTS, Scanned, broken, cloud_of

_NAMES: Final = ("x", "y", "z", "red", "green", "blue")
_ENTRIES_AFTER: Final = re.compile(r"/\S*")


def read_obj(path: Path) -> Scanned:
    """Read the vertices of an OBJ file, and its polygons as fans of triangles.

    Raises:
        InputError: It holds no vertices, faces name others, or half of its lines are damaged.
    """
    text, said = standard_obj(untrusted.read_text(path, "model"), path)
    vertices, faces, before, unknown = list[str](), list[str](), list[int](), list[str]()
    count = 0
    for number, line in enumerate(re.sub(r"\\[ \t\r]*\n", " ", text).split("\n"), 1):
        word, *rest = line.split(None, 1)[:2] or ["#"]
        is_vertex = word == "v"
        count += is_vertex
        # Other lines stay empty, so that damaged ones have their number in the file.
        vertices.append(rest[0] if is_vertex and rest else "none" if is_vertex else "")
        if word == "f":
            faces.append(rest[0] if rest else "")
            before.append(count)
        elif word not in KNOWN and not word.startswith("#"):
            unknown.append(f"line {number}, {word[:40]!r}")
    if not count:
        raise broken(path, "it has no vertices")
    colored = all(len(line.split()) >= len(_NAMES) for line in vertices if line)
    width = len(_NAMES) if colored else 3
    rows = read_rows(vertices, width, path, more=True)
    notes = [*said, *rows.told]
    if unknown:
        notes.append(f"{len(unknown):,} lines are none of OBJ: the first is {unknown[0]}")
    cloud = cloud_of(dict(zip(_NAMES, rows.values.T, strict=False)), path, notes)
    found = _triangles(faces, np.array(before), path, notes)
    if len(found) and not 0 <= found.min() <= found.max() < count:
        raise broken(path, "a face refers to a vertex that is not there", "export the mesh again")
    return Scanned(cloud, found if len(found) else None, notes=tuple(notes))


def _triangles(
    faces: Sequence[str], before: NDArray[np.int64], path: Path, notes: list[str]
) -> NDArray[np.int64]:
    """(F, 3) fans of the faces; negative numbers count back from the vertices before them."""
    corners = [_ENTRIES_AFTER.sub("", face).split() for face in faces]
    sizes = np.array([len(face) for face in corners], dtype=np.int64)
    fans, lost = [np.empty((0, 3), np.int64)], 0
    for size in np.unique(sizes[sizes > 2]).tolist():
        some = np.flatnonzero(sizes == size)
        rows = read_rows([" ".join(corners[i]) for i in some.tolist()], size, path)
        whole = np.abs(rows.values) <= MOST_POINTS
        given = np.where(whole, rows.values, 0.0).astype(np.int64)
        sound = ((given == rows.values) & (given != 0)).all(axis=1)
        lost += int((~sound).sum())
        given, known = given[sound], before[some][sound, None]
        index = np.where(given > 0, given - 1, known + given)
        fans += [index[:, [0, i, i + 1]] for i in range(1, size - 1)]
    if lost:
        notes.append(f"{lost:,} of {len(faces):,} faces are damaged, and left out")
    return np.concatenate(fans)
