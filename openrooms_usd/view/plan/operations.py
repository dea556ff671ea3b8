"""What a page may ask for: each operation with what comes with it, and what it makes of a plan."""

from collections.abc import Callable, Mapping
from typing import Any, Final, Literal, NamedTuple

from pydantic import Field

from openrooms_usd.building.shell import Hole
from openrooms_usd.description.model import Model, Number, Switch, Whole
from openrooms_usd.view.plan import corners, fittings
from openrooms_usd.view.plan.drawing import Drawing

Point = tuple[Number, Number]
Rectangle = tuple[Number, Number, Number, Number]


class SnapRequest(Model):
    """What comes with every operation."""

    snap: Switch = False
    """Whether it goes where it is probably meant."""
    final: Switch = True
    """False while something is still being dragged: it is shown, and not done."""


class CornerRequest(SnapRequest):
    """A corner."""

    corner: Whole


class MoveCorner(CornerRequest):
    """A corner, and where it goes."""

    to: Point


class WallRequest(SnapRequest):
    """A wall of the outline."""

    wall: Whole


class MoveWall(WallRequest):
    """A wall, and by which way it was dragged."""

    by: Point


class SplitWall(WallRequest):
    """A wall, and where."""

    at: Point


class AddOpening(SnapRequest):
    """An opening of a wall or a partition, by its left, right, bottom and top."""

    wall: Whole | None = None
    partition: str | None = None
    kind: Literal["window", "door", "opening"] | None = None
    rectangle: Rectangle


class OfOpening(SnapRequest):
    """An opening."""

    opening: Whole


class SetOpening(OfOpening):
    """An opening, and what it becomes."""

    kind: Literal["window", "door", "opening"] | None = None
    rectangle: Rectangle | None = None


class AddPartition(SnapRequest):
    """A wall that stands free, by its ends."""

    line: tuple[Point, Point]


class OfPartition(SnapRequest):
    """A wall that stands free."""

    partition: Whole


class MovePartition(OfPartition):
    """A wall that stands free, and its new ends."""

    line: tuple[Point, Point]


class SetHeight(SnapRequest):
    """How high the room is, metres."""

    height: Number = Field(gt=0)


class Operation(NamedTuple):
    """Something that changes a plan.

    Attributes:
        model: What comes with it.
        run: Makes the changed plan.
    """

    model: type[SnapRequest]
    run: Callable[[Drawing, Any], Drawing]


def _move_wall(plan: Drawing, given: MoveWall) -> Drawing:
    start, end = plan.ends(given.wall)
    along = (end - start) / max(float(((end - start) ** 2).sum() ** 0.5), 1e-9)
    outward = float(given.by[0] * along[1] - given.by[1] * along[0])
    by = -outward if plan.clockwise else outward
    return corners.move_wall(plan, given.wall, by, snap=given.snap)


def _add_opening(plan: Drawing, given: AddOpening) -> Drawing:
    left, right, bottom, top = given.rectangle
    return fittings.add_opening(
        plan,
        Hole(left, right, bottom, top),
        wall=given.wall,
        partition=given.partition,
        kind=given.kind,
        snap=given.snap,
    )


def _set_opening(plan: Drawing, given: SetOpening) -> Drawing:
    hole = None
    if given.rectangle is not None:
        left, right, bottom, top = given.rectangle
        hole = Hole(left, right, bottom, top)
    return fittings.set_opening(plan, given.opening, hole=hole, kind=given.kind, snap=given.snap)


def _move_partition(plan: Drawing, given: MovePartition) -> Drawing:
    return fittings.move_partition(plan, given.partition, given.line)


OPERATIONS: Final[Mapping[str, Operation]] = {
    "move_corner": Operation(
        MoveCorner, lambda plan, on: corners.move_corner(plan, on.corner, on.to, snap=on.snap)
    ),
    "remove_corner": Operation(
        CornerRequest, lambda plan, on: corners.remove_corner(plan, on.corner)
    ),
    "move_wall": Operation(MoveWall, _move_wall),
    "split_wall": Operation(SplitWall, lambda plan, on: corners.split_wall(plan, on.wall, on.at)),
    "remove_wall": Operation(WallRequest, lambda plan, on: corners.remove_wall(plan, on.wall)),
    "square": Operation(SnapRequest, lambda plan, _: corners.square(plan)),
    "add_opening": Operation(AddOpening, _add_opening),
    "set_opening": Operation(SetOpening, _set_opening),
    "remove_opening": Operation(
        OfOpening, lambda plan, on: fittings.remove_opening(plan, on.opening)
    ),
    "add_partition": Operation(
        AddPartition, lambda plan, on: fittings.add_partition(plan, on.line)
    ),
    "move_partition": Operation(MovePartition, _move_partition),
    "remove_partition": Operation(
        OfPartition, lambda plan, on: fittings.remove_partition(plan, on.partition)
    ),
    "set_height": Operation(SetHeight, lambda plan, on: fittings.set_height(plan, on.height)),
}
"""By the names that a page uses."""
