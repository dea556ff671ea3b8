"""Where a scan shows space to walk in: a map of pixels, cut into rooms at narrow places."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.surfels import Surfels
from openrooms_usd.scan.walls import Walls

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

PIXEL: Final = 0.05
# Nothing narrower than twice this is a room, and rooms end where they are narrower, metres.
_NARROW: Final = 0.5
_LEAST_AREA: Final = 1.0
_MARGIN: Final = 0.6
_COURSE: Final = 0.1
_TOP: Final = 0.5
# Above this height a wall is taller than doors.
_DOORS: Final = 2.15
_SMALL_HOLE: Final = 1.5
_MOST_EYES: Final = 60
_RAYS: Final = 720
_FAR_SIGHT: Final = 10.0


@dataclass(frozen=True, eq=False)
class Spaces:
    """A map of the plan.

    Attributes:
        low: (2,) the corner of pixel (0, 0), metres.
        seen: (X, Y) whether the scan shows anything there.
        standing: (X, Y) metres of wall there that reach as high as walls were seen.
        rooms: (X, Y) the number of the room, from 1; 0 where there is none.
        middles: (R, 2) for each room the place farthest from its borders.
    """

    low: Array
    seen: Mask
    standing: Array
    rooms: NDArray[np.int32]
    middles: Array

    @property
    def high(self) -> Array:
        """(2,) the far corner of the map."""
        return np.asarray(self.low + PIXEL * np.array(self.seen.shape))

    def centres(self) -> Array:
        """(X * Y, 2) the pixels' middles."""
        x, y = (
            low + PIXEL * (np.arange(count) + 0.5)
            for low, count in zip(self.low, self.seen.shape, strict=True)
        )
        return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)


def find_spaces(pieces: Surfels, walls: Walls, eyes: Array | None = None) -> Spaces:
    """Map what a level scan shows and cut it into rooms.

    Args:
        pieces: In the level frame.
        walls: Its upright pieces.
        eyes: (V, 3) where the scanner stood; what it could see from there, up to the walls, is
            space too.
    """
    from scipy import ndimage

    plan = pieces.points[:, :2]
    inner = (np.quantile(plan, 0.0005, axis=0), np.quantile(plan, 0.9995, axis=0))
    low = np.floor((inner[0] - _MARGIN) / PIXEL) * PIXEL
    shape = tuple(np.ceil((inner[1] + _MARGIN - low) / PIXEL).astype(int))
    evidence = _map(plan, low, shape) > 0
    seen = ndimage.binary_closing(evidence, _disc(3), border_value=0)
    barrier = _barrier(walls, low, shape)
    if eyes is not None:
        seen |= _visible(barrier, (eyes[:, :2] - low) / PIXEL)
    seen |= _holes(seen, barrier)
    free = ndimage.binary_opening(seen & ~barrier, _disc(1))
    rooms, middles = _rooms(free, low)
    return Spaces(low, seen, _standing(walls, low, shape), rooms, middles)


def _disc(radius: int) -> Mask:
    x, y = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    return np.asarray(x * x + y * y <= radius * radius + 0.5)


def _map(plan: Array, low: Array, shape: tuple[int, ...], weight: Array | None = None) -> Array:
    pixel = np.floor((plan - low) / PIXEL).astype(int)
    within = ((pixel >= 0) & (pixel < shape)).all(axis=1)
    flat = np.ravel_multi_index(tuple(pixel[within].T), shape)
    weights = None if weight is None else weight[within]
    return np.bincount(flat, weights, int(np.prod(shape))).astype(np.float64).reshape(shape)


def _barrier(walls: Walls, low: Array, shape: tuple[int, ...]) -> Mask:
    """Where something stands higher than doors are, or, if nothing was seen there, anything."""
    from scipy import ndimage

    tall = walls.top > _DOORS + 0.15
    base = max(walls.top - _TOP, _DOORS) if tall else 0.3 * walls.top
    high = walls.height > base
    filled = _map(walls.points[high], low, shape, walls.weight[high])
    across = ndimage.uniform_filter(filled, 3) * 9.0 / 1.5
    full = (walls.top - base) / PIXEL
    return np.asarray((filled > 0) & (across > (0.35 if tall else 0.6) * full))


