"""Stages that say the same in another way are the same scene: layers, instances, units, axes.

Scenes are compared by what does not depend on the order of their triangles: their area, its first
and second moments, and how much of it faces where, weighted by colour.
"""

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom

from openrooms_usd.arrays import Array
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.pictures import Picture
from openrooms_usd.usd.places.frames import TIME
from tests.anystage.properties import digest, scene_of
from tests.anystage.stages import random_stage
from tests.anystage.test_any_stage import batches

SEEDS = [seed for batch in batches() for seed in batch]


def moments(scene: Scene) -> Array:
    """(P, 19) of each colour: area, its centre and second moments, and the squares of normals."""
    found: dict[tuple[float, ...], Array] = {}
    for patch in scene.patches:
        value = patch.surface.base_color
        color = value.pixels.reshape(-1, 3).mean(axis=0) if isinstance(value, Picture) else value
        a, b, c = np.moveaxis(patch.triangles.corners, 1, 0)
        crosses = np.cross(b - a, c - a)
        areas = 0.5 * np.linalg.norm(crosses, axis=1)
        middles = (a + b + c) / 3.0
        ways = crosses / np.where(areas > 0.0, 2.0 * areas, 1.0)[:, None]
        rows = [np.ones((len(a), 1)), middles, _squares(middles), _squares(ways), ways]
        sums = (areas[:, None] * np.concatenate(rows, axis=1)).sum(axis=0)
        key = tuple(np.round(np.asarray(color, float), 3))
        found[key] = found.get(key, np.zeros(len(sums))) + sums
    return np.array([found[key] for key in sorted(found)]).reshape(-1, 19)


