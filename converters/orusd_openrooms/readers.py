"""Reads OpenRooms' files, of the release or ours, into arrays; shares no code with the writers.

Pictures come in the order red, green, blue, rows from the top; frames are those of the files.
"""

import json
import math
import struct
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import hdf5, untrusted
from openrooms_usd.arrays import Array, Bytes, Floats, Ints, Mask
from openrooms_usd.errors import InputError
from openrooms_usd.unpickling import read_pickled
from openrooms_usd.unpickling.arrays import read_array
from openrooms_usd.untrusted import checked, read_text

_MOST_PIXELS: Final = 2**27


def read_light(path: Path) -> Floats:
    """A Radiance picture, ``.hdr`` or ``.rgbe``: (height, width, 3).

    Raises:
        InputError: It is missing or is not such a picture.
    """
    pixels: Floats = _read_image(path, "hdr").astype(np.float32)
    if pixels.shape[-1] != 3:
        raise InputError(f"{pixels.shape[-1]} channels, not 3", place=path)
    return pixels


def read_bytes(path: Path) -> Bytes:
    """An 8-bit picture: (height, width, 3).

    Raises:
        InputError: It is missing or is not a PNG of three channels.
    """
    pixels = _read_image(path, "png")
    if pixels.dtype != np.uint8 or pixels.shape[-1] != 3:
        raise InputError(
            f"{pixels.shape[-1]} channels of {pixels.dtype}, not 3 of 8 bits", place=path
        )
    return pixels


def read_base_color(path: Path) -> Floats:
    """Linear reflectance as loaders decode it: (height, width, 3)."""
    return ((read_bytes(path) / 255.0) ** 2.2).astype(np.float32)


def read_roughness(path: Path) -> Floats:
    """Perceptual roughness: (height, width)."""
    return (read_bytes(path)[..., 0] / 255.0).astype(np.float32)


def read_normal(path: Path) -> Floats:
    """Unit vectors along right, up, backward; 0 without surface: (height, width, 3)."""
    stored = read_bytes(path)
    vectors = stored / 127.5 - 1.0
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    there = (stored > 0).any(axis=-1, keepdims=True)
    return np.where(there, vectors / np.maximum(length, 1e-6), 0.0).astype(np.float32)


def read_mask(path: Path) -> dict[str, Mask]:
    """(height, width) where ``sky``, a ``lamp`` or an ``object`` is, by the loaders' thresholds."""
    share = read_bytes(path)[..., 0] / 255.0
    return {"sky": share < 0.1, "lamp": (share > 0.49) & (share < 0.51), "object": share > 0.9}


def read_depth(path: Path) -> Floats:
    """Planar depth, metres; 0 without surface: (height, width).

    Raises:
        InputError: It is missing or damaged.
    """
    return _read_binary(path, "<f4", 1)[..., 0].astype(np.float32)


def read_parts(path: Path) -> NDArray[np.int32]:
    """Model, material part and object of every pixel: (height, width, 3).

    Raises:
        InputError: It is missing or damaged.
    """
    return _read_binary(path, "<i4", 3).astype(np.int32)


def read_labels(path: Path) -> Ints:
    """Numbers of the 45 classes: (height, width).

    Raises:
        InputError: It is missing, damaged, or holds objects.
    """
    return np.asarray(read_array(path, 2, "iu"), np.int64)


