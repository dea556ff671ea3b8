"""The neutral form of a captured room, which importers fill and stages read.

Everything is in metres, Z up, right-handed; every part is optional, because every capture lacks
something. ``source_from_world`` is the way back to the frame of the original file.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Literal, Protocol

import numpy as np

from openrooms_usd import adapters
from openrooms_usd.arrays import Array
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.untrusted import check_path

Confidence = Literal["low", "medium", "high"]

NO_OPTIONS: Final[Mapping[str, str]] = MappingProxyType({})
"""What an importer is given when nothing is asked of it."""


@dataclass(frozen=True)
class CapturedOpening:
    """A rectangle cut into a wall.

    Attributes:
        id: The identifier in the source.
        kind: ``window``, ``door`` (with a leaf) or ``opening`` (without).
        center: (3,) centre of the rectangle, metres.
        direction: (3,) unit vector along its width, horizontal.
        width: Metres.
        height: Metres.
        is_open: Whether a door's leaf stands open; None when unknown.
        confidence: How sure the source is.
        wall: The identifier of its wall in the source; None when unknown.
    """

    id: str
    kind: Literal["window", "door", "opening"]
    center: Array
    direction: Array
    width: float
    height: float
    is_open: bool | None = None
    confidence: Confidence | None = None
    wall: str | None = None


@dataclass(frozen=True, eq=False)
class CapturedPartition:
    """A wall inside the room, with the room on both of its sides.

    Attributes:
        id: The identifier in the source.
        ends: (2, 2) of its middle line in the plan, metres.
        thickness: Metres; None when unknown.
        height: Metres; None for one that reaches the ceiling.
        confidence: How sure the source is.
    """

    id: str
    ends: Array
    thickness: float | None = None
    height: float | None = None
    confidence: Confidence | None = None


@dataclass(frozen=True)
class CapturedBox:
    """An object known by its oriented box.

    Attributes:
        id: The identifier in the source.
        label: The source's own category name.
        center: (3,) metres.
        rotation: (3, 3) box axes as columns: width (right), depth (back), height (up), seen from
            the object's front, its own -Y side.
        size: (3,) full width, depth and height, metres.
        confidence: How sure the source is.
        attributes: Whatever else the source knows, as plain strings.
    """

    id: str
    label: str
    center: Array
    rotation: Array
    size: Array
    confidence: Confidence | None = None
    attributes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class CapturedModel:
    """A CAD model that was aligned to the capture with nine degrees of freedom.

    Attributes:
        id: The identifier in the source.
        label: Its category's name in words: one of the library's where there is one.
        file: The CAD's mesh file; None when it is not there, and then only its box is known.
        world_from_model: (4, 4) takes points of the CAD's own frame to the world, metres: a
            translation, a rotation and a positive scale along each axis of the CAD.
        half: (3,) half extents of the CAD's bounding box, in its own frame.
        center: (3,) the middle of that box, in its own frame.
        symmetry: How it looks when it is turned about its own vertical: ``2`` and ``4`` times
            the same in a whole turn, or always (``inf``).
        up: The CAD's vertical axis.
        front: Where its front looks once that axis is turned to Z.
        shifts: (3,) each, metres in the world: how it was moved afterwards, one after the other, so
            that it stands where it can.
        radiance: Nits of each primary that its bulbs emit, scene-linear; None if unknown.
        looks: What its parts are made of where its file does not say it: looks of the description
            by part.
    """

    id: str
    label: str
    file: Path | None
    world_from_model: Array
    half: Array
    center: Array
    symmetry: Literal["none", "2", "4", "inf"] = "none"
    up: Literal["Y", "Z"] = "Y"
    front: Literal["+X", "-X", "+Y", "-Y"] = "+Y"
    shifts: tuple[Array, ...] = ()
    radiance: tuple[float, float, float] | None = None
    looks: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def stands(self) -> Array:
        """(4, 4) the same after all shifts."""
        moved = self.world_from_model.copy()
        moved[:3, 3] += sum(self.shifts, np.zeros(3))
        return moved


@dataclass(frozen=True)
class CapturedFrame:
    """A photograph of the capture: where its camera stood.

    Attributes:
        id: Its identifier in the source, such as the frame's number.
        world_from_camera: (4, 4) rigid, from the OpenCV frame (x right, y down, z forward) to the
            world, metres.
        K: (3, 3) intrinsics in pixels; the centre of the top-left pixel is (0.5, 0.5).
        resolution: Width and height of the picture, pixels.
        picture: The picture's file name in the source; None where it has none.
        distortion: Of the lens, by OpenCV's model: k1 k2 p1 p2, then k3, then k4 k5 k6; of a
            fisheye k1 k2 k3 k4. Empty for a pinhole.
        fisheye: Whether the lens is OpenCV's fisheye: angles, not tangents, grow with the radius.
        depth: The file name of a map of planar depth that shows the same as the picture, whole
            numbers of 16 bits; 0 and 65535 hold no depth. None where there is none.
        depth_unit: Metres for a count of that map.
    """

    id: str
    world_from_camera: Array
    K: Array
    resolution: tuple[int, int]
    picture: str | None = None
    distortion: tuple[float, ...] = ()
    fisheye: bool = False
    depth: str | None = None
    depth_unit: float = 0.001


@dataclass(frozen=True)
class Capture:
    """What an importer read.

    Attributes:
        source: The name of the file that was read, without its folder.
        source_from_world: (4, 4) takes world points (metres, Z up) to the source's own frame.
        floor: (N, 2) corners of the floor polygon, counter-clockwise seen from above, metres;
            None when the source has none.
        height: Floor to ceiling, at its highest, metres; None when the source does not know.
        roof: (M, 3) the line where the walls meet a ceiling that is not level, in order around the
            floor: above every corner of it, and where a top bends; metres.
        openings: Windows, doors and openings.
        partitions: Walls that are not on the floor's outline but inside it.
        boxes: Objects known by their boxes.
        models: CAD models that were aligned to the capture.
        frames: The photographs whose cameras are known, in the order they were taken.
        fov: Horizontal field of view of pictures whose cameras are not known, degrees.
        cloud: The scanned points.
        environment: The world outside, as in the description; None if unknown.
        shell: Looks of the description for ``floor``, ``walls`` and ``ceiling``.
        notes: What was dropped or guessed, one sentence each.
        use: What the room is for, in the source's word; None where it does not say.
        remedy: What to do where the floor is missing.
        settled: Options that say what the importer found out by itself, so that it can be changed.
    """

    source: str
    source_from_world: Array
    floor: Array | None = None
    height: float | None = None
    roof: Array | None = None
    openings: tuple[CapturedOpening, ...] = ()
    partitions: tuple[CapturedPartition, ...] = ()
    boxes: tuple[CapturedBox, ...] = ()
    models: tuple[CapturedModel, ...] = ()
    frames: tuple[CapturedFrame, ...] = ()
    fov: float | None = None
    cloud: Cloud | None = None
    environment: Mapping[str, Any] | None = None
    shell: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    use: str | None = None
    remedy: str = "scan the room again, so that its walls close"
    settled: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Packed:
    """The part of a capture that one room needs, as files that can lie beside its description.

    Attributes:
        file: The captured file's name among them.
        contents: Every file by its path in that folder, with forward slashes: its bytes, or where
            they stand.
        options: What to ask of the importer when it reads them; paths are relative to the folder.
    """

    file: str
    contents: Mapping[str, bytes | Path]
    options: Mapping[str, str] = field(default_factory=dict)


class Importer(Protocol):
    """Reads foreign files; registered as an entry point ``openrooms_usd.importers``.

    The first line of its class's docstring says in ``orusd import --help`` what it reads.

    It may also have ``paths``, the set of those options that name files or folders: they reach it
    as paths that can be opened from anywhere. And it may have a method ``pack`` with the arguments
    of ``read`` that returns a `Packed`, where a room needs more, or less, than the one file. Its
    ``read`` may take a `openrooms_usd.progress.Progress` as ``progress``, too.
    """

    options: Mapping[str, str]
    """What may be asked of it beside the file: names, and a sentence of help for each."""

    def read(self, source: Path, options: Mapping[str, str] = NO_OPTIONS) -> Capture:
        """Read a foreign file or folder.

        Args:
            source: The file or folder.
            options: Values by the names that `options` declares.

        Raises:
            InputError: It is missing, unreadable or not of this kind.
        """
        ...


def read_capture(
    kind: str, source: Path, options: Mapping[str, str] = NO_OPTIONS, base: Path | None = None
) -> Capture:
    """Read a capture by the importer of that name.

    Args:
        kind: The importer's name.
        source: The file or folder.
        options: What is asked of it.
        base: The folder in which options that name files begin; by default the current one.

    Raises:
        InputError: There is no such importer or option, or the source is not of its kind.
        MissingPackageError: The importer needs a package that is not installed.
    """
    importer: Importer = adapters.load(adapters.IMPORTERS, kind)
    check_path(source)
    return importer.read(source, checked_options(kind, importer, options, base))


def checked_options(
    kind: str, importer: Importer, options: Mapping[str, str], base: Path | None = None
) -> dict[str, str]:
    """The options that an importer knows, with paths that can be opened from anywhere.

    Raises:
        InputError: It knows no such option.
    """
    adapters.check_options(adapters.IMPORTERS, kind, importer.options, options)
    paths = option_paths(importer)
    folder = base or Path()
    for name in paths & options.keys():
        check_path(folder / options[name])
    return {name: str(folder / v) if name in paths else v for name, v in options.items()}


def option_paths(importer: Importer) -> frozenset[str]:
    """Those options of an importer that name files or folders."""
    return frozenset(getattr(importer, "paths", ()))
