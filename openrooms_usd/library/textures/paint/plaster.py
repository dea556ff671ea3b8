"""Families of painted plaster: what trowel, sponge, rag and hopper gun leave on walls."""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base.family import Color, Family, Order, Use
from openrooms_usd.library.textures.base.flakes import flakes
from openrooms_usd.library.textures.base.maps import Maps
from openrooms_usd.library.textures.base.noise import band_noise, smoothstep
from openrooms_usd.library.textures.base.recipe import (
    displaced,
    drawn_color,
    drawn_roughness,
    finished,
    fractal,
    mixed,
    noise,
)
from openrooms_usd.library.textures.base.strewn import pits

# Lime and earth colours, scene-linear Rec.709.
EARTHS: Final[tuple[Color, ...]] = (
    (0.74, 0.71, 0.65),
    (0.62, 0.57, 0.49),
    (0.55, 0.43, 0.31),
    (0.50, 0.52, 0.46),
    (0.40, 0.45, 0.48),
    (0.55, 0.36, 0.27),
)
WHITES: Final[tuple[Color, ...]] = ((0.80, 0.79, 0.77), (0.76, 0.75, 0.72), (0.70, 0.69, 0.66))


def _limewash(order: Order) -> Maps:
    """Thin coats of lime brushed crosswise: clouds, and strokes of a wide brush all ways."""
    strokes = flakes(order, 2.5, (0.12, 0.28), (0.05, 0.09), spread=1.4)
    tone = strokes.each(order.rng.uniform(-1.0, 1.0, strokes.count))
    bristle = strokes.fibre(order, 0.002, 0.1)
    edge = smoothstep(0.0, 0.03, strokes.inside)
    cloud = fractal(order, 0.3, 0.5)
    shade = 1.0 + edge * (0.03 * tone + 0.02 * bristle) + 0.025 * cloud
    color = drawn_color(order, EARTHS, 0.06)
    height = 20e-6 * bristle * edge + 60e-6 * noise(order, 0.03)
    return finished(order, color * shade[..., None], height, drawn_roughness(order, 0.8, 0.95))


def _venetian(order: Order) -> Maps:
    """Polished lime plaster: thin layers of a trowel's breadth, veined where they overlap."""
    strokes = flakes(order, 2.2, (0.06, 0.16), (0.025, 0.06), spread=np.pi)
    tone = strokes.each(order.rng.uniform(-1.0, 1.0, strokes.count))
    edge = smoothstep(0.0015, 0.0, strokes.inside)
    cloud = fractal(order, 0.12, 0.5)
    color = drawn_color(order, EARTHS, 0.06)
    shade = 1.0 + 0.07 * tone + 0.05 * cloud - 0.07 * edge
    burnish = 0.06 * tone + 0.04 * cloud
    height = 12e-6 * strokes.level + 6e-6 * tone + 10e-6 * noise(order, 0.02)
    roughness = drawn_roughness(order, 0.22, 0.38) - burnish + 0.08 * edge
    return finished(order, color * shade[..., None], height, np.maximum(roughness, 0.1))


def _troweled(order: Order) -> Maps:
    """Skip trowel: mud drawn in thin arcs, each ending in a ridge."""
    strokes = flakes(order, 0.8, (0.10, 0.22), (0.04, 0.10), spread=np.pi)
    ridge = np.exp(-strokes.inside / 0.0035) * (strokes.index > 0)
    slope = np.clip(strokes.across / 0.05, -1.0, 1.0)
    ragged = smoothstep(-0.4, 0.8, noise(order, 0.014) + 0.5 * slope)
    height = 1.1e-3 * ridge * ragged + 0.5e-3 * slope * ragged + 0.06e-3 * noise(order, 0.006)
    color = drawn_color(order, WHITES, 0.04)
    shade = 1.0 + 0.01 * ragged
    return finished(order, color * shade[..., None], height, drawn_roughness(order, 0.75, 0.9))


def _knockdown(order: Order) -> Maps:
    """Sprayed mud, knocked flat with a knife: islands with flat tops."""
    blob = band_noise(order.rng, order.resolution, order.size, 0.020) + 0.5 * noise(order, 0.008)
    island = smoothstep(0.55, 0.85, blob)
    stipple = band_noise(order.rng, order.resolution, order.size, 0.003)
    height = 0.8e-3 * island + 15e-6 * stipple + 0.05e-3 * noise(order, 0.15)
    color = drawn_color(order, WHITES, 0.04)
    shade = 1.0 + 0.006 * stipple + 0.006 * island
    return finished(order, color * shade[..., None], height, drawn_roughness(order, 0.75, 0.9))


def _splatter(order: Order) -> Maps:
    """Orange-peel drywall: drops of mud from a hopper gun, round and of all sizes."""
    drops = pits(order, 0.55, (0.0015, 0.006))
    dome = np.sqrt(np.clip(drops.inside, 0.0, 0.006) / 0.006)
    stipple = band_noise(order.rng, order.resolution, order.size, 0.003)
    height = 0.55e-3 * dome + 15e-6 * stipple
    color = drawn_color(order, WHITES, 0.04)
    shade = 1.0 + 0.006 * stipple
    return finished(order, color * shade[..., None], height, drawn_roughness(order, 0.75, 0.9))


