"""What points, curves, patches and instances say of themselves: colours and opacity, one by one."""

from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd.rendering.scene.pictures import Picture, evaluate
from openrooms_usd.rendering.scene.translate import translate
from tests import small
from tests.rendering.scene.test_painted import FACES, POINTS, affine, floor, seen

COLORS = [(0.8, 0.1, 0.1), (0.1, 0.7, 0.1), (0.1, 0.1, 0.9), (0.6, 0.6, 0.1)]


def vectors(rows: Any) -> list[Gf.Vec3f]:
    return [Gf.Vec3f(*map(float, row)) for row in rows]


def say(prim: Any, name: str, kind: Sdf.ValueTypeName, interpolation: str, values: Any) -> None:
    UsdGeom.PrimvarsAPI(prim).CreatePrimvar(name, kind, interpolation).Set(values)


def colors(prim: Any, interpolation: str, rows: Any) -> None:
    say(prim, "displayColor", Sdf.ValueTypeNames.Color3fArray, interpolation, vectors(rows))


def at_corners(stage: Usd.Stage, field: str = "base_color") -> tuple[np.ndarray, np.ndarray]:
    """(N, 3) corners of all triangles, and (N, C) what a field of their surface is there."""
    scene = translate(stage)
    places, values = [], []
    for patch in scene.patches:
        value = getattr(patch.surface, field)
        st = patch.triangles.st.astype(np.float64).reshape(-1, 2)
        if isinstance(value, Picture):
            values.append(evaluate(value, st, value.channels))
        else:
            values.append(np.tile(np.atleast_1d(value), (len(st), 1)))
        places.append(patch.triangles.corners.reshape(-1, 3))
    return np.concatenate(places), np.concatenate(values)


def test_each_point_of_a_cloud_has_its_color() -> None:
    made = small.Stage()
    cloud = UsdGeom.Points.Define(made.stage, "/Cloud")
    where = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)], dtype=float)
    cloud.CreatePointsAttr(vectors(where))
    cloud.CreateWidthsAttr([0.2, 0.0, 0.2, 0.2])
    colors(cloud, "vertex", COLORS)
    at, found = at_corners(made.stage)
    # The one without a size is not there, and shifts nobody's colour.
    nearest = np.abs(at[:, None] - where).sum(axis=2).argmin(axis=1)
    assert set(nearest) == {0, 2, 3}
    assert np.abs(found - np.array(COLORS)[nearest]).max() < 2e-3


def test_curves_change_along_their_length() -> None:
    made = small.Stage()
    curves = UsdGeom.BasisCurves.Define(made.stage, "/Hair")
    curves.CreateTypeAttr("linear")
    points = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1, 0)], dtype=float)
    curves.CreatePointsAttr(vectors(points))
    curves.CreateCurveVertexCountsAttr([3, 2])
    curves.CreateWidthsAttr([0.1])
    colors(curves, "vertex", affine(points))
    at, found = at_corners(made.stage)
    axis = at * [1, 0, 0] + np.round(at * [0, 1, 0])
    assert np.abs(found - affine(axis)).max() < 2e-3


def test_each_curve_has_its_color() -> None:
    made = small.Stage()
    curves = UsdGeom.BasisCurves.Define(made.stage, "/Hair")
    curves.CreateBasisAttr("catmullRom")
    points = [(i, j, 0) for j in range(4) for i in range(5)]
    curves.CreatePointsAttr(vectors(points))
    # The second is too short for its basis, and is left out with its colour.
    curves.CreateCurveVertexCountsAttr([5, 3, 7, 5])
    curves.CreateWidthsAttr([0.1])
    colors(curves, "uniform", COLORS)
    _, found = at_corners(made.stage)
    kinds = np.unique(found.round(2), axis=0)
    assert sorted(map(tuple, kinds.tolist())) == sorted(COLORS[i] for i in (0, 2, 3))


def test_patches_and_tetrahedra_have_those_of_their_points() -> None:
    made = small.Stage()
    body = UsdGeom.TetMesh.Define(made.stage, "/Body")
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    body.CreatePointsAttr(vectors(points))
    body.CreateTetVertexIndicesAttr([Gf.Vec4i(0, 1, 2, 3)])
    colors(body, "vertex", affine(points))
    patch = UsdGeom.NurbsPatch.Define(made.stage, "/Patch")
    square = np.array([(0, 0, 5), (1, 0, 5), (0, 1, 5), (1, 1, 5)], dtype=float)
    patch.CreatePointsAttr(vectors(square))
    for name, value in (("VertexCount", 2), ("Order", 2), ("Knots", [0.0, 0.0, 1.0, 1.0])):
        for side in "uv":
            patch.GetPrim().GetAttribute(f"{side}{name}").Set(value)
    colors(patch, "vertex", affine(square))
    at, found = at_corners(made.stage)
    assert np.abs(found - affine(at)).max() < 2e-3


