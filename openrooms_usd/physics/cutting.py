"""Convex decomposition by planes: a piece that its hull is too coarse for is cut in two.

Each cut is the plane that leaves the least volume in the hulls of both sides, of those through
faces of the piece and some between. Only surfaces are cut and no caps are needed: the hull of what
lies on one side of a plane is the hull of the solid there. So open sheets are cut as solids are.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry.topology import distinct_rows
from openrooms_usd.geometry.triangulation import has_area
from openrooms_usd.geometry.vectors import doubled_areas

# Judges the hulls of pieces: how far each is off, metres.
Judge = Callable[[Sequence[Array]], Sequence[float]]

# Where a piece is tried between its ends, as shares of its length.
SHARES: Final = (0.25, 0.5, 0.75)
# How many planes through faces are tried along an axis.
FACES_PER_AXIS: Final = 4
# What a wholly uneven cut costs, as a share of the volume that there is.
UNEVEN_COST_SHARE: Final = 0.3
# What a cut across the shortest side costs: rings and trays are not sliced into rings and trays.
SLICING_COST: Final = 0.2
# Corners this close to a plane are in it, metres.
ON_PLANE_M: Final = 1e-7
# What a cut along a principal axis costs: cuts along the frame's axes leave boxes.
SLANTED_COST: Final = 0.3
# What a cut along a face that fills the whole section saves.
BOARD_GAIN: Final = 0.2
# Faces this close are in one plane, metres.
SAME_PLANE_M: Final = 1e-3


@dataclass(frozen=True, eq=False)
class Cutting:
    """A piece of a surface.

    Attributes:
        corners: (M, 3, 3) its triangles, metres.
        off: How far its hull is off, metres.
    """

    corners: Array
    off: float


def cut(surface: Array, judge: Judge, tolerance: float, least: float, most: int) -> list[Cutting]:
    """Cut a surface until its hulls are within a tolerance, the worst first.

    Args:
        surface: (M, 3, 3) triangles, metres.
        judge: Told all new pieces of a round at once.
        tolerance: How far hulls may be off, metres.
        least: Pieces are not cut across sides that are shorter, metres.
        most: No piece is cut once there are so many.
    """
    done: list[Cutting] = []
    left = [surface]
    while left:
        found = [Cutting(*pair) for pair in zip(left, judge(left), strict=True)]
        done += [piece for piece in found if piece.off <= tolerance]
        coarse = sorted(
            (piece for piece in found if piece.off > tolerance), key=lambda piece: -piece.off
        )
        left = []
        for k, piece in enumerate(coarse):
            room = most - len(done) - len(left) - (len(coarse) - k - 1)
            halves = _halves(piece.corners, least) if room >= 2 else None
            if halves is None:
                done.append(piece)
            else:
                left += halves
    return done


def clipped(corners: Array, heights: Array) -> Array:
    """The parts of triangles that lie where a linear function is not negative.

    Args:
        corners: (M, 3, 3) metres.
        heights: (M, 3) the function at each corner.

    Returns:
        (K, 3, 3) triangles with the windings of those they are of.
    """
    # What lies in the plane is of neither side here.
    there = heights.max(axis=1) > 0.0
    corners, heights = corners[there], heights[there]
    above = heights >= 0.0
    number = above.sum(axis=1)
    kept = [corners[number == 3]]
    for count in (1, 2):
        chosen = number == count
        # The corner that is alone on its side comes first.
        alone = above[chosen] if count == 1 else ~above[chosen]
        turn = (alone.argmax(axis=1)[:, None] + np.arange(3)) % 3
        h = np.take_along_axis(heights[chosen], turn, axis=1)
        a, b, c = np.moveaxis(np.take_along_axis(corners[chosen], turn[:, :, None], axis=1), 1, 0)
        ab = a + (h[:, 0] / (h[:, 0] - h[:, 1]))[:, None] * (b - a)
        ac = a + (h[:, 0] / (h[:, 0] - h[:, 2]))[:, None] * (c - a)
        if count == 1:
            kept.append(np.stack([a, ab, ac], axis=1))
        else:
            kept += [np.stack([ab, b, c], axis=1), np.stack([ab, c, ac], axis=1)]
    return np.concatenate(kept)


def _halves(piece: Array, least: float) -> list[Array] | None:
    """Both sides of the best plane; None where the piece is too small to be cut."""
    plane = _best_plane(piece, least)
    if plane is None:
        return None
    heights = piece @ plane[:3] + plane[3]
    # Corners on the plane belong to both sides.
    heights[np.abs(heights) < ON_PLANE_M] = 0.0
    sides = [_with_area(clipped(piece, heights)), _with_area(clipped(piece, -heights))]
    # What lies in the plane bounds the side that it looks away from.
    flat = piece[(heights == 0.0).all(axis=1)]
    away = doubled_areas(flat) @ plane[:3] < 0.0
    sides = [np.concatenate([sides[0], flat[away]]), np.concatenate([sides[1], flat[~away]])]
    return sides if all(len(side) for side in sides) else None


def _best_plane(piece: Array, least: float) -> Array | None:
    first, rows = distinct_rows(piece.reshape(-1, 3))
    points = piece.reshape(-1, 3)[first]
    edges = rows.reshape(-1, 3)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges = np.sort(edges, axis=1)
    edges = edges[distinct_rows(edges)[0]]
    normals = doubled_areas(piece)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    best, plane = np.inf, None
    for axis, shares in _axes(points):
        framed = len(shares) > 1
        along = points @ axis
        low, high = float(along.min()), float(along.max())
        if high - low < least:
            continue
        places = [(low + share * (high - low), 0.0) for share in shares]
        if framed:
            places += _faces(piece, normals, axis, low, high)
        for offset, covered in places:
            heights = along - offset
            heights[np.abs(heights) < ON_PLANE_M] = 0.0
            uneven = abs(2.0 * offset - low - high) / (high - low)
            # Flat pieces have no volume: the longest side is halved.
            sliced = SLICING_COST * (1.0 - (high - low) / size)
            # Boards that meet come apart at their faces, however uneven the cut.
            share = (
                1.0 + (1.0 - covered) * (UNEVEN_COST_SHARE * uneven + sliced) - BOARD_GAIN * covered
            )
            share += 0.0 if framed else SLANTED_COST
            saved = 1e-9 * size * size * (high - low)
            volume = _volume(points, edges, heights, (best + saved) / share)
            if volume * share - saved < best:
                best, plane = volume * share - saved, np.append(axis, -offset)
    return plane


def _axes(points: Array) -> list[tuple[Array, tuple[float, ...]]]:
    """The axes of the frame, tried at several places, and the principal ones, in the middle."""
    centred = points - points.mean(axis=0)
    principal = np.linalg.eigh(centred.T @ centred)[1].T
    return [(axis, SHARES) for axis in np.eye(3)] + [(axis, (0.5,)) for axis in principal]


def _faces(
    piece: Array, normals: Array, axis: Array, low: float, high: float
) -> list[tuple[float, float]]:
    """Where the most area lies square to an axis, inside, and its share of the section."""
    square = np.abs(normals @ axis) > 0.999 * np.linalg.norm(normals, axis=1)
    places = piece[square].mean(axis=1) @ axis
    inner = (places > low + SAME_PLANE_M) & (places < high - SAME_PLANE_M)
    if not inner.any():
        return []
    of = np.unique(np.round(places[inner] / SAME_PLANE_M), return_inverse=True)[1].reshape(-1)
    areas = np.bincount(of, weights=np.linalg.norm(normals[square][inner], axis=1))
    chosen = np.argsort(-areas, kind="stable")[:FACES_PER_AXIS]
    first = [np.flatnonzero(of == k)[0] for k in chosen]
    extent = np.ptp(piece.reshape(-1, 3), axis=0)[axis == 0.0]
    section = 2.0 * max(float(extent.prod()), SAME_PLANE_M**2)
    covers = np.clip(areas[chosen] / section, 0.0, 1.0)
    return [(float(places[inner][row]), float(c)) for row, c in zip(first, covers, strict=True)]


def _volume(points: Array, edges: Ints, heights: Array, enough: float) -> float:
    """The volume of the hulls of both sides; of one alone where that is enough, cubic metres."""
    start, end = heights[edges[:, 0]], heights[edges[:, 1]]
    crossing = start * end < 0.0
    share = (start[crossing] / (start[crossing] - end[crossing]))[:, None]
    a, b = points[edges[crossing, 0]], points[edges[crossing, 1]]
    between = a + share * (b - a)
    total = 0.0
    # The side that mostly holds more comes first: it alone may be enough.
    sides = (heights, -heights) if -heights.min() < heights.max() else (-heights, heights)
    for side in sides:
        # A corner in the plane is of the side that an edge leads to.
        kept = side > 0.0
        kept[edges[kept[edges].any(axis=1) & (side[edges] >= 0.0).all(axis=1)]] = True
        total += _hull_volume(np.concatenate([points[kept], between]))
        if total >= enough:
            break
    return total


def _hull_volume(points: Array) -> float:
    from scipy.spatial import ConvexHull, QhullError

    try:
        return float(ConvexHull(points).volume) if len(points) > 3 else 0.0
    except QhullError:
        return 0.0


def _with_area(corners: Array) -> Array:
    return corners[has_area(corners)]
