"""What lies behind openings that lead to another part of the house: a lit hallway.

::

    /World/Room/Beyond          Scope
        door_0                  Xform, in the frame of its wall, named as the opening
            Floor               Mesh, like Ceiling, Wall_0, Wall_1, Wall_2, Door, Skirting, Lamp
            Picture_0           Xform, like Runner: parts of things from the library
"""

import math
from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np
from pxr import Gf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.building.hallways import Hallway, Way, door_space, hallway, hallways_behind
from openrooms_usd.furniture import Size, make, part_of, styles
from openrooms_usd.steps.base import StepContext
from openrooms_usd.steps.layout.joinery import author_mesh
from openrooms_usd.steps.layout.openings import Cut
from openrooms_usd.usd.light.emitters import nits_from_lumen, world_area
from openrooms_usd.usd.light.lights import define_mesh_light
from openrooms_usd.usd.places.frames import author_placement
from openrooms_usd.usd.semantics import label

# Where the door across stands, from the left to the right.
_DOORS: Final = (0.08, 0.3, 0.5, 0.7, 0.92)
_LUMEN, _KELVIN = 800.0, 3000.0
# Free wall beside a picture, and the middle of pictures above the floor, metres.
_MARGIN_M: Final = 0.12
_EYE_LEVEL_M: Final = 1.5
# A picture's largest width, how thick it is, and which walls are too narrow for one; metres.
_PICTURE_M: Final = (0.62, 0.022)
_LEAST_M: Final = 0.45
_PICTURE_SHARE, _RUNNER_SHARE = 0.7, 0.55
# Width and thickness of a runner, and the floor before its ends; metres.
_RUNNER_M: Final = (0.75, 0.008)
_BEFORE_M: Final = 0.3
_RUNNERS: Final = frozenset({"bordered", "fringed", "runner"})


class Decoration(NamedTuple):
    """A thing in a hallway.

    Attributes:
        name: Of its prim.
        category: What it is.
        size: Metres.
        at: The middle of its base in the frame of the wall, metres.
    """

    name: str
    category: str
    size: Size
    at: tuple[float, float, float]


def decor(size: Hallway, rng: np.random.Generator) -> Iterator[Decoration]:
    """What a hallway holds, drawn."""
    thick = _PICTURE_M[1]
    low, high = door_space(size) or (size.right, size.right)
    for number, (left, right) in enumerate(((size.left, low), (high, size.right))):
        space = right - left - 2.0 * _MARGIN_M
        if space < _LEAST_M - 2.0 * _MARGIN_M or rng.random() > _PICTURE_SHARE:
            continue
        wide = min(space, _PICTURE_M[0] * float(rng.uniform(0.7, 1.0)))
        tall = wide * float(rng.choice((0.75, 1.0, 1.35)))
        middle = 0.5 * (left + right)
        at = (middle, size.far - 0.5 * thick - 0.002, _EYE_LEVEL_M - 0.5 * tall)
        yield Decoration(f"Picture_{number}", "picture", (wide, thick, tall), at)
    long = size.right - size.left - 2.0 * _BEFORE_M
    deep = min(_RUNNER_M[0], size.far - size.near - _BEFORE_M)
    if long > 1.0 and rng.random() < _RUNNER_SHARE:
        at = (0.5 * (size.left + size.right), 0.5 * (size.near + size.far), 0.0)
        yield Decoration("Runner", "rug", (long, deep, _RUNNER_M[1]), at)


def author_decor(stage: Usd.Stage, path: str, size: Hallway, rng: np.random.Generator) -> None:
    """Write what a hallway holds below its prim."""
    for thing in decor(size, rng):
        prim = UsdGeom.Xform.Define(stage, f"{path}/{thing.name}").GetPrim()
        author_placement(prim, Gf.Vec3d(*thing.at), 0.0)
        label(prim, thing.category)
        known = styles(thing.category, thing.size)
        if thing.category == "rug":
            known = tuple(name for name in known if name in _RUNNERS) or known
        style = known[int(rng.integers(len(known)))]
        for name, mesh in make(thing.category, thing.size, style, rng).parts.items():
            author_mesh(stage, f"{prim.GetPath()}/{name}", mesh, part=part_of(name))


def author_beyond(context: StepContext, corners: Array, cuts: Sequence[Cut]) -> None:
    """Build a hallway behind each opening that leads to one and can be looked through.

    Args:
        context: Of the layout step; its notes receive a sentence for each that has no space.
        corners: (N, 2) the room's floor, counter-clockwise, metres.
        cuts: All openings.
    """
    sizes = hallways_behind(corners, [_way(cut) for cut in cuts])
    for cut, size in zip(cuts, sizes, strict=True):
        if not _leads(cut):
            continue
        if size is None:
            context.notes.append(f"{cut.name}: no space for a hallway behind it; it leads outside")
            continue
        rng = context.rng("layout", "beyond", cut.name)
        _author(context.stage, cut, size._replace(door=float(rng.choice(_DOORS))), rng)


def _leads(cut: Cut) -> bool:
    """Whether a hallway is to be seen through an opening."""
    seen = cut.kind != "door" or cut.open > 0.0 or cut.style in names.SEE_THROUGH
    return seen and cut.beyond == "hallway" and not cut.wall.partition


def _way(cut: Cut) -> Way:
    swings_out = cut.kind == "door" and cut.swing == "out" and cut.open > 0.0
    leaf = cut.hole.right - cut.hole.left if swings_out else 0.0
    return Way(cut.wall, cut.hole, cut.kind == "window", _leads(cut), leaf)


def _author(stage: Usd.Stage, cut: Cut, size: Hallway, rng: np.random.Generator) -> None:
    UsdGeom.Scope.Define(stage, names.BEYOND)
    path = f"{names.BEYOND}/{cut.name}"
    prim = UsdGeom.Xform.Define(stage, path).GetPrim()
    heading = math.degrees(math.atan2(cut.wall.along[1], cut.wall.along[0]))
    author_placement(prim, Gf.Vec3d(*cut.wall.left.tolist(), 0.0), heading)
    for name, category, mesh in hallway(size):
        part = names.LIGHT_BULB if category == "ceiling_lamp" else ""
        author_mesh(stage, f"{path}/{name}", mesh, category=category, part=part)
    author_decor(stage, path, size, rng)


def author_beyond_lamps(stage: Usd.Stage) -> None:
    """Light the hallways; in the layer of the lights."""
    beyond = stage.GetPrimAtPath(names.BEYOND)
    for place in beyond.GetChildren() if beyond else ():
        lamp = place.GetChild("Lamp")
        if lamp and lamp.IsActive() and (area := world_area(lamp)) > 0.0:
            over = stage.OverridePrim(lamp.GetPath())
            define_mesh_light(over, nits=nits_from_lumen(_LUMEN, area), kelvin=_KELVIN)
