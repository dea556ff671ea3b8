"""Doors and windows in the walls of a level scan, from labels, holes and frames.

On the evidence grid of each wall (`wallpicture`) rectangles are proposed (`wallholes`), scored, and
suppressed where they overlap one of higher confidence.

Reflected at the wall, points seen through a mirror coincide with points inside the room; those of
a street or a corridor do not.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy import ndimage

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.names import SCANNED_HEIGHT
from openrooms_usd.scan.openings import judgement
from openrooms_usd.scan.openings.cellcounts import BLINDS, CELL_M, CURTAIN, DOOR, WINDOW, WallFace
from openrooms_usd.scan.openings.rectangles import Rectangle
from openrooms_usd.scan.openings.wallholes import (
    Proposal,
    hole_weights,
    kind_of,
    measured,
    rectangles,
)
from openrooms_usd.scan.openings.wallpicture import WallGrid, wall_grids
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.sightlines import VOXEL_M, Sight, sight_of
from openrooms_usd.scan.results import FoundOpening

# Least distance of openings from the corners of the room and from the ceiling, metres.
MARGIN_M: Final = 0.05
# Between openings, metres.
MIN_GAP_M: Final = 0.02
# Points farther than this from a room occlude nothing in it, metres.
_VIEW_MARGIN_M: Final = 1.0
# Least and greatest width and height, metres.
_SIZES_M: Final = {"door": ((0.5, 4.0), (1.6, 3.2)), "window": ((0.25, 8.0), (0.25, 4.0))}
# Openings less probable than the first are not built, and less than the second not worth a word.
LIKELY: Final = 0.4
DOUBTFUL: Final = 0.2
# Calibration of labelled openings: slope of the share of false positives over one minus the score,
# and the share of true positives at full score.
_UNSURE_WRONG_SHARE: Final = 0.65
_SUREST_RIGHT_SHARE: Final = 0.97
_HIDDEN_WINDOW_SCORE: Final = 0.6
# Proposals nearer to an opening than this, metres, and smaller than this part of it belong to it.
_SCRAP_M_AND_SHARE: Final = (0.15, 0.35)
# Walls of which less was scanned give no holes.
_MIN_SCANNED_SHARE: Final = 0.1
# Holes down to the floor that are lower than this are shadows of furniture, metres.
_MIN_PASSAGE_M: Final = 1.8
# Least part of an open door's cells that are a hole.
_AJAR_SHARE: Final = 0.2
# Least part of a closed leaf that returned.
_CLOSED_LEAF_SHARE: Final = 0.6
# Least part of the labelled returns with the opening's own label.
_MIN_NAMED_SHARE: Final = 0.3
# A door's lower part may be hidden up to this height, metres.
_HIDDEN_FOOT_M: Final = 0.6
# Flat patches labelled window are wrong labels up to the first area, and round ones up to the
# second.
_BLOB_AREAS_M2: Final = (0.35, 0.8)
# Least part of such a patch where the wall returned.
_MIN_WALL_SHARE: Final = 0.5
# Curtains up to this width and this near to a window are that one's, metres.
_CURTAIN_WIDTH_M: Final = 0.5
_CURTAIN_GAP_M: Final = 0.25
# Margin of curtains around their window, horizontally and vertically, metres; a column of cells is
# hidden if this part of it is.
_CURTAIN_MARGINS_M: Final = (0.12, 0.1)
_HIDDEN_SHARE: Final = 0.3
# Curtains that end lower than this reach the floor, and the sill that is then assumed, metres.
_FLOOR_LENGTH_M: Final = 0.3
_HALF_SILL_M: Final = 0.5
# Largest width of a curtain that is drawn aside, metres.
_MAX_BUNDLE_WIDTH_M: Final = 0.6

_MAX_POINTS: Final = 60_000
# Points nearer behind the wall may be of a frame, metres.
_FRAME_DEPTH_M: Final = 0.3
# Floors and ceilings of neighbouring rooms are coplanar, and left out with this margin, metres.
_FLOOR_MARGIN_M: Final = 0.15
# Least part of the reflected points that coincide with points, and their least number.
_MIN_REFLECTED_SHARE: Final = 0.6
_MIN_REFLECTED_RETURNS: Final = 12


@dataclass(frozen=True, eq=False)
class Echoes:
    """A scan prepared for the comparison of points behind walls with those inside.

    Attributes:
        points: (N, 3) a sample of the scan's points, in the level frame.
        full: Occupancy of the voxels of ``sight``, dilated by one.
        sight: Sensors and occlusion.
    """

    points: Array
    full: Mask
    sight: Sight

    def fill(self, face: WallFace, where: Rectangle) -> bool:
        """Whether the points seen through a rectangle of a wall mirror the room."""
        seen = self._through(face, where)
        if len(seen) < _MIN_REFLECTED_RETURNS:
            return False
        turned = face.to_level(seen * np.array([1.0, -1.0, 1.0]))
        last = np.array(self.full.shape) - 1
        cell = np.clip(((turned - self.sight.low) / VOXEL_M).astype(np.int64), 0, last)
        return bool(self.full[cell[:, 0], cell[:, 1], cell[:, 2]].mean() > _MIN_REFLECTED_SHARE)

    def _through(self, face: WallFace, where: Rectangle) -> Array:
        """(M, 3) points behind the wall that a sensor sees through a rectangle, in its frame."""
        points = face.from_level(self.points)
        points = points[(points[:, 1] > _FRAME_DEPTH_M) & (points[:, 2] > _FLOOR_MARGIN_M)]
        seen = np.zeros(len(points), dtype=np.bool_)
        for origin in face.from_level(self.sight.sensor_origins):
            if origin[1] < 0:
                share = (-origin[1] / (points[:, 1] - origin[1]))[:, None]
                x, z = (origin + share * (points - origin))[:, [0, 2]].T / CELL_M
                seen |= (x > where.left) & (x < where.right) & (z > where.bottom) & (z < where.top)
        return np.asarray(points[seen])


def echoes(points: Array, sight: Sight, height: float) -> Echoes:
    """Prepare a scan for the detection of mirrors.

    Args:
        points: (N, 3) of the scan, in the level frame.
        sight: Sensors and occlusion.
        height: Of the ceiling, metres.
    """
    some = points[:: max(1, len(points) // _MAX_POINTS)]
    low = some[some[:, 2] < height - _FLOOR_MARGIN_M]
    return Echoes(low, ndimage.binary_dilation(sight.full, np.ones((3, 3, 3), bool)), sight)


def find_openings(
    cloud: Cloud, corners: Array, height: float | None, least: float = LIKELY
) -> tuple[FoundOpening, ...]:
    """Find the doors and windows of a room.

    Args:
        cloud: In the level frame: the floor at z = 0, metres.
        corners: (N, 2) of the room at its walls' inner faces, counter-clockwise.
        height: Of the ceiling, metres; None where it is not known.
        least: Their probability.

    Returns:
        The openings, by wall and from left to right, in the level frame. None overlap.
    """
    if not len(cloud):
        return ()
    cloud = replace(cloud, instance=None, confidence=None)
    sight = sight_of(_around(cloud.points, corners), cloud.sensor_origins)
    labelled = cloud.label is not None and bool(np.isin(cloud.label, (DOOR, WINDOW)).any())
    found: list[FoundOpening] = []
    mirrored = echoes(cloud.points, sight, height or SCANNED_HEIGHT)
    for grid in wall_grids(cloud, corners, height or SCANNED_HEIGHT, sight):
        found += _in_wall(grid, labelled, mirrored, least)
    return tuple(found)


def _around(points: Array, corners: Array) -> Array:
    """The points in the box around a room."""
    inside = np.ones(len(points), dtype=np.bool_)
    for axis in (0, 1):
        low, high = corners[:, axis].min() - _VIEW_MARGIN_M, corners[:, axis].max() + _VIEW_MARGIN_M
        inside &= (points[:, axis] > low) & (points[:, axis] < high)
    return points if inside.all() else points[inside]


def _in_wall(
    grid: WallGrid, labelled: bool, mirrored: Echoes, least: float
) -> Iterator[FoundOpening]:
    kept: list[Proposal] = []
    # Labels first: a hole may be only a part of the labelled opening.
    named = _by_labels(grid) if labelled else ()
    shaped = (*_by_holes(grid, labelled, mirrored), *_by_frames(grid))
    for proposals in (named, shaped):
        judged = [(confidence(p, labelled), p) for p in proposals if _plausible(p)]
        for sure, proposal in sorted(judged, key=lambda pair: -pair[0]):
            if sure >= least and not any(_suppressed(proposal, q) for q in kept):
                kept.append(proposal)
    for proposal in sorted(kept, key=lambda p: p.where.left):
        yield _opening(grid, proposal, confidence(proposal, labelled))


def _by_holes(grid: WallGrid, labelled: bool, mirrored: Echoes) -> Iterator[Proposal]:
    """Holes; in labelled scans windows must have their label, doors need not."""
    if grid.solid.mean() < _MIN_SCANNED_SHARE:
        return
    for where in rectangles(hole_weights(grid)):
        if mirrored.fill(grid.face, where):
            continue
        proposal = measured(grid, kind_of(grid, where), where)
        if proposal.kind == "door" and proposal.height < _MIN_PASSAGE_M:
            continue
        if proposal.kind == "door":
            proposal = measured(grid, "door", replace(where, bottom=0))
        # An open leaf hides a part of the hole: labelled doors come from `_by_labels`.
        named = proposal.label > _MIN_NAMED_SHARE
        if not labelled or named == (proposal.kind == "window"):
            yield proposal


def _by_frames(grid: WallGrid) -> Iterator[Proposal]:
    for where, clear in judgement.frames(grid):
        proposal = replace(measured(grid, "door", where), leaf=clear)
        # An open door shows the floor behind it, a closed one its leaf; shelves show neither.
        returned = proposal.solid + proposal.recess
        shut = proposal.hole - proposal.recess < _AJAR_SHARE and returned > _CLOSED_LEAF_SHARE
        if shut or proposal.threshold > 0.3:
            yield proposal


def _by_labels(grid: WallGrid) -> Iterator[Proposal]:
    for where in rectangles(judgement.label_weights(grid, "door"), _SIZES_M["door"][1][0]):
        proposal = measured(grid, "door", where)
        if proposal.label > _MIN_NAMED_SHARE and proposal.sill < _HIDDEN_FOOT_M:
            yield measured(grid, "door", judgement.without_casing(grid, replace(where, bottom=0)))
    named: list[Proposal] = []
    for where in rectangles(judgement.label_weights(grid, "window")):
        proposal = measured(grid, "window", under_curtains(grid, where))
        if proposal.label > _MIN_NAMED_SHARE and not _is_blob(grid, proposal):
            named.append(proposal)
    yield from named
    for where in rectangles(curtain_weights(grid)):
        hidden = replace(measured(grid, "window", behind_curtain(where)), curtain=1.0)
        reach = where if hidden.width > _CURTAIN_WIDTH_M else grown(where, _CURTAIN_GAP_M)
        if hidden.solid < 0.5 and not any(_beside(reach, q.where) < 0 for q in named):
            yield hidden


def _is_blob(grid: WallGrid, p: Proposal) -> bool:
    """Whether a window is a blob of wrong labels: on the wall's plane, and small or round."""
    area = p.width * p.height
    if (
        area > _BLOB_AREAS_M2[1]
        or p.solid < _MIN_WALL_SHARE
        or p.curtain >= 0.5
        or judgement.lies_deeper(grid, p.where)
    ):
        return False
    return area < _BLOB_AREAS_M2[0] or judgement.is_round(grid, "window", p.where)


