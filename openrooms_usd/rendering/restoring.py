"""Channels that follow from others: compact storage leaves them out, reading works them out."""

from collections.abc import Callable, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.channels import CHANNELS, definition, numbered
from openrooms_usd.geometry.pinhole import pixel_directions
from openrooms_usd.rendering.shading import RULES

# OpenCV axes (right, down, forward) in OpenGL's (right, up, backward).
_OPENGL: Final = np.diag([1.0, -1.0, -1.0])
# How far what is worked out may be from what was rendered, so that the latter need not be stored:
# relative to the length of the ray and of the camera's place, and of one for what has no length.
_LENGTH_TOLERANCE: Final = 2e-6
_HALF_TOLERANCE: Final = 2e-3


def _distance(depth: Array, K: Array, pose: Array) -> Array:
    return np.asarray(depth * np.linalg.norm(_rays(depth, K), axis=-1, keepdims=True))


def _position(depth: Array, K: Array, pose: Array) -> Array:
    points = (_rays(depth, K) * depth) @ pose[:3, :3].T + pose[:3, 3]
    return np.where(depth > 0.0, points, 0.0)


def _normal_camera(normal: Array, K: Array, pose: Array) -> Array:
    return np.asarray(normal @ pose[:3, :3] @ _OPENGL)


def _rays(image: Array, K: Array) -> Array:
    return pixel_directions(K, image.shape[1], image.shape[0])


_GEOMETRY: Final[dict[str, tuple[str, Callable[[Array, Array, Array], Array], float]]] = {
    "distance": ("depth", _distance, _LENGTH_TOLERANCE),
    "position": ("depth", _position, _LENGTH_TOLERANCE),
    "normal_camera": ("normal", _normal_camera, _HALF_TOLERANCE),
}
# Those of light that no renderer gives: they are made by these rules in the first place.
_LIGHT: Final = {name: rule for name, rule in RULES.items() if CHANNELS[name].kind == "derived"}


def sources_of(name: str) -> tuple[str, ...]:
    """The channels that one follows from; none where it follows from no others.

    Args:
        name: Of a single image: ``direct_3`` is one of ``direct_i``.
    """
    try:
        base = definition(name).name
    except KeyError:
        return ()
    if base in _GEOMETRY:
        return (_GEOMETRY[base][0],)
    light = name.rpartition("_")[2]
    found = _LIGHT[base][0] if base in _LIGHT else ()
    return tuple(numbered(one, int(light)) if one.endswith("_i") else one for one in found)


def restored(name: str, parts: Mapping[str, NDArray[Any]], K: Array, pose: Array) -> Floats:
    """A channel from those that it follows from.

    Args:
        name: One that has `sources_of`.
        parts: (height, width, components) by their names.
        K: (3, 3) intrinsics, pixels.
        pose: (4, 4) from the OpenCV camera frame to the world, metres.

    Returns:
        (height, width, components): lengths within 2e-6 of the distance from the camera and of its
        place, directions within 2e-3, light as exact as its parts and never negative.
    """
    images = [parts[source].astype(np.float64) for source in sources_of(name)]
    base = definition(name).name
    # Pixels may hold any number, NaN and infinity.
    with np.errstate(over="ignore", invalid="ignore"):
        if base in _GEOMETRY:
            return _GEOMETRY[base][1](images[0], K, pose).astype(np.float32)
        # Where two that were rounded cancel, less than nothing may remain.
        return np.maximum(_LIGHT[base][1](*images), 0.0).astype(np.float32)


def follows(
    name: str, pixels: Floats, parts: Mapping[str, NDArray[Any]], K: Array, pose: Array
) -> bool:
    """Whether a channel can be left out: what would be worked out is what was rendered.

    Cameras other than pinholes, such as panoramas, have no position that follows from K.

    Args:
        name: One that has `sources_of`, which are all among ``parts``.
        pixels: (height, width, components) as it was rendered.
        parts: As of `restored`, as they are stored where that is exact.
        K: As of `restored`.
        pose: As of `restored`.
    """
    base = definition(name).name
    if base not in _GEOMETRY:
        return True
    off = np.abs(restored(name, parts, K, pose) - pixels)
    tolerance = _GEOMETRY[base][2]
    if tolerance == _LENGTH_TOLERANCE:
        away = _distance(parts["depth"].astype(np.float64), K, pose)
        return bool((off <= tolerance * (1.0 + away + np.abs(pose[:3, 3]).max())).all())
    return bool((off <= tolerance).all())
