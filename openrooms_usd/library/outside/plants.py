"""Trees, bushes and hedges that stand on the land, as pictures that the moment lights."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.library.outside.canvas import Canvas
from openrooms_usd.library.outside.faces import Face, Hit, World
from openrooms_usd.library.outside.noise import Floats
from openrooms_usd.library.outside.shadows import Shadows
from openrooms_usd.library.outside.sprites import Sprite

# Of the sun, what goes through a leaf; and what bark sends back.
_THROUGH: Final = np.array([0.6, 0.75, 0.25], dtype=np.float32)
_BARK: Final = np.array([0.085, 0.07, 0.055], dtype=np.float32)


@dataclass(frozen=True, eq=False)
class Leaves:
    """How a picture of a plant is lit.

    Attributes:
        sprite: The picture.
        albedo: (3,) reflectance of its leaves.
        width: Metres.
        height: Metres.
        repeats: Whether it repeats to the sides.
    """

    sprite: Sprite
    albedo: Floats
    width: float
    height: float
    repeats: bool = False

    def __call__(self, hit: Hit) -> tuple[Floats, Floats]:
        """Nits and cover of the plant."""
        cover, normal, light, wood = self._looked_up(hit)
        day, up = hit.world.day, np.array([0.0, 0.0, 1.0])
        out = np.cross(hit.first, up)
        sun = np.array([day.sun @ hit.first, day.sun[2], day.sun @ out], dtype=np.float32)
        facing = normal @ sun
        direct = np.maximum(facing, 0.0) * light + 0.06 * light
        behind = np.maximum(-facing, 0.0) * light**1.5 * (1.0 - wood)
        lit = np.maximum(
            hit.world.shadows.lit(hit.x, hit.y, hit.z + 0.3), _risen(hit.z, self.height)
        )
        sky = 0.5 + 0.5 * normal[..., 1]
        ambient = day.ambient(np.array([0.0, 0.0, 1.0])) * (0.15 + 0.85 * light * sky)[..., None]
        ambient = ambient + math.pi * day.land * (light * (1.0 - sky))[..., None]
        albedo = self.albedo + (_BARK - self.albedo) * wood[..., None]
        beam = (direct * lit)[..., None] * albedo + (behind * lit)[..., None] * albedo * _THROUGH
        return np.asarray((ambient * albedo + beam * day.beam) / math.pi, np.float32), cover

    def _looked_up(self, hit: Hit) -> tuple[Floats, Floats, Floats, Floats]:
        fine = self.height / len(self.sprite.pixels)
        level = int(np.clip(np.log2(max(hit.pixel / fine, 1.0)), 0, len(self.sprite.smaller) - 1))
        pixels = self.sprite.smaller[level]
        rows, columns = pixels.shape[:2]
        row = ((1.0 - hit.v / self.height) * rows).astype(np.int32)
        column = np.floor((hit.u / self.width + 0.5) * columns).astype(np.int32)
        inside = (row >= 0) & (row < rows)
        if not self.repeats:
            inside = inside & (column >= 0) & (column < columns)
        found = pixels[np.clip(row, 0, rows - 1), column % columns]
        return found[..., 0] * inside, found[..., 1:4], found[..., 4], found[..., 5]


def _risen(z: Floats, height: float) -> Floats:
    """What of a plant stands in its own light: its upper part, whatever shades its foot."""
    return np.asarray(np.clip(z / (0.35 * height) - 0.6, 0.0, 1.0), dtype=np.float32)


@dataclass(frozen=True, eq=False)
class Plant:
    """A tree or a bush.

    Attributes:
        x: Metres from the eye.
        y: The same.
        height: Metres.
        sprite: Its picture.
        albedo: (3,) reflectance of its leaves.
        trunk: The part of its height below the crown.
        mirrored: Whether its picture is turned.
    """

    x: float
    y: float
    height: float
    sprite: Sprite
    albedo: Floats
    trunk: float = 0.0
    mirrored: bool = False

    @property
    def distance(self) -> float:
        """Metres from the eye."""
        return math.hypot(self.x, self.y)

    def stand(self, shadows: Shadows) -> None:
        """Tell the shadows of its crown."""
        half = 0.5 * self.height * self.sprite.aspect
        part = shadows.around(self.x, self.y, half)
        x, y = shadows.x[:, part[1]], shadows.y[part[0]]
        away = np.hypot(x - self.x, y - self.y) / half
        crown = self.height * (0.55 + 0.45 * np.sqrt(np.clip(1.0 - away**2, 0.0, 1.0)))
        shadows.stand(np.where(away < 0.92, crown, 0.0).astype(np.float32), part)

    def draw(self, canvas: Canvas, world: World) -> None:
        """Put it on the canvas, turned to the eye."""
        width = self.height * self.sprite.aspect
        towards = -np.array([self.x, self.y, 0.0]) / self.distance
        first = np.array([-towards[1], towards[0], 0.0], dtype=np.float32)
        up = np.array([0.0, 0.0, 1.0], dtype=np.float32)
        half = 0.5 * width
        outline = np.array([(-half, 0.0), (half, 0.0), (half, self.height), (-half, self.height)])
        paint = Leaves(self.sprite, self.albedo, -width if self.mirrored else width, self.height)
        origin = np.array([self.x, self.y, -world.eye], dtype=np.float32)
        Face(origin, first, up, outline, paint).draw(canvas, world)


@dataclass(frozen=True, eq=False)
class Hedge:
    """A hedge between two places, or a fence in its stead.

    Attributes:
        start: (2,) metres from the eye.
        end: (2,) the same; the hedge is seen from its right.
        height: Metres.
        sprite: Its leaves.
        albedo: (3,) their reflectance.
    """

    start: tuple[float, float]
    end: tuple[float, float]
    height: float
    sprite: Sprite
    albedo: Floats

    @property
    def distance(self) -> float:
        """Metres from the eye to the nearest part of it."""
        a, b = np.array(self.start), np.array(self.end)
        t = float(np.clip(-(a @ (b - a)) / ((b - a) @ (b - a)), 0.0, 1.0))
        return float(np.linalg.norm(a + t * (b - a)))

    def stand(self, shadows: Shadows) -> None:
        """Tell the shadows of it."""
        a, b = np.array(self.start), np.array(self.end)
        along = (b - a) / np.linalg.norm(b - a)
        u = (shadows.x - a[0]) * along[0] + (shadows.y - a[1]) * along[1]
        v = (shadows.y - a[1]) * along[0] - (shadows.x - a[0]) * along[1]
        inside = (u > 0.0) & (u < np.linalg.norm(b - a)) & (v > -0.1) & (v < 0.8)
        shadows.stand((self.height * inside).astype(np.float32))

    def draw(self, canvas: Canvas, world: World) -> None:
        """Put it on the canvas, piece by piece."""
        a, b = np.array([*self.start, -world.eye]), np.array([*self.end, -world.eye])
        length = float(np.linalg.norm(b - a))
        first = ((b - a) / length).astype(np.float32)
        up = np.array([0.0, 0.0, 1.0], dtype=np.float32)
        paint = Leaves(self.sprite, self.albedo, self.height, self.height, repeats=True)
        pieces = max(1, math.ceil(length / 9.0))
        for number in range(pieces):
            low, high = length * number / pieces, length * (number + 1) / pieces
            outline = np.array([(low, 0.0), (high, 0.0), (high, self.height), (low, self.height)])
            Face(a.astype(np.float32), first, up, outline, paint).draw(canvas, world)