def _plausible(proposal: Proposal) -> bool:
    wide, tall = _SIZES_M[proposal.kind]
    fits = wide[0] <= proposal.width <= wide[1] and tall[0] <= proposal.height <= tall[1]
    return fits and (proposal.kind == "window" or proposal.sill == 0.0)


def confidence(proposal: Proposal, labelled: bool) -> float:
    """The probability that a proposal is an opening."""
    p = proposal
    if labelled and p.label > _MIN_NAMED_SHARE:
        score = 0.5 + 0.4 * p.label + 0.2 * p.hole + (0.1 if p.leaf else 0.0)
        return _as_probability(min(1.0, score))
    if p.curtain == 1.0:
        return _as_probability(_HIDDEN_WINDOW_SCORE)
    return 0.0 if labelled and p.leaf else judgement.likelihood(p)


def _overlap(a: Proposal, b: Proposal, apart: float = MIN_GAP_M) -> bool:
    above = max(a.where.bottom, b.where.bottom) - min(a.where.top, b.where.top)
    return max(_beside(a.where, b.where), above) < apart / CELL_M


def _beside(a: Rectangle, b: Rectangle) -> int:
    """The gap between rectangles along the wall, cells; negative where they overlap."""
    return max(a.left, b.left) - min(a.right, b.right)


