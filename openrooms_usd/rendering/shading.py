"""Channels of light that are made of others: the Lambertian part, and what remains.

A renderer that has them from the lobes of surfaces gives them itself.
"""

import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.channels import CHANNELS, numbered
from openrooms_usd.rendering.contract import Image, View
from openrooms_usd.rendering.estimates import Halves
from openrooms_usd.rendering.halves import KeptHalves

Pixels = NDArray[Any]
Rule = tuple[tuple[str, ...], Callable[..., Pixels]]


def lambertian(base_color: Pixels, metallic: Pixels, irradiance: Pixels) -> Pixels:
    """base_color (1 - metallic) / pi x irradiance, (H, W, 3) nits."""
    return np.asarray(base_color * (1.0 - metallic) * irradiance / np.pi)


def _rest(*parts: Pixels) -> Pixels:
    """The first ones but the last, which is the Lambertian part."""
    *wholes, diffuse = parts
    return np.asarray(sum(wholes[1:], wholes[0]) - diffuse)


# What each is made of: the channel of the Lambertian part is made before those that need it.
RULES: Final[dict[str, Rule]] = {
    "diffuse": (("base_color", "metallic", "irradiance"), lambertian),
    "specular": (("direct", "indirect", "diffuse"), _rest),
    "residual": (("radiance", "diffuse"), _rest),
    "irradiance_unoccluded_i": (
        ("irradiance_i", "unoccluded_i", "direct_i"),
        lambda whole, free, direct: whole + free - direct,
    ),
}


def derivable(given: tuple[str, ...]) -> tuple[str, ...]:
    """The channels that can be made of what a renderer gives."""
    found: list[str] = []
    for name, (needed, _) in RULES.items():
        if name not in given and {*needed} <= {*given, *found}:
            found.append(name)
    return tuple(found)


class Shading:
    """Makes the channels of the rules that are asked for.

    Args:
        given: What the renderer gives by itself: that is better than a rule.
    """

    def __init__(self, given: Collection[str]) -> None:
        self._rules = {name: rule for name, rule in RULES.items() if name not in given}

    def makes(self, channels: tuple[str, ...]) -> bool:
        """Whether it makes any of these channels."""
        return not self._rules.keys().isdisjoint(channels)

    def needs(self, channels: tuple[str, ...]) -> tuple[str, ...]:
        """The channels to render so that these can be written."""
        needed = set(channels)
        for name, (sources, _) in reversed(self._rules.items()):
            if name in needed:
                needed = (needed - {name}) | set(sources)
        return tuple(name for name in CHANNELS if name in needed)

    def complete(self, view: View, channels: tuple[str, ...]) -> View:
        """The view with the requested channels, and without sources that were not requested.

        Args:
            view: What was rendered by `needs`.
            channels: Names of single images.
        """
        images = dict(view.images)
        lights = sum(name.startswith("irradiance_") and name[11:].isdigit() for name in images)
        for name, (sources, rule) in self._rules.items():
            each = range(lights) if name.endswith("_i") else (None,)
            for light in each:
                _make(images, name, sources, rule, light)
        return replace(view, images={name: images[name] for name in channels})


def _make(
    images: dict[str, Image],
    name: str,
    sources: tuple[str, ...],
    rule: Callable[..., Pixels],
    light: int | None,
) -> None:
    """Add one image, where all that it is made of is there."""

    def single(channel: str) -> str:
        return channel if light is None else numbered(channel, light)

    parts = [images.get(single(source)) for source in sources]
    if not all(parts):
        return
    began = time.perf_counter()
    whole = [part for part in parts if part is not None]
    pixels = np.asarray(rule(*(part.pixels for part in whole)), dtype=np.float32)
    lit = [part for part in whole if part.error != 0.0]
    halves = _halves(rule, whole) if all(part.halves for part in lit) else None
    images[single(name)] = Image(
        pixels,
        min(part.samples for part in lit or whole),
        time.perf_counter() - began,
        halves.error if halves else None,
        max(part.replaced for part in whole),
        KeptHalves.made(pixels, halves) if halves else None,
        robust_error=halves.robust_error if halves else None,
    )


def _halves(rule: Callable[..., Pixels], parts: Sequence[Image]) -> Halves | None:
    """The rule on each half; what one ray gives is the same in both."""
    counts = [part.halves.samples for part in parts if part.halves]
    if not counts:
        return None
    known = [part.halves.halves if part.halves else None for part in parts]
    a, b = (
        rule(
            *(
                getattr(pair, side) if pair else part.pixels
                for part, pair in zip(parts, known, strict=True)
            )
        )
        for side in ("a", "b")
    )
    return Halves(a, b, min(counts))
