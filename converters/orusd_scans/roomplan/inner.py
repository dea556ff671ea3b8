"""The walls of RoomPlan that are not on the floor's outline: inside it they are partitions."""

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.capture import CapturedPartition
from orusd_scans.floorplan import TWIN_DISTANCE_M
from orusd_scans.roomplan.records import Record
from orusd_scans.roomplan.spaces import facets, placed, rectangle

if TYPE_CHECKING:
    from shapely import Polygon

Array = NDArray[np.float64]

# A wall of which less than this is inside the floor stands outside, metres: half a door.
_MIN_INSIDE_M: Final = 0.4
# What may be missing of a wall at the outline before it is said, metres.
_MAX_CUT_M: Final = 0.3
# Points at which a wall is held against the outline.
_SAMPLES: Final = 17


def inner_walls(
    walls: Sequence[Record], floor: Array, to_world: Callable[[Array], Array], notes: list[str]
) -> tuple[CapturedPartition, ...]:
    """The walls that stand inside the floor.

    Args:
        walls: All walls of the room.
        floor: (N, 2) the corners of its floor in the world, metres.
        to_world: Takes points (..., 3) of the source to the world.
        notes: Receives a sentence for each wall that is left out or cut.
    """
    import shapely

    polygon = shapely.Polygon(floor)
    found: list[CapturedPartition] = []
    for wall in walls:
        top = float(to_world(placed(wall, rectangle(wall)))[:, 2].max())
        lines = to_world(facets(wall))[:, :2]
        pieces = list(_pieces(wall, lines, polygon, notes))
        for number, ends in enumerate(pieces):
            name = wall.id if len(pieces) == 1 else f"{wall.id} {number}"
            found.append(CapturedPartition(name, ends, None, top, wall.confidence))
    return tuple(found)


def _pieces(wall: Record, line: Array, polygon: "Polygon", notes: list[str]) -> Iterator[Array]:
    """(2, 2) the straight parts of a wall (N, 2) inside a floor, unless it is on the outline."""
    import shapely

    path = shapely.LineString(line)
    samples = shapely.line_interpolate_point(path, np.linspace(0.0, 1.0, _SAMPLES), normalized=True)
    off = shapely.distance(samples, shapely.boundary(polygon))
    if off.max() <= TWIN_DISTANCE_M:
        return
    parts = [
        part
        for part in shapely.get_parts(shapely.intersection(path, polygon))
        if part.geom_type == "LineString"
    ]
    kept = max(parts, key=lambda part: part.length, default=None)
    if kept is None or kept.length < min(_MIN_INSIDE_M, 0.5 * path.length):
        notes.append(f"left out the wall {wall.id} ({path.length:.2f} m): it is outside the floor")
        return
    if path.length - kept.length > _MAX_CUT_M:
        notes.append(
            f"the inner wall {wall.id} ends at the floor's edge: {kept.length:.2f} m "
            f"of {path.length:.2f} m are built"
        )
    corners = shapely.get_coordinates(kept)
    yield from np.stack([corners[:-1], corners[1:]], axis=1)
