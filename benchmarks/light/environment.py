"""Hemispheres on a grid by both techniques of the paper, and by one alone."""

from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.light.rooms import REFERENCE_SEED, ROOMS, Pictures, Room, generated, stopwatch
from benchmarks.light.section import Section, Setting, section
from openrooms_usd.render.estimates import relative_mse, robust_error


def environment(setting: Setting) -> Section:
    """The grid of hemispheres by both techniques, and by one alone."""
    from orusd_mitsuba.transport import incident, paths
    from orusd_mitsuba.transport.path_tracing import trace

    grid, counts, many = ((3, 2), (1,), 4) if setting.quick else ((12, 9), (1, 4), 128)
    stage = (
        ROOMS["plain"].build(setting.folder)
        if setting.quick
        else generated("bedroom", 1, setting.folder)
    )
    room = Room(stage, 64, 48)
    integrator = _hemispheres(room, grid)
    truth = np.asarray(mean_around(integrator, many, REFERENCE_SEED))
    rows = []

    sample_lights = incident._sample_lights

    def alone(*args: Any) -> None:
        *before, _begun, numbers, prefix = args
        trace(*before, None, numbers, prefix)

    for title, only in (("both, as the paper", False), ("hemisphere alone", True)):
        for samples in counts:
            with (
                patch.object(paths, "trace", alone if only else trace),
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
    return section(rows)


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
