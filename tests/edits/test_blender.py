"""Of what Blender exports, what a person did becomes an edit; what Blender does of itself does not.

`exported` writes a room as Blender 5 does; `tests/blender` runs Blender itself.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from openrooms_usd import names
from openrooms_usd.edits.adopting import Adoption, adopt
from openrooms_usd.edits.blender_changes import SAME_AXIS, SAME_PLACE_METRES
from openrooms_usd.rules import validate_stage
from openrooms_usd.usd.light.lights import DistantLight, read_lights
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading.materialreader import preview_shader, read_preview_surface
from openrooms_usd.usd.shading.materials import bound_material

FURNITURE = "/World/Furniture"
PROXIES = Usd.TraverseInstanceProxies()
Change = Callable[[Usd.Stage, Callable[[str], Usd.Prim]], None]


def tag(prim: Usd.Prim, kind: str, name: str) -> None:
    """The name that Blender has for an object or for data, as it writes it."""
    key = f"userProperties:blender:{kind}_name"
    prim.CreateAttribute(key, Sdf.ValueTypeNames.String).Set(name)


class Exporter:
    """Writes what Blender makes of a composed stage: other names, other prims, 32 bits."""

    def __init__(self, stage: Usd.Stage, root: str, *, merged: bool) -> None:
        self.made = Usd.Stage.CreateInMemory()
        self.root, self.merged = root, merged
        self.counts: dict[str, int] = {}
        self.materials: dict[Sdf.Path, Sdf.Path] = {}
        UsdGeom.SetStageUpAxis(self.made, "Z")
        UsdGeom.SetStageMetersPerUnit(self.made, 1.0)
        self.made.GetRootLayer().documentation = "Blender v5.0.1"
        if root:
            prim = UsdGeom.Xform.Define(self.made, root).GetPrim()
            prim.SetCustomDataByKey("Blender:generated", True)
            self.made.SetDefaultPrim(prim)
        for prim in stage.GetPseudoRoot().GetChildren():
            self.put(prim, root)
        dome = UsdLux.DomeLight.Define(self.made, f"{root}/env_light")
        sky = UsdLux.LightAPI(stage.GetPrimAtPath(names.ENVIRONMENT))
        dome.CreateIntensityAttr(sky.GetIntensityAttr().Get())

    def counted(self, name: str, kind: str) -> str:
        number = self.counts[kind + name] = self.counts.get(kind + name, -1) + 1
        return f"{name}.{number:03d}" if number else name

    def put(self, prim: Usd.Prim, parent: str) -> None:
        """An object, its data and what is below it."""
        if prim.IsA(UsdLux.DomeLight) or prim.GetTypeName() in ("Material", "RenderSettings"):
            return
        if not UsdGeom.Imageable(prim) or prim.IsA(UsdGeom.Subset):
            return
        below = prim.GetFilteredChildren(PROXIES)
        local = (
            UsdGeom.Xformable(prim).GetLocalTransformation()
            if self.placed(prim)
            else Gf.Matrix4d(1)
        )
        if prim.GetTypeName() == "Xform" and len(below) == 1 and below[0].IsA(UsdGeom.Gprim):
            # Blender makes one object of both.
            [prim] = below
            local = UsdGeom.Xformable(prim).GetLocalTransformation() * local
            below = []
        name = self.counted(prim.GetName(), "")
        path = f"{parent}/{name.replace('.', '_')}"
        shape = prim.IsA(UsdGeom.Boundable) or prim.IsA(UsdGeom.Camera)
        kind = self.kind(prim) if shape and self.merged else "Xform"
        made = self.made.DefinePrim(path, kind)
        tag(made, "object", name)
        if local != Gf.Matrix4d(1):
            rounded = np.array(local, dtype=np.float32).astype(float)
            UsdGeom.Xformable(made).MakeMatrixXform().Set(Gf.Matrix4d(rounded))
        if shape:
            inner = (
                made
                if self.merged
                else self.made.DefinePrim(f"{path}/{prim.GetName()}", self.kind(prim))
            )
            self.describe(prim, inner)
        for child in below:
            self.put(child, path)

    @staticmethod
    def placed(prim: Usd.Prim) -> bool:
        return bool(UsdGeom.Xformable(prim))

    @staticmethod
    def kind(prim: Usd.Prim) -> str:
        return "SphereLight" if prim.IsA(UsdLux.PortalLight) else str(prim.GetTypeName())

    def describe(self, prim: Usd.Prim, inner: Usd.Prim) -> None:
        tag(inner, "data", prim.GetName())
        lens = ("focalLength", "horizontalAperture", "clippingRange")
        for name in lens if prim.IsA(UsdGeom.Camera) else ():
            inner.GetAttribute(name).Set(prim.GetAttribute(name).Get())
        if prim.IsA(UsdGeom.Camera):
            # The shape of the picture is Blender's own.
            inner.GetAttribute("verticalAperture").Set(0.2025)
        material = bound_material(prim)
        if prim.IsA(UsdGeom.Gprim) and material:
            found = UsdShade.Material(self.made.GetPrimAtPath(self.material(material)))
            UsdShade.MaterialBindingAPI.Apply(inner).Bind(found)

    def material(self, material: UsdShade.Material) -> Sdf.Path:
        """Constants are kept; of pictures, that there is one."""
        if material.GetPath() not in self.materials:
            name = self.counted(material.GetPrim().GetName(), "material ")
            path = f"{self.root}/_materials/{name.replace('.', '_')}"
            made = UsdShade.Material.Define(self.made, path)
            tag(made.GetPrim(), "data", name)
            shader = UsdShade.Shader.Define(self.made, f"{path}/Principled_BSDF")
            shader.CreateIdAttr("UsdPreviewSurface")
            made.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
            ours = preview_shader(material)
            for key in ("diffuseColor", "emissiveColor"):
                found = ours.GetInput(key) if ours else None
                new = shader.CreateInput(key, Sdf.ValueTypeNames.Color3f)
                if found and found.HasConnectedSource():
                    picture = UsdShade.Shader.Define(self.made, f"{path}/Image_Texture")
                    picture.CreateIdAttr("UsdUVTexture")
                    new.ConnectToSource(picture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3))
                elif found and found.Get() is not None:
                    new.Set(found.Get())
            self.materials[material.GetPath()] = Sdf.Path(path)
        return self.materials[material.GetPath()]

    def find(self, name: str) -> Usd.Prim:
        """The first object of a name."""
        for prim in self.made.Traverse():
            given = prim.GetAttribute("userProperties:blender:object_name")
            if given and given.Get() == name:
                return prim
        raise AssertionError(f"no object {name}")


FORMS = [("/root", False), ("/scene", True), ("", False), ("", True)]


def local(prim: Usd.Prim) -> Gf.Matrix4d:
    return UsdGeom.Xformable(prim).GetLocalTransformation()


def exported(place: Any, change: Change, root: str = "/root", *, merged: bool = False) -> Path:
    written = Exporter(place.stage(), root, merged=merged)
    change(written.made, written.find)
    path: Path = place.out.parent / "blender.usda"
    written.made.GetRootLayer().Export(str(path))
    return path


def moved(prim: Usd.Prim, *by: float) -> None:
    place = UsdGeom.Xformable(prim)
    matrix = place.GetLocalTransformation()
    matrix.SetTranslateOnly(matrix.ExtractTranslation() + Gf.Vec3d(*by))
    place.MakeMatrixXform().Set(matrix)


def nothing(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
    """Changes nothing."""


def changed(adoption: Adoption) -> dict[str, tuple[str, ...]]:
    return {x.path: x.fields for x in adoption.changes if not x.path.startswith("/World/Looks")}


def errors(place: Any) -> list[str]:
    return [str(found) for found in validate_stage(place.scene) if found.severity == "error"]


@pytest.mark.one_in(4)
@pytest.mark.parametrize(("root", "merged"), FORMS)
def test_what_blender_does_of_itself_is_no_edit(place: Any, root: str, merged: bool) -> None:
    before = place.tree()
    adoption = adopt(place.scene, exported(place, nothing, root, merged=merged))
    assert (adoption.changes, adoption.left) == ((), ())
    assert adoption.compared > 30
    assert place.tree() == before


def rearranged(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
    moved(find("sofa"), 0.5, 0.25, 0.0)
    moved(find("lamp"), 0.0, -0.2, 0.0)
    moved(find("eye"), 0.0, 0.0, 0.3)
    for prim in stage.Traverse():
        if prim.GetName() == "eye" and prim.IsA(UsdGeom.Camera):
            prim.GetAttribute("focalLength").Set(0.5)
    stage.RemovePrim(find("chair_b").GetPath())


@pytest.mark.one_in(16)
@pytest.mark.parametrize(("root", "merged"), FORMS)
def test_what_somebody_did_is_said_in_a_few_words(place: Any, root: str, merged: bool) -> None:
    adoption = adopt(place.scene, exported(place, rearranged, root, merged=merged))
    assert changed(adoption) == {
        f"{FURNITURE}/sofa": ("xformOp:translate",),
        f"{FURNITURE}/lamp": ("xformOp:translate",),
        f"{FURNITURE}/chair_b": ("active",),
        "/World/Cameras/eye": ("xformOp:transform", "xformOpOrder", "focalLength"),
    }
    assert adoption.left == ()
    assert len(place.edits.read_text()) < 2000
    place.compose()
    assert errors(place) == []
    stage = place.stage()
    sofa = UsdGeom.Xformable(stage.GetPrimAtPath(f"{FURNITURE}/sofa"))
    np.testing.assert_allclose(
        sofa.GetLocalTransformation().ExtractTranslation(), [2.5, 3.25, 0.0], atol=1e-6
    )
    assert stage.GetPrimAtPath(f"{FURNITURE}/sofa").IsInstance()
    assert stage.GetPrimAtPath("/World/Cameras/eye").GetAttribute("focalLength").Get() == 0.5


@pytest.mark.slow
def test_a_file_that_is_saved_over_the_scene_is_adopted_and_the_scene_restored(place: Any) -> None:
    wanted = place.scene.read_bytes()
    exported(place, rearranged).replace(place.scene)
    with pytest.raises(Exception, match="another program has saved"):
        place.compose()
    assert f"{FURNITURE}/sofa" in changed(adopt(place.scene))
    assert place.scene.read_bytes() == wanted
    place.compose()
    assert errors(place) == []


@pytest.mark.slow
def test_the_same_file_twice_says_nothing_new(place: Any) -> None:
    def more(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        rearranged(stage, find)
        crate(stage, find)

    file = exported(place, more)
    adopt(place.scene, file)
    before = place.tree()
    again = adopt(place.scene, file)
    assert (changed(again), again.left, again.written) == ({}, (), False)
    assert place.tree() == before


@pytest.mark.one_in(4)
@pytest.mark.parametrize(
    ("by", "turn", "edited"),
    [
        (0.5 * SAME_PLACE_METRES, 0.0, False),
        (2 * SAME_PLACE_METRES, 0.0, True),
        (0.0, 0.5 * SAME_AXIS, False),
        (0.0, 2 * SAME_AXIS, True),
    ],
)
def test_the_tolerance_is_what_it_is_said_to_be(
    place: Any, by: float, turn: float, edited: bool
) -> None:
    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        where = UsdGeom.Xformable(find("sofa"))
        before = where.GetLocalTransformation()
        rotation = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(0, 0, 1), np.degrees(turn)))
        where.MakeMatrixXform().Set(rotation * before * Gf.Matrix4d().SetTranslate((by, 0, 0)))

    assert bool(changed(adopt(place.scene, exported(place, change)))) == edited


@pytest.mark.slow
def test_a_turn_and_a_scale_arrive(place: Any) -> None:
    turned = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 2, 3), 50.0))
    wanted = Gf.Matrix4d().SetScale((1.0, 2.0, 0.5)) * turned
    wanted.SetTranslateOnly((1.0, 2.0, 0.25))

    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        UsdGeom.Xformable(find("table")).MakeMatrixXform().Set(wanted)

    adopt(place.scene, exported(place, change))
    stage = place.stage()
    table = UsdGeom.Xformable(stage.GetPrimAtPath(f"{FURNITURE}/table"))
    np.testing.assert_allclose(
        np.array(table.GetLocalTransformation()), np.array(wanted), atol=2e-6
    )
    assert [op.GetOpName() for op in table.GetOrderedXformOps()] == [
        "xformOp:translate",
        "xformOp:rotateXYZ",
        "xformOp:scale",
    ]


def test_a_door_that_is_opened_in_blender_is_open(place: Any) -> None:
    """What Blender has made one object of two prims turns about the pivot all the same."""

    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        where = UsdGeom.Xformable(find("Leaf"))
        turn = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(0, 0, 1), 20.0))
        where.MakeMatrixXform().Set(turn * where.GetLocalTransformation())

    leaf = "/World/Room/Openings/door/Leaf"
    first = place.stage()
    before = UsdGeom.Xformable(first.GetPrimAtPath(leaf)).GetLocalTransformation()
    adoption = adopt(place.scene, exported(place, change))
    assert set(changed(adoption)) == {leaf}
    second = place.stage()
    after = UsdGeom.Xformable(second.GetPrimAtPath(leaf)).GetLocalTransformation()
    np.testing.assert_allclose(before.ExtractTranslation(), after.ExtractTranslation(), atol=1e-6)
    turn = (after * before.GetInverse()).ExtractRotation()
    assert turn.GetAngle() == pytest.approx(20.0, abs=1e-4)


def crate(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
    root = str(find("World").GetPath().GetParentPath()).rstrip("/")
    box = UsdGeom.Xform.Define(stage, f"{root}/Crate")
    box.AddTranslateOp().Set((3.0, 2.0, 0.2))
    tag(box.GetPrim(), "object", "Crate")
    mesh = UsdGeom.Mesh.Define(stage, f"{root}/Crate/Cube")
    tag(mesh.GetPrim(), "data", "Cube")
    mesh.CreatePointsAttr([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateExtentAttr([(0, 0, 0), (1, 1, 0)])
    mesh.CreateSubdivisionSchemeAttr("none")
    paint = UsdShade.Material.Define(stage, f"{root}/_materials/Red_Paint")
    shader = UsdShade.Shader.Define(stage, f"{root}/_materials/Red_Paint/Principled_BSDF")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set((0.9, 0.1, 0.1))
    paint.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(paint)


@pytest.mark.slow
def test_new_objects_come_with_their_materials(place: Any) -> None:
    adoption = adopt(place.scene, exported(place, crate))
    assert set(changed(adoption)) == {"/World/Crate", "/World/Crate/Cube"}
    place.compose()
    assert errors(place) == []
    stage = place.stage()
    material = bound_material(stage.GetPrimAtPath("/World/Crate/Cube"))
    assert material is not None and str(material.GetPath()) == "/World/Looks/Red_Paint"
    shader = preview_shader(material)
    assert shader is not None
    np.testing.assert_allclose(shader.GetInput("diffuseColor").Get(), [0.9, 0.1, 0.1], atol=1e-6)
    assert "blender" not in place.edits.read_text()


@pytest.mark.slow
def test_a_copy_of_an_object_refers_to_it(place: Any) -> None:
    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        table = find("table")
        path = table.GetPath().ReplaceName("table_001")
        layer = stage.GetRootLayer()
        Sdf.CopySpec(layer, table.GetPath(), layer, path)
        copy = stage.GetPrimAtPath(path)
        copy.GetAttribute("userProperties:blender:object_name").Set("table.001")
        moved(copy, 1.5, 0.0, 0.0)

    adoption = adopt(place.scene, exported(place, change))
    copied = f"{FURNITURE}/table_001"
    assert set(changed(adoption)) == {copied}
    place.compose()
    stage = place.stage()
    table, copy = (stage.GetPrimAtPath(f"{FURNITURE}/{name}") for name in ("table", "table_001"))
    assert copy.IsInstance() and read_label(copy, names.CATEGORY) == "table"
    parts = [
        [child.GetName() for child in prim.GetChild("Geometry").GetFilteredChildren(PROXIES)]
        for prim in (table, copy)
    ]
    assert parts[0] == parts[1] != []
    offset = local(copy).ExtractTranslation() - local(table).ExtractTranslation()
    np.testing.assert_allclose(offset, [1.5, 0.0, 0.0], atol=1e-6)
    assert errors(place) == []


@pytest.mark.slow
def test_below_an_instance_there_is_room_once_it_is_opened(place: Any) -> None:
    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        ball = UsdGeom.Sphere.Define(stage, find("sofa").GetPath().AppendChild("Ball"))
        tag(ball.GetPrim(), "object", "Ball")
        tag(ball.GetPrim(), "data", "Ball")

    adopt(place.scene, exported(place, change))
    place.compose()
    assert place.stage().GetPrimAtPath(f"{FURNITURE}/sofa/Ball")
    assert errors(place) == []


@pytest.mark.slow
def test_lamps_and_the_sky_are_as_bright_as_in_blender(place: Any) -> None:
    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        for prim in stage.Traverse():
            glow = prim.GetAttribute("inputs:emissiveColor")
            if glow and glow.Get() is not None and max(glow.Get()) > 0:
                glow.Set(glow.Get() * 0.25)
            if prim.GetName() == "env_light":
                sky = UsdLux.LightAPI(prim).GetIntensityAttr()
                sky.Set(sky.Get() * 3)

    before = {light.path: light.radiance for light in read_lights(place.stage())}
    adoption = adopt(place.scene, exported(place, change))
    bulb = f"{FURNITURE}/lamp/Geometry/light_bulb"
    assert changed(adoption) == {
        bulb: ("inputs:intensity",),
        names.ENVIRONMENT: ("inputs:intensity",),
    }
    after = {light.path: light.radiance for light in read_lights(place.stage())}
    np.testing.assert_allclose(after[bulb], 0.25 * before[bulb], rtol=1e-5)
    np.testing.assert_allclose(after[names.ENVIRONMENT], 3 * before[names.ENVIRONMENT], rtol=1e-5)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("color", [(5000.0, 100.0, 100.0), (0.0, 0.0, 0.0)])
def test_a_lamp_of_another_hue(place: Any, color: tuple[float, float, float]) -> None:
    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        for prim in stage.Traverse():
            glow = prim.GetAttribute("inputs:emissiveColor")
            if glow and glow.Get() is not None and max(glow.Get()) > 0:
                glow.Set(Gf.Vec3f(*color))

    adopt(place.scene, exported(place, change))
    place.compose()
    stage = place.stage()
    [bulb] = [x for x in read_lights(stage) if x.path.endswith("light_bulb")]
    np.testing.assert_allclose(bulb.radiance, color, rtol=1e-5)
    material = bound_material(stage.GetPrimAtPath(bulb.path))
    shader = preview_shader(material) if material else None
    glow = shader.GetInput("emissiveColor").Get() if shader and any(color) else None
    assert glow is None or tuple(glow) == pytest.approx(color, rel=1e-5)


@pytest.mark.slow
def test_a_plain_base_colour_is_taken_over(place: Any) -> None:
    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        for prim in stage.Traverse():
            color = prim.GetAttribute("inputs:diffuseColor")
            if prim.GetParent().GetName().startswith("bulb_"):
                color.Set(Gf.Vec3f(0.1, 0.2, 0.3))

    adopt(place.scene, exported(place, change))
    place.compose()
    stage = place.stage()
    material = bound_material(stage.GetPrimAtPath(f"{FURNITURE}/lamp/Geometry/light_bulb"))
    shader = preview_shader(material) if material else None
    assert shader is not None
    np.testing.assert_allclose(shader.GetInput("diffuseColor").Get(), [0.1, 0.2, 0.3], atol=1e-6)


@pytest.mark.one_in(4)
@pytest.mark.parametrize("kelvin", [None, 3000.0])
def test_lamps_of_blender_are_white_unless_they_have_a_temperature(
    place: Any, kelvin: float | None
) -> None:
    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        root = str(find("World").GetPath().GetParentPath()).rstrip("/")
        sun = UsdLux.DistantLight.Define(stage, f"{root}/Sun")
        tag(sun.GetPrim(), "object", "Sun")
        tag(sun.GetPrim(), "data", "Sun")
        # As Blender 5.0 writes 1000 W/m2 and an angle of 1 degree.
        sun.CreateIntensityAttr(250.0)
        sun.CreateAngleAttr(0.5)
        sun.CreateNormalizeAttr(True)
        sun.CreateEnableColorTemperatureAttr(True)
        if kelvin is not None:
            sun.CreateColorTemperatureAttr(kelvin)

    adopt(place.scene, exported(place, change))
    [sun] = [x for x in read_lights(place.stage()) if x.path.endswith("/Sun")]
    assert isinstance(sun, DistantLight) and sun.angle == pytest.approx(1.0)
    hue = np.ones(3) if kelvin is None else np.array(UsdLux.BlackbodyTemperatureAsRgb(kelvin))
    np.testing.assert_allclose(sun.irradiance, 1000.0 * hue, rtol=1e-5)


@pytest.mark.slow
def test_paint_over_a_picture_is_taken_over_and_the_picture_left(place: Any) -> None:
    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        for prim in stage.Traverse():
            material = bound_material(prim) if prim.GetName() == "lamp_shade" else None
            if material and (shader := preview_shader(material)):
                shader.GetInput("diffuseColor").ClearSources()
                shader.GetInput("diffuseColor").Set(Gf.Vec3f(0.1, 0.2, 0.3))

    adopt(place.scene, exported(place, change))
    place.compose()
    stage = place.stage()
    material = bound_material(stage.GetPrimAtPath(f"{FURNITURE}/lamp/Geometry/lamp_shade"))
    assert material and read_preview_surface(material)[0].base_color == pytest.approx(
        (0.1, 0.2, 0.3)
    )
    assert errors(place) == []


def test_of_a_selection_nothing_is_switched_off(place: Any) -> None:
    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        moved(find("sofa"), 0.5, 0.0, 0.0)
        for name in ("Room", "Cameras", "table", "chair_a", "chair_b", "lamp", "Lights"):
            stage.RemovePrim(find(name).GetPath())

    adoption = adopt(place.scene, exported(place, change))
    assert set(changed(adoption)) == {f"{FURNITURE}/sofa"}
    assert len(adoption.left) == 1 and "selection" in adoption.left[0]


def test_of_a_selection_with_a_camera_the_others_stay_too(place: Any) -> None:
    """Half of the cameras are there; the meshes tell that the file is of a selection."""
    layer = Sdf.Layer.FindOrOpen(str(place.scene.parent / "layers" / "edits.usda"))
    beside = Usd.Stage.Open(layer)
    for name in ("one", "two"):
        UsdGeom.Camera.Define(beside, f"/World/Cameras/{name}")
    layer.Save()

    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        for name in ("two", "Room", "table", "chair_a", "chair_b", "lamp", "Lights"):
            stage.RemovePrim(find(name).GetPath())

    adoption = adopt(place.scene, exported(place, change))
    assert not [fields for fields in changed(adoption).values() if "active" in fields]
    assert sum("selection" in sentence for sentence in adoption.left) == 1


def test_another_material_on_a_part_is_named(place: Any) -> None:
    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        other = next(p for p in stage.Traverse() if p.GetName().startswith("bulb_"))
        mesh = find("wall_0").GetChild("wall_0")
        UsdShade.MaterialBindingAPI.Apply(mesh).Bind(UsdShade.Material(other))

    adoption = adopt(place.scene, exported(place, change))
    assert changed(adoption) == {}
    assert (
        len(adoption.left) == 1
        and "/World/Room/Walls/wall_0 now has the material bulb_" in adoption.left[0]
    )


NESTED = """
over "World"
{
    def Xform "Stand"
    {
        double3 xformOp:translate = (1, 2, 0)
        float3 xformOp:rotateXYZ = (0, 0, 90)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]

        def Mesh "Plate"
        {
            int[] faceVertexCounts = [3]
            int[] faceVertexIndices = [0, 1, 2]
            point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
            float3[] extent = [(0, 0, 0), (1, 1, 0)]
            uniform token subdivisionScheme = "none"
            double3 xformOp:translate = (0.5, 0.25, 1)
            uniform token[] xformOpOrder = ["xformOp:translate"]
        }
    }
}
"""


@pytest.mark.parametrize("by", [0.0, 0.75])
def test_what_has_become_one_object_is_two_prims_again(place: Any, by: float) -> None:
    place.write_edits(NESTED)

    def change(stage: Usd.Stage, find: Callable[[str], Usd.Prim]) -> None:
        assert not any(prim.GetName() == "Stand" for prim in stage.Traverse())
        moved(find("Plate"), by, 0.0, 0.0)

    adoption = adopt(place.scene, exported(place, change))
    assert changed(adoption) == ({"/World/Stand": ("xformOp:translate",)} if by else {})
    stage = place.stage()
    stand = local(stage.GetPrimAtPath("/World/Stand")).ExtractTranslation()
    np.testing.assert_allclose(stand, [1.0 + by, 2.0, 0.0], atol=1e-6)
