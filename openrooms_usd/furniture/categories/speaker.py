"""Loudspeakers: a box with drivers, a tower, a bar, a small one wrapped in cloth."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.construction import ANY, filled, row
from openrooms_usd.furniture.joinery.boards import board, corners
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style, numbered
from openrooms_usd.furniture.joinery.posing import facing
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.curves import filleted, rectangle
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder, lathe, sphere
from openrooms_usd.geometry.sweeps import extrude


def _cone(radius: float) -> Mesh:
    """A driver along Z: a rubber surround, a cone that goes down, a cap in its middle."""
    r = radius
    profile = [
        (0.0, -0.3 * r),
        (0.94 * r, -0.3 * r),
        (0.94 * r, 0.0),
        (0.9 * r, 0.03 * r),
        (0.84 * r, 0.045 * r),
        (0.78 * r, 0.02 * r),
        (0.36 * r, -0.2 * r),
        (0.32 * r, -0.15 * r),
        (0.2 * r, -0.09 * r),
        (0.0, -0.07 * r),
    ]
    return lathe(profile, crease=50.0)


def _ring(radius: float) -> Mesh:
    """The rim that holds a driver."""
    r = radius
    return lathe(
        [(0.93 * r, 0.0), (1.08 * r, 0.0), (1.08 * r, 0.025 * r), (0.95 * r, 0.045 * r)],
        segments=36,
    )


def _drivers(
    rows: list[tuple[float, float]], front: float, x: float = 0.0
) -> tuple[list[Mesh], list[Mesh]]:
    """Drivers (height, radius) above one another, seen from the front: cones and their rims."""
    cones = [facing(_cone(radius), (x, front - 0.002, z)) for z, radius in rows]
    rims = [facing(_ring(radius), (x, front, z)) for z, radius in rows]
    return cones, rims


def bookshelf(size: Size, rng: np.random.Generator) -> Parts:
    """A wooden box with a woofer, a tweeter and a port."""
    width, depth, height = size
    front = -0.5 * depth + 0.012
    box = board((-0.5 * width, front, 0.0), (0.5 * width, 0.5 * depth, height), 0.004)
    woofer = min(0.4 * width, 0.26 * height)
    low = 0.06 * height + woofer
    tweeter = 0.38 * woofer
    cones, rims = _drivers(
        [(low + 0.1 * height, woofer), (height - 0.07 * height - 1.2 * tweeter, tweeter)], front
    )
    plate = board(
        (-0.46 * width, front - 0.012, 0.02 * height),
        (0.46 * width, front + 0.002, 0.03 * height),
        0.001,
    )
    port = facing(
        _ring(0.14 * width),
        (float(rng.choice([-1.0, 1.0])) * 0.28 * width, front, 0.04 * height + 0.16 * width),
    )
    hole = cylinder(0.13 * width, 0.0012, segments=28)
    hole = facing(hole, (port.extent[0] + port.extent[1]) * [0.5, 0.0, 0.5] + [0.0, front, 0.0])
    return {
        "body": box,
        **numbered("driver", cones),
        "rim": joined([*rims, port, hole]),
        "badge": plate,
    }


def covered(size: Size, rng: np.random.Generator) -> Parts:
    """A box whose front is hidden by a frame of cloth, a control knob below it."""
    width, depth, height = size
    front = -0.5 * depth + 0.014
    box = board((-0.5 * width, front, 0.0), (0.5 * width, 0.5 * depth, height), 0.006)
    low = float(rng.uniform(0.14, 0.2)) * height
    cloth = board(
        (-0.46 * width, front - 0.012, low), (0.46 * width, front + 0.002, 0.975 * height), 0.005
    )
    knob = cylinder(0.07 * width, 0.014, bevel=0.003, segments=28)
    trim = _ring(0.075 * width)
    at = (0.3 * width, front, 0.5 * low)
    badge = board(
        (-0.42 * width, front - 0.002, 0.46 * low),
        (-0.12 * width, front + 0.002, 0.54 * low),
        0.0008,
    )
    return {
        "body": box,
        "grille": cloth,
        "button": facing(knob, at),
        "rim": facing(trim, at),
        "badge": badge,
    }


def tower(size: Size, rng: np.random.Generator) -> Parts:
    """A slim column on a plinth, with three or four drivers."""
    width, depth, height = size
    plinth = 0.03
    front = -0.5 * depth + 0.03
    outline = filleted(rectangle(width - 0.05, depth - 0.04), 0.03, closed=True)
    column = extrude(outline, height - plinth, bevel=0.003, base=plinth).moved((0, 0.01, 0))
    woofer = 0.38 * (width - 0.05)
    count = int(rng.integers(2, 4))
    rows = [(height - 0.3 - (2.3 * i + 1.2) * woofer, woofer) for i in range(count)]
    rows = [(z, r) for z, r in rows if z - 1.1 * r > plinth + 0.01]
    cones, rims = _drivers(
        [*rows, (height - 0.24, 0.8 * woofer), (height - 0.1, 0.35 * woofer)], front
    )
    spread = corners(0.5 * width - 0.02, 0.5 * depth - 0.02)
    spikes = [cylinder(0.014, 0.016, bevel=0.003, segments=16, base=(*at, 0.0)) for at in spread]
    base = board(
        (-0.5 * width, -0.5 * depth, 0.012), (0.5 * width, 0.5 * depth, plinth + 0.002), 0.006
    )
    return {
        "body": column,
        **numbered("driver", cones),
        "rim": joined(rims),
        "base": base,
        **numbered("foot", spikes),
    }


def bar(size: Size, rng: np.random.Generator) -> Parts:
    """A long bar to lie below a television, cloth over its front."""
    width, depth, height = size
    cap = min(0.04, 0.08 * width)
    cloth = board(
        (-0.5 * width + cap, -0.5 * depth, 0.006),
        (0.5 * width - cap, 0.45 * depth, height),
        0.25 * height,
    )
    ends = [
        board(
            (x - 0.5 * cap - 0.002, -0.5 * depth + 0.002, 0.005),
            (x + 0.5 * cap + 0.002, 0.5 * depth, height - 0.001),
            0.22 * height,
        )
        for x in (-0.5 * (width - cap) + 0.002, 0.5 * (width - cap) - 0.002)
    ]
    feet = [
        board((x - 0.03, -0.3 * depth, 0.0), (x + 0.03, 0.3 * depth, 0.01))
        for x in (-0.36 * width, 0.36 * width)
    ]
    keys = [
        cylinder(
            0.007,
            0.003,
            bevel=0.001,
            segments=16,
            base=(0.024 * (i - 1.5), 0.1 * depth, height - 0.002),
        )
        for i in range(int(rng.integers(3, 5)))
    ]
    low = [mesh.moved((0.0, 0.0, -0.0015)) for mesh in keys]
    return {
        "grille": cloth,
        **numbered("body", ends),
        **numbered("foot", feet),
        "button": joined(low),
    }


def wrapped(size: Size, rng: np.random.Generator) -> Parts:
    """A small round one in cloth, with a touch plate on top."""
    width, depth, height = size
    radius = 0.5 * min(width, depth)
    t = np.linspace(0.0, 1.0, 14)
    belly = float(rng.uniform(0.0, 0.1))
    shape = radius * (1.0 - belly + belly * np.sin(np.pi * t)) * (1.0 - 0.06 * (2 * t - 1) ** 8)
    shape *= radius / shape.max()
    side = np.stack([shape, 0.008 + (height - 0.014) * t], axis=1)
    cloth = lathe([(0.0, 0.008), *side, (0.0, height - 0.006)], segments=44)
    top = lathe(
        [
            (0.0, height - 0.012),
            (0.93 * radius, height - 0.012),
            (0.91 * radius, height - 0.004),
            (0.82 * radius, height),
            (0.0, height - 0.002),
        ],
        segments=44,
    )
    dots = [
        sphere(0.0035, segments=10, squash=0.5, center=(x, -0.5 * radius, height - 0.0022))
        for x in (-0.016, 0.0, 0.016)
    ]
    base = cylinder(0.86 * radius, 0.012, bevel=0.003, segments=40)
    return {"grille": cloth, "body": top, "base": base, "button": joined(dots)}


CATEGORY: Final = BuiltCategory(
    description="a loudspeaker",
    size=(0.2, 0.26, 0.34),
    min_size=(0.06, 0.05, 0.04),
    max_size=(1.6, 0.6, 1.6),
    styles={
        "bookshelf": Style(bookshelf, lambda size: size[0] < 1.2 * size[2] < 0.9),
        "covered": Style(covered, lambda size: size[0] < 1.2 * size[2] < 0.9),
        "tower": Style(tower, lambda size: size[2] > 0.7, (0.26, 0.32, 1.05), mass_range=(12, 35)),
        "bar": Style(
            bar, lambda size: size[0] > 3.0 * size[2], (0.9, 0.1, 0.065), mass_range=(1.2, 5)
        ),
        "wrapped": Style(
            wrapped,
            lambda size: size[2] < 0.3 and size[0] < 0.3,
            (0.11, 0.11, 0.16),
            mass_range=(0.3, 5),
        ),
    },
    one_variant_per_room=True,
    support="surface",
    alternative_supports=("wall",),
    mass_range=(3, 10),
    words="loudspeaker speakers subwoofer",
    classes=Classes(openrooms45="speaker"),
    synsets=("03691459",),
    schemes=(
        scheme("black", steel="badge foot"),
        scheme("wood", black_plastic="rim", steel="badge foot", black="base"),
        scheme("black_plastic", upholstery="grille", needs="grille", weight=100.0),
    ),
    construction=(
        row("grille", filled(350), "weight"),
        row(ANY, filled(350), "weight"),
        row("driver", filled(4000), "weight"),
    ),
    placements=(on("shelf cabinet_top desk media_top", weight=0.25, max_groups=1),),
)
