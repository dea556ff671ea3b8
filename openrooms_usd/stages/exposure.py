"""Estimates the mean luminance of a room from its lights alone, for the exposure of cameras.

The room is taken for an integrating sphere: what lamps give and what comes in through openings,
the flux F in lumen, spreads evenly over all that bounds it, the area A. At a reflectance r what
leaves a surface is F r / (A (1 - r)) lumen a square metre, and its luminance a pi-th of that
(W. E. Sumpner, The Direct Measurement of the Total Light Emitted from a Lamp, 1892).
"""

import math
from collections.abc import Iterator
from functools import reduce
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pxr import Usd

from openrooms_usd import names
from openrooms_usd.colorimetry import luminance
from openrooms_usd.errors import InputError
from openrooms_usd.stages.surroundings import Surroundings, surroundings
from openrooms_usd.usd.emitters import flux_share, world_area
from openrooms_usd.usd.frames import Z_UP_FROM_Y_UP
from openrooms_usd.usd.lights import DomeLight, MeshLight, read_lights, read_portals
from openrooms_usd.usd.textures import read_texture

Array: TypeAlias = NDArray[np.float64]

# Mean reflectance of walls, floor, ceiling and furniture.
_REFLECTANCE: Final = 0.5
# Share of daylight that passes frames, curtains and the depth of the wall.
_LET_IN: Final = 0.5
# Target of the mean luminance after exposure, as in previews.
_KEY: Final = 0.27
# So many pixels of a panorama along each side are taken together.
_BLOCK_PIXELS: Final = 4
# A room whose height nobody knows, metres.


def room_exposure(stage: Usd.Stage) -> float | None:
    """What to multiply luminance in nits by, so that the room is neither black nor white.

    Args:
        stage: A composed room, in metres with Z up.

    Returns:
        The factor; None for a room without a floor plan, or without light.
    """
    room = surroundings(stage)
    if not len(room.walls):
        return None
    floor, bounds = _areas(room)
    ways = [(p.world_from_portal[:3, 2], p.width * p.height) for p in read_portals(stage)]
    if room.ceiling is None:
        ways.append((np.array([0.0, 0.0, 1.0]), floor))
    flux = 0.0
    for light in read_lights(stage):
        if isinstance(light, MeshLight):
            area = world_area(stage.GetPrimAtPath(light.path))
            share = flux_share(stage.GetPrimAtPath(light.path), light.shaping)
            flux += math.pi * area * share * float(luminance(light.radiance))
        elif isinstance(light, DomeLight):
            lux = _illuminances(light, [outwards for outwards, _ in ways])
            flux += _LET_IN * sum(size * found for found, (_, size) in zip(lux, ways, strict=True))
    nits = flux * _REFLECTANCE / (bounds * (1.0 - _REFLECTANCE)) / math.pi
    return _KEY / nits if nits > 0.0 and math.isfinite(nits) else None


def _coarse(pixels: NDArray[np.float32]) -> NDArray[np.float32]:
    """The means of square blocks of pixels, about half a degree wide, as far as they fit."""
    count = math.gcd(*pixels.shape[:2], _BLOCK_PIXELS)
    # Sums of whole planes, which take a third of the time of a mean over two short axes.
    rows = reduce(np.add, [pixels[k::count] for k in range(count)])
    blocks = reduce(np.add, [rows[:, k::count] for k in range(count)])
    return np.asarray(blocks / np.float32(count**2))


def _areas(room: Surroundings) -> tuple[float, float]:
    """Of the floor, and of all that bounds the room; square metres."""
    (x0, y0), (x1, y1) = room.walls[:, 0].T, room.walls[:, 1].T
    floor = abs(float((x0 * y1 - x1 * y0).sum())) / 2.0
    height = names.ROOM_HEIGHT if room.ceiling is None else max(room.ceiling - room.floor, 0.0)
    return floor, 2.0 * floor + height * float(np.hypot(x1 - x0, y1 - y0).sum())


def _illuminances(dome: DomeLight, outwards: list[Array]) -> Iterator[float]:
    """Lux of planes that face outwards, by the half of the surroundings before each."""
    if dome.texture is None:
        yield from [math.pi * float(luminance(dome.radiance))] * len(outwards)
        return
    try:
        pixels = read_texture(dome.texture)[..., :3]
    except InputError:
        # Said by whoever draws it.
        yield from [0.0] * len(outwards)
        return
    nits = luminance(_coarse(pixels) * dome.radiance)
    height, width = nits.shape
    # The frame of the picture: its middle looks along -Y, a quarter from the left along +X.
    turn = Z_UP_FROM_Y_UP[:3, :3] @ dome.world_from_light[:3, :3].T
    edges = np.pi * (0.5 - np.arange(height + 1) / height)
    up, along = (
        0.5 * (edges[1:] + edges[:-1]),
        np.pi * (1.0 - 2.0 * (np.arange(width) + 0.5) / width),
    )
    weights = nits * -np.diff(np.sin(edges))[:, None] * (2.0 * np.pi / width)
    for way in outwards:
        x, y, z = turn @ way
        flat = x * np.sin(along) - y * np.cos(along)
        cosines = np.cos(up)[:, None] * flat + z * np.sin(up)[:, None]
        yield float((weights * np.clip(cosines, 0.0, None)).sum())
