"""Where a room stands: what lies before its windows, drawn by a seed.

The frame of a scene: metres from the eye, the front of the room's house looks along +Y, Z up.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from types import MappingProxyType
from typing import Final

import numpy as np

from openrooms_usd.library.surroundings.outside.facades import Color, Style
from openrooms_usd.library.surroundings.outside.houses import House
from openrooms_usd.library.surroundings.outside.land import Ridge, Zone
from openrooms_usd.library.surroundings.outside.plants import (
    Hedge,
    Plant,
    Sprite,
    conifer,
    hedge,
    leafy,
)
from openrooms_usd.tables import read_table

_FAR: Final = 1e6
_ALL: Final = (-_FAR, _FAR)

_PALETTES: Final = read_table(__file__, "scenes.toml")
# Of trees on open land, how many stand apart from others.
_ALONE_SHARE: Final = 0.35
_NEEDLES: Final[Color] = (0.026, 0.044, 0.022)


@dataclass(frozen=True, eq=False)
class Scene:
    """What lies around a room.

    Attributes:
        things: Houses and plants.
        zones: The land, later ones over earlier ones.
        ridges: Hills, the farthest first.
        own: Height of the room's own house, metres.
    """

    things: tuple[House | Plant | Hedge, ...]
    zones: tuple[Zone, ...]
    ridges: tuple[Ridge, ...]
    own: float


@dataclass(frozen=True, eq=False)
class PlantPalette:
    """What a scene chooses from.

    Attributes:
        rng: Draws it.
        trees: Pictures of broad-leaved trees.
        bushes: Of bushes.
        firs: Of firs.
        hedge: Of a clipped hedge.
    """

    rng: np.random.Generator
    trees: tuple[Sprite, ...]
    bushes: tuple[Sprite, ...]
    firs: tuple[Sprite, ...]
    hedge: Sprite

    @classmethod
    def create(
        cls, rng: np.random.Generator, pictures: np.random.Generator | None
    ) -> "PlantPalette":
        """Draw the pictures.

        Args:
            rng: Draws the scene.
            pictures: Draws them; None leaves them blank, for a scene that is not rendered.
        """
        broad, low, narrow = ((0.85, 0.2), (0.62, 0.16)), (1.25, 0.0), 0.46
        if pictures is None:
            trees = tuple(_blank(aspect) for aspect, _ in broad)
            return cls(rng, trees, (_blank(low[0]),), (_blank(narrow),), _blank(1.0))
        trees = tuple(leafy(pictures, *shape) for shape in broad)
        bushes, firs = (leafy(pictures, *low),), (conifer(pictures, narrow),)
        return cls(rng, trees, bushes, firs, hedge(pictures))

    def between(self, low: float, high: float) -> float:
        """A number between two."""
        return float(self.rng.uniform(low, high))

    def pick(self, options: tuple[Color, ...]) -> Color:
        """One of some colours, a little changed."""
        color = np.array(options[int(self.rng.integers(len(options)))])
        return tuple((color * self.rng.uniform(0.92, 1.08)).tolist())

    def tree(self, x: float, y: float, low: float, high: float) -> Plant:
        """A tree of a height between two."""
        rng = self.rng
        fir = rng.random() < 0.18
        sprite = (self.firs if fir else self.trees)[
            int(rng.integers(len(self.firs if fir else self.trees)))
        ]
        color = np.array(_NEEDLES if fir else self.pick(_PALETTES["leaves"]), dtype=np.float32)
        tall = self.between(low, high) * (1.15 if fir else 1.0)
        return Plant(x, y, tall, sprite, color, 0.15, bool(rng.integers(2)))

    def bush(self, x: float, y: float, low: float = 0.7, high: float = 1.9) -> Plant:
        """A bush."""
        color = np.array(self.pick(_PALETTES["leaves"]), dtype=np.float32)
        tall = self.between(low, high)
        return Plant(x, y, tall, self.bushes[0], color, 0.0, bool(self.rng.integers(2)))

    def fence(self, *points: tuple[float, float], height: float) -> list[Hedge]:
        """A hedge along a line; the eye is on its right."""
        color = np.array(self.pick(_PALETTES["leaves"]), dtype=np.float32) * 0.85
        pairs = pairwise(points)
        return [Hedge(a, b, height, self.hedge, color) for a, b in pairs]

    def style(self, city: bool = False) -> Style:
        """How a house looks."""
        rng = self.rng
        shares = (0.7, 0.3, 0.0) if city else (0.5, 0.3, 0.2)
        build = str(rng.choice(("plaster", "brick", "boards"), p=shares))
        frame = (0.68, 0.68, 0.66) if rng.random() < 0.75 else (0.07, 0.065, 0.06)
        if city:
            size = (self.between(1.0, 1.3), self.between(1.6, 2.0), 0.75)
            bay, storey = self.between(2.3, 3.0), self.between(3.1, 3.4)
        else:
            size = (self.between(1.0, 1.6), self.between(1.2, 1.45), 0.95)
            bay, storey = self.between(2.5, 3.6), self.between(2.7, 2.95)
        door, roof = self.pick(_PALETTES["doors"]), self.pick(_PALETTES["roofs"])
        return Style(self.pick(_PALETTES[build]), build, frame, door, roof, size, bay, storey)

    def house(self, x: float, y: float, yaw: float, width: float) -> House:
        """A house for one or two families; ``y`` is its front's where ``yaw`` is 0."""
        rng, style = self.rng, self.style()
        storeys = 1 if rng.random() < 0.3 else 2
        eaves = storeys * style.storey + self.between(0.15, 0.5)
        pitch = math.radians(self.between(32.0, 48.0))
        depth = self.between(7.5, 9.5)
        out = np.array([math.sin(yaw), -math.cos(yaw)]) * 0.5 * depth
        body = width, depth, eaves, pitch, yaw, style, int(rng.integers(1000))
        return House(x - out[0], y - out[1], *body, rng.random() < 0.65)

    def row(self, y: float, facing: float, gap: tuple[float, float], reach: float) -> list[House]:
        """Houses side by side along X, their fronts at ``y``."""
        made: list[House] = []
        x = -reach + self.between(0.0, 8.0)
        while x < reach:
            width = self.between(8.5, 12.5)
            made.append(self.house(x + 0.5 * width, y + self.between(-0.8, 0.8), facing, width))
            x += width + self.between(*gap)
        return made

    def block(
        self, y: float, yaw: float, reach: float, storeys: tuple[int, int], along_x: bool = True
    ) -> list[House]:
        """Tall houses wall to wall, their fronts at a distance ``y`` from the eye."""
        rng, made, x = self.rng, [], -reach
        while x < reach:
            width, depth = self.between(11.0, 18.0), 11.0
            style = self.style(city=True)
            eaves = int(rng.integers(storeys[0], storeys[1] + 1)) * style.storey + 0.5
            pitch = math.radians(self.between(25.0, 42.0)) if rng.random() < 0.5 else 0.0
            out = 0.5 * depth * np.array([math.sin(yaw), -math.cos(yaw)])
            place = (x + 0.5 * width, y) if along_x else (y, x + 0.5 * width)
            body = width, depth, eaves, pitch, yaw, style, int(rng.integers(1000))
            made.append(House(place[0] - out[0], place[1] - out[1], *body))
            x += width
        return made

    def scattered(
        self, count: int, near: float, far: float, low: float, high: float
    ) -> list[Plant]:
        """Trees anywhere between two distances, most of them in groups."""
        rng = self.rng
        made: list[Plant] = []
        x, y = 0.0, 0.0
        for _ in range(count):
            if rng.random() < _ALONE_SHARE or not made:
                away = math.sqrt(self.between(near**2, far**2))
                angle = self.between(0.0, 2.0 * math.pi)
                x, y = away * math.cos(angle), away * math.sin(angle)
            else:
                x, y = (
                    place + float(rng.normal(0.0, 0.5 * high)) for place in (made[-1].x, made[-1].y)
                )
            if near <= math.hypot(x, y):
                made.append(self.tree(x, y, low, high))
        return made


