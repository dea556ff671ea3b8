"""Colours that meshes carry: what is seen is what USD says lies between the corners."""

from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom, UsdShade

from openrooms_usd.rendering.scene.translate import translate
from tests import small

# Three by three points on the floor, and their four squares.
POINTS = np.array([(i, j, 0.0) for j in range(3) for i in range(3)])
FACES = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]])


def colors_of(count: int) -> np.ndarray:
    return np.random.default_rng(8).uniform(0.1, 0.9, (count, 3))


def affine(at: np.ndarray) -> np.ndarray:
    """A colour that changes evenly over the floor."""
    return 0.2 + at @ np.array([[0.3, 0.1, 0.0], [0.0, 0.1, 0.25], [0.0, 0.0, 0.0]])


def floor(interpolation: str, colors: np.ndarray, name: str = "displayColor") -> Any:
    made = small.Stage()
    mesh = made.mesh("/floor", POINTS, FACES)
    primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        name, Sdf.ValueTypeNames.Color3fArray, interpolation
    )
    primvar.Set([Gf.Vec3f(*map(float, row)) for row in colors])
    made.camera((1.0, 1.0, 2.5), (1.0, 1.0, 0.0), up=(0, 1, 0), fov=35.0)
    return made


def seen(view: Any, *channels: str) -> list[np.ndarray]:
    """Channels where there is something."""
    there = view.images["depth"].pixels[..., 0] > 0.0
    assert there.sum() > 100
    return [view.images[name].pixels[there].astype(np.float64) for name in channels]


def test_colors_of_points_change_evenly_between_them(shoot) -> None:
    made = floor("vertex", affine(POINTS))
    at, found = seen(shoot(made.stage, "depth", "position", "base_color"), "position", "base_color")
    assert np.abs(found - affine(at)).max() < 2e-4
    # Not the mean, which it was.
    assert found.std(axis=0).min() > 0.05


def test_colors_of_corners_stay_with_their_triangle(shoot) -> None:
    colors = colors_of(16)
    made = floor("faceVarying", colors)
    at, found = seen(shoot(made.stage, "depth", "position", "base_color"), "position", "base_color")
    expected = np.zeros_like(found)
    for face, corners in enumerate(FACES):
        own = colors[4 * face : 4 * face + 4]
        # A square is cut from its first corner to its third.
        for rows in ([0, 1, 2], [0, 2, 3]):
            edges = np.vstack([POINTS[corners[rows]][:, :2].T, np.ones(3)])
            weights = np.linalg.solve(edges, np.vstack([at[:, :2].T, np.ones(len(at))])).T
            inside = (weights > -1e-9).all(axis=1)
            expected[inside] = weights[inside] @ own[rows]
    # Edges of two triangles are either's.
    wrong = np.abs(found - expected).max(axis=1) > 2e-4
    assert wrong.mean() < 0.01


def test_colors_of_faces_are_theirs(shoot) -> None:
    colors = colors_of(4)
    made = floor("uniform", colors)
    at, found = seen(shoot(made.stage, "depth", "position", "base_color"), "position", "base_color")
    face = (at[:, 0] > 1.0) + 2 * (at[:, 1] > 1.0)
    away = (np.abs(at[:, :2] - 1.0) > 1e-6).all(axis=1)
    assert np.abs(found - colors[face])[away].max() < 2e-4


def test_subdivision_surfaces_carry_them_along(shoot) -> None:
    made = floor("vertex", affine(POINTS))
    UsdGeom.Mesh(made.stage.GetPrimAtPath("/floor")).GetSubdivisionSchemeAttr().Set("catmullClark")
    at, found = seen(shoot(made.stage, "depth", "position", "base_color"), "position", "base_color")
    assert np.abs(found - affine(at)).max() < 2e-4


def painted_material(made: Any, name: str, **inputs: Any) -> str:
    """A Lambertian material whose base colour is a primvar."""
    path = made.material("/Looks/paint", **inputs)
    shader = UsdShade.Shader(made.stage.GetPrimAtPath(path).GetChildren()[0])
    reader = UsdShade.Shader.Define(made.stage, f"{path}/reader")
    reader.CreateIdAttr("UsdPrimvarReader_float3")
    reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set(name)
    reader.CreateInput("fallback", Sdf.ValueTypeNames.Float3).Set(Gf.Vec3f(0.1, 0.2, 0.3))
    output = reader.CreateOutput("result", Sdf.ValueTypeNames.Float3)
    socket = shader.GetInput("diffuseColor") or shader.CreateInput(
        "diffuseColor", Sdf.ValueTypeNames.Color3f
    )
    socket.ConnectToSource(output)
    return path


