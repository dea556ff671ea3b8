"""Points and polygons of the plan."""

import numpy as np


def inside(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(N,) which of (N, 2) points are within a polygon of (M, 2) corners."""
    x, y = points.T
    (x0, y0), (x1, y1) = corners.T, np.roll(corners, -1, axis=0).T
    with np.errstate(divide="ignore", invalid="ignore"):
        meets = x0 + (y[:, None] - y0) * (x1 - x0) / (y1 - y0)
    crossed = ((y0 > y[:, None]) != (y1 > y[:, None])) & (x[:, None] < meets)
    return crossed.sum(axis=1) % 2 == 1
