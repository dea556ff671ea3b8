"""A room's plan as plain data: corners, what is cut into the walls, and walls that stand free."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.building.walls import Wall, walls_of
from openrooms_usd.description.layout import Opening, Partition, named_partitions
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.curves import signed_area
from openrooms_usd.geometry.polygons import counter_clockwise

Point = tuple[float, float]

# What is written of lengths, metres: a tenth of a millimetre.
_DIGITS: Final = 4


@dataclass(frozen=True)
class Drawing:
    """A room's plan; every change makes another one.

    Attributes:
        corners: Inner corners in order, either way round, metres.
        height: Floor to ceiling, metres.
        openings: Each with its place, width, height and sill.
        partitions: Walls that stand free.
        thickness: Of the outer walls, metres.
    """

    corners: tuple[Point, ...]
    height: float
    openings: tuple[Opening, ...] = ()
    partitions: tuple[Partition, ...] = ()
    thickness: float = 0.2

    @property
    def polygon(self) -> Array:
        """(N, 2) the corners."""
        return np.asarray(self.corners, dtype=np.float64)

    @property
    def clockwise(self) -> bool:
        """Whether the corners run clockwise, seen from above."""
        return signed_area(self.polygon) < 0.0

    @property
    def area(self) -> float:
        """Of the floor, square metres."""
        return abs(signed_area(self.polygon))

    def walls(self) -> tuple[Wall, ...]:
        """The walls of the outline by their numbers."""
        corners, numbers = counter_clockwise(self.polygon)
        return walls_of(corners, numbers, self.thickness)

    def seen(self, wall: int | None = None, partition: str | None = None) -> Wall:
        """A wall of the outline, or a partition, as its elevation shows it.

        Raises:
            InputError: There is none.
        """
        if partition is None:
            number = -1 if wall is None else wall
            self.check("wall", number, len(self.corners))
            return self.walls()[number]
        row = dict(named_partitions(self.partitions)).get(partition)
        if row is None:
            raise InputError(f"there is no partition {partition}", remedy="choose another wall")
        start, end = np.asarray(row.line)
        way = end - start
        length = max(float(np.linalg.norm(way)), 1e-9)
        inwards = 0.5 * row.thickness / length * np.array([way[1], -way[0]])
        corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        outline = corners * [length, row.thickness]
        left, right = start + inwards, end + inwards
        return Wall(0, left, right, row.thickness, outline, 0.0, partition, row.height)

    def ends(self, wall: int) -> tuple[Array, Array]:
        """Where a wall of the outline starts and ends.

        Raises:
            InputError: There is no such wall.
        """
        self.check("wall", wall, len(self.corners))
        points = self.polygon
        return points[wall], points[(wall + 1) % len(points)]

    def line(self, opening: Opening) -> tuple[Array, Array]:
        """Where the wall or partition of an opening starts and ends."""
        if opening.partition is None:
            assert opening.wall is not None, "an opening is in a wall or in a partition"
            return self.ends(opening.wall)
        lines = {name: row.line for name, row in named_partitions(self.partitions)}
        start, end = lines[opening.partition]
        return np.asarray(start), np.asarray(end)

    def check(self, what: str, number: int, count: int) -> None:
        """Refuse a number that nothing has.

        Raises:
            InputError: It is not from 0 to ``count`` - 1.
        """
        if not 0 <= number < count:
            raise InputError(
                f"there is no {what} {number}", remedy="reload the plan: it may have changed since"
            )

    def as_section(self) -> dict[str, Any]:
        """The keys of a layout section that say all of it; None for what there is none of."""
        openings = [_written(one, Opening) for one in self.openings]
        partitions = [_written(one, Partition) for one in self.partitions]
        return {
            "polygon": _rounded(self.corners),
            "height": _rounded(self.height),
            "partitions": partitions or None,
            "openings": openings or None,
        }


def reseated(
    before: Drawing, corners: Sequence[Point], candidates: Callable[[int], Sequence[int]]
) -> Drawing:
    """The plan with other corners, whose openings stay where they are in the room.

    Args:
        before: The plan.
        corners: The new ones.
        candidates: For the number of an old wall those that it became: the nearest one is taken.
    """
    after = replace(before, corners=tuple((float(x), float(y)) for x, y in corners), openings=())
    openings = []
    for one in before.openings:
        if one.wall is None:
            openings.append(one)
            continue
        start, end = before.ends(one.wall)
        middle = start + (end - start) / max(float(np.linalg.norm(end - start)), 1e-9) * (
            one.at or 0.0
        )
        away = {number: _foot(middle, *after.ends(number)) for number in candidates(one.wall)}
        number = min(away, key=lambda number: away[number][1])
        same = np.array_equal(after.ends(number), (start, end))
        at = one.at if same else away[number][0]
        openings.append(one.model_copy(update={"wall": number, "at": at}))
    return replace(after, openings=tuple(openings))


def _foot(point: Array, start: Array, end: Array) -> tuple[float, float]:
    """How far along a segment the foot of a point lies, and how far the segment is from it."""
    along = end - start
    length = max(float(np.linalg.norm(along)), 1e-9)
    at = float((point - start) @ along) / length
    nearest = start + along / length * np.clip(at, 0.0, length)
    return at, float(np.linalg.norm(point - nearest))


def _written(row: Opening | Partition, model: type[Opening] | type[Partition]) -> dict[str, Any]:
    """What is to be said of a row: no defaults, lengths to a tenth of a millimetre."""
    told: Mapping[str, Any] = row.model_dump(mode="json", by_alias=True, exclude_defaults=True)
    first = [name for name in model.model_fields if name in told]
    return {name: _rounded(told[name]) for name in first}


def _rounded(value: Any) -> Any:
    if isinstance(value, (list, tuple)):
        return [_rounded(one) for one in value]
    if isinstance(value, float):
        whole = round(value, _DIGITS) + 0.0
        return int(whole) if whole.is_integer() else whole
    return value