def test_a_material_takes_them_and_light_does(shoot) -> None:
    """Under an even sky a Lambertian floor is as bright as its colour."""
    made = floor("vertex", affine(POINTS), "paint")
    made.bind(made.stage.GetPrimAtPath("/floor"), painted_material(made, "paint"))
    made.dome()
    channels = ("depth", "position", "base_color", "radiance")
    at, found, light = seen(shoot(made.stage, *channels), *channels[1:])
    assert np.abs(found - affine(at)).max() < 2e-4
    if light.any():  # the core alone has none
        assert np.abs(light.mean(axis=0) - affine(at).mean(axis=0)).max() < 0.02


def test_a_material_without_the_primvar_has_its_fallback(shoot) -> None:
    made = floor("vertex", affine(POINTS), "other")
    made.bind(made.stage.GetPrimAtPath("/floor"), painted_material(made, "paint"))
    (found,) = seen(shoot(made.stage, "depth", "base_color"), "base_color")
    assert np.abs(found - [0.1, 0.2, 0.3]).max() < 1e-3


def test_instances_share_their_picture_and_inherit_colors() -> None:
    made = small.Stage()
    made.stage.DefinePrim("/asset", "Xform")
    made.mesh("/asset/floor", POINTS, FACES)
    mesh = UsdGeom.Mesh(made.stage.GetPrimAtPath("/asset/floor"))
    mesh.CreateDisplayColorPrimvar("uniform").Set([Gf.Vec3f(*row) for row in colors_of(4)])
    made.mesh("/asset/plain", POINTS + np.array([0.0, 0.0, 1.0]), FACES)
    made.stage.GetPrimAtPath("/asset").SetSpecifier(Sdf.SpecifierClass)
    for number, color in enumerate([(0.5, 0.1, 0.1), (0.1, 0.5, 0.1)]):
        prim = made.stage.DefinePrim(f"/World/one_{number}", "Xform")
        prim.GetReferences().AddInternalReference("/asset")
        prim.SetInstanceable(True)
        primvar = UsdGeom.PrimvarsAPI(prim).CreatePrimvar(
            "displayColor", Sdf.ValueTypeNames.Color3fArray, "constant"
        )
        primvar.Set([Gf.Vec3f(*color)])
    scene = translate(made.stage)
    of = dict(scene.owners)
    one, two = (of[f"/World/one_{k}/floor"] for k in range(2))
    assert one is two
    assert of["/World/one_0/plain"].base_color == pytest.approx((0.5, 0.1, 0.1))
    assert of["/World/one_1/plain"].base_color == pytest.approx((0.1, 0.5, 0.1))


def test_beside_textures_their_mean_is_taken_and_told(tmp_path) -> None:
    made = floor("vertex", affine(POINTS), "paint")
    path = painted_material(made, "paint")
    made.bind(made.stage.GetPrimAtPath("/floor"), path)
    from openrooms_usd.imagefile import write_png

    write_png(tmp_path / "rough.png", np.full((2, 2, 3), 128, np.uint8))
    shader = UsdShade.Shader(made.stage.GetPrimAtPath(path).GetChildren()[0])
    texture = UsdShade.Shader.Define(made.stage, f"{path}/rough")
    texture.CreateIdAttr("UsdUVTexture")
    texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(str(tmp_path / "rough.png"))
    output = texture.CreateOutput("r", Sdf.ValueTypeNames.Float)
    shader.CreateInput("roughness", Sdf.ValueTypeNames.Float).ConnectToSource(output)
    scene = translate(made.stage)
    assert scene.patches[0].surface.base_color == pytest.approx(tuple(affine(POINTS).mean(axis=0)))
    reasons = " ".join(reason for _, _, reason in scene.report.rows)
    assert "taken as their mean beside textures" in reasons
