"""Views of scenes in Hypersim's layout for training, of Apple's own or ours.

A frame's files hold arrays; its camera is in the scene's ``_detail``, its lens in the table beside
the scenes. Lengths come out in metres, light in the unit of the scene.
"""

import csv
import io
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.channels import CHANNELS
from openrooms_usd.errors import InputError
from openrooms_usd.loading.files import Files
from openrooms_usd.loading.sample import Sample
from openrooms_usd.loading.source import ViewSelection, refuse_nothing
from openrooms_usd.untrusted import read_text
from orusd_hypersim.cameras import OPENGL
from orusd_hypersim.frames import FINAL, GEOMETRY
from orusd_hypersim.hdf5 import read_array
from orusd_hypersim.tables import CAMERAS_FILE, SPLIT_FILE

# The last row of the matrix of pinholes; other lenses differ.
_PINHOLE: Final = (0.0, 0.0, -1.0)
Array = NDArray[Any]
_FRAME: Final = re.compile(r"frame\.(\d{4})\.color\.hdf5")
_PICTURES: Final = re.compile(rf"scene_(\w+)_{FINAL}_hdf5")


class _ChannelInfo(NamedTuple):
    """Which pictures of a frame tell a channel, and how."""

    folder: str
    pictures: tuple[str, ...]
    make: Callable[..., Array]


def _finite(pixels: Array) -> Array:
    """Without surface 0, as channels have it."""
    return np.nan_to_num(pixels.astype(np.float32), posinf=0.0, neginf=0.0)


def _labels(numbers: Array) -> Array:
    return np.maximum(numbers.astype(np.int64), 0)[..., None]


def _product(reflectance: Array, illumination: Array) -> Array:
    return _finite(reflectance.astype(np.float32) * illumination.astype(np.float32))


FROM_FILES: Final[dict[str, _ChannelInfo]] = {
    "radiance": _ChannelInfo(FINAL, ("color",), _finite),
    "diffuse": _ChannelInfo(FINAL, ("diffuse_reflectance", "diffuse_illumination"), _product),
    "irradiance": _ChannelInfo(
        FINAL, ("diffuse_illumination",), lambda light: np.pi * _finite(light)
    ),
    "residual": _ChannelInfo(FINAL, ("residual",), _finite),
    "normal": _ChannelInfo(GEOMETRY, ("normal_bump_world",), _finite),
    "normal_camera": _ChannelInfo(GEOMETRY, ("normal_bump_cam",), _finite),
    "normal_geometric": _ChannelInfo(GEOMETRY, ("normal_world",), _finite),
    "semantic_nyu40": _ChannelInfo(GEOMETRY, ("semantic",), _labels),
    "instance": _ChannelInfo(GEOMETRY, ("semantic_instance",), _labels),
    "distance": _ChannelInfo(GEOMETRY, ("depth_meters",), lambda depth: _finite(depth)[..., None]),
}


"""The channels that pictures tell."""
_FOLLOWS: Final = ("depth", "position", "valid")


@dataclass(frozen=True, slots=True)
class HypersimFrame:
    """A frame of a scene.

    Attributes:
        scene: Such as ``ai_001_010``.
        camera: Such as ``cam_00``.
        number: As its files are numbered.
        split: ``train``, ``val``, ``test``, or empty.
    """

    scene: str
    camera: str
    number: int
    split: str

    def file(self, folder: str, picture: str) -> str:
        """The path of a picture, below the root."""
        images = f"scenes/{self.scene}/images/scene_{self.camera}_{folder}_hdf5"
        return f"{images}/frame.{self.number:04d}.{picture}.hdf5"


