"""Rugs, blankets and other layers, which lie under things without lifting them."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from pxr import Sdf, Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.library.construction import lies_under
from openrooms_usd.usd.bodies import keep_apart
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.semantics import read_label

# What reaches less far into a layer stands on it, metres.
_STANDS_ON_M: Final = 1e-3


def pass_layers(stage: Usd.Stage, roots: Sequence[Usd.Prim]) -> None:
    """Let layers pass through what stands in them and is held by what holds them too.

    A bed half on a rug then stands on the floor; what stands on the rug alone, such as a table
    whose carrier it is, goes on doing so.

    Args:
        stage: Its edit target receives the pairs.
        roots: The objects.
    """
    layers = [root for root in roots if lies_under(read_label(root, names.CATEGORY) or "")]
    if not layers:
        return
    cache = UsdGeom.BBoxCache(TIME, [UsdGeom.Tokens.default_])
    boxes = {root.GetPath(): _box(root, cache) for root in roots}
    held = {root.GetPath(): _held_by(root) for root in roots}
    found: dict[Sdf.Path, list[Sdf.Path]] = {}
    for layer in (root.GetPath() for root in layers):
        beside = [p for p in held if p != layer and p not in found and held[p] == held[layer]]
        found[layer] = [path for path in beside if _reaches_in(boxes[path], boxes[layer])]
    for layer, inside in found.items():
        if inside:
            keep_apart(stage.OverridePrim(layer), inside)


def _box(root: Usd.Prim, cache: UsdGeom.BBoxCache) -> Array:
    found = cache.ComputeWorldBound(root).ComputeAlignedRange()
    return np.array([found.GetMin(), found.GetMax()])


def _held_by(root: Usd.Prim) -> tuple[str, ...]:
    """What carries an object: a word of the alignment, and the prims that it names."""
    said = root.GetAttribute(names.ALIGNMENT_SUPPORT)
    carrier = root.GetRelationship(names.ALIGNMENT_CARRIER)
    return (str(said.Get() if said else ""), *map(str, carrier.GetTargets() if carrier else ()))


def _reaches_in(box: Array, layer: Array) -> bool:
    plan = (box[0, :2] < layer[1, :2]).all() and (box[1, :2] > layer[0, :2]).all()
    return bool(plan and box[0, 2] < layer[1, 2] - _STANDS_ON_M and box[1, 2] > layer[0, 2])
