"""What hallways hold: pictures on the wall across, and a runner on the floor."""

from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np
from pxr import Gf, Usd, UsdGeom

from openrooms_usd.geometry.hallways import Hallway, door_space
from openrooms_usd.library.furniture import Size, make, part_of, styles
from openrooms_usd.stages.joinery import author_mesh
from openrooms_usd.usd.frames import author_placement
from openrooms_usd.usd.semantics import label

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
