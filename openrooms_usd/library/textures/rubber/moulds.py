"""Patterns moulded into rubber: studs, ribs, bars, domes, holes and treads, 0 (low) to 1 (high)."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base.cells import hexagons
from openrooms_usd.library.textures.base.family import Color, Order
from openrooms_usd.library.textures.base.lattice import diagonal, offset, phase, whole
from openrooms_usd.library.textures.base.noise import Field, smoothstep
from openrooms_usd.library.textures.rubber.compound import BLACKS, COLORS


@dataclass(frozen=True)
class Mould:
    """A pattern.

    Attributes:
        relief: (N, N) its height, 0..1, of an order and the distance of its repeats, metres.
        pitch: Usual distance of its repeats, metres.
        depth: From low to high, metres.
        size: Its usual size, metres.
        dark: How much darker its hollows are.
        roughness: Range of its mean.
        grain: Whether it runs along t.
        colors: Usual mean colours.
    """

    relief: Callable[[Order, float], Field]
    pitch: float
    depth: float
    size: float
    dark: float = 0.3
    roughness: tuple[float, float] = (0.62, 0.78)
    grain: bool = False
    colors: tuple[Color, ...] = COLORS


def _square(order: Order, pitch: float) -> tuple[Field, Field]:
    """Places -1..1 in squares, along s and t."""
    place = phase(order.resolution, whole(order, pitch))
    return offset(place)[None], offset(place)[:, None]


def _coins(order: Order, pitch: float) -> Field:
    """Round flat studs with a bevel."""
    x, y = _square(order, pitch)
    return 1.0 - smoothstep(0.66, 0.80, np.hypot(x, y))


def _bubbles(order: Order, pitch: float) -> Field:
    """Domes side by side, as on mats to stand on."""
    count = whole(order, pitch)
    first, second = diagonal(order.resolution, count, count)
    reach = np.hypot(offset(first), offset(second))
    return np.sqrt(np.maximum(1.0 - (reach / 0.97) ** 2, 0.0))


def _ribs(order: Order, pitch: float) -> Field:
    """Fine round ribs."""
    x, y = _square(order, pitch)
    return np.asarray(np.maximum(1.0 - (x / 0.85) ** 4, 0.0) + 0.0 * y)


def _runner(order: Order, pitch: float) -> Field:
    """Broad flat ribs, each followed by four narrow ones."""
    count = whole(order, pitch)
    place = np.broadcast_to(
        phase(order.resolution, count) % 1.0, (order.resolution, order.resolution)
    )
    broad = smoothstep(0.02, 0.06, place) * smoothstep(0.44, 0.40, place)
    narrow = 0.75 * (0.5 - 0.5 * np.cos(2.0 * np.pi * 4.0 * (place - 0.46) / 0.54))
    return np.asarray(np.where(place < 0.46, broad, narrow))


def _bar(p: Field, q: Field) -> Field:
    """A lens that is pointed at p = -1 and 1, and ``q`` from its middle line."""
    inside = 0.34 * (1.0 - p**2) - np.abs(q)
    return smoothstep(0.0, 0.14, inside)


def _lozenges(order: Order, pitch: float) -> Field:
    """Single slanted lenses, every second one the other way: diamond tread."""
    count = whole(order, pitch, 2)
    place = phase(order.resolution, count)
    x, y = offset(place)[None], offset(place)[:, None]
    number = np.floor(place).astype(np.int64)
    is_even = (number[None] + number[:, None]) % 2 == 0
    p, q = np.where(is_even, x + y, x - y), np.where(is_even, x - y, x + y)
    return _bar(p / 1.35, q / 1.35)


def _five_bars(order: Order, pitch: float) -> Field:
    """Fields of five bars, along s and along t by turns: checker plate."""
    count = whole(order, pitch, 2)
    place = phase(order.resolution, count)
    x, y = offset(place)[None], offset(place)[:, None]
    number = np.floor(place).astype(np.int64)
    is_even = (number[None] + number[:, None]) % 2 == 0
    p, q = np.where(is_even, x, y), np.where(is_even, y, x)
    bar = 1.0 - np.abs(offset(2.5 * (q + 1.0)))
    ends = smoothstep(0.93, 0.80, np.abs(p))
    return np.asarray(smoothstep(0.28, 0.62, bar) * ends)


def _honeycomb(order: Order, pitch: float) -> Field:
    """Walls about open hexagons."""
    edge = hexagons(order, order.size / whole(order, pitch)).edge
    wall = 0.09 * min(pitch, order.size)
    return 1.0 - smoothstep(wall, 1.8 * wall, edge)


def _rings(order: Order, pitch: float) -> Field:
    """Drain holes, each in a raised ring, with small ones between them."""
    x, y = _square(order, pitch)
    reach = np.hypot(x, y)
    ring = 1.0 - smoothstep(0.05, 0.10, np.abs(reach - 0.84))
    hole = 1.0 - smoothstep(0.66, 0.71, reach)
    small = np.hypot(x - np.copysign(1.0, x), y - np.copysign(1.0, y))
    hole = np.maximum(hole, 1.0 - smoothstep(0.24, 0.29, small))
    return np.asarray((0.72 + 0.28 * ring) * (1.0 - hole))


def _crosshatch(order: Order, pitch: float) -> Field:
    """Blunt pyramids between two sets of slanted grooves."""
    count = whole(order, pitch)
    first, second = diagonal(order.resolution, count, count)
    edge = np.maximum(np.abs(offset(first)), np.abs(offset(second)))
    return np.minimum((1.0 - edge) / 0.62, 1.0)


def _tread(order: Order, pitch: float) -> Field:
    """Tyre: blocks between grooves along t and slanted ones, with fine sipes."""
    n = order.resolution
    columns, rows = whole(order, 4.0 * pitch), whole(order, pitch)
    place, along = phase(n, columns)[None] % 1.0, phase(n, rows)[:, None]
    texel = columns / n
    groove: Field = np.abs(place[..., None] - np.array([0.0, 0.2, 0.5, 0.8, 1.0])).min(axis=-1)
    straight = smoothstep(0.018, 0.026 + texel, groove)
    lean = 1.6 * np.abs(place - 0.5)
    is_rib = (place > 0.2) & (place < 0.8)
    block = np.abs(offset(along + np.where(is_rib, lean, 0.35 - 0.5 * lean)))
    slanted = smoothstep(0.95, 0.84, block) * np.ones_like(straight)
    sipe = np.abs(offset(3.0 * along + 4.0 * lean))
    cut = 1.0 - 0.4 * smoothstep(0.86, 0.96, sipe) * is_rib
    return np.asarray(straight * slanted * cut)


MOULDS: Final[dict[str, Mould]] = {
    "coin_rubber": Mould(_coins, 0.033, 0.0009, 0.264, 0.12),
    "ribbed_rubber": Mould(_ribs, 0.0036, 0.0011, 0.144, 0.4, grain=True),
    "corrugated_rubber": Mould(_runner, 0.024, 0.0025, 0.24, 0.35, grain=True),
    "diamond_tread_rubber": Mould(_lozenges, 0.026, 0.0012, 0.26, 0.12),
    "five_bar_rubber": Mould(_five_bars, 0.04, 0.0013, 0.32, 0.15),
    "bubble_mat": Mould(_bubbles, 0.022, 0.0045, 0.22, 0.35),
    "honeycomb_mat": Mould(_honeycomb, 0.018, 0.008, 0.18, 0.6),
    "ring_mat": Mould(_rings, 0.034, 0.009, 0.272, 0.65),
    "crosshatch_rubber": Mould(_crosshatch, 0.0062, 0.0011, 0.124, 0.35),
    "tyre_tread": Mould(_tread, 0.03, 0.006, 0.24, 0.5, grain=True, colors=BLACKS),
}
