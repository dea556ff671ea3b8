"""Window frames: an outer frame, one sash a light, and a sill board.

No glass: a pane would only dim and bend what enters, and every renderer's direct light would have
to look through it. The light of the outside enters by the opening itself.

Frames are in their opening's frame: x to the right seen from inside, y outwards, z up, the origin
in the middle of the opening on the wall's inner face.
"""

import numpy as np

from openrooms_usd.geometry.faces import prism
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import rounded_box

# How far parts reach into the wall and into each other, so that no seam lets light pass, metres.
EMBED = 0.005

_PROFILE = 0.06  # visible width of the outer frame
_DEPTH = 0.07
_SASH = 0.05  # visible width of a sash
_REBATE = 0.012  # how far a sash overlaps the frame
_LIGHT = 0.75  # the width that one sash usually has
_BOARD = 0.025  # thickness of the sill board
_NOSE = 0.04  # how far the board stands out into the room and beyond the opening


def bar(
    x: tuple[float, float], y: tuple[float, float], z: tuple[float, float], radius: float = 0.002
) -> Mesh:
    """A box with softened edges between two values of each coordinate, metres."""
    low, high = np.sort(np.array([x, y, z], dtype=np.float64), axis=1).T
    return rounded_box(high - low, radius, center=0.5 * (low + high))


def rectangle(
    x: tuple[float, float], z: tuple[float, float], y: tuple[float, float], width: float
) -> list[Mesh]:
    """Four bars of a width around the inside of a rectangle: two stiles and two rails."""
    inner = (x[0] + width - EMBED, x[1] - width + EMBED)
    return [
        bar((x[0], x[0] + width), y, z),
        bar((x[1] - width, x[1]), y, z),
        bar(inner, y, (z[0], z[0] + width)),
        bar(inner, y, (z[1] - width, z[1])),
    ]


def window_frame(width: float, height: float, thickness: float, *, board: bool) -> Mesh:
    """The frame of a window with as many sashes side by side as its width asks for.

    Args:
        width: Of the opening, metres.
        height: Of the opening, metres.
        thickness: Of the wall, metres.
        board: Whether it has a sill board.

    Returns:
        The frame; its parts are closed solids that overlap each other and the wall.
    """
    slim = min(1.0, width / 0.5, height / 0.5)  # small windows have slim profiles
    profile, sash = slim * _PROFILE, slim * _SASH
    middle = max(0.6 * thickness, 0.5 * _DEPTH)
    y = (middle - 0.5 * _DEPTH, middle + 0.5 * _DEPTH)
    x, z = (-0.5 * width, 0.5 * width), (-0.5 * height, 0.5 * height)
    bars = rectangle(_wider(x, EMBED), _wider(z, EMBED), y, profile + EMBED)
    lights = max(1, round((width - 2 * profile) / _LIGHT))
    edges = np.linspace(x[0] + profile, x[1] - profile, lights + 1)
    clear = (z[0] + profile, z[1] - profile)
    for edge in edges[1:-1]:
        bars.append(bar((edge - 0.5 * profile, edge + 0.5 * profile), y, _wider(clear, EMBED)))
    inward = (y[0] - 0.3 * _REBATE, y[1] - 0.4 * _DEPTH)
    for i in range(lights):
        left = edges[i] + (0.5 * profile if i > 0 else 0.0)
        right = edges[i + 1] - (0.5 * profile if i < lights - 1 else 0.0)
        bars += rectangle(
            _wider((left, right), _REBATE), _wider(clear, _REBATE), inward, sash + _REBATE
        )
    return joined([*bars, _sill_board(width, z[0], y[0])] if board else bars)


def _wider(span: tuple[float, float], by: float) -> tuple[float, float]:
    return (float(span[0] - by), float(span[1] + by))


def _sill_board(width: float, bottom: float, depth: float) -> Mesh:
    """A board on the lower reveal, from the frame to a nose that is wider than the opening."""
    inside, beyond = 0.5 * width + EMBED, 0.5 * width + _NOSE
    outline = np.array(
        [
            [-beyond, -_NOSE],
            [beyond, -_NOSE],
            [beyond, EMBED],
            [inside, EMBED],
            [inside, depth + EMBED],
            [-inside, depth + EMBED],
            [-inside, EMBED],
            [-beyond, EMBED],
        ]
    )
    return prism(outline, bottom - EMBED, bottom + _BOARD)