class HypersimSource:
    """Frames of scenes in Hypersim's layout.

    Args:
        files: Where they lie.
        frames: Which.
    """

    def __init__(self, files: Files, frames: Sequence[HypersimFrame]) -> None:
        self.files, self.frames = files, tuple(frames)

    def __len__(self) -> int:
        return len(self.frames)

    def read(self, index: int, channels: Sequence[str]) -> Sample:
        """A frame; see `openrooms_usd.loading.source.Source`."""
        frame = self.frames[index]
        needed = dict.fromkeys("distance" if n in _FOLLOWS else n for n in channels)
        told = {name: _channel_info(name) for name in needed}
        paths = {
            name: [frame.file(row.folder, picture) for picture in row.pictures]
            for name, row in told.items()
        }
        with self.files.local({path: "" for found in paths.values() for path in found}) as root:
            images = {
                name: row.make(*(read_array(root / path) for path in paths[name]))
                for name, row in told.items()
            }
        K, size = lens_of(self.files, frame.scene)
        sample = Sample(
            name=f"{frame.scene}/{frame.camera}/{frame.number}",
            size=size,
            K=K,
            world_from_camera=pose_of(self.files, frame.scene, frame.camera, frame.number),
            about={"room": frame.scene, "variant": frame.camera, "split": frame.split},
        )
        for name, pixels in images.items():
            wanted = (size[1], size[0], len(CHANNELS[name].components))
            if pixels.shape != wanted:
                raise InputError(
                    f"{name!r} has the shape {pixels.shape}, not {wanted}",
                    place=f"{self.files}/{paths[name][0]}",
                )
        if "distance" in images:
            images |= _following(sample, images["distance"])
        return replace(sample, images={name: images[name] for name in channels})


class HypersimForm:
    """Hypersim's layout (docs/howto/hypersim.md)."""

    options: Mapping[str, str] = {}

    def open(self, files: Files, selection: ViewSelection, options: Mapping[str, str]) -> Any:
        """Its frames; ``rooms`` are scenes, ``variants`` cameras, ``views`` numbers of frames.

        Raises:
            InputError: There are none.
        """
        forget()
        frames = [
            frame
            for frame in _frames(files)
            if selection.admits(frame.split, frame.camera, frame.scene, str(frame.number))
        ]
        refuse_nothing(len(frames), files, selection)
        return HypersimSource(files, frames)


def _frames(files: Files) -> Iterator[HypersimFrame]:
    folder, _, table = SPLIT_FILE.rpartition("/")
    known = read_table(files, SPLIT_FILE) if table in files.names(folder) else []
    with understanding(f"{files}/{SPLIT_FILE}"):
        splits = {
            (row["scene_name"], row["camera_name"], int(row["frame_id"])): row[
                "split_partition_name"
            ]
            for row in known
        }
    for scene in files.names("scenes"):
        for pictures in files.names(f"scenes/{scene}/images"):
            if not (found := _PICTURES.fullmatch(pictures)):
                continue
            for name in files.names(f"scenes/{scene}/images/{pictures}"):
                if number := _FRAME.fullmatch(name):
                    place = scene, found[1], int(number[1])
                    yield HypersimFrame(*place, splits.get(place, ""))


def _channel_info(channel: str) -> _ChannelInfo:
    if channel not in FROM_FILES:
        known = ", ".join((*FROM_FILES, *_FOLLOWS))
        raise InputError(f"Hypersim's files do not have {channel!r}", remedy=f"they have {known}")
    return FROM_FILES[channel]


def _following(sample: Sample, distance: Array) -> dict[str, Array]:
    """What follows from the distance and the camera."""
    depth = distance / np.linalg.norm(sample.rays, axis=-1, keepdims=True)
    points = sample.rays * depth @ sample.world_from_camera[:3, :3].T
    there = distance > 0.0
    return {
        "depth": depth.astype(np.float32),
        "position": np.where(there, points + sample.world_from_camera[:3, 3], 0.0).astype(
            np.float32
        ),
        "valid": there.astype(np.float32),
    }


def read_table(files: Files, path: str) -> list[dict[str, str]]:
    """The rows of a CSV file.

    Raises:
        InputError: It cannot be read.
    """
    with files.local({path: ""}) as root, understanding(f"{files}/{path}"):
        return list(csv.DictReader(io.StringIO(read_text(root / path, "table"))))


