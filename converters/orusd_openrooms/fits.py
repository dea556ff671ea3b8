"""Spherical Gaussians of every hemisphere, as HDF5."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic
from openrooms_usd.errors import MissingPackageError, writing


def write_fit(path: Path, lobes: NDArray[np.float32]) -> None:
    """Write the data set ``data``, compressed by lzf.

    Args:
        path: The file.
        lobes: (rows, columns, lobes, 6): theta, phi, sharpness, red, green, blue; the light in the
            direction d is the sum of color exp(sharpness (axis . d - 1)).

    Raises:
        MissingPackageError: h5py is not installed.
        OutputError: The file cannot be written.
    """
    h5py = load_h5py()
    with (
        atomic.replacing(path) as beside,
        writing(path),
        h5py.File(beside, "w", libver="v108") as file,
    ):
        # Without times the same lobes give the same bytes.
        file.create_dataset(
            "data", data=np.ascontiguousarray(lobes, "<f4"), compression="lzf", track_times=False
        )


def load_h5py() -> Any:
    """The package h5py.

    Raises:
        MissingPackageError: It is not installed.
    """
    try:
        import h5py
    except ImportError as error:
        raise MissingPackageError(
            "spherical Gaussians are stored as HDF5, which needs the package 'h5py'",
            remedy="pip install 'openrooms-usd[openrooms]'",
        ) from error
    return h5py
