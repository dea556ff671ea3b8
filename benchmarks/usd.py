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
from pathlib import Path
from typing import Any, Final

import click

from benchmarks.report import publish, table
from benchmarks.usd_stages import KINDS

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
from openrooms_usd.usd.moments import hold
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
hold(stage)
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