@contextmanager
def understanding(place: str) -> Iterator[None]:
    """Say of a table that does not hold what it should where it lies.

    Raises:
        InputError: What is done with it went wrong.
    """
    try:
        yield
    except (csv.Error, ArithmeticError, LookupError, TypeError, ValueError) as error:
        raise InputError(
            f"this is not a table of Hypersim: {type(error).__name__}: {error}",
            place=place,
            remedy="copy it again, or write it again",
        ) from error


@lru_cache(maxsize=256)
def lens_of(files: Files, scene: str) -> tuple[Array, tuple[int, int]]:
    """K and the picture's size, of the table of all scenes.

    Raises:
        InputError: The table does not know the scene, or its lens is not a pinhole.
    """
    place = f"{files}/{CAMERAS_FILE}"
    rows = (row for row in read_table(files, CAMERAS_FILE) if row.get("scene_name") == scene)
    row = next(rows, None)
    if row is None:
        raise InputError(f"it does not know the scene {scene!r}", place=place)
    with understanding(place):
        width, height = (
            int(float(row[f"settings_output_img_{side}"])) for side in ("width", "height")
        )
        rays = np.array([[float(row[f"M_cam_from_uv_{i}{j}"]) for j in range(3)] for i in range(3)])
        np.linalg.inv(rays)
    if min(width, height) < 1 or not np.isfinite(rays).all() or not rays[2, 2]:
        raise InputError(f"not the lens of a picture of {width}x{height} pixels", place=place)
    if not np.allclose(rays[2] / -rays[2, 2], _PINHOLE, atol=1e-6):
        raise InputError(
            "its lens is tilted, which K cannot express",
            place=f"{files}/{scene}",
            remedy="leave this scene out: rooms=[...]",
        )
    # From pixels to -1 to 1 over the picture, upward, and from there to rays.
    uv = np.array([[2.0 / width, 0.0, -1.0], [0.0, -2.0 / height, 1.0], [0.0, 0.0, 1.0]])
    K = np.linalg.inv(OPENGL @ rays / -rays[2, 2] @ uv)
    return K / K[2, 2], (width, height)


def pose_of(files: Files, scene: str, camera: str, frame: int) -> Array:
    """(4, 4) from the OpenCV camera of a frame to the world, metres.

    Raises:
        InputError: It has none.
    """
    numbers, positions, turns, unit = _keyframes(files, scene, camera)
    at = np.flatnonzero(numbers == frame)
    if not len(at):
        raise InputError("it has no camera", place=f"{files}/scenes/{scene}: {camera}/{frame}")
    pose = np.eye(4)
    pose[:3, :3] = turns[at[0]] @ OPENGL
    pose[:3, 3] = positions[at[0]] * unit
    return pose


@lru_cache(maxsize=256)
def _keyframes(files: Files, scene: str, camera: str) -> tuple[Array, Array, Array, float]:
    """Numbers of frames, positions in units, orientations, and metres in a unit."""
    detail = f"scenes/{scene}/_detail"
    scene_file = f"{detail}/metadata_scene.csv"
    with understanding(f"{files}/{scene_file}"):
        rows = read_table(files, scene_file)
        said = {row["parameter_name"]: row["parameter_value"] for row in rows}
        unit = float(said["meters_per_asset_unit"])
    kinds = ("frame_indices", "positions", "orientations")
    paths = [f"{detail}/{camera}/camera_keyframe_{kind}.hdf5" for kind in kinds]
    with files.local(dict.fromkeys(paths, "")) as root:
        numbers, positions, turns = (read_array(root / path) for path in paths)
    count = numbers.size
    if [a.shape for a in (numbers, positions, turns)] != [(count,), (count, 3), (count, 3, 3)]:
        raise InputError("its arrays are not cameras of frames", place=f"{files}/{detail}/{camera}")
    return numbers, positions.astype(np.float64), turns.astype(np.float64), unit


def forget() -> None:
    """Keep nothing of what was read so far: it may be other by now."""
    lens_of.cache_clear()
    _keyframes.cache_clear()
