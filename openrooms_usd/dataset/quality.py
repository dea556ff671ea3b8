"""A look at every view: what a person would throw away without a second one.

Nothing is hidden by it: views stay, and their records say what is wrong with them.
"""

from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.colorimetry import luminance
from openrooms_usd.render.contract import View

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


def look_at(view: View, error: float | None = None) -> dict[str, Any]:
    """Measures of a view, and what is wrong with it.

    Args:
        view: What was rendered.
        error: The estimated robust error that its radiance shall have at most, if any.

    Returns:
        ``measures`` by name, as far as its channels tell them, and ``faults``, one sentence each.
    """
    measures = dict(_measures(view))
    return {"measures": measures, "faults": list(_faults(measures, view, error))}


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
    seen = _seen(pixels)
    if seen is not None:
        yield "seen_share", _rounded(seen.mean())
        if "depth" in pixels and seen.any():
            depth = pixels["depth"][..., 0][seen]
            yield "nearest_m", _rounded(depth.min())
            yield "close_share", _rounded(np.mean(depth < _CLOSE_M))
    if "instance" in pixels:
        numbers = np.unique(pixels["instance"])
        yield "instances", int((numbers > 0).sum())


def _seen(pixels: Mapping[str, NDArray[np.float32]]) -> NDArray[np.bool_] | None:
    """(height, width) where there is a surface."""
    if "valid" in pixels:
        return pixels["valid"][..., 0] > 0.5
    return pixels["depth"][..., 0] > 0.0 if "depth" in pixels else None


def _faults(measures: Mapping[str, float], view: View, error: float | None) -> Iterator[str]:
    if measures.get("bright_nits", np.inf) < _DARK_NITS:
        yield "it is dark"
    if measures.get("blown_share", 0.0) > _BLOWN_SHARE:
        yield "most of it is brighter than white"
    if measures.get("nearest_m", np.inf) < _IN_WALL_M:
        yield "the camera is in something"
    elif measures.get("close_share", 0.0) > _CLOSE_SHARE:
        yield "something stands in front of the camera"
    if measures.get("seen_share", 1.0) < _EMPTY_SHARE:
        yield "it is empty"
    elif measures.get("instances", _LEAST_INSTANCES) < _LEAST_INSTANCES:
        yield "it shows one thing alone"
    if error is not None and measures.get("error", 0.0) > error:
        yield "it is noisier than asked for"
    broken = [name for name, image in view.images.items() if not np.isfinite(image.pixels).all()]
    if broken:
        yield f"not all numbers are finite in {', '.join(broken)}"


def _rounded(value: Any) -> float:
    return float(f"{float(value):.{_DIGITS}g}")
