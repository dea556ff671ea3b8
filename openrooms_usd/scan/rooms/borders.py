"""Wall hypotheses without surfels of a wall: where the scanned plan ends along a straight line."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array
from openrooms_usd.scan.points.surfels import Surfels
from openrooms_usd.scan.rooms.occupancy import PIXEL_M
from openrooms_usd.scan.rooms.outline import Outline
from openrooms_usd.scan.rooms.spaces import Spaces
from openrooms_usd.scan.rooms.walls import COLUMN_M, Line

_MIN_EDGE_M: Final = 0.6  # of straight border
_BLUR_PIXELS: Final = 1.5
_MIN_SLOPE: Final = 0.12  # of the blurred map, a pixel
_FACING_COS: Final = 0.9
_WALL_COVER_SHARE: Final = 0.4
_MIN_RUN_M: Final = 0.3
_MAX_ENDS: Final = 30
# A missed wall is looked for this far around its hypothesis, metres,
_SEARCH_M: Final = 0.3
# if the scan ends there in this part of its columns, of this width; it is put at this quantile
# of the ends, because a scan with a ragged border reached the wall where it is widest.
_ENDED_SHARE: Final = 0.4
_STRIP_M: Final = 0.1
_END_QUANTILE: Final = 0.8
# The wall stands this far behind those surfels, metres.
_BEHIND_SEEN_M: Final = 0.03


def border_lines(spaces: Spaces, directions: tuple[float, ...]) -> list[tuple[Array, float]]:
    """Normals (2,) and offsets of straight borders of the scanned plan.

    Where a scan misses a wall, the floor and ceiling before it still end there.

    Args:
        spaces: The map of the plan.
        directions: Degrees modulo 90.
    """
    from scipy import ndimage

    inside = ndimage.gaussian_filter((spaces.rooms > 0).astype(float), _BLUR_PIXELS)
    slope = np.column_stack([np.gradient(inside, axis=axis).ravel() for axis in (0, 1)])
    steep = np.linalg.norm(slope, axis=1)
    border = steep > _MIN_SLOPE
    places, slope = spaces.centres()[border], slope[border] / steep[border, None]
    found = []
    for angle in [d + turn for d in directions for turn in (0.0, 90.0)]:
        normal = np.array([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))])
        facing = np.abs(slope @ normal) > _FACING_COS
        found += [(normal, offset) for offset in _edges(places[facing] @ normal)]
    return found


def end_lines(lines: list[Line], directions: tuple[float, ...]) -> list[tuple[Array, float]]:
    """Normals (2,) and offsets of lines across the ends of walls: another may begin there.

    Args:
        lines: Wall lines.
        directions: Degrees modulo 90.
    """
    if not directions:
        return []
    ends = []
    for line in lines:
        wall = np.pad(line.cover > _WALL_COVER_SHARE, 1).astype(int)
        first, last = (np.flatnonzero(np.diff(wall) == step) for step in (1, -1))
        for a, b in zip(first, last, strict=True):
            if (b - a) * COLUMN_M > _MIN_RUN_M:
                ends += [(b - a, line.along, line.start + COLUMN_M * place) for place in (a, b)]
    ends.sort(key=lambda end: -end[0])
    return [(along, float(place)) for _, along, place in ends[:_MAX_ENDS]]


def moved_behind(outline: Outline, unseen: NDArray[np.bool_], pieces: Surfels) -> Outline:
    """Move walls without surfels behind the floor, ceiling and furniture before them.

    Args:
        outline: The room.
        unseen: (N,) which of its walls have no surfels.
        pieces: All surfels of the level scan.

    Returns:
        The outline; the one that was given where the moved walls bound no simple polygon.
    """
    starts, offsets = outline.corners(), outline.offsets.copy()
    ends = np.roll(starts, -1, axis=0)
    for wall in np.flatnonzero(unseen):
        normal = outline.normals[wall]
        along = np.array([-normal[1], normal[0]])
        away = pieces.points[:, :2] @ normal - offsets[wall]
        place = (pieces.points[:, :2] - starts[wall]) @ along
        length = float((ends[wall] - starts[wall]) @ along)
        near = (np.abs(away) < 2.0 * _SEARCH_M) & (place > 0.0) & (place < length)
        offsets[wall] += _end(place[near], away[near], int(length / _STRIP_M))
    moved = Outline(outline.normals, offsets)
    return moved if moved.valid() else outline


def _end(place: Array, away: Array, columns: int) -> float:
    """The offset of a wall behind surfels; 0 where they end in too few of the columns."""
    farthest = np.full(columns + 1, -np.inf)
    np.maximum.at(farthest, np.minimum((place / _STRIP_M).astype(int), columns), away)
    # Columns that go on beyond, as through a door, have no end here.
    ending = farthest[np.abs(farthest) < _SEARCH_M]
    if len(ending) < max(_ENDED_SHARE * columns, 3):
        return 0.0
    return float(np.quantile(ending, _END_QUANTILE)) + _BEHIND_SEEN_M


def _edges(offsets: Array) -> list[float]:
    if not len(offsets):
        return []
    low = offsets.min() - 4 * PIXEL_M
    counts = np.bincount(((offsets - low) / (0.5 * PIXEL_M)).astype(int))
    density = np.convolve(np.append(counts, np.zeros(8)), [1, 2, 3, 4, 3, 2, 1], "same")
    peaks = np.flatnonzero((density[1:-1] > density[:-2]) & (density[1:-1] >= density[2:])) + 1
    strong = peaks[density[peaks] > 4.0 * _MIN_EDGE_M / PIXEL_M]
    return [float(low + (peak + 0.5) * 0.5 * PIXEL_M) for peak in strong]
