"""Hats: a cap, one with a brim, a knitted one."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.joinery.posing import at_rest, oval
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.mesh import joined
from openrooms_usd.geometry.solids import cylinder, lathe
from openrooms_usd.geometry.sweeps import sheet


def brim(size: Size, rng: np.random.Generator) -> Parts:
    """A hat with a brim all round."""
    width, depth, height = size
    r, crown = 0.5 * min(width, depth), 0.56 * 0.5 * min(width, depth)
    hat = lathe(
        [
            (crown - 0.004, 0.012),
            (r, 0.0),
            (r + 0.0, 0.003),
            (crown + 0.012, 0.015),
            (crown + 0.002, 0.03),
            (0.92 * crown, 0.9 * height),
            (0.8 * crown, height),
            (0.3 * crown, 0.9 * height),
            (0.0, 0.89 * height),
            (0.0, 0.87 * height),
            (0.86 * crown, 0.86 * height),
        ],
        segments=36,
        crease=60.0,
    )
    band = lathe(
        [
            (crown - 0.001, 0.022),
            (crown + 0.004, 0.022),
            (crown + 0.001, 0.05),
            (crown - 0.004, 0.05),
        ],
        segments=36,
    )
    return {"hat": oval(hat, size), "band": oval(band, size)}


def cap(size: Size, rng: np.random.Generator) -> Parts:
    """A cap with a peak to the front."""
    width, depth, height = size
    r = 0.5 * width
    t = np.linspace(0.0, 0.5 * np.pi, 8)
    dome = [(r * np.cos(a) ** 0.8, 0.0075 + (height - 0.0135) * np.sin(a)) for a in t]
    dome[-1] = (0.0, dome[-1][1])
    inner = [(max(a - 0.003, 0.0), z - 0.003) for a, z in dome]
    shell = lathe([*dome, *inner[::-1]], segments=30, crease=60.0)
    knob = cylinder(0.008, 0.01, bevel=0.003, segments=12, base=(0.0, 0.0, height - 0.01))
    peak = depth - 2.0 * r + 0.05
    u, v = np.meshgrid(np.linspace(-1.0, 1.0, 11), np.linspace(0.0, 1.0, 5))
    x = 0.88 * r * u
    edge = np.sqrt(np.clip(r**2 - x**2, 0.0, None))
    y = -edge + 0.006 - (peak - 0.05) * v * (1.0 - np.abs(u) ** 2.4)
    z = 0.0075 - 0.0035 * v + 0.0 * u
    visor = sheet(np.stack([x, y, z], axis=-1)[::-1], 0.003)
    shift = (0.0, 0.5 * depth - r, 0.0)
    parts = {"hat": joined([shell, knob]).moved(shift), "visor": visor.moved(shift)}
    return at_rest(parts, size)


CATEGORY: Final = BuiltCategory(
    description="a hat",
    size=(0.3, 0.32, 0.13),
    min_size=(0.12, 0.12, 0.06),
    max_size=(0.5, 0.5, 0.3),
    styles={
        "brim": Style(brim),
        "cap": Style(cap, lambda size: size[0] < 0.9 * size[1], (0.18, 0.27, 0.12)),
    },
    support="surface",
    mass_range=(0.04, 0.4),
    words="cap baseball_cap hats caps",
    classes=Classes("cap", "otherprop", "apparel"),
    synsets=("02954340",),
    schemes=(
        scheme("coat_cloth", weight=2.0),
        scheme("rope", membrane="band", needs="band", weight=2.0),
    ),
    construction=(row(ANY, filled(250), "common"),),
    placements=(
        on("wardrobe_shelf shelf", "bedroom hallway", weight=0.4, pose="flat"),
        on("chair_seat cabinet_top bed_foot", clutter=2, weight=0.2, pose="flat", max_groups=1),
    ),
)
