"""Meshes of unknown origin through trimesh: one door, whose meshes have sound shapes and indices.

trimesh raises whatever a broken file leads it to, and says on standard error what it passes over.
Here both become one sentence about the file.
"""

import io
import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError, OrusdError
from openrooms_usd.scan.models.glb import glb_header

# Without a handler, Python prints a library's warnings with their tracebacks.
logging.getLogger("trimesh").addHandler(logging.NullHandler())

_MOST_TRIANGLES: Final = 20_000_000
_REMEDY: Final = "open it with a mesh viewer and export it again"


@dataclass(frozen=True, eq=False)
class ShownMesh:
    """A mesh at one place of a scene.

    Attributes:
        name: What the file calls it.
        mesh: The `trimesh.Trimesh`; its faces refer to its vertices.
        file_from_mesh: (4, 4) where it is.
    """

    name: str
    mesh: Any
    file_from_mesh: NDArray[np.float64]

    @property
    def vertices(self) -> NDArray[np.float64]:
        """(N, 3) in the file's frame."""
        turn, shift = self.file_from_mesh[:3, :3], self.file_from_mesh[:3, 3]
        with np.errstate(all="ignore"):
            return np.asarray(self.mesh.vertices, dtype=np.float64) @ turn.T + shift

    @property
    def faces(self) -> NDArray[np.int32]:
        """(F, 3) rows of the vertices."""
        return np.asarray(self.mesh.faces, dtype=np.int32)


def shown_meshes(path: Path, content: bytes) -> list[ShownMesh]:
    """The meshes with triangles that a file shows, by the ending of its name.

    Args:
        path: An OBJ, PLY, GLB, STL or OFF file; no other file is read with it.
        content: Its bytes.

    Raises:
        InputError: It cannot be read, is too large, or a mesh in it is not sound.
        MissingPackageError: It is compressed and the decoder is not installed.
    """
    import trimesh

    kind = path.suffix.lower().removeprefix(".")
    if kind == "glb":
        glb_header(content, path)
    try:
        with np.errstate(all="ignore"):  # of this thread; what is not finite is found later
            scene = trimesh.load_scene(io.BytesIO(content), file_type=kind, process=False)
            found = [ShownMesh(n, m, _pose(p)) for n, m, p in _shown(scene)]
    except OrusdError:
        raise
    except Exception as error:
        reason = " ".join(str(error).split())[:200] or type(error).__name__
        text = f"not a readable {kind.upper()} file: {reason}"
        raise InputError(text, place=path, remedy=_REMEDY) from error
    _check_meshes(found, path)
    return found


def _shown(scene: Any) -> Any:
    for node in sorted(scene.graph.nodes_geometry):
        pose, name = scene.graph[node]
        mesh = scene.geometry[name]
        if len(getattr(mesh, "faces", ())):
            yield str(name), mesh, pose


def _pose(given: Any) -> NDArray[np.float64]:
    pose = np.asarray(given, dtype=np.float64)
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise ValueError("the place of a mesh is no transform")
    return pose


def _check_meshes(found: list[ShownMesh], path: Path) -> None:
    if sum(len(one.mesh.faces) for one in found) > _MOST_TRIANGLES:
        text = f"it shows more than {_MOST_TRIANGLES:,} triangles"
        raise InputError(text, place=path, remedy="export fewer, or scans as PLY")
    for one in found:
        points, faces = np.asarray(one.mesh.vertices), np.asarray(one.mesh.faces)
        if points.ndim != 2 or points.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
            raise InputError("a mesh is not of triangles", place=path, remedy=_REMEDY)
        if not 0 <= faces.min() <= faces.max() < len(points):
            text = "a triangle refers to a corner that is not there"
            raise InputError(text, place=path, remedy=_REMEDY)