def _visible(barrier: Mask, eyes: Array) -> Mask:
    """What lies before the barrier as seen from places in the map; rays that meet none are void."""
    from scipy import ndimage

    some = eyes[:: max(1, len(eyes) // _MOST_EYES)]
    angles = np.linspace(0.0, 2.0 * np.pi, _RAYS, endpoint=False)
    toward = np.column_stack([np.cos(angles), np.sin(angles)])
    reach = np.arange(0.0, _FAR_SIGHT / PIXEL, 0.7)
    solid = np.pad(ndimage.binary_dilation(barrier, _disc(1)), 1)
    seen = np.zeros(solid.shape, bool)
    for eye in some:
        place = np.floor(eye + toward[:, None, :] * reach[None, :, None]).astype(int) + 1
        place = np.clip(place, 0, np.array(solid.shape) - 1)
        x, y = place[..., 0], place[..., 1]
        stopped = np.maximum.accumulate(solid[x, y], axis=1)
        kept = stopped[:, -1:] & ~stopped
        seen[x[kept], y[kept]] = True
    return np.asarray(ndimage.binary_closing(seen, _disc(1))[1:-1, 1:-1])


def _holes(seen: Mask, barrier: Mask) -> Mask:
    """Holes in what was seen that are small, or that more space than walls surrounds."""
    from scipy import ndimage

    holes, count = ndimage.label(~(seen | barrier))
    size = np.bincount(holes.ravel(), minlength=count + 1)
    rim = np.unique(np.concatenate([holes[0], holes[-1], holes[:, 0], holes[:, -1]]))
    shores = ndimage.grey_dilation(holes, footprint=_disc(1))
    by_free = np.bincount(shores[seen & ~barrier], minlength=count + 1)
    by_wall = np.bincount(shores[barrier], minlength=count + 1)
    filled = (size * PIXEL**2 < _SMALL_HOLE) | (by_free > by_wall)
    filled[0] = False
    filled[rim] = False
    return np.asarray(filled[holes])


def _standing(walls: Walls, low: Array, shape: tuple[int, ...]) -> Array:
    """Metres of wall a pixel: what stands up to the top, nothing where that is lower than doors."""
    if walls.top < _DOORS + 0.15:
        return np.zeros(shape)
    base = max(walls.top - _TOP, _DOORS)
    high = walls.height > base
    pieces = _map(walls.points[high], low, shape, walls.weight[high])
    return np.asarray(pieces * PIXEL**2 / (walls.top - base))


def _rooms(free: Mask, low: Array) -> tuple[NDArray[np.int32], Array]:
    from scipy import ndimage

    padded = np.pad(free, 1)
    distance = ndimage.distance_transform_edt(padded)[1:-1, 1:-1] * PIXEL
    markers, count = ndimage.label(distance > _NARROW)
    depth = np.clip(255.0 - distance * 80.0, 0, 254).astype(np.uint8)
    depth[~free] = 255
    flooded = ndimage.watershed_ift(depth, np.where(free, markers, 0).astype(np.int32))
    flooded[~free] = 0
    area = np.bincount(flooded.ravel(), minlength=count + 1) * PIXEL**2
    large = [number for number in range(1, count + 1) if area[number] > _LEAST_AREA]
    large.sort(key=lambda number: -area[number])
    rooms = np.zeros(free.shape, np.int32)
    middles = np.zeros((len(large), 2))
    for index, number in enumerate(large):
        rooms[flooded == number] = index + 1
        deepest = np.where(markers == number, distance, -1.0).argmax()
        middles[index] = low + PIXEL * (np.array(np.unravel_index(deepest, free.shape)) + 0.5)
    return rooms, middles
