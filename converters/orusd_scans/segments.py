"""People's own segmentation of a scan: a label and a thing for each point, in a file beside it."""

from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.segmentation.naming import with_labels
from openrooms_usd.unpickling.arrays import NUMBERS, TEXTS, read_array, read_arrays

_LABEL: Final = "label"
_INSTANCE: Final = "instance"
_LARGEST_NUMBER: Final = 1 << 24
_REMEDY: Final = (
    "save an .npz with the arrays label (NYU40 numbers or words) and instance (whole numbers), or "
    "one of them, each with one value for each point (of a mesh, each vertex), in the order of the "
    "scan's file"
)

Values = NDArray[Any]


def with_segments(cloud: Cloud, path: Path) -> Cloud:
    """A cloud with the labels and things that a file beside it says; its own are replaced.

    Args:
        cloud: The points of the scan's file, all of them and in its order; of a mesh its vertices.
        path: An ``.npz`` file with the arrays ``label`` and ``instance``, or an ``.npy`` file with
            one of them, or with both as its columns.

    Raises:
        InputError: It cannot be read, or does not fit the scan; names the place and the remedy.
    """
    label, instance = _read(path)
    for name, values in ((_LABEL, label), (_INSTANCE, instance)):
        if values is not None and values.shape != (len(cloud),):
            raise InputError(
                f"the array {name!r} has {_shape_in_words(values.shape)}, but the scan's file has "
                f"{len(cloud)} points or vertices",
                place=path,
                remedy=_REMEDY,
            )
    bare = replace(cloud, label=None, instance=None)
    if instance is not None:
        bare = replace(bare, instance=_whole(instance, _INSTANCE, path))
    if label is None:
        return bare
    if label.dtype.kind in TEXTS:
        return with_labels(bare, _words(label, path))
    return replace(bare, label=_whole(label, _LABEL, path))


def _read(path: Path) -> tuple[Values | None, Values | None]:
    """Labels and instances; at least one of them is there."""
    ending = path.suffix.lower()
    if ending == ".npz":
        found = read_arrays(path, (_LABEL, _INSTANCE), "points", NUMBERS + TEXTS)
        if not found:
            raise InputError("it has no array label or instance", place=path, remedy=_REMEDY)
        return found.get(_LABEL), found.get(_INSTANCE)
    if ending != ".npy":
        raise InputError(
            f"files that end in {ending!r} are not supported segments", place=path, remedy=_REMEDY
        )
    values = read_array(path, None, NUMBERS + TEXTS)
    if values.ndim == 2 and values.shape[1] == 2 and values.dtype.kind not in TEXTS:
        return values[:, 0], values[:, 1]
    return (values, None) if values.dtype.kind in TEXTS else (None, values)


def _shape_in_words(shape: tuple[int, ...]) -> str:
    return f"{shape[0]} values" if len(shape) == 1 else f"the shape {' x '.join(map(str, shape))}"


def _whole(values: Values, name: str, path: Path) -> NDArray[np.int32]:
    """Whole numbers; what is negative means that there is none."""
    if values.dtype.kind == "f" and not np.array_equal(values, np.round(values)):
        raise InputError(f"the array {name!r} has fractions", place=path, remedy=_REMEDY)
    if values.dtype.kind in TEXTS:
        raise InputError(f"the array {name!r} holds words", place=path, remedy=_REMEDY)
    if float(values.max(initial=0)) > _LARGEST_NUMBER:
        raise InputError(
            f"the array {name!r} has numbers beyond {_LARGEST_NUMBER:,}", place=path, remedy=_REMEDY
        )
    return np.where(values > 0, values, 0).astype(np.int32)


def _words(values: Values, path: Path) -> list[str]:
    """One word for each point."""
    try:
        return [word.decode() if isinstance(word, bytes) else str(word) for word in values.tolist()]
    except (UnicodeDecodeError, ValueError) as error:
        raise InputError("a label is not text", place=path, remedy=_REMEDY) from error
