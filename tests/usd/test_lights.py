"""Lights: nits, lux, areas and directions against closed forms, in any unit and up axis."""

import math
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from openrooms_usd.colorimetry import luminance
from openrooms_usd.usd.light.emitters import (
    CylinderLight,
    DiskLight,
    DistantLight,
    DomeLight,
    MeshLight,
    RectLight,
    SphereLight,
    UnknownLight,
    nits_from_lumen,
    world_area,
)
from openrooms_usd.usd.light.lightreader import read_light
from openrooms_usd.usd.light.lights import define_dome, define_mesh_light, read_lights
from openrooms_usd.usd.shading.materials import PreviewSurface, define_preview_surface
from tests.rendering.scene.schemas import write_files

WEIGHTS = (0.2126, 0.7152, 0.0722)


@pytest.fixture
def stage() -> Usd.Stage:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    return stage


def cube(stage: Usd.Stage, path: str, side: float = 1.0) -> Usd.Prim:
    mesh = UsdGeom.Mesh.Define(stage, path)
    corners = [(x, y, z) for x in (0, side) for y in (0, side) for z in (0, side)]
    mesh.CreatePointsAttr([Gf.Vec3f(*c) for c in corners])
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    faces = [0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3]
    mesh.CreateFaceVertexIndicesAttr(faces)
    return mesh.GetPrim()


@pytest.mark.parametrize("kelvin", [1500.0, 2700.0, 4000.0, 6500.0, 8000.0])
def test_color_temperature_changes_the_hue_and_not_the_luminance(
    stage: Usd.Stage, kelvin: float
) -> None:
    light = UsdLux.SphereLight.Define(stage, "/L")
    light.CreateIntensityAttr(100.0)
    light.CreateExposureAttr(1.0)
    light.CreateEnableColorTemperatureAttr(True)
    light.CreateColorTemperatureAttr(kelvin)
    [read] = read_lights(stage)
    assert sum(w * c for w, c in zip(WEIGHTS, read.radiance, strict=True)) == pytest.approx(200.0)
    assert (read.radiance[0] > read.radiance[2]) == (kelvin < 6600)


def test_normalize_divides_by_the_area_in_the_world(stage: Usd.Stage) -> None:
    """A sheared, scaled parent: areas against cross products and known solids."""
    parent = UsdGeom.Xform.Define(stage, "/P")
    parent.AddScaleOp().Set(Gf.Vec3f(2.0, 3.0, 3.0))
    expected = {}
    for kind, area in (
        ("Rect", 2.0 * 3.0 * 0.5 * 0.25),
        ("Disk", 2.0 * 3.0 * math.pi * 0.25),
        ("Cylinder", 2.0 * 1.0 * 2.0 * math.pi * 3.0 * 0.5),
    ):
        light = getattr(UsdLux, f"{kind}Light").Define(stage, f"/P/{kind}")
        expected[f"/P/{kind}"] = 100.0 / area
        if kind == "Rect":
            light.CreateWidthAttr(0.5)
            light.CreateHeightAttr(0.25)
    UsdLux.MeshLightAPI.Apply(cube(stage, "/P/Mesh"))
    expected["/P/Mesh"] = 100.0 / (2.0 * (2 * 3 + 3 * 3 + 3 * 2))
    UsdLux.SphereLight.Define(stage, "/Sphere").AddScaleOp().Set(Gf.Vec3f(2.0))
    expected["/Sphere"] = 100.0 / (4.0 * math.pi)
    for path in expected:
        light = UsdLux.LightAPI(stage.GetPrimAtPath(path))
        light.CreateIntensityAttr(100.0)
        light.CreateNormalizeAttr(True)
    read = {light.path: light.radiance[1] for light in read_lights(stage)}
    assert read == pytest.approx(expected)


