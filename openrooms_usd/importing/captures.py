"""Reads a capture, copies what a room needs of it into a folder, and describes the room there."""

import filecmp
import os
import re
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any, Final

from openrooms_usd.adapters import IMPORTERS, load
from openrooms_usd.atomic import replacing, replacing_files, write_bytes, write_text
from openrooms_usd.capture import NO_OPTIONS, Capture, Importer, Packed, checked_options
from openrooms_usd.claims import locked
from openrooms_usd.description import Room, parse_room
from openrooms_usd.errors import InputError, OutputError, writing
from openrooms_usd.importing.text import describe, describe_scan, unlabelled
from openrooms_usd.portable import shell_line
from openrooms_usd.progress import Progress, nested, passed_to, silent
from openrooms_usd.untrusted import check_path, opened

ROOM: Final = "room.yaml"
# The shares of reading, and of reading and looking at points, in the time of an import.
_READ: Final = 0.5
_CHECKED: Final = 0.95
_UNLABELLED: Final = (
    "the scan has no labels: compose finds furniture by its shape, names the clear cases and "
    "puts boxes for the rest; give your own segmentation by `--segments FILE` or `furniture: "
    "{segmenter: NAME}`; `unlabelled: leave_out` there leaves furniture out"
)


@dataclass(frozen=True, eq=False)
class ImportedRoom:
    """A room that was described from a capture.

    Attributes:
        file: Its ``room.yaml``; what the room needs of the capture lies beside it.
        room: What stands in it.
        capture: What the importer read.
    """

    file: Path
    room: Room
    capture: Capture

    @property
    def notes(self) -> tuple[str, ...]:
        """What was dropped or guessed, one sentence each."""
        return self.capture.notes

    @property
    def counts(self) -> dict[str, int]:
        """How many walls, partitions, openings, objects, models, frames and points were read."""
        read = self.capture
        return {
            "walls": 0 if read.floor is None else len(read.floor),
            "partitions": len(read.partitions),
            "openings": len(read.openings),
            "objects": len(read.boxes) + len(read.models),
            "models": sum(model.file is not None for model in read.models),
            "frames": len(read.frames),
            "points": 0 if read.cloud is None else len(read.cloud),
        }

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for ``--json``."""
        height, notes = self.capture.height, list(self.notes)
        return {"room": str(self.file), **self.counts, "height": height, "notes": notes}

    def __repr__(self) -> str:
        counts = ((count, what) for what, count in self.counts.items() if count)
        known = ", ".join(f"{count} {what if count > 1 else what[:-1]}" for count, what in counts)
        notes = f"; {len(self.notes)} notes" if self.notes else ""
        return f"ImportedRoom({str(self.file)!r}: {known or 'nothing'}{notes})"


def import_capture(
    kind: str,
    source: Path,
    out: Path,
    options: Mapping[str, str] = NO_OPTIONS,
    progress: Progress = silent,
) -> ImportedRoom:
    """Describe a capture in a folder, as `openrooms_usd.api.rooms.import_capture` says."""
    importer: Importer = load(IMPORTERS, kind)
    check_path(source)
    try:
        asked = checked_options(kind, importer, options)
        capture = _read(kind, importer, source, asked, nested(progress, "", 0.0, _READ))
        progress("checking", _READ)
        if capture.floor is None and (refusal := check_scan(capture, source)):
            capture = replace(capture, notes=(*capture.notes, refusal))
        if unlabelled(capture):
            capture = replace(capture, notes=(*capture.notes, _UNLABELLED))
        packed = _packed(kind, importer, source, asked)
        _check_names(packed, out)
    except OSError as error:
        raise _unreadable(source, error) from error
    text = _described(kind, capture, packed.file, packed.options)
    room = parse_room(text, str(out / ROOM), folder=out)
    progress("copying", _CHECKED)
    with locked(out):
        with writing(out):
            _refuse_to_replace(out, {**packed.contents, ROOM: text.encode()})
        with replacing_files(out) as folder:
            for name, content in packed.contents.items():
                if not os.path.lexists(out / name):
                    _copy(content, folder / name)
            write_text(folder / ROOM, text)
    return ImportedRoom(out / ROOM, room, capture)


def described_capture(
    kind: str, file: str, folder: Path, options: Mapping[str, str] = NO_OPTIONS
) -> Room:
    """Describe the room of a capture where it lies; nothing is copied or written.

    Args:
        kind: The name of the importer.
        file: What it reads, relative to the folder.
        folder: Where names of files begin, also those of options.
        options: What is asked of the importer.

    Raises:
        InputError: The source cannot be read, or has no usable floor.
    """
    importer: Importer = load(IMPORTERS, kind)
    source = folder / file
    check_path(source)
    try:
        capture = _read(kind, importer, source, checked_options(kind, importer, options, folder))
    except OSError as error:
        raise _unreadable(source, error) from error
    return parse_room(_described(kind, capture, file, options), str(source), folder=folder)


def _read(
    kind: str,
    importer: Importer,
    source: Path,
    options: Mapping[str, str],
    progress: Progress = silent,
) -> Capture:
    """What a room can be made of."""
    check_archive(source)
    try:
        capture = importer.read(source, options, **passed_to(importer.read, progress))
    except InputError as error:
        hint_importer(kind, source, error)
        raise
    _check_usable(capture, source)
    return capture


def _described(kind: str, capture: Capture, file: str, options: Mapping[str, str]) -> str:
    """The text of the room, with what the importer found out by itself among its options."""
    text = describe if capture.floor is not None else describe_scan
    return text(kind, capture, file, {**options, **capture.settled})


def _check_usable(capture: Capture, source: Path) -> None:
    """Refuse what no room can be made of."""
    if capture.floor is None and capture.cloud is None:
        raise InputError(
            "the capture has no floor, and no walls that enclose one",
            place=source,
            remedy=capture.remedy,
        )


def _packed(kind: str, importer: Importer, source: Path, options: Mapping[str, str]) -> Packed:
    """What of a capture is copied: what its importer says, or else the file as it is."""
    pack = getattr(importer, "pack", None)
    if pack is not None:
        packed: Packed = pack(source, options)
    else:
        packed = Packed(source.name, {source.name: source}, options)
    if packed.file.isprintable() and packed.file.casefold() != ROOM:
        return packed
    name = f"{kind}{Path(packed.file).suffix}"
    # The file itself, or the folder that the files lie in.
    own = re.compile(re.escape(packed.file) + "(?=/|$)")
    contents = {own.sub(name, key, count=1): v for key, v in packed.contents.items()}
    return Packed(name, contents, packed.options)


def _check_names(packed: Packed, folder: Path) -> None:
    """Refuse files that would lie elsewhere, or where the description comes."""
    for name, content in packed.contents.items():
        path = PurePosixPath(name)
        is_inner = (folder / name).is_relative_to(folder) and ".." not in path.parts
        if not is_inner or str(path).casefold() == ROOM:
            raise InputError(
                f"a file of the capture cannot be copied as {name!r}",
                place=content if isinstance(content, Path) else None,
                remedy="give it another name",
            )


def _copy(content: bytes | Path, target: Path) -> None:
    if isinstance(content, bytes):
        write_bytes(target, content)
        return
    with opened(content, "frames") as source, replacing(target) as path, path.open("wb") as copy:
        shutil.copyfileobj(source, copy)


def _unreadable(path: Path, error: OSError) -> InputError:
    return InputError(
        f"cannot be read: {error.strerror or error}",
        place=path,
        remedy="check that it is a file and that you can read it",
    )


def _refuse_to_replace(out: Path, contents: Mapping[str, bytes | Path]) -> None:
    remedy = "choose another folder, or move the file away"
    for name, content in contents.items():
        if os.path.lexists(out / name) and not _equal(content, out / name):
            said = (
                "the folder already has a room" if name == ROOM else "another capture has that name"
            )
            raise OutputError(said, place=out / name, remedy=remedy)


def _equal(content: bytes | Path, target: Path) -> bool:
    if isinstance(content, bytes):
        return target.is_file() and target.read_bytes() == content
    return target.is_file() and filecmp.cmp(content, target, shallow=False)


# What import looks at beside reading: the right importer, and whether compose would refuse.

_ARCHIVES: Final = (".zip", ".tar", ".tgz", ".gz", ".bz2", ".xz", ".7z", ".rar")
# What reads files of these endings, whatever they were given to.
_READERS: Final = {
    **dict.fromkeys((".ply", ".pcd", ".obj", ".glb", ".stl", ".off"), "scan"),
    **dict.fromkeys((".las", ".laz", ".e57", ".xyz", ".pts", ".ptx"), "scan"),
    ".usdz": "roomplan",
    ".pkl": "sunrgbd",
    ".sens": "scannet",
    ".xml": "openrooms-xml",
}
# What folders hold that an importer reads whole.
_FOLDERS: Final = (
    ("*_vh_clean_2.ply", "scannet"),
    ("*.sens", "scannet"),
    ("*_3dod_mesh.ply", "arkitscenes"),
    ("Annotations", "s3dis"),
    ("full_annotations.json", "scan2cad"),
)
# Scans whose walls stand all round, this part of the azimuths, are not searched for rooms.
_ALL_ROUND: Final = 0.75


def check_archive(source: Path) -> None:
    """Refuse a packed folder.

    Raises:
        InputError: It is one.
    """
    if source.suffix.lower() in _ARCHIVES and source.is_file():
        raise InputError(
            "this is an archive", place=source, remedy="unpack it, and give its contents"
        )


def hint_importer(kind: str, source: Path, error: InputError) -> None:
    """Say in an importer's error which one reads files of that ending, or such a folder."""
    if not str(error.place or "").startswith(str(source)):
        return
    other = _folder_reader(kind, source) if source.is_dir() else _file_reader(kind, source)
    if other:
        error.remedy = f"{error.remedy}; or {other}" if error.remedy else f"use {other}"