def _suppressed(proposal: Proposal, other: Proposal) -> bool:
    """Whether an opening of higher score overlaps a proposal, or has it as a near fragment."""
    apart = (
        _SCRAP_M_AND_SHARE[0]
        if proposal.where.area < _SCRAP_M_AND_SHARE[1] * other.where.area
        else MIN_GAP_M
    )
    return _overlap(proposal, other, apart)


def _as_probability(sure: float) -> float:
    """The calibrated probability of a score."""
    return min(_SUREST_RIGHT_SHARE, 1.0 - _UNSURE_WRONG_SHARE * (1.0 - sure))


def _opening(grid: WallGrid, p: Proposal, sure: float) -> FoundOpening:
    length, top = grid.face.length, grid.shape[0] * CELL_M
    left, right = np.clip(
        [p.where.left * CELL_M, p.where.right * CELL_M], MARGIN_M, length - MARGIN_M
    )
    low, high = p.where.bottom * CELL_M, min(p.where.top * CELL_M, top - MARGIN_M)
    ring = np.array([[left, 0, low], [right, 0, low], [right, 0, high], [left, 0, high]])
    return FoundOpening(p.kind, grid.face.to_level(ring), float(sure), grid.face.number)


def curtain_weights(grid: WallGrid) -> Array:
    """(Z, X) weights of curtains and blinds, by their labels."""
    curtain = judgement.around(grid.labels[CURTAIN] + grid.labels[BLINDS], grid.window)
    share = curtain / np.maximum(judgement.around(grid.labelled, grid.window), 1e-9)
    return np.asarray(np.where(curtain > 0, 2.0 * share - 1.0, np.where(grid.solid, -1.0, -0.2)))


