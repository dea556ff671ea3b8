"""Spherical Gaussians of hemispheres: how soon they are fitted, and what they leave.

Hemispheres are those of a coarse grid, one sample a cell; seconds are those of a full one.
"""

import time
from typing import Any, Final

import numpy as np

from benchmarks.light.rooms import ROOMS, Room
from benchmarks.light.section import Section, Setting, section
from benchmarks.light.sessions import OpenedRoom, methods_of
from benchmarks.light.targets import Target
from openrooms_usd.description.rendering import DEFAULT_GRID
from openrooms_usd.geometry import spherical_gaussians
from openrooms_usd.geometry.hemisphere import untiled

_ROOMS: Final = ("bedroom", "living room", "plain")
_GRID: Final = 40, 30
# One sample of a cell for so many of a pixel.
_PIXEL_SAMPLES: Final = 16


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
