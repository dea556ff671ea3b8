"""The rooms of a level scan as closed polygons.

Line hypotheses (`candidates`, and `borders` for missed walls) cut the plan into cells; for each
space of a watershed (`spaces`) a minimum cut labels them inside or outside (`roomoutline`); the
outline is simplified as long as its cost falls (`outline`), and its lines are refitted (`refit`).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import SparseScanError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import Surfels, surfels
from openrooms_usd.scan.results import FoundOpening, FoundRoom
from openrooms_usd.scan.rooms.borders import border_lines, end_lines, moved_behind
from openrooms_usd.scan.rooms.candidates import wall_lines
from openrooms_usd.scan.rooms.ceilings import ceiling_height, ceiling_slopes
from openrooms_usd.scan.rooms.cells import cut_plan
from openrooms_usd.scan.rooms.coverage import covered_lengths, residuals, seen_shares
from openrooms_usd.scan.rooms.doorleaves import open_leaves
from openrooms_usd.scan.rooms.faces import no_walls
from openrooms_usd.scan.rooms.levelling import Level
from openrooms_usd.scan.rooms.outline import Outline
from openrooms_usd.scan.rooms.roomoutline import Plan
from openrooms_usd.scan.rooms.soffits import ceilings_of
from openrooms_usd.scan.rooms.spaces import Spaces, find_spaces, walled_shares
from openrooms_usd.scan.rooms.walls import Line, Walls, profile, upright

Array = NDArray[np.float64]

# Gain of a square metre of the room inside, in metres of missing wall.
_INSIDE_GAIN: Final = 1.0
# A partial view has few walls, which the gain must outweigh.
_PARTIAL_INSIDE_GAIN: Final = 6.0
# Walls of which less was scanned are reported as guessed.
_GUESSED_SHARE: Final = 0.3
# Spaces of whose border less is beside walls, such as lawns, are no rooms.
_WALLED_SHARE: Final = 0.1
# A room needs two walls with this much scanned, in directions with at most this cosine.
_MIN_WALL_M: Final = 0.4
_OTHER_DIRECTION_COS: Final = 0.87
# A space beside a larger room is a room if this part of its own walls and of its floor was
# scanned; walls this near to the other room are shared, metres.
_OWN_WALLS_SHARE: Final = 0.6
_OWN_FLOOR_SHARE: Final = 0.6
_SHARED_WALL_M: Final = 0.03


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
            level.normal, level.point, corners, self.guessed, self.ceiling, openings, finite,
            tuple((back[:3, :3] @ n, back[:3, :3] @ p + back[:3, 3]) for n, p in self.slopes),
        )  # fmt: skip


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
        walls, spaces, cells, level.directions, options.simplicity,
        _PARTIAL_INSIDE_GAIN if options.partial else _INSIDE_GAIN, sensor_origins, included,
    )  # fmt: skip
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
        raise _too_little(f"the scan shows {100.0 * refused:.0f} % of the walls of any room")
    return tuple(rooms)


def _too_little(message: str) -> SparseScanError:
    return SparseScanError(
        f"{message}, which is too little for its layout",
        remedy="scan the floor and at least two walls that meet, best every wall from end to end;"
        " `partial: true` in the layout takes what there is and guesses the rest; a scan on its"
        " side needs `up` (`--up`)",
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
