"""Houses as faces: walls under a gable or a flat roof, with chimneys."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from openrooms_usd.library.surroundings.outside.canvas import Canvas
from openrooms_usd.library.surroundings.outside.facades import (
    EAVES_M,
    Facade,
    FacadeMaterials,
    Plain,
    Style,
    Tiles,
)
from openrooms_usd.library.surroundings.outside.faces import Face, World, axes
from openrooms_usd.library.surroundings.outside.noise import Floats
from openrooms_usd.library.surroundings.outside.shadows import Shadows


@dataclass(frozen=True, eq=False)
class House:
    """A house on the land, in the frame of the scene.

    Attributes:
        x: Its middle, metres from the eye.
        y: The same.
        width: Along its front, metres.
        depth: Metres.
        eaves: Height of its walls, metres.
        pitch: Slope of its gable roof, radians; 0 for a flat one.
        yaw: Radians; at 0 its front looks along -Y.
        style: How it looks.
        number: For what is drawn.
        front: Whether the roof slopes down to the front, not to the sides.
    """

    x: float
    y: float
    width: float
    depth: float
    eaves: float
    pitch: float
    yaw: float
    style: Style
    number: int
    front: bool = True

    @property
    def distance(self) -> float:
        """Metres from the eye to its middle."""
        return math.hypot(self.x, self.y)

    @property
    def _span(self) -> float:
        """Metres across, below the roof."""
        return self.depth if self.front else self.width

    @property
    def ridge(self) -> float:
        """Height of its roof, metres."""
        return self.eaves + 0.5 * self._span * math.tan(self.pitch) + 0.4 * (self.pitch == 0.0)

    def plan(self) -> Floats:
        """(4, 2) its corners, metres from the eye."""
        return np.array([self._corner(side, *self._sides(side))[:2] for side in range(4)])

    def faces(self, eye: float, surfaces: FacadeMaterials) -> Iterator[Face]:
        """Its walls, its roof and its chimney; ``eye`` is the height of the eye above the land."""
        yield from self._walls(eye, surfaces)
        yield from self._roof(eye, surfaces)

    def stand(self, shadows: Shadows) -> None:
        """Tell the shadows of it."""
        along, out = axes(self.yaw)
        u = (shadows.x - self.x) * along[0] + (shadows.y - self.y) * along[1]
        v = (shadows.x - self.x) * out[0] + (shadows.y - self.y) * out[1]
        across = v if self.front else u
        roof = np.maximum(self.ridge - np.abs(across) * math.tan(self.pitch), 0.0)
        inside = (np.abs(u) < 0.5 * self.width) & (np.abs(v) < 0.5 * self.depth)
        shadows.stand(np.where(inside, roof, 0.0).astype(np.float32))

    def draw(self, canvas: Canvas, world: World, surfaces: FacadeMaterials) -> None:
        """Put it on the canvas, its roof before its walls."""
        for face in reversed(tuple(self.faces(world.eye, surfaces))):
            face.draw(canvas, world)

    def _at(self, u: float, v: float, z: float) -> Floats:
        """(3,) a point from its middle: along the front, out of it, up from the land."""
        along, out = axes(self.yaw)
        flat = along * u + out * v
        return np.array([self.x + flat[0], self.y + flat[1], z], dtype=np.float32)

    def _walls(self, eye: float, surfaces: FacadeMaterials) -> Iterator[Face]:
        up = np.array([0.0, 0.0, 1.0], dtype=np.float32)
        for side in range(4):
            along, _ = axes(self.yaw + 0.5 * math.pi * side)
            length, deep = self._sides(side)
            corner = self._corner(side, length, deep)
            gable = self.pitch > 0.0 and (side % 2 == 1) == self.front
            top = self.ridge if self.pitch == 0.0 else self.eaves
            outline = [(0.0, 0.0), (length, 0.0), (length, top)]
            outline += [(0.5 * length, self.ridge)] * gable + [(0.0, top)]
            paint = Facade(
                surfaces,
                self.style,
                length,
                self.eaves,
                self.number + 17 * side,
                windows=side % 2 == 0 or self.style.storey > 3.0 or self.number % 3 > 0,
                door=side == 0,
                eaves=self.pitch > 0.0 and not gable,
            )
            yield Face(corner - eye * up, along, up, np.array(outline), paint)

    def _sides(self, side: int) -> tuple[float, float]:
        """The length of a wall, and how deep the house is behind it."""
        return (self.width, self.depth) if side % 2 == 0 else (self.depth, self.width)

    def _corner(self, side: int, length: float, deep: float) -> Floats:
        """The left foot of a wall, seen from outside."""
        along, out = axes(self.yaw + 0.5 * math.pi * side)
        flat = -0.5 * length * along + 0.5 * deep * out
        return np.array([self.x + flat[0], self.y + flat[1], 0.0], dtype=np.float32)

    def _roof(self, eye: float, surfaces: FacadeMaterials) -> Iterator[Face]:
        if self.pitch == 0.0:
            return
        long = (self.width if self.front else self.depth) + 0.5
        slope = (0.5 * self._span + EAVES_M) / math.cos(self.pitch)
        for side in (0, 2) if self.front else (1, 3):
            along, out = axes(self.yaw + 0.5 * math.pi * side)
            rise = np.array([0.0, 0.0, math.sin(self.pitch)]) - out * math.cos(self.pitch)
            foot = (0.5 * self._span + EAVES_M) * out - 0.5 * long * along
            low = self.eaves - EAVES_M * math.tan(self.pitch)
            origin = np.array([self.x, self.y, low - eye]) + foot
            outline = np.array([(0.0, 0.0), (long, 0.0), (long, slope), (0.0, slope)])
            yield Face(
                origin.astype(np.float32),
                along,
                rise.astype(np.float32),
                outline,
                Tiles(surfaces, self.style.roof, self.number),
            )
        if self.number % 3:
            yield from self._chimney(eye, surfaces)

    def _chimney(self, eye: float, surfaces: FacadeMaterials) -> Iterator[Face]:
        up = np.array([0.0, 0.0, 1.0], dtype=np.float32)
        place = 0.3 * (1 - 2 * (self.number % 2)) * (self.width if self.front else self.depth)
        middle = self._at(place, 0.0, 0.0) if self.front else self._at(0.0, place, 0.0)
        low, high = self.ridge - 0.9, self.ridge + 0.9
        for side in range(4):
            along, out = axes(self.yaw + 0.5 * math.pi * side)
            corner = middle + 0.35 * out - 0.35 * along + (low - eye) * up
            outline = np.array([(0.0, 0.0), (0.7, 0.0), (0.7, high - low), (0.0, high - low)])
            yield Face(corner, along, up, outline, Plain(surfaces, (0.2, 0.1, 0.075)))
