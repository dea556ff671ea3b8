"""The surroundings as a panorama of the release, and the boxes of lights in the scene's world."""

from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.rendering.scene.arrays import Scene
from orusd_openrooms.cameras import THEIRS_FROM_OURS
from orusd_openrooms.lights import LOBES, Light, box, source

# Suns are drawn as pixels, which must be small.
_SUNNY: Final = (512, 1024)
_SMALL: Final = (16, 32)
_STILL: Final = 1e-9
# What loaders call the form of these lights.
FORM: Final = "3SG-SkyGrd"
_AXES: Final = tuple(f"axis{ending}" for ending in LOBES.values())


def panorama(scene: Scene) -> Floats:
    """(H, W, 3) nits: the middle looks along their +z, right of it along their -x, top up."""
    sky = scene.environment
    if sky is None:
        pixels, turn = np.zeros((1, 1, 3), np.float32), np.eye(3)
    else:
        # A small picture came with rows between its own, and at the poles, that are made of them.
        height, width = sky.pixels.shape[:2]
        own = sky.pixels[1::2] if height > max(1, width) else sky.pixels
        pixels, turn = np.maximum(own, 0.0), sky.world_from_light
    size = pixels.shape[:2] if pixels.shape[0] > 1 else _SMALL
    if scene.suns:
        size = (max(size[0], _SUNNY[0]), max(size[1], _SUNNY[1]))
    ways = _directions(*size)
    light_from_theirs = turn.T @ THEIRS_FROM_OURS.T
    if size == pixels.shape[:2] and np.abs(light_from_theirs - np.eye(3)).max() < _STILL:
        found = pixels.astype(np.float32).copy()
    else:
        found = _looked_up(pixels, ways @ light_from_theirs.T)
    for sun in scene.suns:
        toward = THEIRS_FROM_OURS @ -sun.direction
        row, column = np.unravel_index(int((ways @ toward).argmax()), size)
        height = np.pi / size[0]
        solid = 2.0 * np.pi / size[1] * height * np.sin((row + 0.5) * height)
        found[row, column] += (sun.irradiance / solid).astype(np.float32)
    return found


def _directions(height: int, width: int) -> Array:
    """(H, W, 3) unit vectors of pixels, as `DomeLight` has them: +Y up, +Z in the middle."""
    theta = (np.arange(height) + 0.5) * np.pi / height
    phi = ((np.arange(width) + 0.5) / width - 0.5) * 2.0 * np.pi
    y = np.broadcast_to(np.cos(theta)[:, None], (height, width))
    # A quarter from the left looks along +X.
    x, z = (np.sin(theta)[:, None] * f(phi) for f in (lambda p: -np.sin(p), np.cos))
    return np.stack([x, y, z], axis=-1)


def _looked_up(pixels: Floats, ways: Array) -> Floats:
    """Bilinear values, round about and to the poles."""
    height, width = pixels.shape[:2]
    rows = np.arccos(np.clip(ways[..., 1], -1.0, 1.0)) / np.pi * height - 0.5
    columns = (np.arctan2(-ways[..., 0], ways[..., 2]) / (2.0 * np.pi) + 0.5) * width - 0.5
    top, left = np.floor(rows).astype(int), np.floor(columns).astype(int)
    v, u = (rows - top)[..., None], (columns - left)[..., None]

    def at(row: NDArray[np.int_], column: NDArray[np.int_]) -> Array:
        return np.asarray(pixels[np.clip(row, 0, height - 1), column % width], dtype=np.float64)

    upper = at(top, left) * (1.0 - u) + at(top, left + 1) * u
    lower = at(top + 1, left) * (1.0 - u) + at(top + 1, left + 1) * u
    return np.asarray(upper * (1.0 - v) + lower * v, dtype=np.float32)


def light_files(
    lights: Sequence[Light], scale: float, environment: str
) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """What ``box*.dat`` and ``light_3SG-SkyGrd_*.dat`` of each light hold, in the scene's world.

    Args:
        lights: Windows and lamps, in the order of their shapes.
        scale: Of the environment map.
        environment: Its path.
    """
    theirs = np.eye(4)
    theirs[:3, :3] = THEIRS_FROM_OURS
    nothing = np.zeros((1, 1), dtype=np.bool_)
    for number, light in enumerate(lights):
        found = box(light, theirs, nothing)
        around = {"isWindow": light.is_window, "box3D_world": found["box3D"]}
        values = source(light, theirs)
        world = {f"{key}_world" if key in _AXES else key: value for key, value in values.items()}
        shines: dict[str, Any] = {"shapeId": number, "N_ambient_rep": FORM, **world}
        if light.is_window:
            paths = dict.fromkeys(("lightXmlFile", "recHalfEnvName", "imHalfEnvName"), "")
            shines |= {"envScale": scale, "envMapPath": environment, **paths}
        yield around, shines
