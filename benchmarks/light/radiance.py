"""Radiance: error against seconds of Mitsuba's `path`, of the same tuned, and of ours."""

from typing import Any

import numpy as np

from benchmarks.light.rooms import REFERENCE_SEED, ROOMS, Pictures, Room, first, mean_of, stopwatch
from benchmarks.light.section import Section, Setting, section
from openrooms_usd.render.estimates import relative_mse, robust_error


def radiance(setting: Setting) -> Section:
    """Three estimators at several numbers of samples."""
    size, counts, many = ((32, 24), (2, 4), 32) if setting.quick else ((96, 72), (8, 32), 1024)
    rows = []
    for name in first(tuple(ROOMS), setting.quick):
        room = Room(ROOMS[name].build(setting.folder), *size)
        integrators = {
            "path": room.theirs(tuned=False),
            "path, tuned": room.theirs(tuned=True),
            "ours": room.ours,
        }
        reference = mean_of(room.ours, many, REFERENCE_SEED)
        found = {
            key: paced(integrator, counts, reference) for key, integrator in integrators.items()
        }
        cost = {key: measured[-1][2] * measured[-1][1] for key, measured in found.items()}
        for key, measured in found.items():
            ratio = cost["ours"] / min(cost["path"], cost["path, tuned"]) if key == "ours" else None
            for samples, seconds, error, robust in measured:
                last = ratio if samples == counts[-1] else None
                rows.append({"room": name, "condition": ROOMS[name].condition, "estimator": key,
                             "samples": samples, "seconds": seconds, "relative MSE": error,
                             "robust error": robust, "to path": last})  # fmt: skip
    return section(rows)


def paced(
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
