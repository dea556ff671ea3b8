"""Which of a scene's things stand so near that they are meshes, and which are left to the panorama.

In a look through a window from a step to the side, what is near has to move against what is far.
Nothing is shown twice: the panorama is drawn of what is left. The frame is that of the scene.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from openrooms_usd.library.outside.houses import House
from openrooms_usd.library.outside.land import Zone
from openrooms_usd.library.outside.noise import Floats
from openrooms_usd.library.outside.plants import Hedge, Plant
from openrooms_usd.library.outside.scenes import Scene

# What is nearer is a mesh: plants and houses; hedges and land end where most of them would be seen
# to end. Metres.
_NEAR_M: Final = 15.0
REACH_M: Final = 21.0
# Between plants and the walls of the room, beyond half of their crowns; metres.
_CLEAR_M: Final = 1.5
# A plant whose top is so far below the eye is seen from few places.
_BELOW_M: Final = 1.5
_MOST_PLANTS: Final = 18


@dataclass(frozen=True, eq=False)
class Near:
    """What is near.

    Attributes:
        plants: Trees and bushes.
        hedges: Pieces of hedges.
        houses: Houses.
        zones: The land, as rectangles that end at `REACH_M`; none under upper storeys, from which
            it is seen far away alone.
        own: Height of the room's own house, metres.
    """

    plants: tuple[Plant, ...] = ()
    hedges: tuple[Hedge, ...] = ()
    houses: tuple[House, ...] = ()
    zones: tuple[Zone, ...] = ()
    own: float = 0.0


def parted(scene: Scene, eye: float, outline: Floats) -> tuple[Near, Scene]:
    """The near things of a scene, and the scene without them.

    Args:
        scene: All that stands there.
        eye: Its height above the land, metres.
        outline: (N, 2) the room in plan. What would stand in it or at its walls is left out.
    """
    import shapely

    room = shapely.Polygon(outline)
    level = eye < 1.0 + 2.0
    far: list[House | Plant | Hedge] = []
    plants: list[Plant] = []
    hedges: list[Hedge] = []
    houses: list[House] = []
    for thing in sorted(scene.things, key=lambda thing: thing.distance):
        if isinstance(thing, House):
            box = shapely.Polygon(thing.plan())
            if box.distance(room) < _CLEAR_M:
                continue
            (houses if box.distance(shapely.Point(0.0, 0.0)) < _NEAR_M else far).append(thing)
        elif isinstance(thing, Hedge):
            if not level:
                far.append(thing)
                continue
            inside, outside = _cut(thing)
            hedges += [
                piece
                for piece in inside
                if shapely.LineString([piece.start, piece.end]).distance(room) > _CLEAR_M
            ]
            far += outside
        else:
            half = 0.5 * thing.height * thing.sprite.aspect
            if shapely.Point(thing.x, thing.y).distance(room) < half + _CLEAR_M:
                continue
            seen = thing.distance < _NEAR_M and (level or thing.height > eye - _BELOW_M)
            (plants if seen and len(plants) < _MOST_PLANTS else far).append(thing)
    zones = tuple(_clipped(scene.zones)) if level else ()
    near = Near(tuple(plants), tuple(hedges), tuple(houses), zones, scene.own)
    return near, replace(scene, things=tuple(far))


def _cut(hedge: Hedge) -> tuple[list[Hedge], list[Hedge]]:
    """The pieces of a hedge within and beyond a circle."""
    a, b = np.array(hedge.start), np.array(hedge.end)
    length = float(np.linalg.norm(b - a))
    along = (b - a) / length
    foot = -float(a @ along)
    off = float(np.linalg.norm(a + foot * along))
    if off >= REACH_M:
        return [], [hedge]
    half = math.sqrt(REACH_M**2 - off**2)
    low, high = max(0.0, foot - half), min(length, foot + half)
    if low >= high:
        return [], [hedge]

    def piece(start: float, end: float) -> list[Hedge]:
        if end - start < 0.3:
            return []
        ends = [tuple((a + t * along).tolist()) for t in (start, end)]
        return [replace(hedge, start=ends[0], end=ends[1])]

    return piece(low, high), [*piece(0.0, low), *piece(high, length)]


def _clipped(zones: tuple[Zone, ...]) -> Iterator[Zone]:
    """The parts of the land that are within reach."""
    for zone in zones:
        x, y = ((max(ends[0], -REACH_M), min(ends[1], REACH_M)) for ends in (zone.x, zone.y))
        if x[0] < x[1] and y[0] < y[1]:
            yield replace(zone, x=x, y=y)