def test_an_ellipsoid_is_within_its_bound(stage: Usd.Stage) -> None:
    """Spheroid, closed form (prolate): 2 pi a^2 (1 + c / (a e) asin e)."""
    light = UsdLux.SphereLight.Define(stage, "/L")
    light.CreateRadiusAttr(1.0)
    light.AddScaleOp().Set(Gf.Vec3f(1.0, 1.0, 3.0))
    light.CreateNormalizeAttr(True)
    e = math.sqrt(1 - 1 / 9)
    area = 2 * math.pi * (1 + 3 / e * math.asin(e))
    assert 1 / read_lights(stage)[0].radiance[0] == pytest.approx(area, rel=0.011)


@pytest.mark.parametrize("angle", [0.53, 10.0, 90.0])
def test_a_distant_light_gives_the_lux_of_its_disk(stage: Usd.Stage, angle: float) -> None:
    light = UsdLux.DistantLight.Define(stage, "/L")
    light.CreateAngleAttr(angle)
    light.CreateIntensityAttr(1000.0)
    [read] = read_lights(stage)
    assert isinstance(read, DistantLight)
    # The integral of L cos over the disk, by the midpoint rule.
    theta = (np.arange(20_000) + 0.5) / 20_000 * math.radians(angle / 2)
    ring = 2 * math.pi * np.sin(theta) * np.cos(theta) * math.radians(angle / 2) / 20_000
    assert read.irradiance[0] == pytest.approx(1000.0 * ring.sum(), rel=1e-6)
    light.CreateNormalizeAttr(True)
    [read] = read_lights(stage)
    assert isinstance(read, DistantLight)
    assert read.irradiance[0] == pytest.approx(1000.0)


def test_centimetres_y_up_equal_metres_z_up() -> None:
    """The same lamp in both conventions: points and radiance agree."""
    found = []
    for up, unit in (("Z", 1.0), ("Y", 0.01)):
        stage = Usd.Stage.CreateInMemory()
        UsdGeom.SetStageUpAxis(stage, up)
        UsdGeom.SetStageMetersPerUnit(stage, unit)
        place = (1.0, 2.0, 3.0) if up == "Z" else (100.0, 300.0, -200.0)
        light = UsdLux.RectLight.Define(stage, "/L")
        light.AddTranslateOp().Set(Gf.Vec3d(*place))
        if up == "Z":
            light.AddRotateXOp().Set(90.0)
        light.CreateWidthAttr(0.5 / unit)
        light.CreateHeightAttr(0.25 / unit)
        light.CreateNormalizeAttr(True)
        found.append(read_lights(stage)[0])
    for a, b in zip(
        *[(x.radiance, x.world_from_light @ [0.5 * x.width, 0, 0, 1]) for x in found], strict=True
    ):
        np.testing.assert_allclose(a, b, atol=1e-6)
    np.testing.assert_allclose(found[0].world_from_light[:3, 3], [1, 2, 3])


def looks_at(dome: DomeLight, u: float, v: float) -> np.ndarray:
    """World direction of a place in the picture (v from the top), by OpenEXR's definition."""
    longitude, latitude = math.pi * (1 - 2 * u), math.pi * (0.5 - v)
    local = [
        math.cos(latitude) * math.sin(longitude),
        math.sin(latitude),
        math.cos(latitude) * math.cos(longitude),
    ]
    return dome.world_from_light[:3, :3] @ local


