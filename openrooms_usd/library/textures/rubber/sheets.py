"""Rubber: compounds as they are, and mats and treads that are moulded of them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import lattice
from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.rubber import compound
from openrooms_usd.library.textures.rubber.compound import BLACKS, COLORS, rubber


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

    relief: Callable[[tx.TextureParams, float], tx.Field]
    pitch: float
    depth: float
    size: float
    dark: float = 0.3
    roughness: tuple[float, float] = (0.62, 0.78)
    grain: bool = False
    colors: tuple[tx.Color, ...] = COLORS


def _square(order: tx.TextureParams, pitch: float) -> tuple[tx.Field, tx.Field]:
    """Places -1..1 in squares, along s and t."""
    place = lattice.phase(order.resolution, lattice.whole(order, pitch))
    return lattice.offset(place)[None], lattice.offset(place)[:, None]


def _coins(order: tx.TextureParams, pitch: float) -> tx.Field:
    """Round flat studs with a bevel."""
    x, y = _square(order, pitch)
    return 1.0 - tx.smoothstep(0.66, 0.80, np.hypot(x, y))


def _bubbles(order: tx.TextureParams, pitch: float) -> tx.Field:
    """Domes side by side, as on mats to stand on."""
    count = lattice.whole(order, pitch)
    first, second = lattice.diagonal(order.resolution, count, count)
    reach = np.hypot(lattice.offset(first), lattice.offset(second))
    return np.sqrt(np.maximum(1.0 - (reach / 0.97) ** 2, 0.0))


def _ribs(order: tx.TextureParams, pitch: float) -> tx.Field:
    """Fine round ribs."""
    x, y = _square(order, pitch)
    return np.asarray(np.maximum(1.0 - (x / 0.85) ** 4, 0.0) + 0.0 * y)


def _runner(order: tx.TextureParams, pitch: float) -> tx.Field:
    """Broad flat ribs, each followed by four narrow ones."""
    count = lattice.whole(order, pitch)
    place = np.broadcast_to(
        lattice.phase(order.resolution, count) % 1.0, (order.resolution, order.resolution)
    )
    broad = tx.smoothstep(0.02, 0.06, place) * tx.smoothstep(0.44, 0.40, place)
    narrow = 0.75 * (0.5 - 0.5 * np.cos(2.0 * np.pi * 4.0 * (place - 0.46) / 0.54))
    return np.asarray(np.where(place < 0.46, broad, narrow))


def _bar(p: tx.Field, q: tx.Field) -> tx.Field:
    """A lens that is pointed at p = -1 and 1, and ``q`` from its middle line."""
    inside = 0.34 * (1.0 - p**2) - np.abs(q)
    return tx.smoothstep(0.0, 0.14, inside)


def _lozenges(order: tx.TextureParams, pitch: float) -> tx.Field:
    """Single slanted lenses, every second one the other way: diamond tread."""
    count = lattice.whole(order, pitch, 2)
    place = lattice.phase(order.resolution, count)
    x, y = lattice.offset(place)[None], lattice.offset(place)[:, None]
    number = np.floor(place).astype(np.int64)
    is_even = (number[None] + number[:, None]) % 2 == 0
    p, q = np.where(is_even, x + y, x - y), np.where(is_even, x - y, x + y)
    return _bar(p / 1.35, q / 1.35)


def _five_bars(order: tx.TextureParams, pitch: float) -> tx.Field:
    """Fields of five bars, along s and along t by turns: checker plate."""
    count = lattice.whole(order, pitch, 2)
    place = lattice.phase(order.resolution, count)
    x, y = lattice.offset(place)[None], lattice.offset(place)[:, None]
    number = np.floor(place).astype(np.int64)
    is_even = (number[None] + number[:, None]) % 2 == 0
    p, q = np.where(is_even, x, y), np.where(is_even, y, x)
    bar = 1.0 - np.abs(lattice.offset(2.5 * (q + 1.0)))
    ends = tx.smoothstep(0.93, 0.80, np.abs(p))
    return np.asarray(tx.smoothstep(0.28, 0.62, bar) * ends)


def _honeycomb(order: tx.TextureParams, pitch: float) -> tx.Field:
    """Walls about open hexagons."""
    edge = tx.hexagons(order, order.size / lattice.whole(order, pitch)).edge
    wall = 0.09 * min(pitch, order.size)
    return 1.0 - tx.smoothstep(wall, 1.8 * wall, edge)


def _rings(order: tx.TextureParams, pitch: float) -> tx.Field:
    """Drain holes, each in a raised ring, with small ones between them."""
    x, y = _square(order, pitch)
    reach = np.hypot(x, y)
    ring = 1.0 - tx.smoothstep(0.05, 0.10, np.abs(reach - 0.84))
    hole = 1.0 - tx.smoothstep(0.66, 0.71, reach)
    small = np.hypot(x - np.copysign(1.0, x), y - np.copysign(1.0, y))
    hole = np.maximum(hole, 1.0 - tx.smoothstep(0.24, 0.29, small))
    return np.asarray((0.72 + 0.28 * ring) * (1.0 - hole))


def _crosshatch(order: tx.TextureParams, pitch: float) -> tx.Field:
    """Blunt pyramids between two sets of slanted grooves."""
    count = lattice.whole(order, pitch)
    first, second = lattice.diagonal(order.resolution, count, count)
    edge = np.maximum(np.abs(lattice.offset(first)), np.abs(lattice.offset(second)))
    return np.minimum((1.0 - edge) / 0.62, 1.0)


def _tread(order: tx.TextureParams, pitch: float) -> tx.Field:
    """Tyre: blocks between grooves along t and slanted ones, with fine sipes."""
    n = order.resolution
    columns, rows = lattice.whole(order, 4.0 * pitch), lattice.whole(order, pitch)
    place, along = lattice.phase(n, columns)[None] % 1.0, lattice.phase(n, rows)[:, None]
    texel = columns / n
    groove: tx.Field = np.abs(place[..., None] - np.array([0.0, 0.2, 0.5, 0.8, 1.0])).min(axis=-1)
    straight = tx.smoothstep(0.018, 0.026 + texel, groove)
    lean = 1.6 * np.abs(place - 0.5)
    is_rib = (place > 0.2) & (place < 0.8)
    block = np.abs(lattice.offset(along + np.where(is_rib, lean, 0.35 - 0.5 * lean)))
    slanted = tx.smoothstep(0.95, 0.84, block) * np.ones_like(straight)
    sipe = np.abs(lattice.offset(3.0 * along + 4.0 * lean))
    cut = 1.0 - 0.4 * tx.smoothstep(0.86, 0.96, sipe) * is_rib
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


def _moulded(mould: Mould, order: tx.TextureParams) -> tx.Maps:
    """A pattern pressed into rubber: dust lies in its hollows, feet polish its tops."""
    pitch = mould.pitch * float(order.rng.uniform(0.85, 1.15))
    relief = mould.relief(order, pitch)
    skin = tx.noise(order, 0.0007)
    dust = tx.fractal(order, 0.06, 0.3)
    hollow = 1.0 - relief
    shade = (1.0 + 0.06 * dust + 0.03 * skin) * (1.0 - mould.dark * hollow)
    depth = mould.depth * min(1.0, order.size / pitch) * order.rng.uniform(0.8, 1.2)
    height = depth * relief + 5e-6 * skin
    wear = 0.08 * hollow + 0.02 * dust
    return rubber(order, shade, height, mould.roughness, wear, mould.colors)


_FLOOR: Final[frozenset[tx.Use]] = frozenset({"floor"})
_THINGS: Final[frozenset[tx.Use]] = frozenset({"object"})
_BOTH: Final = _FLOOR | _THINGS

_COMPOUNDS: Final[
    dict[str, tuple[Callable[[tx.TextureParams], tx.Maps], float, float, frozenset[tx.Use]]]
] = {
    "smooth_rubber": (compound.smooth, 0.0008, 0.25, _BOTH),
    "crumb_rubber": (compound.crumb, 0.002, 0.2, _FLOOR),
    "speckled_rubber": (compound.speckled, 0.002, 0.25, _FLOOR),
    "marbled_rubber": (compound.marbled, 0.003, 0.5, _FLOOR),
    "pebbled_rubber": (compound.pebbled, 0.003, 0.2, _FLOOR),
    "eva_foam": (compound.foam, 0.0011, 0.1, _BOTH),
    "sponge": (compound.sponge, 0.002, 0.15, _THINGS),
    "latex": (compound.latex, 0.004, 0.2, _THINGS),
}

FAMILIES: Final[dict[str, tx.Family]] = {
    **{
        name: tx.Family(lattice.resolved(make, detail), size, uses)
        for name, (make, detail, size, uses) in _COMPOUNDS.items()
    },
    **{
        name: tx.Family(
            lattice.resolved(partial(_moulded, mould), mould.pitch / 4.0),
            mould.size,
            _FLOOR,
            grain=mould.grain,
        )
        for name, mould in MOULDS.items()
    },
}
