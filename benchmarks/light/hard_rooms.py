"""Rooms that are hard to light, by every method: noise, bias, and whether all is finite."""

import numpy as np

from benchmarks.light.bias import Pair, bias_of, mse_of, robust_of
from benchmarks.light.hard import CASES
from benchmarks.light.pictures import truth_of
from benchmarks.light.rooms import Room, first
from benchmarks.light.section import Section, Setting, section
from benchmarks.light.sessions import OpenedRoom, methods_of

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
