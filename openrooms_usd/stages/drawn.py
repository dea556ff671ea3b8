"""A room that a person drew over a scan, in the form of one that was found there."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.description.layout import CapturedLayout, Opening
from openrooms_usd.geometry.curves import signed_area
from openrooms_usd.geometry.polygons import counter_clockwise
from openrooms_usd.geometry.walls import walls_of
from openrooms_usd.scan.results import FoundOpening, FoundRoom
from openrooms_usd.stages.openings import hole_of

Array = NDArray[np.float64]


def drawn_room(layout: CapturedLayout) -> FoundRoom:
    """The room that a person drew over a scan, in the level frame; what is sure has confidence 1.

    Whether its openings fit is said where they are cut.

    Args:
        layout: A section with a polygon.
    """
    assert layout.polygon is not None, "asked for where there is one"
    corners, numbers = counter_clockwise(layout.polygon)
    walls = walls_of(corners, numbers, layout.wall_thickness)
    clockwise = signed_area(np.asarray(layout.polygon)) < 0.0
    # Found walls are numbered along the corners as they run counter-clockwise.
    place = {number: index for index, number in enumerate(numbers.tolist())}
    openings = []
    for one in layout.openings:
        if one.wall is None or one.kind == "opening":
            continue
        wall = walls[one.wall]
        hole = hole_of(one, wall, clockwise=clockwise)
        ends = wall.to_plan(np.array([[hole.left, 0.0], [hole.right, 0.0]]))[[0, 1, 1, 0]]
        levels = np.array([[hole.bottom], [hole.bottom], [hole.top], [hole.top]])
        rectangle = np.hstack([ends, levels])
        openings.append(FoundOpening(_type(one), rectangle, 1.0, place[one.wall]))
    return FoundRoom(
        normal=np.array([0.0, 0.0, 1.0]),
        point=np.zeros(3),
        corners=np.column_stack([corners, np.zeros(len(corners))]),
        ceiling=layout.height,
        openings=tuple(openings),
    )


def _type(opening: Opening) -> Literal["door", "window"]:
    return "window" if opening.kind == "window" else "door"
