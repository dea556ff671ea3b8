"""How honest estimated errors are: how often a true one is more than twice what the render says."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from benchmarks.light.bias import Pair, bias_of, mse_of, robust_of
from benchmarks.light.hard import CASES
from benchmarks.light.pictures import Section, Setting, section, truth_of
from benchmarks.light.rooms import BOUNCES, ROOMS, Room, first
from benchmarks.light.sessions import OpenedRoom, Target, methods_of
from openrooms_usd.channels import CHANNELS, RENDERED, each
from openrooms_usd.rendering import Image
from openrooms_usd.rendering.estimates import estimate, relative_mse, robust_error

_FIGURES: Final = {"relative MSE": relative_mse, "robust": robust_error}
_SAMPLES: Final = (4, 16, 64)
_HONEST_FACTOR: Final = 2.0
# What a reference may be off itself, as a part of the error that is measured against it.
_REFERENCE_SHARE: Final = 0.25


@dataclass(frozen=True)
class _Case:
    """One picture: an estimate over the truth by figure; none where there is no estimate."""

    room: str
    channel: str
    samples: int
    ratios: Mapping[str, float | None]


def honesty(setting: Setting) -> Section:
    """Every channel of every room; each light of a channel has a part of its weight."""
    size, many = ((16, 12), 32) if setting.quick else ((32, 24), 512)
    names = setting.chosen({**ROOMS, **CASES})
    cases = [case for name in names for case in _cases(setting, name, size, many)]
    ways: dict[str, Sequence[Any]] = {
        "channel": sorted({case.channel for case in cases}, key=LIT.index),
        "samples": sorted({case.samples for case in cases}),
        "room": names,
    }
    rows = [_row("all", "all", cases)]
    rows += [
        _row(way, value, [case for case in cases if getattr(case, way) == value])
        for way, values in ways.items()
        for value in values
    ]
    reached = (
        Target(f"{figure}: truth above twice the estimate, %", 5.0, rows[0][f"{figure}: above, %"])
        for figure in _FIGURES
    )
    return section(rows, reached)


def _cases(setting: Setting, name: str, size: tuple[int, int], many: int) -> Iterator[_Case]:
    found = ROOMS.get(name) or CASES[name]
    bounces = CASES[name].bounces if name in CASES else BOUNCES
    room = Room(found.build(setting.folder), *size, bounces)
    grid = (2, 2)
    truth, opened = truth_of(setting, room, LIT, many, grid=grid), OpenedRoom(room)
    for samples in _SAMPLES[: 1 if setting.quick else None]:
        images = opened.shot(LIT, samples, seed=samples, grid=grid).images
        for channel in LIT:
            for single in each((channel,), len(opened.opened.lights)):
                ratios = _ratios(images[single], truth[single])
                if ratios:
                    yield _Case(name, channel, samples, ratios)


def _ratios(image: Image, truth: Pair) -> dict[str, float | None]:
    """An estimate over the truth by figure, of those that the reference can tell."""
    reference = 0.5 * (truth[0].astype(np.float64) + truth[1])
    own = estimate(*truth)
    stated = {
        "relative MSE": (image.error, own.relative_mse),
        "robust": (image.robust_error, own.robust),
    }
    ratios: dict[str, float | None] = {}
    for figure, (said, its_own) in stated.items():
        made = _FIGURES[figure](image.pixels, reference)
        if its_own is not None and made > 0.0 and its_own <= _REFERENCE_SHARE * made:
            ratios[figure] = None if said is None else said / made
    return ratios


def _row(way: str, value: Any, cases: list[_Case]) -> dict[str, Any]:
    row: dict[str, Any] = {"by": way, "which": value, "pictures": len(cases)}
    for figure in _FIGURES:
        groups: defaultdict[tuple[str, str, int], list[float]] = defaultdict(list)
        silent = judged = 0
        for case in cases:
            if figure in case.ratios:
                ratio, judged = case.ratios[figure], judged + 1
                if ratio is None:
                    silent += 1
                else:
                    groups[case.room, case.channel, case.samples].append(ratio)
        above = [np.mean(np.array(group) * _HONEST_FACTOR < 1.0) for group in groups.values()]
        medians = [np.median(group) for group in groups.values()]
        row |= {
            f"{figure}: above, %": float(100 * np.mean(above)) if above else None,
            f"{figure}: estimate / truth": float(np.median(medians)) if medians else None,
            f"{figure}: no estimate, %": 100 * silent / judged if judged else None,
        }
    return row


# Every channel of light, by every method: its true error, the estimated one, and its bias.

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


# Rooms that are hard to light, by every method: noise, bias, and whether all is finite.

_ASKED = ("radiance",)


def hard(setting: Setting) -> Section:
    """Every room that is hard to light."""
    size, samples, many = ((24, 18), 4, 16) if setting.quick else ((48, 36), 64, 1024)
    rows = []
    for name in first(setting.chosen(CASES) if setting.rooms else tuple(CASES), setting.quick, 3):
        case = CASES[name]
        room = Room(case.build(setting.folder), *size, case.bounces)
        truth = truth_of(setting, room, _ASKED, many)["radiance"]
        for method in methods_of(room):
            opened = OpenedRoom(room, method)
            shots = [opened.shot(_ASKED, samples, seed=seed) for seed in (11, 12)]
            images = [shot.images["radiance"] for shot in shots]
            found: Pair = images[0].pixels, images[1].pixels
            bias = bias_of(found, truth)
            rows.append(
                {
                    "case": name,
                    "condition": case.condition,
                    "method": method,
                    "samples": samples,
                    "s": shots[1].seconds,
                    "estimated": float(np.mean([image.error or 0.0 for image in images])),
                    "relative MSE": float(np.mean([mse_of(x, truth) for x in found])),
                    "robust error": float(np.mean([robust_of(x, truth) for x in found])),
                    **bias.columns,
                    "finite": "yes" if all(np.isfinite(x).all() for x in found) else "NO",
                    "replaced pixels": sum(image.replaced for image in images),
                }
            )
    return section(rows)
