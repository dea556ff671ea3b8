"""Where objects stand: their heights follow from what carries them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from openrooms_usd import names
from openrooms_usd.capture import Confidence
from openrooms_usd.errors import InputError, StageError
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.library.assets import Asset, Model
from openrooms_usd.library.furniture import Size

Array: TypeAlias = NDArray[np.float64]

FLOOR: Final = "floor"
CEILING: Final = "ceiling"
# The highest top at the place of all that stands on the floor.
SURFACE: Final = "surface"


@dataclass(frozen=True)
class Source:
    """Where an object was captured.

    Attributes:
        file: The name of the captured file, without its folder.
        id: Its identifier there.
        confidence: How sure the source is.
    """

    file: str
    id: str
    confidence: Confidence | None = None


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
        on: `FLOOR`, `CEILING`, `SURFACE` or the name of another object.
        emits: Whether it is a lamp.
        source: Where it was captured, when it was.
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
    source: Source | None = None

    def to_local(self, x: float, y: float) -> tuple[float, float]:
        """A place of the room in the object's own frame, metres."""
        c, s = np.cos(np.radians(self.yaw)), np.sin(np.radians(self.yaw))
        dx, dy = x - self.x, y - self.y
        return float(c * dx + s * dy), float(c * dy - s * dx)


@dataclass
class Supports:
    """Finds the height of every object's base.

    Attributes:
        placements: All objects by name.
        floor: Height of the floor, metres.
        ceiling: Height of the ceiling, metres; None in a room without one.
        notes: Receives a sentence for what had to be guessed.
    """

    placements: Mapping[str, Placement]
    floor: float
    ceiling: float | None
    notes: list[str]
    _heights: dict[str, float] = field(default_factory=dict)
    _pending: list[str] = field(default_factory=list)

    def height(self, name: str) -> float:
        """Height of an object's base, metres.

        Raises:
            InputError: Its support does not exist, or it stands on itself by way of others.
            StageError: It hangs from a ceiling that is not there.
        """
        if name not in self._heights:
            if name in self._pending:
                circle = " on ".join([*self._pending[self._pending.index(name) :], name])
                raise InputError(
                    f"objects carry each other in a circle: {circle}",
                    place="alignment.objects",
                    remedy="let one of them stand on the floor",
                )
            self._pending.append(name)
            self._heights[name] = self._resolve(self.placements[name])
            self._pending.pop()
        return self._heights[name]

    def _resolve(self, item: Placement) -> float:
        if item.z is not None:
            return item.z
        if item.on == FLOOR:
            return self.floor
        if item.on == CEILING:
            return self._ceiling() - item.size[2]
        if item.on == SURFACE:
            return self._surface(item)
        if item.on not in self.placements:
            raise InputError(
                f"{item.name} stands on {item.on!r}, which is no object",
                place="alignment.objects",
                remedy=f"choose floor, ceiling or one of: {', '.join(sorted(self.placements)[:9])}",
            )
        return self._top(self.placements[item.on], item)

    def _ceiling(self) -> float:
        if self.ceiling is None:
            raise StageError(
                "the room has no ceiling to hang something from",
                place=names.CEILING,
                remedy="compose the layout first, or give the lamps a z",
            )
        return self.ceiling

    def _surface(self, item: Placement) -> float:
        """The highest top below the item's middle of what stands on the floor, else the floor."""
        centers, turns, halves, standing = self._outlines
        offset = np.array([item.x, item.y]) - centers
        local = np.abs(np.einsum("nij,nj->ni", turns, offset))
        inside = np.flatnonzero((local <= halves).all(axis=1))
        below = (standing[i] for i in inside.tolist())
        tops = (top_at(other.asset.build(), *other.to_local(item.x, item.y)) for other in below)
        return self.floor + max((top for top in tops if top is not None), default=0.0)

    @cached_property
    def _outlines(self) -> tuple[Array, Array, Array, Sequence[Placement]]:
        """Middle, turn into the own frame and half size of all that stands on the floor."""
        everything = self.placements.values()
        standing = [item for item in everything if item.on == FLOOR and item.z is None]
        yaw = np.radians([item.yaw for item in standing])
        c, s = np.cos(yaw), np.sin(yaw)
        turns = np.stack([np.stack([c, s], axis=-1), np.stack([-s, c], axis=-1)], axis=1)
        centers = np.array([(item.x, item.y) for item in standing]).reshape(-1, 2)
        halves = 0.5 * np.array([item.size[:2] for item in standing]).reshape(-1, 2)
        return centers, turns.reshape(-1, 2, 2), halves, standing

    def _top(self, support: Placement, item: Placement) -> float:
        """Height of the support's upper side at the item's place."""
        x, y = support.to_local(item.x, item.y)
        base = self.height(support.name)
        top = top_at(support.asset.build(), x, y)
        if top is None:
            self.notes.append(
                f"{item.name} stands beside {support.name} that shall carry it: it is placed at "
                "the height of its top"
            )
            top = support.size[2]
        return base + top


def top_at(model: Model, x: float, y: float) -> float | None:
    """Where a vertical line through (x, y) meets a model last, metres; None where it misses."""
    heights = [_top_of(mesh, x, y) for mesh in model.parts.values()]
    found = [height for height in heights if height is not None]
    return max(found, default=None)


def _top_of(mesh: Mesh, x: float, y: float) -> float | None:
    corners, _ = mesh.triangles()
    a, b, c = np.moveaxis(mesh.points[mesh.indices[corners]], 1, 0)
    area = _cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        v = _cross(np.array([x, y]) - a[:, :2], c - a) / area
        w = _cross(b - a, np.array([x, y]) - a[:, :2]) / area
        # A line through an edge must not slip between its two faces.
        hit = (area != 0.0) & (v >= -1e-9) & (w >= -1e-9) & (v + w <= 1.0 + 1e-9)
    if not hit.any():
        return None
    z = a[hit, 2] + v[hit] * (b - a)[hit, 2] + w[hit] * (c - a)[hit, 2]
    return float(z.max())


def _cross(a: Array, b: Array) -> Array:
    """Cross product of the horizontal parts."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
