"""Which of a scene's things stand so near that they are meshes, and which are left to the panorama.

In a look through a window from a step to the side, what is near has to move against what is far.
Nothing is shown twice: the panorama is drawn of what is left. The frame is that of the scene.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd.library.surroundings.outside.houses import House
from openrooms_usd.library.surroundings.outside.noise import Floats
from openrooms_usd.library.surroundings.outside.plants import Hedge, Plant
from openrooms_usd.library.surroundings.outside.scenes import Scene

# What is nearer is a mesh: plants and houses; pieces of hedges, which go around. Metres.
_NEAR_M: Final = 15.0
_REACH_M: Final = 20.0
_PIECE_M: Final = 4.0
# An eye so high above the land is in an upper storey, from which hedges are seen far below.
_UPSTAIRS_M: Final = 3.0
# Between plants and the walls of the room, beyond half of their crowns; metres.
_CLEAR_M: Final = 1.5
# A plant whose top is so far below the eye is seen from few places.
_BELOW_M: Final = 1.5
_MOST_PLANTS: Final = 8
# From a window's outward way to what is seen through it: the cosine at most.
_LEAST_COS: Final = math.cos(math.radians(70.0))


class Window(NamedTuple):
    """Where a room is looked out of, in plan.

    Attributes:
        x: Its middle.
        y: The same.
        out_x: Unit vector outwards.
        out_y: The same.
    """

    x: float
    y: float
    out_x: float
    out_y: float

    def shows(self, points: Floats) -> bool:
        """Whether any of (N, 2) points stands before it."""
        way = points - np.array([self.x, self.y])
        ahead = way @ np.array([self.out_x, self.out_y])
        return bool((ahead > _LEAST_COS * np.linalg.norm(way, axis=1)).any())


@dataclass(frozen=True, eq=False)
class Near:
    """What is near.

    Attributes:
        plants: Trees and bushes.
        hedges: Pieces of hedges.
        houses: Houses.
    """

    plants: tuple[Plant, ...] = ()
    hedges: tuple[Hedge, ...] = ()
    houses: tuple[House, ...] = ()


def parted(
    scene: Scene, eye: float, outline: Floats, windows: Sequence[Window]
) -> tuple[Near, Scene]:
    """The near things of a scene, and the scene without them.

    Args:
        scene: All that stands there.
        eye: Its height above the land, metres.
        outline: (N, 2) the room in plan. What would stand in it or at its walls is left out.
        windows: Of the room; what stands before none of them is left to the panorama.
    """
    import shapely

    room = shapely.Polygon(outline)
    level = eye < _UPSTAIRS_M
    far: list[House | Plant | Hedge] = []
    plants: list[Plant] = []
    hedges: list[Hedge] = []
    houses: list[House] = []

    def shown(points: Floats) -> bool:
        return any(window.shows(points) for window in windows)

    for thing in sorted(scene.things, key=lambda thing: thing.distance):
        if isinstance(thing, House):
            box = shapely.Polygon(thing.plan())
            if box.distance(room) > _CLEAR_M:
                near = box.distance(shapely.Point(0.0, 0.0)) < _NEAR_M and shown(thing.plan())
                (houses if near else far).append(thing)
        elif isinstance(thing, Hedge):
            for piece in _pieces(thing):
                line = np.array([piece.start, piece.end])
                if shapely.LineString(line).distance(room) > _CLEAR_M:
                    near = level and piece.distance < _REACH_M and shown(line)
                    (hedges if near else far).append(piece)
        else:
            at, half = np.array([[thing.x, thing.y]]), 0.5 * thing.height * thing.sprite.aspect
            if shapely.Point(at[0]).distance(room) > half + _CLEAR_M:
                near = thing.distance < _NEAR_M and (level or thing.height > eye - _BELOW_M)
                near = near and len(plants) < _MOST_PLANTS and shown(at)
                (plants if near else far).append(thing)
    return Near(tuple(plants), tuple(hedges), tuple(houses)), replace(scene, things=tuple(far))


def _pieces(hedge: Hedge) -> Iterator[Hedge]:
    a, b = np.array(hedge.start), np.array(hedge.end)
    count = max(1, round(float(np.linalg.norm(b - a)) / _PIECE_M))
    ends = [(float(x), float(y)) for x, y in a + np.linspace(0, 1, count + 1)[:, None] * (b - a)]
    for start, end in pairwise(ends):
        yield replace(hedge, start=start, end=end)
