"""Views of an OpenRooms dataset for training, released or ours, in either layout.

A file that a variant has not of its own is that of ``main``, as the release has it. The channels of
a frame's files are in `FROM_FILES`; ``normal``, ``position`` and ``distance`` follow from the
camera.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, Final, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.geometry.pinhole import intrinsics
from openrooms_usd.loading.files import Files
from openrooms_usd.loading.sample import Sample
from openrooms_usd.loading.source import ViewSelection, refuse_nothing
from openrooms_usd.untrusted import read_text
from openrooms_usd.urls import MissingFileError
from orusd_openrooms import readers
from orusd_openrooms.layout import (
    FRAME,
    LAYOUTS,
    SHARED_INTRINSICS,
    SPLITS,
    SUBSETS,
    Layout,
    Place,
    suffix_of,
)
from orusd_openrooms.scenes.reading import read_scene

Array = NDArray[Any]
# Their world, Y up, to ours, Z up; and OpenCV's axes from OpenGL's.
_OURS_FROM_THEIRS: Final = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
_OPENGL: Final = np.array([1.0, -1.0, -1.0])
IMAGE: Final = "im"


"""The kind of file that every frame has."""


@dataclass(frozen=True, slots=True)
class OpenRoomsFrame:
    """A frame of a scene.

    Attributes:
        scene: Such as ``scene0000_00``.
        split: One of `SPLITS`.
        number: As its files are numbered.
        row: Of ``cam.txt``.
        layout: How the files lie.
        subset: ``train``, ``val``, ``test``, or empty.
    """

    scene: str
    split: str
    number: int
    row: int
    layout: Layout
    subset: str

    def files(self, name: str) -> tuple[str, ...]:
        """Where a kind of file may lie, below the root: the first that is there counts.

        What is not released with a variant is that of ``main``, unless it exists.
        """
        splits = [self.split]
        if self.split.partition("_")[0] not in FRAME[name].variants:
            splits.append(f"main_{suffix_of(self.split)}")
        paths = [self._place(split).frame(name, self.number) for split in splits]
        return tuple(path.as_posix() for path in paths if path)

    @property
    def cameras(self) -> str:
        """The folder of its cameras, below the root."""
        return self._place(self.split).scene_folder.as_posix()

    def _place(self, split: str) -> Place:
        return Place(Path(), self.scene, split, self.layout)


def listed(files: Files) -> Iterator[OpenRoomsFrame]:
    """All frames of a dataset; one is where its picture is.

    Raises:
        InputError: It cannot be listed.
    """
    subsets = {scene: subset for subset in SUBSETS for scene in _scenes(files, f"{subset}.txt")}
    for layout in LAYOUTS:
        for split in SPLITS:
            pictures = FRAME[IMAGE].folder
            top = f"{pictures}/{split}" if layout == "split" else split
            for scene in files.names(top):
                numbers = sorted(
                    int(words[1])
                    for name in files.names(f"{top}/{scene}")
                    if (words := Path(name).stem.split("_"))[0] == IMAGE
                    and name.endswith(FRAME[IMAGE].suffix)
                    and len(words) == 2
                    and words[1].isdecimal()
                )
                # Released frames count from 1, those that others rendered again from 0.
                first = 0 if 0 in numbers else 1
                for number in numbers:
                    subset = subsets.get(scene, "")
                    yield OpenRoomsFrame(scene, split, number, number - first, layout, subset)


def _scenes(files: Files, name: str) -> list[str]:
    if name not in files.names(""):
        return []
    with files.local({name: ""}) as root:
        return read_text(root / name, "table").split()


def _plane(read: Callable[[Path], Array]) -> Callable[[Path], Array]:
    return lambda path: read(path)[..., None]


class _ChannelInfo(NamedTuple):
    """Which file tells a channel, and how."""

    file: str
    read: Callable[[Path], Array]


def _share(of: Callable[[dict[str, Array]], Array]) -> _ChannelInfo:
    return _ChannelInfo(
        "immask", lambda path: of(readers.read_mask(path)).astype(np.float32)[..., None]
    )


FROM_FILES: Final[dict[str, _ChannelInfo]] = {
    "radiance": _ChannelInfo(IMAGE, readers.read_light),
    "base_color": _ChannelInfo("imbaseColor", readers.read_base_color),
    "roughness": _ChannelInfo("imroughness", _plane(readers.read_roughness)),
    "metallic": _ChannelInfo("immetallic", _plane(readers.read_roughness)),
    "normal_camera": _ChannelInfo("imnormal", readers.read_normal),
    "depth": _ChannelInfo("imdepth", _plane(readers.read_depth)),
    "friction": _ChannelInfo("imfriction", _plane(readers.read_depth)),
    "semantic": _ChannelInfo("imsemLabel", _plane(readers.read_labels)),
    "valid": _share(lambda mask: ~mask["sky"]),
    "emission_mask": _share(lambda mask: mask["lamp"]),
}


"""The channels that files tell: those of a view."""
GRIDS: Final = {"environment": "imenv", "environment_direct": "imenvDirect"}


"""The grids of hemispheres."""
_FOLLOWS: Final = {"normal": "normal_camera", "position": "depth", "distance": "depth"}


class OpenRoomsSource:
    """Frames of OpenRooms' files.

    Args:
        files: Where they lie.
        frames: Which.
        order: In which order the channels of environment maps are stored.
    """

    def __init__(self, files: Files, frames: Sequence[OpenRoomsFrame], order: str) -> None:
        self.files, self.frames, self.order = files, tuple(frames), order

    def __len__(self) -> int:
        return len(self.frames)

    def read(self, index: int, channels: Sequence[str]) -> Sample:
        """A frame; see `openrooms_usd.loading.source.Source`."""
        frame = self.frames[index]
        pose, K = self._camera(frame)
        needed = {_FOLLOWS.get(name, name) for name in channels}
        paths = {name: self._file(frame, _file_of(name)) for name in needed}
        size_of = paths.get("radiance") or self._file(frame, IMAGE)
        with self.files.local(dict.fromkeys({*paths.values(), size_of}, "")) as root:
            images = {
                name: FROM_FILES[name].read(root / path)
                for name, path in paths.items()
                if name in FROM_FILES
            }
            grids = {
                name: readers.read_environments(root / path, cast(Any, self.order))
                for name, path in paths.items()
                if name in GRIDS
            }
            first = next(iter(images.values()), None)
            shown = readers.read_light(root / size_of) if first is None else first
        height, width = shown.shape[:2]
        sample = Sample(
            name=f"{frame.scene}/{frame.split}/{frame.number}",
            size=(width, height),
            K=K,
            world_from_camera=pose,
            grids=grids,
            about={"room": frame.scene, "variant": frame.split, "split": frame.subset},
        )
        made = {
            name: _derive_channel(name, images, sample) for name in channels if name not in GRIDS
        }
        for name, pixels in made.items():
            if pixels.shape[:2] != (height, width):
                raise InputError(f"{name!r} is not of the picture's size", place=sample.name)
        return replace(sample, images=made)

    def _file(self, frame: OpenRoomsFrame, name: str) -> str:
        """Where a kind of file of a frame lies, or should."""
        own, *others = frame.files(name)
        is_shared = others and name not in _kinds(self.files, own.rpartition("/")[0])
        return others[0] if is_shared else own

    def _camera(self, frame: OpenRoomsFrame) -> tuple[Array, Array]:
        """The pose in our world, and K."""
        poses, K = _cameras(self.files, frame.cameras)
        if frame.row >= len(poses):
            place = f"{frame.cameras}/cam.txt"
            raise InputError(f"it has {len(poses)} cameras, and no {frame.row + 1}", place=place)
        return poses[frame.row], K


class OpenRoomsForm:
    """OpenRooms' files (docs/howto/openrooms.md)."""

    options: Mapping[str, str] = {"order": "of environment maps' channels: legacy, or rgb"}

    def open(self, files: Files, selection: ViewSelection, options: Mapping[str, str]) -> Any:
        """Its frames; ``variants`` are splits such as ``main_xml``, ``views`` their numbers.

        Raises:
            InputError: There are none.
        """
        order = options.get("order", "legacy")
        if order not in ("legacy", "rgb"):
            raise InputError(f"{order!r} is not an order of channels", remedy="give legacy or rgb")
        _kinds.cache_clear()
        _cameras.cache_clear()
        frames = [
            frame
            for frame in listed(files)
            if selection.admits(frame.subset, frame.split, frame.scene, str(frame.number))
        ]
        refuse_nothing(len(frames), files, selection)
        return OpenRoomsSource(files, frames, order)


