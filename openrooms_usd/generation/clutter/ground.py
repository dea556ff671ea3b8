"""What lies about on the floor and hangs on the walls: shoes by the door, a basket in a corner."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture.placements import Place
from openrooms_usd.generation.boxes import Pose, overlap
from openrooms_usd.generation.clutter.laying import PosedObject, Taken
from openrooms_usd.generation.items import STEP_M, Item, placed
from openrooms_usd.generation.placement import Arrangement

_TRIES: Final = 24
_WALL_GAP_M: Final = 0.02
_BESIDE_M: Final = 0.04
_DOOR_GAP_M: Final = 0.16
_HANGING_GAP_M: Final = 0.07


@dataclass
class Ground:
    """The floor of a furnished room.

    Attributes:
        room: The room with its paths.
        items: Its furniture.
        taken: What takes up space.
        rng: Draws places.
    """

    room: Arrangement
    items: Sequence[Item]
    taken: Taken
    rng: np.random.Generator

    def place(self, place: Place, thing: PosedObject) -> Pose | None:
        """Where a thing stands on the floor without being in the way; None where it would be.

        Args:
            place: A place of the floor, such as ``floor_by_door``.
            thing: What it is.
        """
        for pose in self._poses(place, thing):
            if self._free(thing, pose):
                return pose
        return None

    def hang(self, thing: PosedObject, low: float) -> Pose | None:
        """Where a thing hangs on a wall with nothing before it, its lower edge at a height."""
        if low + thing.size[2] > self.room.shell.height - 0.08:
            return None
        sides = self.room.shell.sides
        lengths = np.array([side.length for side in sides])
        for _ in range(_TRIES):
            side = sides[int(self.rng.choice(len(sides), p=lengths / lengths.sum()))]
            at = float(self.rng.uniform(0.0, side.length))
            x, y = side.point(at, 0.5 * thing.size[1]).tolist()
            box = thing.standing((x, y, side.yaw), low)
            half = 0.5 * thing.size[0] + _HANGING_GAP_M
            free = half < at < side.length - half and self.room.shows(box, _HANGING_GAP_M)
            if free and not self._meets(box, _HANGING_GAP_M, -0.002):
                return x, y, side.yaw
        return None

    def _meets(self, box: Array, gap: float, to_walls: float) -> bool:
        shell = self.room.shell
        return bool(
            overlap(box, shell.walls, to_walls).any()
            or overlap(box, shell.kept, gap).any()
            or overlap(box, shell.attached).any()
            or overlap(box, self.taken.boxes, gap).any()
        )

    def meets_walls(self, box: Array) -> bool:
        """Whether a box runs into a wall, or into what is fixed to walls and ceiling."""
        shell = self.room.shell
        return bool(overlap(box, shell.walls).any() or overlap(box, shell.attached).any())

    def _free(self, thing: PosedObject, pose: Pose) -> bool:
        box = thing.standing(pose, 0.0)
        if not self.room.shell.contains(box[:, :2]).all() or self._meets(box, 0.01, 0.005):
            return False
        if thing.size[2] <= STEP_M:
            return True
        if len(self.room.zones) and overlap(box, self.room.zones).any():
            return False
        floor = self.room.floor.with_boxes(box)
        reachable = floor.connected()
        if reachable is None or not floor.reaches(reachable, self.room.access):
            return False
        self.room.floor = floor
        return True

    def _poses(self, place: Place, thing: PosedObject) -> Iterator[Pose]:
        source = _SOURCES.get(place)
        if source is not None:
            for _ in range(_TRIES):
                pose = source(self, thing)
                if pose is not None:
                    yield pose

    def _by_door(self, thing: PosedObject) -> Pose | None:
        doors = self.room.shell.doors
        if not doors:
            return None
        gap = doors[int(self.rng.integers(len(doors)))]
        side = self.room.shell.sides[gap.side]
        away = 0.5 * gap.width + _DOOR_GAP_M + 0.5 * thing.size[0] + float(self.rng.uniform(0, 0.7))
        at = gap.at + away * (1 if self.rng.random() < 0.5 else -1)
        return self._at_wall(gap.side, at, thing) if 0.0 < at < side.length else None

    def _at_wall(self, side: int, at: float, thing: PosedObject, turned: float = 8.0) -> Pose:
        wall = self.room.shell.sides[side]
        x, y = wall.point(at, 0.5 * thing.size[1] + _WALL_GAP_M + 0.1 * thing.size[0]).tolist()
        return x, y, wall.yaw + float(self.rng.uniform(-turned, turned))

    def _by_wall(self, thing: PosedObject) -> Pose | None:
        sides = self.room.shell.sides
        lengths = np.array([side.length for side in sides])
        side = int(self.rng.choice(len(sides), p=lengths / lengths.sum()))
        return self._at_wall(side, float(self.rng.uniform(0.0, sides[side].length)), thing)

    def _corner(self, thing: PosedObject) -> Pose | None:
        side = int(self.rng.integers(len(self.room.shell.sides)))
        half = 0.5 * thing.size[0] + 0.05 + 0.1 * thing.size[1]
        length = self.room.shell.sides[side].length
        at = half if self.rng.random() < 0.5 else length - half
        return self._at_wall(side, at, thing, 5.0)

    def _anywhere(self, thing: PosedObject) -> Pose | None:
        low, high = self.room.shell.corners.min(axis=0), self.room.shell.corners.max(axis=0)
        x, y = self.rng.uniform(low, high).tolist()
        return x, y, float(self.rng.uniform(-180.0, 180.0))

    def _beside(self, thing: PosedObject, *names: str) -> Pose | None:
        """Beside a piece of furniture, to its right or left."""
        found = [item for item in self.items if item.category in names and item.z < 0.1]
        if not found:
            return None
        item = found[int(self.rng.integers(len(found)))]
        side = 1.0 if self.rng.random() < 0.5 else -1.0
        width, depth, _ = item.size
        x = side * (0.5 * (width + thing.size[0]) + _BESIDE_M + float(self.rng.uniform(0, 0.1)))
        y = float(self.rng.uniform(-0.4, 0.4)) * depth
        px, py = placed((item.x, item.y, item.yaw), x, y)
        return px, py, item.yaw + float(self.rng.uniform(-15, 15))

    def _by_media(self, thing: PosedObject) -> Pose | None:
        """At the wall, beside what a television stands on."""
        below = [item.on for item in self.items if item.category == "television"]
        found = [item for item in self.items if item.key in below and item.z < 0.1]
        if not found:
            return None
        item = found[int(self.rng.integers(len(found)))]
        side = 1.0 if self.rng.random() < 0.5 else -1.0
        away = 0.5 * (item.size[0] + thing.size[0]) + float(self.rng.uniform(0.03, 0.25))
        y = 0.5 * (item.size[1] - thing.size[1]) - float(self.rng.uniform(0.03, 0.12))
        px, py = placed((item.x, item.y, item.yaw), side * away, y)
        return px, py, item.yaw + float(self.rng.uniform(-12, 12))

    def _before(self, thing: PosedObject, *names: str) -> Pose | None:
        """On the floor before a piece of furniture."""
        found = [item for item in self.items if item.category in names]
        if not found:
            return None
        item = found[int(self.rng.integers(len(found)))]
        y = -0.5 * (item.size[1] + thing.size[1]) - float(self.rng.uniform(0.03, 0.12))
        x = float(self.rng.uniform(-0.2, 0.2)) * item.size[0]
        px, py = placed((item.x, item.y, item.yaw), x, y)
        return px, py, item.yaw + float(self.rng.uniform(-6, 6))

    def _below(self, thing: PosedObject, *names: str) -> Pose | None:
        """Below a table, towards its back."""
        found = [item for item in self.items if item.category in names]
        if not found:
            return None
        item = found[int(self.rng.integers(len(found)))]
        x = float(self.rng.uniform(-0.42, 0.42)) * item.size[0]
        y = 0.5 * item.size[1] - 0.5 * thing.size[1] - float(self.rng.uniform(0.03, 0.15))
        px, py = placed((item.x, item.y, item.yaw), x, y)
        return px, py, item.yaw + float(self.rng.uniform(-20, 20))


_SOURCES: Final[dict[Place, Callable[[Ground, PosedObject], Pose | None]]] = {
    "floor_by_door": Ground._by_door,
    "floor_by_wall": Ground._by_wall,
    "floor_corner": Ground._corner,
    "floor_open": Ground._anywhere,
    "floor_beside_bed": lambda ground, thing: ground._beside(thing, "bed"),
    "floor_beside_sofa": lambda ground, thing: ground._beside(thing, "sofa", "armchair"),
    "beside_toilet": lambda ground, thing: ground._beside(thing, "toilet"),
    "floor_before_basin": lambda ground, thing: ground._before(thing, "sink", "bathtub"),
    "floor_by_media": Ground._by_media,
    "floor_under_desk": lambda ground, thing: ground._below(thing, "desk"),
}
