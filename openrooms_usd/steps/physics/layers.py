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

# Bases that differ by less are held by the same thing; one that is higher stands on the layer.
_LEVEL_M: Final = 1e-3


def pass_layers(stage: Usd.Stage, roots: Sequence[Usd.Prim]) -> None:
    """Let layers pass through what stands in them at the same height.

    A bed half on a rug then stands on the floor; what stands on the rug, such as a table, and what
    carries a layer, such as the desk below a sheet, go on doing so.

    Args:
        stage: Its edit target receives the pairs.
        roots: The objects.
    """
    layers = [root for root in roots if lies_under(read_label(root, names.CATEGORY) or "")]
    if not layers:
        return
    cache = UsdGeom.BBoxCache(TIME, [UsdGeom.Tokens.default_])
    boxes = {root.GetPath(): _box(root, cache) for root in roots}
    found: dict[Sdf.Path, list[Sdf.Path]] = {}
    for layer in (root.GetPath() for root in layers):
        beside = [path for path in boxes if path != layer and path not in found]
        found[layer] = [path for path in beside if _reaches_in(boxes[path], boxes[layer])]
    for layer, inside in found.items():
        if inside:
            keep_apart(stage.OverridePrim(layer), inside)


def _box(root: Usd.Prim, cache: UsdGeom.BBoxCache) -> Array:
    found = cache.ComputeWorldBound(root).ComputeAlignedRange()
    return np.array([found.GetMin(), found.GetMax()])


def _reaches_in(box: Array, layer: Array) -> bool:
    """Whether both stand at one height, in the same place."""
    plan = (box[0, :2] < layer[1, :2]).all() and (box[1, :2] > layer[0, :2]).all()
    return bool(plan and abs(box[0, 2] - layer[0, 2]) < _LEVEL_M)
