"""What may be asked of the exporter."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Final, Literal

from openrooms_usd.errors import InputError

_MOST_STOPS: Final = 40.0
_CHOICES: Final[dict[str, tuple[str, ...]]] = {
    "pictures": ("png", "jpeg", "webp"),
    "light": ("lamps", "baked", "lightmaps"),
    "compression": ("none", "draco"),
    "instances": ("nodes", "gpu"),
}


@dataclass(frozen=True)
class Options:
    """What the exporter does.

    Attributes:
        pictures: How textures are stored: ``png`` keeps PNG and JPEG files as they are, ``jpeg``
            and ``webp`` make them smaller; readers must know the extension for WebP.
        light: ``lamps`` for lights of the viewer, or ``baked`` for what the stage's lightmaps say
            (`orusd bake`): surfaces show their light themselves. ``lightmaps`` is as ``lamps``,
            with the places of surfaces in the lightmaps, for viewers that have these besides.
        compression: Of vertices: ``none``, or ``draco``, whose extension readers must know.
        exposure: Stops by which light is made brighter, for viewers that cannot expose: rooms are
            in nits. ``camera`` is what the first camera says that says something. None is as it is
            for ``lamps``, and as for ``camera`` where it is ``baked``.
        instances: ``nodes`` for a node each, or ``gpu`` for one node of all that show the same
            mesh, whose extension readers must know.
    """

    pictures: Literal["png", "jpeg", "webp"] = "png"
    light: Literal["lamps", "baked", "lightmaps"] = "lamps"
    compression: Literal["none", "draco"] = "none"
    exposure: float | Literal["camera"] | None = None
    instances: Literal["nodes", "gpu"] = "nodes"


def parsed(given: Mapping[str, Any]) -> Options:
    """The given options.

    Raises:
        InputError: One is not known, or has a value that is not.
    """
    known = [item.name for item in fields(Options)]
    for name, value in given.items():
        if name not in known:
            offered = ", ".join(known)
            raise InputError(f"the glTF exporter has no option {name!r}", remedy=f"use {offered}")
        if name in _CHOICES and value not in _CHOICES[name]:
            offered = " or ".join(_CHOICES[name])
            raise InputError(f"{name} is {value!r}", remedy=f"give {offered}")
    return Options(**{**given, "exposure": _stops(given.get("exposure"))})


def _stops(value: Any) -> float | Literal["camera"] | None:
    if value is None or value == "camera":
        return value  # type: ignore[no-any-return]
    try:
        stops = float(value)
    except (TypeError, ValueError):
        stops = math.inf
    if not abs(stops) <= _MOST_STOPS:
        raise InputError(
            f"exposure is {value!r}", remedy=f"give stops up to {_MOST_STOPS:g}, or camera"
        )
    return stops
