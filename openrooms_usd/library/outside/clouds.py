"""Clouds over a sky: heaps with lit tops and grey bases, and thin veils above them.

Both lie on a plane overhead, so that they shrink towards the horizon as real ones do. A heap is lit
by the sun through what of it lies on the sun's side, and by the sky.
"""

from typing import Final

import numpy as np

from openrooms_usd.library.outside.noise import Floats, fractal_tile, sampled, step

# What of the light that falls on it a thick cloud sends to all sides.
_ALBEDO: Final = 0.75
# Tiles of noise for one height of the clouds above the eye; and how far the shade reaches.
_HEAP_SCALE, _VEIL_SCALE, _SHADE_REACH = 0.11, 0.06, 0.018
# Around the sun the sky stays clear, radians.
_CLEAR_ABOUT_SUN: Final = (0.12, 0.3)


def clouded(
    rng: np.random.Generator, way: Floats, sky: Floats, sun: Floats, beam: Floats, cover: float
) -> Floats:
    """(H, W, 3) nits of a sky with clouds before it.

    Args:
        rng: Draws them.
        way: (H, W, 3) unit vectors above the horizon.
        sky: (H, W, 3) nits without clouds.
        sun: (3,) unit vector towards the sun.
        beam: (3,) lux of each primary on what faces the sun.
        cover: The part of the sky behind heaps, 0 to 1.
    """
    if cover <= 0.0:
        return sky
    heap, veil = fractal_tile(rng, 1.75, 3), fractal_tile(rng, 1.6, 4)
    up = way[..., 2] + 0.07
    plan_x, plan_y = way[..., 0] / up, way[..., 1] / up
    away = np.arccos(np.clip(way @ sun, -1.0, 1.0))
    clear = step(*_CLEAR_ABOUT_SUN, away) * step(0.01, 0.1, way[..., 2])
    glare = 1.0 + 1.6 * np.exp(-((away / 0.6) ** 2))
    ambient = sky.mean(axis=(0, 1)) * 0.9
    light = np.asarray(beam * _ALBEDO / np.pi, dtype=np.float32)

    # Veils: long threads, thin everywhere.
    thread = sampled(veil, plan_x * _VEIL_SCALE, plan_y * _VEIL_SCALE * 0.3)
    thin = (0.3 * min(1.0, 2.0 * cover) * step(0.2, 2.2, thread) * clear)[..., None]
    found = sky * (1.0 - thin) + thin * (0.55 * light * glare[..., None] + ambient)

    edge = float(np.quantile(heap, 1.0 - cover))
    u, v = plan_x * _HEAP_SCALE, plan_y * _HEAP_SCALE
    thick = step(edge, edge + 1.1, sampled(heap, u, v)) * clear
    flat = np.asarray(sun[:2] / max(float(sun[2]), 0.35) * _SHADE_REACH, dtype=np.float32)
    before = step(edge, edge + 1.3, sampled(heap, u + flat[0], v + flat[1]))
    lit = np.exp(-1.5 * before) * (1.0 - 0.35 * thick) * glare
    color = light * lit[..., None] + ambient * (1.25 - 0.6 * thick[..., None])
    hidden = (1.0 - np.exp(-5.0 * thick))[..., None]
    return np.asarray(found * (1.0 - hidden) + color * hidden, dtype=np.float32)
