"""Poses of objects as they are described: in the plan, and on their supports."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Final, TypeAlias

import numpy as np

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.capture import Confidence
from openrooms_usd.description.mistakes import FieldsError
from openrooms_usd.errors import StageError
from openrooms_usd.furniture import Size
from openrooms_usd.geometry.rotations import in_plan, tilted
from openrooms_usd.library.assets import Asset, Model
from openrooms_usd.spelling import did_you_mean
from openrooms_usd.steps.alignment.surroundings import RoomGeometry

_OBJECTS: Final = ("furniture", "objects")

Tilt: TypeAlias = tuple[float, float]

FLOOR: Final = "floor"
CEILING: Final = "ceiling"
# Support on the highest top at a place, of all objects on the floor.
SURFACE: Final = "surface"
WALL: Final = "wall"
# Headings that are apart by less are the same, degrees.
_TURNED_DEG: Final = 1.0
# Categories that hang in front of openings on purpose.
_COVERS: Final = ("curtain",)


def top_at(model: Model, x: float, y: float) -> float | None:
    """The highest intersection of a vertical line with a model, metres; None where it misses."""
    a, b, c = _skin(_Same(model))
    area = _cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        v = _cross(np.array([x, y]) - a[:, :2], c - a) / area
        w = _cross(b - a, np.array([x, y]) - a[:, :2]) / area
        # A line through an edge must not miss both its faces.
        hit = (area != 0.0) & (v >= -1e-9) & (w >= -1e-9) & (v + w <= 1.0 + 1e-9)
    if not hit.any():
        return None
    z = a[hit, 2] + v[hit] * (b - a)[hit, 2] + w[hit] * (c - a)[hit, 2]
    return float(z.max())


class _Same:
    """A model compared by identity: comparing its arrays would be slow."""

    def __init__(self, model: Model) -> None:
        self.model = model

    def __hash__(self) -> int:
        return id(self.model)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and other.model is self.model


# A room queries the same few models again and again; the bound limits memory.
@lru_cache(maxsize=32)
def _skin(same: _Same) -> tuple[Array, Array, Array]:
    """(T, 3) first, second and third corners of all triangles of a model, metres."""
    corners = [mesh.points[mesh.indices[mesh.triangles()[0]]] for mesh in same.model.parts.values()]
    a, b, c = np.moveaxis(np.concatenate([np.zeros((0, 3, 3)), *corners]), 1, 0)
    return a, b, c


def _cross(a: Array, b: Array) -> Array:
    """Cross product of the horizontal parts."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


@dataclass(frozen=True)
class CaptureSource:
    """Where an object was captured.

    Attributes:
        file: The name of the captured file, without its folder.
        id: Its identifier there.
        confidence: How sure the source is.
        word: The source's own word for it; empty where that is not known.
    """

    file: str
    id: str
    confidence: Confidence | None = None
    word: str = ""


@dataclass(frozen=True, eq=False)
class Measured:
    """How an object was found in a scan, before it was put where it can be.

    Attributes:
        pose: (4, 4) from the asset's frame to the room, with a scale along each of its axes.
        residual: Root of the mean squared distance of its points to it, metres.
        coverage: The part of its visible surface that points lie on, from 0 to 1.
        symmetry: ``none``, ``2``, ``4`` or ``inf``, about its vertical.
        support: ``floor``, ``wall``, ``ceiling``, ``object`` or ``nothing``.
        carrier: The name of the object that it stands on; None if it stands on something else.
    """

    pose: Array
    residual: float
    coverage: float
    symmetry: str
    support: str
    carrier: str | None = None


