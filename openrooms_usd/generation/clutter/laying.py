"""Laying things down: what they take up in each pose, what is taken already, and where they fit."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.generation.boxes import NONE, Pose, box, overlap, posed
from openrooms_usd.generation.clutter.forms import LevelFinder
from openrooms_usd.generation.clutter.levels import CELL_M
from openrooms_usd.generation.clutter.making import Variant
from openrooms_usd.generation.clutter.resting import skin_of
from openrooms_usd.generation.clutter.spots import SupportSurface
from openrooms_usd.generation.items import Item, placed, wrapped
from openrooms_usd.generation.shapes import BuiltForm
from openrooms_usd.geometry.rotations import about_z, tilted

# Between things that lie beside each other, metres.
_GAP_M: Final = 0.004
# Between a thing and the edge of what it lies on, metres.
_FROM_EDGE_M: Final = 0.008
# How many places are looked at for one thing.
_PLACES: Final = 48
# Things higher than this stand towards the back, metres.
_TALL_M: Final = 0.18
# Where to a thing goes: how much the nearness of its like, and the back, count per metre.
_TOGETHER, _BACKWARDS = 6.0, 3.0

Tilt = tuple[float, float]


@dataclass(frozen=True, eq=False)
class PosedObject:
    """Something to lay down: a make in a pose.

    Attributes:
        name: Its category.
        make: Its size and style.
        tilt: Degrees forward, then to its right.
        form: How it is built.
        points: (N, 3) its corners when it leans so, the middle of its base in the origin; metres.
        skin: (M, 3) its corners and points between them, likewise.
    """

    name: str
    make: Variant
    tilt: Tilt
    form: BuiltForm = field(repr=False)
    points: Array = field(repr=False)
    skin: Array = field(repr=False)

    @cached_property
    def low(self) -> Array:
        """(3,) its least corner, metres."""
        return np.asarray(self.points.min(axis=0))

    @cached_property
    def high(self) -> Array:
        """(3,) its greatest corner, metres."""
        return np.asarray(self.points.max(axis=0))

    @cached_property
    def corners(self) -> Array:
        """(T, 3, 3) of its triangles, leant likewise, metres."""
        return np.asarray(self.form.corners @ tilted(*self.tilt).T)

    def above(self, pose: Pose) -> Array:
        """(T, 3, 3) likewise, at a place and turned there."""
        x, y, yaw = pose
        return np.asarray(self.corners @ about_z(np.radians(yaw)).T + np.array([x, y, 0.0]))

    def turned(self, tilt: Tilt) -> "PosedObject":
        """The same in another pose."""
        return _posed_object(self.name, self.make, tilt, self.form)

    @property
    def size(self) -> tuple[float, float, float]:
        """Width, depth and height that it takes up, metres."""
        width, depth, height = (self.high - self.low).tolist()
        return width, depth, height

    @property
    def row(self) -> Array:
        """(1, 8) the box around it."""
        x, y, _ = (0.5 * (self.low + self.high)).tolist()
        width, depth, _ = self.size
        return box(x, y, width, depth, float(self.low[2]), float(self.high[2]))[None]

    def standing(self, pose: Pose, z: float) -> Array:
        """(1, 8) the box around it where it lies, its lowest point at a height."""
        found: Array = posed(self.row, [pose])[0]
        found[:, 6:] += z - self.low[2]
        return found


def posed_object(
    surfaces: LevelFinder, name: str, make: Variant, tilt: Tilt = (0.0, 0.0)
) -> PosedObject:
    """A make in a pose."""
    return _posed_object(name, make, tilt, surfaces.shapes.of(name, *make))


def _posed_object(name: str, make: Variant, tilt: Tilt, shape: BuiltForm) -> PosedObject:
    points = np.concatenate([mesh.points for mesh in shape.meshes])
    turn = tilted(*tilt).T if any(tilt) else np.eye(3)
    return PosedObject(name, make, tilt, shape, points @ turn, skin_of(shape) @ turn)


@dataclass
class Taken:
    """What takes up space in a room.

    Attributes:
        boxes: (N, 8).
        owners: The keys of the items that they belong to.
    """

    boxes: Array = field(default_factory=lambda: NONE)
    owners: list[str] = field(default_factory=list)

    def add(self, boxes: Array, owner: str) -> None:
        """Take up more."""
        self.boxes = np.concatenate([self.boxes, boxes])
        self.owners += [owner] * len(boxes)

    def near(self, area: Array, but: Collection[str]) -> Array:
        """(K, 8) what comes into a box, but the parts of some items, which carry things there."""
        found = np.flatnonzero(overlap(area, self.boxes, 2 * _GAP_M)).tolist()
        return self.boxes[[i for i in found if self.owners[i] not in but]]


def taken_by(items: Sequence[Item], surfaces: LevelFinder) -> Taken:
    """What furniture takes up, part by part."""
    taken = Taken()
    for item in items:
        boxes: Array = posed(surfaces.shape(item).slices, (item.x, item.y, item.yaw))[0]
        boxes[:, 6:] += item.z
        taken.add(boxes, item.key)
    return taken


def places_on(
    spot: SupportSurface,
    size: tuple[float, float, float],
    yaws: Array,
    taken: Array,
    mates: Array,
    rng: np.random.Generator,
) -> Pose | None:
    """A free place on a surface for a box, in the room's frame.

    Args:
        spot: The surface.
        size: Of the box, metres.
        yaws: (N,) some turns to choose from, in the carrier's frame, degrees.
        taken: (K, 8) what is there.
        mates: (M, 2) what it shall lie beside, in the carrier's frame.
        rng: Draws the candidates.

    Returns:
        Middle and yaw of the box; None without one.
    """
    level = spot.level
    rows, columns = np.nonzero(level.clear >= size[2])
    if not len(rows):
        return None
    drawn = rng.integers(0, len(rows), _PLACES)
    jitter = rng.uniform(0.0, 1.0, (_PLACES, 2))
    local = level.origin + CELL_M * (np.stack([columns[drawn], rows[drawn]], axis=1) + jitter)
    turns = yaws[rng.integers(0, len(yaws), _PLACES)]
    good = fits(spot, size, local, turns)
    local, turns = local[good], turns[good]
    if not len(local):
        return None
    poses = _poses_in_room(spot.pose, local, turns)
    if len(taken):
        row = box(0.0, 0.0, size[0], size[1], spot.z + 0.001, spot.z + size[2])[None]
        clash = overlap(posed(row, poses)[:, 0], taken, _GAP_M).any(axis=1)
        poses, local = poses[~clash], local[~clash]
        if not len(poses):
            return None
    taste = rng.uniform(0.0, 1.0, len(poses))
    if len(mates):
        away = np.linalg.norm(local[:, None] - mates, axis=2).min(axis=1)
        taste -= _TOGETHER * away
    elif size[2] > _TALL_M and not spot.around:
        taste += _BACKWARDS * local[:, 1]
    x, y, yaw = poses[int(np.argmax(taste))].tolist()
    return x, y, yaw


def fits(
    spot: SupportSurface, size: tuple[float, float, float], local: Array, turns: Array
) -> Mask:
    """(N,) whether a box stands on free cells wholly."""
    half = 0.5 * np.array(size[:2]) + _FROM_EDGE_M
    ticks = [np.linspace(-h, h, max(3, int(np.ceil(2 * h / CELL_M)) + 1)) for h in half]
    u, v = (side.ravel() for side in np.meshgrid(*ticks))
    c, s = np.cos(np.radians(turns))[:, None], np.sin(np.radians(turns))[:, None]
    x = local[:, :1] + c * u - s * v
    y = local[:, 1:] + s * u + c * v
    return np.asarray((spot.level.within(x, y) >= size[2] + _GAP_M).all(axis=1), dtype=np.bool_)


def _poses_in_room(pose: Pose, local: Array, turns: Array) -> Array:
    """(N, 3) places and turns of a frame in the room."""
    c, s = np.cos(np.radians(pose[2])), np.sin(np.radians(pose[2]))
    x = pose[0] + c * local[:, 0] - s * local[:, 1]
    y = pose[1] + s * local[:, 0] + c * local[:, 1]
    return np.column_stack([x, y, pose[2] + turns])


def item_at(thing: PosedObject, key: str, middle: Pose, z: float, on: str) -> Item:
    """An item whose box has its middle at a place, and its lowest point at a height."""
    offset = -0.5 * (thing.low + thing.high)
    x, y = placed(middle, float(offset[0]), float(offset[1]))
    size, style = thing.make
    return Item(
        key, thing.name, size, style, round(x, 4), round(y, 4),
        round(z - float(thing.low[2]), 4), round(wrapped(middle[2]), 2), on, True,
        tilt=thing.tilt, lies=True,
    )  # fmt: skip
