"""Each attribute of each type that USD knows, with a value of another type than the schema's."""

import pytest
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, Vt

from openrooms_usd.errors import OrusdError
from openrooms_usd.usd.files.diagnostics import quiet
from openrooms_usd.usd.rendersettings import asked_cameras, asked_resolution, settings_losses
from tests.anystage.properties import faults, scene_of, views

OTHERS = (
    ("string", "none"),
    ("double", 0.5),
    ("float[]", Vt.FloatArray([0.5, 2.0])),
    ("float3", Gf.Vec3f(1.0, 2.0, 3.0)),
    ("token[]", Vt.TokenArray(["none"])),
)


def concrete() -> list[str]:
    known = Usd.SchemaRegistry()
    found = (known.GetConcreteSchemaTypeName(one) for one in _all(Tf.Type.Find(Usd.Typed)))
    return sorted(filter(None, found))


def _all(kind: Tf.Type) -> set[Tf.Type]:
    return {one for child in kind.derivedTypes for one in (child, *_all(child))}


def stage_with(kind: str, name: str, type_name: str, value: object) -> Usd.Stage:
    """A square with a camera, and a prim of a type with one attribute that is of another."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    mesh = UsdGeom.Mesh.Define(stage, "/Square")
    mesh.CreatePointsAttr([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    UsdGeom.Camera.Define(stage, "/Eye")
    stage.DefinePrim("/It", kind)
    stage.SetMetadata("renderSettingsPrimPath", "/It" if kind == "RenderSettings" else "/Render")
    render = stage.DefinePrim("/Render", "RenderSettings")
    render.GetRelationship("products").SetTargets(["/It"])
    spec = Sdf.AttributeSpec(layer.GetPrimAtPath("/It"), name, Sdf.ValueTypeNames.Find(type_name))
    spec.default = value
    return stage


@pytest.mark.slow
@pytest.mark.one_in(2, rest="long")
@pytest.mark.parametrize("kind", concrete())
def test_a_value_of_another_type_is_a_scene_or_a_sentence(kind: str) -> None:
    definition = Usd.SchemaRegistry().FindConcretePrimDefinition(kind)
    assert definition is not None
    for name in definition.GetPropertyNames():
        if not definition.GetAttributeDefinition(name):
            continue
        for type_name, value in OTHERS:
            stage = stage_with(kind, name, type_name, value)
            try:
                scene = scene_of(stage)
                with quiet():
                    views(stage)
                    asked_cameras(stage)
                    asked_resolution(stage)
                    list(settings_losses(stage))
            except OrusdError:
                continue
            assert not faults(scene), (name, type_name)
