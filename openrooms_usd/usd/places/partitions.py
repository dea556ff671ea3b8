"""The free-standing walls of a room, as they are on a stage."""

from typing import Final, NamedTuple

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.usd.places.frames import TIME, local_to_world

_MIN_CORNERS: Final = 3


class StandingWall(NamedTuple):
    """A free-standing wall.

    Attributes:
        path: Of its prim.
        outline: (K, 2) convex, counter-clockwise in the plan of the world, metres; its first edge
            is one of its two faces.
        height: Metres above the floor.
    """

    path: str
    outline: Array
    height: float

    @property
    def faces(self) -> Array:
        """(2, 2, 2) start and end of its two faces; the room is on their left."""
        starts, ends = self.outline, np.roll(self.outline, -1, axis=0)
        along = (ends[0] - starts[0]) / np.linalg.norm(ends[0] - starts[0])
        # The second face runs the other way.
        back = int(np.argmin((ends - starts) @ along))
        return np.array([[ends[0], starts[0]], [ends[back], starts[back]]])


def read_partitions(stage: Usd.Stage) -> tuple[StandingWall, ...]:
    """The active free-standing walls of a composed room, in the world, in its order."""
    walls, cache = stage.GetPrimAtPath(names.WALLS), UsdGeom.XformCache(TIME)
    found = [_read(prim, cache) for prim in (walls.GetChildren() if walls else ())]
    return tuple(wall for wall in found if wall is not None)


def is_partition(prim: Usd.Prim) -> bool:
    """Whether a prim is a free-standing wall."""
    # By its outline: USD leaves schemas that are not registered out of those it lists.
    outline = prim.GetAttribute(names.PARTITION_OUTLINE) if prim else None
    return bool(outline and outline.HasValue())


def _read(prim: Usd.Prim, cache: UsdGeom.XformCache) -> StandingWall | None:
    if not is_partition(prim):
        return None
    given = [prim.GetAttribute(key) for key in (names.PARTITION_OUTLINE, names.PARTITION_HEIGHT)]
    outline, height = (a.Get(TIME) if a and a.HasValue() else None for a in given)
    corners = np.array(() if outline is None else outline, dtype=np.float64).reshape(-1, 2)
    if len(corners) < _MIN_CORNERS or not np.isfinite(corners).all() or height is None:
        return None
    frame = local_to_world(prim, cache)
    placed = corners @ frame[:2, :2].T + frame[:2, 3]
    return StandingWall(str(prim.GetPath()), placed, float(height))
