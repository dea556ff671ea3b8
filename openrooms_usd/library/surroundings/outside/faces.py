"""Flat faces of the land's things on the canvas: where a way meets them, and how they are lit."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Mask
from openrooms_usd.library.surroundings.outside.canvas import Canvas
from openrooms_usd.library.surroundings.outside.daylight import Daylight
from openrooms_usd.library.surroundings.outside.noise import Floats
from openrooms_usd.library.surroundings.outside.shadows import Shadows

# How far before a face its light is looked up, so that it does not shade itself, metres.
_BEFORE_M: Final = 0.75
# What is this far is seen through half as much haze as light, metres.
_HAZY_M: Final = 4000.0


@dataclass(frozen=True, eq=False)
class World:
    """What lights things, and where the eye is.

    Attributes:
        day: Sun and sky.
        shadows: What the sun does not reach.
        eye: Height of the eye above the land, metres.
    """

    day: Daylight
    shadows: Shadows
    eye: float


@dataclass(frozen=True, eq=False)
class Hit:
    """Where K ways meet a face; arrays of (K,).

    Attributes:
        world: What lights it.
        u: Along the face's first axis, metres.
        v: Along its second.
        x: In the frame of the scene, metres from the eye.
        y: The same.
        z: Metres above the land.
        pixel: Metres across, of a pixel there.
        normal: (3,) of the face.
        first: (3,) its first axis.
    """

    world: World
    u: Floats
    v: Floats
    x: Floats
    y: Floats
    z: Floats
    pixel: float
    normal: Floats
    first: Floats

    def lit(self) -> Floats:
        """The part of the sun that reaches the face."""
        before = self.normal * _BEFORE_M
        return self.world.shadows.lit(self.x + before[0], self.y + before[1], self.z)

    def facing(self) -> float:
        """The cosine between the face and the sun; 0 from behind."""
        return max(0.0, float(self.world.day.sun @ self.normal))

    def irradiance(self, lit: Floats | float = 1.0) -> Floats:
        """(K, 3) lux of each primary, where a part ``lit`` of the sun comes in."""
        direct = self.facing() * self.world.day.beam
        return np.asarray(self.world.day.ambient(self.normal) + np.asarray(lit)[..., None] * direct)


Paint = Callable[[Hit], tuple[Floats, Floats]]
"""(K, 3) nits and (K,) cover."""


@dataclass(frozen=True, eq=False)
class Face:
    """A convex outline in a plane.

    Attributes:
        origin: (3,) metres from the eye.
        first: (3,) unit vector of u.
        second: (3,) unit vector of v; the face looks along first x second.
        outline: (K, 2) counter-clockwise, metres.
        paint: Its colours.
    """

    origin: Floats
    first: Floats
    second: Floats
    outline: Floats
    paint: Paint

    def draw(self, canvas: Canvas, world: World) -> None:
        """Put it on the canvas, behind what is there, unless it shows its back."""
        normal = np.cross(self.first, self.second).astype(np.float32)
        offset = float(normal @ self.origin)
        if offset > -0.02:
            return
        away = float(np.linalg.norm(self.origin + self._middle()))
        for patch in canvas.around(self._edge()):
            slant = normal[0] * patch.x + normal[1] * patch.y
            if normal[2]:
                slant = slant + normal[2] * patch.z
            t = offset / np.where(slant < -1e-5, slant, np.float32(-1e-5))
            ways = t * patch.x, t * patch.y, t * patch.z
            u, v = (self._along(axis, *ways) for axis in (self.first, self.second))
            inside = self._inside(u, v)
            seen = canvas.seen(patch, inside)
            if not len(seen[0]):
                continue
            u, v, x, y, z = (np.broadcast_to(item, inside.shape)[seen] for item in (u, v, *ways))
            hit = Hit(world, u, v, x, y, z + world.eye, away * patch.step, normal, self.first)
            color, cover = self.paint(hit)
            hazy = np.float32(1.0 - 0.5 ** (away / _HAZY_M))
            canvas.paint(patch, seen, color + (world.day.haze - color) * hazy, cover)

    def _middle(self) -> Floats:
        u, v = self.outline.mean(axis=0)
        return np.asarray(u * self.first + v * self.second)

    def _along(self, axis: Floats, x: Floats, y: Floats, z: Floats) -> Floats:
        found = x * axis[0] + y * axis[1] - float(axis @ self.origin)
        return np.asarray(found + z * axis[2] if axis[2] else found)

    def _edge(self) -> Floats:
        """(N, 3) points all around."""
        ends = np.roll(self.outline, -1, axis=0)
        share = np.linspace(0.0, 1.0, 12, endpoint=False)[:, None, None]
        plan = (self.outline + share * (ends - self.outline)).transpose(1, 0, 2).reshape(-1, 2)
        return np.asarray(self.origin + plan[:, :1] * self.first + plan[:, 1:] * self.second)

    def _inside(self, u: Floats, v: Floats) -> Mask:
        found = np.ones(np.broadcast_shapes(u.shape, v.shape), dtype=bool)
        corners = self.outline.tolist()
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            found &= (b[0] - a[0]) * (v - a[1]) >= (b[1] - a[1]) * (u - a[0])
        return found


def axes(yaw: float) -> tuple[Floats, Floats]:
    """(3,) along a wall and (3,) out of it, for a wall that looks along -Y turned by ``yaw``."""
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([c, s, 0.0], dtype=np.float32), np.array([s, -c, 0.0], dtype=np.float32)
