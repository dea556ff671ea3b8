"""Where a scan shows space to walk in: a map of pixels, cut into rooms at narrow places."""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.surfels import Surfels
from openrooms_usd.scan.rooms.planmap import (
    PIXEL,
    at_sensor_height,
    disc,
    overlooked,
    plan_map,
    sighted,
)
from openrooms_usd.scan.rooms.walls import Walls

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Nothing narrower than twice this is a room, and rooms end where they are narrower, metres.
_ROOM_HALF_WIDTH_M: Final = 0.5
# What lies behind a gap narrower than twice this is of no room, metres: nobody passes there.
_GAP_HALF_WIDTH_M: Final = 0.2
_MIN_AREA_M2: Final = 1.0
# Columns and lamps are smaller, metres.
_FREESTANDING_M: Final = 0.8
_MAP_MARGIN_M: Final = 0.6
_COURSE_M: Final = 0.1
_WALL_TOP_M: Final = 0.5
# Above this height a wall is taller than doors.
_DOOR_HEIGHT_M: Final = 2.15
_SMALL_HOLE_M2: Final = 1.5


@dataclass(frozen=True, eq=False)
class Spaces:
    """A map of the plan.

    Attributes:
        low: (2,) the corner of pixel (0, 0), metres.
        seen: (X, Y) whether the scan shows anything there, or sensors looked over it.
        shown: (X, Y) whether the scan shows anything there.
        standing: (X, Y) metres of wall there that reach as high as walls were seen.
        rooms: (X, Y) the number of the room, from 1; 0 where there is none.
        middles: (R, 2) for each room the place farthest from its borders.
    """

    low: Array
    seen: Mask
    shown: Mask
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

    def numbers(self, places: Array) -> NDArray[np.int32]:
        """(N,) in which room each place (N, 2) lies; 0 in none."""
        pixel = np.floor((places - self.low) / PIXEL).astype(int)
        within = ((pixel >= 0) & (pixel < self.rooms.shape)).all(axis=1)
        numbers = np.zeros(len(places), np.int32)
        numbers[within] = self.rooms[tuple(pixel[within].T)]
        return numbers


def find_spaces(
    pieces: Surfels, walls: Walls, sensor_origins: Array | None = None, held: Array | None = None
) -> Spaces:
    """Map what a level scan shows and cut it into rooms.

    Args:
        pieces: In the level frame.
        walls: Its upright pieces.
        sensor_origins: (V, 3) where the scanner stood; what it could see from there, up to the
            walls, is space too.
        held: (H, 2) places that the map must reach.
    """
    from scipy import ndimage

    plan = pieces.points[:, :2]
    inner = np.quantile(plan, (0.0005, 0.9995), axis=0)
    if held is not None:
        reach = np.concatenate([inner, held])
        inner = np.stack([reach.min(axis=0), reach.max(axis=0)])
    low = np.floor((inner[0] - _MAP_MARGIN_M) / PIXEL) * PIXEL
    shape = tuple(np.ceil((inner[1] + _MAP_MARGIN_M - low) / PIXEL).astype(int))
    evidence = plan_map(plan, low, shape) > 0
    shown = ndimage.binary_closing(evidence, disc(3), border_value=0)
    if held is not None and len(held) == 1:
        shown |= sighted(plan, held, low, shape)
    seen = shown.copy()
    barrier = _barrier(walls, low, shape)
    if sensor_origins is not None:
        blocked = barrier | at_sensor_height(
            pieces, float(np.median(sensor_origins[:, 2])), low, shape
        )
        seen |= overlooked(blocked, (sensor_origins[:, :2] - low) / PIXEL)
    seen |= _holes(seen, barrier)
    free = ndimage.binary_opening(seen & ~barrier, disc(1))
    rooms, middles = _rooms(free, barrier, low)
    return Spaces(low, seen, shown, _standing(walls, low, shape), rooms, middles)


def _barrier(walls: Walls, low: Array, shape: tuple[int, ...]) -> Mask:
    """Where something stands higher than doors are, or, if nothing was seen there, anything."""
    from scipy import ndimage

    tall = walls.top > _DOOR_HEIGHT_M + 0.15
    base = max(walls.top - _WALL_TOP_M, _DOOR_HEIGHT_M) if tall else 0.3 * walls.top
    high = walls.height > base
    filled = plan_map(walls.points[high], low, shape, walls.weight[high])
    across = ndimage.uniform_filter(filled, 3) * 9.0 / 1.5
    full = (walls.top - base) / PIXEL
    return np.asarray((filled > 0) & (across > (0.35 if tall else 0.6) * full))


def _holes(seen: Mask, barrier: Mask) -> Mask:
    """Holes in what was seen that are small, or that more space than walls surrounds."""
    from scipy import ndimage

    holes, count = ndimage.label(~(seen | barrier))
    size = np.bincount(holes.ravel(), minlength=count + 1)
    rim = np.unique(np.concatenate([holes[0], holes[-1], holes[:, 0], holes[:, -1]]))
    shores = ndimage.grey_dilation(holes, footprint=disc(1))
    by_free = np.bincount(shores[seen & ~barrier], minlength=count + 1)
    by_wall = np.bincount(shores[barrier], minlength=count + 1)
    filled = (size * PIXEL**2 < _SMALL_HOLE_M2) | (by_free > by_wall)
    filled[0] = False
    filled[rim] = False
    return np.asarray(filled[holes])