def test_one_value_is_that_of_all_whatever_its_interpolation() -> None:
    for interpolation in ("vertex", "uniform", "faceVarying", "varying"):
        made = small.Stage()
        mesh = made.mesh("/floor", POINTS, FACES)
        colors(mesh, interpolation, COLORS[:1])
        _, found = at_corners(made.stage)
        assert np.abs(found - COLORS[0]).max() < 1e-6, interpolation


def test_colors_that_are_no_array_are_taken() -> None:
    made = small.Stage()
    made.mesh("/floor", POINTS, FACES)
    # As some exporters write it; USD's own interface would refuse to.
    spec = made.stage.GetRootLayer().GetPrimAtPath("/floor")
    kind = Sdf.ValueTypeNames.Color3f
    Sdf.AttributeSpec(spec, "primvars:displayColor", kind).default = Gf.Vec3f(0.2, 0.4, 0.6)
    _, found = at_corners(made.stage)
    assert np.abs(found - [0.2, 0.4, 0.6]).max() < 1e-6


def test_opacity_changes_over_a_mesh(shoot: Any) -> None:
    """What is less than half there is seen through; an even sky shines through the rest."""
    made = floor("constant", np.array([(1.0, 1.0, 1.0)]))
    opacity = (POINTS[:, 0] / 2.0).tolist()
    mesh = made.stage.GetPrimAtPath("/floor")
    say(mesh, "displayOpacity", Sdf.ValueTypeNames.FloatArray, "vertex", opacity)
    (at,) = seen(shoot(made.stage, "depth", "position"), "position")
    assert 0.99 < at[:, 0].min() < 1.15
    _, found = at_corners(made.stage, "opacity")
    assert found.min() == pytest.approx(0.0, abs=1e-3) and found.max() == pytest.approx(1.0)


def test_materials_read_numbers_of_meshes() -> None:
    made = small.Stage()
    mesh = made.mesh("/floor", POINTS, FACES)
    path = made.material("/Looks/paint", base_color=(0.5, 0.5, 0.5))
    shader = UsdShade.Shader(made.stage.GetPrimAtPath(path).GetChildren()[0])
    for name in ("roughness", "opacity"):
        reader = UsdShade.Shader.Define(made.stage, f"{path}/{name}_reader")
        reader.CreateIdAttr("UsdPrimvarReader_float")
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set(f"my_{name}")
        reader.CreateInput("fallback", Sdf.ValueTypeNames.Float).Set(0.7)
        output = reader.CreateOutput("result", Sdf.ValueTypeNames.Float)
        shader.CreateInput(name, Sdf.ValueTypeNames.Float).ConnectToSource(output)
    shader.CreateInput("opacityThreshold", Sdf.ValueTypeNames.Float).Set(0.5)
    made.bind(mesh.GetPrim(), path)
    say(mesh, "my_roughness", Sdf.ValueTypeNames.FloatArray, "constant", [0.25])
    (patch,) = translate(made.stage).patches
    # Without the primvar of its name its fallback counts, as a mask.
    assert (patch.surface.roughness, patch.surface.opacity) == (0.25, 1.0)
    say(mesh, "my_opacity", Sdf.ValueTypeNames.FloatArray, "constant", [0.4])
    (patch,) = translate(made.stage).patches
    assert patch.surface.opacity == 0.0


def test_a_material_that_nobody_can_read_leaves_the_colors() -> None:
    made = small.Stage()
    mesh = made.mesh("/floor", POINTS, FACES)
    colors(mesh, "constant", COLORS[:1])
    material = UsdShade.Material.Define(made.stage, "/Looks/other")
    shader = UsdShade.Shader.Define(made.stage, "/Looks/other/surface")
    shader.CreateIdAttr("SomebodysSurface")
    output = shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    material.CreateSurfaceOutput().ConnectToSource(output)
    made.bind(mesh.GetPrim(), "/Looks/other")
    scene = translate(made.stage)
    assert scene.patches[0].surface.base_color == pytest.approx(COLORS[0])
    assert any("SomebodysSurface is not" in reason for _, _, reason in scene.report.rows)


