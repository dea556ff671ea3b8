"""Trees, bushes and hedges that stand on the land, as pictures that the moment lights."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from openrooms_usd.library.surroundings.outside.canvas import Canvas
from openrooms_usd.library.surroundings.outside.faces import Face, Hit, World
from openrooms_usd.library.surroundings.outside.noise import Floats
from openrooms_usd.library.surroundings.outside.shadows import Shadows

# Rows of a picture; how many kinds of leaf clusters there are, their side in pixels, their leaves.
_ROWS: Final = 448
# How much of a hedge's height its top differs by.
_RAGGED_SHARE: Final = 0.055
# Trees whose crowns begin lower show no boughs.
_STEM_ONLY_SHARE: Final = 0.1
_CLUSTERS, _CLUSTER_SIDE, _LEAVES = 12, 26, 16


@dataclass(frozen=True, eq=False)
class Sprite:
    """A plant as a picture, its foot in the middle of the lower edge.

    Attributes:
        pixels: (H, W, 6) cover, normal (right, up, to the eye), light that reaches it in the
            crown, and whether it is wood.
        aspect: Width over height.
    """

    pixels: Floats
    aspect: float

    @cached_property
    def smaller(self) -> tuple[Floats, ...]:
        """The picture, and the same with half as many pixels each."""
        found = [self.pixels]
        while min(found[-1].shape[:2]) >= 16:
            last = found[-1][: len(found[-1]) // 2 * 2, : found[-1].shape[1] // 2 * 2]
            h, w = last.shape[0] // 2, last.shape[1] // 2
            quads = last.reshape(h, 2, w, 2, last.shape[2])
            weight = quads[..., :1] + 1e-4
            mean = (quads * weight).sum(axis=(1, 3)) / weight.sum(axis=(1, 3))
            mean[..., 0] = quads[..., 0].mean(axis=(1, 3))
            found.append(mean)
        return tuple(found)


def leafy(rng: np.random.Generator, aspect: float, trunk: float) -> Sprite:
    """A broad-leaved tree or, without a trunk, a bush.

    Args:
        rng: Draws it.
        aspect: Width over height.
        trunk: The part of its height below the crown.
    """
    count = int(rng.integers(16, 24))
    way = rng.standard_normal((count, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    # An egg that is wider below its middle.
    size = np.array([0.36 * aspect, 0.4 * (1.0 - trunk), 0.36 * aspect])
    middle = np.array([0.0, trunk + 0.52 * (1.0 - trunk), 0.0])
    lobes = middle + way * size * rng.uniform(0.55, 1.0, (count, 1))
    lobes[:, 0] *= 1.12 - 0.45 * np.clip((lobes[:, 1] - middle[1]) / size[1], -0.3, 1.0)
    radii = rng.uniform(0.11, 0.19, count) * (1.0 - 0.5 * trunk) * min(1.0, aspect * 1.2)
    at, out = _on_lobes(rng, lobes, radii, 95)
    out = 0.6 * out + 0.7 * _unit((at - middle) / size)
    return _stamped(rng, aspect, at, out, middle, size, trunk)


def conifer(rng: np.random.Generator, aspect: float) -> Sprite:
    """A fir: branches that droop in tiers around a stem."""
    heights = rng.random(2600) ** 0.75 * 0.93
    angle = rng.uniform(0.0, 2.0 * np.pi, 2600)
    reach = 0.5 * aspect * heights * (0.82 + 0.18 * np.sin(heights * 70.0 + 2.0 * np.sin(angle)))
    reach *= np.sqrt(rng.random(2600)) * 0.35 + 0.65
    up = 0.985 - heights - 0.12 * reach
    at = np.stack([reach * np.cos(angle), up, reach * np.sin(angle)], axis=1)
    out = _unit(np.stack([np.cos(angle), np.full(2600, 0.55), np.sin(angle)], axis=1))
    middle, size = np.array([0.0, 0.45, 0.0]), np.array([0.45 * aspect, 0.6, 0.45 * aspect])
    return _stamped(rng, aspect, at, out, middle, size, 0.06, scale=0.62)


def hedge(rng: np.random.Generator) -> Sprite:
    """A square of clipped leaves that repeats to the sides."""
    at = np.stack(
        [rng.uniform(-0.5, 0.5, 4200), rng.uniform(0.0, 1.0, 4200), 0.12 * rng.random(4200)], axis=1
    )
    out = rng.standard_normal((4200, 3)) * 0.55 + np.array([0.0, 0.35, 1.0])
    middle, size = np.array([0.0, 0.5, -0.35]), np.array([9.0, 9.0, 0.44])
    made = _stamped(rng, 1.0, at, _unit(out), middle, size, 0.0, scale=0.8, around=True)
    # Shoots stand out at the top.
    steps = rng.random(_ROWS)
    shoots = sum(np.roll(steps, k) for k in range(-3, 4)) / 7.0 + 0.25 * rng.random(_ROWS)
    top = (_RAGGED_SHARE * _ROWS * shoots).astype(int)
    made.pixels[np.arange(_ROWS)[:, None] < top[None, :], 0] = 0.0
    return made


def _on_lobes(
    rng: np.random.Generator, lobes: Floats, radii: Floats, each: int
) -> tuple[Floats, Floats]:
    way = _unit(rng.standard_normal((len(lobes), each, 3)))
    at = lobes[:, None] + way * radii[:, None, None] * rng.uniform(0.8, 1.08, (len(lobes), each, 1))
    return at.reshape(-1, 3), way.reshape(-1, 3)


def _unit(ways: Floats) -> Floats:
    return np.asarray(ways / np.linalg.norm(ways, axis=-1, keepdims=True))


def _stamped(
    rng: np.random.Generator,
    aspect: float,
    at: Floats,
    out: Floats,
    middle: Floats,
    size: Floats,
    trunk: float,
    *,
    scale: float = 1.0,
    around: bool = False,
) -> Sprite:
    """Clusters of leaves at (N, 3) places (right, up, to the eye) in heights of the plant."""
    height, width = _ROWS, round(_ROWS * aspect)
    pad = _CLUSTER_SIDE
    pixels = np.zeros((height + 2 * pad, width + 2 * pad, 6), dtype=np.float32)
    if around:
        # Between its leaves it is dark, but nothing is seen through it.
        pixels[..., :5] = 1.0, 0.0, 0.5, 0.87, 0.12
    if trunk > 0.0:
        _wood(rng, pixels[pad:-pad, pad:-pad], trunk, middle, size)
    stencils = _clusters(rng, scale)
    order = np.argsort(at[:, 2])
    inner = np.linalg.norm((at - middle) / size, axis=1)
    light = np.clip((inner - 0.25) / 0.75, 0.12, 1.0) ** 1.3
    light *= rng.uniform(0.75, 1.1, len(at))
    half, kinds = _CLUSTER_SIDE // 2, rng.integers(_CLUSTERS, size=len(at))
    normals = _unit(out + 0.35 * rng.standard_normal(out.shape))
    column = (at[:, 0] + 0.5 * aspect) * height + pad - half
    row = (1.0 - at[:, 1]) * height + pad - half
    values = np.ones((len(at), 6), dtype=np.float32)
    values[:, 1:4], values[:, 4], values[:, 5] = normals, light, 0.0
    rows, columns = row.astype(int).tolist(), column.astype(int).tolist()
    for k in order.tolist():
        r, c = rows[k], columns[k]
        stencil = stencils[kinds[k]]
        places = [c - width, c, c + width] if around else [c]
        for c in places:
            if r < 0 or c < 0:
                continue
            there = pixels[r : r + _CLUSTER_SIDE, c : c + _CLUSTER_SIDE]
            if there.shape[:2] == stencil.shape:
                there[stencil] = values[k]
    return Sprite(pixels[pad:-pad, pad:-pad].copy(), aspect)


def _clusters(rng: np.random.Generator, scale: float) -> list[np.ndarray]:
    """Shapes of leaves that grow together: ellipses around a point."""
    side = _CLUSTER_SIDE
    y, x = np.mgrid[0:side, 0:side] - 0.5 * (side - 1)
    found = []
    for _ in range(_CLUSTERS):
        shape = np.zeros((side, side), dtype=bool)
        for _ in range(_LEAVES):
            px, py = rng.normal(0.0, 0.22 * side, 2)
            turn, long = rng.uniform(0.0, np.pi), rng.uniform(1.9, 3.4) * scale
            a = (x - px) * np.cos(turn) + (y - py) * np.sin(turn)
            b = (y - py) * np.cos(turn) - (x - px) * np.sin(turn)
            shape |= (a / long) ** 2 + (b / (0.48 * long)) ** 2 < 1.0
        found.append(shape)
    return found


def _wood(
    rng: np.random.Generator, pixels: Floats, trunk: float, middle: Floats, size: Floats
) -> None:
    """A stem and its boughs, from the foot into the crown."""
    height, width = pixels.shape[:2]
    boughs = [((0.0, 0.0), (0.0, middle[1]), 0.022, 0.012)]
    for _ in range(7 if trunk > _STEM_ONLY_SHARE else 0):
        start = float(rng.uniform(trunk * 0.85, middle[1]))
        way = rng.uniform(-1.0, 1.0)
        end = (way * size[0] * 0.9, start + size[1] * float(rng.uniform(0.5, 1.0)))
        boughs.append(((0.0, start), end, 0.01, 0.003))
    y, x = np.mgrid[0:height, 0:width]
    px, py = (x + 0.5) / height - 0.5 * width / height, 1.0 - (y + 0.5) / height
    for (ax, ay), (bx, by), thick, thin in boughs:
        along = np.array([bx - ax, by - ay])
        t = np.clip(((px - ax) * along[0] + (py - ay) * along[1]) / (along @ along), 0.0, 1.0)
        away = np.hypot(px - ax - t * along[0], py - ay - t * along[1])
        half = thick + (thin - thick) * t
        inside = away < half
        side = np.clip((px - ax - t * along[0]) / half, -1.0, 1.0)[inside]
        normal = np.stack([side, np.zeros_like(side), np.sqrt(1.0 - side**2)], axis=1)
        pixels[inside] = 1.0
        pixels[inside, 1:4], pixels[inside, 4] = normal, 0.7


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
