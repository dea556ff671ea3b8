"""Light: how soon it is right.

radiance: relative MSE against seconds of Mitsuba's `path` with its lights sampled evenly, `path`
with sampling weights by the flux that each light brings, and ours, in rooms plain, furnished and
hard. The last column is the error of ours over that of the better `path`, at equal time.
channels: every channel of light: seconds, the error estimated by the renderer, and the true one,
against a reference of another seed; of channels that there are for each light, the mean over them.
environment: hemispheres on a grid. Ours is the estimator of the OpenRooms paper, light sampling and
hemisphere sampling combined by the power heuristic; beside it stands hemisphere sampling alone.
growth: seconds for a million paths, with the number of lights, pixels and triangles.
hard: rooms that are hard to light: estimated error, whether all is finite, pixels replaced.

Seconds are those of all cores together. Relative MSE is the mean over pixels of (x - ref)^2 /
(ref^2 + 0.01 M^2) for each colour, M the mean of the reference in that colour, and the mean of the
three. The robust error is the same with every pixel's part capped at 1.
"""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from unittest.mock import patch

import click
import numpy as np

from benchmarks.light import hard as hard_light
from benchmarks.light.rooms import (
    ROOMS,
    Pictures,
    Room,
    boxes,
    first,
    generated,
    mean_of,
    stopwatch,
)
from benchmarks.report import publish, table
from openrooms_usd.channels import CHANNELS, each
from openrooms_usd.render import RenderRequest
from openrooms_usd.render.estimates import relative_error, relative_mse, robust_error
from openrooms_usd.render.opened import open_with

# References begin here; far from the seeds that are compared with them.
_REFERENCE: Final = 1_000_000


@dataclass(frozen=True)
class Section:
    """A part of the benchmark: numbers for programs, and text for people."""

    data: Any
    markdown: str


def _section(rows: list[dict[str, Any]]) -> Section:
    return Section(rows, table(tuple(rows[0]), [list(row.values()) for row in rows]))


@click.command(help=__doc__)
@click.option("--section", "chosen", multiple=True, help="Repeatable; all by default.")
@click.option("--quick", is_flag=True, help="Small pictures, few samples, few rooms.")
@click.option("--json", "target", type=click.Path(path_type=Path), help="Where to write numbers.")
def main(chosen: tuple[str, ...], quick: bool, target: Path | None) -> None:
    with tempfile.TemporaryDirectory() as folder:
        sections = {name: SECTIONS[name](quick, Path(folder)) for name in chosen or SECTIONS}
    text = "\n\n".join(f"## {name}\n\n{section.markdown}" for name, section in sections.items())
    publish("light", {name: section.data for name, section in sections.items()}, text, target)


# Radiance.


def radiance(quick: bool, folder: Path) -> Section:
    """Three estimators at several numbers of samples."""
    size, counts, many = ((32, 24), (2, 4), 32) if quick else ((96, 72), (8, 32), 1024)
    rows = []
    for name in first(tuple(ROOMS), quick):
        room = Room(ROOMS[name].build(folder), *size)
        integrators = {
            "path": room.theirs(tuned=False),
            "path, tuned": room.theirs(tuned=True),
            "ours": room.ours,
        }
        reference = mean_of(room.ours, many, _REFERENCE)
        found = {
            key: _paced(integrator, counts, reference) for key, integrator in integrators.items()
        }
        cost = {key: measured[-1][2] * measured[-1][1] for key, measured in found.items()}
        for key, measured in found.items():
            ratio = cost["ours"] / min(cost["path"], cost["path, tuned"]) if key == "ours" else None
            for samples, seconds, error, robust in measured:
                last = ratio if samples == counts[-1] else None
                rows.append({"room": name, "condition": ROOMS[name].condition, "estimator": key,
                             "samples": samples, "seconds": seconds, "relative MSE": error,
                             "robust error": robust, "to path": last})  # fmt: skip
    return _section(rows)


def _paced(
    integrator: Any, counts: tuple[int, ...], reference: Pictures, repeats: int = 4
) -> list[tuple[int, float, float, float]]:
    """Samples, seconds, relative MSE and robust error, each the mean of several pictures."""
    integrator(1, 0)
    found = []
    for samples in counts:
        mean_of(integrator, samples, 0)  # Compiles what depends on the size.
        seconds: list[float] = []
        pictures = []
        for number in range(repeats):
            with stopwatch(seconds):
                pictures.append(mean_of(integrator, samples, 1000 * samples + 100 * number))
        errors, robust = (
            float(np.mean([figure(picture, reference) for picture in pictures]))
            for figure in (relative_mse, robust_error)
        )
        found.append((samples, float(np.mean(seconds)), errors, robust))
    return found


# Channels.