def _squares(vectors: Array) -> Array:
    products = vectors[:, :, None] * vectors[:, None, :]
    return np.asarray(products[:, [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])


def reach(scene: Scene) -> float:
    return float(np.abs(scene.triangles.hull).max(initial=1e-9))


def assert_alike(one: Scene, other: Scene) -> None:
    first, second = moments(one), moments(other)
    assert first.shape == second.shape
    size = reach(one)
    assert reach(other) == pytest.approx(size, rel=1e-6)
    # By area, and by lengths that the moments are of.
    scale = first[:, :1] * np.array([1.0, *[size] * 3, *[size**2] * 6, *[1.0] * 9])
    assert np.abs(first - second).max(initial=0.0) <= 1e-5 * max(1e-30, scale.max(initial=0.0))
    assert (np.abs(first - second) <= 1e-5 * scale + 1e-30).all()


def copied(stage: Usd.Stage) -> Usd.Stage:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.TransferContent(stage.GetRootLayer())
    return Usd.Stage.Open(layer)


def flattened(stage: Usd.Stage) -> Usd.Stage:
    return Usd.Stage.Open(stage.Flatten())


def layered(stage: Usd.Stage) -> Usd.Stage:
    """All that it says in a layer below; the root has the metadata that only a root can have."""
    top = Sdf.Layer.CreateAnonymous(".usda")
    below = Sdf.Layer.CreateAnonymous(".usda")
    below.TransferContent(stage.GetRootLayer())
    top.subLayerPaths.append(below.identifier)
    found = Usd.Stage.Open(top)
    UsdGeom.SetStageUpAxis(found, UsdGeom.GetStageUpAxis(stage))
    UsdGeom.SetStageMetersPerUnit(found, UsdGeom.GetStageMetersPerUnit(stage))
    found.SetDefaultPrim(found.GetPrimAtPath(stage.GetDefaultPrim().GetPath()))
    return found


def without_instances(stage: Usd.Stage) -> Usd.Stage:
    found = copied(stage)
    while some := [prim for prim in found.Traverse() if prim.IsInstance()]:
        for prim in some:
            prim.SetInstanceable(False)
    return found


def by_matrices(stage: Usd.Stage) -> Usd.Stage:
    """Each stack of operations as one matrix."""
    found = copied(stage)
    for prim in _authored(found):
        shape = UsdGeom.Xformable(prim)
        if shape and shape.GetOrderedXformOps():
            resets = shape.GetResetXformStack()
            matrix = shape.GetLocalTransformation(TIME)
            shape.MakeMatrixXform().Set(matrix)
            shape.SetResetXformStack(resets)
    return found


def _authored(stage: Usd.Stage) -> Iterator[Usd.Prim]:
    """Prims that the root layer says something of: those in instances stay as they are."""
    every = Usd.PrimAllPrimsPredicate
    return (prim for prim in Usd.PrimRange.Stage(stage, every) if not prim.IsInPrototype())


SAME: list[Callable[[Usd.Stage], Usd.Stage]] = [
    copied,
    flattened,
    layered,
    without_instances,
    by_matrices,
]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("change", SAME, ids=lambda change: change.__name__)
def test_the_same_in_another_way_is_the_same(change: Callable[[Usd.Stage], Usd.Stage]) -> None:
    for seed in SEEDS[::5]:
        stage = random_stage(seed)
        expected = scene_of(copied(stage))
        assert_alike(expected, scene_of(change(stage)))


def test_other_units_scale_it() -> None:
    for seed in SEEDS[::5]:
        stage = random_stage(seed)
        before = scene_of(copied(stage))
        larger = copied(stage)
        UsdGeom.SetStageMetersPerUnit(larger, 3.0 * UsdGeom.GetStageMetersPerUnit(stage))
        after = scene_of(larger)
        one, other = moments(before), moments(after)
        factors = np.array([9.0, *[27.0] * 3, *[81.0] * 6, *[9.0] * 9])
        assert one.shape == other.shape
        scale = reach(after)
        sizes = other[:, :1] * np.array([1.0, *[scale] * 3, *[scale**2] * 6, *[1.0] * 9])
        assert (np.abs(one * factors - other) <= 1e-5 * sizes + 1e-30).all()


def test_another_axis_turns_it() -> None:
    for seed in SEEDS[::5]:
        stage = random_stage(seed)
        upright, lying = copied(stage), copied(stage)
        UsdGeom.SetStageUpAxis(upright, "Z")
        UsdGeom.SetStageUpAxis(lying, "Y")
        one, other = scene_of(upright), scene_of(lying)
        # (x, y, z) of the second is (x, z, -y) of the first.
        turned = [
            patch.triangles.corners[..., [0, 2, 1]] * [1.0, 1.0, -1.0] for patch in other.patches
        ]
        for patch, corners in zip(one.patches, turned, strict=True):
            size = np.abs(corners).max(initial=1e-9)
            assert np.abs(patch.triangles.corners - corners).max(initial=0.0) <= 1e-6 * size


def test_an_edit_gives_what_a_clean_translation_gives() -> None:
    """One thing is changed in a stage that was translated already, as an editor does."""

    def hidden(prim: Usd.Prim) -> None:
        UsdGeom.Imageable(prim).MakeInvisible()

    def moved(prim: Usd.Prim) -> None:
        UsdGeom.Xformable(prim).MakeMatrixXform().Set(Gf.Matrix4d().SetTranslate((1, 2, 3)))

    def off(prim: Usd.Prim) -> None:
        prim.SetActive(False)

    def painted(prim: Usd.Prim) -> None:
        for one in Usd.PrimRange(prim):
            if one.IsA(UsdGeom.Gprim):
                UsdGeom.Gprim(one).CreateDisplayColorAttr([Gf.Vec3f(0.9, 0.1, 0.4)])

    for number, seed in enumerate(SEEDS[::4]):
        stage = random_stage(seed)
        scene_of(stage)
        branch = stage.GetPrimAtPath("/World").GetChildren()[0]
        (hidden, moved, off, painted)[number % 4](branch)
        assert digest(scene_of(stage)) == digest(scene_of(copied(stage)))
