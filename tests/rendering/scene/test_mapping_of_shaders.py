"""The table of all concepts of USD is true of shaders: each input is changed alone."""

import fnmatch
from pathlib import Path
from typing import Any

import pytest
from pxr import Gf, Sdf, Sdr, Usd, UsdGeom, UsdShade

from openrooms_usd.exporters import Report
from openrooms_usd.rendering.scene.digest import light_digest
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd import mapping
from tests.rendering.scene.schemas import MATERIAL, SURFACE, bind, write_files

Kind = Sdf.ValueTypeNames
TEXTURE, TURN, READER = (f"{MATERIAL}/{name}" for name in ("Texture", "Turn", "Reader"))
OTHER_READER = f"{MATERIAL}/OtherReader"


def textured(reader: str = "UsdPrimvarReader_float2") -> Usd.Stage:
    """A square whose base colour is a picture, by turned coordinates."""
    stage = Usd.Stage.CreateInMemory()
    square = UsdGeom.Mesh.Define(stage, "/World/Square")
    square.CreatePointsAttr([(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)])
    square.CreateFaceVertexCountsAttr([4])
    square.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    square.CreateSubdivisionSchemeAttr("none")
    primvars = UsdGeom.PrimvarsAPI(square)
    for name, size in (("st", 1), ("other", 2)):
        found = primvars.CreatePrimvar(name, Kind.TexCoord2fArray, "vertex")
        found.Set([(0, 0), (size, 0), (size, size), (0, size)])
    for name, level in (("paint", 0.2), ("varnish", 0.7)):
        paint = primvars.CreatePrimvar(name, Kind.Color3fArray, "vertex")
        paint.Set([(level, 0, 0), (0, level, 0), (0, 0, level), (1, 1, level)])
    material = UsdShade.Material.Define(stage, MATERIAL)
    surface = node(stage, SURFACE, "UsdPreviewSurface")
    material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", Kind.Token))
    picture, turn = node(stage, TEXTURE, "UsdUVTexture"), node(stage, TURN, "UsdTransform2d")
    given, other = node(stage, READER, reader), node(stage, OTHER_READER, reader)
    given.CreateInput("varname", Kind.String).Set("st")
    other.CreateInput("varname", Kind.String).Set("other")
    turn.CreateInput("rotation", Kind.Float).Set(30.0)
    picture.CreateInput("file", Kind.Asset).Set("one.png")
    connect(turn, "in", given, Kind.Float2)
    connect(picture, "st", turn, Kind.Float2)
    connect(surface, "diffuseColor", picture, Kind.Color3f, "rgb")
    bind(square.GetPrim())
    return stage


def node(stage: Usd.Stage, path: str, kind: str) -> UsdShade.Shader:
    made = UsdShade.Shader.Define(stage, path)
    made.CreateIdAttr(kind)
    return made


def connect(
    to: UsdShade.Shader, name: str, source: UsdShade.Shader, kind: Any, output: str = "result"
) -> None:
    to.CreateInput(name, kind).ConnectToSource(source.CreateOutput(output, kind))


def at(stage: Usd.Stage, path: str) -> UsdShade.Shader:
    return UsdShade.Shader(stage.GetPrimAtPath(path))


def give(stage: Usd.Stage, path: str, values: dict[str, Any]) -> None:
    """Set inputs of a shader, of the types that the registry says."""
    shader = at(stage, path)
    known = Sdr.Registry().GetShaderNodeByIdentifier(str(shader.GetShaderId()))
    for name, value in values.items():
        kind = known.GetShaderInput(name).GetTypeAsSdfType().GetSdfType()
        socket = shader.CreateInput(name, kind)
        UsdShade.ConnectableAPI.ClearSources(socket)
        assert socket.Set(value), name


