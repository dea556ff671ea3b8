"""Fits of environment maps, in files beside them."""

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic
from openrooms_usd.arrays import Floats
from openrooms_usd.errors import writing
from openrooms_usd.geometry import spherical_gaussians, spherical_harmonics
from openrooms_usd.geometry.hemisphere import HEMISPHERE, irradiance
from openrooms_usd.rendering import exr

ORDER: Final = 2
"""The degree of harmonics that are written unless told otherwise."""

_MOST_HALF: Final = 65504.0


def write_fits(
    folder: Path, grid: Floats, order: int = ORDER, *, compact: bool = False
) -> dict[str, Any]:
    """Fit the environment maps of a view and write the fits.

    Args:
        folder: Receives ``environment_shading.exr``, (rows, columns) pixels of the irradiance that
            the cells make, lux; ``environment_sg.npy``, (rows, columns, 12, 6) of
            `spherical_gaussians.fit`, and ``environment_sh.npy``, (rows, columns, (order + 1)^2, 3)
            of `spherical_harmonics.project`; both in the frames of the hemispheres.
        grid: (rows, columns, 16, 32, 3) hemispheres.
        order: The highest degree of the harmonics, 2 to 4.
        compact: Whether to write the Gaussians alone, of which the fit takes long; the rest is
            quickly made of the hemispheres again.

    Returns:
        For the manifest: the files, and the median over lit points of the error that the Gaussians
        leave.

    Raises:
        OutputError: A file cannot be written.
    """
    lobes = spherical_gaussians.fit(grid)
    found = {"environment_sg": lobes}
    files = {}
    if not compact:
        shading = folder / "environment_shading.exr"
        exr.write_rgb(shading, irradiance(grid).astype(np.float32))
        files["environment_shading"] = shading.name
        found["environment_sh"] = harmonics(grid, order)
    for name, values in found.items():
        path = folder / f"{name}.npy"
        values = _halved(values) if compact else values
        with writing(path), atomic.replacing(path) as beside:
            np.save(beside, values, allow_pickle=False)
    lit = grid.any(axis=(2, 3, 4))
    error = spherical_gaussians.error(grid[lit], lobes[lit])
    return {
        "files": files | {name: f"{name}.npy" for name in found},
        "environment_sg": {
            "lobes": spherical_gaussians.LOBES,
            "median_error": float(np.median(error)) if error.size else None,
        },
        "environment_sh": {"order": order},
    }


def _halved(values: Floats) -> NDArray[Any]:
    """In half precision, unless some number is too large for that."""
    return values.astype(np.float16) if np.abs(values).max(initial=0.0) < _MOST_HALF else values


def harmonics(grid: Floats, order: int = ORDER) -> Floats:
    """(rows, columns, (order + 1)^2, 3) spherical harmonics of hemispheres, in their frames."""
    return spherical_harmonics.project(grid, HEMISPHERE, order).astype(np.float32)
