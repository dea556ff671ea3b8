"""Things dropped into bowls and bins: each comes to rest at the lowest place that is left."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.furniture import offered_surfaces
from openrooms_usd.furniture.placements import Place
from openrooms_usd.generation.boxes import Pose
from openrooms_usd.generation.clutter.forms import LevelFinder
from openrooms_usd.generation.clutter.laying import PosedObject, posed_object
from openrooms_usd.generation.clutter.resting import Relief, rest_on
from openrooms_usd.generation.clutter.scatter import Scatter
from openrooms_usd.generation.items import Item, placed, wrapped
from openrooms_usd.generation.shapes import BuiltForm
from openrooms_usd.geometry.rotations import about_z

INTO: Final[tuple[Place, ...]] = ("in_bowl", "in_bin")
# Where things are dropped, as a share of half the vessel's size, and how many places are tried.
_REACH_SHARE: Final = 0.6
_PLACES, _LOOKED_AT = 48, 10
# A vessel's middle is at least so far below its rim, as a share of its height: else it has a lid.
_HOLLOW_SHARE: Final = 0.3
# Others may lift a thing by so much, metres: else it lies on them, not in the vessel.
_LIFTED_M: Final = 0.002
# Of the lowest points of a thing none is farther than this above the vessel, metres.
_LOWEST_M, _MAX_GAP_M = 0.005, 0.012
# Of a thing so much is at least below the rim, as a share of its height.
_WITHIN_SHARE: Final = 0.4


Held = tuple[str, PosedObject, Pose, float]


@dataclass(eq=False)
class Vessel:
    """Something that things are dropped into.

    Attributes:
        place: ``in_bowl`` or ``in_bin``.
        carrier: The vessel.
        group: The index of its group.
        shape: Its form.
        relief: Its upper side.
        held: What lies in it: keys, things, and their poses and heights in its frame.
    """

    place: Place
    carrier: Item
    group: int
    shape: BuiltForm
    relief: Relief
    held: list[Held] = field(default_factory=list)

    @property
    def area(self) -> float:
        """Of its opening, square metres."""
        return self.carrier.size[0] * self.carrier.size[1]


def vessels(items: Sequence[tuple[int, Item]], surfaces: LevelFinder) -> Iterator[Vessel]:
    """Those of some items, with their groups, that are open above and hold nothing."""
    full = {item.on for _, item in items}
    for group, item in items:
        offered = offered_surfaces(item.category)
        for place in (place for place in offered if place in INTO and item.key not in full):
            relief = surfaces.relief(item)
            middle = float(relief.at(np.zeros(1), np.zeros(1))[0])
            if -np.inf < middle < (1.0 - _HOLLOW_SHARE) * item.size[2]:
                shape = surfaces.shape(item)
                yield Vessel(place, item, group, shape, relief)


def fill_vessel(scatter: Scatter, number: int, vessel: Vessel, level: int) -> None:
    """Drop into a bowl or a bin what a level adds.

    Args:
        scatter: Lays things in this room.
        number: The vessel's, the same at all levels.
        vessel: The vessel.
        level: 1, 2 or 3.
    """
    width, depth, height = vessel.carrier.size
    for _ in range(scatter.count(vessel.place, vessel.area, level)):
        drawn = scatter.drawn(number, vessel.place, level)
        make = scatter.variants.draw(*drawn, (0.8 * width, 0.8 * depth, height)) if drawn else None
        if drawn is None or make is None:
            continue
        thing = posed_object(scatter.surfaces, drawn[0], make)
        item = settle(vessel, thing, scatter.key(drawn[0]), scatter.rng)
        if item is None:
            continue
        box = thing.standing((item.x, item.y, item.yaw), item.z)
        inside = {vessel.carrier.key, *(key for key, _, _, _ in vessel.held)}
        if len(scatter.taken.near(box, inside)):
            vessel.held.pop()
            continue
        scatter.note(number, *drawn)
        scatter.add(vessel.group, item, box)


def settle(vessel: Vessel, thing: PosedObject, key: str, rng: np.random.Generator) -> Item | None:
    """A thing at the lowest place in a vessel that others leave; None without one.

    Args:
        vessel: The vessel; takes the thing in.
        thing: The thing, as built.
        key: Its key.
        rng: Draws places and turns.
    """
    width, depth, height = vessel.carrier.size
    half = 0.5 * _REACH_SHARE * np.array([width, depth])
    places = rng.uniform(-half, half, (_PLACES, 2))
    yaw = float(rng.uniform(-180.0, 180.0))
    points = thing.skin @ about_z(np.radians(yaw)).T
    coarse = vessel.relief.rest(points, places[:, 0], places[:, 1])
    for at in np.argsort(coarse, kind="stable")[:_LOOKED_AT]:
        pose = (*places[at].tolist(), yaw)
        z = rest_on(vessel.shape.corners, thing.above(pose))
        if z + _WITHIN_SHARE * thing.size[2] > height or not _stands(vessel, points, pose, z):
            continue
        if all(_clear(thing, pose, z, other) for other in vessel.held):
            vessel.held.append((key, thing, pose, z))
            return _item(vessel.carrier, thing, key, pose, z)
    return None


def _stands(vessel: Vessel, points: Array, pose: Pose, z: float) -> bool:
    base = points[points[:, 2] < points[:, 2].min() + _LOWEST_M]
    below = vessel.shape.tops(pose[0] + base[:, 0], pose[1] + base[:, 1])
    return bool(np.isfinite(z) and (base[:, 2] + z - below).max() < _MAX_GAP_M)


def _clear(thing: PosedObject, pose: Pose, z: float, other: Held) -> bool:
    """Whether what lies there already would not lift a thing."""
    _, below, at, low = other
    back = (0.0, 0.0, -at[2])
    x, y = placed(back, pose[0] - at[0], pose[1] - at[1])
    lifted = rest_on(below.corners, thing.above((x, y, pose[2] - at[2])))
    return low + lifted < z + _LIFTED_M


def _item(carrier: Item, thing: PosedObject, key: str, pose: Pose, z: float) -> Item:
    x, y = carrier.at(pose[0], pose[1])
    size, style = thing.make
    return Item(
        key, thing.name, size, style, round(x, 4), round(y, 4), round(carrier.z + z, 4),
        round(wrapped(carrier.yaw + pose[2]), 2), carrier.key, True, lies=True,
    )  # fmt: skip
