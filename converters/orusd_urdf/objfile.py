"""Wavefront OBJ and MTL: what Bullet, MuJoCo and ROS all read."""

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.geometry.vectors import unit


def collision_text(mesh: TriangleMesh) -> str:
    """A convex shape: points and triangles, nothing else."""
    used, rows = np.unique(mesh.triangles, return_inverse=True)
    lines = _lines("v", mesh.points[used], 9)
    lines += [f"f {a} {b} {c}" for a, b, c in (rows.reshape(-1, 3) + 1).tolist()]
    return "\n".join(lines) + "\n"


def visual_text(mesh: TriangleMesh, st: Floats | None, material: str, library: str) -> str:
    """A surface that shows one material.

    Args:
        mesh: Its triangles; where they have no normals, each is flat.
        st: (M, 3, 2) coordinates in the picture, the first row of which is at t = 1.
        material: The name of its material.
        library: The MTL file that has it, relative to this one.
    """
    used, rows = np.unique(mesh.triangles, return_inverse=True)
    normals, normal_rows = _distinct(_normals(mesh), 6)
    columns = [rows.reshape(-1, 3) + 1]
    lines = [f"mtllib {library}", *_lines("v", mesh.points[used], 7)]
    if st is not None:
        coordinates, st_rows = _distinct(st, 6)
        lines += _lines("vt", coordinates, 7)
        columns.append(st_rows + 1)
    lines += [*_lines("vn", normals, 6), f"usemtl {material}"]
    columns.append(normal_rows + 1)
    between = "/" if st is not None else "//"
    corners = np.stack(columns, axis=-1).tolist()
    lines += ["f " + " ".join(between.join(map(str, c)) for c in face) for face in corners]
    return "\n".join(lines) + "\n"


def material_text(
    name: str, color: tuple[float, float, float], opacity: float, picture: str | None
) -> str:
    """A material of an MTL file: a colour as screens show it, or a picture beside the file."""
    lines = [f"newmtl {name}", "Ka 0 0 0", *_lines("Kd", np.array([color]), 6), "Ks 0 0 0"]
    lines += [f"d {opacity:.6g}", "illum 1"]
    if picture is not None:
        lines.append(f"map_Kd {picture}")
    return "\n".join(lines) + "\n"


def _lines(word: str, rows: NDArray[np.floating], digits: int) -> list[str]:
    values = (np.asarray(rows, dtype=np.float64) + 0.0).tolist()
    return [word + "".join(f" {value:.{digits}g}" for value in row) for row in values]


def _normals(mesh: TriangleMesh) -> Floats:
    if mesh.normals is not None:
        return mesh.normals
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    normals = unit(np.cross(b - a, c - a))
    return np.repeat(normals[:, None], 3, axis=1).astype(np.float32)


def _distinct(values: Floats, digits: int) -> tuple[Floats, NDArray[np.intp]]:
    """The different rows of (M, 3, K) values, and (M, 3) which of them each corner has."""
    flat = np.round(values.reshape(-1, values.shape[-1]).astype(np.float64), digits) + 0.0
    rows, index = np.unique(flat, axis=0, return_inverse=True)
    return rows.astype(np.float32), index.reshape(-1, 3)
