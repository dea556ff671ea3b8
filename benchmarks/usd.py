"""From a USD file to the first pixel: seconds and memory, by what a stage has many of.

Each figure is of a process of its own, which has loaded its libraries before it begins. Beside ours
stand what it takes to read the same arrays by USD alone, and what Blender's importer takes, in its
own environment (ORUSD_BLENDER_PYTHON), which draws nothing. The error is that of bounds and numbers
of triangles against USD's own.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import click
import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, Vt

from benchmarks.report import publish, table
from openrooms_usd import imagefile

# Stages of one kind of thing in any number, for measuring what that number costs.

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


_BLENDER: Final = "ORUSD_BLENDER_PYTHON"
_LONGEST_S: Final = 600
_BEGIN: Final = """
import json, re, sys, time
from pathlib import Path
import numpy as np
def memory():
    # Not getrusage's: that begins with the most that the parent has taken.
    status = open("/proc/self/status").read()
    return int(re.search(r"VmHWM:\\s+(\\d+) kB", status)[1]) / 1024
def told(**found):
    print("\\n" + json.dumps({"megabytes": memory() - before, **found}))
"""
_OURS: Final = """
from pxr import Usd, UsdGeom
import openrooms_usd.usd.shapes.subdivided
from openrooms_usd.rendering import RenderRequest
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.rendering.channel_plan import ChannelPlan
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.files.layers import open_stage
from openrooms_usd.usd.moments import freeze_time
from openrooms_usd.usd.shading.mtlxlayers import read_mtlx_layers
from orusd_mitsuba import MitsubaRenderer
from orusd_mitsuba.variants import choose
choose(sys.argv[2])
import mitsuba
mitsuba.set_variant(choose(sys.argv[2]).variant)
import orusd_mitsuba.session
before, began = memory(), time.perf_counter()
# As the commands do: looked through before USD reads it.
stage = open_stage(Path(sys.argv[1]))
read_mtlx_layers(stage)
freeze_time(stage)
looked = time.perf_counter() - began
scene = translate(stage)
translated = time.perf_counter() - began
renderer = MitsubaRenderer()
plan = ChannelPlan.of(RenderSettings(options={"variant": sys.argv[2]}), renderer)
session = RenderContext(Path(sys.argv[1]), stage, scene, renderer, plan)
opened = time.perf_counter() - began
view = session.render(RenderRequest(None, ("radiance",), 64, 48, samples=1))
first = time.perf_counter() - began
assert view.images["radiance"].pixels.max() > 0.0
box = UsdGeom.BBoxCache(Usd.TimeCode.Default(), ["default"]).ComputeWorldBound(
    stage.GetPseudoRoot()).ComputeAlignedRange()
hull = scene.triangles.hull
error = max(np.abs(hull.min(axis=0) - box.GetMin()).max(),
            np.abs(hull.max(axis=0) - box.GetMax()).max())
told(looked=looked, translated=translated, opened=opened, first=first,
     triangles=len(scene.triangles), error=float(error))
"""
_ARRAYS: Final = """
from pxr import Usd, UsdGeom
before, began = memory(), time.perf_counter()
stage = Usd.Stage.Open(sys.argv[1])
triangles, kept = 0, []
for prim in stage.Traverse():
    if prim.IsA(UsdGeom.Mesh):
        mesh = UsdGeom.Mesh(prim)
        kept.append([np.array(mesh.GetPointsAttr().Get()),
                     np.array(mesh.GetFaceVertexIndicesAttr().Get()),
                     np.array(mesh.GetFaceVertexCountsAttr().Get()),
                     np.array(UsdGeom.PrimvarsAPI(mesh).GetPrimvar("st").Get())])
told(first=time.perf_counter() - began)
"""
_IMPORTER: Final = """
import bpy
bpy.ops.wm.read_factory_settings(use_empty=True)
before, began = memory(), time.perf_counter()
bpy.ops.wm.usd_import(filepath=sys.argv[1])
told(first=time.perf_counter() - began)
"""


@click.command()
@click.option("--only", multiple=True, type=click.Choice(list(KINDS)), help="Kinds; all.")
@click.option("--most", type=int, default=None, help="Leave larger numbers out.")
@click.option("--quick", is_flag=True, help="Ten of everything, to see that it runs.")
@click.option("--json", "target", type=click.Path(path_type=Path), default=None)
def main(only: tuple[str, ...], most: int | None, quick: bool, target: Path | None) -> None:
    """Measure what a number of things in a stage costs."""
    blender = os.environ.get(_BLENDER)
    if blender is None:
        click.echo(f"without Blender: {_BLENDER} names no Python with bpy", err=True)
    rows: list[dict[str, Any]] = []
    for kind in only or KINDS:
        make, counts = KINDS[kind]
        for count in (10,) if quick else (n for n in counts if most is None or n <= most):
            with tempfile.TemporaryDirectory() as folder:
                file = Path(folder) / "stage.usdc"
                make(file, count)
                row = {
                    "kind": kind,
                    "count": count,
                    "auto": measured(sys.executable, _OURS, file, "auto"),
                    "scalar": measured(sys.executable, _OURS, file, "scalar"),
                    "arrays": measured(sys.executable, _ARRAYS, file),
                    "blender": measured(blender, _IMPORTER, file) if blender else None,
                }
            rows.append(row)
            click.echo(f"{kind} {count}: {json.dumps(row)}", err=True)
    publish("usd", {"rows": rows}, _table(rows), target)


def measured(python: str, code: str, *words: object) -> dict[str, float]:
    """What a process of its own tells of itself.

    Args:
        python: The interpreter.
        code: What it runs, which calls ``told`` once.
        words: Its arguments.

    Returns:
        Seconds by what was done, and ``megabytes`` beyond what its libraries take.
    """
    command = [python, "-c", _BEGIN + code, *map(str, words)]
    found = subprocess.run(command, capture_output=True, text=True, timeout=_LONGEST_S, check=False)
    if found.returncode:
        raise click.ClickException(f"{python} failed:\n{found.stderr[-2000:]}")
    lines = [line for line in found.stdout.splitlines() if line.startswith("{")]
    said: dict[str, float] = json.loads(lines[-1])
    return said


def _table(rows: list[dict[str, Any]]) -> str:
    titles = (
        "of",
        "number",
        "triangles",
        "error, m",
        "opened, s",
        "translated, s",
        "first pixel, s",
        "MB",
        "scalar: first pixel, s",
        "MB",
        "arrays alone, s",
        "Blender's importer, s",
        "MB",
    )
    lines = []
    for row in rows:
        ours, scalar, arrays = row["auto"], row["scalar"], row["arrays"]
        other = row["blender"] or {}
        lines.append(
            [
                row["kind"],
                row["count"],
                int(scalar["triangles"]),
                scalar["error"],
                ours["looked"],
                ours["translated"],
                ours["first"],
                ours["megabytes"],
                scalar["first"],
                scalar["megabytes"],
                arrays["first"],
                other.get("first"),
                other.get("megabytes"),
            ]
        )
    return table(titles, lines)


if __name__ == "__main__":
    main()
