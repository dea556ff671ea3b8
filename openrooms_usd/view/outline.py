"""The plan of a room as lines over its picture: the floor's outline, the openings in the walls."""

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.usd.frames import TIME, local_to_world, world_from_stage

Array = NDArray[np.float64]

# Corners of an opening in its own frame, in halves of its width and height.
_RECTANGLE = np.array([[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]])


def plan_of(stage: Usd.Stage) -> list[list[float]]:
    """Ends of lines, two after the other: [x, y, z] in metres, Z up; none without a room's plan.

    Args:
        stage: A composed stage.
    """
    cache, to_world = UsdGeom.XformCache(TIME), world_from_stage(stage)
    loops = []
    for prim, corners in [*_floor(stage), *_openings(stage)]:
        frame = to_world @ local_to_world(prim, cache)
        loops.append(corners @ frame[:3, :3].T + frame[:3, 3])
    lines = [np.stack([loop, np.roll(loop, -1, axis=0)], axis=1).reshape(-1, 3) for loop in loops]
    found: list[list[float]] = np.concatenate([np.empty((0, 3)), *lines]).tolist()
    return found


def _floor(stage: Usd.Stage) -> list[tuple[Usd.Prim, Array]]:
    """The room with the (N, 3) corners of its floor between the walls."""
    prim = stage.GetPrimAtPath(names.ROOM)
    attribute = prim.GetAttribute(names.ROOM_FLOOR) if prim else None
    corners = np.array((attribute.Get(TIME) if attribute else None) or [], dtype=np.float64)
    if corners.ndim != 2 or not np.isfinite(corners).all():
        return []
    return [(prim, np.column_stack([corners, np.zeros(len(corners))]))]


def _openings(stage: Usd.Stage) -> list[tuple[Usd.Prim, Array]]:
    """Doors, windows and openings with their (4, 3) corners, on the inside of the wall."""
    openings = stage.GetPrimAtPath(names.OPENINGS)
    found = []
    for prim in openings.GetChildren() if openings else ():
        attributes = map(prim.GetAttribute, (names.OPENING_WIDTH, names.OPENING_HEIGHT))
        width, height = (one.Get(TIME) if one else None for one in attributes)
        if width and height:
            found.append((prim, 0.5 * _RECTANGLE * [width, 1.0, height]))
    return found
