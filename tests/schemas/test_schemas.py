"""The codeless schemas are fresh, register, and change nothing about what is authored."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import get_args

import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

import orusd_schemas
from openrooms_usd.description.layout import STYLES, Opening
from openrooms_usd.description.room import RoomType

# Every property of every schema: its type, and the value that the stages might author.
PROPERTIES = {
    "OpenRoomsRoomAPI": {
        "openrooms:room:type": ("token", "office"),
        "openrooms:room:height": ("double", 2.6),
        "openrooms:room:floor": ("double2[]", [Gf.Vec2d(0, 0), Gf.Vec2d(4, 0), Gf.Vec2d(0, 3)]),
    },
    "OpenRoomsPartitionAPI": {
        "openrooms:partition:outline": ("double2[]", [Gf.Vec2d(0, 0), Gf.Vec2d(4, 0)]),
        "openrooms:partition:height": ("double", 2.1),
    },
    "OpenRoomsOpeningAPI": {
        "openrooms:opening:kind": ("token", "window"),
        "openrooms:opening:width": ("double", 1.2),
        "openrooms:opening:height": ("double", 1.3),
        "openrooms:opening:sill": ("double", 0.9),
        "openrooms:opening:style": ("token", "glazed"),
        "openrooms:opening:wall": ("rel", "/World/Room/Walls/wall_0"),
    },
    "OpenRoomsJointAPI": {
        "openrooms:joint:type": ("token", "rail"),
        "openrooms:joint:axis": ("float3", Gf.Vec3f(0, -1, 0)),
        "openrooms:joint:lower": ("float", 0.0),
        "openrooms:joint:upper": ("float", 0.5),
    },
    "OpenRoomsSourceAPI": {
        "openrooms:source:file": ("string", "room.json"),
        "openrooms:source:id": ("string", "3F2A"),
        "openrooms:source:confidence": ("token", "high"),
        "openrooms:source:fromWorld": ("matrix4d", Gf.Matrix4d(1)),
    },
    "OpenRoomsAlignmentAPI": {
        "openrooms:alignment:residual": ("double", 0.012),
        "openrooms:alignment:coverage": ("double", 0.6),
        "openrooms:alignment:symmetry": ("token", "4"),
        "openrooms:alignment:support": ("token", "object"),
        "openrooms:alignment:carrier": ("rel", "/World/Furniture/table_0"),
    },
    "OpenRoomsMaterialAPI": {
        "openrooms:material:category": ("token", "wood"),
        "openrooms:material:family": ("token", "oak_planks"),
        "openrooms:material:number": ("int", 7),
        "openrooms:material:size": ("float2", Gf.Vec2f(1, 2)),
        "openrooms:material:transmission": ("float", 0.5),
        "openrooms:material:f0": ("float", 0.05),
        "openrooms:material:pane": ("color3f", (0.98, 0.99, 0.98)),
        "openrooms:material:frictionSpread": ("float", 0.1),
    },
}

# Authored as the stages do it: the schema's name as data, the properties not custom.
AUTHOR = """
from pxr import Sdf, Usd, UsdGeom, UsdShade
stage = Usd.Stage.CreateInMemory(".usda")
prim = UsdGeom.Xform.Define(stage, "/Room").GetPrim()
prim.AddAppliedSchema("OpenRoomsRoomAPI")
kind = Sdf.ValueTypeNames
prim.CreateAttribute("openrooms:room:type", kind.Token, custom=False).Set("office")
prim.CreateAttribute("openrooms:room:height", kind.Double, custom=False).Set(2.6)
prim.CreateAttribute("openrooms:room:floor", kind.Double2Array, custom=False).Set([(0, 0), (4, 0)])
opening = UsdGeom.Xform.Define(stage, "/Window").GetPrim()
opening.AddAppliedSchema("OpenRoomsOpeningAPI")
opening.CreateRelationship("openrooms:opening:wall", custom=False).SetTargets(["/Room"])
print(stage.GetRootLayer().ExportToString())
"""


def definition(schema: str) -> Usd.PrimDefinition:
    found = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(schema)
    assert found, f"{schema} is not registered"
    return found


def test_generated_files_are_fresh() -> None:
    command = [sys.executable, "-m", "pxr.Usd.usdGenSchema", "-v"]
    folder = orusd_schemas.PATH
    done = subprocess.run(
        [*command, folder / "schema.usda", folder], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("schema", PROPERTIES)
def test_a_schema_has_exactly_these_properties(schema: str) -> None:
    found = definition(schema)
    assert set(found.GetPropertyNames()) == set(PROPERTIES[schema])
    for name, (type_name, _) in PROPERTIES[schema].items():
        spec = found.GetSchemaPropertySpec(name)
        actual = "rel" if isinstance(spec, Sdf.RelationshipSpec) else str(spec.typeName)
        assert actual == type_name
        assert spec.customData["userDocBrief"]


@pytest.mark.parametrize("schema", PROPERTIES)
def test_a_schema_applies_to_what_it_is_for(schema: str) -> None:
    stage = Usd.Stage.CreateInMemory()
    xform = UsdGeom.Xform.Define(stage, "/Xform").GetPrim()
    shade = UsdShade.Material.Define(stage, "/Material").GetPrim()
    if schema == "OpenRoomsPartitionAPI":
        xform = UsdGeom.Mesh.Define(stage, "/Mesh").GetPrim()
    allowed = {"OpenRoomsMaterialAPI": (False, True), "OpenRoomsSourceAPI": (True, True)}.get(
        schema, (True, False)
    )
    assert (bool(xform.CanApplyAPI(schema)), bool(shade.CanApplyAPI(schema))) == allowed


def test_fallbacks_and_allowed_values_are_those_of_the_description() -> None:
    room, opening = definition("OpenRoomsRoomAPI"), definition("OpenRoomsOpeningAPI")
    assert room.GetAttributeFallbackValue("openrooms:room:type") == "misc"
    assert opening.GetAttributeFallbackValue("openrooms:opening:kind") == "opening"
    types = room.GetSchemaAttributeSpec("openrooms:room:type").allowedTokens
    assert tuple(types) == get_args(RoomType)
    styles = opening.GetSchemaAttributeSpec("openrooms:opening:style").allowedTokens
    assert tuple(styles) == ("", *(name for known in STYLES.values() for name in known))
    kinds = opening.GetSchemaAttributeSpec("openrooms:opening:kind").allowedTokens
    assert tuple(kinds) == get_args(Opening.model_fields["kind"].annotation)
    for name in ("width", "height", "sill"):
        spec = opening.GetSchemaAttributeSpec(f"openrooms:opening:{name}")
        assert spec.limits["hard"]["minimum"] == 0


def run_plain(code: str, **environment: str) -> str:
    """Run code in a Python that has not registered the schemas by importing them."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, **environment},
    )
    return done.stdout


