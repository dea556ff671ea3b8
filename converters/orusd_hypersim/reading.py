"""Cameras, lenses and tables of scenes in Hypersim's layout, as others wrote them."""

import csv
import io
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.loading.files import Files
from openrooms_usd.untrusted import read_text
from orusd_hypersim.cameras import OPENGL
from orusd_hypersim.hdf5 import read_array
from orusd_hypersim.tables import CAMERAS_FILE

Array = NDArray[Any]

# What a lens that is no pinhole has otherwise in the last row of its matrix.
_PINHOLE: Final = (0.0, 0.0, -1.0)


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
            f"this is no table of Hypersim: {type(error).__name__}: {error}",
            place=place,
            remedy="bring it here again, or write it again",
        ) from error


@lru_cache(maxsize=256)
def lens_of(files: Files, scene: str) -> tuple[Array, tuple[int, int]]:
    """K and the picture's size, of the table of all scenes.

    Raises:
        InputError: The table does not know the scene, or its lens is no pinhole.
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
        raise InputError(f"no lens of a picture of {width}x{height} pixels", place=place)
    if not np.allclose(rays[2] / -rays[2, 2], _PINHOLE, atol=1e-6):
        raise InputError(
            "its lens is tilted, which K cannot say", place=f"{files}/{scene}",
            remedy="leave this scene out: rooms=[...]",
        )  # fmt: skip
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
        raise InputError("its arrays are no cameras of frames", place=f"{files}/{detail}/{camera}")
    return numbers, positions.astype(np.float64), turns.astype(np.float64), unit


def forget() -> None:
    """Keep nothing of what was read so far: it may be other by now."""
    lens_of.cache_clear()
    _keyframes.cache_clear()
