"""The lights of a render, as the files of the dataset need them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.rendering.reading import RenderedScene
from openrooms_usd.rendering.scene.lights import Gaussian, LightKind, LightRecord, LobeName

LAMP: Final[LightKind] = "lamp"
ELSEWHERE: Final[LightKind] = "elsewhere"  # what no lamp and no opening brings: it has no place
# Of an opening's fit, with the endings of their names in the loaders' files.
LOBES: Final[dict[LobeName, str]] = {"sun": "", "sky": "Sky", "ground": "Grd"}


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
    """

    number: int
    is_window: bool
    on: bool
    center: Array
    axes: Array
    size: Array
    radiance: Array
    lobes: Mapping[str, Lobe]


def lights_of(scene: RenderedScene) -> list[Light]:
    """The lights of a render that have a place, in the order of their numbers."""
    return [light_of(record) for record in scene.lights if record.kind != ELSEWHERE]


def light_of(record: LightRecord) -> Light:
    """A light with a place."""
    axes = record.world_from_box[:3, :3]
    lobes = {gaussian.name: _lobe(gaussian) for gaussian in record.gaussians}
    # An opening without a fit lets its mean radiance in, alike from everywhere.
    lobes = lobes or {"sky": Lobe(np.array([0.0, 0.0, 1.0]), 0.0, record.radiance)}
    return Light(
        number=record.number,
        is_window=record.kind != LAMP,
        on=record.on,
        center=record.world_from_box[:3, 3],
        axes=axes / np.linalg.norm(axes, axis=0),
        size=record.size,
        radiance=record.radiance,
        lobes=lobes if record.kind != LAMP else {},
    )


def _lobe(fit: Gaussian) -> Lobe:
    return Lobe(fit.axis / np.linalg.norm(fit.axis), fit.sharpness, fit.amplitude)
