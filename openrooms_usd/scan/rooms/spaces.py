"""The free space of a scan's plan, segmented into rooms at narrow places by a watershed.

A ceiling that ends at walls nearly everywhere was scanned whole. What it does not cover is not
indoors: a yard seen through a gate, a corridor through a door. A ceiling that ends amid the room
was scanned in part, and says nothing about the rest.
"""

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.scan.points.surfels import Surfels
from openrooms_usd.scan.rooms.directions import UPRIGHT_SINE
from openrooms_usd.scan.rooms.walls import Walls

# Half the least width of a room, metres; narrower places separate rooms.
_ROOM_HALF_WIDTH_M: Final = 0.5
# Half the least width of a gap that people pass, metres; space behind narrower ones is separate.
_GAP_HALF_WIDTH_M: Final = 0.2
_MIN_AREA_M2: Final = 1.0
# Freestanding things larger than this may separate rooms, metres; columns and lamps are smaller.
_FREESTANDING_M: Final = 0.8
_MAP_MARGIN_M: Final = 0.6
_COURSE_M: Final = 0.1
_WALL_TOP_M: Final = 0.5
# Above this height only walls reach, no doors.
_DOOR_HEIGHT_M: Final = 2.15
_LINTEL_M: Final = 0.15  # least height of what is seen above doors
_SMALL_HOLE_M2: Final = 1.5
_BESIDE_WALL_M: Final = 0.3
_MIN_CEILING_M: Final = 1.9
# Least vertical component of a ceiling's normals, level or sloping.
_FACING_DOWN_COS: Final = 0.5
# Lamps, beams and gaps of a sparse scan in a ceiling are narrower, metres.
_GAP_M: Final = 0.6
_MIN_ROOF_M2: Final = 2.0
# A whole ceiling ends within this distance of walls along this part of its edge.
_BESIDE_ROOF_WALL_M: Final = 0.35
_WHOLE_SHARE: Final = 0.85


@dataclass(frozen=True, eq=False)
class Spaces:
    """A map of the plan.

    Attributes:
        low: (2,) the corner of pixel (0, 0), metres.
        seen: (X, Y) whether there are surfels, or free space on the sensors' rays.
        scanned: (X, Y) whether there are surfels.
        standing: (X, Y) metres of full-height wall.
        rooms: (X, Y) the number of the room, from 1; 0 where there is none.
        middles: (R, 2) for each room the place farthest from its borders.
        indoors: (X, Y) what whole ceilings cover, in rooms that have one; all of the others.
    """

    low: Array
    seen: Mask
    scanned: Mask
    standing: Array
    rooms: NDArray[np.int32]
    middles: Array
    indoors: Mask

    @property
    def high(self) -> Array:
        """(2,) the far corner of the map."""
        return np.asarray(self.low + PIXEL_M * np.array(self.seen.shape))

    def centres(self) -> Array:
        """(X * Y, 2) the pixels' middles."""
        x, y = (
            low + PIXEL_M * (np.arange(count) + 0.5)
            for low, count in zip(self.low, self.seen.shape, strict=True)
        )
        return np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)

    def numbers(self, places: Array) -> NDArray[np.int32]:
        """(N,) the room of each place (N, 2); 0 for none."""
        pixel = np.floor((places - self.low) / PIXEL_M).astype(int)
        within = ((pixel >= 0) & (pixel < self.rooms.shape)).all(axis=1)
        numbers = np.zeros(len(places), np.int32)
        numbers[within] = self.rooms[tuple(pixel[within].T)]
        return numbers


def find_spaces(
    pieces: Surfels,
    walls: Walls,
    sensor_origins: Array | None = None,
    included: Array | None = None,
) -> Spaces:
    """Map the plan of a level scan and segment it into rooms.

    Args:
        pieces: Surfels in the level frame.
        walls: The vertical ones.
        sensor_origins: (V, 3) metres; free space on their rays counts as seen.
        included: (H, 2) places that the map must contain.
    """
    from scipy import ndimage

    plan = pieces.points[:, :2]
    inner = np.quantile(plan, (0.0005, 0.9995), axis=0)
    if included is not None:
        reach = np.concatenate([inner, included])
        inner = np.stack([reach.min(axis=0), reach.max(axis=0)])
    low = np.floor((inner[0] - _MAP_MARGIN_M) / PIXEL_M) * PIXEL_M
    shape = tuple(np.ceil((inner[1] + _MAP_MARGIN_M - low) / PIXEL_M).astype(int))
    evidence = plan_map(plan, low, shape) > 0
    scanned = ndimage.binary_closing(evidence, disc(3), border_value=0)
    if included is not None and len(included) == 1:
        scanned |= free_along_rays(plan, included, low, shape)
    seen = scanned.copy()
    barrier = _barrier(walls, low, shape)
    if sensor_origins is not None:
        blocked = barrier | at_sensor_height(
            pieces, float(np.median(sensor_origins[:, 2])), low, shape
        )
        seen |= free_space(blocked, (sensor_origins[:, :2] - low) / PIXEL_M)
    seen |= _holes(seen, barrier)
    free = ndimage.binary_opening(seen & ~barrier, disc(1))
    roof = roofed(pieces, barrier, low)
    rooms, count = _rooms(free, barrier)
    indoors = _indoors(rooms, roof, count)
    middles = _middles(rooms, free & indoors, low, count)
    return Spaces(low, seen, scanned, _standing(walls, low, shape), rooms, middles, indoors)