def behind_curtain(where: Rectangle) -> Rectangle:
    """The likely window behind a curtain, which is a little larger.

    Behind one that reaches the floor may be a French window or a usual one: a sill at half the
    usual height overlaps most with either.
    """
    side, end = (round(length / CELL_M) for length in _CURTAIN_MARGINS_M)
    wide, tall = where.right - where.left > 4 * side, where.top - where.bottom > 4 * end
    bottom, top = where.bottom + end * tall, where.top - end * tall
    if where.bottom * CELL_M < _FLOOR_LENGTH_M:
        bottom = max(bottom, round(_HALF_SILL_M / CELL_M))
    return Rectangle(min(bottom, top - 1), top, where.left + side * wide, where.right - side * wide)


def grown(where: Rectangle, more: float) -> Rectangle:
    """A rectangle widened on both sides, metres."""
    cells = round(more / CELL_M)
    return replace(where, left=max(where.left - cells, 0), right=where.right + cells)


def under_curtains(grid: WallGrid, where: Rectangle) -> Rectangle:
    """A window extended by its parts that curtains at its sides hide."""
    curtain = grid.labels[CURTAIN] + grid.labels[BLINDS]
    hidden = (curtain[where.rows] > 0).mean(axis=0) > _HIDDEN_SHARE
    left, right = _curtain_cells(hidden[: where.left][::-1]), _curtain_cells(hidden[where.right :])
    # A wide curtain beside a window that is open to the view belongs to another one.
    most = round(_MAX_BUNDLE_WIDTH_M / CELL_M)
    slit = where.right - where.left < most
    more = round(_CURTAIN_MARGINS_M[0] / CELL_M)
    left, right = (max(n - more, 0) if slit or n <= most else 0 for n in (left, right))
    return replace(where, left=where.left - left, right=where.right + right)


def _curtain_cells(hidden: Mask) -> int:
    """Cells of a curtain from the first one on, across gaps of up to two cells."""
    line = np.concatenate([[True] * 3, hidden, [False] * 3])
    gaps = np.flatnonzero(~ndimage.binary_closing(line, np.ones(3, dtype=bool))[3:])
    return int(gaps[0])