def _blank(aspect: float) -> Sprite:
    return Sprite(np.zeros((1, 1, 6), dtype=np.float32), aspect)


def _street(plants: PlantPalette) -> Scene:
    """Houses across a road at the front, gardens at the back, neighbours to both sides."""
    rng = plants.rng
    road = plants.between(11.5, 14.5)  # to its middle
    half, walk = plants.between(2.8, 3.4), 2.0
    kerb, back = road + half, -plants.between(15.0, 22.0)
    front = kerb + walk + plants.between(3.5, 6.0)
    things: list[House | Plant | Hedge] = []
    things += plants.row(front, 0.0, (1.5, 5.0), 75.0)
    things += plants.row(2.0 * back - 4.0, math.pi, (3.0, 8.0), 75.0)
    for side in (-1.0, 1.0):
        for place in (1.0, 2.0, 3.0):
            x = side * place * plants.between(15.5, 17.5)
            things.append(plants.house(x, -4.0 + 8.5, math.pi, plants.between(8.5, 10.5)))
    low = road - half - walk
    things += plants.fence(
        (-70.0, kerb + walk), (70.0, kerb + walk), height=plants.between(0.8, 1.4)
    )
    things += plants.fence((-60.0, low - 0.4), (-7.0, low - 0.4), height=1.0)
    things += plants.fence((70.0, back), (-70.0, back), height=plants.between(1.5, 2.1))
    for x in np.arange(-60.0, 60.0, plants.between(11.0, 19.0)).tolist():
        if rng.random() < 0.6:
            things.append(plants.tree(x + plants.between(-3, 3), kerb + 0.5 * walk, 4.5, 7.5))
        if rng.random() < 0.7:
            things.append(plants.tree(x, back + plants.between(-7, 4), 4.0, 9.0))
        things.append(plants.bush(x + plants.between(-4, 4), front - 1.2))
        things.append(plants.bush(x + plants.between(-4, 4), back + 1.5))
    things += plants.scattered(60, 50.0, 130.0, 7.0, 13.0)
    zones = (
        Zone("meadow", _ALL, _ALL),
        Zone("lawn", (-90.0, 90.0), (-60.0, 60.0)),
        Zone("gravel", (-2.2, -0.7), (4.0, low)),
        Zone("paving", (-_FAR, _FAR), (low, low + walk)),
        Zone("kerb", (-_FAR, _FAR), (low + walk - 0.15, low + walk)),
        Zone("asphalt", (-_FAR, _FAR), (low + walk, kerb)),
        Zone("kerb", (-_FAR, _FAR), (kerb, kerb + 0.15)),
        Zone("paving", (-_FAR, _FAR), (kerb + 0.15, kerb + walk)),
        Zone("paving", (-5.0, 5.0), (-7.2, -3.0)),
    )
    ridges = (Ridge(0.004, 0.03, 2200.0, (0.05, 0.065, 0.03), 0.8),)
    return Scene(tuple(things), zones, ridges, 6.5)


