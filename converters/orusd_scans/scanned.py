"""What a reader of points or meshes hands over, and how it opens files that it cannot trust."""

import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array, Bytes, Floats, Ints
from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.spelling import listed
from orusd_scans.plan import Up
from orusd_scans.records import Node

Columns = Mapping[str, NDArray[Any]]

MOST_POINTS: Final = 200_000_000
LONGEST_HEADER: Final = 1 << 16  # bytes
_LONGEST_LINE: Final = 1 << 16
_LONGEST_MESSAGE: Final = 400  # letters
# Classes and numbers of objects.
_LARGEST_NUMBER: Final = 1 << 24
_NYU40: Final = 40
OTHER_CLASSES: Final = "NYU40 classes were expected (give --classes FILE for other classes)"
"""The end of a note about labels that NYU40 does not have."""

_PLACE: Final = (("x", "y", "z"),)
_NORMAL: Final = (("nx", "ny", "nz"), ("normal_x", "normal_y", "normal_z"))
_COLOR: Final = (
    ("red", "green", "blue"),
    ("r", "g", "b"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
)
# The scalar fields of CloudCompare carry a prefix.
_LABEL: Final = ("label", "labels", "semantic", "scalar_label", "scalar_labels")
_INSTANCE: Final = ("instance", "instance_id", "object_id", "objectid", "scalar_instance")
_CONFIDENCE: Final = ("confidence", "scalar_confidence")
# Points are opaque, whatever is said.
_OPAQUE: Final = ("alpha", "a")
# Columns that a note names.
_MOST_NAMED: Final = 6
_GREY: Final = 128.0


@dataclass(frozen=True, eq=False)
class Scanned:
    """Points in the frame and the unit of their file.

    Attributes:
        cloud: The points; its coordinates are not metres yet.
        faces: (F, 3) triangles of points; None where there is no surface.
        up: The vertical axis where the format fixes it.
        notes: What was left out, one sentence each.
        unit: Of the coordinates, where the file says it.
    """

    cloud: Cloud
    faces: Ints | None = None
    up: Up = "Z"
    notes: tuple[str, ...] = ()
    unit: str | None = None


@contextmanager
def opened(path: Path, kind: untrusted.Kind = "points") -> Iterator[BinaryIO]:
    """A file to read bytes from.

    Raises:
        InputError: It cannot be read, is not a regular file, is too large for its kind, or is
            empty.
    """
    with untrusted.opened(path, kind) as stream:
        if size_of(stream) == 0:
            raise broken(path, "the file is empty")
        yield stream


def size_of(stream: BinaryIO) -> int:
    """Bytes of the whole file that a stream reads."""
    return os.fstat(stream.fileno()).st_size


def lines_of(stream: BinaryIO) -> Iterator[bytes]:
    """The lines from here on; those that no point needs are cut, and so found to be none."""
    return iter(partial(stream.readline, _LONGEST_LINE), b"")


def broken(path: Path, message: str, remedy: str = "export the scan again") -> InputError:
    """An error about the contents of a file; what it quotes of them is cut."""
    short = message if len(message) <= _LONGEST_MESSAGE else f"{message[:_LONGEST_MESSAGE]}..."
    return InputError(short, place=path, remedy=remedy)


def counted(path: Path, text: str, what: str = "points") -> int:
    """A count in a header.

    Raises:
        InputError: It is not a number, or absurd.
    """
    if not text.isdecimal() or len(text) > 12 or int(text) > MOST_POINTS:
        raise broken(path, f"{text[:20]!r} is not a number of {what} (at most {MOST_POINTS:,})")
    return int(text)


def line_of_numbers(line: str, count: int, path: Path, index: int, largest: float = 1e6) -> Array:
    """(count,) the numbers of a line of text, none beyond the largest; its index counts from 0.

    Raises:
        InputError: There are others.
    """
    try:
        values = [float(word) for word in line.split()]
    except ValueError as error:
        raise broken(path, f"line {index + 1}: {error}") from error
    return Node(values, path, f"line {index + 1}").numbers(count, largest)


def one_in(options: Mapping[str, str], usual: int, place: Path, what: str) -> int:
    """One in how many pictures the option ``fuse`` asks for.

    Raises:
        InputError: It is not such a number.
    """
    text = options.get("fuse", str(usual))
    if not text.isdecimal() or not 0 < int(text) < 1_000_000:
        raise InputError(
            f"{text[:20]!r} is not a number of {what}", place=place, remedy="give --fuse 10"
        )
    return int(text)


def cloud_of(columns: Columns, path: Path, notes: list[str], others: Iterable[str] = ()) -> Cloud:
    """The cloud of named columns, each (N,).

    Args:
        columns: By names in lower case; notes name those that are not used.
        path: The file, for messages.
        notes: Receives sentences about what was left out.
        others: Names of columns that hold no single numbers.

    Raises:
        InputError: There are no points or coordinates, or a label is not a whole number.
    """
    places = _three(columns, _PLACE)
    if places is None:
        raise broken(path, "points have no coordinates: x, y and z are expected")
    if len(places[0]) == 0:
        raise broken(path, "it holds no points")
    normals, colors = _three(columns, _NORMAL), _three(columns, _COLOR)
    _tell_unused([*columns, *sorted(others)], notes)
    return Cloud(
        points=_double(np.column_stack(places)),
        normals=None if normals is None else _single(np.column_stack(normals)),
        colors=None if colors is None else _colors(np.column_stack(colors), notes),
        label=_numbers(columns, _LABEL, path, notes, _NYU40),
        instance=_numbers(columns, _INSTANCE, path, notes),
        confidence=_confidence(columns, notes),
    )


def sound_faces(faces: Ints, count: int, path: Path, notes: list[str]) -> Ints | None:
    """The triangles whose corners are there; None where there are none.

    Args:
        faces: (F, 3) numbers of points.
        count: How many points there are.
        path: The file, for messages.
        notes: Receives a sentence about what was left out.

    Raises:
        InputError: Half of them refer to others, or more.
    """
    sound = ((faces >= 0) & (faces < count)).all(axis=1)
    if lost := int(np.count_nonzero(~sound)):
        told = f"{lost:,} of {len(faces):,} triangles refer to a vertex that is not there"
        if 2 * lost >= len(faces):
            raise broken(path, told, "export the mesh again")
        notes.append(f"{told}, and are left out")
    return faces[sound] if sound.any() else None


def _three(columns: Columns, names: tuple[tuple[str, ...], ...]) -> list[NDArray[Any]] | None:
    found = next((trio for trio in names if all(name in columns for name in trio)), None)
    return None if found is None else [columns[name] for name in found]


def _double(values: NDArray[Any]) -> Array:
    with np.errstate(invalid="ignore"):  # NaN is dropped later
        return values.astype(np.float64, copy=False)


def _single(values: NDArray[Any]) -> Floats:
    # What becomes infinite is dropped with other broken normals.
    with np.errstate(over="ignore", invalid="ignore"):
        return values.astype(np.float32)


def _colors(values: NDArray[Any], notes: list[str]) -> Bytes:
    """Colours (N, 3) as bytes: fractions are scaled up, 16 bits down; grey if not valid."""
    if values.dtype == np.uint8:
        return values
    sound = np.isfinite(values).all(axis=1)
    if lost := int(np.count_nonzero(~sound)):
        notes.append(f"{lost:,} colours are not numbers: these points are grey")
    top = float(values[sound].max(initial=0.0))
    is_fraction = values.dtype.kind == "f" and top <= 1.0
    scale = 255.0 if is_fraction else 255.0 / 65535.0 if top > 255.0 else 1.0
    scaled = np.where(sound[:, None], values * scale, _GREY)
    return np.asarray(np.rint(scaled).clip(0, 255), dtype=np.uint8)


def _tell_unused(names: Iterable[str], notes: list[str]) -> None:
    given = list(names)
    known = {*_LABEL, *_INSTANCE, *_CONFIDENCE, *_OPAQUE}
    known.update(*(trio for trio in (*_PLACE, *_NORMAL, *_COLOR) if {*trio} <= {*given}))
    unused = [name[:40] for name in given if name not in known]
    if unused:
        notes.append(f"columns that are not used: {listed(unused, _MOST_NAMED)}")


def _numbers(
    columns: Columns, names: tuple[str, ...], path: Path, notes: list[str], usual: int | None = None
) -> NDArray[np.int32] | None:
    """Whole numbers of the points; what is negative, or no number, means that there is none."""
    name = next((name for name in names if name in columns), None)
    if name is None:
        return None
    given = columns[name]
    values = np.where(np.isfinite(given) & (given > 0), given, 0)
    if values.max(initial=0) > _LARGEST_NUMBER or (values % 1 != 0).any():
        raise broken(path, f"{name!r} must hold whole numbers below {_LARGEST_NUMBER:,}")
    if usual is not None and (beyond := int(np.count_nonzero(values > usual))):
        notes.append(f"{beyond} points have labels beyond {usual}: {OTHER_CLASSES}")
    return values.astype(np.int32)


def _confidence(columns: Columns, notes: list[str]) -> Floats | None:
    name = next((name for name in _CONFIDENCE if name in columns), None)
    if name is None:
        return None
    given = _single(columns[name])
    # NaN is trusted least; a damaged line has no position, either.
    values = np.where(np.isnan(given), np.float32(0.0), given)
    if not ((values >= 0.0) & (values <= 1.0)).all():
        notes.append("the confidence is not from 0 to 1: it is ignored")
        return None
    return values
