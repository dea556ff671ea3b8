"""Rooms that are hard to light: the estimated error, and whether all is finite."""

import numpy as np

from benchmarks.light.hard import CASES
from benchmarks.light.rooms import Room, first, mean_of
from benchmarks.light.section import Section, Setting, section
from openrooms_usd.render.estimates import relative_error


def hard(setting: Setting) -> Section:
    """Every room that is hard to light."""
    size, samples = ((24, 18), 4) if setting.quick else ((48, 36), 32)
    rows = []
    for name in first(tuple(CASES), setting.quick, 3):
        case = CASES[name]
        room = Room(case.build(setting.folder), *size, case.bounces)
        a, b = (mean_of(room.ours, samples, seed) for seed in (0, 100))
        rows.append({"case": name, "condition": case.condition, "samples": 2 * samples,
                     "estimated error": relative_error(a, b), "mean": float((a + b).mean() / 2),
                     "finite": "yes" if np.isfinite(a + b).all() else "NO",
                     "replaced pixels": int(room.ours.broken.sum())})  # fmt: skip
    return section(rows)