@dataclass(frozen=True)
class Placement:
    """An object to be placed.

    Attributes:
        name: Its prim name.
        asset: What is placed.
        size: Width, depth and height of its bounding box, metres.
        x: Middle of its base, metres.
        y: Middle of its base, metres.
        z: Its base, metres; None when it follows from the support.
        yaw: Degrees, counter-clockwise from above.
        on: `FLOOR`, `CEILING`, `SURFACE`, `WALL` or the name of another object.
        emits: Whether it is a lamp.
        source: Where it was captured, when it was.
        relative_to: The object in whose frame x, y and yaw are given.
        level: Height of its base above the floor where it hangs on a wall, metres.
        tilt: Degrees about its own x axis, then about its own y axis, before it is turned by yaw.
        pose: (4, 4) from the asset's frame to the room where that is more than upright: with a
            tilt, and a scale along each axis of the asset.
        shifts: (3,) each, metres: how the source moved it, after it had measured its pose.
        measured: How it was found in a scan; None where it was not found in one.
    """

    name: str
    asset: Asset
    size: Size
    x: float
    y: float
    z: float | None = None
    yaw: float = 0.0
    on: str = FLOOR
    emits: bool = False
    source: CaptureSource | None = None
    relative_to: str | None = None
    level: float = 0.0
    tilt: Tilt = (0.0, 0.0)
    pose: Array | None = field(default=None, compare=False)
    shifts: tuple[Array, ...] = field(default=(), compare=False)
    measured: Measured | None = field(default=None, compare=False)

    @property
    def carrier(self) -> str | None:
        """The object that it is described to stand on; None where that is a part of the room."""
        return None if self.on in (FLOOR, CEILING, SURFACE, WALL) else self.on

    def top(self, x: float, y: float) -> float | None:
        """Height of its upper side above its base at a place of the room; None beside it."""
        model = self.asset.build()
        if self.pose is None and any(self.tilt):
            turn = tilted(*self.tilt)
            parts = {name: mesh.transformed(turn) for name, mesh in model.parts.items()}
            return top_at(replace(model, parts=parts), *self.to_local(x, y))
        if self.pose is None:
            return top_at(model, *self.to_local(x, y))
        parts = {name: mesh.transformed(self.pose[:3, :3]) for name, mesh in model.parts.items()}
        return top_at(replace(model, parts=parts), x - self.x, y - self.y)

    @property
    def lift(self) -> float:
        """How far its lowest point is below the middle of its base, metres."""
        if not any(self.tilt):
            return 0.0
        turn = tilted(*self.tilt)
        parts = self.asset.build().parts.values()
        return -min(float((mesh.points @ turn[2]).min()) for mesh in parts)

    def to_local(self, x: float, y: float) -> tuple[float, float]:
        """A place of the room in the object's own frame, metres."""
        c, s = np.cos(np.radians(self.yaw)), np.sin(np.radians(self.yaw))
        dx, dy = x - self.x, y - self.y
        return float(c * dx + s * dy), float(c * dy - s * dx)

    def to_room(self, x: float, y: float) -> tuple[float, float]:
        """A place in the object's own frame in the room, metres."""
        c, s = np.cos(np.radians(self.yaw)), np.sin(np.radians(self.yaw))
        return float(self.x + c * x - s * y), float(self.y + s * x + c * y)


@dataclass(frozen=True)
class ResolvedPose:
    """The pose of an object in the room.

    Attributes:
        x: Middle of its base, metres.
        y: Middle of its base, metres.
        z: Its base, metres.
        yaw: Degrees, counter-clockwise from above.
        carrier: The object that carries it; None for the room itself.
        tilt: Degrees about its own x axis, then about its own y axis, before yaw.
    """

    x: float
    y: float
    z: float
    yaw: float
    carrier: str | None = None
    tilt: Tilt = (0.0, 0.0)


