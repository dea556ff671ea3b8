"""Light of lightmaps: what is shown without any lamp is colour times irradiance, exposed."""

from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdGeom

from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.errors import StageError
from openrooms_usd.rendering.bake.layer import ATLAS, IRRADIANCE, SCALE_OFFSET
from openrooms_usd.rendering.scene.pictures import Picture
from openrooms_usd.usd.light.lights import define_mesh_light
from openrooms_usd.usd.shading.surfaces import Texture
from tests.gltf.conftest import Export
from tests.pictures import save_picture
from tests.small import Stage

SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
STOPS = -6.0
PLACES = np.random.default_rng(3).uniform(0.1, 0.9, (100, 2))


def lit(tmp_path: Path) -> tuple[Stage, np.ndarray, np.ndarray]:
    """Two squares in one lightmap; its irradiance, and the colour of the squares."""
    columns, rows = np.meshgrid(np.arange(32) / 32.0, np.arange(32) / 32.0)
    light = np.stack([20 + 60 * columns, 30 + 50 * rows, 40 + 0 * rows], axis=-1)
    paint = np.stack([0.3 + 0.6 * rows, 0.9 - 0.5 * columns, 0.6 + 0 * rows], axis=-1)
    codes = np.round(paint * 255).astype(np.uint8)
    made = Stage()
    color = Texture(
        save_picture(tmp_path / "paint.png", codes),
        color_space="sRGB",
        wrap_s="clamp",
        wrap_t="clamp",
    )
    look = made.material("/M", base_color=color)
    atlas = made.stage.DefinePrim("/Lightmaps/atlas_0", "Scope")
    asset = Sdf.AssetPath(save_picture(tmp_path / "light.exr", light.astype(np.float32)))
    atlas.CreateAttribute(IRRADIANCE, Sdf.ValueTypeNames.Asset).Set(asset)
    for number, offset in enumerate(((0.0, 0.0), (0.5, 0.25))):
        mesh = made.quad(f"/Square_{number}", np.add(SQUARE, (0, 0, number)), material=look)
        api = UsdGeom.PrimvarsAPI(mesh)
        st = api.CreatePrimvar("st1", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
        st.Set([Gf.Vec2f(*map(float, corner[:2])) for corner in SQUARE])
        place = mesh.GetPrim().CreateAttribute(SCALE_OFFSET, Sdf.ValueTypeNames.Float4)
        place.Set(Gf.Vec4f(0.5, 0.5, *offset))
        mesh.GetPrim().CreateRelationship(ATLAS).SetTargets(["/Lightmaps/atlas_0"])
    made.camera((0, 0, 4), (0.5, 0.5, 0), up=(0, 1, 0))
    UsdGeom.Camera(made.stage.GetPrimAtPath("/Camera")).CreateExposureAttr(STOPS)
    return made, light[::-1], linear_from_srgb(codes[::-1] / 255.0)


def test_a_surface_shows_colour_times_irradiance(export: Export, tmp_path: Path) -> None:
    made, light, paint = lit(tmp_path)
    glb, report = export(made.stage, {"light": "baked"})
    assert "extensionsRequired" not in glb.json
    assert "KHR_lights_punctual" not in glb.json["extensionsUsed"]
    for number, offset in enumerate(((0.0, 0.0), (0.5, 0.25))):
        (primitive,) = glb.named("meshes", f"Square_{number}")["primitives"]
        material = glb.json["materials"][primitive["material"]]
        assert "KHR_materials_unlit" in material["extensions"]
        points = glb.accessor(primitive["attributes"]["POSITION"])[:, :2]
        uv = glb.accessor(primitive["attributes"]["TEXCOORD_0"])
        basis = np.linalg.lstsq(np.c_[points, np.ones(len(points))], uv, rcond=None)[0]
        where = np.c_[PLACES, np.ones(len(PLACES))] @ basis
        info = material["pbrMetallicRoughness"]["baseColorTexture"]
        codes = glb.picture(info, tmp_path)[::-1]
        seen = Picture(codes, "clamp").lookup(np.c_[where[:, 0], 1.0 - where[:, 1]])
        there = PLACES * 0.5 + offset
        expected = Picture(light, "clamp").lookup(there) * Picture(paint, "clamp").lookup(PLACES)
        shown = linear_from_srgb(seen)
        expected *= 2.0**STOPS / np.pi
        # JPEG keeps colours to some codes.
        assert np.abs(shown - expected).max() < 0.015
        assert shown.mean() == pytest.approx(expected.mean(), rel=0.01)
    assert {row[1] for row in report.losses()} == {"approximated"}


def test_what_has_no_lightmap_is_shown_and_told(export: Export, tmp_path: Path) -> None:
    made, _, _ = lit(tmp_path)
    define_mesh_light(made.box("/Bulb", 0.1).GetPrim(), nits=16.0)
    pane = made.material("/Glass", base_color=(1, 1, 1), opacity=0.1)
    made.quad("/Pane", np.add(SQUARE, (0, 0, 3)), material=pane)
    glb, report = export(made.stage, {"light": "baked"})
    materials = {
        mesh["name"]: glb.json["materials"][mesh["primitives"][0]["material"]]
        for mesh in glb.json["meshes"]
    }
    bulb = materials["Bulb"]["pbrMetallicRoughness"]["baseColorFactor"]
    assert bulb[:3] == pytest.approx([16.0 * 2.0**STOPS] * 3, abs=0.01)
    assert materials["Pane"]["alphaMode"] == "BLEND"
    rows = {path: reason for path, _, reason in report.rows}
    assert "no lightmap" in rows["/Pane"] and rows["/Bulb"] == ""


def test_a_stage_without_lightmaps_is_told_how_to_get_them(export: Export) -> None:
    made = Stage()
    made.box("/Box", 1.0)
    with pytest.raises(StageError, match="no lightmaps"):
        export(made.stage, {"light": "baked"})


def test_a_node_tells_where_it_lies_in_a_lightmap(export: Export, tmp_path: Path) -> None:
    made, _, _ = lit(tmp_path)
    glb, _ = export(made.stage, {"light": "lightmaps"})
    assert "KHR_materials_unlit" not in glb.json.get("extensionsUsed", ())
    for number, offset in enumerate(((0.0, 0.0), (0.5, 0.25))):
        (primitive,) = glb.named("meshes", f"Square_{number}")["primitives"]
        told = glb.named("nodes", f"Square_{number}")["extras"]["lightmap"]
        assert told["atlas"] == "/Lightmaps/atlas_0"
        places = glb.accessor(
            primitive["attributes"][f"TEXCOORD_{primitive['extras']['lightmap']}"]
        )
        found = places * told["area"][:2] + told["area"][2:]
        points = glb.accessor(primitive["attributes"]["POSITION"])[:, :2]
        expected = points * 0.5 + offset
        assert np.abs(found - np.c_[expected[:, 0], 1.0 - expected[:, 1]]).max() < 1e-6


def test_lightmaps_need_some(export: Export) -> None:
    made = Stage()
    made.box("/Box", 1.0)
    with pytest.raises(StageError, match="no lightmaps"):
        export(made.stage, {"light": "lightmaps"})
