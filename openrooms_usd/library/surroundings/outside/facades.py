"""House walls: brick, plaster or boards with windows and doors in rows, and roofs of tiles."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.library.surroundings.outside.faces import Hit
from openrooms_usd.library.surroundings.outside.noise import (
    Floats,
    fractal_tile,
    nearest,
    sampled,
    step,
)

Color = tuple[float, float, float]

# How far a window stands back in its wall, and how far eaves reach over walls, metres.
_REVEAL_M: Final = 0.12
EAVES_M: Final = 0.4
_FRAME_M: Final = 0.07
_DOOR_M: Final = (1.05, 2.15)
# Light that a pane sends back, of both its surfaces, seen straight and along it.
_MIRRORED: Final = (0.09, 0.9)
# What is seen of a room behind a pane, as a part of the light outside; and lamps inside, nits.
_INSIDE_ALBEDO: Final = 0.012
_LAMP_NITS: Final = np.array([95.0, 62.0, 33.0], dtype=np.float32)
_TABLE: Final = 64
_GLASS: Final = np.array([0.86, 0.95, 0.93], dtype=np.float32)


@dataclass(frozen=True)
class Style:
    """How a house looks.

    Attributes:
        wall: Reflectance of its walls.
        build: ``plaster``, ``brick`` or ``boards``.
        frame: Reflectance of window frames.
        door: Of doors.
        roof: Of its tiles.
        window: Width, height and height above the floor of its windows, metres.
        bay: From window to window, metres.
        storey: From floor to floor, metres.
    """

    wall: Color
    build: str
    frame: Color
    door: Color
    roof: Color
    window: tuple[float, float, float]
    bay: float
    storey: float


class FacadeMaterials:
    """Patterns that the houses of a scene share."""

    def __init__(self, rng: np.random.Generator) -> None:
        """Draw them."""
        self.rough = fractal_tile(rng, 1.0, 3)
        self.smooth = fractal_tile(rng, 2.3, 2)
        self.white = fractal_tile(rng, 0.0, 1)
        self.chance = rng.random((_TABLE, _TABLE)).astype(np.float32)

    def drawn(self, i: Floats, j: Floats, salt: int) -> Floats:
        """A number from 0 to 1 for each pair of whole numbers."""
        rows = (j.astype(np.int32) * 7 + salt * 13) % _TABLE
        return np.asarray(self.chance[rows, (i.astype(np.int32) * 3 + salt * 29) % _TABLE])


@dataclass(frozen=True, eq=False)
class Facade:
    """A wall of a house; u runs along it from 0, v up from the land.

    Attributes:
        surfaces: Its patterns.
        style: How it looks.
        length: Metres.
        height: Of its eaves, metres.
        number: Of the house, for what is drawn.
        windows: Whether it has any.
        door: Whether it has a door.
        eaves: Whether a roof reaches over it.
    """

    surfaces: FacadeMaterials
    style: Style
    length: float
    height: float
    number: int
    windows: bool = True
    door: bool = False
    eaves: bool = True

    def __call__(self, hit: Hit) -> tuple[Floats, Floats]:
        """Nits and cover of the wall."""
        slope_u, slope_v = self._sun_slopes(hit)
        sun = np.broadcast_to(hit.lit(), hit.u.shape)
        if self.eaves:
            sun = sun * (hit.v + EAVES_M * slope_v < self.height)
        albedo = self._wall(hit)
        if not self.windows:
            return albedo * hit.irradiance(sun) / math.pi, np.ones(1, np.float32)
        return self._with_windows(hit, albedo, sun, slope_u, slope_v)

    def _sun_slopes(self, hit: Hit) -> tuple[float, float]:
        """How far light moves along u and v for each metre that it comes out of the wall."""
        sun = hit.world.day.sun
        facing = max(float(sun @ hit.normal), 0.05)
        return float(sun @ hit.first) / facing, float(sun[2]) / facing

    def _wall(self, hit: Hit) -> Floats:
        style, u, v = self.style, hit.u, hit.v
        shade = 1.0 + 0.05 * sampled(self.surfaces.rough, u / 9.0, v / 9.0)
        shade = shade * (1.0 - 0.18 * np.exp(-np.maximum(v, 0.0) / 0.5))
        if style.build == "brick":
            shade = shade * self._bricks(hit)
        elif style.build == "boards":
            lines = (np.abs((v / 0.16) % 1.0 - 0.5) > 0.42).astype(np.float32)
            shade = shade * (1.0 - 0.45 * _visible(0.16, hit.pixel) * lines)
        wall = np.array(style.wall, dtype=np.float32) * shade[..., None]
        plinth = (v < 0.45)[..., None]
        return np.asarray(np.where(plinth, np.array((0.16, 0.155, 0.15), dtype=np.float32), wall))

    def _bricks(self, hit: Hit) -> Floats:
        row = np.floor(hit.v / 0.075)
        along = hit.u / 0.24 + 0.5 * (row % 2.0)
        joint = ((hit.v / 0.075) % 1.0 > 0.86) | (along % 1.0 > 0.95)
        varied = 0.17 * nearest(self.surfaces.white, np.floor(along) / 509.0, row / 503.0)
        seen = _visible(0.075, hit.pixel)
        return np.asarray(1.0 + seen * np.where(joint, 0.35, varied), dtype=np.float32)

    def _with_windows(
        self, hit: Hit, albedo: Floats, sun: Floats, slope_u: float, slope_v: float
    ) -> tuple[Floats, Floats]:
        style, draw = self.style, self.surfaces.drawn
        wide, tall, sill = style.window
        bays = max(1, int(self.length / style.bay))
        pitch = self.length / bays
        i, j = np.floor(hit.u / pitch), np.floor(hit.v / style.storey)
        a = hit.u - (i + 0.5) * pitch
        b = hit.v - j * style.storey - sill
        storeys = max(1, int((self.height + 0.3) / style.storey))
        there = (i >= 0) & (i < bays) & (j >= 0) & (j < storeys)
        door = there & (j == 0) & (i == self.number % bays) & self.door
        blank = draw(i, j * 0, self.number + 5) < 0.08
        there = there & ~door & ~blank
        half = 0.5 * wide
        hole = there & (np.abs(a) < half) & (b > 0.0) & (b < tall)
        inner = hole & (np.abs(a) < half - _FRAME_M) & (b > _FRAME_M) & (b < tall - _FRAME_M)
        cross = (np.abs(a) < 0.04) & (wide > 0.8)
        cross = cross | ((np.abs(b - 0.68 * tall) < 0.025) & (style.build != "plaster"))
        glass = inner & ~cross
        stone = there & (np.abs(a) < half + 0.09) & (b > -0.09) & (b < tall + 0.1) & ~hole
        leaf = door & (np.abs(a) < 0.5 * _DOOR_M[0]) & (hit.v < _DOOR_M[1])
        for where, color in (
            (stone, tuple(0.5 * c + 0.28 for c in style.wall)),
            (hole, style.frame),
            (leaf, style.door),
        ):
            albedo = np.where(where[..., None], np.array(color, dtype=np.float32), albedo)
        deep = np.abs(a + _REVEAL_M * slope_u) < half
        deep = deep & (b + _REVEAL_M * slope_v < tall)
        sun = np.where(hole, sun * deep, sun)
        below = there & (np.abs(a) < half + 0.1) & (b < -0.09) & (b > -0.09 - 0.07 * slope_v)
        sun = np.where(below & (slope_v > 0.0), 0.25 * sun, sun)
        nits = albedo * hit.irradiance(sun) / math.pi
        nits = np.where(glass[..., None], self._panes(hit, i, j, a, b, sun), nits)
        return np.asarray(nits, dtype=np.float32), np.ones(1, np.float32)

    def _panes(self, hit: Hit, i: Floats, j: Floats, a: Floats, b: Floats, sun: Floats) -> Floats:
        """(K, 3) nits: what a pane mirrors, and curtains, blinds and lamps behind it."""
        draw, (wide, tall, _) = self.surfaces.drawn, self.style.window
        kind, width = draw(i, j, self.number), draw(i, j, self.number + 1)
        drawn = (kind < 0.45) & (np.abs(a) > 0.5 * wide * (0.45 + 0.5 * width))
        lowered = (kind > 0.7) & (b > tall * (0.25 + 0.7 * width))
        cloth = (drawn | lowered).astype(np.float32)
        light = hit.irradiance(0.8 * sun) / math.pi
        inside = light * (_INSIDE_ALBEDO + 0.24 * cloth)[..., None]
        # Lit rooms differ, and are brighter towards their ceilings; blinds glow.
        bright = (0.25 + 0.75 * draw(i, j, self.number + 4)) * (0.55 + 0.45 * b / tall)
        bright = bright * (draw(i, j, self.number + 2) < 0.2) * (0.6 + 0.4 * cloth)
        lamp = bright[..., None] * _LAMP_NITS
        far = np.sqrt(hit.x**2 + hit.y**2 + (hit.z - hit.world.eye) ** 2)
        cosine = np.abs(hit.x * hit.normal[0] + hit.y * hit.normal[1]) / far
        low, high = _MIRRORED
        mirrored = low + (high - low) * (1.0 - cosine) ** 5
        # A pane is never quite flat, nor quite in its wall's plane.
        lean = 0.05 * (draw(i, j, self.number + 3) - 0.5) + 0.012 * sampled(
            self.surfaces.rough, hit.u / 4.0, hit.v / 4.0
        )
        n = hit.normal
        flat = np.hypot(hit.x, hit.y)
        ways = hit.x / flat, hit.y / flat, (hit.z - hit.world.eye) / flat
        along = 2.0 * (ways[0] * n[0] + ways[1] * n[1])
        seen = hit.world.day.seen(
            ways[0] - along * (n[0] + lean), ways[1] - along * (n[1] + lean), ways[2] + lean
        )
        # Low down a pane mirrors the houses and trees across from it.
        rise = step(0.16, 0.36, ways[2] + lean + 0.08 * (width - 0.5))[..., None]
        seen = seen * rise + 0.5 * light * (1.0 - rise)
        through = (1.0 - mirrored)[..., None]
        return np.asarray((inside * _GLASS + lamp) * through + seen * mirrored[..., None])


@dataclass(frozen=True, eq=False)
class Tiles:
    """A roof; u runs along its eaves, v up its slope."""

    surfaces: FacadeMaterials
    albedo: Color
    number: int

    def __call__(self, hit: Hit) -> tuple[Floats, Floats]:
        """Nits and cover of the roof."""
        row = np.floor(hit.v / 0.33)
        along = hit.u / 0.3 + 0.5 * (row % 2.0)
        edge = ((hit.v / 0.33) % 1.0 < 0.16) | (along % 1.0 > 0.9)
        each = 0.1 * nearest(self.surfaces.white, np.floor(along) / 509.0, row / 503.0)
        seen = _visible(0.33, hit.pixel)
        shade = 1.0 + seen * np.where(edge, -0.32, each)
        shade = shade * (1.0 + 0.09 * sampled(self.surfaces.rough, hit.u / 14.0, hit.v / 14.0))
        albedo = np.array(self.albedo, dtype=np.float32) * shade[..., None]
        # The gutter.
        albedo = np.where(
            (hit.v < 0.14)[..., None], np.array((0.2, 0.2, 0.2), dtype=np.float32), albedo
        )
        color = albedo * hit.irradiance(hit.lit()) / math.pi
        return np.asarray(color, np.float32), np.ones(1, np.float32)


@dataclass(frozen=True, eq=False)
class Plain:
    """An even face, a little stained."""

    surfaces: FacadeMaterials
    albedo: Color

    def __call__(self, hit: Hit) -> tuple[Floats, Floats]:
        """Nits and cover of the face."""
        shade = 1.0 + 0.07 * sampled(self.surfaces.rough, hit.u / 5.0, hit.v / 5.0)
        color = (
            np.array(self.albedo, dtype=np.float32)
            * shade[..., None]
            * hit.irradiance(hit.lit())
            / math.pi
        )
        return np.asarray(color, np.float32), np.ones(1, np.float32)


def _visible(size: float, pixel: float) -> float:
    """How much of a pattern is left where it is as fine as pixels."""
    return float(np.clip(size / (2.0 * pixel) - 0.5, 0.0, 1.0))
