"""How honest estimated errors are: how often a true one is more than twice what the render says."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from benchmarks.light.bias import Pair
from benchmarks.light.channels import LIT
from benchmarks.light.hard import CASES
from benchmarks.light.pictures import truth_of
from benchmarks.light.rooms import BOUNCES, ROOMS, Room
from benchmarks.light.section import Section, Setting, section
from benchmarks.light.sessions import OpenedRoom
from benchmarks.light.targets import Target
from openrooms_usd.channels import each
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
