"""HDF5 files with one data set, ``dataset``, as Hypersim has them."""

from pathlib import Path
from typing import Any, Final

from numpy.typing import NDArray

from openrooms_usd import atomic, hdf5
from openrooms_usd.errors import writing

DATASET: Final = "dataset"


def write_array(path: Path, values: NDArray[Any], *, packed: bool = True) -> None:
    """Write an array.

    Args:
        path: The file.
        values: The array, in the type that it shall have.
        packed: Whether to compress it.

    Raises:
        OutputError: It cannot be written.
    """
    import h5py

    how = {"compression": "gzip", "compression_opts": 4} if packed else {}
    with (
        atomic.replacing(path) as beside,
        writing(path),
        h5py.File(beside, "w", libver="v108") as file,
    ):
        # Without times the same numbers give the same bytes.
        file.create_dataset(DATASET, data=values, track_times=False, **how)


def read_array(path: Path) -> NDArray[Any]:
    """Read an array of numbers.

    Raises:
        InputError: It is missing, damaged, or holds no such data set.
        MissingPackageError: h5py is not installed.
    """
    return hdf5.read_array(path, DATASET, "hypersim", lambda shape, kind: kind in "fiu")