def _file_reader(kind: str, source: Path) -> str:
    ending = source.suffix.lower()
    reader = _READERS.get(ending, kind)
    return "" if reader == kind else f"`orusd import {reader}`, which reads {ending} files"


def _folder_reader(kind: str, folder: Path) -> str:
    """What reads a folder that another importer refused, or a file in it; empty if nothing does."""
    for pattern, reader in _FOLDERS:
        if any(folder.glob(pattern)):
            return "" if reader == kind else f"`orusd import {reader}`, which reads such folders"
    known = sorted(path for path in folder.iterdir() if path.suffix.lower() in _READERS)
    if not known:
        return ""
    reader = _READERS[known[0].suffix.lower()]
    return f"what is in it: `{shell_line(('orusd', 'import', reader, str(known[0])))}`"


def check_scan(capture: Capture, source: Path) -> str:
    """Look whether compose would find a room in a scan.

    Args:
        capture: With points, without a floor.
        source: The file or folder, for messages.

    Returns:
        What compose would say of a scan that shows too little without `partial: true`; empty where
        it would say nothing.

    Raises:
        InputError: Compose would refuse it in any case; its own words.
    """
    # What finds rooms in points takes a second to import.
    from openrooms_usd.scan.reconstruction import standing
    from openrooms_usd.scan.rooms.layout import LayoutOptions, find_layout

    assert capture.cloud is not None
    options = LayoutOptions(partial=len(capture.frames) == 1)
    try:
        flat, stands, storey = standing(capture.cloud, options)
    except InputError as error:
        error.place = error.place or str(source)
        raise
    # The walls of other storeys count in the coverage.
    if storey is None and stands.coverage >= _ALL_ROUND:
        return ""
    try:
        find_layout(flat, stands, options)
    except InputError as error:
        return f"compose cannot use the scan as it is: {error.message}; remedy: {error.remedy}"
    return ""
