"""Cushions to lean on: square ones, long rolls, round ones with a button."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.boards import FRONT
from openrooms_usd.furniture.joinery.cloth import pillow as filled
from openrooms_usd.furniture.joinery.pieces import Parts, Size, Style
from openrooms_usd.furniture.placements import on
from openrooms_usd.furniture.record import BuiltCategory, Classes
from openrooms_usd.furniture.schemes import scheme
from openrooms_usd.geometry.solids import lathe, sphere
from openrooms_usd.geometry.sweeps import tube
from openrooms_usd.geometry.uv import metric

# Lying shapes turned up, so that what was above looks to the front.


def _stands(size: Size) -> bool:
    """Whether it stands on an edge: it is thinner from front to back than it is high."""
    return size[1] < size[2]


def _stand_up(parts: Parts, size: Size, lean: float = 0.0) -> Parts:
    """Turn lying parts up where the box asks for it, leaning back, and put them on the floor."""
    shear = np.eye(3)
    if _stands(size):
        shear[1, 2] = lean
        shear = shear @ FRONT
    return {
        name: mesh.transformed(shear).moved((0.0, 0.0, 0.5 * size[2]))
        for name, mesh in parts.items()
    }


def _lying(size: Size) -> tuple[float, float, float]:
    width, depth, height = size
    return (width, height, depth) if _stands(size) else size


def square(size: Size, rng: np.random.Generator) -> Parts:
    """A filled case with a seam, sometimes with a corded edge."""
    width, depth, thick = _lying(size)
    lean = 0.0
    if _stands(size):
        lean = min(0.12, 0.25 * thick / depth)
        # Where the case is thinner, it may lean further.
        v = np.linspace(0.0, 0.95, 20)
        thick = float(((thick - lean * depth * v) / (1.0 - v**2) ** 0.46).min())
    corded = bool(rng.integers(2)) and min(width, depth) > 0.25
    cord = 0.005 if corded else 0.0
    case = filled(width - 2 * cord, depth - 2 * cord, thick, rng, divisions=18)
    parts = {"pillow": case}
    if corded:
        rim = _rim(width - 2 * cord, depth - 2 * cord)
        parts["trim"] = tube(rim, cord, segments=6, closed=True)
    return _stand_up(parts, size, lean)


def _rim(width: float, depth: float) -> np.ndarray:
    """(N, 3) the seam of a filled case, its corners rounded a little."""
    t = np.sin(0.5 * np.pi * np.linspace(-0.93, 0.93, 11))
    x, y = 0.5 * width, 0.5 * depth
    bow = 1.0 - 0.07 * (1.0 - t**2)
    sides = [
        np.stack([x * t, -y * bow], axis=1),
        np.stack([x * bow, y * t], axis=1),
        np.stack([-x * t, y * bow], axis=1),
        np.stack([-x * bow, -y * t], axis=1),
    ]
    flat = np.concatenate(sides)
    return np.concatenate([flat, np.zeros((len(flat), 1))], axis=1)


def bolster(size: Size, rng: np.random.Generator) -> Parts:
    """A roll with drawn-in ends."""
    width, depth, height = size
    r, half = 0.5, 0.5 * width
    edge = min(0.035, 0.2 * width)
    dip = float(rng.uniform(0.1, 0.4)) * edge
    profile = [
        (0.0, dip - half),
        (0.12 * r, dip - half),
        (0.75 * r, -half),
        (0.94 * r, 0.35 * edge - half),
        (r, edge - half),
        (1.02 * r, 0.0),
        (r, half - edge),
        (0.94 * r, half - 0.35 * edge),
        (0.75 * r, half),
        (0.12 * r, half - dip),
        (0.0, half - dip),
    ]
    roll = lathe(profile, segments=36, crease=60.0)
    along = np.array([[0.0, 0.0, 1.0], [depth, 0.0, 0.0], [0.0, height, 0.0]])
    case, _ = metric(roll.transformed(along).moved((0.0, 0.0, 0.5 * height)))
    return {"pillow": case}


def round_(size: Size, rng: np.random.Generator) -> Parts:
    """A round cushion drawn together by a button in its middle."""
    width, depth, thick = _lying(size)
    t = np.linspace(0.0, np.pi, 19)
    plump = 0.5 * np.sin(t) ** 0.5 * np.sign(0.5 * np.pi - t) * np.abs(np.cos(t)) ** 0.45
    radius = 0.5 * np.sin(t) ** 0.8
    dent = 1.0 - float(rng.uniform(0.35, 0.6)) * np.exp(-((radius / 0.12) ** 2))
    profile = np.stack([radius, -plump * dent], axis=1)
    profile[[0, -1], 0] = 0.0
    high = float(np.abs(profile[:, 1]).max())
    profile[0, 1], profile[-1, 1] = -0.45 * high, 0.45 * high
    scale = np.diag([width, depth, 0.5 * thick / high])
    case, _ = metric(lathe(profile, segments=44, crease=70.0).transformed(scale))
    button = sphere(0.016, segments=12, squash=0.4, center=(0.0, 0.0, 0.24 * thick))
    other = sphere(0.016, segments=12, squash=0.4, center=(0.0, 0.0, -0.24 * thick))
    return _stand_up({"pillow": case, "button_0": button, "button_1": other}, size)


def _rolled(size: Size) -> bool:
    return size[0] > 2.0 * max(size[1:]) and max(size[1:]) < 1.5 * min(size[1:])


CATEGORY: Final = BuiltCategory(
    description="a cushion to lean on",
    size=(0.45, 0.16, 0.4),
    min_size=(0.15, 0.06, 0.06),
    max_size=(1.2, 0.9, 0.7),
    styles={
        "square": Style(square, lambda size: not _rolled(size)),
        "bolster": Style(bolster, _rolled, (0.55, 0.2, 0.2)),
        "round": Style(
            round_, lambda size: not _rolled(size) and size[0] < 0.6, (0.42, 0.15, 0.42), weight=0.1
        ),
    },
    support="surface",
    mass_range=(0.3, 1.5),
    words="cushion pillows",
    lies_under=True,
    classes=Classes("pillow", "pillow", "pillow"),
    synsets=("03938244",),
    schemes=(scheme("linen"),),
    placements=(
        on("sofa_seat", styles="square round", pose="leaning", max_groups=4, max_variants=3),
        on("armchair_seat", styles="square", pose="leaning"),
    ),
)