# What each input becomes, and what must be there for it to count.
SURFACES: dict[str, tuple[Any, dict[str, Any]]] = {
    "diffuseColor": ((0.5, 0.1, 0.2), {}),
    "useSpecularWorkflow": (1, {}),
    "specularColor": ((0.5, 0.1, 0.2), {"useSpecularWorkflow": 1}),
    "metallic": (1.0, {}),
    "roughness": (0.2, {}),
    "clearcoat": (1.0, {}),
    "clearcoatRoughness": (0.4, {"clearcoat": 1.0}),
    "opacity": (0.4, {}),
    "opacityThreshold": (0.5, {"opacity": 0.4}),
    "opacityMode": ("presence", {"opacity": 0.4}),
    "ior": (1.8, {}),
    "emissiveColor": ((1.0, 2.0, 3.0), {}),
    "normal": ((0.6, 0.0, 0.8), {}),
    "displacement": (0.1, {}),
    "occlusion": (0.3, {}),
}
TEXTURES: dict[str, tuple[Any, dict[str, Any]]] = {
    "file": (Sdf.AssetPath("other.png"), {}),
    "wrapS": ("mirror", {}),
    "wrapT": ("mirror", {}),
    "sourceColorSpace": ("raw", {}),
    "scale": (Gf.Vec4f(0.5), {}),
    "bias": (Gf.Vec4f(0.1), {}),
    "fallback": (Gf.Vec4f(0.3, 0.2, 0.1, 1.0), {"file": Sdf.AssetPath("none.png")}),
}
TURNS: dict[str, tuple[Any, dict[str, Any]]] = {
    "rotation": (60.0, {}),
    "scale": (Gf.Vec2f(2.0, 3.0), {}),
    "translation": (Gf.Vec2f(0.3, 0.2), {}),
}


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_files(tmp_path)
    monkeypatch.chdir(tmp_path)


def made_of(stage: Usd.Stage) -> tuple[str, str]:
    """What is rendered, and what the report says of the material."""
    scene = translate(stage)
    return light_digest(scene), said(scene.report)


def said(report: Report) -> str:
    return "; ".join(why for prim, _, why in report.rows if prim == MATERIAL)


@pytest.mark.parametrize(
    ("path", "shader", "inputs"),
    [
        (SURFACE, "UsdPreviewSurface", SURFACES),
        (TEXTURE, "UsdUVTexture", TEXTURES),
        (TURN, "UsdTransform2d", TURNS),
    ],
)
def test_inputs_do_what_the_table_says(
    path: str, shader: str, inputs: dict[str, tuple[Any, dict[str, Any]]]
) -> None:
    nodes = set(mapping.shader_inputs()[shader])
    assert set(inputs) == nodes - {"st", "in"}
    for name, (value, beside) in inputs.items():
        row = mapping.row_of_input(shader, name)
        assert row is not None
        stages = [textured() for _ in range(2)]
        for stage in stages:
            give(stage, path, beside)
        give(stages[1], path, {name: value})
        (before, usual), (after, told) = (made_of(stage) for stage in stages)
        if row.outcome == "approximated":
            assert (before, usual) != (after, told), name
        else:
            assert (before != after) == (row.outcome == "supported"), name
            assert (name in told) == (row.outcome == "reported"), name


def test_connections_do_what_the_table_says() -> None:
    """Coordinates of another name, and without the turn."""
    before, told = made_of(textured())
    assert told == ""
    for path, name, source in ((TURN, "in", OTHER_READER), (TEXTURE, "st", READER)):
        stage = textured()
        connect(at(stage, path), name, at(stage, source), Kind.Float2)
        assert made_of(stage)[0] != before, name


def test_readers_of_primvars_do_what_the_table_says() -> None:
    for kind in fnmatch.filter(mapping.shader_inputs(), "UsdPrimvarReader_*"):
        digests = {}
        for name, value in (("", ""), ("varname", "varnish"), ("fallback", (0.1, 0.2, 0.3))):
            row = mapping.row_of_input(kind, name or "varname")
            assert row is not None
            if kind == "UsdPrimvarReader_float2":
                stage = textured()
                give(stage, READER, {name: "other"} if name == "varname" else {})
            else:
                stage = painted(kind, "of_nobody" if name == "fallback" else value or "paint")
            if name == "fallback" and kind == "UsdPrimvarReader_float3":
                give(stage, READER, {"fallback": value})
            digests[name], told = made_of(stage)
            assert (row.outcome == "reported") == (f"{kind} cannot drive it" in told), kind
            if name and row.outcome == "supported":
                assert digests[name] != digests[""], f"{kind}.{name}"


def painted(kind: str, name: str) -> Usd.Stage:
    """The square with its colours, by a reader of some type."""
    stage = textured(kind)
    at(stage, READER).GetInput("varname").Set(name)
    surface = at(stage, SURFACE)
    UsdShade.ConnectableAPI.ClearSources(surface.GetInput("diffuseColor"))
    connect(surface, "diffuseColor", at(stage, READER), Kind.Float3)
    return stage
