"""What folders of photographs share: names of pictures, their sizes, intrinsics and poses."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath
from typing import Final

import numpy as np

from openrooms_usd import untrusted
from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError
from orusd_scans.formats.depthpicture import picture_size
from orusd_scans.frames import intrinsics
from orusd_scans.records import Node, read_json
from orusd_scans.worldframe import rigid

PICTURES: Final = (".jpg", ".jpeg", ".png")
_INTRINSICS: Final = (
    "camera-intrinsics.txt",
    "camera_intrinsics.txt",
    "intrinsics.txt",
    "calibration.txt",
    "intrinsic.json",
    "camera_intrinsic.json",
)
_MAX_PIXELS: Final = 1e6
_LONGEST_NAME: Final = 1024


def name_inside(folder: Path, given: str, node: Node) -> str:
    """The name of a file as it is in a folder, never one outside.

    Absolute names and names with ``..`` are of another machine: their end counts that is there.

    Args:
        folder: Where the file should be.
        given: The name in the source; an ending may be missing.
        node: Where it stands, for messages.

    Raises:
        InputError: It cannot be the name of a file.
    """
    text = given.replace("\\", "/")
    parts = [part for part in PurePosixPath(text).parts if part not in ("/", ".", "..")]
    if not parts or len(given) > _LONGEST_NAME or not given.isprintable():
        raise node.error("this is not the name of a picture", "write its path in the folder")
    names = ["/".join(parts[first:]) for first in range(len(parts))]
    candidates = [f"{name}{ending}" for name in names for ending in ("", *PICTURES)]
    return next((name for name in candidates if is_inside(folder, name)), names[0])


def is_inside(folder: Path, name: str) -> bool:
    """Whether a folder has a file of this name, which does not lead out of it."""
    try:
        return untrusted.inside(folder, name).is_file()
    except (InputError, OSError):
        return False


def identifiers(names: Sequence[str]) -> list[str]:
    """Names of pictures without folder and ending, as far as these tell them apart."""
    stems = [PurePosixPath(name).stem for name in names]
    return stems if len(set(stems)) == len(stems) else list(names)


def files_of(folder: Path, endings: Iterable[str] = PICTURES) -> list[Path]:
    """The files of a folder with these endings, by the numbers in their names."""
    wanted = tuple(endings)
    found = folder.glob("*") if folder.is_dir() else ()
    return sorted(
        (f for f in found if f.suffix.lower() in wanted and f.is_file()),
        key=lambda f: by_number(f.name),
    )


def by_number(name: str) -> list[tuple[int, str]]:
    """A key that sorts the name ``2.png`` before ``10.png``."""
    words = re.split(r"([0-9]+)", name)
    return [(int(w), "") if w.isdecimal() and len(w) < 40 else (-1, w) for w in words]


def size_of_first(folder: Path, names: Iterable[str | None]) -> tuple[int, int]:
    """Width and height of the first picture that is there.

    Raises:
        InputError: None is, or it cannot be read.
    """
    for name in names:
        if name is not None and is_inside(folder, name):
            return picture_size(folder / name)
    raise InputError(
        "the size of the pictures is not known: none of them is here",
        place=folder,
        remedy="put the pictures into this folder, as their names say",
    )


def numbers_of(path: Path, kind: untrusted.Kind = "text") -> list[float]:
    """All numbers of a text; lines that begin with # are comments.

    Raises:
        InputError: It holds something else.
    """
    lines = untrusted.read_text(path, kind).splitlines()
    words = [word for line in lines if not line.lstrip().startswith("#") for word in line.split()]
    try:
        return [float(word) for word in words]
    except ValueError as error:
        raise InputError(
            f"numbers are expected: {str(error)[:100]}", place=path, remedy="export it again"
        ) from error


def pose_of(path: Path) -> Node:
    """The 16 numbers of a pose in a text file, as they stand there.

    Raises:
        InputError: There are others.
    """
    numbers = numbers_of(path)
    if len(numbers) != 16:
        raise InputError(
            f"a pose of 4 x 4 numbers is expected, found {len(numbers)} numbers",
            place=path,
            remedy="export the pose again",
        )
    return Node(numbers, path)


def tracked(node: Node) -> Array | None:
    """(4, 4) a pose; None where tracking was lost, which numbers without end say.

    Raises:
        InputError: It is not rigid.
    """
    return rigid(node) if np.isfinite(np.array(node.value)).all() else None


def left_out(lost: int, total: int) -> list[str]:
    """A note about photographs without a pose."""
    return [f"{lost} of {total} photographs have no pose: they were left out"] if lost else []


def intrinsics_near(folder: Path) -> Array | None:
    """(3, 3) of a file of intrinsics in a folder or above it; None where there is none.

    Raises:
        InputError: It holds others than 3 x 3, 4 x 4, or fx fy cx cy.
    """
    files = [f / name for f in (folder, folder.parent) for name in _INTRINSICS]
    path = next((file for file in files if file.is_file()), None)
    if path is None:
        return None
    if path.suffix == ".json":
        # Open3D writes it by columns.
        columns = read_json(path).need("intrinsic_matrix").numbers(9, _MAX_PIXELS)
        return intrinsics(Node(columns.reshape(3, 3).T.tolist(), path, "intrinsic_matrix"))
    numbers = numbers_of(path)
    if len(numbers) == 4:
        fx, fy, cx, cy = numbers
        return pinhole(fx, fy, cx, cy, Node(None, path))
    if len(numbers) == 16:
        numbers = np.array(numbers).reshape(4, 4)[:3, :3].ravel().tolist()
    return intrinsics(Node(numbers, path))


def pinhole(fx: float, fy: float, cx: float, cy: float, node: Node) -> Array:
    """(3, 3) intrinsics of four numbers, pixels.

    Raises:
        InputError: They are absurd.
    """
    rows = [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]
    return intrinsics(Node(rows, node.file, node.path))
