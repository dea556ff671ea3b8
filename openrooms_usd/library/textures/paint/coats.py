"""Families of paint on sound ground: nearly one colour, with the relief that its tool leaves."""

from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

WALLS: Final[tuple[tx.Color, ...]] = _PALETTES["coats_walls"]
JOINERY: Final[tuple[tx.Color, ...]] = _PALETTES["coats_joinery"]
METALWORK: Final[tuple[tx.Color, ...]] = _PALETTES["coats_metalwork"]


@dataclass(frozen=True)
class Coat:
    """A coat of paint by the bumps that it has.

    Attributes:
        roughness: Range of its mean.
        stipple: Distance between the bumps, metres.
        relief: Standard deviation of their height, metres.
        waviness: Standard deviation of the height over a hand's breadth, metres.
        tint: Standard deviation of the colour's brightness.
        colors: Usual mean colours.
    """

    roughness: tuple[float, float]
    stipple: float
    relief: float
    waviness: float
    tint: float
    colors: tuple[tx.Color, ...] = WALLS


# Emulsion on plaster, by roller; a coarse roller leaves larger bumps.
ROLLED: Final = Coat((0.75, 0.92), 0.0028, 28e-6, 100e-6, 0.006)
# Lacquer on wood or metal, by spray gun: orange peel. Powder coat is finer and even.
SPRAYED: Final = Coat((0.3, 0.5), 0.006, 4e-6, 8e-6, 0.003, JOINERY)
POWDER: Final = Coat((0.5, 0.7), 0.0011, 7e-6, 0.0, 0.004, METALWORK)


def _coated(order: tx.TextureParams, coat: Coat) -> tx.Maps:
    color = tx.drawn_color(order, coat.colors, 0.06)
    stipple = tx.band_noise(order.rng, order.resolution, order.size, coat.stipple)
    wave, cloud = tx.noise(order, 0.12), tx.noise(order, 0.05)
    # Paint gathers in the hollows, where it also looks a little more matt.
    shade = 1.0 + coat.tint * (0.6 * cloud + 0.4 * wave) + 0.5 * coat.tint * stipple
    roughness = tx.drawn_roughness(order, *coat.roughness) * (1.0 + 0.02 * cloud - 0.015 * stipple)
    height = coat.relief * stipple + coat.waviness * wave
    return tx.finished(order, color * shade[..., None], height, roughness)


def _high_gloss(order: tx.TextureParams) -> tx.Maps:
    """Polished lacquer: flat but for long waves, a few nibs of dust and haze of wiping."""
    color = tx.drawn_color(order, JOINERY, 0.06)
    dust = tx.pits(order, 0.0006, (0.0002, 0.0006))
    nib = np.clip(dust.inside / 0.0004, 0.0, 1.0)
    haze = tx.smoothstep(0.3, 2.0, tx.noise(order, 0.02, 0.12))
    height = 2.0e-6 * tx.noise(order, 0.015) + 6e-6 * tx.noise(order, 0.09) + 25e-6 * nib
    shade = np.ones_like(haze)[..., None]
    return tx.finished(
        order, color * shade, height, tx.drawn_roughness(order, 0.06, 0.14) + 0.05 * haze
    )


def _brushed(order: tx.TextureParams) -> tx.Maps:
    """Gloss paint laid off by brush: fine furrows along t that flowed together."""
    color = tx.drawn_color(order, JOINERY, 0.06)
    furrow = tx.noise(order, 0.0011, 0.09) + 0.8 * tx.noise(order, 0.0025, 0.14)
    lap = tx.smoothstep(0.9, 1.8, tx.noise(order, 0.03, 0.3))
    shade = 1.0 - 0.012 * furrow + 0.01 * lap
    height = 14e-6 * furrow + 20e-6 * lap
    roughness = tx.drawn_roughness(order, 0.18, 0.4) + 0.012 * furrow
    return tx.finished(order, color * shade[..., None], height, roughness)


