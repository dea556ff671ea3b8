"""A second set of texture coordinates in which no two places share one: for what is baked.

The charts are xatlas' (MIT; after Sander et al. 2002 and Levy et al. 2002); the extra ``bake``.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import MissingPackageError
from openrooms_usd.geometry.mesh import Mesh

if TYPE_CHECKING:
    from types import ModuleType


def triangulated(mesh: Mesh) -> Mesh:
    """The mesh in triangles: a polygon may be cut where it has no corner."""
    corners, _ = mesh.triangles()
    flat = corners.reshape(-1)
    return replace(
        mesh,
        counts=np.full(len(corners), 3, dtype=np.int32),
        indices=mesh.indices[flat],
        normals=None if mesh.normals is None else mesh.normals[flat],
        st=None if mesh.st is None else mesh.st[flat],
    )


def unwrapped(
    mesh: Mesh, *, resolution: int = 1024, padding: int = 2
) -> tuple[Mesh, NDArray[np.float32]]:
    """Lay out a mesh in the unit square without overlaps.

    The same mesh always gives the same layout. Triangles without an area get a place without one.

    Args:
        mesh: Convex polygons of any size.
        resolution: Pixels of the picture that will be baked, along its longer side.
        padding: Pixels that are kept free between charts.

    Returns:
        The mesh in triangles, and the (K, 2) coordinates in 0..1 of their corners.

    Raises:
        MissingPackageError: xatlas is not installed.
    """
    cut = triangulated(mesh)
    layout = np.zeros((len(cut.indices), 2), dtype=np.float32)
    laid = np.flatnonzero(cut.areas() > 0.0)
    if len(laid):
        rows = (3 * laid[:, None] + np.arange(3)).reshape(-1)
        layout[rows] = _charts(cut, rows, resolution, padding)
    return cut, layout


def _charts(mesh: Mesh, rows: NDArray[np.int64], size: int, padding: int) -> NDArray[np.float32]:
    """(K, 2) places of the chosen corners."""
    xatlas = _xatlas()
    points, indices = np.unique(mesh.points[mesh.indices[rows]], axis=0, return_inverse=True)
    # Tolerances of the package are absolute.
    low, high = points.min(axis=0), points.max(axis=0)
    small = ((points - low) / (high - low).max()).astype(np.float32)
    options = xatlas.PackOptions()
    options.resolution, options.padding = size, padding
    options.bilinear = True
    atlas = xatlas.Atlas()
    atlas.add_mesh(small, indices.reshape(-1, 3).astype(np.uint32))
    atlas.generate(xatlas.ChartOptions(), options)
    _, corners, places = atlas.get_mesh(0)
    layout: NDArray[np.float32] = np.asarray(places, dtype=np.float32)[corners.reshape(-1)]
    return layout


def _xatlas() -> "ModuleType":
    try:
        import xatlas
    except ImportError as error:
        raise MissingPackageError(
            f"unwrapping needs the package 'xatlas', which cannot be imported ({error})",
            remedy="pip install openrooms-usd[bake]",
        ) from error
    package: ModuleType = xatlas
    return package