def _garden(plants: PlantPalette) -> Scene:
    """A garden within hedges; roofs and trees of others behind them."""
    rng = plants.rng
    front, back = plants.between(12.0, 20.0), -plants.between(8.0, 12.0)
    wide = plants.between(10.0, 15.0)
    tall = plants.between(1.5, 2.1)
    things: list[House | Plant | Hedge] = []
    things += plants.fence(
        (-wide, back), (-wide, front), (wide, front), (wide, back), (-wide, back), height=tall
    )
    for _ in range(9):
        things.append(plants.bush(plants.between(-wide, wide), front - plants.between(1, 2)))
        things.append(
            plants.bush(float(rng.choice((-1, 1))) * (wide - 1.3), plants.between(back, front))
        )
    for _ in range(4):
        things.append(
            plants.tree(plants.between(-wide, wide), front * plants.between(0.6, 1.2), 3.5, 7.5)
        )
    for yaw, y in ((0.0, front + 14.0), (math.pi, back - 20.0)):
        things += [house for house in plants.row(y, yaw, (6.0, 16.0), 60.0) if rng.random() < 0.7]
    for side in (-1.0, 1.0):
        things.append(
            plants.house(
                side * (wide + 9.0), plants.between(-6.0, 8.0), -math.pi / 2.0 * side, 10.0
            )
        )
    things += plants.scattered(22, wide + 6.0, 45.0, 5.0, 10.0)
    things += plants.scattered(90, 50.0, 140.0, 7.0, 14.0)
    zones = (
        Zone("meadow", _ALL, _ALL),
        Zone("lawn", (-70.0, 70.0), (-60.0, 60.0)),
        Zone("bed", (-wide, wide), (front - 2.0, front)),
        Zone("paving", (-4.5, 4.5), (3.0, 7.0)),
    )
    ridges = (
        Ridge(0.015, 0.06, 6000.0, (0.045, 0.06, 0.03), 0.3),
        Ridge(0.004, 0.03, 1800.0, (0.05, 0.066, 0.03), 0.9),
    )
    return Scene(tuple(things), zones, ridges, 6.0)