def _dragged(order: tx.TextureParams) -> tx.Maps:
    """Glaze dragged with a dry brush: threads of a darker tone run down the whole wall."""
    color = tx.drawn_color(order, WALLS, 0.06)
    thread = tx.noise(order, 0.0016, 1.2) + 0.6 * tx.noise(order, 0.005, 2.0)
    light = tx.smoothstep(-1.0, 1.4, thread + 0.25 * tx.noise(order, 0.001, 0.02))
    shade = 0.8 + 0.32 * light
    roughness = tx.drawn_roughness(order, 0.45, 0.65) + 0.05 * light
    return tx.finished(order, color * shade[..., None], -12e-6 * light, roughness)


def _hammered(order: tx.TextureParams) -> tx.Maps:
    """Hammer enamel: the paint has drawn back into shallow bowls with rims between."""
    warp = 0.0006 * tx.noise(order, 0.003), 0.0006 * tx.noise(order, 0.003)
    bowls = tx.scattered_cells(order, 0.0042, 0.9, warp)
    rim = np.exp(-bowls.edge / 0.0005)
    color = tx.drawn_color(order, ((0.30, 0.31, 0.31), (0.08, 0.15, 0.11), (0.07, 0.12, 0.2)))
    sparkle = tx.noise(order, 0.0005)
    shade = 1.0 - 0.22 * rim + 0.04 * sparkle
    height = 70e-6 * rim + 10e-6 * tx.noise(order, 0.004)
    roughness = tx.drawn_roughness(order, 0.22, 0.35) + 0.06 * rim
    return tx.finished(order, color * shade[..., None], height, roughness)


def _wrinkled(order: tx.TextureParams) -> tx.Maps:
    """Wrinkle finish of instruments: folds that wander like a labyrinth."""
    fold = tx.band_noise(order.rng, order.resolution, order.size, 0.0016)
    ridge = 1.0 - tx.smoothstep(0.0, 1.1, np.abs(fold))
    color = tx.drawn_color(order, METALWORK, 0.06)
    shade = 1.0 - 0.12 * (1.0 - ridge)
    height = 70e-6 * ridge + 8e-6 * tx.noise(order, 0.03)
    roughness = tx.drawn_roughness(order, 0.45, 0.6) - 0.05 * ridge
    return tx.finished(order, color * shade[..., None], height, roughness)


def _metal_flake(order: tx.TextureParams) -> tx.Maps:
    """Effect paint: flakes of mica under clear lacquer, each lying a little askew."""
    grains = tx.scattered_cells(order, 0.0005, 1.0)
    glint = order.rng.random(grains.count) ** 4
    tilt = order.rng.uniform(-1.0, 1.0, (2, grains.count))
    color = tx.drawn_color(order, ((0.30, 0.31, 0.32), (0.09, 0.12, 0.2), (0.25, 0.17, 0.08)))
    shade = 0.75 + 1.2 * glint[grains.index]
    lean = grains.across * tilt[0][grains.index] + grains.up * tilt[1][grains.index]
    height = 0.06 * lean + 3e-6 * tx.noise(order, 0.02)
    return tx.shaded(order, color, shade, height, (0.2, 0.32))


def _speckled(order: tx.TextureParams) -> tx.Maps:
    """Fleck paint of corridors: drops of three colours in one coat."""
    color = tx.drawn_color(order, WALLS, 0.06)
    fine, coarse = tx.noise(order, 0.0016), tx.noise(order, 0.0035)
    dark, light = tx.smoothstep(1.2, 1.35, fine), tx.smoothstep(1.0, 1.15, coarse)
    warm = tx.smoothstep(1.25, 1.4, tx.noise(order, 0.0025))
    albedo = tx.mixed(light, np.array((0.86, 0.85, 0.83)), np.broadcast_to(color, (*fine.shape, 3)))
    albedo = tx.mixed(warm, 0.55 * color * np.array((1.1, 0.95, 0.8)), albedo)
    albedo = tx.mixed(dark, 0.3 * color, albedo)
    height = 25e-6 * (dark + light + warm) + 10e-6 * tx.noise(order, 0.006)
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.4, 0.6))