def walled_shares(spaces: Spaces, walls: Walls) -> Array:
    """(R + 1,) by the spaces' numbers, the part of the border that is beside vertical surfels."""
    from scipy import ndimage

    bare = plan_map(walls.points, spaces.low, spaces.rooms.shape) == 0
    beside = ndimage.distance_transform_edt(bare) * PIXEL_M < _BESIDE_WALL_M
    inner = ndimage.minimum_filter(spaces.rooms, 3) == ndimage.maximum_filter(spaces.rooms, 3)
    count = len(spaces.middles) + 1
    rim = np.bincount(spaces.rooms[~inner], minlength=count)
    near = np.bincount(spaces.rooms[~inner & beside], minlength=count)
    return np.asarray(near / np.maximum(rim, 1))


def _indoors(rooms: NDArray[np.int32], roof: Mask, count: int) -> Mask:
    """(X, Y) the roofs of rooms that have one, and all of the others."""
    area = np.bincount(rooms[roof], minlength=count + 1) * PIXEL_M**2
    bare = area < _MIN_AREA_M2
    return np.asarray(roof | bare[rooms])


def _barrier(walls: Walls, low: Array, shape: tuple[int, ...]) -> Mask:
    """(X, Y) pixels with surfels above doors, or, if walls were not scanned so high, with any."""
    from scipy import ndimage

    tall = walls.top > _DOOR_HEIGHT_M + _LINTEL_M
    base, full = _above_doors(walls) if tall else (0.3 * walls.top, 0.7 * walls.top)
    high = walls.height > base
    weight = walls.weight / full
    filled = plan_map(walls.points[high], low, shape, weight[high]) * PIXEL_M
    across = ndimage.uniform_filter(filled, 3) * 9.0 / 1.5
    return np.asarray((filled > 0) & (across > (0.35 if tall else 0.6)))


def _above_doors(walls: Walls) -> tuple[Array, Array]:
    """(M,) the height from which surfels are above doors, and the metres from there to the top."""
    tops = walls.tops(walls.points, walls.normals)
    base = np.maximum(tops - _WALL_TOP_M, np.minimum(_DOOR_HEIGHT_M, tops - _LINTEL_M))
    return base, np.maximum(tops - base, _LINTEL_M)


def _holes(seen: Mask, barrier: Mask) -> Mask:
    """Holes in the seen area that are small, or that border more on space than on walls."""
    from scipy import ndimage

    holes, count = ndimage.label(~(seen | barrier))
    size = np.bincount(holes.ravel(), minlength=count + 1)
    rim = np.unique(np.concatenate([holes[0], holes[-1], holes[:, 0], holes[:, -1]]))
    shores = ndimage.grey_dilation(holes, footprint=disc(1))
    by_free = np.bincount(shores[seen & ~barrier], minlength=count + 1)
    by_wall = np.bincount(shores[barrier], minlength=count + 1)
    filled = (size * PIXEL_M**2 < _SMALL_HOLE_M2) | (by_free > by_wall)
    filled[0] = False
    filled[rim] = False
    return np.asarray(filled[holes])


def _standing(walls: Walls, low: Array, shape: tuple[int, ...]) -> Array:
    """(X, Y) metres of full-height wall a pixel; 0 if walls were not scanned above doors."""
    if walls.top < _DOOR_HEIGHT_M + _LINTEL_M:
        return np.zeros(shape)
    base, full = _above_doors(walls)
    high = walls.height > base
    pieces = plan_map(walls.points[high], low, shape, (walls.weight / full)[high])
    return np.asarray(pieces * PIXEL_M**2)


