"""Every channel of light, by every method: its true error, the estimated one, and its bias."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from benchmarks.light.bias import Pair, bias_of, mse_of, robust_of
from benchmarks.light.pictures import truth_of
from benchmarks.light.rooms import ROOMS, Room
from benchmarks.light.section import Section, Setting, section
from benchmarks.light.sessions import OpenedRoom, methods_of
from openrooms_usd.channels import CHANNELS, RENDERED, each
from openrooms_usd.rendering import Image

# Those that are light by colour: a part of it has no error of its own.
LIT: Final = tuple(
    name
    for name in RENDERED
    if CHANNELS[name].kind == "light" and len(CHANNELS[name].components) == 3
)
# A bias in luminance is measured in squares of so many pixels: the reference is no longer.
_TILE: Final = 4
_AGREEING: Final = 0.8
_COLUMNS: Final = (
    "estimated",
    "relative MSE",
    "robust error",
    "bias, %",
    "+-",
    "worst tenth, %",
    "+- ",
    "worst light: robust",
    "worst light: bias, %",
)


def channels(setting: Setting) -> Section:
    """All at once; of what there is for each light, the mean over them, and the worst of them."""
    size, samples, many = ((24, 18), 4, 16) if setting.quick else ((64, 48), 32, 1024)
    grid = (2, 2) if setting.quick else (8, 6)
    rows: list[dict[str, Any]] = []
    for name in setting.chosen(("bedroom",)):
        room = Room(ROOMS["plain" if setting.quick else name].build(setting.folder), *size)
        truth = truth_of(setting, room, LIT, many, grid=grid)
        for method in methods_of(room):
            opened = OpenedRoom(room, method)
            shots = [opened.shot(LIT, samples, seed=seed, grid=grid).images for seed in (11, 12)]
            for channel in LIT:
                of_lights = each((channel,), len(opened.opened.lights))
                shown = _lit(of_lights, truth)
                figures = [_figures(one, shots, truth[one]) for one in shown]
                named = {"method": method, "channel": channel, "samples": samples}
                rows.append(named | _summary(figures))
    return section(rows)


def _lit(names: Sequence[str], truth: Mapping[str, Pair]) -> list[str]:
    """Those that the reference knows well enough: its halves agree on how much light there is.

    A light that is seen by rare paths alone would need a far longer reference than the others.
    """
    known = []
    for name in names:
        means = [float(half.mean(dtype=np.float64)) for half in truth[name]]
        if max(means) > 0.0 and min(means) >= _AGREEING * max(means):
            known.append(name)
    return known


def _figures(name: str, shots: list[Mapping[str, Image]], truth: Pair) -> dict[str, float]:
    found: Pair = shots[0][name].pixels, shots[1][name].pixels
    bias = bias_of(found, truth, _TILE)
    return {
        "estimated": float(np.mean([shot[name].error or 0.0 for shot in shots])),
        "relative MSE": float(np.mean([mse_of(x, truth) for x in found])),
        "robust error": float(np.mean([robust_of(x, truth) for x in found])),
        **bias.columns,
    }


def _summary(lights: list[dict[str, float]]) -> dict[str, Any]:
    """The mean over lights, and what is worst among them; dashes where no light is there."""
    if not lights:
        return dict.fromkeys(_COLUMNS)
    means = {name: float(np.mean([light[name] for light in lights])) for name in lights[0]}
    worst = [max(abs(light[name]) for light in lights) for name in ("robust error", "bias, %")]
    several = len(lights) > 1
    return means | dict(zip(_COLUMNS[-2:], worst if several else (None, None), strict=True))
