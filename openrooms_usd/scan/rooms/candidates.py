"""Line hypotheses for walls in the plan.

Along the prevailing directions they are maxima of a kernel density of vertical surfels over the
offset; to the rest, lines of any angle are fitted one after the other by MSAC.
"""

from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.scan.points.surfels import Surfels
from openrooms_usd.scan.rooms.outline import Outline
from openrooms_usd.scan.rooms.spaces import PIXEL_M, Spaces
from openrooms_usd.scan.rooms.walls import (
    COLUMN_M,
    FACES_ACROSS_COS,
    Line,
    Walls,
    line_fit,
    on_line,
    profile,
)

_OFFSET_BIN_M: Final = 0.01
_MIN_RUN_M: Final = 0.12  # least length of surfels on a line, metres
_MAX_LINES: Final = 70
# Surfels within so many times their reach of a line are explained by it.
_EXPLAINED_REACHES: Final = 2.5
# Lines that differ by less than 8 degrees may be duplicates.
_SAME_LINE_COS: Final = 0.99
_ODD_TRIES: Final = 200
_ODD_SAMPLE: Final = 2000
_ODD_LINES: Final = 16
_ODD_REACH: Final = 2.0


def wall_lines(walls: Walls, directions: tuple[float, ...]) -> list[Line]:
    """Wall lines: along the prevailing directions, and oblique ones.

    Args:
        walls: The surfels of walls.
        directions: Degrees modulo 90.

    Returns:
        At most 70 lines, those with the most cover first.
    """
    free = np.ones(len(walls.points), bool)
    found: list[tuple[float, float]] = []
    for direction in directions:
        for angle in (direction, direction + 90.0):
            for offset in _offsets(walls, angle):
                found.append((angle, offset))
                free &= ~on_line(walls, _unit(angle), offset, spread=_EXPLAINED_REACHES)
    lines = [profile(walls, _unit(angle), offset) for angle, offset in found]
    odd = [profile(walls, _unit(angle), offset) for angle, offset in _odd_lines(walls, free)]
    lines += [line for line in odd if not _repeats(walls, line, lines)]
    lines = [line for line in lines if line.cover.sum() * COLUMN_M > _MIN_RUN_M]
    lines.sort(key=lambda line: -float(line.cover.sum()))
    return lines[:_MAX_LINES]


def _unit(degrees: float) -> Array:
    return np.array([np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))])


def _offsets(walls: Walls, angle: float) -> list[float]:
    """Offsets of lines with a normal direction: maxima of the surfels' kernel density."""
    normal = _unit(angle)
    facing = np.abs(walls.normals @ normal) > FACES_ACROSS_COS
    if not facing.any():
        return []
    place = walls.points[facing] @ normal
    low = place.min() - 0.2
    counts = np.bincount(
        ((place - low) / _OFFSET_BIN_M).astype(int), (walls.weight * walls.share)[facing]
    )
    counts = np.append(counts, np.zeros(20))
    steps = np.arange(-12, 13) * _OFFSET_BIN_M
    kernel = np.exp(-0.5 * (steps / (walls.reach / 3.0)) ** 2)
    density = np.convolve(counts, kernel, "same")
    peaks = np.flatnonzero((density[1:-1] > density[:-2]) & (density[1:-1] >= density[2:])) + 1
    least = _MIN_RUN_M / COLUMN_M * 0.3 * walls.courses
    peaks = peaks[density[peaks] > least]
    kept: list[int] = []
    for peak in peaks[np.argsort(-density[peaks], kind="stable")]:
        if all(abs(peak - other) * _OFFSET_BIN_M > walls.reach for other in kept):
            kept.append(int(peak))
    return [low + (peak + 0.5) * _OFFSET_BIN_M for peak in kept]


