"""The rooms of a level scan: closed polygons from the evidence of walls.

Lines on which walls may stand (`candidates`, and `borders` where a wall was missed) cut the plan
into cells; a minimum cut says which cells are inside (`roomcut`), once for each space that narrow
places separate (`spaces`); the outline loses the corners that are not worth it (`outline`), and
its walls move to where their points lie (`refit`).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.errors import InputError
from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.points.surfels import Surfels, surfels
from openrooms_usd.scan.results import FoundOpening, FoundRoom
from openrooms_usd.scan.rooms.borders import border_lines, end_lines, moved_behind
from openrooms_usd.scan.rooms.candidates import wall_lines
from openrooms_usd.scan.rooms.ceilings import ceiling_height, ceiling_slopes
from openrooms_usd.scan.rooms.cells import cut_plan
from openrooms_usd.scan.rooms.doorleaves import open_leaves
from openrooms_usd.scan.rooms.levelling import Level
from openrooms_usd.scan.rooms.outline import Outline
from openrooms_usd.scan.rooms.roomcut import Plan
from openrooms_usd.scan.rooms.shown import covered_lengths, distances, shown_parts
from openrooms_usd.scan.rooms.spaces import Spaces, find_spaces
from openrooms_usd.scan.rooms.walls import Line, Walls, profile, upright

Array = NDArray[np.float64]

# What a square metre of the room that lies inside is worth, in metres of missing wall.
_INSIDE_WORTH: Final = 1.0
# A partial view has few walls to hold what it shows.
_PARTIAL_INSIDE_WORTH: Final = 6.0
# Walls of which less was seen are guessed.
_GUESSED_SHARE: Final = 0.3
# Two walls that were seen this far, metres, in directions this far apart, as a cosine.
_MIN_WALL_M: Final = 0.4
_OTHER_DIRECTION_COS: Final = 0.87
# A space beside a larger room is one of its own if this part of its own walls and of its floor
# was seen; walls nearer to the other room, metres, are that one's.
_OWN_WALLS_SHARE: Final = 0.6
_OWN_FLOOR_SHARE: Final = 0.6
_SHARED_WALL_M: Final = 0.03


@dataclass(frozen=True)
class LayoutOptions:
    """What people may choose.

    Attributes:
        simplicity: What a corner must save in missing wall to be worth its while, metres. Larger
            values give plainer rooms.
        least_coverage: Rooms of whose outline a smaller part was seen are refused.
        partial: Accept whatever was seen, as of a single view; the rest is guessed.
    """

    simplicity: float = 0.1
    least_coverage: float = 0.25
    partial: bool = False


DEFAULTS: Final = LayoutOptions()


@dataclass(frozen=True, eq=False)
class LayoutRoom:
    """One room in the level frame.

    Attributes:
        corners: (N, 2) at the walls' inner faces, counter-clockwise.
        shown: (N,) the part of each wall, from corner i to the next, that was seen.
        guessed: Numbers of the walls that were hardly seen.
        ceiling: Height of a level ceiling, metres; None where none was seen, or where it slopes.
        coverage: The part of the outline that was seen.
        residual: Root of the mean squared distance of the walls' pieces to them, metres.
        slopes: Planes of a ceiling that is not level: normal (3,) into the room, and a point (3,).
    """

    corners: Array
    shown: Array
    guessed: tuple[int, ...]
    ceiling: float | None
    coverage: float
    residual: float
    slopes: tuple[tuple[Array, Array], ...] = ()

    def found(self, level: Level, openings: tuple[FoundOpening, ...] = ()) -> FoundRoom:
        """The room in the scan's own frame.

        Args:
            level: How the scan stands.
            openings: What is in the walls, in the scan's frame already.
        """
        back = level.scan_from_level
        corners = self.corners @ back[:3, :2].T + back[:3, 3]
        measures = {
            "coverage": self.coverage,
            "floor_residual": level.residual,
            "wall_residual": self.residual,
        }
        told = {name: value for name, value in measures.items() if np.isfinite(value)}
        return FoundRoom(
            level.normal, level.point, corners, self.guessed, self.ceiling, openings, told,
            tuple((back[:3, :3] @ n, back[:3, :3] @ p + back[:3, 3]) for n, p in self.slopes),
        )  # fmt: skip


def find_layout(
    cloud: Cloud, level: Level, options: LayoutOptions = DEFAULTS
) -> tuple[LayoutRoom, ...]:
    """Find the rooms of a scan.

    Args:
        cloud: N finite points in the level frame, metres. Labels (NYU40) and sensors help where
            they are given.
        level: How the scan stands.
        options: What people may choose.

    Returns:
        The rooms, the largest space first.

    Raises:
        InputError: The scan shows too little of any room.
    """
    pieces = surfels(cloud)
    walls = upright(pieces.take(~open_leaves(pieces, level.directions)))
    if not len(walls.points):
        raise _too_little("the scan shows no wall")
    # What is seen of a part of a room is seen from inside it.
    sensor_origins = (
        np.zeros((0, 2)) if cloud.sensor_origins is None else cloud.sensor_origins[:, :2]
    )
    held = sensor_origins if options.partial else sensor_origins[:0]
    spaces = find_spaces(pieces, walls, cloud.sensor_origins, held)
    lines = _lines(walls, spaces, level.directions)
    cells = cut_plan(lines, spaces.low, spaces.high, level.directions)
    plan = Plan(
        walls, spaces, cells, level.directions, options.simplicity,
        _PARTIAL_INSIDE_WORTH if options.partial else _INSIDE_WORTH, sensor_origins, held,
    )  # fmt: skip
    rooms: list[LayoutRoom] = []
    refused = 0.0
    for number in range(1, len(spaces.middles) + 1):
        outline = plan.outline(number)
        # What was seen of a wall tells its place better than what was seen before it.
        unseen = shown_parts(outline, walls) < _GUESSED_SHARE
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


def _too_little(message: str) -> InputError:
    return InputError(
        f"{message}, which is too little for its layout",
        remedy="scan the floor and at least two walls that meet, best every wall from end to end",
    )


def _lines(walls: Walls, spaces: Spaces, directions: tuple[float, ...]) -> list[Line]:
    """Lines on which walls were seen, and where what was seen ends without one."""
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
    shown, near = shown_parts(outline, walls), distances(outline, walls)
    own = pieces.take(shapely.contains_xy(shapely.Polygon(corners), pieces.points[:, :2]))
    ceiling = ceiling_height(own)
    return LayoutRoom(
        corners=corners,
        shown=shown,
        guessed=tuple(int(i) for i in np.flatnonzero(shown < _GUESSED_SHARE)),
        ceiling=ceiling,
        coverage=float((shown * length).sum() / length.sum()),
        residual=float(np.sqrt((near**2).mean())) if len(near) else float("nan"),
        slopes=() if ceiling is not None else ceiling_slopes(own),
    )


def _enough(room: LayoutRoom, options: LayoutOptions) -> bool:
    """Whether two walls that are not parallel were seen, and enough of the outline."""
    if options.partial:
        return True
    run = np.roll(room.corners, -1, axis=0) - room.corners
    length = np.linalg.norm(run, axis=1)
    clear = room.shown * length > _MIN_WALL_M
    ways = run[clear] / length[clear, None]
    differ = len(ways) > 0 and bool((np.abs(ways @ ways.T) < _OTHER_DIRECTION_COS).any())
    return differ and room.coverage >= options.least_coverage


def _its_own(room: LayoutRoom, others: list[LayoutRoom], spaces: Spaces) -> bool:
    """Whether a space is a room of its own, and not what is seen of another through a door."""
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
    own = float((room.shown * length * ~shared).sum() / length.sum())
    inside = shapely.contains_xy(shape, spaces.centres())
    floor = float((spaces.rooms.ravel()[inside] > 0).mean())
    return own > _OWN_WALLS_SHARE and floor > _OWN_FLOOR_SHARE
