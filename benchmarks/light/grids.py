"""Hemispheres on a grid: the paper's estimator beside every method, at equal error.

Errors are measured on a coarse grid; seconds are those of the full one: of the reference, whose
seconds grow with its paths, extrapolated from the coarse one.
"""

import time
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from benchmarks.light import pictures
from benchmarks.light.bias import Pair, bias_of, mse_of, robust_of
from benchmarks.light.pictures import Section, Setting, section, truth_of
from benchmarks.light.rooms import ROOMS, Room
from benchmarks.light.sessions import Cost, OpenedRoom, Target, methods_of
from openrooms_usd.description.rendering import DEFAULT_GRID, REFERENCE
from openrooms_usd.geometry import spherical_gaussians
from openrooms_usd.geometry.hemisphere import untiled

_ASKED: Final = ("environment", "environment_direct")
_ROOMS: Final = ("bedroom", "living room", "plain")
# Of the paper, in each cell.
_PAPER: Final = 50
# One sample of a cell for so many of a pixel.
_PIXEL_SAMPLES: Final = 16
_THEIRS: Final = "the paper's"
_VIEWS: Final = 20
# A bias in luminance is measured in so many by so many cells together.
_TILE_CELLS: Final = 8


def grids(setting: Setting) -> Section:
    """Error, bias and seconds of the grid's hemispheres."""
    coarse, full, many = ((12, 9), DEFAULT_GRID, 192)
    counts = (1, 4, _PAPER)
    if setting.quick:
        coarse, full, many, counts = (3, 2), (8, 6), 4, (1, 2)
    rows: list[dict[str, Any]] = []
    for name in setting.chosen(_ROOMS):
        room = Room(ROOMS[name].build(setting.folder), 64, 48)
        truth = truth_of(setting, room, _ASKED, many * _PIXEL_SAMPLES, grid=coarse)
        alone = pictures.hemispheres(room, full)[1]
        paper: float | None = None
        for method in methods_of(room):
            reference = method == REFERENCE
            opened = OpenedRoom(room, method)
            for samples in (counts[0], counts[-1]) if reference else counts[:-1]:
                cost = _cost(opened, samples, coarse, full, reference)
                if reference:
                    paper = cost.views(1)
                rows.append(
                    {
                        "room": name,
                        "method": _THEIRS if reference else method,
                        "samples a cell": samples,
                        "s, one view": cost.views(1),
                        f"s, of {_VIEWS} views": cost.views(_VIEWS),
                        "s, rays alone": alone,
                        "paper / one view": (paper or 0.0) / cost.views(1),
                        "further view / rays": cost.view / alone,
                    }
                    | _errors(opened, samples, coarse, truth)
                )
    return section(rows, _targets(rows))


def _targets(rows: Sequence[dict[str, Any]]) -> Iterator[Target]:
    """Of every method but the paper's, with the fewest samples that reach the paper's error."""
    for name in dict.fromkeys(row["room"] for row in rows):
        *_, paper = (row for row in rows if row["room"] == name and row["method"] == _THEIRS)
        ours = [row for row in rows if row["room"] == name and row["method"] != _THEIRS]
        good = [row for row in ours if row["all: robust"] <= paper["all: robust"]]
        best = good[0] if good else None
        title = f"grid, {name}: "
        yield Target(
            f"{title}the paper's {paper['samples a cell']} samples over one view at their error",
            30.0,
            best and best["paper / one view"],
            at_least=True,
        )
        for row in good[:1] or ours[-1:]:
            yield Target(f"{title}further view over its rays", 2.0, row["further view / rays"])
            yield Target(f"{title}bias, %", 1.0, row["bias, %"])
            yield Target(f"{title}bias of the worst tenth, %", 3.0, row["worst tenth, %"])


def _cost(
    opened: OpenedRoom, samples: int, coarse: tuple[int, int], full: tuple[int, int], grows: bool
) -> Cost:
    """Of the full grid; measured on the coarse one where it grows with the number of paths."""
    asked = samples * _PIXEL_SAMPLES
    if not grows:
        return opened.cost(_ASKED, asked, views=1, grid=full)
    seconds = opened.cost(_ASKED, asked, views=1, grid=coarse).view
    return Cost(0.0, float(seconds * np.prod(full) / np.prod(coarse)))


def _errors(
    opened: OpenedRoom, samples: int, grid: tuple[int, int], truth: Mapping[str, Pair]
) -> dict[str, Any]:
    asked = samples * _PIXEL_SAMPLES
    found = [opened.shot(_ASKED, asked, seed=seed, grid=grid).pixels for seed in (11, 12)]
    errors: dict[str, Any] = {}
    for name in _ASKED:
        pair: Pair = found[0][name], found[1][name]
        short = name.removeprefix("environment_").removeprefix("environment") or "all"
        errors[f"{short}: relative MSE"] = float(np.mean([mse_of(x, truth[name]) for x in pair]))
        errors[f"{short}: robust"] = float(np.mean([robust_of(x, truth[name]) for x in pair]))
    pair = found[0]["environment"], found[1]["environment"]
    apart = bias_of(pair, truth["environment"], _TILE_CELLS)
    return errors | apart.columns


# Spherical Gaussians of hemispheres: how soon they are fitted, and what they leave.
#
# Hemispheres are those of a coarse grid, one sample a cell; seconds are those of a full one.

_GRID: Final = 40, 30
# One sample of a cell for so many of a pixel.


def fits(setting: Setting) -> Section:
    """Seconds and errors of fits, by the method that the hemispheres are rendered by."""
    rows: list[dict[str, Any]] = []
    for name in setting.chosen(_ROOMS):
        room = Room(ROOMS[name].build(setting.folder), 64, 48)
        for method in methods_of(room):
            grid = (4, 3) if setting.quick else _GRID
            shot = OpenedRoom(room, method).shot(("environment",), _PIXEL_SAMPLES, grid=grid)
            light = untiled(shot.pixels["environment"])
            light = light[light.any(axis=(2, 3, 4))]
            began = time.process_time()
            lobes = spherical_gaussians.fit(light)
            each = (time.process_time() - began) / len(light)
            error = np.sort(spherical_gaussians.error(light, lobes))
            worst = error[-(len(error) + 9) // 10 :]
            rows.append(
                {
                    "room": name,
                    "method": method,
                    "hemispheres": len(light),
                    "s of a full grid": each * DEFAULT_GRID[0] * DEFAULT_GRID[1],
                    "error: mean": float(error.mean()),
                    "median": float(np.median(error)),
                    "worst tenth": float(worst.mean()),
                }
            )
    return section(
        rows,
        [
            Target(
                f"fits of a full grid, {row['room']}, {row['method']}, s",
                40.0,
                row["s of a full grid"],
            )
            for row in rows
        ],
    )
