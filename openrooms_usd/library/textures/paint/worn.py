"""Families of paint that shows its age, and of wallpaper that was painted over."""

from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

MILK: Final[tuple[tx.Color, ...]] = _PALETTES["worn_milk"]
_WOOD: Final = np.array((0.25, 0.155, 0.085))
_PLASTER: Final = np.array((0.56, 0.52, 0.46))


def _crackled(order: tx.Order) -> tx.Maps:
    """Paint over crackle glaze: fields within fields, the ground in the cracks."""
    warp = 0.0015 * tx.noise(order, 0.01), 0.0015 * tx.noise(order, 0.01)
    large = tx.scattered_cells(order, 0.022, 1.0, warp)
    small = tx.scattered_cells(order, 0.008, 1.0, warp)
    width = 0.0004 + 0.00025 * tx.noise(order, 0.05).clip(-1.2, 2.0)
    crack = np.maximum(
        tx.smoothstep(0.0, 1.0, (width - large.edge) / 0.0003 + 1.0),
        tx.smoothstep(0.0, 1.0, (0.5 * width - small.edge) / 0.0003 + 0.6),
    )
    tone = order.rng.uniform(-0.04, 0.04, large.count)[large.index]
    paint = tx.drawn_color(order, MILK) * (1.0 + tone)[..., None]
    curl = np.exp(-large.edge / 0.0018)
    height = (0.12e-3 + 0.05e-3 * curl) * (1.0 - crack)
    roughness = tx.drawn_roughness(order, 0.5, 0.7) + 0.15 * crack
    return tx.finished(order, tx.mixed(crack, _WOOD, paint), height, roughness)


def _chalk(order: tx.Order) -> tx.Maps:
    """Chalk paint: brushed both ways, sanded back here and there, dark wax in the furrows."""
    color = tx.drawn_color(order, MILK)
    furrow = tx.noise(order, 0.0016, 0.05) + 0.7 * tx.noise(order, 0.05, 0.0016)
    wax = tx.smoothstep(0.4, 2.2, -furrow)
    rub = tx.smoothstep(1.5, 2.3, tx.fractal(order, 0.15, 0.4) + 0.35 * furrow)
    shade = (1.0 + 0.02 * furrow) * (1.0 - 0.22 * wax)
    albedo = tx.mixed(rub, _WOOD * 1.3, color * shade[..., None])
    height = 16e-6 * furrow - 60e-6 * rub
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.7, 0.88) - 0.15 * wax)


def _flaking(order: tx.Order) -> tx.Maps:
    """Old wall paint that has come off in flakes down to the plaster."""
    patch = tx.fractal(order, 0.4, 0.5)
    shards = tx.scattered_cells(order, 0.03, 1.0, (0.002 * tx.noise(order, 0.01), 0.002 * patch))
    lost = patch + 0.5 * order.rng.uniform(-1.0, 1.0, shards.count)[shards.index]
    bare = tx.smoothstep(0.75, 0.79, lost)
    crack = tx.smoothstep(0.0009, 0.0, shards.edge) * tx.smoothstep(0.0, 0.6, lost) * (1.0 - bare)
    lip = np.exp(-np.abs(lost - 0.72) / 0.05) * (1.0 - bare)
    color = tx.drawn_color(order, MILK)
    ground = _PLASTER * (1.0 + 0.08 * tx.fractal(order, 0.05, 0.3))[..., None]
    paint = color * (1.0 + 0.03 * patch)[..., None] * (1.0 - 0.5 * crack)[..., None]
    height = 0.3e-3 * (1.0 - bare) + 0.2e-3 * lip - 0.2e-3 * crack + 30e-6 * tx.noise(order, 0.004)
    roughness = tx.drawn_roughness(order, 0.6, 0.8) + 0.15 * bare
    return tx.finished(order, tx.mixed(bare, ground, paint), height, roughness)


def _embossed(order: tx.Order) -> tx.Maps:
    """Embossed wallpaper: rosettes and a diaper pattern, pressed into soft paper, painted over."""
    count = tx.whole(order.size, 0.12)
    place = (np.arange(order.resolution) + 0.5) / order.resolution * count
    s, t = 2.0 * np.pi * place[None, :], 2.0 * np.pi * place[:, None]
    x, y = (place[None, :] % 1.0) - 0.5, (place[:, None] % 1.0) - 0.5
    petals = np.hypot(x, y) - 0.2 - 0.09 * np.cos(8.0 * np.arctan2(y, x))
    flower = tx.smoothstep(0.03, -0.03, petals)
    heart = tx.smoothstep(0.06, 0.03, np.abs(np.hypot(x, y) - 0.07))
    lattice = tx.smoothstep(0.25, 0.0, np.abs(np.cos(s / 2.0) * np.cos(t / 2.0))) * (1.0 - flower)
    relief = flower * (0.7 - 0.45 * heart) + 0.6 * lattice
    stipple = tx.band_noise(order.rng, order.resolution, order.size, 0.0022)
    color = tx.drawn_color(order, ((0.78, 0.77, 0.73), (0.62, 0.62, 0.57), (0.36, 0.42, 0.38)))
    shade = 1.0 + 0.005 * stipple + 0.02 * relief
    height = 0.9e-3 * relief + 14e-6 * stipple
    return tx.finished(
        order, color * shade[..., None], height, tx.drawn_roughness(order, 0.55, 0.8)
    )


FAMILIES: Final[dict[str, tx.Family]] = {
    "chalk_paint": tx.Family(_chalk, 0.5, frozenset({"furniture", "object"})),
    "crackled_paint": tx.Family(_crackled, 0.35, frozenset({"furniture", "object"})),
    "embossed_wallpaper": tx.Family(_embossed, 0.6, frozenset({"wall", "ceiling"})),
    "flaking_paint": tx.Family(_flaking, 1.2, frozenset({"wall"})),
}
