"""What is seen of a prim of any scene: its surfaces, their box, and the objects they are of."""

from functools import partial
from typing import Final

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.channels import CLASS_CHANNELS
from openrooms_usd.usd.arrays import array_of
from openrooms_usd.usd.places.frames import TIME, local_to_world, world_from_stage

_PROXIES: Final = Usd.TraverseInstanceProxies()
_DRAWN: Final = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)
_LABELS: Final = frozenset(
    f"SemanticsLabelsAPI:{kind}" for kind in (names.CATEGORY, *CLASS_CHANNELS)
)


def owners_of(root: Usd.Prim) -> list[Usd.Prim]:
    """The objects that the surfaces below a prim are parts of, each once."""
    found = {owner.GetPath(): owner for owner in map(_owner, surfaces_of(root))}
    return list(found.values())


def _owner(prim: Usd.Prim) -> Usd.Prim:
    chain = [prim]
    while not chain[-1].GetParent().IsPseudoRoot():
        chain.append(chain[-1].GetParent())
    labelled = (one for one in chain if not _LABELS.isdisjoint(one.GetAppliedSchemas()))
    return next(labelled, None) or next(filter(Usd.Prim.IsComponent, chain), prim)


def surfaces_of(root: Usd.Prim) -> list[Usd.Prim]:
    """What is drawn of a prim and all below it; of point instancers the whole."""
    found = []
    walk = iter(Usd.PrimRange(root, _PROXIES))
    for prim in walk:
        shown = UsdGeom.Imageable(prim)
        if shown and shown.GetVisibilityAttr().Get(TIME) == UsdGeom.Tokens.invisible:
            walk.PruneChildren()
        elif prim.IsA(UsdGeom.PointInstancer):
            walk.PruneChildren()
            found.append(prim)
        elif prim.IsA(UsdGeom.Gprim) and shown.ComputePurpose() in _DRAWN:
            found.append(prim)
    return found


def points_of(root: Usd.Prim) -> Array:
    """(N, 3) points of the world, metres, in whose box all that is seen of a prim lies."""
    cache, boxes = UsdGeom.XformCache(TIME), UsdGeom.BBoxCache(TIME, list(_DRAWN))
    world = world_from_stage(root.GetStage())
    placed = partial(_placed, world=world, cache=cache, boxes=boxes)
    return np.concatenate([np.zeros((0, 3)), *map(placed, surfaces_of(root))])


def _placed(
    prim: Usd.Prim, world: Array, cache: UsdGeom.XformCache, boxes: UsdGeom.BBoxCache
) -> Array:
    """(N, 3) points of one surface in the world: of a mesh its own, of others their box."""
    points = np.zeros((0, 3))
    if prim.IsA(UsdGeom.PointBased) and not prim.IsA(UsdGeom.Curves):
        points = array_of(UsdGeom.PointBased(prim).GetPointsAttr().Get(TIME), np.float64, 3)
    if not len(points):
        box = boxes.ComputeUntransformedBound(prim).ComputeAlignedRange()
        points = (
            np.zeros((0, 3))
            if box.IsEmpty()
            else np.array([list(box.GetCorner(i)) for i in range(8)])
        )
    M = world @ local_to_world(prim, cache)
    return np.asarray(points @ M[:3, :3].T + M[:3, 3])


def extent_of(points: Array) -> Array:
    """(2, 3) least and greatest coordinates of (N, 3) points; not a number of none."""
    if not len(points):
        return np.full((2, 3), np.nan)
    return np.stack([points.min(axis=0), points.max(axis=0)])
