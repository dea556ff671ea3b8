"""A look at every view: what a person would throw away without a second one.

Some faults are the camera's: another one would not have them. They depend only on exact channels
(`JUDGED`), before any light is computed, and so are the same in all variants of a room. Of the rest
nothing is hidden: such views stay, and their records say what is wrong with them.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Floats, Mask
from openrooms_usd.colorimetry import luminance
from openrooms_usd.rendering.contract import View

# A picture of which nine tenths are darker, nits: people see no colours there.
_DARK_NITS: Final = 0.05
_DARK_QUANTILE: Final = 0.9
# The part of a picture that is brighter than what its preview shows as white.
_BLOWN_SHARE: Final = 0.5
# Nearer than that to something the camera is in it, or in front of its face, metres.
_IN_WALL_M: Final = 0.05
_CLOSE_M: Final = 0.3
_CLOSE_SHARE: Final = 0.5
# The part of the pixels that see a surface at all, and how many things there must be in them.
_EMPTY_SHARE: Final = 0.3
_LEAST_INSTANCES: Final = 2
_DIGITS: Final = 6

_IN_SOMETHING: Final = "the camera is inside an object"
_OBSTRUCTED: Final = "an object blocks the camera"
_EMPTY: Final = "it is empty"
_ONE_THING: Final = "it shows only one object"
_OF_THE_CAMERA: Final = frozenset({_IN_SOMETHING, _OBSTRUCTED, _EMPTY, _ONE_THING})

JUDGED: Final = ("depth", "instance", "valid")
"""The channels by which cameras are judged."""

# What is nowhere 0 where there is a surface, and what is not 0 everywhere where there is light.
_OF_SURFACES: Final = frozenset(
    {*JUDGED, "distance", "position", "normal", "normal_geometric", "normal_camera", "part"}
)
_OF_LIGHT: Final = frozenset({"radiance", "irradiance", "environment"})


def assess(view: View, error: float | None = None, asked: Sequence[str] = ()) -> dict[str, Any]:
    """Measures of a view, and what is wrong with it.

    Args:
        view: What was rendered.
        error: The estimated robust error that its radiance shall have at most, if any.
        asked: The single channels that it shall have.

    Returns:
        ``measures`` by name, as far as its channels tell them in numbers, and ``faults``, one
        sentence each.
    """
    measures = {name: value for name, value in _measures(view) if np.isfinite(value)}
    return {"measures": measures, "faults": list(_faults(measures, view, error, asked))}


def camera_faults(view: View) -> list[str]:
    """What is wrong with a view that another camera would not have.

    Args:
        view: It has the channels of `JUDGED`.
    """
    return [fault for fault in assess(view)["faults"] if fault in _OF_THE_CAMERA]


def _measures(view: View) -> Iterator[tuple[str, float | int]]:
    pixels = {name: image.pixels for name, image in view.images.items()}
    if "radiance" in pixels:
        light = luminance(pixels["radiance"].astype(np.float64))
        yield "bright_nits", _rounded(np.quantile(light, _DARK_QUANTILE))
        if view.exposure is not None:
            yield "blown_share", _rounded(np.mean(light * view.exposure > 1.0))
        found = view.images["radiance"].robust_error
        if found is not None:
            yield "error", _rounded(found)
    seen = _where_surface(pixels)
    if seen is not None:
        yield "seen_share", _rounded(seen.mean())
        if "depth" in pixels and seen.any():
            depth = pixels["depth"][..., 0][seen]
            yield "nearest_m", _rounded(depth.min())
            yield "close_share", _rounded(np.mean(depth < _CLOSE_M))
    if "instance" in pixels:
        numbers = np.unique(pixels["instance"])
        yield "instances", int((numbers > 0).sum())


def _where_surface(pixels: Mapping[str, Floats]) -> Mask | None:
    """(height, width) where there is a surface."""
    if "valid" in pixels:
        return pixels["valid"][..., 0] > 0.5
    return pixels["depth"][..., 0] > 0.0 if "depth" in pixels else None


def _faults(
    measures: Mapping[str, float], view: View, error: float | None, asked: Sequence[str]
) -> Iterator[str]:
    dark = measures.get("bright_nits", np.inf) < _DARK_NITS
    if dark:
        yield "it is dark"
    if measures.get("blown_share", 0.0) > _BLOWN_SHARE:
        yield "most of it is brighter than white"
    if measures.get("nearest_m", np.inf) < _IN_WALL_M:
        yield _IN_SOMETHING
    elif measures.get("close_share", 0.0) > _CLOSE_SHARE:
        yield _OBSTRUCTED
    if measures.get("seen_share", 1.0) < _EMPTY_SHARE:
        yield _EMPTY
    elif measures.get("instances", _LEAST_INSTANCES) < _LEAST_INSTANCES:
        yield _ONE_THING
    if error is not None and measures.get("error", 0.0) > error:
        yield "it is noisier than requested"
    filled = _OF_SURFACES if measures.get("seen_share", 0.0) > 0.0 else frozenset()
    if missing := list(_missing(view, asked, filled if dark else filled | _OF_LIGHT)):
        yield f"no values in {', '.join(missing)}"
    broken = [name for name, image in view.images.items() if not np.isfinite(image.pixels).all()]
    if broken:
        yield f"not all values are finite in {', '.join(broken)}"


def _missing(view: View, asked: Sequence[str], filled: frozenset[str]) -> Iterator[str]:
    """Channels that are not there, have no pixels, or are 0 everywhere though they cannot be."""
    for name in asked:
        image = view.images.get(name)
        if image is None or not image.pixels.size or (name in filled and not image.pixels.any()):
            yield name


def _rounded(value: Any) -> float:
    return float(f"{float(value):.{_DIGITS}g}")
