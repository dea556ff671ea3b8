"""Labels of doors, windows and what hangs before them, counted over the cells of a wall."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.openings.cellcounts import counted
from openrooms_usd.scan.openings.wallfaces import WallFace
from openrooms_usd.scan.points.cloud import Cloud

Array = NDArray[np.float64]
Rows = NDArray[np.int64]

# NYU40.
DOOR, WINDOW, BLINDS, CURTAIN = 8, 9, 13, 16
OPENING_LABELS: Final = (DOOR, WINDOW, BLINDS, CURTAIN)

# Returns labelled door that are farther before the wall than this, and than so many of its standard
# deviations more (drift doubles walls), are of a leaf that was opened against it, which is no door
# in this wall.
_LEAF_ASIDE_M: Final = 0.12
_DRIFT_SIGMAS: Final = 2.0
# Labels count of returns with normals within 25 degrees of the wall's.
_LABEL_FACING_COS: Final = float(np.cos(np.radians(25.0)))


def label_counts(
    cloud: Cloud, out: Array, near: float, deviation: float, cells: Rows, face: WallFace,
    shape: tuple[int, int],
) -> tuple[dict[int, Array], Array]:  # fmt: skip
    """The labels of openings over the cells of a wall.

    Only returns with the wall's normal count, and those of the sides of holes in it; of a leaf
    that was opened against the wall none does.

    Args:
        cloud: N returns near the wall.
        out: (N,) their distances behind its face, metres.
        near: Least distance of what is behind it, metres.
        deviation: Root mean squared residual of the wall's plane, metres.
        cells: (N,) their cells.
        face: The wall.
        shape: Rows and columns of its grid.

    Returns:
        (Z, X) counts for each label of openings, and for all labels.
    """
    if cloud.label is None:
        return {}, np.zeros(shape)
    own = (cloud.label != DOOR) | (out > -_LEAF_ASIDE_M - _DRIFT_SIGMAS * deviation)
    if cloud.normals is not None:
        facing = np.abs(cloud.normals[:, :2] @ face.outward) > _LABEL_FACING_COS
        own &= (out >= near) | facing
    cells, label = cells[own], cloud.label[own]
    counts = {number: counted(cells[label == number], shape) for number in OPENING_LABELS}
    return counts, counted(cells[label > 0], shape)
