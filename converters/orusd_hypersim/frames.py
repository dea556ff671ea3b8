"""What each picture of a frame is made of."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Floats
from openrooms_usd.rendering.reading import RenderedView
from orusd_hypersim.cameras import OPENGL
from orusd_hypersim.hdf5 import write_array

Pixels = NDArray[Any]

FINAL: Final = "final"
GEOMETRY: Final = "geometry"
_MOST_HALF: Final = 65504.0
_NOTHING: Final = -1


class _Made(NamedTuple):
    """A picture: in which folder, of which channels, and how."""

    folder: str
    needs: tuple[str, ...]
    make: Callable[[RenderedView], Pixels]


def write_frame(images: Path, number: int, view: RenderedView) -> dict[str, str]:
    """Write the pictures of a view.

    Args:
        images: The folder of the scene's pictures.
        number: Of the frame.
        view: The view.

    Returns:
        By name of pictures that there are none of: why.

    Raises:
        InputError: A file of the render is damaged.
        OutputError: A file cannot be written.
    """
    missing = dict(_NEVER)
    with np.errstate(over="ignore", invalid="ignore"):
        for name, made in PICTURES.items():
            absent = [need for need in made.needs if need not in view.pixels]
            if absent:
                missing[name] = f"the render has no {', no '.join(absent)}"
                continue
            folder = images / f"scene_cam_00_{made.folder}_hdf5"
            write_array(folder / f"frame.{number:04d}.{name}.hdf5", made.make(view))
    return missing


# What renders do not know.
_NEVER: Final = {"tex_coord": "texture coordinates are not a channel"}


def _half(pixels: Pixels) -> NDArray[np.float16]:
    """In half precision, as Hypersim has light; what is brighter than that ends there."""
    return np.clip(pixels, -_MOST_HALF, _MOST_HALF).astype(np.float16)


def _reflectance(view: RenderedView) -> Pixels:
    return _half(view.pixels["base_color"] * (1.0 - view.pixels["metallic"]))


def _illumination(view: RenderedView) -> Pixels:
    return _half(view.pixels["irradiance"] / np.pi)


def _residual(view: RenderedView) -> Pixels:
    """What their equation leaves, of the numbers as they are stored."""
    parts = (_half(view.pixels["radiance"]), _reflectance(view), _illumination(view))
    color, reflectance, illumination = (part.astype(np.float32) for part in parts)
    return _half(color - reflectance * illumination)


def _where_surface(view: RenderedView, pixels: Pixels) -> Floats:
    """Without surface there is no number."""
    there = view.pixels["depth"] > 0.0
    return np.where(there, pixels, np.nan).astype(np.float32)


def _normal(view: RenderedView, channel: str, *, camera: bool) -> Pixels:
    normals = view.pixels[channel].astype(np.float64)
    if camera:
        normals = normals @ view.world_from_camera[:3, :3] @ OPENGL
    return _half(_where_surface(view, normals))


def _labels(view: RenderedView, channel: str) -> Pixels:
    """Numbers from 1; what has none is -1."""
    found = view.labels(channel)
    kind = np.int16 if found.max(initial=0) <= np.iinfo(np.int16).max else np.int32
    return np.where(found > 0, found, _NOTHING).astype(kind)


_DIFFUSE: Final = ("base_color", "metallic", "irradiance")

PICTURES: Final[dict[str, _Made]] = {
    "color": _Made(FINAL, ("radiance",), lambda view: _half(view.pixels["radiance"])),
    "diffuse_reflectance": _Made(FINAL, _DIFFUSE[:2], _reflectance),
    "diffuse_illumination": _Made(FINAL, _DIFFUSE[2:], _illumination),
    "residual": _Made(FINAL, ("radiance", *_DIFFUSE), _residual),
    "depth_meters": _Made(
        GEOMETRY,
        ("depth", "distance"),
        lambda view: _where_surface(view, view.pixels["distance"])[..., 0],
    ),
    "position": _Made(
        GEOMETRY, ("depth", "position"), lambda view: _where_surface(view, view.pixels["position"])
    ),
    **{
        f"normal_{'bump_' if bump else ''}{frame}": _Made(
            GEOMETRY,
            ("depth", channel),
            lambda view, channel=channel, frame=frame: _normal(  # type: ignore[misc]
                view, channel, camera=frame == "cam"
            ),
        )
        for bump, channel in ((False, "normal_geometric"), (True, "normal"))
        for frame in ("cam", "world")
    },
    "render_entity_id": _Made(GEOMETRY, ("instance",), lambda view: _labels(view, "instance")),
    "semantic_instance": _Made(GEOMETRY, ("instance",), lambda view: _labels(view, "instance")),
    "semantic": _Made(GEOMETRY, ("semantic_nyu40",), lambda view: _labels(view, "semantic_nyu40")),
}
