"""Families of plastic parts: what the mould, the tool and the printer leave on them."""

from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.tables import read_table

_PALETTES: Final = read_table(__file__, "palettes.toml")

COLORS: Final[tuple[tx.Color, ...]] = _PALETTES["parts_colors"]
DARK: Final[tuple[tx.Color, ...]] = _PALETTES["parts_dark"]


def _plain(order: tx.TextureParams, colors: tuple[tx.Color, ...] = COLORS) -> tx.Field:
    """(N, N, 3) one colour through and through."""
    color = tx.drawn_color(order, (colors[int(order.rng.integers(len(colors)))],), 0.08)
    return np.broadcast_to(color, (order.resolution, order.resolution, 3))


def _moulded(order: tx.TextureParams) -> tx.Maps:
    """Polished mould: sink marks of some centimetres, and flow lines where the melt ran."""
    flow = tx.noise(order, 0.007, 0.12)
    height = 14e-6 * tx.noise(order, 0.045) + 0.8e-6 * flow
    shade = 1.0 + 0.012 * flow
    roughness = tx.drawn_roughness(order, 0.12, 0.24) + 0.012 * flow
    return tx.finished(order, _plain(order) * shade[..., None], height, roughness)


def _leather_grain(order: tx.TextureParams) -> tx.Maps:
    """Grain of dashboards and cases: rounded pads with valleys, finer ones within."""
    warp = 0.0004 * tx.noise(order, 0.004), 0.0004 * tx.noise(order, 0.004)
    pads = tx.scattered_cells(order, 0.0024, 1.0, warp)
    valley = np.exp(-((pads.edge / 0.00022) ** 2))
    own = order.rng.uniform(0.6, 1.0, pads.count)[pads.index]
    height = 70e-6 * own * (1.0 - valley) + 5e-6 * tx.noise(order, 0.0005)
    roughness = tx.drawn_roughness(order, 0.42, 0.58) + 0.08 * valley
    return tx.finished(order, _plain(order) * (1.0 - 0.08 * valley)[..., None], height, roughness)


def _spark_eroded(order: tx.TextureParams) -> tx.Maps:
    """Spark-eroded mould (VDI 3400): craters over craters, equal in all directions."""
    crater = np.minimum(
        np.abs(tx.band_noise(order.rng, order.resolution, order.size, 0.0008)),
        np.abs(tx.noise(order, 0.0006)) + 0.2,
    )
    height = 9e-6 * np.sqrt(crater + 0.01) + 2e-6 * tx.noise(order, 0.003)
    shade = 1.0 + 0.02 * (crater - crater.mean())
    roughness = tx.drawn_roughness(order, 0.5, 0.7)
    return tx.finished(order, _plain(order) * shade[..., None], height, roughness + 0.02 * crater)


def _hairline(order: tx.TextureParams) -> tx.Maps:
    """Brushed face of appliances: hairlines along t, each some centimetres long."""
    hair = tx.noise(order, 0.00035, 0.05) + 0.7 * tx.noise(order, 0.0008, 0.12)
    height = 1.6e-6 * hair
    shade = 1.0 + 0.03 * hair
    roughness = tx.drawn_roughness(order, 0.3, 0.42) + 0.02 * hair
    return tx.finished(order, _plain(order) * shade[..., None], height, roughness)


def _ribbed(order: tx.TextureParams) -> tx.Maps:
    """Round ribs along t, as grips and grilles have."""
    count = tx.whole(order.size, 0.006)
    place = (np.arange(order.resolution) + 0.5) / order.resolution * count % 1.0
    groove = np.clip((np.abs(place - 0.5) - 0.33) / 0.17, 0.0, 1.0)
    rib = 0.0018 * np.sqrt(1.0 - groove**1.5 * 0.98)[None, :]
    grain = tx.noise(order, 0.0006)
    shade = 1.0 - 0.12 * (groove**2)[None, :] + 0.004 * grain
    roughness = tx.drawn_roughness(order, 0.3, 0.5) + 0.01 * grain
    return tx.finished(order, _plain(order) * shade[..., None], rib + 2e-6 * grain, roughness)


