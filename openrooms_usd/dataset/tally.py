"""What a record tells of the pixels of a view, small enough for a million views."""

from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from openrooms_usd import names
from openrooms_usd.channels import CHANNELS, definition
from openrooms_usd.rendering.contract import View

if TYPE_CHECKING:
    from pxr import Usd

DEPTH_STEP_M: Final = 0.25
"""The width of a bin of depths."""
DEPTH_BINS: Final = 41
"""How many there are; the last one takes all that is farther."""
OTHER: Final = "other"
"""What materials are counted as of which nobody says what they are."""


def material_names(stage: "Usd.Stage", paths: Mapping[int, str]) -> dict[int, str]:
    """What materials are counted as: ``substance/family``, as far as a stage says so.

    Args:
        stage: The composed stage.
        paths: The materials' prim paths by number.
    """
    return {number: _material_name(stage, path) for number, path in paths.items()}


def _material_name(stage: "Usd.Stage", path: str) -> str:
    prim = stage.GetPrimAtPath(path)
    said = (names.MATERIAL_CATEGORY, names.MATERIAL_FAMILY)
    found = [prim.GetAttribute(name).Get() for name in said if prim and prim.HasAttribute(name)]
    return "/".join(str(word) for word in found if word) or OTHER


def tally(view: View, classes: Mapping[int, str], materials: Mapping[int, str]) -> dict[str, Any]:
    """Counts of a view's pixels; empty where its channels do not tell.

    Args:
        view: What was rendered.
        classes: Names of OpenRooms' classes, by number.
        materials: As `material_names` gives them.

    Returns:
        ``pixels`` by class, how many ``instances``, ``materials`` by name, and ``depth``: how many
        lie in each bin of `DEPTH_STEP_M`, up to the last that has any.
    """
    return {
        "pixels": _labelled(view, "semantic", classes),
        "instances": _instances(view),
        "materials": _labelled(view, "material", materials),
        "depth": _depths(view),
    }


def channel_seconds(view: View) -> dict[str, float]:
    """Seconds of each channel, by its name in the table; those that share rays each count them."""
    seconds: dict[str, float] = {}
    for name, image in view.images.items():
        table = definition(name).name
        seconds[table] = max(seconds.get(table, 0.0), image.seconds)
    return {name: seconds[name] for name in CHANNELS if name in seconds}


def _labelled(view: View, channel: str, named: Mapping[int, str]) -> dict[str, int]:
    if channel not in view.images:
        return {}
    pixels = view.images[channel].pixels.astype(np.int64)
    numbers, counts = np.unique(pixels, return_counts=True)
    found: Counter[str] = Counter()
    for number, count in zip(numbers.tolist(), counts.tolist(), strict=True):
        if number in named:
            found[named[number]] += count
    return dict(sorted(found.items()))


def _instances(view: View) -> int | None:
    if "instance" not in view.images:
        return None
    return int(np.count_nonzero(np.unique(view.images["instance"].pixels)))


def _depths(view: View) -> list[int]:
    if "depth" not in view.images:
        return []
    depth = view.images["depth"].pixels
    bins = np.minimum(depth[depth > 0.0] / DEPTH_STEP_M, DEPTH_BINS - 1).astype(np.int64)
    return [int(count) for count in np.bincount(bins)]
