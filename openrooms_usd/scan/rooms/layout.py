"""The rooms of a level scan as closed polygons.

Line hypotheses (`candidates`, for missed walls too) cut the plan into cells. For each space of a
watershed (`spaces`) a minimum cut labels them inside or outside (`roomoutline`). The outline is
simplified as long as its cost falls (`outline`), and its lines are refitted.

An open leaf is collinear with no wall.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Ints, Mask
from openrooms_usd.errors import SparseScanError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import VOXEL_M, Surfels, surfels
from openrooms_usd.scan.results import FoundOpening, FoundRoom
from openrooms_usd.scan.rooms.candidates import border_lines, end_lines, moved_behind, wall_lines
from openrooms_usd.scan.rooms.ceilings import ceiling_height, ceiling_slopes, ceilings_of
from openrooms_usd.scan.rooms.cells import cut_plan
from openrooms_usd.scan.rooms.directions import UPRIGHT_SINE, angle_between
from openrooms_usd.scan.rooms.faces import no_walls
from openrooms_usd.scan.rooms.levelling import Level
from openrooms_usd.scan.rooms.outline import Outline
from openrooms_usd.scan.rooms.roomoutline import Plan
from openrooms_usd.scan.rooms.spaces import Spaces, find_spaces, walled_shares
from openrooms_usd.scan.rooms.walls import Line, Walls, profile, upright

# Gain of a square metre of the room inside, in metres of missing wall.
_INSIDE_GAIN: Final = 1.0
# A partial view has few walls, which the gain must outweigh.
_PARTIAL_INSIDE_GAIN: Final = 6.0
# Walls of which less was scanned are reported as guessed.
_GUESSED_SHARE: Final = 0.3
# Spaces with less of their border beside walls, such as lawns, are not rooms.
_WALLED_SHARE: Final = 0.1
# A room needs two walls with this much scanned, in directions with at most this cosine.
_MIN_WALL_M: Final = 0.4
_OTHER_DIRECTION_COS: Final = 0.87
# A space beside a larger room is a room if this part of its own walls and of its floor was
# scanned; walls this near to the other room are shared, metres.
_OWN_WALLS_SHARE: Final = 0.6
_OWN_FLOOR_SHARE: Final = 0.6
_SHARED_WALL_M: Final = 0.03

# NYU40.
_WALL_LABEL: Final = 1
_DOOR_LABEL: Final = 8
# Below this, skirting boards and thresholds are labelled door, too, metres.
_SKIRTING_M: Final = 0.1
# Radius of the neighbourhood whose principal axis is the direction of a leaf or wall, metres.
_DIRECTION_RADIUS_M: Final = 0.35
_MIN_PIECES: Final = 8
# A closed door continues a wall: within this angle, range and band, in so many columns. One that
# is parallel to the walls may stand in a deep frame.
_ALIKE_DEG: Final = 4.0
_WALL_ONWARD_M: Final = 1.5
_WALL_BAND_M: Final = 0.08
_FRAME_BAND_M: Final = 0.12
_MIN_COLUMNS: Final = 6


@dataclass(frozen=True)
class LayoutOptions:
    """What people may choose.

    Attributes:
        simplicity: Penalty of a corner, metres of missing wall. Larger values give plainer rooms.
        least_coverage: Rooms of whose outline a smaller part was scanned are refused.
        partial: Accept any part of a room, as a single view gives; the rest is guessed.
        storey: Which of several, 0 is the lowest; None: the one with the largest floor.
    """

    simplicity: float = 0.1
    least_coverage: float = 0.25
    partial: bool = False
    storey: int | None = None


DEFAULTS: Final = LayoutOptions()


@dataclass(frozen=True, eq=False)
class LayoutRoom:
    """One room in the level frame.

    Attributes:
        corners: (N, 2) at the walls' inner faces, counter-clockwise.
        seen_shares: (N,) the part of each wall, from corner i to the next, that was scanned.
        guessed: Numbers of the walls that were hardly scanned.
        ceiling: Height of a level ceiling, metres; None where none was scanned, or where it slopes.
        coverage: The part of the outline that was scanned.
        residual: Root mean squared distance of the walls' surfels to them, metres.
        slopes: Planes of a ceiling that is not level: normal (3,) into the room, and a point (3,).
    """

    corners: Array
    seen_shares: Array
    guessed: tuple[int, ...]
    ceiling: float | None
    coverage: float
    residual: float
    slopes: tuple[tuple[Array, Array], ...] = ()

    def found(self, level: Level, openings: tuple[FoundOpening, ...] = ()) -> FoundRoom:
        """The room in the scan's own frame.

        Args:
            level: Level frame of the scan.
            openings: In the walls, in the scan's frame already.
        """
        back = level.scan_from_level
        corners = self.corners @ back[:3, :2].T + back[:3, 3]
        measures = {
            "coverage": self.coverage,
            "floor_residual": level.residual,
            "wall_residual": self.residual,
        }
        finite = {name: value for name, value in measures.items() if np.isfinite(value)}
        return FoundRoom(
            level.normal,
            level.point,
            corners,
            self.guessed,
            self.ceiling,
            openings,
            finite,
            tuple((back[:3, :3] @ n, back[:3, :3] @ p + back[:3, 3]) for n, p in self.slopes),
        )


def find_layout(
    cloud: Cloud, level: Level, options: LayoutOptions = DEFAULTS
) -> tuple[LayoutRoom, ...]:
    """Find the rooms of a scan.

    Args:
        cloud: N finite points in the level frame, metres. Labels (NYU40) and sensor origins help
            where they are given.
        level: Level frame of the scan.
        options: What people may choose.

    Returns:
        The rooms, the largest space first.

    Raises:
        SparseScanError: The scan shows too little of any room.
    """
    pieces = surfels(cloud)
    ceilings = ceilings_of(pieces)
    hanging, standing = no_walls(pieces, ceilings)
    leaves = open_leaves(pieces, level.directions)
    kept = ~(leaves | hanging)
    walls = upright(pieces.take(kept), ceilings, standing[kept])
    if not len(walls.points):
        raise _too_little("the scan shows no wall")
    # A partial view was taken from inside its room.
    sensor_origins = (
        np.zeros((0, 2)) if cloud.sensor_origins is None else cloud.sensor_origins[:, :2]
    )
    included = sensor_origins if options.partial else sensor_origins[:0]
    spaces = find_spaces(pieces, walls, cloud.sensor_origins, included)
    lines = _lines(walls, spaces, level.directions)
    cells = cut_plan(lines, spaces.low, spaces.high, level.directions)
    plan = Plan(
        walls,
        spaces,
        cells,
        level.directions,
        options.simplicity,
        _PARTIAL_INSIDE_GAIN if options.partial else _INSIDE_GAIN,
        sensor_origins,
        included,
    )
    rooms: list[LayoutRoom] = []
    refused = 0.0
    walled = walled_shares(spaces, walls)
    for number in range(1, len(spaces.middles) + 1):
        if walled[number] < _WALLED_SHARE and not options.partial:
            continue
        outline = plan.outline(number)
        # Only walls without surfels of their own are placed by the surfels before them.
        unseen = seen_shares(outline, walls) < _GUESSED_SHARE
        unseen &= covered_lengths(outline, walls) < _MIN_WALL_M
        outline = moved_behind(outline, unseen, pieces)
        room = _described(outline, walls, pieces)
        if not _enough(room, options):
            refused = max(refused, room.coverage)
        elif _its_own(room, rooms, spaces):
            rooms.append(room)
    if not rooms:
        raise _too_little(f"only {100.0 * refused:.0f} % of the walls were scanned")
    return tuple(rooms)


def _too_little(message: str) -> SparseScanError:
    return SparseScanError(
        f"{message}, too little to reconstruct its layout",
        remedy="scan the floor and at least two walls that meet, best every wall from end to "
        "end; `partial: true` in the layout guesses the missing walls; a scan on its side "
        "needs `up` (`--up`)",
    )


def _lines(walls: Walls, spaces: Spaces, directions: tuple[float, ...]) -> list[Line]:
    """Line hypotheses: scanned walls, ends of walls, and borders of the scanned plan."""
    lines = wall_lines(walls, directions)
    for normal, offset in [*end_lines(lines, directions), *border_lines(spaces, directions)]:
        if not any(_same(line, normal, offset) for line in lines):
            lines.append(profile(walls, normal, offset))
    return lines


def _same(line: Line, normal: Array, offset: float) -> bool:
    turn = float(line.normal @ normal)
    return abs(turn) > 0.999 and abs(line.offset * np.sign(turn) - offset) < 0.06


def _described(outline: Outline, walls: Walls, pieces: Surfels) -> LayoutRoom:
    import shapely

    corners = outline.corners()
    length = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    seen, near = seen_shares(outline, walls), residuals(outline, walls)
    own = pieces.take(shapely.contains_xy(shapely.Polygon(corners), pieces.points[:, :2]))
    ceiling = ceiling_height(own)
    return LayoutRoom(
        corners=corners,
        seen_shares=seen,
        guessed=tuple(int(i) for i in np.flatnonzero(seen < _GUESSED_SHARE)),
        ceiling=ceiling,
        coverage=float((seen * length).sum() / length.sum()),
        residual=float(np.sqrt((near**2).mean())) if len(near) else float("nan"),
        slopes=() if ceiling is not None else ceiling_slopes(own),
    )


def _enough(room: LayoutRoom, options: LayoutOptions) -> bool:
    """Whether two walls that are not parallel and enough of the outline were scanned."""
    if options.partial:
        return True
    run = np.roll(room.corners, -1, axis=0) - room.corners
    length = np.linalg.norm(run, axis=1)
    clear = room.seen_shares * length > _MIN_WALL_M
    ways = run[clear] / length[clear, None]
    differ = len(ways) > 0 and bool((np.abs(ways @ ways.T) < _OTHER_DIRECTION_COS).any())
    return differ and room.coverage >= options.least_coverage


def _its_own(room: LayoutRoom, others: list[LayoutRoom], spaces: Spaces) -> bool:
    """Whether a space is a room of its own, not a part of another one seen through a door."""
    import shapely

    if not others:
        return True
    shape = shapely.Polygon(room.corners)
    rest = shapely.union_all([shapely.Polygon(other.corners) for other in others])
    if shape.intersection(rest).area > 0.1 * shape.area:
        return False
    ends = np.roll(room.corners, -1, axis=0)
    length = np.linalg.norm(ends - room.corners, axis=1)
    shared = shapely.distance(rest, shapely.points((room.corners + ends) / 2.0)) < _SHARED_WALL_M
    own = float((room.seen_shares * length * ~shared).sum() / length.sum())
    inside = shapely.contains_xy(shape, spaces.centres())
    floor = float((spaces.rooms.ravel()[inside] > 0).mean())
    return own > _OWN_WALLS_SHARE and floor > _OWN_FLOOR_SHARE


def seen_shares(outline: Outline, walls: Walls) -> Array:
    """(N,) the part of each wall with vertical surfels."""
    corners = outline.corners()
    seen = np.zeros(len(outline))
    for i, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        line = profile(walls, outline.normals[i], float(outline.offsets[i]))
        seen[i] = line.seen_length(start @ line.along, end @ line.along) / np.linalg.norm(
            end - start
        )
    return seen


def covered_lengths(outline: Outline, walls: Walls) -> Array:
    """(N,) metres of each wall with surfels that count as wall."""
    corners = outline.corners()
    found = np.zeros(len(outline))
    for i, (start, end) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
        line = profile(walls, outline.normals[i], float(outline.offsets[i]))
        found[i] = line.covered(start @ line.along, end @ line.along)
    return found


def residuals(outline: Outline, walls: Walls) -> Array:
    """(P,) signed distances of surfels to their walls, outwards, metres."""
    starts = outline.corners()
    ends = np.roll(starts, -1, axis=0)
    found = []
    for normal, offset, start, end in zip(
        outline.normals, outline.offsets, starts, ends, strict=True
    ):
        along = np.array([-normal[1], normal[0]])
        place, across = walls.points @ along, walls.points @ normal - offset
        on = (place > start @ along) & (place < end @ along) & (np.abs(across) < walls.reach)
        found.append(across[on])
    return np.concatenate(found)


def open_leaves(pieces: Surfels, directions: tuple[float, ...]) -> Mask:
    """The surfels of open leaves: labelled door, and continuing no wall.

    Args:
        pieces: Surfels of a level scan; without labels no leaf is found.
        directions: Of walls, degrees modulo 90.
    """
    none = np.zeros(len(pieces), dtype=np.bool_)
    if pieces.label is None or not directions:
        return none
    standing = (np.abs(pieces.normals[:, 2]) < UPRIGHT_SINE) & (pieces.points[:, 2] > _SKIRTING_M)
    doors = np.flatnonzero(standing & (pieces.label == _DOOR_LABEL))
    walls = np.flatnonzero(standing & (pieces.label == _WALL_LABEL))
    if not len(doors) or not len(walls):
        return none
    places, column = _columns(pieces.points[doors, :2])
    angle = _normal_directions(places)
    off = np.min([angle_between(angle, direction) for direction in directions], axis=0)
    band = np.where(off > _ALIKE_DEG, _WALL_BAND_M, _FRAME_BAND_M)
    leaf = np.isfinite(angle) & ~_in_line(
        places, angle, band, _columns(pieces.points[walls, :2])[0]
    )
    none[doors[leaf[column]]] = True
    return none


def _columns(plan: Array) -> tuple[Array, Ints]:
    """(C, 2) centroids of occupied cells of the plan, and (N,) the cell of each surfel."""
    cells = np.floor((plan - plan.min(axis=0)) / VOXEL_M).astype(np.int64)
    _, column = np.unique(cells @ [1 << 32, 1], return_inverse=True)
    count = np.bincount(column)
    return np.column_stack([np.bincount(column, axis) / count for axis in plan.T]), column


def _normal_directions(places: Array) -> Array:
    """(C,) normal directions of line fits around places, degrees; NaN where there is too little."""
    from scipy.spatial import KDTree

    near = KDTree(places).query_pairs(_DIRECTION_RADIUS_M, output_type="ndarray")
    pairs = np.concatenate([near, near[:, ::-1], np.repeat(np.arange(len(places))[:, None], 2, 1)])
    x, y = places[pairs[:, 1]].T
    count, sx, sy, xx, xy, yy = (
        np.bincount(pairs[:, 0], values, len(places)).astype(np.float64)
        for values in (np.ones(len(pairs)), x, y, x * x, x * y, y * y)
    )
    covariance = xy - sx * sy / count
    difference = (xx - sx * sx / count) - (yy - sy * sy / count)
    along = 0.5 * np.arctan2(2.0 * covariance, difference)
    return np.where(count >= _MIN_PIECES, np.rad2deg(along) + 90.0, np.nan)


def _in_line(places: Array, angles: Array, band: Array, walls: Array) -> Mask:
    """(N,) whether a wall is collinear with the leaf at each place."""
    from scipy.spatial import KDTree

    found = np.zeros(len(places), bool)
    runs = _normal_directions(walls)
    for row, near in enumerate(KDTree(walls).query_ball_point(places, _WALL_ONWARD_M)):
        turn = np.deg2rad(angles[row])
        away = np.abs((walls[near] - places[row]) @ np.array([np.cos(turn), np.sin(turn)]))
        alike = angle_between(runs[near], angles[row], 180.0) < _ALIKE_DEG
        found[row] = ((away < band[row]) & alike).sum() >= _MIN_COLUMNS
    return found