@dataclass
class Supports:
    """Resolves the poses of all objects.

    Attributes:
        placements: All objects by name.
        room: What they stand in.
        notes: Receives a sentence for what had to be guessed.
    """

    placements: Mapping[str, Placement]
    room: RoomGeometry
    notes: list[str]
    _stands: dict[str, ResolvedPose] = field(default_factory=dict)

    def resolve(self) -> dict[str, ResolvedPose]:
        """Every object's stand by name, in the order of the objects.

        Raises:
            InputError: An object names another one that does not exist, or they go in a circle.
            StageError: Something hangs from a ceiling or a wall that is not there.
        """
        carriers = {name: item.carrier for name, item in self.placements.items()}
        self._check(carriers, "stands on")
        for name in parents_first(carriers):
            item = self._plan[name]
            z, carrier = self._base(item)
            z += item.lift if item.z is None else 0.0
            self._stands[name] = ResolvedPose(item.x, item.y, z, item.yaw, carrier, item.tilt)
        for item in self._plan.values():
            if item.on == WALL:
                self._note_openings(item)
        return {name: self._stands[name] for name in self.placements}

    def _check(self, others: Mapping[str, str | None], link: str) -> None:
        known = sorted(self.placements)
        wrong = [
            f"{name} {link} {other!r}, which is not an object{did_you_mean(other, known)}; choose "
            "the "
            f"room's own floor, ceiling or wall, or one of: {', '.join(known[:9])}"
            for name, other in others.items()
            if other is not None and other not in self.placements
        ]
        if wrong:
            raise FieldsError(*((_OBJECTS, text) for text in wrong))

    @cached_property
    def _plan(self) -> dict[str, Placement]:
        """All objects with x, y and yaw in the room's own frame."""
        parents = {name: item.relative_to for name, item in self.placements.items()}
        self._check(parents, "is relative to")
        found: dict[str, Placement] = {}
        for name in parents_first(parents):
            item = self.placements[name]
            if item.relative_to is not None:
                frame = found[item.relative_to]
                x, y = frame.to_room(item.x, item.y)
                item = replace(item, x=x, y=y, yaw=item.yaw + frame.yaw)
            found[name] = self._hang_on_wall(item) if item.on == WALL else item
        return {name: found[name] for name in self.placements}

    def _hang_on_wall(self, item: Placement) -> Placement:
        """The object with its back flush to the nearest wall."""
        if not len(self.room.walls):
            raise StageError(
                "the room has no walls to hang something on",
                place=names.ROOM,
                remedy="compose the layout first, or give the object another support",
            )
        width, depth, _ = item.size
        hung = self.room.hang(item.x, item.y, width, depth)
        if width > self.room.length(hung.wall) + 1e-6:
            self.notes.append(
                f"{item.name} is {width:g} m wide, its wall only {self.room.length(hung.wall):g} m"
            )
        own = self.placements[item.name].yaw
        if own and abs((item.yaw - hung.yaw + 180.0) % 360.0 - 180.0) > _TURNED_DEG:
            self.notes.append(
                f"{item.name} hangs with its back to the wall: its yaw of {own:g} has no effect"
            )
        return replace(item, x=hung.x, y=hung.y, yaw=hung.yaw)

    def _note_openings(self, item: Placement) -> None:
        width, depth, height = item.size
        base = self._stands[item.name].z
        hung = self.room.hang(item.x, item.y, width, depth)
        covered = self.room.covered(hung, width, base, base + height)
        if covered and item.asset.category not in _COVERS:
            self.notes.append(f"{item.name} hangs before {', '.join(covered)}")

    def _base(self, item: Placement) -> tuple[float, str | None]:
        """Height of an object's base, and the object that carries it."""
        if item.z is not None:
            return item.z, item.carrier
        if item.carrier is not None:
            below = self._stands[item.carrier].z
            return below + self._top(self._plan[item.carrier], item), item.carrier
        if item.on == SURFACE:
            return self._surface(item)
        if item.on == CEILING:
            return self._ceiling(item) - item.size[2], None
        return self.room.floor + (item.level if item.on == WALL else 0.0), None

    def _ceiling(self, item: Placement) -> float:
        height = self.room.ceiling_over(item.x, item.y)
        if height is None:
            raise StageError(
                "the room has no ceiling to hang something from",
                place=names.CEILING,
                remedy="compose the layout first, or give the lamps a z",
            )
        return height

    def _surface(self, item: Placement) -> tuple[float, str | None]:
        """The highest top below the item's middle of what stands on the floor, else the floor."""
        centers, turns, halves, standing = self._outlines
        offset = np.array([item.x, item.y]) - centers
        local = np.abs(np.einsum("nij,nj->ni", turns, offset))
        inside = np.flatnonzero((local <= halves).all(axis=1))
        tops = [
            (top + (0.0 if other.z is None else other.z - self.room.floor), other.name)
            for other in (standing[i] for i in inside.tolist())
            if (top := other.top(item.x, item.y)) is not None
        ]
        top, carrier = max(tops, default=(0.0, None), key=lambda found: found[0])
        return self.room.floor + top, carrier

    @cached_property
    def _outlines(self) -> tuple[Array, Array, Array, Sequence[Placement]]:
        """Middle, turn into the own frame and half size of all that stands on the floor."""
        everything = self._plan.values()
        standing = [
            item
            for item in everything
            if item.on == FLOOR and (item.z is None or item.pose is not None)
        ]
        turns = in_plan(-np.radians([item.yaw for item in standing]))
        centers = np.array([(item.x, item.y) for item in standing]).reshape(-1, 2)
        halves = 0.5 * np.array([item.size[:2] for item in standing]).reshape(-1, 2)
        return centers, turns.reshape(-1, 2, 2), halves, standing

    def _top(self, support: Placement, item: Placement) -> float:
        """Height of the support's upper side at the item's place, above the support's base."""
        top = support.top(item.x, item.y)
        if top is None:
            self.notes.append(
                f"{item.name} is not above {support.name}, so it floats at the height of its top; "
                "change `at`"
            )
            top = support.size[2]
        return top


def parents_first(parents: Mapping[str, str | None]) -> list[str]:
    """The names in an order in which each comes after its parent.

    Raises:
        FieldsError: Some are their own ancestors.
    """
    order: dict[str, None] = {}
    for start in parents:
        chain: dict[str, None] = {}
        name: str | None = start
        while name is not None and name not in order:
            if name in chain:
                members = [*list(chain)[list(chain).index(name) :], name]
                said = f"objects depend on each other in a circle: {', '.join(members)}"
                remedy = "put one of them on the floor, in the room's frame"
                raise FieldsError((_OBJECTS, f"{said}; {remedy}"))
            chain[name] = None
            name = parents[name]
        order.update(dict.fromkeys(reversed(chain)))
    return list(order)