def _standing(walls: Walls, low: Array, shape: tuple[int, ...]) -> Array:
    """Metres of wall a pixel: what stands up to the top, nothing where that is lower than doors."""
    if walls.top < _DOOR_HEIGHT_M + 0.15:
        return np.zeros(shape)
    base = max(walls.top - _WALL_TOP_M, _DOOR_HEIGHT_M)
    high = walls.height > base
    pieces = plan_map(walls.points[high], low, shape, walls.weight[high])
    return np.asarray(pieces * PIXEL**2 / (walls.top - base))


def _flooded(distance: Array, markers: NDArray[np.integer[Any]], count: int) -> NDArray[np.int32]:
    """Each pixel's marker: that which it reaches without passing a narrower place than needed.

    A watershed as a minimum spanning forest (Cousty et al., "Watershed cuts", 2009).

    Args:
        distance: (X, Y) to the nearest border, metres; 0 where there is no space.
        markers: (X, Y) numbers from 1 in connected pieces; else 0.
        count: Of the markers.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components, minimum_spanning_tree

    number = np.arange(distance.size).reshape(distance.shape)
    pairs = [(number[1:], number[:-1]), (number[:, 1:], number[:, :-1])]
    a, b = (np.concatenate([pair[i].ravel() for pair in pairs]) for i in (0, 1))
    narrow = np.minimum(distance.ravel()[a], distance.ravel()[b])
    a, b, narrow = a[narrow > 0], b[narrow > 0], narrow[narrow > 0]
    chosen = [int((markers == i).argmax()) for i in range(1, count + 1)]
    # A root that is nearest to all markers: the tree falls into their pieces without it.
    root = np.full(count, distance.size)
    rows, columns = np.concatenate([a, root]), np.concatenate([b, chosen])
    # Among ways that are as narrow, the one towards the wider place.
    wide = np.maximum(distance.ravel()[a], distance.ravel()[b])
    steep = 1.0 + 2.0 * distance.max() - narrow - 1e-3 * wide
    weights = np.concatenate([steep, np.full(count, 0.5)])
    graph = csr_array((weights, (rows, columns)), shape=(distance.size + 1,) * 2)
    tree = minimum_spanning_tree(graph).tocoo()
    kept = (tree.row < distance.size) & (tree.col < distance.size)
    forest = csr_array((tree.data[kept], (tree.row[kept], tree.col[kept])), shape=graph.shape)
    _, piece = connected_components(forest, directed=False)
    names = np.zeros(len(piece), np.int32)
    names[piece[chosen]] = np.arange(1, count + 1)
    return np.asarray(np.where(distance > 0, names[piece[:-1]].reshape(distance.shape), 0))


def _parting(barrier: Mask) -> Mask:
    """The barriers that may part rooms: what stands free and is small does not, nor what hangs."""
    from scipy import ndimage

    groups, count = ndimage.label(barrier, np.ones((3, 3)))
    places = ndimage.find_objects(groups)
    extents = [max(rows.stop - rows.start for rows in place) for place in places]
    large = np.array([False, *(extent * PIXEL > _FREESTANDING_M for extent in extents)])
    return np.asarray(large[groups]) if count else barrier


def _markers(width: Array) -> tuple[NDArray[np.integer[Any]], int]:
    """Pieces of plan, one for each space: the wide ones, and what only a slit joins to them."""
    from scipy import ndimage

    markers, count = ndimage.label(width > _ROOM_HALF_WIDTH_M)
    pieces, others = ndimage.label(width > _GAP_HALF_WIDTH_M)
    lone = np.setdiff1d(np.arange(1, others + 1), pieces[markers > 0])
    for number, piece in enumerate(lone, count + 1):
        markers[pieces == piece] = number
    return markers, count + len(lone)


def _rooms(free: Mask, barrier: Mask, low: Array) -> tuple[NDArray[np.int32], Array]:
    from scipy import ndimage

    # Rooms end where walls leave little way, not where little was seen.
    walls = _parting(barrier)
    walled = ndimage.distance_transform_edt(~walls) * PIXEL if walls.any() else 1e3 * free
    width = np.where(free, walled, 0.0)
    markers, count = _markers(width)
    flooded = _flooded(width, markers, count)
    area = np.bincount(flooded.ravel(), minlength=count + 1) * PIXEL**2
    wide = ndimage.maximum(width, flooded, np.arange(count + 1)) > _ROOM_HALF_WIDTH_M
    large = [n for n in range(1, count + 1) if area[n] > _MIN_AREA_M2 and wide[n]]
    large.sort(key=lambda number: -area[number])
    depth = ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1]
    rooms = np.zeros(free.shape, np.int32)
    middles = np.zeros((len(large), 2))
    for index, number in enumerate(large):
        rooms[flooded == number] = index + 1
        deepest = np.where(markers == number, depth, -1.0).argmax()
        middles[index] = low + PIXEL * (np.array(np.unravel_index(deepest, free.shape)) + 0.5)
    return rooms, middles