@pytest.mark.parametrize(
    ("kind", "up", "pole"),
    [
        ("DomeLight", "Y", ""),
        ("DomeLight_1", "Y", "scene"),
        ("DomeLight_1", "Z", "scene"),
        ("DomeLight_1", "Z", "Z"),
        ("DomeLight_1", "Y", "Y"),
    ],
)
def test_domes_that_stand_upright_all_look_alike(kind: str, up: str, pole: str) -> None:
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, up)
    light = getattr(UsdLux, kind).Define(stage, "/L")
    light.AddScaleOp().Set(Gf.Vec3f(7.0))
    if pole:
        light.CreatePoleAxisAttr(pole)
    [dome] = read_lights(stage)
    assert isinstance(dome, DomeLight)
    np.testing.assert_allclose(looks_at(dome, 0.5, 0.0), [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(looks_at(dome, 0.5, 0.5), [0, -1, 0], atol=1e-12)
    np.testing.assert_allclose(looks_at(dome, 0.25, 0.5), [1, 0, 0], atol=1e-12)


def test_other_poles_are_turned(stage: Usd.Stage) -> None:
    legacy = UsdLux.DomeLight.Define(stage, "/Legacy").GetPrim()
    # A word that only DomeLight_1 knows.
    legacy.CreateAttribute("poleAxis", Sdf.ValueTypeNames.Token).Set("Z")
    UsdLux.DomeLight_1.Define(stage, "/New").CreatePoleAxisAttr("Y")
    domes = read_lights(stage)
    assert len(domes) == 2
    for dome in domes:
        assert isinstance(dome, DomeLight)
        np.testing.assert_allclose(looks_at(dome, 0.5, 0.0), [0, 1, 0], atol=1e-12)
        np.testing.assert_allclose(looks_at(dome, 0.5, 0.5), [0, 0, 1], atol=1e-12)


def test_our_dome_turns_counter_clockwise_and_keeps_its_nits(stage: Usd.Stage) -> None:
    define_dome(stage, "/L", radiance=(10.0, 20.0, 40.0), rotation=90.0)
    [dome] = read_lights(stage)
    assert isinstance(dome, DomeLight)
    np.testing.assert_allclose(dome.radiance, [10.0, 20.0, 40.0], rtol=1e-6)
    np.testing.assert_allclose(looks_at(dome, 0.25, 0.5), [0, 1, 0], atol=1e-7)
    define_dome(stage, "/Night", radiance=(0.0, 0.0, 0.0))
    assert read_lights(stage)[1].radiance.tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("degrees", [0.0, 90.0, 40.0, -130.0])
def test_our_dome_shows_what_one_with_its_pole_along_z_does(
    stage: Usd.Stage, degrees: float
) -> None:
    """To the last bit where there is no turn, so that no pixel of a picture moves."""
    ours = define_dome(stage, "/Ours", rotation=degrees)
    pole = UsdLux.DomeLight_1.Define(stage, "/Pole")
    pole.CreatePoleAxisAttr("Z")
    pole.AddRotateZOp(UsdGeom.XformOp.PrecisionDouble).Set(degrees)
    one, other = (x.world_from_light for x in read_lights(stage))
    np.testing.assert_allclose(one, other, atol=0.0 if degrees == 0.0 else 1e-15)
    assert ours.GetPrim().GetTypeName() == "DomeLight"
    # The operation is the one that UsdLux writes itself, which finds nothing left to do.
    order = ours.GetXformOpOrderAttr().Get()
    ours.OrientToStageUpAxis()
    assert ours.GetXformOpOrderAttr().Get() == order


def test_a_mesh_light_gives_its_lumen(stage: Usd.Stage) -> None:
    prim = cube(stage, "/Bulb", 0.1)
    area = world_area(prim)
    assert area == pytest.approx(6 * 0.01)
    define_mesh_light(prim, nits=nits_from_lumen(800.0, area), kelvin=3000.0)
    [read] = read_lights(stage)
    assert isinstance(read, MeshLight)
    assert float(luminance(read.radiance)) * math.pi * 0.06 == pytest.approx(800.0, rel=1e-6)
    assert read.losses == ()


def test_the_glow_of_a_material_tints_a_mesh_light(stage: Usd.Stage) -> None:
    prim = cube(stage, "/Bulb")
    UsdLux.MeshLightAPI.Apply(prim)
    glow = define_preview_surface(stage, "/M", PreviewSurface(emissive=(2.0, 1.0, 0.5)))
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(glow)
    assert read_lights(stage)[0].radiance.tolist() == [2.0, 1.0, 0.5]
    glow.GetPrim().GetChild("Surface").GetAttribute("inputs:emissiveColor").Set(Gf.Vec3f(0))
    [read] = read_lights(stage)
    assert read.radiance.tolist() == [1.0, 1.0, 1.0] and "black" in read.losses[0]


def test_every_kind_is_read_and_unknown_ones_say_so(stage: Usd.Stage) -> None:
    kinds = {
        "RectLight": RectLight,
        "DiskLight": DiskLight,
        "SphereLight": SphereLight,
        "CylinderLight": CylinderLight,
        "DistantLight": DistantLight,
        "DomeLight": DomeLight,
        "GeometryLight": UnknownLight,
    }
    stage.DefinePrim("/PortalEmitsNothing", "PortalLight")
    for name in kinds:
        stage.DefinePrim(f"/{name}", name)
    assert {light.path[1:]: type(light) for light in read_lights(stage)} == kinds
    assert all(isinstance(x, UnknownLight) == bool(x.losses) for x in read_lights(stage))


def test_what_is_not_seen_does_not_shine(stage: Usd.Stage) -> None:
    UsdLux.RectLight.Define(stage, "/Off").CreateVisibilityAttr("invisible")
    UsdLux.RectLight.Define(stage, "/Guide").CreatePurposeAttr("guide")
    model = UsdGeom.Xform.Define(stage, "/Lamp").GetPrim()
    UsdLux.DiskLight.Define(stage, "/Lamp/Light")
    for name in ("A", "B"):
        copy = stage.DefinePrim(f"/{name}")
        copy.GetReferences().AddInternalReference(model.GetPath())
        copy.SetInstanceable(True)
    assert [x.path for x in read_lights(stage)] == ["/Lamp/Light", "/A/Light", "/B/Light"]


@pytest.mark.parametrize(
    ("kind", "area"),
    [("Cube", 6 * 4.0), ("Sphere", 4 * math.pi), ("Cylinder", 6 * math.pi), ("Plane", 4.0)],
)
def test_normalize_divides_by_the_area_of_shapes(stage: Usd.Stage, kind: str, area: float) -> None:
    """In their default sizes, ten times as large; facets have a little less than what is round."""
    prim = stage.DefinePrim("/L", kind)
    UsdGeom.Xformable(prim).AddScaleOp().Set(Gf.Vec3f(10.0))
    UsdLux.LightAPI.Apply(prim)
    UsdLux.LightAPI(prim).CreateIntensityAttr(100.0)
    UsdLux.LightAPI(prim).CreateNormalizeAttr(True)
    (light,) = read_lights(stage)
    assert light.losses == ()
    round_shape = kind in ("Sphere", "Cylinder")
    np.testing.assert_allclose(light.radiance, 1.0 / area, rtol=0.005 if round_shape else 1e-6)


@pytest.mark.filterwarnings("ignore")
def test_what_is_lost_is_named(stage: Usd.Stage) -> None:
    light = UsdLux.RectLight.Define(stage, "/L")
    prim = light.GetPrim()
    UsdLux.ShapingAPI.Apply(prim).CreateShapingConeAngleAttr(30.0)
    UsdLux.ShapingAPI(prim).CreateShapingIesFileAttr("./a.ies")
    UsdLux.ShadowAPI.Apply(prim).CreateShadowEnableAttr(False)
    light.CreateDiffuseAttr(0.5)
    light.CreateTextureFileAttr("./none.png")
    light.CreateFiltersRel().AddTarget("/F")
    UsdLux.LightAPI(prim).GetShadowLinkCollectionAPI().ExcludePath(Sdf.Path("/X"))
    light.CreateIntensityAttr(math.nan)
    light.CreateColorAttr(Gf.Vec3f(-1.0, 1.0, 1.0))
    [read] = read_lights(stage)
    assert read.radiance.tolist() == [0.0, 1.0, 1.0]
    text = " ".join(read.losses)
    for word in (
        "a.ies",
        "shadow:enable",
        "diffuse",
        "none.png",
        "filters",
        "shadowLink",
        "not finite",
        "not physical",
    ):
        assert word in text, word
    plain = UsdLux.RectLight.Define(stage, "/Plain").GetPrim()
    UsdLux.ShapingAPI.Apply(plain)
    UsdLux.ShadowAPI.Apply(plain)
    assert read_lights(stage)[1].losses == ()
    dome = UsdLux.LightAPI(UsdLux.DomeLight.Define(stage, "/Dome"))
    dome.GetLightLinkCollectionAPI().ExcludePath(Sdf.Path("/X"))
    dome.CreateSpecularAttr(0.0)
    told = " ".join(read_lights(stage)[2].losses)
    assert "lightLink" in told and "no multipliers" in told


def test_dome_pictures_of_other_layouts_are_named(stage: Usd.Stage) -> None:
    light = UsdLux.DomeLight_1.Define(stage, "/L")
    light.CreateTextureFileAttr(__file__)
    light.CreateTextureFormatAttr("angular")
    [dome] = read_lights(stage)
    assert isinstance(dome, DomeLight)
    assert dome.texture is None and "angular" in dome.losses[0]
    light.CreateTextureFormatAttr("automatic")
    assert read_lights(stage)[0].texture == __file__


# Names of before USD 21.02.


def otherwise(attribute: Usd.Attribute, folder: Path) -> object:
    """A value that an input of a light does not have by itself."""
    value = attribute.Get()
    match value:
        case bool():
            return not value
        case float():
            return value + 0.25 if math.isfinite(value) else 2.0
        case Gf.Vec3f():
            return Gf.Vec3f(0.5, 0.25, 0.75)
        case str():
            return "latlong"
    is_profile = "ies" in attribute.GetName()
    return Sdf.AssetPath(str(folder / ("other.ies" if is_profile else "one.png")))


LIT = ("RectLight", "DiskLight", "SphereLight", "CylinderLight", "DistantLight", "DomeLight")


@pytest.mark.parametrize("kind", LIT)
def test_inputs_are_read_by_their_old_names(kind: str, tmp_path: Path) -> None:
    write_files(tmp_path)
    stages = [Usd.Stage.CreateInMemory() for _ in range(3)]
    now, old, usual = (stage.DefinePrim("/L", kind) for stage in stages)
    for prim in (now, old):
        for api in ("ShapingAPI", "ShadowAPI"):
            prim.ApplyAPI(api)
    inputs = [name for name in now.GetPropertyNames() if name.startswith("inputs:")]
    assert len(inputs) > 17
    for name in inputs:
        attribute = now.GetAttribute(name)
        attribute.Set(otherwise(attribute, tmp_path))
        made = old.CreateAttribute(name.removeprefix("inputs:"), attribute.GetTypeName())
        made.Set(attribute.Get())
    meant, read = read_light(now), read_light(old)
    *losses, told = (loss for loss in read.losses if loss.startswith("names of"))
    assert not losses
    assert all(name.removeprefix("inputs:") in told for name in inputs)
    same = [pickle.dumps(replace(light, losses=())) for light in (meant, read, read_light(usual))]
    assert same[0] == same[1] != same[2]
    assert set(read.losses) - {told} == set(meant.losses)


def test_an_input_counts_before_its_old_name(stage: Usd.Stage) -> None:
    light = UsdLux.RectLight.Define(stage, "/L")
    for name in ("intensity", "inputs:intensity", "filters"):
        if name == "filters":
            light.GetPrim().CreateRelationship(name).SetTargets(["/F"])
        else:
            made = light.GetPrim().CreateAttribute(name, Sdf.ValueTypeNames.Float)
            made.Set(10.0 * len(name))
    [read] = read_lights(stage)
    assert read.radiance.tolist() == [160.0] * 3
    assert read.losses == ("light:filters: light filters are left out",)
    shape = UsdGeom.Cylinder.Define(stage, "/Shape").GetPrim()
    UsdLux.MeshLightAPI.Apply(shape)
    assert not [loss for loss in read_light(shape).losses if "21.02" in loss]