@lru_cache(maxsize=4096)
def _kinds(files: Files, folder: str) -> frozenset[str]:
    """The kinds of files in a folder."""
    return frozenset(name.partition("_")[0] for name in files.names(folder))


@lru_cache(maxsize=4096)
def _cameras(files: Files, folder: str) -> tuple[list[Array], Array]:
    """The poses in our world, and K, of the cameras of a scene; kept until one opens anew."""
    path = f"{folder}/cam.txt"
    with files.local({path: ""}) as root:
        cameras = readers.read_cameras(root / path)
    return [_pose(*camera) for camera in cameras], _intrinsics(files, folder)


def _pose(origin: Array, target: Array, up: Array) -> Array:
    """(4, 4) from the OpenCV camera frame to our world."""
    ahead = (target - origin) / np.linalg.norm(target - origin)
    # Files have few decimals: up is made orthogonal again.
    up = up - (up @ ahead) * ahead
    down = -up / np.linalg.norm(up)
    pose = np.eye(4)
    pose[:3, :3] = _OURS_FROM_THEIRS @ np.stack([np.cross(down, ahead), down, ahead], axis=1)
    pose[:3, 3] = _OURS_FROM_THEIRS @ origin
    return pose


def _intrinsics(files: Files, folder: str) -> Array:
    """Of the scene's own matrix, its scene file, or the one matrix for all scenes."""
    for path in (f"{folder}/intrinsic.txt", f"{folder}/main.xml", SHARED_INTRINSICS.as_posix()):
        try:
            with files.local({path: ""}) as root:
                if not (root / path).is_file():
                    continue
                if not path.endswith(".xml"):
                    return readers.read_intrinsics(root / path)
                scene = read_scene(root / path)
        except MissingFileError:
            continue
        if scene.fov is not None:
            return intrinsics(scene.fov, *scene.resolution)
    raise InputError(
        "its field of view is unknown",
        place=f"{files}/{folder}",
        remedy="put the scene's main.xml or its intrinsic.txt there",
    )


def _file_of(channel: str) -> str:
    if channel in FROM_FILES:
        return FROM_FILES[channel].file
    if channel in GRIDS:
        return GRIDS[channel]
    known = ", ".join((*FROM_FILES, *_FOLLOWS, *GRIDS))
    raise InputError(f"OpenRooms' files do not have {channel!r}", remedy=f"they have {known}")


def _derive_channel(name: str, images: Mapping[str, Array], sample: Sample) -> Array:
    """A channel of files, or what follows from one."""
    if name in images:
        return images[name]
    source = images[_FOLLOWS[name]]
    turn, shift = sample.world_from_camera[:3, :3], sample.world_from_camera[:3, 3]
    if name == "normal":
        return np.asarray((source * _OPENGL) @ turn.T, np.float32)
    points = sample.rays * source
    if name == "distance":
        return np.asarray(np.linalg.norm(points, axis=-1, keepdims=True), np.float32)
    return np.where(source > 0.0, points @ turn.T + shift, 0.0).astype(np.float32)