def _watershed(distance: Array, markers: NDArray[np.integer[Any]], count: int) -> NDArray[np.int32]:
    """Watershed: each pixel gets the marker to which its path is the widest.

    Computed as a minimum spanning forest (Cousty et al., "Watershed cuts", 2009).

    Args:
        distance: (X, Y) to the nearest border, metres; 0 where there is no space.
        markers: (X, Y) numbers from 1, each connected; else 0.
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
    # A root joined to all markers by the lightest edges: without it the tree becomes the forest.
    root = np.full(count, distance.size)
    rows, columns = np.concatenate([a, root]), np.concatenate([b, chosen])
    # Ties are broken towards the wider place.
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


def _separating(barrier: Mask) -> Mask:
    """The barriers that may separate rooms: without small freestanding or hanging things."""
    from scipy import ndimage

    groups, count = ndimage.label(barrier, np.ones((3, 3)))
    places = [place for place in ndimage.find_objects(groups) if place is not None]
    extents = [max(rows.stop - rows.start for rows in place) for place in places]
    large = np.array([False, *(extent * PIXEL_M > _FREESTANDING_M for extent in extents)])
    return np.asarray(large[groups]) if count else barrier


def _markers(width: Array) -> tuple[NDArray[np.integer[Any]], int]:
    """Watershed markers: wide parts of the plan, and parts that only narrow gaps join to them."""
    from scipy import ndimage

    markers, count = ndimage.label(width > _ROOM_HALF_WIDTH_M)
    pieces, others = ndimage.label(width > _GAP_HALF_WIDTH_M)
    lone = np.setdiff1d(np.arange(1, others + 1), pieces[markers > 0])
    for number, piece in enumerate(lone, count + 1):
        markers[pieces == piece] = number
    return markers, count + len(lone)


def _rooms(free: Mask, barrier: Mask) -> tuple[NDArray[np.int32], int]:
    """(X, Y) the number of the room, the largest first, and how many there are."""
    from scipy import ndimage

    # The width is measured to walls, not to the border of the scan.
    walls = _separating(barrier)
    walled = ndimage.distance_transform_edt(~walls) * PIXEL_M if walls.any() else 1e3 * free
    width = np.where(free, walled, 0.0)
    markers, count = _markers(width)
    flooded = _watershed(width, markers, count)
    area = np.bincount(flooded.ravel(), minlength=count + 1) * PIXEL_M**2
    wide = ndimage.maximum(width, flooded, np.arange(count + 1)) > _ROOM_HALF_WIDTH_M
    large = [n for n in range(1, count + 1) if area[n] > _MIN_AREA_M2 and wide[n]]
    large.sort(key=lambda number: -area[number])
    rooms = np.zeros(free.shape, np.int32)
    for index, number in enumerate(large, 1):
        rooms[flooded == number] = index
    return rooms, len(large)


def _middles(rooms: NDArray[np.int32], free: Mask, low: Array, count: int) -> Array:
    """(R, 2) for each room the place farthest from the borders of free space."""
    from scipy import ndimage

    depth = ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1]
    places = [np.where(rooms == n, depth, -1.0).argmax() for n in range(1, count + 1)]
    pixels = np.column_stack(np.unravel_index(np.array(places, int), rooms.shape))
    return np.asarray(low + PIXEL_M * (pixels + 0.5))


def roofed(pieces: Surfels, barrier: Mask, low: Array) -> Mask:
    """(X, Y) what whole ceilings cover; all where the scan shows no whole one.

    Args:
        pieces: Surfels in the level frame.
        barrier: (X, Y) walls.
        low: (2,) the corner of pixel (0, 0), metres.
    """
    from scipy import ndimage

    above = (pieces.points[:, 2] > _MIN_CEILING_M) & (
        np.abs(pieces.normals[:, 2]) > _FACING_DOWN_COS
    )
    ceiling = plan_map(pieces.points[above, :2], low, barrier.shape) > 0
    radius = int(_GAP_M / 2.0 / PIXEL_M)
    closed = ndimage.binary_closing(np.pad(ceiling, radius), disc(radius))
    closed = ndimage.binary_fill_holes(closed)[radius:-radius, radius:-radius]
    closed &= ~barrier
    beside = ndimage.distance_transform_edt(~barrier) * PIXEL_M < _BESIDE_ROOF_WALL_M
    groups, count = ndimage.label(closed)
    edge = closed & ~ndimage.binary_erosion(closed)
    size, rim, walled = (
        np.bincount(groups[mask], minlength=count + 1) for mask in (closed, edge, edge & beside)
    )
    large = size * PIXEL_M**2 > _MIN_ROOF_M2
    whole = large & (walled > _WHOLE_SHARE * rim)
    whole[0] = False
    if not whole.any():
        return np.ones(barrier.shape, bool)
    return np.asarray(whole[groups])


# Grids of the plan: occupancy, and free space along the sensors' rays.

PIXEL_M: Final = 0.05
# Half the height of the slab at the sensors that is tested for occlusion, metres, and the part of
# it that must be filled.
_VIEW_HALF_HEIGHT_M: Final = 0.25
_BLOCKING_SHARE: Final = 0.5
_MOST_SENSORS: Final = 60
_MOST_SIGHTS: Final = 20_000
_RAYS_PER_TURN: Final = 720
_MAX_SIGHT_M: Final = 10.0


def disc(radius: int) -> Mask:
    """A disc as a structuring element."""
    x, y = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    return np.asarray(x * x + y * y <= radius * radius + 0.5)


def plan_map(plan: Array, low: Array, shape: tuple[int, ...], weight: Array | None = None) -> Array:
    """(X, Y) number, or total weight, of points (N, 2) a pixel; the grid begins at low (2,)."""
    pixel = np.floor((plan - low) / PIXEL_M).astype(int)
    within = ((pixel >= 0) & (pixel < shape)).all(axis=1)
    flat = np.ravel_multi_index(tuple(pixel[within].T), shape)
    weights = None if weight is None else weight[within]
    return np.bincount(flat, weights, int(np.prod(shape))).astype(np.float64).reshape(shape)


def at_sensor_height(pieces: Surfels, origin: float, low: Array, shape: tuple[int, ...]) -> Mask:
    """(X, Y) pixels with occluders at the height of the sensors."""
    from scipy import ndimage

    upright = np.abs(pieces.normals[:, 2]) < UPRIGHT_SINE
    facing = upright & (np.abs(pieces.points[:, 2] - origin) < _VIEW_HALF_HEIGHT_M)
    filled = plan_map(pieces.points[facing, :2], low, shape)
    across = ndimage.uniform_filter(filled, 3) * 9.0 / 1.5
    return np.asarray(
        (filled > 0) & (across > _BLOCKING_SHARE * 2.0 * _VIEW_HALF_HEIGHT_M / PIXEL_M)
    )


def free_space(barrier: Mask, sensor_origins: Array) -> Mask:
    """(X, Y) pixels on rays from sensors (pixels) up to a barrier; others do not count."""
    from scipy import ndimage

    some = sensor_origins[:: max(1, len(sensor_origins) // _MOST_SENSORS)]
    angles = np.linspace(0.0, 2.0 * np.pi, _RAYS_PER_TURN, endpoint=False)
    toward = np.column_stack([np.cos(angles), np.sin(angles)])
    reach = np.arange(0.0, _MAX_SIGHT_M / PIXEL_M, 0.7)
    solid = np.pad(ndimage.binary_dilation(barrier, disc(1)), 1)
    seen = np.zeros(solid.shape, bool)
    for origin in some:
        place = np.floor(origin + toward[:, None, :] * reach[None, :, None]).astype(int) + 1
        place = np.clip(place, 0, np.array(solid.shape) - 1)
        x, y = place[..., 0], place[..., 1]
        stopped = np.maximum.accumulate(solid[x, y], axis=1)
        kept = stopped[:, -1:] & ~stopped
        seen[x[kept], y[kept]] = True
    return np.asarray(ndimage.binary_closing(seen, disc(1))[1:-1, 1:-1])


def free_along_rays(plan: Array, sensor_origins: Array, low: Array, shape: tuple[int, ...]) -> Mask:
    """(X, Y) pixels on the segments between points (N, 2) and sensors (E, 2)."""
    some = plan[:: max(1, len(plan) // _MOST_SIGHTS)]
    seen = np.zeros(shape, bool)
    for origin in sensor_origins:
        longest = float(np.linalg.norm(some - origin, axis=1).max(initial=0.0))
        part = np.linspace(0.0, 1.0, int(longest / (0.7 * PIXEL_M)) + 2)[:, None, None]
        pixel = (
            np.floor((origin + part * (some - origin) - low) / PIXEL_M).astype(int).reshape(-1, 2)
        )
        pixel = pixel[((pixel >= 0) & (pixel < shape)).all(axis=1)]
        seen[tuple(pixel.T)] = True
    return seen
