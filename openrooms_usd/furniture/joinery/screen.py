"""Monitors and televisions: flat, curved, on feet or a wall, and the deep ones with a tube."""

from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.boards import board
from openrooms_usd.furniture.joinery.pieces import Parts, Size, numbered
from openrooms_usd.furniture.joinery.posing import tapered, turned
from openrooms_usd.geometry.curves import filleted, rectangle
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import cylinder
from openrooms_usd.geometry.sweeps import extrude, sheet, tube
from openrooms_usd.geometry.vectors import points_at

_PANEL: Final = 0.012


def _flat_panel(width: float, low: float, high: float, front: float, bezel: float) -> Parts:
    """A display with its front at ``front``: housing, screen, and the electronics behind it."""
    half, tall = 0.5 * width, high - low
    chin = 1.8 * bezel
    shell = board((-half, front, low), (half, front + _PANEL, high), 0.003)
    back = board(
        (-0.3 * width, front + 0.5 * _PANEL, low + 0.18 * tall),
        (0.3 * width, front + _PANEL + 0.024, low + 0.72 * tall),
        0.01,
    )
    # The glass stands a hair before the bezel, so that neither hides the other.
    glass = board(
        (-half + bezel, front - 0.0006, low + chin),
        (half - bezel, front + 0.004, high - bezel),
        0.0005,
    )
    return {"frame": joined([shell, back]), "screen": glass}


def _plate(width: float, depth: float, thickness: float = 0.009) -> Mesh:
    outline = filleted(rectangle(width, depth), 0.25 * min(width, depth), closed=True, segments=5)
    return extrude(outline, thickness, bevel=0.003)


def monitor_flat(size: Size, rng: np.random.Generator) -> Parts:
    """A thin display on a column and a plate."""
    width, depth, height = size
    low = max(height - 0.64 * width, 0.2 * height)
    front = 0.5 * depth - min(0.6 * depth, 0.11) - _PANEL
    column = front + _PANEL + 0.026
    parts = _flat_panel(width, low, height, front, float(rng.uniform(0.006, 0.012)))
    tall = low + 0.5 * (height - low)
    parts["stand"] = board((-0.032, column - 0.006, 0.004), (0.032, column + 0.012, tall), 0.004)
    parts["base"] = _plate(float(rng.uniform(0.38, 0.46)) * width, depth)
    return parts


def _bowed(
    half: float, low: float, high: float, front: float, radius: float, thickness: float
) -> Mesh:
    """A panel whose sides come forward on a circle about the viewer."""
    x = np.linspace(-half, half, 25)
    y = front + np.sqrt(radius**2 - x**2) - radius
    grid = points_at(x, y, [[low], [high]])
    return sheet(grid, thickness)


def monitor_curved(size: Size, rng: np.random.Generator) -> Parts:
    """A wide display that bends around the viewer, on two splayed feet."""
    width, depth, height = size
    half = 0.5 * width
    radius = max(float(rng.uniform(1.2, 1.6)), 1.5 * width)
    low = max(height - 0.45 * width, 0.22 * height)
    front = 0.5 * depth - 0.075
    heel, middle = (0.0, 0.5 * depth - 0.012, 0.006), low + 0.45 * (height - low)
    toes = [(side * min(0.3 * width, 0.28), -0.5 * depth + 0.006, 0.006) for side in (-1, 1)]
    arm = board((-0.035, front + 0.01, middle - 0.035), (0.035, 0.5 * depth - 0.02, middle + 0.035))
    post = board((-0.024, 0.5 * depth - 0.024, 0.0), (0.024, 0.5 * depth, middle + 0.03), 0.005)
    return {
        "frame": _bowed(half, low, height, front, radius, 0.02),
        "screen": _bowed(half - 0.008, low + 0.016, height - 0.008, front - 0.0008, radius, 0.004),
        "stand": joined([post, arm]),
        **numbered("foot", [tube([heel, toe], 0.006) for toe in toes]),
    }


def _tube_set(size: Size, foot: float, chin: float, bezel: float) -> Parts:
    """A picture tube in its housing: a frame, a bulging screen, a back that narrows."""
    width, depth, height = size
    half, front = 0.5 * width, -0.5 * depth
    rim = min(0.16 * depth, 0.08)
    shell = board((-half, front, foot), (half, front + rim, height), 0.012)
    back = board(
        (-half + 0.008, front + rim - 0.01, foot + 0.006),
        (half - 0.008, 0.5 * depth, height - 0.008),
        0.02,
    )
    u, v = np.meshgrid(np.linspace(-1.0, 1.0, 11), np.linspace(-1.0, 1.0, 9))
    low, high = foot + chin, height - bezel
    bulge = 0.02 * width * (1.0 - 0.5 * (u**2 + v**2)) + 0.0005
    grid = points_at(
        u * (half - bezel),
        front - bulge + 0.02 * width,
        0.5 * (low + high) + 0.5 * v * (high - low),
    )
    shell = shell.moved((0.0, 0.02 * width, 0.0))
    return {
        "frame": joined([shell, tapered(back, "y", (0.5, 0.55))]),
        "screen": sheet(grid, 0.02 * width),
    }