def _odd_lines(walls: Walls, free: Mask) -> list[tuple[float, float]]:
    """Lines of any angle through surfels without a line, by sequential MSAC."""
    rng = np.random.default_rng(0)
    found: list[tuple[float, float]] = []
    least = 2.0 * _MIN_RUN_M / COLUMN_M * walls.courses
    for _ in range(_ODD_LINES):
        rows = np.flatnonzero(free)
        if walls.weight[rows].sum() < least:
            break
        some = rows[rng.permutation(len(rows))[:_ODD_SAMPLE]]
        seed = _best_seed(walls, some, rng.integers(len(some), size=_ODD_TRIES))
        normal, offset = _refitted(walls, rows, seed)
        taken = rows[on_line(walls, normal, offset, rows=rows)]
        free[taken] = False
        free[seed] = False
        angle = float(np.rad2deg(np.arctan2(normal[1], normal[0])))
        if walls.weight[taken].sum() >= least:
            found.append((angle, offset))
    return found


def _repeats(walls: Walls, odd: Line, straight: list[Line]) -> bool:
    """Whether an oblique line duplicates one along a prevailing direction, slightly turned."""
    total = np.concatenate([[0.0], np.cumsum(odd.cover)]) / max(float(odd.cover.sum()), 1e-9)
    a, b = odd.start + COLUMN_M * np.interp([0.1, 0.9], total, np.arange(len(total)))
    middle = odd.offset * odd.normal + (a + b) / 2.0 * odd.along
    half = (b - a) / 2.0
    for line in straight:
        near = abs(line.normal @ odd.normal) > _SAME_LINE_COS
        if near and abs(middle @ line.normal - line.offset) < walls.thickness:
            place = middle @ line.along
            if line.covered(place - half, place + half) > 0.4 * odd.covered(a, b):
                return True
    return False


def _best_seed(walls: Walls, some: Ints, tries: Ints) -> int:
    """The surfel whose own line has the best MSAC score within two metres."""
    points, normals = walls.points[some], walls.normals[some]
    seeds, axes = points[tries], normals[tries]
    across = points @ axes.T - (seeds * axes).sum(axis=1)
    along = points @ _quarter(axes).T - (seeds * _quarter(axes)).sum(axis=1)
    near = (np.abs(along) < _ODD_REACH) & (np.abs(normals @ axes.T) > FACES_ACROSS_COS)
    support = np.where(near, np.clip(1.0 - (across / walls.reach) ** 2, 0.0, None), 0.0)
    return int(some[tries[int((walls.weight[some] @ support).argmax())]])


def _quarter(axes: Array) -> Array:
    return np.column_stack([-axes[:, 1], axes[:, 0]])


def _refitted(walls: Walls, rows: Ints, seed: int) -> tuple[Array, float]:
    """The line through the surfels around a seed, by iteratively reweighted least squares."""
    points, normals, weight = walls.points[rows], walls.normals[rows], walls.weight[rows]
    close = ((points - walls.points[seed]) ** 2).sum(axis=1) < _ODD_REACH**2
    normal = walls.normals[seed]
    offset = float(walls.points[seed] @ normal)
    for _ in range(6):
        across = points @ normal - offset
        near = close & (np.abs(normals @ normal) > FACES_ACROSS_COS)
        bell = np.clip(1.0 - (across / walls.reach) ** 2, 0.0, None) ** 2
        kernel = np.where(near, weight * bell, 0.0)
        if kernel.sum() < 3.0:
            break
        normal, offset = line_fit(points, kernel, normal)
    return normal, offset


# Wall hypotheses without surfels of a wall: where the scanned plan ends along a straight line.

_MIN_EDGE_M: Final = 0.6  # of straight border
_BLUR_PIXELS: Final = 1.5
_MIN_SLOPE: Final = 0.12  # of the blurred map, a pixel
_FACING_COS: Final = 0.9
_WALL_COVER_SHARE: Final = 0.4
_MIN_BORDER_M: Final = 0.3
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
            if (b - a) * COLUMN_M > _MIN_BORDER_M:
                ends += [(b - a, line.along, line.start + COLUMN_M * place) for place in (a, b)]
    ends.sort(key=lambda end: -end[0])
    return [(along, float(place)) for _, along, place in ends[:_MAX_ENDS]]


def moved_behind(outline: Outline, unseen: Mask, pieces: Surfels) -> Outline:
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
