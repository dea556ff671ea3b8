"""The files of the lights in a view: which channels each is made of, and how."""

from collections.abc import Callable
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import atomic
from openrooms_usd.colorimetry import LUMINANCE
from openrooms_usd.errors import writing
from openrooms_usd.render.reading import RenderedView
from orusd_openrooms import images, lights
from orusd_openrooms.depthshadows import depth_shadow
from orusd_openrooms.frame import Frame, Pixels
from orusd_openrooms.layout import Place
from orusd_openrooms.pickles import write_pickled
from orusd_openrooms.records import Light
from orusd_openrooms.rgbe import write_rgbe
from orusd_openrooms.unoccluded import approximate

_LUMINANCE: Final = LUMINANCE.astype(np.float32)
# What the light of an opening's lobes is computed from.
_APPROXIMATED: Final = ("depth", "normal_camera")


def write_lights(place: Place, number: int, frame: Frame) -> None:
    """Write the files of all lights of a view; ``frame.missing`` has what it cannot give.

    Args:
        place: Where they go.
        number: Of the frame.
        frame: The view.

    Raises:
        OutputError: A file cannot be written.
    """
    for light in frame.lights:
        for name, made in _LIGHT.items():
            path = place.light(name, number, light.number)
            if path and made.concerns(light) and not frame.misses(name, made.needs):
                made.write(path, frame, light)
    seen = place.visibility(number)
    if seen and frame.lights and not frame.misses("visibility", ("mask_i",)):
        kinds = {"isVisLamp": False, "isVisWindow": True}
        write_pickled(seen, {name: _seen(frame, window) for name, window in kinds.items()})


def _seen(frame: Frame, window: bool) -> bool:
    """Whether a light of this kind is in the picture."""
    return any(
        bool(_mask(frame, light).any()) for light in frame.lights if light.is_window == window
    )


def _mask(frame: Frame, light: Light) -> NDArray[np.bool_]:
    found: NDArray[np.bool_] = frame.light("mask", light)[..., 0] > 0.5
    return found


class _MadeOfLight(NamedTuple):
    needs: tuple[str, ...]
    write: Callable[[Path, Frame, Light], None]
    concerns: Callable[[Light], bool] = lambda light: True


def _camera(frame: Frame) -> NDArray[np.float64]:
    return lights.camera_from_world(frame.view.world_from_camera)


def _write_box(path: Path, frame: Frame, light: Light) -> None:
    write_pickled(path, lights.box(light, _camera(frame), _mask(frame, light)))


def _write_mask(path: Path, frame: Frame, light: Light) -> None:
    images.write_picture(path, images.ratio(_mask(frame, light)[..., None]))


def _write_source(path: Path, frame: Frame, light: Light) -> None:
    write_pickled(path, lights.source(light, _camera(frame), _loss(frame, light)))


def _loss(frame: Frame, light: Light) -> float:
    """The mean absolute error of what an opening's lobes give, lux; 0 where it is not known."""
    needs = (*_APPROXIMATED, "unoccluded_i")
    if not light.is_window or frame.lacks(needs):
        return 0.0
    true = frame.coarse(frame.light("unoccluded", light))
    off = np.abs(_approximation(frame, light).astype(np.float64) - true)
    known = off[np.isfinite(off)]
    return float(known.mean()) if known.size else 0.0


def _write_single_source(path: Path, frame: Frame, light: Light) -> None:
    write_pickled(path, lights.single_source(light, _camera(frame)))


def _write_shadow(path: Path, frame: Frame, light: Light) -> None:
    """The visibility of a coarse pixel: the mean of its pixels', each by the light that it bars."""
    free = frame.light("unoccluded", light)
    seen = frame.light("visibility", light) * free
    sums = frame.coarse(np.stack([seen @ _LUMINANCE, free @ _LUMINANCE], axis=-1))
    lit = np.where(sums[..., 1:] > 0, sums[..., 1:], 1.0)
    images.write_picture(path, images.ratio(sums[..., :1] / lit))


def _write_depth_shadow(path: Path, frame: Frame, light: Light) -> None:
    rows, columns = frame.grid
    mask = frame.coarse(_mask(frame, light)[..., None].astype(np.float32))[..., 0] > 0.0
    scale = np.array([columns / frame.view.width, rows / frame.view.height, 1.0])
    points = frame.coarse(_camera_points(frame.view)).astype(np.float64)
    K = scale[:, None] * frame.view.K
    share = depth_shadow(light, _camera(frame), points, K, mask)
    with atomic.replacing(path) as beside, writing(path):
        np.save(beside, share.astype(np.float32), allow_pickle=False)


def _write_approximation(path: Path, frame: Frame, light: Light) -> None:
    write_rgbe(path, _approximation(frame, light))


def _approximation(frame: Frame, light: Light) -> Pixels:
    """What an opening's lobes give at the points of the grid, computed once."""
    if light.number not in frame.approximations:
        points = frame.coarse(_camera_points(frame.view))
        normals = frame.coarse(frame.view.pixels["normal_camera"])
        found = approximate(light, _camera(frame), points, normals)
        frame.approximations[light.number] = found
    return frame.approximations[light.number]


def _camera_points(view: RenderedView) -> Pixels:
    """(height, width, 3) what every pixel sees; right, up, backward, metres."""
    columns, rows = np.meshgrid(np.arange(view.width) + 0.5, np.arange(view.height) + 0.5)
    rays = np.stack([columns, rows, np.ones_like(rows)], axis=-1) @ np.linalg.inv(view.K).T
    found: Pixels = (rays * [1.0, -1.0, -1.0] * view.pixels["depth"]).astype(np.float32)
    return found


def _shading(channel: str) -> _MadeOfLight:
    return _MadeOfLight(
        (f"{channel}_i",),
        lambda path, f, light: write_rgbe(path, f.coarse(f.light(channel, light))),
    )


_LIGHT: Final[dict[str, _MadeOfLight]] = {
    "box": _MadeOfLight(("mask_i",), _write_box),
    "mask": _MadeOfLight(("mask_i",), _write_mask),
    "imShadow": _MadeOfLight(("visibility_i", "unoccluded_i"), _write_shadow),
    "depthShadow": _MadeOfLight(("depth", "mask_i"), _write_depth_shadow),
    "imDS": _shading("direct"),
    "imDSNoOcclu": _shading("unoccluded"),
    "imDSNoOccluApprox": _MadeOfLight(
        _APPROXIMATED, _write_approximation, lambda light: light.is_window
    ),
    "light": _MadeOfLight((), _write_single_source),
    "lightSrc": _MadeOfLight((), _write_source),
    "lightSrcNoOcclu": _MadeOfLight((), _write_source),
}
