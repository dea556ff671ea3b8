"""The photographs and the points of a capture, in the world of the room that was made of it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from openrooms_usd import names, untrusted
from openrooms_usd.capture import CapturedFrame, read_capture
from openrooms_usd.description import load_room
from openrooms_usd.errors import InputError
from openrooms_usd.steps.captures import captured_section

Array = NDArray[np.float64]

_DESCRIPTION = "room.yaml"


@dataclass(frozen=True, eq=False)
class Photographs:
    """What a capture shows of a room.

    Attributes:
        frames: Its cameras, in the room's world.
        points: (N, 3) what was scanned, in the room's world, metres; None where nothing was.
        folders: Where pictures are looked for, the first first.
        colors: (N, 3) uint8, sRGB, of the points; None where they have none.
    """

    frames: tuple[CapturedFrame, ...]
    points: Array | None
    folders: tuple[Path, ...]
    colors: NDArray[np.uint8] | None = None

    def file(self, frame: CapturedFrame) -> Path | None:
        """The picture of a frame; None where it is in none of the folders."""
        if frame.picture is None:
            return None
        # A name from a file may not lead out of the folders.
        inner = Path(frame.picture)
        leads_out = inner.is_absolute() or ".." in inner.parts
        inside = [Path(inner.name)] if leads_out else [inner, Path(inner.name)]
        found = (folder / name for folder in self.folders for name in inside)
        return next((path for path in found if untrusted.kind_of(path) == "a file"), None)


def read_photographs(
    stage: Usd.Stage, path: Path, description: Path | None, pictures: Path | None
) -> Photographs:
    """Read the capture that a room was made of, with the cameras of its photographs.

    Args:
        stage: The composed room.
        path: Its file.
        description: Its room.yaml; by default the one beside the folder of the stage.
        pictures: Where the photographs lie, if not where the capture does.

    Raises:
        InputError: A file is missing or damaged, the room comes from no capture, or the capture
            knows no cameras.
    """
    found = read_captured(stage, path, description, pictures)
    if not found.frames:
        raise InputError(
            "this capture has no cameras of photographs",
            place=description or _beside(path),
            remedy="import it with --frames, where its importer has that (`orusd import --help`)",
        )
    return found


def read_captured(
    stage: Usd.Stage, path: Path, description: Path | None = None, pictures: Path | None = None
) -> Photographs:
    """The same, also of a capture without photographs.

    Raises:
        InputError: A file is missing or damaged, or the room comes from no capture.
    """
    file = description or _beside(path)
    section = captured_section(load_room(file))
    if section is None:
        raise InputError(
            "this room does not come from a capture, so there is nothing to compare it with",
            place=file,
        )
    source = file.parent / section.file
    untrusted.check_path(source)
    capture = read_capture(section.reader, source, section.asked, file.parent)
    room_from_capture = _room_from_source(stage, path) @ capture.source_from_world
    frames = tuple(_frame_in_room(frame, room_from_capture) for frame in capture.frames)
    points = colors = None
    if capture.cloud is not None:
        points = capture.cloud.points @ room_from_capture[:3, :3].T + room_from_capture[:3, 3]
        colors = capture.cloud.colors
    own = source if source.is_dir() else source.parent
    folders = (pictures,) if pictures else (own, file.parent)
    return Photographs(frames, points, folders, colors)


def is_captured(path: Path) -> bool:
    """Whether the description beside a composed room says that it comes from a capture."""
    try:
        return captured_section(load_room(_beside(path))) is not None
    except InputError:
        return False


def chosen_frames(
    frames: Sequence[CapturedFrame], wanted: Sequence[str], count: int
) -> list[CapturedFrame]:
    """The frames that are asked for, or some that are evenly spread over all.

    Args:
        frames: All, in the order they were taken.
        wanted: Identifiers; none: ``count`` of all.
        count: How many at most.

    Raises:
        InputError: There is no such frame.
    """
    if not wanted:
        picked = np.unique(np.linspace(0, len(frames) - 1, min(count, len(frames))).round())
        return [frames[int(index)] for index in picked]
    known = {frame.id: frame for frame in frames}
    for name in wanted:
        if name not in known:
            some = ", ".join(list(known)[:5])
            raise InputError(f"the capture has no frame {name!r}", remedy=f"it has {some} ...")
    return [known[name] for name in wanted]


def _beside(path: Path) -> Path:
    for folder in (path.absolute().parent.parent, path.absolute().parent):
        if untrusted.kind_of(folder / _DESCRIPTION) == "a file":
            return folder / _DESCRIPTION
    raise InputError(
        "the description that this room was composed from is not beside its folder",
        place=path,
        remedy="name it by --description ROOM.yaml",
    )


def _room_from_source(stage: Usd.Stage, path: Path) -> Array:
    room = stage.GetPrimAtPath(names.ROOM)
    attribute = room.GetAttribute(names.SOURCE_FROM_WORLD) if room else None
    if not attribute or not attribute.HasValue():
        raise InputError(
            "this room does not record its place in the capture",
            place=f"{path}{names.ROOM}",
            remedy="compose it again from its capture",
        )
    return np.asarray(np.linalg.inv(np.array(attribute.Get()).T))


def _frame_in_room(frame: CapturedFrame, room_from_capture: Array) -> CapturedFrame:
    return replace(frame, world_from_camera=room_from_capture @ frame.world_from_camera)
