"""What is known of a light that ground truth is given for."""

from collections.abc import Iterable
from dataclasses import dataclass, fields, is_dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from openrooms_usd.arrays import Array, Floats

if TYPE_CHECKING:
    from openrooms_usd.rendering.scene.arrays import Patch

LightKind = Literal["lamp", "opening", "elsewhere"]
LobeName = Literal["sun", "sky", "ground"]


@dataclass(frozen=True, eq=False)
class Gaussian:
    """A spherical Gaussian, ``amplitude exp(sharpness (axis . d - 1))``, part of a fit.

    Attributes:
        name: What it stands for: ``sun``, ``sky`` or ``ground``.
        amplitude: (3,) nits along its axis.
        axis: (3,) unit vector in the world.
        sharpness: From 0, which is even.
    """

    name: str
    amplitude: Array
    axis: Array
    sharpness: float


@dataclass(frozen=True, eq=False)
class LightRecord:
    """A light, by the number under which channels are filed.

    Attributes:
        number: From 0.
        name: For people and options; unique.
        path: Its prim: a lamp's object or a portal; empty for ``elsewhere``.
        kind: A lamp emits by itself, an opening lets the surroundings in, ``elsewhere`` is what
            comes in past all openings.
        on: Whether it gives any light.
        world_from_box: (4, 4) a rigid motion: the middle and the axes of its box, metres. Of a lamp
            its emitting faces' box along the object's axes; of an opening x runs along its width, y
            along its height, z outwards.
        size: (3,) of the box along its axes, metres; an opening's third is 0.
        radiance: (3,) mean over the emitting faces, nits; of an opening the mean of the
            surroundings over the directions that come in, by their cosine.
        lumen: Luminous flux that it sends into the room if nothing stands in its way.
        kelvin: Colour temperature that the stage gives; None where it gives none.
        instance: The lamp's object in the channel ``instance``; 0 for openings.
        gaussians: A fit of the surroundings as an opening sees them: sun, sky, ground.
        fit_error: RMS of what that fit leaves over the RMS of the surroundings, by how much of each
            direction comes in, without a sun that has a lobe by itself.
        environment: (height, 2 height, 3) float32, what an opening's centre sees of the
            surroundings, nits, as the texture of a dome whose pole is the world's Z.
    """

    number: int
    name: str
    path: str
    kind: LightKind
    on: bool
    world_from_box: Array
    size: Array
    radiance: Array
    lumen: float
    kelvin: float | None = None
    instance: int = 0
    gaussians: tuple[Gaussian, ...] = ()
    fit_error: float | None = None
    environment: Floats | None = None

    def as_dict(self) -> dict[str, Any]:
        """The record as plain data, without its picture."""
        names = (field.name for field in fields(self) if field.name != "environment")
        return {name: plain(getattr(self, name)) for name in names}


def plain(value: Any) -> Any:
    """Arrays, tuples and records as lists, numbers and dictionaries."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return [plain(item) for item in value]
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    return value


def is_linked(patches: "Iterable[Patch]") -> bool:
    """Whether any lamp lights only some surfaces, or some more than others."""
    return any(patch.unlit_by or patch.response != (1.0, 1.0) for patch in patches)


def counted(lamp: "Patch", patch: "Patch") -> float:
    """The factor of a lamp's light on a surface.

    Args:
        lamp: What emits.
        patch: What receives: the second multiplier is for what is all metal.
    """
    if lamp.lamp in patch.unlit_by:
        return 0.0
    return lamp.response[patch.surface.metallic == 1.0]