def _blackboard(order: tx.TextureParams) -> tx.Maps:
    """Blackboard paint with what the sponge left of chalk."""
    ground = tx.drawn_color(order, ((0.030, 0.032, 0.032), (0.032, 0.055, 0.042)))
    swept = tx.fractal(order, 0.25, 0.5) + 0.8 * tx.noise(order, 0.16, 0.012)
    chalk = 0.055 * tx.smoothstep(-0.8, 2.6, swept)
    grit = tx.noise(order, 0.0007)
    albedo = ground * (1.0 + 0.05 * grit)[..., None] + (chalk * (1.0 + 0.3 * grit))[..., None]
    return tx.finished(
        order, albedo, 9e-6 * grit, tx.drawn_roughness(order, 0.72, 0.88) + 0.8 * chalk
    )


def _woodchip(order: tx.TextureParams) -> tx.Maps:
    """Woodchip wallpaper under emulsion: slivers that lie all ways below the paint."""
    chips = tx.flakes(order, 0.16, (0.002, 0.007), (0.0006, 0.0016), spread=np.pi)
    bump = tx.smoothstep(0.0, 0.0006, chips.inside)
    color = tx.drawn_color(order, WALLS, 0.06)
    stipple = tx.band_noise(order.rng, order.resolution, order.size, 0.003)
    height = 0.45e-3 * _softened(order, bump) + 18e-6 * stipple
    shade = 1.0 + 0.004 * stipple
    return tx.shaded(order, color, shade, height, (0.75, 0.92))


def _softened(order: tx.TextureParams, field: tx.Field) -> tx.Field:
    """A field seen through a coat of paint: averaged over a few tenths of a millimetre."""
    frequency = np.fft.fftfreq(order.resolution, order.size / order.resolution)
    low = np.exp(-2.0 * (np.pi * 0.00035 * frequency) ** 2)
    spectrum = np.fft.rfft2(field) * low[:, None] * low[: order.resolution // 2 + 1]
    return np.asarray(np.fft.irfft2(spectrum, s=field.shape))


_INSIDE: Final[frozenset[tx.Use]] = frozenset({"wall", "ceiling"})
_OBJECTS: Final[frozenset[tx.Use]] = frozenset({"furniture", "object"})

FAMILIES: Final[dict[str, tx.Family]] = {
    "blackboard_paint": tx.Family(_blackboard, 1.0, frozenset({"wall", "object"})),
    "brushed_gloss": tx.Family(_brushed, 0.3, _OBJECTS | {"wall"}, grain=True),
    "dragged_glaze": tx.Family(_dragged, 0.8, frozenset({"wall", "furniture"}), grain=True),
    "hammered_enamel": tx.Family(_hammered, 0.15, _OBJECTS),
    "high_gloss_lacquer": tx.Family(_high_gloss, 0.5, _OBJECTS),
    "metal_flake": tx.Family(_metal_flake, 0.08, _OBJECTS),
    "powder_coat": tx.Family(partial(_coated, coat=POWDER), 0.12, _OBJECTS),
    "roller_matt": tx.Family(partial(_coated, coat=ROLLED), 0.4, _INSIDE),
    "speckled_coating": tx.Family(_speckled, 0.3, frozenset({"wall"})),
    "sprayed_satin": tx.Family(partial(_coated, coat=SPRAYED), 0.4, _OBJECTS),
    "woodchip_wallpaper": tx.Family(_woodchip, 0.3, _INSIDE),
    "wrinkle_finish": tx.Family(_wrinkled, 0.1, _OBJECTS),
}
