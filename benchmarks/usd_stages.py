"""Stages of one kind of thing in any number, for measuring what that number costs."""

from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

from openrooms_usd import imagefile

_PROTOTYPES: Final = 50
_INSTANCE_TRIANGLES: Final = 1000
_TEXTURE_PIXELS: Final = 1024


def meshes(file: Path, triangles: int) -> None:
    """Wavy sheets of at most 100,000 triangles each, without instances."""
    stage = _stage(file)
    each = min(triangles, 100_000)
    count = max(1, round(triangles / each))
    for number in range(count):
        mesh = _sheet(stage, f"/World/sheet_{number}", each)
        mesh.AddTranslateOp().Set(Gf.Vec3d(number % 10, number // 10, 0.0))
    stage.Save()


def scene_graph_instances(file: Path, count: int) -> None:
    """Instanceable references to 50 prototypes of about 1,000 triangles."""
    stage = _stage(file)
    stage.CreateClassPrim("/Prototypes")
    names = [f"/Prototypes/p{number}" for number in range(_PROTOTYPES)]
    for name in names:
        UsdGeom.Xform.Define(stage, name)
        _sheet(stage, f"{name}/sheet", _INSTANCE_TRIANGLES)
    layer = stage.GetRootLayer()
    with Sdf.ChangeBlock():
        for number, at in enumerate(_grid(count)):
            prim = Sdf.CreatePrimInLayer(layer, f"/World/i{number}")
            prim.specifier, prim.typeName = Sdf.SpecifierDef, "Xform"
            prim.instanceable = True
            prim.referenceList.Prepend(Sdf.Reference("", names[number % _PROTOTYPES]))
            place = Sdf.AttributeSpec(prim, "xformOp:translate", Sdf.ValueTypeNames.Double3)
            place.default = Gf.Vec3d(*at)
            order = Sdf.AttributeSpec(prim, "xformOpOrder", Sdf.ValueTypeNames.TokenArray)
            order.default = Vt.TokenArray(["xformOp:translate"])
    stage.Save()


def point_instances(file: Path, count: int) -> None:
    """One point instancer of 50 prototypes of about 1,000 triangles."""
    stage = _stage(file)
    instancer = UsdGeom.PointInstancer.Define(stage, "/World/instancer")
    names = [f"/World/instancer/p{number}" for number in range(_PROTOTYPES)]
    for name in names:
        _sheet(stage, name, _INSTANCE_TRIANGLES)
    instancer.CreatePrototypesRel().SetTargets(names)
    instancer.CreateProtoIndicesAttr([number % _PROTOTYPES for number in range(count)])
    instancer.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(np.array(_grid(count), np.float32)))
    stage.Save()


def materials(file: Path, count: int) -> None:
    """Sheets of 200 triangles, each with a material of its own."""
    stage = _stage(file)
    colors = np.random.default_rng(1).uniform(0.1, 0.8, (count, 3))
    for number, at in enumerate(_grid(count)):
        mesh = _sheet(stage, f"/World/sheet_{number}", 200)
        mesh.AddTranslateOp().Set(Gf.Vec3d(*at))
        shader = _material(stage, number, mesh)
        color = shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f)
        color.Set(Gf.Vec3f(*colors[number].tolist()))
    stage.Save()


def textures(file: Path, count: int) -> None:
    """Sheets of 200 triangles, each with a picture of 1024x1024 pixels of its own."""
    stage = _stage(file)
    for number, at in enumerate(_grid(count)):
        mesh = _sheet(stage, f"/World/sheet_{number}", 200)
        mesh.AddTranslateOp().Set(Gf.Vec3d(*at))
        coarse = np.random.default_rng(number).integers(0, 255, (64, 64, 3)).astype(np.uint8)
        pixels = np.kron(coarse, np.ones((_TEXTURE_PIXELS // 64,) * 2 + (1,), np.uint8))
        picture = file.parent / f"{file.stem}_{number}.png"
        imagefile.write_png(picture, pixels)
        shader = _material(stage, number, mesh)
        path = shader.GetPath().GetParentPath()
        reader = UsdShade.Shader.Define(stage, path.AppendChild("st"))
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", Sdf.ValueTypeNames.String).Set("st")
        texture = UsdShade.Shader.Define(stage, path.AppendChild("texture"))
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", Sdf.ValueTypeNames.Asset).Set(f"./{picture.name}")
        texture.CreateInput("st", Sdf.ValueTypeNames.Float2).ConnectToSource(
            reader.CreateOutput("result", Sdf.ValueTypeNames.Float2)
        )
        shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).ConnectToSource(
            texture.CreateOutput("rgb", Sdf.ValueTypeNames.Float3)
        )
    stage.Save()


KINDS: Final[dict[str, tuple[Callable[[Path, int], None], tuple[int, ...]]]] = {
    "triangles": (meshes, (1_000, 100_000, 1_000_000, 5_000_000)),
    "scene-graph instances": (scene_graph_instances, (100, 1_000, 10_000, 100_000)),
    "point instances": (point_instances, (100, 1_000, 10_000, 100_000)),
    "materials": (materials, (1, 10, 100, 500)),
    "textures": (textures, (1, 10, 50)),
}
"""What is measured, and in which numbers."""


def _stage(file: Path) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(file))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    UsdLux.DomeLight.Define(stage, "/World/dome").CreateIntensityAttr(1.0)
    return stage


def _grid(count: int) -> list[tuple[float, float, float]]:
    side = int(np.ceil(np.sqrt(count)))
    return [(float(n % side), float(n // side), 0.0) for n in range(count)]


def _sheet(stage: Usd.Stage, path: str, triangles: int) -> UsdGeom.Mesh:
    """A wavy square of quads, a metre wide, with texture coordinates."""
    side = max(1, round(np.sqrt(triangles / 2)))
    u, v = np.meshgrid(*[np.linspace(0.0, 1.0, side + 1)] * 2)
    points = np.stack([0.9 * u, 0.9 * v, 0.1 * np.sin(9 * u) * np.cos(7 * v)], axis=-1)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    faces = corner[:, None] + np.array([0, 1, side + 2, side + 1])
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points.reshape(-1, 3).astype(np.float32)))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(side**2, 4, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(faces.ravel().astype(np.int32)))
    mesh.CreateSubdivisionSchemeAttr("none")
    st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "st", Sdf.ValueTypeNames.TexCoord2fArray, UsdGeom.Tokens.vertex
    )
    st.Set(Vt.Vec2fArray.FromNumpy(np.stack([u, v], axis=-1).reshape(-1, 2).astype(np.float32)))
    return mesh


def _material(stage: Usd.Stage, number: int, mesh: UsdGeom.Mesh) -> UsdShade.Shader:
    material = UsdShade.Material.Define(stage, f"/World/Looks/m{number}")
    shader = UsdShade.Shader.Define(stage, f"/World/Looks/m{number}/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    material.CreateSurfaceOutput().ConnectToSource(
        shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    )
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
    return shader
