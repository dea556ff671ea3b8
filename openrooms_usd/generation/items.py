"""What the generator arranges: items, and groups of them that belong together."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Literal

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture import NOTHING_ORDERED, FitOptions, Size
from openrooms_usd.generation.boxes import NONE, Pose, box

# People walk and stand between these heights: neither a rug nor a high shelf is an obstacle;
# metres.
STEP_M: Final = 0.06
HEADROOM_M: Final = 1.9

Anchor = Literal["wall", "free"]


@dataclass(frozen=True)
class Item:
    """One object in the frame of its group.

    Attributes:
        key: Names it within the group.
        category: Of the library.
        size: Width, depth, height; metres.
        style: Of the category.
        x: Middle of its base, metres.
        y: Middle of its base, metres.
        z: Height of its base above the floor, metres.
        yaw: Degrees.
        on: What carries it: ``floor``, ``ceiling``, ``wall`` or the key of another item.
        optional: Whether the group makes sense without it.
        order: What is ordered with it.
        sunk: Whether it is let into what carries it, or lies on more than that: its height is said,
            and follows from no top.
        tilt: Degrees that it leans forward, and then to its right, before it is turned by yaw.
        lies: Whether its height is its own, not that of the top below its middle.
    """

    key: str
    category: str
    size: Size
    style: str
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    yaw: float = 0.0
    on: str = "floor"
    optional: bool = False
    order: FitOptions = NOTHING_ORDERED
    sunk: bool = False
    tilt: tuple[float, float] = (0.0, 0.0)
    lies: bool = False

    @property
    def box(self) -> Array:
        """(8,) its bounding box in the group's frame."""
        width, depth, height = self.size
        return box(self.x, self.y, width, depth, self.z, self.z + height, self.yaw)

    def at(self, x: float, y: float) -> tuple[float, float]:
        """A place given in the item's own frame, in the frame of the group; metres."""
        return placed((self.x, self.y, self.yaw), x, y)

    def posed(self, pose: Pose) -> "Item":
        """The item of a group that stands at a pose, in the room's frame."""
        x, y = placed(pose, self.x, self.y)
        return replace(self, x=x, y=y, yaw=wrapped(self.yaw + pose[2]))


def placed(pose: Pose, x: float, y: float) -> tuple[float, float]:
    """A place given in the frame of what stands at a pose, in the frame of that pose; metres."""
    c, s = np.cos(np.radians(pose[2])), np.sin(np.radians(pose[2]))
    return pose[0] + float(c * x - s * y), pose[1] + float(s * x + c * y)


def wrapped(degrees: float) -> float:
    """An angle in (-180, 180]."""
    return -((180.0 - degrees) % 360.0 - 180.0)


@dataclass(frozen=True)
class Group:
    """Items that are used together, in a frame of their own: front towards -Y, back at +Y.

    Attributes:
        title: What it is for; becomes a comment.
        items: An item follows what carries it; the first is the one that the group is about.
        zones: (Z, 8) floor that people need, clear of all other furniture.
        access: Places where a person must be able to stand, metres.
        anchor: ``wall``: its back stands against a wall; ``free``: it stands in the room.
        back: How far its back is behind its origin, metres.
        gap: Between its back and the wall, metres.
        beside: What is left at least between its ends and the walls beside it, metres.
        corner: Its end that stands in a corner of the room, where its items go on along the wall
            beside it; seen from before it.
        window_at: X of what people like to have below a window, metres.
    """

    title: str
    items: tuple[Item, ...]
    zones: Array = field(default_factory=lambda: NONE)
    access: tuple[tuple[float, float], ...] = ()
    anchor: Anchor = "wall"
    back: float = 0.0
    gap: float = 0.015
    beside: float = 0.03
    corner: Literal["", "left", "right"] = ""
    window_at: float | None = None

    @property
    def boxes(self) -> Array:
        """(N, 8) of all items."""
        return np.array([item.box for item in self.items])

    @property
    def required(self) -> Array:
        """(N,) which items the group needs."""
        return np.array([not item.optional for item in self.items])


def zone(x: float, y: float, width: float, depth: float) -> Array:
    """(8,) floor that people need to stand or walk on."""
    return box(x, y, width, depth, STEP_M, HEADROOM_M)


def front_zone(item: Item, depth: float, beside: float = 0.0) -> Array:
    """(8,) the floor before an item."""
    x, y = item.at(0.0, -0.5 * item.size[1] - 0.5 * depth)
    return box(x, y, item.size[0] + 2 * beside, depth, STEP_M, HEADROOM_M, item.yaw)


def zones(rows: Iterable[Array]) -> Array:
    """(Z, 8) several."""
    found = list(rows)
    return np.array(found) if found else NONE


def with_dependants(kept: Sequence[bool], items: Sequence[Item]) -> list[bool]:
    """Drop what stands on something that is dropped."""
    standing: dict[str, bool] = {"floor": True, "ceiling": True, "wall": True}
    for keep, item in zip(kept, items, strict=True):
        standing[item.key] = keep and standing[item.on]
    return [standing[item.key] for item in items]