def _popcorn(order: Order) -> Maps:
    """Acoustic ceiling spray: crumbs that stand on each other."""
    coarse = band_noise(order.rng, order.resolution, order.size, 0.009)
    fine = band_noise(order.rng, order.resolution, order.size, 0.0045)
    crumb = np.maximum(coarse, fine - 0.2)
    lump = smoothstep(-0.3, 1.8, crumb)
    height = 3e-3 * lump + 0.25e-3 * fine
    color = drawn_color(order, WHITES, 0.04)
    # Deep hollows see little of the room.
    shade = 0.8 + 0.24 * lump
    return finished(order, color * shade[..., None], height, drawn_roughness(order, 0.88, 0.97))


def _sponged(order: Order) -> Maps:
    """Distemper dabbed on with a sponge: blots full of holes, in two tones."""
    dab = smoothstep(0.1, 0.5, noise(order, 0.03) + 0.55 * noise(order, 0.004))
    second = smoothstep(0.4, 0.8, noise(order, 0.035) + 0.6 * noise(order, 0.005))
    color = drawn_color(order, EARTHS, 0.06)
    shade = 1.0 - 0.16 * dab + 0.13 * second
    height = 35e-6 * (dab + second) + 12e-6 * noise(order, 0.0025)
    return finished(order, color * shade[..., None], height, drawn_roughness(order, 0.8, 0.94))


def _rag_rolled(order: Order) -> Maps:
    """Glaze rolled with a crumpled rag: sharp folds that run together."""
    folded = np.abs(noise(order, 0.022)) + 0.5 * np.abs(noise(order, 0.010))
    crease = displaced(folded, order, 0.006 * noise(order, 0.02), 0.006 * noise(order, 0.02))
    lift = np.exp(-crease / 0.4)
    color = drawn_color(order, EARTHS, 0.06)
    shade = 1.15 - 0.35 * lift
    roughness = drawn_roughness(order, 0.45, 0.65) + 0.06 * lift
    return finished(order, color * shade[..., None], 10e-6 * lift, roughness)


def _combed(order: Order) -> Maps:
    """Textured plaster drawn with a notched comb in overlapping half circles."""
    count = max(2, 2 * round(order.size / 0.2 / 2))
    place = (np.arange(order.resolution) + 0.5) / order.resolution * count
    high = np.full((order.resolution, order.resolution), 0.0)
    unit = order.size / count
    done = np.zeros(high.shape, dtype=bool)
    # Scales from the bottom up: lower rows lie over higher ones, every second one shifted by half.
    for lower in (0, 1, 2):
        row = np.floor(place * 2.0).astype(np.int64)[:, None] + lower
        down = row + 1.0 - 2.0 * place[:, None]
        shift = 0.5 * (row % 2)
        across = (place[None, :] + shift) % 1.0 - 0.5
        far = np.hypot(across, 0.5 * down) * unit
        mine = ~done & (far < 0.56 * unit)
        groove = np.abs(np.sin(np.pi * (far / 0.009))) ** 0.7
        high[mine] = groove[mine]
        done |= mine
    wobble = noise(order, 0.01)
    height = 0.9e-3 * high + 0.05e-3 * wobble
    color = drawn_color(order, WHITES, 0.04)
    shade = 0.96 + 0.05 * high
    return finished(order, color * shade[..., None], height, drawn_roughness(order, 0.75, 0.9))


def _rough_render(order: Order) -> Maps:
    """Scratched render under paint: grains that were dragged have left furrows."""
    furrows = pits(order, 0.3, (0.0012, 0.003), 1.0)
    drag = smoothstep(0.9, 1.5, noise(order, 0.003, 0.02))
    grain = band_noise(order.rng, order.resolution, order.size, 0.0025)
    hole = np.clip(furrows.inside / 0.002, 0.0, 1.0)
    height = 0.18e-3 * grain - 0.8e-3 * drag - 0.3e-3 * hole
    color = drawn_color(order, EARTHS, 0.06)
    shade = 1.0 + 0.02 * grain - 0.10 * drag
    albedo = mixed(hole, 0.93 * color, color * shade[..., None])
    return finished(order, albedo, height, drawn_roughness(order, 0.85, 0.96))


_INSIDE: Final[frozenset[Use]] = frozenset({"wall", "ceiling"})
_WALLS: Final[frozenset[Use]] = frozenset({"wall"})

FAMILIES: Final[dict[str, Family]] = {
    "combed_plaster": Family(_combed, 0.8, _INSIDE),
    "knockdown": Family(_knockdown, 0.5, _INSIDE),
    "limewash": Family(_limewash, 1.6, _INSIDE),
    "orange_peel": Family(_splatter, 0.4, _INSIDE),
    "popcorn_ceiling": Family(_popcorn, 0.4, frozenset({"ceiling"})),
    "rag_rolled": Family(_rag_rolled, 0.8, _WALLS),
    "scratched_render": Family(_rough_render, 0.4, _WALLS, grain=True),
    "skip_trowel": Family(_troweled, 1.0, _INSIDE),
    "sponged_distemper": Family(_sponged, 0.8, _INSIDE),
    "venetian_plaster": Family(_venetian, 1.0, _WALLS),
}
