"""Displacement of UsdPreviewSurface, in closed form."""

from typing import Any

import numpy as np
import pytest
from pxr import Sdf, UsdGeom, UsdShade

from openrooms_usd.exporters import Report
from openrooms_usd.rendering.scene.mesh_surfaces import MeshSurfaces
from openrooms_usd.rendering.scene.surfaces import SurfaceReader
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.shapes.meshes import read_meshes
from tests import small
from tests.pictures import save_picture


def material(made: small.Stage, by: Any, *, connected: bool = True) -> str:
    """A material that moves its surface by a number, or by the red of a picture."""
    path = made.material("/Moved")
    shader = UsdShade.Shader(made.stage.GetPrimAtPath("/Moved/Surface"))
    socket = shader.CreateInput("displacement", Sdf.ValueTypeNames.Float)
    if isinstance(by, float):
        socket.Set(by)
    else:
        texture = UsdShade.Shader.Define(made.stage, "/Moved/Height")
        texture.CreateIdAttr("UsdUVTexture")
        file, scale, bias, *fallback = by
        if fallback:
            texture.CreateInput("fallback", Sdf.ValueTypeNames.Float4).Set((*fallback, 0, 0, 0))
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(file)
        texture.CreateInput("wrapS", Sdf.ValueTypeNames.Token).Set("clamp")
        texture.CreateInput("wrapT", Sdf.ValueTypeNames.Token).Set("clamp")
        texture.CreateInput("sourceColorSpace", Sdf.ValueTypeNames.Token).Set("raw")
        texture.CreateInput("scale", Sdf.ValueTypeNames.Float4).Set((scale,) * 4)
        texture.CreateInput("bias", Sdf.ValueTypeNames.Float4).Set((bias,) * 4)
        reader = UsdShade.Shader.Define(made.stage, "/Moved/St")
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
        st = reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(st)
        socket.ConnectToSource(texture.CreateOutput("r", Sdf.ValueTypeNames.Float))
    if connected:
        output = UsdShade.Material(made.stage.GetPrimAtPath(path)).CreateDisplacementOutput()
        output.ConnectToSource(shader.CreateOutput("displacement", Sdf.ValueTypeNames.Token))
    return path


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (2.0, 2.0, 2.0), (-1.0, 1.0, 1.0)])
@pytest.mark.parametrize("metres", [1.0, 0.01])
def test_a_ball_grows_by_units_of_the_stage(scale: tuple[float, ...], metres: float) -> None:
    made = small.Stage(metres=metres)
    ball = UsdGeom.Sphere.Define(made.stage, "/Ball")
    ball.CreateRadiusAttr(1.0)
    ball.AddScaleOp().Set(scale)
    made.bind(ball.GetPrim(), material(made, 0.25))
    scene = translate(made.stage)
    radii = np.linalg.norm(scene.triangles.corners, axis=2)
    assert np.allclose(radii, metres * (abs(scale[0]) + 0.25), rtol=1e-3)
    assert any("displacement moves" in why for path, _, why in scene.report.losses())


def test_a_picture_lifts_the_corners_that_it_is_bright_at(tmp_path: Any) -> None:
    pixels = np.array([[[0] * 3, [255] * 3], [[51] * 3, [102] * 3]], np.uint8)
    file = save_picture(tmp_path / "height.png", pixels)
    made = small.Stage()
    made.quad("/Quad", small.square((0, 0, 0), 1), material=material(made, (file, 2.0, -0.5)))
    corners = translate(made.stage).triangles.corners.reshape(-1, 3)
    heights = {tuple(corner[:2].round(6)): corner[2] for corner in corners}
    # The picture's lower row lies at t = 0: st runs from the first corner to the third.
    expected = {(-1, -1): -0.1, (1, -1): 0.3, (1, 1): 1.5, (-1, 1): -0.5}
    assert heights == pytest.approx(expected, abs=1e-3)


def test_nothing_moves_where_no_output_leads_to_it() -> None:
    made = small.Stage()
    made.quad("/Quad", small.square((0, 0, 0), 1), material=material(made, 0.5, connected=False))
    scene = translate(made.stage)
    assert not scene.triangles.corners[..., 2].any()
    assert any("left out" in why for path, _, why in scene.report.losses())


@pytest.mark.parametrize(
    ("code", "fallback", "expected"), [(None, -0.25, -0.25), (None, 0.5, 0.5), (102, 9.0, 0.2)]
)
def test_heights_of_any_sign_and_of_missing_pictures(
    tmp_path: Any, code: int | None, fallback: float, expected: float
) -> None:
    """Scale and bias are of pictures, not of what stands in; as normal maps have them, too."""
    file = tmp_path / "height.png"
    if code is not None:
        save_picture(file, np.full((2, 2, 3), code, np.uint8))
    else:
        file.write_bytes(b"none")
    made = small.Stage()
    by = (str(file), 2.0, -0.6 if code else -1.0, fallback)
    made.quad("/Quad", small.square((0, 0, 0), 1), material=material(made, by))
    scene = translate(made.stage)
    assert np.allclose(scene.triangles.corners[..., 2], expected, atol=1e-3)
    told = [why for path, _, why in scene.report.losses() if path == "/Moved"]
    assert ["cannot be read" in why for why in told] == [True] * (code is None)


def test_a_unit_that_is_no_length_is_usds() -> None:
    made = small.Stage(metres=0.0)
    made.quad("/Quad", small.square((0, 0, 0), 1), material=material(made, 0.5))
    assert np.allclose(translate(made.stage).triangles.corners[..., 2], 0.005)


def test_instances_of_one_form_share_what_was_moved() -> None:
    made = small.Stage()
    made.quad("/Proto/Quad", small.square((0, 0, 0), 1), material=material(made, 0.5))
    for turn, size in ((0.0, 1.0), (30.0, 1.0), (70.0, 1.0), (0.0, 2.0)):
        prim = UsdGeom.Xform.Define(made.stage, f"/World/I{turn:g}_{size:g}")
        prim.GetPrim().GetReferences().AddInternalReference("/Proto")
        prim.GetPrim().SetInstanceable(True)
        prim.AddTranslateOp().Set((turn, 0, 0))
        prim.AddRotateXOp().Set(turn)
        prim.AddScaleOp().Set((size,) * 3)
    placed = list(read_meshes(made.stage))
    report = Report()
    surfaces = MeshSurfaces(SurfaceReader(), frozenset(), report)
    moved = []
    for mesh, ((rows, material_of),) in surfaces.bind(placed):
        surfaces.read(mesh, material_of, [])
        moved.append(surfaces.moved(mesh, rows, material_of, []))
        far = moved[-1].world_points() - mesh.world_points()
        assert np.allclose(np.linalg.norm(far, axis=1), 0.5)
    # One that stands by itself, and two sizes.
    assert len(moved) == 5 and len({id(one.mesh) for one in moved}) == 3
