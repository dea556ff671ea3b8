"""What Mitsuba makes of a stage, as users get it."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from pxr import Usd

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.rendering import RenderRequest
from orusd_mitsuba import MitsubaRenderer
from tests.opening import open_with

Pictures = dict[str, Array]
SIZE = (24, 18)
SEEDS = 12


def session_of(stage: Usd.Stage, *, default_light: bool = True, **options: Any) -> Any:
    """The session of a stage, with options of the renderer."""
    return open_with(MitsubaRenderer(), stage, options, default_light=default_light)


def shown(session: Any, *channels: str, **how: Any) -> Any:
    """One view: by ``/Camera`` and of 24 by 18 pixels, unless it says otherwise."""
    default = {"camera": "/Camera", "width": SIZE[0], "height": SIZE[1]}
    default |= {} if {"error", "seconds"} & set(how) else {"samples": 16}
    return session.render(RenderRequest(channels=channels, **(default | how)))


def pictures(
    session: Any, channels: Iterable[str], seeds: Iterable[int] = range(SEEDS), **how: Any
) -> Pictures:
    """(seeds, height, width, C) by name, of independent renders."""
    views = [shown(session, *channels, seed=seed, **how) for seed in seeds]
    return {
        name: np.stack([view.images[name].pixels for view in views]).astype(np.float64)
        for name in views[0].images
    }


def of_lights(found: Pictures, channel: str) -> list[Array]:
    """A channel of every light, by number."""
    stem = channel.removesuffix("i")
    return [found[f"{stem}{n}"] for n in range(len(found)) if f"{stem}{n}" in found]


def passes(integrator: Any, count: int = 12, samples: int = 16, seed: int = 100) -> Any:
    """(count, planes, height, width, 3) of independent passes of an integrator."""
    return np.stack([integrator(samples, seed + n) for n in range(count)]).astype(np.float64)


def radiance(session: Any, **how: Any) -> Floats:
    """(height, width, 3) of one view."""
    return np.asarray(shown(session, "radiance", **how).images["radiance"].pixels)