def _hills(plants: PlantPalette) -> Scene:
    """Open land: meadows, groups of trees, woods and hills in haze."""
    rng = plants.rng
    things: list[House | Plant | Hedge] = []
    things += plants.scattered(5, 14.0, 32.0, 4.0, 9.0)
    things += plants.scattered(60, 40.0, 140.0, 6.0, 13.0)
    things += plants.scattered(150, 150.0, 360.0, 8.0, 15.0)
    for _ in range(5):
        angle, away = plants.between(0.0, 2.0 * math.pi), plants.between(60.0, 160.0)
        things.append(
            plants.house(
                away * math.cos(angle), away * math.sin(angle), plants.between(0.0, math.pi), 11.0
            )
        )
    things += [
        plants.bush(
            plants.between(-14, 14), float(rng.choice((-1, 1)) * rng.uniform(7, 12)), 0.6, 1.4
        )
        for _ in range(8)
    ]
    zones = (
        Zone("meadow", _ALL, _ALL),
        Zone("field", (20.0, 160.0), (70.0, 150.0)),
        Zone("field", (-260.0, -70.0), (-180.0, 60.0)),
        Zone("lawn", (-14.0, 14.0), (-12.0, 12.0)),
        Zone("gravel", (-5.0, 5.0), (2.0, 6.5)),
    )
    ridges = (
        Ridge(0.05, 0.15, 9000.0, (0.05, 0.06, 0.04), 0.1),
        Ridge(0.02, 0.09, 4500.0, (0.048, 0.062, 0.032), 0.35),
        Ridge(0.006, 0.045, 1500.0, (0.055, 0.07, 0.03), 0.9),
    )
    return Scene(tuple(things), zones, ridges, 6.0)


def _city(plants: PlantPalette) -> Scene:
    """A street of tall houses, wall to wall; a courtyard at the back."""
    rng = plants.rng
    front, back = plants.between(15.0, 21.0), -plants.between(17.0, 26.0)
    things: list[House | Plant | Hedge] = []
    things += plants.block(front, 0.0, 90.0, (4, 6))
    things += plants.block(back, math.pi, 60.0, (4, 6))
    for side in (-1.0, 1.0):
        things += [
            house
            for house in plants.block(
                side * 34.0, -side * math.pi / 2.0, 14.0, (4, 5), along_x=False
            )
            if house.y < 8.0
        ]
    kerb = front - 3.2
    for x in np.arange(-70.0, 70.0, plants.between(9.0, 13.0)).tolist():
        if rng.random() < 0.75:
            things.append(plants.tree(x, kerb - 0.4, 6.0, 9.0))
    things += [
        plants.tree(plants.between(-22, 22), plants.between(back + 3, -7), 5.0, 10.0)
        for _ in range(4)
    ]
    zones = (
        Zone("paving", _ALL, _ALL),
        Zone("asphalt", _ALL, (front - 10.5, kerb)),
        Zone("kerb", _ALL, (kerb, kerb + 0.15)),
        Zone("kerb", _ALL, (front - 10.65, front - 10.5)),
        Zone("lawn", (-20.0, 20.0), (back + 2.0, -8.0)),
    )
    return Scene(tuple(things), zones, (Ridge(0.0, 0.02, 3000.0, (0.1, 0.1, 0.1), 0.2),), 17.0)


def _courtyard(plants: PlantPalette) -> Scene:
    """A court that tall houses enclose."""
    rng = plants.rng
    front, back = plants.between(14.0, 22.0), -plants.between(14.0, 20.0)
    wide = plants.between(15.0, 22.0)
    things: list[House | Plant | Hedge] = []
    things += plants.block(front, 0.0, wide + 12.0, (3, 5))
    things += plants.block(back, math.pi, wide + 12.0, (3, 5))
    for side in (-1.0, 1.0):
        things += plants.block(side * wide, -side * math.pi / 2.0, 24.0, (3, 5), along_x=False)
    things += [
        plants.tree(
            plants.between(-wide + 4, wide - 4),
            float(rng.choice((rng.uniform(6, front - 3), rng.uniform(back + 3, -6)))),
            4.5,
            9.0,
        )
        for _ in range(5)
    ]
    things += [plants.bush(plants.between(-wide, wide), front - 1.0) for _ in range(7)]
    zones = (
        Zone("paving", _ALL, _ALL),
        Zone("lawn", (-wide + 4.0, wide - 4.0), (6.0, front - 3.0)),
        Zone("gravel", (-wide + 4.0, wide - 4.0), (back + 3.0, -6.0)),
    )
    return Scene(tuple(things), zones, (), 13.0)


SCENES: Final[Mapping[str, Callable[[PlantPalette], Scene]]] = MappingProxyType(
    {"street": _street, "garden": _garden, "hills": _hills, "city": _city, "courtyard": _courtyard}
)
"""Scenes by name."""
