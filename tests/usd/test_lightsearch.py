"""Lights wherever they are: in instances, and where point instancers place them."""

from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.light.lights import SphereLight, define_mesh_light, read_lights


@pytest.fixture
def stage() -> Usd.Stage:
    made = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(made, "Z")
    UsdGeom.SetStageMetersPerUnit(made, 1.0)
    return made


def ball(stage: Usd.Stage, path: str, radius: float = 0.1) -> UsdLux.SphereLight:
    light = UsdLux.SphereLight.Define(stage, path)
    light.CreateRadiusAttr(radius)
    light.AddTranslateOp().Set((0, 0, 1))
    return light


def scatter(stage: Usd.Stage, path: str, targets: list[str], places: Any, **said: Any) -> Any:
    made = UsdGeom.PointInstancer.Define(stage, path)
    made.CreatePrototypesRel().SetTargets(targets)
    made.CreateProtoIndicesAttr(said.get("which", [0] * len(places)))
    made.CreatePositionsAttr([Gf.Vec3f(*map(float, place)) for place in places])
    return made


def test_they_shine_where_the_instancer_places_them(stage: Usd.Stage) -> None:
    UsdGeom.Xform.Define(stage, "/Set/Proto").AddTranslateOp().Set((0, 5, 0))
    ball(stage, "/Set/Proto/Ball")
    made = scatter(stage, "/Set", ["/Set/Proto"], [(0, 0, 0), (2, 0, 0), (4, 0, 0)])
    made.CreateScalesAttr([Gf.Vec3f(1), Gf.Vec3f(2), Gf.Vec3f(1)])
    made.AddTranslateOp().Set((0, 0, 10))
    found = read_lights(stage)
    assert [light.path for light in found] == [f"/Set[{k}]/Ball" for k in range(3)]
    assert {light.prim for light in found} == {"/Set/Proto/Ball"}
    places = np.array([light.world_from_light[:3, 3] for light in found])
    # The prototype's own place counts, and the instance's factor acts on it.
    assert places == pytest.approx(np.array([(0, 5, 11), (2, 10, 12), (4, 5, 11)]))
    assert np.linalg.norm(found[1].world_from_light[:3, 0]) == pytest.approx(2.0)


def test_they_are_in_the_scene_and_in_its_report(stage: Usd.Stage) -> None:
    ball(stage, "/Set/Ball")
    scatter(stage, "/Set", ["/Set/Ball"], [(0, 0, 0), (3, 0, 0)])
    scene = translate(stage)
    middles = [patch.triangles.hull.mean(axis=0) for patch in scene.patches]
    assert np.array(middles) == pytest.approx(np.array([(0, 0, 1), (3, 0, 1)]), abs=1e-3)
    assert {patch.lamp for patch in scene.patches} == {"/Set[0]", "/Set[1]"}
    assert {("/Set[0]", "translated", ""), ("/Set[1]", "translated", "")} <= set(scene.report.rows)


def test_nested_and_masked_ones(stage: Usd.Stage) -> None:
    ball(stage, "/Set/Inner/Ball")
    scatter(stage, "/Set/Inner", ["/Set/Inner/Ball"], [(0, 0, 0), (1, 0, 0)])
    outer = scatter(stage, "/Set", ["/Set/Inner"], [(0, 0, 0), (10, 0, 0), (20, 0, 0)])
    outer.CreateInvisibleIdsAttr([1])
    found = {light.path: light.world_from_light[:3, 3].tolist() for light in read_lights(stage)}
    assert found == {
        f"/Set[{i}][{j}]": pytest.approx([10.0 * i + j, 0.0, 1.0]) for i in (0, 2) for j in (0, 1)
    }


def test_prototypes_may_be_hidden_classes_elsewhere(stage: Usd.Stage) -> None:
    stage.CreateClassPrim("/Library")
    ball(stage, "/Library/Lamp/Ball")
    scatter(stage, "/Set", ["/Library/Lamp"], [(1, 2, 3)])
    (light,) = read_lights(stage)
    assert light.world_from_light[:3, 3] == pytest.approx((1.0, 2.0, 4.0))
    scope = UsdGeom.Scope.Define(stage, "/Hidden")
    scope.CreateVisibilityAttr("invisible")
    ball(stage, "/Hidden/Lamp/Ball")
    scatter(stage, "/Other", ["/Hidden/Lamp"], [(0, 0, 0)])
    assert [light.path for light in read_lights(stage)] == ["/Set[0]/Ball", "/Other[0]/Ball"]
    UsdGeom.Imageable(stage.GetPrimAtPath("/Hidden/Lamp/Ball")).CreateVisibilityAttr("invisible")
    UsdGeom.Imageable(stage.GetPrimAtPath("/Set")).CreateVisibilityAttr("invisible")
    assert read_lights(stage) == []


def test_instances_of_instances_with_an_instancer_inside(stage: Usd.Stage) -> None:
    stage.CreateClassPrim("/_lamp")
    UsdGeom.Xform.Define(stage, "/_lamp/Rail")
    ball(stage, "/_lamp/Rail/Set/Ball")
    scatter(stage, "/_lamp/Rail/Set", ["/_lamp/Rail/Set/Ball"], [(0, 0, 0), (1, 0, 0)])
    for number in range(2):
        prim = UsdGeom.Xform.Define(stage, f"/Lamp_{number}")
        prim.AddTranslateOp().Set((0, 10 * number, 0))
        prim.GetPrim().GetReferences().AddInternalReference("/_lamp")
        prim.GetPrim().SetInstanceable(True)
    places = sorted(light.world_from_light[:3, 3].tolist() for light in read_lights(stage))
    assert places == [pytest.approx([x, y, 1.0]) for x in (0.0, 1.0) for y in (0.0, 10.0)]


def test_shapes_that_shine_are_read_once_and_drawn_everywhere(stage: Usd.Stage) -> None:
    cube = UsdGeom.Cube.Define(stage, "/Set/Cube")
    define_mesh_light(cube.GetPrim(), nits=7.0)
    made = scatter(stage, "/Set", ["/Set/Cube"], [(0, 0, 0), (5, 0, 0), (9, 0, 0)])
    made.CreateInvisibleIdsAttr([0])
    assert [light.path for light in read_lights(stage)] == ["/Set/Cube"]
    lamps = [patch for patch in translate(stage).patches if patch.radiance is not None]
    assert len(lamps) == 2


def test_an_instancer_in_its_own_prototype_ends(stage: Usd.Stage) -> None:
    ball(stage, "/Set/Proto/Ball")
    scatter(stage, "/Set", ["/Set/Proto"], [(0, 0, 0)])
    inner = UsdGeom.PointInstancer.Define(stage, "/Set/Proto/Again")
    inner.CreatePrototypesRel().SetTargets([Sdf.Path("/Set")])
    inner.CreateProtoIndicesAttr([0])
    inner.CreatePositionsAttr([Gf.Vec3f(0)])
    assert all(isinstance(light, SphereLight) for light in read_lights(stage))