def scattered(count: int = 4) -> tuple[Any, UsdGeom.PointInstancer]:
    made = small.Stage()
    instancer = UsdGeom.PointInstancer.Define(made.stage, "/Set")
    made.mesh("/Set/Proto", POINTS, FACES)
    made.mesh("/Set/Own", POINTS + np.array([0.0, 0.0, 1.0]), FACES)
    colors(UsdGeom.Mesh(made.stage.GetPrimAtPath("/Set/Own")), "constant", [(0.3, 0.3, 0.3)])
    instancer.CreatePrototypesRel().SetTargets(["/Set/Proto", "/Set/Own"])
    instancer.CreateProtoIndicesAttr([0, 0, 0, 1] * (count // 4))
    instancer.CreatePositionsAttr(vectors([(3 * i, 0, 0) for i in range(count)]))
    return made, instancer


@pytest.mark.parametrize("interpolation", ["vertex", "varying"])
def test_instances_have_the_colors_of_their_instancer(interpolation: str) -> None:
    made, instancer = scattered()
    colors(instancer, interpolation, COLORS)
    at, found = at_corners(made.stage)
    number = np.floor(at[:, 0] / 3.0 + 1e-9).astype(int)
    expected = np.array([*COLORS[:3], (0.3, 0.3, 0.3)])
    # A prototype that says its own colour keeps it.
    assert np.abs(found - expected[number]).max() < 1e-6


def test_instances_have_the_opacity_of_their_instancer() -> None:
    made, instancer = scattered()
    say(instancer, "displayOpacity", Sdf.ValueTypeNames.FloatArray, "vertex", [0.2, 0.4, 0.6, 0.8])
    at, found = at_corners(made.stage, "opacity")
    number = np.floor(at[:, 0] / 3.0 + 1e-9).astype(int)
    assert np.abs(found[:, 0] - np.array([0.2, 0.4, 0.6, 0.8])[number]).max() < 1e-6


def test_a_masked_instance_keeps_the_numbers_of_the_others() -> None:
    made, instancer = scattered()
    colors(instancer, "vertex", COLORS)
    instancer.CreateInvisibleIdsAttr([0])
    at, found = at_corners(made.stage)
    number = np.floor(at[:, 0] / 3.0 + 1e-9).astype(int)
    assert set(number) == {1, 2, 3}
    assert np.abs(found[number == 2] - COLORS[2]).max() < 1e-6


def test_very_many_colors_of_instances_are_rounded_and_told() -> None:
    made, instancer = scattered(400)
    rows = np.random.default_rng(2).uniform(0.0, 1.0, (400, 3))
    colors(instancer, "vertex", rows)
    scene = translate(made.stage)
    assert len({id(patch.surface) for patch in scene.patches}) < 200
    assert any("are rounded" in reason for _, _, reason in scene.report.rows)
    at, found = at_corners(made.stage)
    number = np.floor(at[:, 0] / 3.0 + 1e-9).astype(int)
    own = number % 4 != 3
    assert np.abs(found - rows[number])[own].max() <= 1.0 / 8.0 + 1e-6


def test_of_nested_instancers_the_inner_one_counts() -> None:
    made = small.Stage()
    made.mesh("/Set/Inner/Proto", POINTS, FACES)
    for path, target in (("/Set/Inner", "/Set/Inner/Proto"), ("/Set", "/Set/Inner")):
        instancer = UsdGeom.PointInstancer.Define(made.stage, path)
        instancer.CreatePrototypesRel().SetTargets([target])
        instancer.CreateProtoIndicesAttr([0, 0])
        instancer.CreatePositionsAttr(vectors([(0, 0, 0), (30 if path == "/Set" else 3, 0, 0)]))
    outer, inner = (UsdGeom.PointInstancer.Get(made.stage, p) for p in ("/Set", "/Set/Inner"))
    colors(outer, "vertex", COLORS[2:])
    at, found = at_corners(made.stage)
    assert np.abs(found - np.array(COLORS[2:])[(at[:, 0] > 15).astype(int)]).max() < 1e-6
    colors(inner, "vertex", COLORS[:2])
    at, found = at_corners(made.stage)
    assert np.abs(found - np.array(COLORS[:2])[(at[:, 0] % 30 > 2.5).astype(int)]).max() < 1e-6
