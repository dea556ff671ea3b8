"""A room of S3DIS becomes a Capture: one text file for each thing, whose name says what it is.

``<room>/Annotations/chair_1.txt`` has a line for each point: x, y, z in metres, Z up, and red,
green, blue (Armeni et al., "3D Semantic Parsing of Large-Scale Indoor Spaces", CVPR 2016).
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd import names, untrusted
from openrooms_usd.arrays import Bytes
from openrooms_usd.capture import NO_OPTIONS, Capture, Packed
from openrooms_usd.errors import InputError
from openrooms_usd.furniture.words import category_of
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.usd.semantics import class_of, number_of
from orusd_scans.formats.pointtext import read_text
from orusd_scans.frames import packed_folder
from orusd_scans.plainscan import UNDETERMINED, cloud_in
from orusd_scans.scanned import Scanned
from orusd_scans.worldframe import WorldFrame

_FOLDER: Final = "Annotations"
_MOST_THINGS: Final = 10_000
_LONGEST_NUMBER: Final = 1024  # bytes, with blanks before it


class S3disImporter:
    """Reads a room of Stanford's S3DIS, a folder."""

    options: Mapping[str, str] = {}

    def read(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Capture:
        """Read a room.

        Args:
            source: Its folder, which holds ``Annotations``.
            options: None are known.

        Raises:
            InputError: It is not such a folder, or a file holds nonsense; names the place.
        """
        notes = list[str]()
        files = _files(source, notes)
        read = [read_text(path) for path in files]
        notes += [
            f"{path.name}: {t}" for path, one in zip(files, read, strict=True) for t in one.notes
        ]
        counts = [len(one.cloud) for one in read]
        words = [re.sub(r"_\d+$", "", path.stem).replace("_", " ") for path in files]
        cloud = Cloud(
            points=np.concatenate([one.cloud.points for one in read]),
            colors=_colors(read),
            label=np.repeat(np.array([_class(word) for word in words], np.int32), counts),
            instance=np.repeat(np.arange(1, len(files) + 1, dtype=np.int32), counts),
            words={number: (word,) for number, word in enumerate(words, 1)},
        )
        frame = WorldFrame(np.eye(3), np.zeros(3))
        return Capture(
            source=source.name,
            source_from_world=frame.source_from_world(),
            cloud=cloud_in(frame, Scanned(cloud), source, notes),
            notes=tuple(notes),
            remedy=UNDETERMINED,
        )

    def pack(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Packed:
        """The annotated points; the room's own file has the same ones."""
        return packed_folder(source, _files(source, []), options)


def _files(source: Path, notes: list[str]) -> list[Path]:
    """The files of things with points; annotators leave empty ones."""
    untrusted.check_path(source)
    found = sorted((source / _FOLDER).glob("*.txt"))
    # Archives of other systems leave hidden files beside.
    found = [path for path in found if not path.name.startswith(".")]
    if len(found) <= _MOST_THINGS:
        full = [path for path in found if not _is_empty(path)]
        if empty := len(found) - len(full):
            notes.append(f"{empty} files of things are empty, and left out")
        found = full
    if not 0 < len(found) <= _MOST_THINGS:
        raise InputError(
            f"not a room of S3DIS: {len(found)} files {_FOLDER}/*.txt with points are here",
            place=source,
            remedy=f"give the folder of one room, such as Area_1/office_1, with {_FOLDER} in it",
        )
    return found


def _is_empty(path: Path) -> bool:
    """Whether a file holds nothing but blanks."""
    with untrusted.opened(path, "points") as stream:
        return not stream.read(_LONGEST_NUMBER).strip()


def _colors(read: list[Scanned]) -> Bytes | None:
    colors = [one.cloud.colors for one in read if one.cloud.colors is not None]
    return np.concatenate(colors) if len(colors) == len(read) else None


def _class(word: str) -> int:
    """The class of NYU40; 0 for clutter and whatever else that list does not tell."""
    return number_of(class_of(category_of(word, 0.0) or word, names.NYU40), names.NYU40)