@pytest.mark.slow
def test_what_is_authored_is_the_same_without_the_plugin() -> None:
    without = run_plain(AUTHOR)
    assert run_plain("import orusd_schemas\n" + AUTHOR) == without
    assert "custom" not in without and 'token openrooms:room:type = "office"' in without


def test_other_tools_find_the_schemas_by_the_plugin_path() -> None:
    code = (
        "from pxr import Usd\n"
        "found = Usd.SchemaRegistry().FindAppliedAPIPrimDefinition('OpenRoomsRoomAPI')\n"
        "print(bool(found))"
    )
    assert run_plain(code).strip() == "False"
    assert run_plain(code, PXR_PLUGINPATH_NAME=str(orusd_schemas.PATH)).strip() == "True"


def test_a_composed_room_says_nothing_that_no_schema_knows(composed_demo: Path) -> None:
    """Names, types and values of every ``openrooms:`` property against the schemas."""
    stage = Usd.Stage.Open(str(composed_demo))
    seen = set()
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        ours = [name for name in prim.GetAppliedSchemas() if name.startswith("OpenRooms")]
        assert set(ours) <= set(PROPERTIES), prim
        properties = [
            p for p in prim.GetAuthoredProperties() if p.GetName().startswith("openrooms:")
        ]
        for prop in properties:
            owner = next((s for s in ours if prop.GetName() in PROPERTIES[s]), None)
            assert owner, f"{prop} belongs to no applied schema ({ours})"
            type_name, _ = PROPERTIES[owner][prop.GetName()]
            is_attribute = isinstance(prop, Usd.Attribute)
            assert (str(prop.GetTypeName()) if is_attribute else "rel") == type_name
            assert not prop.IsCustom(), prop
            allowed = prop.GetMetadata("allowedTokens") if is_attribute else None
            assert not allowed or prop.Get() in allowed, prop
            seen.add(owner)
    assert {"OpenRoomsRoomAPI", "OpenRoomsOpeningAPI"} <= seen


def test_plug_info_is_relocatable() -> None:
    text = (orusd_schemas.PATH / "plugInfo.json").read_text()
    body = "\n".join(line for line in text.splitlines() if not line.lstrip().startswith("#"))
    (plugin,) = json.loads(body)["Plugins"]
    assert (plugin["Root"], plugin["ResourcePath"], plugin["Type"]) == (".", ".", "resource")
