"""Pictures of radiance: noise and bias against seconds, for every method, raw and denoised."""

from collections.abc import Mapping
from functools import cache
from typing import Any, Final

import numpy as np

from benchmarks.light import casting
from benchmarks.light.bias import Pair, bias_of, mse_of, robust_of
from benchmarks.light.rooms import REFERENCE_SEED, ROOMS, Room, stopwatch
from benchmarks.light.section import Section, Setting, section
from benchmarks.light.sessions import Cost, OpenedRoom, Shot, methods_of
from openrooms_usd.rendering.denoise import is_usable, load_denoiser
from openrooms_usd.rendering.estimates import robust_error

_ASKED: Final = ("radiance",)
_VIEWS: Final = 20
_SAMPLES: Final = (4, 16, 64)


def pictures(setting: Setting) -> Section:
    """Every method in rooms plain, furnished and hard."""
    size, many = ((32, 24), 16) if setting.quick else ((96, 72), 1024)
    rows: list[dict[str, Any]] = []
    for name in setting.chosen(ROOMS):
        room = Room(ROOMS[name].build(setting.folder), *size)
        truth = truth_of(setting, room, _ASKED, many)["radiance"]
        named = {"room": name, "condition": ROOMS[name].condition}
        for method in methods_of(room):
            opened = OpenedRoom(room, method)
            for samples in _SAMPLES[: 1 if setting.quick else None]:
                rows += [named | row for row in _measured(room, opened, samples, truth)]
        rows.append(
            named
            | dict.fromkeys(rows[-1])
            | named
            | {
                "method": "the reference itself",
                "samples": 2 * many,
                "robust error": robust_error(*truth) / 4.0,
            }
        )
    return section(rows)


def truth_of(
    setting: Setting, room: Room, channels: tuple[str, ...], samples: int, **how: Any
) -> Mapping[str, Pair]:
    """Both halves of the reference of channels, by image."""

    @cache
    def opened() -> OpenedRoom:
        return OpenedRoom(room)

    halves = setting.references.pair(
        room.scene,
        {"seen": room.seen, "channels": channels, "samples": samples, **how},
        lambda half: opened().shot(channels, samples, seed=REFERENCE_SEED + half, **how).pixels,
    )
    return {name: (halves[0][name], halves[1][name]) for name in halves[0]}


def _measured(room: Room, opened: OpenedRoom, samples: int, truth: Pair) -> list[dict[str, Any]]:
    """A row for the raw pictures, and one for them denoised."""
    method = opened.method
    shots = [opened.shot(_ASKED, samples, seed=seed, guides=True) for seed in (11, 12)]
    cost, rays = opened.cost(_ASKED, samples), casting.pixels(room, samples)
    raw = [shot.pixels["radiance"] for shot in shots]
    rows = [_row(method, samples, cost, rays, (raw[0], raw[1]), truth)]
    if is_usable():
        taken: list[float] = []
        clean = [denoised(shot, taken) for shot in shots]
        guided = Cost(cost.room, cost.view + taken[-1])
        rows.append(_row(f"{method}, denoised", samples, guided, rays, (clean[0], clean[1]), truth))
    return rows


def denoised(shot: Shot, seconds: list[float]) -> Any:
    """The radiance of a view, denoised; its seconds are added to a list."""
    with stopwatch(seconds):
        return load_denoiser().denoise(shot.pixels["radiance"], shot.guides)


def _row(
    method: str, samples: int, cost: Cost, rays: float, found: Pair, truth: Pair
) -> dict[str, Any]:
    apart = bias_of(found, truth)
    return {
        "method": method,
        "samples": samples,
        "s, one view": cost.views(1),
        f"s, of {_VIEWS} views": cost.views(_VIEWS),
        "s, rays alone": rays,
        "relative MSE": float(np.mean([mse_of(x, truth) for x in found])),
        "robust error": float(np.mean([robust_of(x, truth) for x in found])),
        **apart.columns,
    }
