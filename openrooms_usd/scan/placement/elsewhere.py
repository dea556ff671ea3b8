"""Things that a scan shows beyond the walls of a room: they belong to other rooms."""

from collections.abc import Collection, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.scan.points.cloud import Cloud
from openrooms_usd.scan.registration.hints import Hint
from openrooms_usd.scan.results import FoundRoom

Array = NDArray[np.float64]

# A thing whose middle point lies farther beyond the inner faces of the walls than this is not of
# the room, metres: about the thickness of a wall, or the depth of a window's recess.
_BEYOND_M: Final = 0.25
# Points of an instance that are looked at: more change nothing.
_MAX_POINTS: Final = 2000


def elsewhere(
    cloud: Cloud, hints: Sequence[Hint] | None, rooms: Sequence[FoundRoom]
) -> frozenset[int]:
    """The instances that stand in none of some rooms.

    Args:
        cloud: In the frame of the rooms.
        hints: The objects; None: every instance of the cloud.
        rooms: Those that are composed; none: nothing is elsewhere.
    """
    if not rooms:
        return frozenset()
    numbers = _numbers(cloud) if hints is None else [hint.instance for hint in hints]
    places = _points(cloud, numbers)
    for hint in hints or ():
        if not len(places[hint.instance]) and (known := hint.box or hint.pose) is not None:
            place = hint.box.center if hint.box is not None else None
            place = hint.pose.translation if place is None and hint.pose is not None else place
            assert place is not None, known
            places[hint.instance] = place[None, :2]
    return frozenset(
        number for number, points in places.items() if len(points) and _is_beyond(points, rooms)
    )


def _numbers(cloud: Cloud) -> list[int]:
    if cloud.instance is None:
        return []
    return [int(number) for number in np.unique(cloud.instance) if number > 0]


def _points(cloud: Cloud, numbers: Collection[int]) -> dict[int, Array]:
    """(P, 2) of each instance in the plan, not all of many."""
    if cloud.instance is None:
        return {number: np.empty((0, 2)) for number in numbers}
    order = np.argsort(cloud.instance, kind="stable")
    ranked = cloud.instance[order]
    found = {}
    for number in numbers:
        begin, end = np.searchsorted(ranked, [number, number + 1])
        step = max((end - begin) // _MAX_POINTS, 1)
        found[number] = cloud.points[order[begin:end:step], :2]
    return found


def _is_beyond(points: Array, rooms: Sequence[FoundRoom]) -> bool:
    import shapely

    places = shapely.points(points)
    distances = [
        float(np.median(shapely.distance(shapely.Polygon(room.corners[:, :2]), places)))
        for room in rooms
    ]
    return min(distances) > _BEYOND_M
