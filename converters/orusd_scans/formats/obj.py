"""OBJ files as scans: all vertices in the file's order, their colours, and faces as triangles.

Groups, materials, normals and texture coordinates say nothing of a room, and are passed over.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.arrays import Ints
from openrooms_usd.scan.models.objtext import KNOWN, standard_obj
from orusd_scans.formats.rows import read_rows
from orusd_scans.scanned import MOST_POINTS, Scanned, broken, cloud_of, sound_faces
from orusd_scans.surfaces import fans

_NAMES: Final = ("x", "y", "z", "red", "green", "blue")


def read_obj(path: Path) -> Scanned:
    """Read the vertices of an OBJ file, and its polygons as fans of triangles.

    Raises:
        InputError: It holds no vertices, or half of its vertices or faces are damaged.
    """
    text, said = standard_obj(untrusted.read_text(path, "model"), path)
    vertices, faces, before, unknown = list[str](), list[str](), list[int](), list[str]()
    count = 0
    for number, line in enumerate(text.split("\n"), 1):
        word, *rest = line.split(None, 1)[:2] or [""]
        is_vertex = word == "v"
        count += is_vertex
        # Other lines stay empty, so that damaged ones have their number in the file.
        vertices.append(rest[0] if is_vertex and rest else "none" if is_vertex else "")
        if word == "f":
            faces.append(rest[0] if rest else "")
            before.append(count)
        elif word and word not in KNOWN:
            unknown.append(f"line {number}, {word[:40]!r}")
    if not count:
        raise broken(path, "it has no vertices")
    widths = [len(line.split()) for line in vertices]
    colored = 2 * sum(width >= len(_NAMES) for width in widths) > count
    if colored:  # the others are grey
        pairs = zip(vertices, widths, strict=True)
        vertices = [f"{line} nan nan nan" if width == 3 else line for line, width in pairs]
    rows = read_rows(vertices, len(_NAMES) if colored else 3, path, more=True)
    notes = [*said, *rows.told]
    if unknown:
        notes.append(f"{len(unknown):,} lines are not OBJ: the first is {unknown[0]}")
    cloud = cloud_of(dict(zip(_NAMES, rows.values.T, strict=False)), path, notes)
    found = _triangles(faces, np.array(before), path, notes)
    return Scanned(cloud, sound_faces(found, count, path, notes), notes=tuple(notes))


def _triangles(faces: Sequence[str], before: Ints, path: Path, notes: list[str]) -> Ints:
    """(F, 3) fans of the faces; negative numbers count back from the vertices before them."""
    corners = [_corners(face) for face in faces]
    sizes = np.array([len(face) for face in corners], dtype=np.int64)
    found, lost = [np.empty((0, 3), np.int64)], int((sizes == 0).sum())
    for size in np.unique(sizes[sizes > 2]).tolist():
        some = np.flatnonzero(sizes == size)
        numbers = np.array([corners[i] for i in some.tolist()])
        given = np.where(np.abs(numbers) <= MOST_POINTS, numbers, 0.0).astype(np.int64)
        sound = ((given == numbers) & (given != 0)).all(axis=1)
        lost += int((~sound).sum())
        given, known = given[sound], before[some][sound, None]
        found.append(fans(np.where(given > 0, given - 1, known + given)))
    told = f"{lost:,} of {len(faces):,} faces are damaged"
    if lost and 2 * lost >= len(faces):
        raise broken(path, told, "export the mesh again")
    notes += [f"{told}, and left out"] if lost else []
    return np.concatenate(found)


def _corners(face: str) -> list[float]:
    """The numbers of a face's vertices; none if one is not a number."""
    try:
        # Underscores are numbers to Python alone.
        return [] if "_" in face else [float(word.partition("/")[0]) for word in face.split()]
    except ValueError:
        return []
