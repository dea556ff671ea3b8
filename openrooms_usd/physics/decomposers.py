"""CoACD and V-HACD: what others decompose meshes with, in metres and with equal bytes."""

from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import MissingPackageError
from openrooms_usd.physics.components import Component

Array = NDArray[np.float64]

# Voxels of V-HACD; more are closer and slower.
VOXELS: Final = 50_000
# Corners of a hull that V-HACD gives.
CORNERS: Final = 64


def coacd(component: Component, tolerance: float, most: int, seed: int) -> list[Array]:
    """Convex pieces by CoACD (Wei et al., 2022), by the corners of their hulls.

    CoACD gathers the pieces in the order in which its threads finish; they are sorted here.

    Args:
        component: What is decomposed; open ones are closed by CoACD's own remeshing.
        tolerance: Its concavity threshold, metres.
        most: The most pieces.
        seed: Of its search.

    Raises:
        MissingPackageError: coacd is not installed.
    """
    try:
        import coacd as package
    except ImportError as error:
        raise MissingPackageError(
            "convex decomposition by CoACD needs coacd", remedy='pip install "coacd>=1.0.14"'
        ) from error
    package.set_log_level("off")
    points, triangles = _indexed(component)
    found = package.run_coacd(
        package.Mesh(points, triangles.astype(np.int32)),
        threshold=tolerance,
        max_convex_hull=most,
        real_metric=True,
        seed=seed,
    )
    return _sorted([corners for corners, _ in found])


def vhacd(component: Component, tolerance: float, most: int, seed: int) -> list[Array]:
    """Convex pieces by V-HACD 4, by the corners of their hulls.

    Args:
        component: What is decomposed.
        tolerance: Unused: V-HACD knows volumes, not distances.
        most: The most pieces.
        seed: Unused: V-HACD draws nothing.

    Raises:
        MissingPackageError: vhacdx is not installed.
    """
    del tolerance, seed
    try:
        import vhacdx
    except ImportError as error:
        raise MissingPackageError(
            "convex decomposition by V-HACD needs vhacdx",
            remedy='pip install "vhacdx>=0.0.8"',
        ) from error
    points, triangles = _indexed(component)
    # Rows as VTK has them: the number of corners comes first.
    faces = np.column_stack([np.full(len(triangles), 3), triangles]).astype(np.uint32)
    found: Any = vhacdx.compute_vhacd(
        points,
        faces.reshape(-1),
        maxConvexHulls=most,
        resolution=VOXELS,
        maxNumVerticesPerCH=CORNERS,
        asyncACD=False,
    )
    return _sorted([np.asarray(corners, dtype=np.float64) for corners, _ in found])


DECOMPOSERS: Final[dict[str, Callable[[Component, float, int, int], list[Array]]]] = {
    "coacd": coacd,
    "vhacd": vhacd,
}


def _indexed(component: Component) -> tuple[Array, NDArray[np.int64]]:
    points, rows = np.unique(component.corners.reshape(-1, 3), axis=0, return_inverse=True)
    return points, rows.reshape(-1, 3).astype(np.int64)


def _sorted(pieces: Sequence[Array]) -> list[Array]:
    """Pieces with their corners in lexicographic order, by their least corners."""
    ordered = [piece[np.lexsort(piece.T[::-1])] for piece in pieces if len(piece)]
    return sorted(ordered, key=lambda piece: piece.reshape(-1).tolist())
