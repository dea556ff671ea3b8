"""Near things as meshes with their reflectance: plants, houses, and what is at windows.

All of it is lit by the sun and the sky of the panorama, so it carries no light of its own. The
frame is that of the scene, with the land at z = 0.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.library.surroundings.outside.daylight import LAND_SHARE, Daylight
from openrooms_usd.library.surroundings.outside.facades import FacadeMaterials
from openrooms_usd.library.surroundings.outside.faces import Face, Hit, World
from openrooms_usd.library.surroundings.outside.foliage import HEDGE_DEEP, HEDGE_LONG, SHADES
from openrooms_usd.library.surroundings.outside.houses import House
from openrooms_usd.library.surroundings.outside.near import Near
from openrooms_usd.library.surroundings.outside.noise import Floats
from openrooms_usd.library.surroundings.outside.plants import Hedge, Plant
from openrooms_usd.library.surroundings.outside.shadows import Shadows

_HOUSE_PIXEL_M: Final = 0.04
_MOST_PIXELS: Final = 400
# Under an even sky of this a face shows its reflectance; lamps behind its windows are nothing.
_EVEN_NITS: Final = 1e6
_WOOD: Final = (0.085, 0.07, 0.055)
# What leaves send through themselves is added to what they send back.
_LEAF_GAIN: Final = 1.35
# Of leaves within a crown and outside, as parts of their reflectance.
_SHADE_RANGE: Final = (0.35, 1.45)
# Leaves whose colours differ by less than about this part look alike.
_COLOR_STEP: Final = 0.22


@dataclass(frozen=True, eq=False)
class Reflectance:
    """What a surface reflects.

    Attributes:
        albedo: (3,) or (H, W, 3), scene-linear Rec.709, the first row on top.
        passes: What a sheet of it lets straight through, by primary; None where it is opaque.
    """

    albedo: Floats
    passes: tuple[float, float, float] | None = None


@dataclass(frozen=True, eq=False)
class SolidPart:
    """A mesh that stands once.

    Attributes:
        thing: The thing that it is part of.
        name: Its name there.
        category: Of the thing.
        mesh: In the frame of the scene; texture coordinates of its look's picture.
        look: The name of its look.
    """

    thing: str
    name: str
    category: str
    mesh: Mesh
    look: str


@dataclass(frozen=True, eq=False)
class PlacedSolid:
    """A plant of `foliage.PLANTS` somewhere.

    Attributes:
        name: Its name.
        kind: Which plant.
        category: What it is.
        matrix: (4, 4) from the plant's frame to that of the scene.
        look: The name of the look of its leaves.
    """

    name: str
    kind: str
    category: str
    matrix: Array
    look: str


@dataclass
class Solid:
    """Near things as meshes.

    Attributes:
        parts: What stands once.
        placed: Plants.
        looks: What they look like, by name.
    """

    parts: list[SolidPart] = field(default_factory=list)
    placed: list[PlacedSolid] = field(default_factory=list)
    looks: dict[str, Reflectance] = field(default_factory=dict)


WOOD: Final = "Wood"
"""The look of stems."""


def solid(near: Near, surfaces: FacadeMaterials, rng: np.random.Generator) -> Solid:
    """Make the meshes.

    Args:
        near: What is near.
        surfaces: The patterns of the scene.
        rng: Turns plants.
    """
    made = Solid(looks={WOOD: Reflectance(np.array(_WOOD))})
    for number, plant in enumerate(near.plants):
        made.placed.append(_plant(made, plant, number, rng))
    for number, piece in enumerate(_pieces(near.hedges)):
        made.placed.append(_hedge(made, *piece, number))
    for number, house in enumerate(near.houses):
        _add_house(made, house, f"House_{number}", surfaces)
    return made


def _leaves(made: Solid, albedo: Floats) -> str:
    """The look of leaves of about a colour: few differ, so that few pictures are kept."""
    coarse = np.exp(np.round(np.log(albedo) / _COLOR_STEP) * _COLOR_STEP)
    known = [name for name in made.looks if name.startswith("Leaves")]
    shades = np.geomspace(*_SHADE_RANGE, SHADES)[None, :, None] * _LEAF_GAIN
    for name in known:
        if np.allclose(made.looks[name].albedo, coarse * shades):
            return name
    name = f"Leaves_{len(known)}"
    made.looks[name] = Reflectance(
        np.broadcast_to(coarse * shades, (1, SHADES, 3)).astype(np.float32)
    )
    return name


def _plant(made: Solid, plant: Plant, number: int, rng: np.random.Generator) -> PlacedSolid:
    aspect = plant.sprite.aspect
    kind = "bush" if plant.trunk == 0.0 else "fir" if aspect < 0.5 else "tree"
    # The mesh is as wide as it is high times its own aspect.
    wide = aspect / {"bush": 1.25, "fir": 0.46, "tree": 0.78}[kind] * plant.height
    turn = float(rng.uniform(0.0, 2.0 * math.pi))
    c, s = math.cos(turn) * wide, math.sin(turn) * wide
    matrix = np.array(
        [[c, -s, 0, plant.x], [s, c, 0, plant.y], [0, 0, plant.height, 0], [0, 0, 0, 1.0]]
    )
    category = "bush" if kind == "bush" else "tree"
    name = f"{category.capitalize()}_{number}"
    return PlacedSolid(name, kind, category, matrix, _leaves(made, plant.albedo))


def _pieces(hedges: Iterable[Hedge]) -> Iterator[tuple[Hedge, Floats, Floats]]:
    """Each hedge in pieces: their starts and ends."""
    for hedge in hedges:
        a, b = np.array(hedge.start), np.array(hedge.end)
        count = max(1, round(float(np.linalg.norm(b - a)) / (HEDGE_LONG * hedge.height)))
        ends = a + np.linspace(0.0, 1.0, count + 1)[:, None] * (b - a)
        for start, end in pairwise(ends):
            yield hedge, start, end


def _hedge(made: Solid, hedge: Hedge, start: Floats, end: Floats, number: int) -> PlacedSolid:
    step = end - start
    along = step / HEDGE_LONG
    out = np.array([step[1], -step[0]]) / np.linalg.norm(step)
    deep = out * hedge.height
    # The picture of it stands at its near side.
    middle = 0.5 * (start + end) - 0.5 * HEDGE_DEEP * deep
    matrix = np.eye(4)
    matrix[:2, 0], matrix[:2, 1] = along, -deep
    matrix[2, 2], matrix[:2, 3] = hedge.height, middle
    return PlacedSolid(f"Hedge_{number}", "hedge", "hedge", matrix, _leaves(made, hedge.albedo))


def _add_house(made: Solid, house: House, name: str, surfaces: FacadeMaterials) -> None:
    world = even_light()
    for number, face in enumerate(house.faces(0.0, surfaces)):
        look = f"{name}_{number}"
        mesh, st = _polygon(face)
        made.looks[look] = Reflectance(painted(face, world, st))
        made.parts.append(SolidPart(name, f"Face_{number}", "house", mesh, look))


def even_light() -> World:
    """An even sky over land that is as bright, without a sun."""
    sky, dark = (np.full((30, 120, 3), nits, np.float32) for nits in (_EVEN_NITS, 0.0))
    above, land = np.array([0.0, 0.0, 1.0]), np.full(3, 1.0 / LAND_SHARE)
    return World(Daylight(sky, dark, above, np.zeros(3), land), Shadows(), 0.0)


def _polygon(face: Face) -> tuple[Mesh, Floats]:
    """A face as one polygon, and (2, 2) the range of u and v that its picture covers."""
    low, high = face.outline.min(axis=0), face.outline.max(axis=0)
    points = face.origin + face.outline[:, :1] * face.first + face.outline[:, 1:] * face.second
    count = len(points)
    normal = np.cross(face.first, face.second).astype(np.float32)
    mesh = Mesh(
        points.astype(np.float64),
        np.array([count], np.int32),
        np.arange(count, dtype=np.int32),
        np.tile(normal, (count, 1)),
        ((face.outline - low) / (high - low)).astype(np.float32),
    )
    return mesh, np.stack([low, high])


def painted(face: Face, world: World, covered: Floats) -> Floats:
    """(H, W, 3) reflectance of a face: what it shows under an even light, as a part of that.

    Args:
        face: The face.
        world: Of `even_light`.
        covered: (2, 2) the range of u and v that the picture covers.
    """
    size = covered[1] - covered[0]
    columns, rows = np.clip(np.ceil(size / _HOUSE_PIXEL_M), 2, _MOST_PIXELS).astype(int).tolist()
    u = (covered[0, 0] + (np.arange(columns) + 0.5) / columns * size[0]).astype(np.float32)[None, :]
    v = (covered[1, 1] - (np.arange(rows) + 0.5) / rows * size[1]).astype(np.float32)[:, None]
    u, v = (item.ravel() for item in np.broadcast_arrays(u, v))
    x, y, z = (face.origin[i] + u * face.first[i] + v * face.second[i] for i in range(3))
    normal = np.cross(face.first, face.second).astype(np.float32)
    hit = Hit(world, u, v, x, y, z, _HOUSE_PIXEL_M, normal, face.first)
    nits, _ = face.paint(hit)
    albedo = np.clip(nits / _EVEN_NITS, 0.0, 1.0).reshape(rows, columns, 3)
    return np.asarray(albedo, dtype=np.float32)