def channels(quick: bool, folder: Path) -> Section:
    """Each channel by itself, from one opened stage."""
    from openrooms_usd import adapters

    size, samples, many = ((24, 18), 4, 16) if quick else ((64, 48), 32, 512)
    stage = ROOMS["plain"].build(folder) if quick else generated("bedroom", 1, folder)
    session = open_with(adapters.load(adapters.RENDERERS, "mitsuba"), stage)
    lit = [name for name, c in CHANNELS.items() if c.kind == "light" and _rendered(name)]
    rows = []
    for name in first(lit, quick, 3):
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
    return _section(rows)


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


# The environment grid.


def environment(quick: bool, folder: Path) -> Section:
    """The grid of hemispheres by both techniques, and by one alone."""
    from orusd_mitsuba.transport import incident
    from orusd_mitsuba.transport.path_tracing import trace

    grid, counts, many = ((3, 2), (1,), 4) if quick else ((12, 9), (1, 4), 128)
    stage = ROOMS["plain"].build(folder) if quick else generated("bedroom", 1, folder)
    room = Room(stage, 64, 48)
    integrator = _hemispheres(room, grid)
    truth = np.asarray(mean_around(integrator, many, _REFERENCE))
    rows = []

    sample_lights = incident._sample_lights

    def alone(*args: Any, begun: Any = None, **how: Any) -> None:
        trace(*args, **how)

    for title, only in (("both, as the paper", False), ("hemisphere alone", True)):
        for samples in counts:
            with (
                patch.object(incident, "trace", alone if only else trace),
                patch.object(incident, "_sample_lights", _nothing if only else sample_lights),
            ):
                integrator(samples, 1)
                seconds: list[float] = []
                with stopwatch(seconds):
                    planes = integrator(samples, 2)
            for row, name in enumerate(("environment_direct", "environment")):
                error = relative_mse(planes[row], truth[row])
                robust = robust_error(planes[row], truth[row])
                rows.append({"estimator": title, "channel": name, "samples a cell": samples,
                             "seconds": seconds[0], "relative MSE": error,
                             "robust error": robust})  # fmt: skip
    return _section(rows)


def _nothing(*args: Any) -> None:
    """No light is looked for."""


def _hemispheres(room: Room, grid: tuple[int, int]) -> Any:
    from dataclasses import replace

    from orusd_mitsuba.tracer import MitsubaTracer
    from orusd_mitsuba.transport.hemispheres import HemisphereIntegrator, coarse

    seen = replace(room.camera, K=coarse(room.camera, room.size, grid))
    tracer = MitsubaTracer(room.scene, room.built)
    return HemisphereIntegrator(room.scene, room.built, room.index, tracer, seen, grid, 8)


def mean_around(integrator: Any, samples: int, seed: int) -> Pictures:
    """Both planes of hemispheres."""
    passes = [integrator(min(samples, 8), seed + n) for n in range(max(1, samples // 8))]
    return np.asarray(np.mean(passes, axis=0, dtype=np.float64))


# Growth.


def growth(quick: bool, folder: Path) -> Section:
    """Seconds of a million paths."""
    size = (32, 24) if quick else (96, 72)
    many, wide, full = ((1, 5), (1,), (10,)) if quick else ((1, 10, 50), (1, 2, 4), (10, 100, 1000))
    lamps = [("lights", n, Room(hard_light.many(n), *size)) for n in many]
    plain = ROOMS["plain"].build(folder)
    areas = [("pixels", n * n * size[0] * size[1], Room(plain, n * size[0], n * size[1]))
             for n in wide]  # fmt: skip
    solids = [("triangles", 12 * n, Room(boxes(n), *size)) for n in full]
    rows = []
    for what, count, room in (*lamps, *areas, *solids):
        samples = 4 if quick else 16
        reference = mean_of(room.ours, 8 * samples, _REFERENCE)
        ((_, seconds, error, robust),) = _paced(room.ours, (samples,), reference, 2)
        paths = samples * room.size[0] * room.size[1] / 1e6
        rows.append({"grows": what, "count": count, "seconds for 1e6 paths": seconds / paths,
                     "relative MSE": error, "robust error": robust})  # fmt: skip
    return _section(rows)


# Hard cases.


def hard(quick: bool, folder: Path) -> Section:
    """Every room that is hard to light."""
    size, samples = ((24, 18), 4) if quick else ((48, 36), 32)
    rows = []
    for name in first(tuple(hard_light.CASES), quick, 3):
        case = hard_light.CASES[name]
        room = Room(case.build(folder), *size, case.bounces)
        a, b = (mean_of(room.ours, samples, seed) for seed in (0, 100))
        rows.append({"case": name, "condition": case.condition, "samples": 2 * samples,
                     "estimated error": relative_error(a, b), "mean": float((a + b).mean() / 2),
                     "finite": "yes" if np.isfinite(a + b).all() else "NO",
                     "replaced pixels": int(room.ours.broken.sum())})  # fmt: skip
    return _section(rows)


SECTIONS: Final[dict[str, Callable[[bool, Path], Section]]] = {
    "radiance": radiance,
    "channels": channels,
    "environment": environment,
    "growth": growth,
    "hard": hard,
}

if __name__ == "__main__":
    main()