def _printed(order: tx.TextureParams) -> tx.Maps:
    """Printed in layers: threads across t, each a little off, with blobs where they begin."""
    count = tx.whole(order.size, 0.0003)
    place = (np.arange(order.resolution)[:, None] + 0.5) / order.resolution * count
    shift = order.rng.uniform(-1.0, 1.0, count)[np.floor(place).astype(np.int64) % count]
    thread = np.sqrt(np.clip(1.0 - (2.0 * (place % 1.0) - 1.0) ** 2, 0.02, 1.0))
    ghost = tx.noise(order, 0.004, 0.03)
    height = 60e-6 * thread + 9e-6 * shift + 6e-6 * ghost
    blob = tx.smoothstep(1.8, 2.5, tx.noise(order, 0.0015, 0.0008))
    shade = 1.0 + 0.05 * (thread - 1.0) + 0.015 * shift + 0.01 * ghost
    roughness = tx.drawn_roughness(order, 0.32, 0.5) + 0.03 * shift + 0.05 * blob
    return tx.finished(order, _plain(order) * shade[..., None], height + 40e-6 * blob, roughness)


def _mesh(order: tx.TextureParams, pitch: float, share: float) -> tx.Maps:
    """Sheet with round holes in rows shifted by half; the holes are dark."""
    columns = tx.whole(order.size, pitch)
    rows = tx.whole(order.size, pitch * np.sqrt(0.75), 2)
    s = (np.arange(order.resolution) + 0.5) / order.resolution * columns
    t = (np.arange(order.resolution)[:, None] + 0.5) / order.resolution * rows
    across = (s + 0.5 * (np.floor(t) % 2)) % 1.0 - 0.5
    far = np.hypot(across, (t % 1.0 - 0.5) * np.sqrt(0.75)) * pitch
    inside = share * pitch - far
    hole = tx.smoothstep(-0.0001, 0.0001, inside)
    bevel = np.clip(inside / 0.0003 + 1.0, 0.0, 1.0)
    fine = tx.noise(order, 0.0006)
    albedo = tx.mixed(hole, np.full(3, 0.02), _plain(order, COLORS[2:5]))
    height = -0.12e-3 * bevel**2 - 0.5e-3 * hole + 2e-6 * fine
    return tx.finished(order, albedo, height, tx.drawn_roughness(order, 0.4, 0.55) + 0.4 * hole)


def _pyramids(order: tx.TextureParams) -> tx.Maps:
    """Prismatic sheet of lamps: square pyramids side by side."""
    count = tx.whole(order.size, 0.004)
    place = np.abs((np.arange(order.resolution) + 0.5) / order.resolution * count % 1.0 - 0.5)
    peak = 0.5 - np.maximum(place[None, :], place[:, None])
    wave = tx.noise(order, 0.03)
    albedo = tx.drawn_color(order, ((0.78, 0.79, 0.79), (0.72, 0.73, 0.72)))
    shade = 1.0 - 0.05 * tx.smoothstep(0.08, 0.0, peak)
    height = 0.0022 * np.minimum(peak, 0.46) + 4e-6 * wave
    return tx.shaded(order, albedo, shade, height, (0.1, 0.2))


def _frosted(order: tx.TextureParams) -> tx.Maps:
    """Frosted acrylic: etched evenly, with soft larger waves of the cast sheet."""
    etch = tx.noise(order, 0.00025)
    cast = tx.fractal(order, 0.06, 0.8)
    albedo = tx.drawn_color(order, ((0.74, 0.76, 0.76), (0.66, 0.7, 0.71), (0.5, 0.62, 0.66)))
    shade = 1.0 + 0.008 * cast
    height = 0.5e-6 * etch + 30e-6 * cast
    return tx.shaded(order, albedo, shade, height, (0.4, 0.6))


def _foam(order: tx.TextureParams) -> tx.Maps:
    """Expanded polystyrene: beads pressed against each other."""
    warp = 0.0003 * tx.noise(order, 0.002), 0.0003 * tx.noise(order, 0.002)
    beads = tx.scattered_cells(order, 0.0042, 1.0, warp)
    dome = np.clip(beads.edge / 0.0016, 0.0, 1.0)
    tone = order.rng.uniform(-0.015, 0.015, beads.count)[beads.index]
    own = order.rng.uniform(-1.0, 1.0, beads.count)[beads.index]
    albedo = tx.drawn_color(order, ((0.82, 0.82, 0.81), (0.6, 0.6, 0.61)), 0.04)
    shade = 1.0 + tone - 0.12 * (1.0 - dome) ** 3
    height = 0.25e-3 * np.sqrt(dome) + 0.05e-3 * own
    return tx.shaded(order, albedo, shade, height, (0.6, 0.75))


