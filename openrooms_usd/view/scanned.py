"""The points of a scan for pages: beside the room that was made of them, or alone."""

from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Bytes, Floats
from openrooms_usd.capture import read_capture
from openrooms_usd.errors import InputError
from openrooms_usd.rendering.color import quantize, ramp
from openrooms_usd.view.app import App

POINTS: Final = "scan.points"
# More are thinned by a step, which keeps how dense they are.
_MOST_POINTS: Final = 500_000
# Percentiles of the points that a page shows at first, without outliers.
_SHOWN_PERCENTILES: Final = (1.0, 99.0)


def packed(points: Array, colors: Bytes | None) -> bytes:
    """Points for a page: the count as uint32, (N, 3) float32 metres, (N, 3) uint8 sRGB.

    Args:
        points: (N, 3) in the page's frame, metres.
        colors: (N, 3) uint8; None: by their height.
    """
    step = max(1, -(-len(points) // _MOST_POINTS))
    kept = np.ascontiguousarray(points[::step], "<f4")
    painted = _by_height(kept) if colors is None else colors[::step]
    return np.uint32(len(kept)).tobytes() + kept.tobytes() + np.ascontiguousarray(painted).tobytes()


def _by_height(points: Floats) -> Bytes:
    low, high = np.percentile(points[:, 2], _SHOWN_PERCENTILES)
    return quantize(ramp(np.clip((points[:, 2] - low) / max(high - low, 1e-6), 0.0, 1.0)))


def scan_app(path: Path, *, importer: str = "scan") -> App:
    """The page of a scan, as its importer reads it.

    Args:
        path: The file or folder.
        importer: The importer's name.

    Raises:
        InputError: There is no such importer, or it is not a scan.
    """
    cloud = read_capture(importer, path).cloud
    if cloud is None or not len(cloud):
        raise InputError(
            "this capture has no points",
            place=path,
            remedy="import it, compose it and look at the stage",
        )
    state: dict[str, Any] = {
        **{name: [] for name in ("prims", "shell", "joints", "looks", "cameras", "plan")},
        "light": None,
        "shots": {},
        "hemispheres": [],
        "scan": POINTS,
        "glb": False,
        "box": np.percentile(cloud.points, _SHOWN_PERCENTILES, axis=0).tolist(),
    }
    make = cache(lambda: packed(cloud.points, cloud.colors))
    return App("room", path.resolve().name, lambda: state, {POINTS: make})
