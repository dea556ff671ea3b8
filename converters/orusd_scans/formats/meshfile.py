"""Meshes (OBJ, GLB, STL, OFF) through trimesh, as points with triangles."""

from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd.scan.models.meshscene import ShownMesh, shown_meshes
from openrooms_usd.scan.points.cloud import Cloud
from orusd_scans.plan import Up
from orusd_scans.scanned import Scanned, broken, opened

# glTF fixes its vertical axis; the others do not.
_Y_UP: Final = (".glb",)


def read_mesh(path: Path) -> Scanned:
    """Read all meshes of a file in its common frame.

    Raises:
        InputError: It cannot be read, or has no triangles.
        MissingPackageError: It is compressed with Draco, which is not installed.
    """
    with opened(path, "model") as stream:
        content = stream.read()
    meshes = shown_meshes(path, content)
    if not meshes:
        raise broken(path, "it has no triangles")
    starts = np.cumsum([0, *(len(one.vertices) for one in meshes)])
    faces = [one.faces + start for one, start in zip(meshes, starts, strict=False)]
    cloud = Cloud(points=np.concatenate([one.vertices for one in meshes]), colors=_colors(meshes))
    up: Up = "Y" if path.suffix.lower() in _Y_UP else "Z"
    return Scanned(cloud, np.concatenate(faces).astype(np.int64), up)


def _colors(meshes: list[ShownMesh]) -> Any:
    """Colours of the points, where all meshes have them."""
    visuals = [one.mesh.visual for one in meshes]
    if not all(visual.kind == "vertex" for visual in visuals):
        return None
    colors = [np.asarray(visual.vertex_colors)[:, :3] for visual in visuals]
    sound = all(len(c) == len(m.vertices) for c, m in zip(colors, meshes, strict=True))
    return np.concatenate(colors).astype("u1") if sound else None
