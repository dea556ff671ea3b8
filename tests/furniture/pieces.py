"""What the library makes: each style in its usual size, built once for all tests that look."""

from functools import cache

import numpy as np

from openrooms_usd.furniture import CATEGORIES, Furniture, Parts, Size, make, part_of
from openrooms_usd.furniture.joinery.pieces import fitted
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.raycast import RayCaster

STYLES = [(name, style) for name, spec in CATEGORIES.items() for style in spec.styles]


def usual(name: str, style: str) -> Size:
    """The usual size of a style, metres."""
    return CATEGORIES[name].styles[style].size or CATEGORIES[name].size


@cache
def planned(name: str, style: str) -> Furniture:
    """A style as its builder leaves it, by the first seed."""
    made = CATEGORIES[name].styles[style].build(usual(name, style), np.random.default_rng(0))
    return made if isinstance(made, Furniture) else Furniture(made)


@cache
def piece(name: str, style: str) -> Furniture:
    """A style as `make` gives it, by the first seed."""
    return fitted(planned(name, style), usual(name, style))


def made(name: str, style: str, seed: int = 0, size: Size | None = None) -> Furniture:
    """A style by some seed, in its usual size or another, metres."""
    return make(name, size or usual(name, style), style, np.random.default_rng(seed))


def parts_of(parts: Parts, *kinds: str) -> Parts:
    """The parts of some kinds."""
    return {name: mesh for name, mesh in parts.items() if part_of(name) in kinds}


def caster(*meshes: Mesh) -> RayCaster:
    """What finds the first of some meshes along a ray."""
    whole = joined(meshes)
    return RayCaster(whole.points, whole.indices[whole.triangles()[0]])
