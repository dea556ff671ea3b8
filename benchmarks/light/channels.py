"""Every channel of light: its true error beside the one that the renderer estimates."""

import numpy as np

from benchmarks.light.rooms import ROOMS, first, generated, stopwatch
from benchmarks.light.section import Section, Setting, section
from openrooms_usd.channels import CHANNELS, each
from openrooms_usd.render import RenderRequest
from openrooms_usd.render.estimates import relative_mse, robust_error
from openrooms_usd.render.opened import open_with


def channels(setting: Setting) -> Section:
    """Each channel by itself, from one opened stage."""
    from openrooms_usd import adapters

    size, samples, many = ((24, 18), 4, 16) if setting.quick else ((64, 48), 32, 512)
    stage = (
        ROOMS["plain"].build(setting.folder)
        if setting.quick
        else generated("bedroom", 1, setting.folder)
    )
    session = open_with(adapters.load(adapters.RENDERERS, "mitsuba"), stage)
    lit = [name for name, c in CHANNELS.items() if c.kind == "light" and _rendered(name)]
    rows = []
    for name in first(lit, setting.quick, 3):
        grid = (4, 3) if CHANNELS[name].scope == "grid" else (8, 6)
        how = {"camera": session.cameras[0], "channels": (name,), "width": size[0],
               "height": size[1], "grid": grid}  # fmt: skip
        truth = session.render(RenderRequest(**how, samples=many, seed=9)).images
        session.render(RenderRequest(**how, samples=samples, seed=1))
        seconds: list[float] = []
        with stopwatch(seconds):
            images = session.render(RenderRequest(**how, samples=samples, seed=0)).images
        names = [one for one in each((name,), len(session.lights)) if truth[one].pixels.max() > 0]
        apart, robust = (
            [figure(images[one].pixels, truth[one].pixels) for one in names]
            for figure in (relative_mse, robust_error)
        )
        rows.append({
            "channel": name, "samples": samples, "seconds": seconds[0],
            "estimated error": _mean([images[one].error or 0.0 for one in names]),
            "true error": _mean(apart), "robust error": _mean(robust),
        })  # fmt: skip
    return section(rows)


def _mean(values: list[float]) -> float | None:
    """None where a channel is dark for every light."""
    return float(np.mean(values)) if values else None


def _rendered(name: str) -> bool:
    from orusd_mitsuba import render_passes

    every = (
        render_passes.RADIANCE,
        render_passes.IRRADIANCE,
        render_passes.DIRECT,
        render_passes.ENVIRONMENT,
    )
    return any(name in one.picks for one in every)