def read_environments(
    path: Path, order: Literal["legacy", "rgb"] = "legacy", cell: tuple[int, int] = (16, 32)
) -> Floats:
    """A grid of hemispheres: (rows, columns, elevations, azimuths, 3).

    Args:
        path: The tiled picture.
        order: In which order its channels are stored; ``legacy`` is blue, green, red.
        cell: Elevations and azimuths of a hemisphere.

    Raises:
        InputError: It is missing, or no such grid.
    """
    picture = read_light(path)
    height, width = picture.shape[:2]
    if height % cell[0] or width % cell[1]:
        raise InputError(f"{width}x{height} is not a grid of {cell[1]}x{cell[0]}", place=path)
    found = np.empty((height // cell[0], width // cell[1], *cell, 3), np.float32)
    for row in range(found.shape[0]):
        band = picture[row * cell[0] : (row + 1) * cell[0]]
        found[row] = np.stack(np.split(band, found.shape[1], axis=1))
    return np.flip(found, axis=-1) if order == "legacy" else found


def read_lobes(path: Path) -> Floats:
    """Spherical Gaussians: (rows, columns, lobes, 6), theta, phi, sharpness, red, green, blue.

    Raises:
        InputError: It is missing or holds no such data set.
        MissingPackageError: h5py is not installed.
    """
    found = hdf5.read_array(path, "data", "openrooms", _are_lobes)
    return found.astype(np.float32)


def _are_lobes(shape: tuple[int, ...], kind: str) -> bool:
    return len(shape) == 4 and shape[-1] == 6 and kind == "f" and math.prod(shape) <= _MOST_PIXELS


def read_cameras(path: Path) -> list[Array]:
    """(3, 3) origin, target, up of every camera; Y up, metres.

    Raises:
        InputError: It is missing or damaged.
    """
    try:
        first, *rows = read_text(path, "table").splitlines()
        count = int(first)
        if count < 0:
            raise ValueError("their number is negative")
        numbers = np.array([[float(word) for word in row.split()] for row in rows])
        found = numbers.reshape(count, 3, 3)
    except ValueError as error:
        raise InputError(f"not a list of cameras: {error}", place=path) from error
    if not np.isfinite(found).all():
        raise InputError("not a list of cameras: a number is not finite", place=path)
    return list(found)


def read_view_names(path: Path) -> list[str]:
    """Which view of its render each camera of ``cam.txt`` is; empty if unknown.

    Raises:
        InputError: It is missing or damaged.
    """
    try:
        found = json.loads(read_text(path, "json"))["views"]
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise InputError("not a list of views", place=path) from error
    if not isinstance(found, list) or not all(isinstance(name, str) for name in found):
        raise InputError("not a list of views", place=path)
    return found


def read_intrinsics(path: Path) -> Array:
    """(3, 3) the matrix of a camera, pixels.

    Raises:
        InputError: It is missing or damaged.
    """
    try:
        rows = read_text(path, "table").splitlines()
        found = np.array([[float(word) for word in row.split()] for row in rows]).reshape(3, 3)
    except ValueError as error:
        raise InputError(f"not the matrix of a camera: {error}", place=path) from error
    return found


def read_light_box(path: Path) -> dict[str, Any]:
    """The box of a light: ``isWindow``, ``box3D`` in right, up, backward, ``box2D``.

    Raises:
        InputError: It is missing, no pickle of plain data, or no such box.
    """
    found = read_pickled(path)
    if not isinstance(found, dict) or not {"isWindow", "box3D", "box2D"} <= set(found):
        raise InputError("not the box of a light", place=path)
    return found


def _read_binary(path: Path, kind: str, depth: int) -> NDArray[Any]:
    data = untrusted.read_bytes(path, "picture")
    try:
        height, width = struct.unpack_from("<ii", data)
    except struct.error as error:
        raise InputError("shorter than its own header", place=path) from error
    if not (0 < height * width <= _MOST_PIXELS and height > 0):
        raise InputError(f"a picture of {width}x{height}", place=path)
    if len(data) != 8 + 4 * height * width * depth:
        raise InputError(f"{len(data)} bytes are not {width}x{height}x{depth} numbers", place=path)
    return np.frombuffer(data, kind, offset=8).reshape(height, width, depth)


def _read_image(path: Path, form: str) -> NDArray[Any]:
    import OpenImageIO

    checked(path, "picture")
    try:
        source: Any = OpenImageIO.ImageInput.open(str(path))
        if source is None:
            raise InputError(f"not a readable image: {OpenImageIO.geterror()}", place=path)
        try:
            spec = source.spec()
            if source.format_name() != form:
                raise InputError(f"a picture of the kind {source.format_name()}", place=path)
            if not 0 < spec.width * spec.height <= _MOST_PIXELS:
                raise InputError(f"a picture of {spec.width}x{spec.height}", place=path)
            pixels = source.read_image(spec.format)
            if pixels is None:
                raise InputError(f"a damaged image: {source.geterror()}", place=path)
        finally:
            source.close()
    # Its messages quote the file, in whatever bytes.
    except UnicodeDecodeError as error:
        raise InputError("a damaged image: its header is not text", place=path) from error
    return np.asarray(pixels)