def monitor_tube(size: Size, rng: np.random.Generator) -> Parts:
    """An old deep one on a swivelling foot."""
    width, depth, height = size
    foot = min(0.05, 0.14 * height)
    radius = 0.32 * min(width, depth)
    return {
        **_tube_set(size, foot, 0.07 * width, 0.05 * width),
        "base": cylinder(radius, foot + 0.02, bevel=0.008, base=(0.0, 0.0, 0.0)),
        **numbered("button", _buttons(width, depth, foot + 0.022, int(rng.integers(2, 5)))),
    }


def _buttons(width: float, depth: float, z: float, count: int) -> list[Mesh]:
    y = -0.5 * depth + 0.02 * width
    step = 0.026
    return [
        board((x - 0.007, y - 0.003, z - 0.004), (x + 0.007, y + 0.006, z + 0.004), 0.0015)
        for x in (0.4 * width - step * np.arange(count)).tolist()
    ]


def television_feet(size: Size, rng: np.random.Generator) -> Parts:
    """A thin display on two feet near its ends."""
    width, depth, height = size
    lift = min(0.07, 0.14 * height)
    parts = _flat_panel(width, lift, height, -0.03, float(rng.uniform(0.007, 0.012)))
    spread = float(rng.uniform(0.3, 0.4)) * width
    line = [
        (0.0, -0.5 * depth + 0.006, 0.006),
        (0.0, -0.006, lift + 0.015),
        (0.0, 0.5 * depth - 0.006, 0.006),
    ]
    foot = tube(line, 0.006, bend=0.03)
    return {
        **parts,
        **numbered("foot", [foot.moved((side * spread, 0.0, 0.0)) for side in (-1, 1)]),
    }


def television_pedestal(size: Size, rng: np.random.Generator) -> Parts:
    """A display on a neck in its middle and a wide glass-like plate."""
    width, depth, height = size
    lift = min(0.09, 0.16 * height)
    parts = _flat_panel(width, lift, height, -0.02, float(rng.uniform(0.012, 0.022)))
    neck = board((-0.07, -0.008, 0.004), (0.07, 0.022, lift + 0.06), 0.006)
    plate = _plate(float(rng.uniform(0.42, 0.55)) * width, depth, 0.012)
    return {**parts, "stand": neck, "base": plate}


def television_mounted(size: Size, rng: np.random.Generator) -> Parts:
    """A display on a bracket, for a wall."""
    width, depth, height = size
    parts = _flat_panel(width, 0.0, height, -0.5 * depth + 0.0006, float(rng.uniform(0.006, 0.012)))
    start, middle = -0.5 * depth + _PANEL, 0.47 * height
    rails = [
        board(
            (x - 0.018, start, middle - 0.2 * height),
            (x + 0.018, start + 0.034, middle + 0.2 * height),
        )
        for x in (-0.16 * width, 0.16 * width)
    ]
    plate = board(
        (-0.22 * width, 0.5 * depth - 0.004, middle - 0.11 * height),
        (0.22 * width, 0.5 * depth, middle + 0.11 * height),
        0.001,
    )
    arm = board((-0.05, start, middle - 0.05), (0.05, 0.5 * depth - 0.003, middle + 0.05))
    return {**parts, "stand": joined([*rails, plate, arm])}


def television_tube(size: Size, rng: np.random.Generator) -> Parts:
    """A set with a picture tube, loudspeakers beside the screen and a pair of antennas."""
    width, depth, height = size
    body = height - min(0.16, 0.25 * height)
    parts = _tube_set((width, depth, body), 0.012, 0.1 * width, 0.07 * width)
    feet = [
        board((x - 0.03, y - 0.03, 0.0), (x + 0.03, y + 0.03, 0.02))
        for x in (-0.38 * width, 0.38 * width)
        for y in (-0.3 * depth, 0.05 * depth)
    ]
    tall = height - body + 0.02
    lean = float(rng.uniform(28.0, 42.0))
    reach = (tall - 0.004) / np.cos(np.radians(lean))
    rod = cylinder(0.0025, reach, segments=8)
    rods = [
        turned(rod, "y", side * lean).moved((side * 0.01, 0.05 * depth, body - 0.02))
        for side in (-1, 1)
    ]
    return {
        **parts,
        **numbered("foot", feet),
        **numbered("antenna", rods),
        **numbered("button", _buttons(width, depth, 0.012 + 0.05 * width, 4)),
    }


def deep(size: Size) -> bool:
    """Whether a size, metres, is that of a screen with a tube."""
    return size[1] > 0.45 * size[0] and size[1] > 0.28