def _glitter(order: tx.TextureParams) -> tx.Maps:
    """Clear plastic over hexagons of foil, most of them dull, some in the light."""
    flakes = tx.scattered_cells(order, 0.0011, 1.0)
    tilt = order.rng.uniform(-1.0, 1.0, (2, flakes.count))
    shine = order.rng.random(flakes.count) ** 3
    foil = tx.smoothstep(0.0, 0.00006, 0.00042 - flakes.radius)
    color = tx.drawn_color(order, ((0.42, 0.33, 0.12), (0.36, 0.36, 0.38), (0.4, 0.10, 0.2)))
    bright = 0.35 + 1.3 * shine[flakes.index]
    albedo = tx.mixed(
        foil, color * bright[..., None], np.broadcast_to(0.3 * color, (*foil.shape, 3))
    )
    lean = flakes.across * tilt[0][flakes.index] + flakes.up * tilt[1][flakes.index]
    roughness = tx.drawn_roughness(order, 0.12, 0.2) + 0.1 * foil
    return tx.finished(order, albedo, 0.08 * lean * foil + 3e-6 * tx.noise(order, 0.01), roughness)


def _wicker(order: tx.TextureParams) -> tx.Maps:
    """Flat bands woven like cane, as garden furniture and baskets have."""
    count = tx.whole(order.size, 0.012, 2)
    place = (np.arange(order.resolution) + 0.5) / order.resolution * count
    s, t = place[None, :], place[:, None]
    cell_s, cell_t = np.floor(s), np.floor(t)
    x, y = s - cell_s - 0.5, t - cell_t - 0.5
    over = (cell_s + cell_t) % 2 == 0
    across, along = np.where(over, x, y), np.where(over, y, x)
    inside = 0.44 - np.abs(across)
    band = tx.smoothstep(0.0, 0.02, inside)
    crown = np.cos(np.pi * along) * 1.1e-3 + 0.35e-3 * np.sqrt(
        np.clip(1 - (across / 0.44) ** 2, 0, 1)
    )
    thread = np.where(over, tx.noise(order, 0.0008, 0.03), tx.noise(order, 0.03, 0.0008))
    color = tx.drawn_color(order, ((0.16, 0.10, 0.06), (0.06, 0.055, 0.05), (0.33, 0.28, 0.21)))
    shade = (1.0 + 0.09 * thread) * (0.25 + 0.75 * band) * (0.75 + 0.25 * np.cos(np.pi * along))
    height = band * crown - 1.0e-3 * (1.0 - band) + 15e-6 * thread
    return tx.shaded(order, color, shade, height, (0.4, 0.55))


_PARTS: Final[frozenset[tx.Use]] = frozenset({"object", "furniture"})
_OBJECTS: Final[frozenset[tx.Use]] = frozenset({"object"})

FAMILIES: Final[dict[str, tx.Family]] = {
    "foam_beads": tx.Family(_foam, 0.15, frozenset({"object", "ceiling"})),
    "frosted_acrylic": tx.Family(_frosted, 0.3, _PARTS),
    "glitter_plastic": tx.Family(_glitter, 0.1, _OBJECTS),
    "hairline_plastic": tx.Family(_hairline, 0.2, _PARTS, grain=True),
    "leather_grain_plastic": tx.Family(_leather_grain, 0.1, _PARTS),
    "moulded_plastic": tx.Family(_moulded, 0.3, _PARTS),
    "perforated_plastic": tx.Family(partial(_mesh, pitch=0.0026, share=0.3), 0.1, _OBJECTS),
    "printed_layers": tx.Family(_printed, 0.06, _OBJECTS),
    "prismatic_sheet": tx.Family(_pyramids, 0.12, frozenset({"object", "ceiling"})),
    "ribbed_plastic": tx.Family(_ribbed, 0.15, _PARTS, grain=True),
    "spark_eroded_plastic": tx.Family(_spark_eroded, 0.08, _PARTS),
    "woven_resin": tx.Family(_wicker, 0.2, _PARTS),
}
