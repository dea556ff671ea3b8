"""The lights of a render, read from its manifest."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.render.reading import RenderedScene

Array = NDArray[np.float64]

LAMP: Final = "lamp"
ELSEWHERE: Final = "elsewhere"  # what no lamp and no opening brings: it has no place
# Of an opening's fit, with the endings of their names in the loaders' files.
LOBES: Final = {"sun": "", "sky": "Sky", "ground": "Grd"}


@dataclass(frozen=True, eq=False)
class Lobe:
    """Light that arrives from about a direction: intensity exp(sharpness (axis . d - 1)).

    Attributes:
        axis: (3,) unit, towards where the light comes from; world.
        sharpness: At least 0; 0 is the same in every direction.
        intensity: (3,) nits.
    """

    axis: Array
    sharpness: float
    intensity: Array


@dataclass(frozen=True, eq=False)
class Light:
    """A light with a place.

    Attributes:
        number: Its number among the light channels.
        is_window: Whether it is an opening, not a lamp.
        on: Whether it shines.
        center: (3,) of its box; world, metres.
        axes: (3, 3) the box's unit vectors as columns; world.
        size: (3,) the box's lengths along them, metres; an opening's third is 0.
        radiance: (3,) nits that a lamp emits, or the mean of what an opening lets in.
        lobes: By name, the fit of what an opening lets in; empty for a lamp.
        loss: How far the fit is from the light, nits (root of the mean square).
    """

    number: int
    is_window: bool
    on: bool
    center: Array
    axes: Array
    size: Array
    radiance: Array
    lobes: Mapping[str, Lobe]
    loss: float = 0.0


def lights_of(scene: RenderedScene) -> list[Light]:
    """The lights of a render that have a place, in the order of their numbers.

    Raises:
        InputError: The manifest's entry of one is damaged.
    """
    found = []
    for entry in scene.lights:
        if entry.get("kind") == ELSEWHERE:
            continue
        try:
            found.append(_light(entry))
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(
                f"light {entry.get('number')} is not described as expected: {error!r}",
                place=scene.folder / "manifest.json",
                remedy="render again",
            ) from error
    return found


def _light(entry: Mapping[str, Any]) -> Light:
    world_from_box = np.array(entry["world_from_box"], dtype=np.float64).reshape(4, 4)
    axes = world_from_box[:3, :3]
    fit, radiance = entry.get("fit") or {}, _color(entry.get("radiance"))
    lobes = {name: _lobe(fit[name]) for name in LOBES if name in fit}
    # An opening without a fit lets its mean radiance in, alike from everywhere.
    lobes = lobes or {"sky": Lobe(np.array([0.0, 0.0, 1.0]), 0.0, radiance)}
    return Light(
        number=int(entry["number"]),
        is_window=entry["kind"] != LAMP,
        on=bool(entry["on"]),
        center=world_from_box[:3, 3],
        axes=axes / np.linalg.norm(axes, axis=0),
        size=np.array(entry["size"], dtype=np.float64).reshape(3),
        radiance=radiance,
        lobes=lobes if entry["kind"] != LAMP else {},
        loss=float(fit.get("loss", 0.0)),
    )


def _lobe(entry: Mapping[str, Any]) -> Lobe:
    axis = np.array(entry["axis"], dtype=np.float64).reshape(3)
    return Lobe(axis / np.linalg.norm(axis), float(entry["sharpness"]), _color(entry["intensity"]))


def _color(value: Any) -> Array:
    return np.zeros(3) if value is None else np.array(value, dtype=np.float64).reshape(3)
