"""Collision shapes that were computed before: in the user's cache, beside the textures.

An entry is one file, named by all that determines the shapes, code and libraries too. It appears
whole; one that cannot be read is as none.
"""

import hashlib
import io
import json
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import atomic, unfinished
from openrooms_usd.codedigest import code_digest, library_versions
from openrooms_usd.errors import OutputError
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.components import Part
from openrooms_usd.physics.decomposition import ConvexShape, Method, Shapes, collision_shapes
from openrooms_usd.usercache import cache_folder

_FOLDER: Final = "shapes"


def cached_shapes(parts: Sequence[Part], method: Method, tolerance: float) -> Shapes:
    """`collision_shapes`, made only where they must be; the same with and without a cache.

    Args:
        parts: Surfaces in one frame, metres.
        method: How.
        tolerance: How far they may be off, metres.

    Raises:
        InputError: A coordinate is not finite, or nothing has an area.
    """
    entry = _entry(parts, method, tolerance)
    if entry is None:
        return collision_shapes(parts, method, tolerance)
    found = _read_entry(entry, parts)
    if found is None:
        found = collision_shapes(parts, method, tolerance)
        with suppress(OSError, OutputError):
            entry.parent.mkdir(parents=True, exist_ok=True)
            unfinished.sweep(entry.parent)
            atomic.write_bytes(entry, _bytes(found, parts))
    return found


def is_missing(parts: Sequence[Part], method: Method, tolerance: float) -> bool:
    """Whether there is a cache, and the shapes are not in it."""
    entry = _entry(parts, method, tolerance)
    return entry is not None and not entry.is_file()


def _entry(parts: Sequence[Part], method: Method, tolerance: float) -> Path | None:
    folder = cache_folder(_FOLDER)
    return folder / f"{_digest(parts, method, tolerance)}.npz" if folder else None


def _digest(parts: Sequence[Part], method: Method, tolerance: float) -> str:
    # What other code or other libraries have made is never taken.
    makers = code_digest(__name__)
    libraries = library_versions(__name__)
    found = hashlib.sha256(json.dumps([makers, libraries, method, tolerance]).encode())
    contacts = list(dict.fromkeys(part.contact for part in parts))
    for part in parts:
        # Which parts share a material matters, and not what it is called.
        told = [contacts.index(part.contact), part.points.shape, part.triangles.shape]
        found.update(json.dumps(told).encode())
        found.update(np.ascontiguousarray(part.points, np.float64).tobytes())
        found.update(np.ascontiguousarray(part.triangles, np.int32).tobytes())
    return found.hexdigest()


def _bytes(shapes: Shapes, parts: Sequence[Part]) -> bytes:
    """All shapes end to end, and how much of each array is of each shape: few arrays load fast."""
    number = {part.name: i for i, part in enumerate(parts)}
    columns: dict[str, list[np.ndarray]] = {
        "points": [shape.mesh.points for shape in shapes.shapes],
        "triangles": [shape.mesh.triangles for shape in shapes.shapes],
        "parts": [
            np.array([number[name] for name in shape.parts], np.int32) for shape in shapes.shapes
        ],
    }
    arrays = {name: np.concatenate(column) for name, column in columns.items()}
    arrays["counts"] = np.array([[len(each) for each in column] for column in columns.values()])
    arrays["boxes"] = np.array([shape.box for shape in shapes.shapes])
    arrays["errors"] = np.array([shapes.protrusion, shapes.uncovered])
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)  # type: ignore[arg-type]
    return buffer.getvalue()


def _read_entry(entry: Path, parts: Sequence[Part]) -> Shapes | None:
    try:
        with np.load(io.BytesIO(entry.read_bytes()), allow_pickle=False) as stored:
            arrays = dict(stored)
        columns = [
            np.split(arrays[name], np.cumsum(counts)[:-1])
            for name, counts in zip(("points", "triangles", "parts"), arrays["counts"], strict=True)
        ]
        rows = zip(*columns, arrays["boxes"].tolist(), strict=True)
        shapes = [_shape(parts, *row) for row in rows]
        protrusion, uncovered = arrays["errors"].tolist()
    except (OSError, ValueError, KeyError, IndexError, EOFError):
        return None
    return Shapes(tuple(shapes), protrusion, uncovered)


def _shape(
    parts: Sequence[Part], points: np.ndarray, triangles: np.ndarray, rows: np.ndarray, box: bool
) -> ConvexShape:
    mesh = TriangleMesh(points, triangles, np.arange(len(triangles), dtype=np.int32))
    used = [parts[row] for row in rows.tolist()]
    return ConvexShape(mesh, used[0].contact, tuple(part.name for part in used), box)
