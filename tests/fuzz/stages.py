"""Sound descriptions and composed rooms, and the commands that read what people changed in them."""

import shutil
from functools import partial
from pathlib import Path

from tests.conftest import SMALL_ROOM
from tests.fuzz.captures import COMPOSED
from tests.fuzz.kinds import Kind
from tests.fuzz.pictures import ramp, write_picture

_ROOM = (
    SMALL_ROOM.replace("on: desk}", "on: desk, name: lamp}")
    + """\
materials:
  resolution: 16
  floor: oak_planks
  walls: {color: [0.5, 0.5, 0.5], roughness: 0.4}
lights:
  environment: {latitude: 52, longitude: 13, date: 2026-06-21, time: "14:30"}
  lamps: {lamp: {lumen: 600, kelvin: 3000}}
cameras:
  resolution: [16, 12]
"""
)
_GENERATED = """\
name: g
room: office
layout: {from: generate}
furniture: {from: generate}
materials: {resolution: 16}
"""
_EDITS = """\
#usda 1.0
(
    defaultPrim = "World"
    kilogramsPerUnit = 1
    metersPerUnit = 1
    upAxis = "Z"
    subLayers = [
        @./more.usda@
    ]
)

over "World"
{
    over "Furniture"
    {
        over "desk"
        {
            double3 xformOp:translate = (1.2, 1.4, 0)
            uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
        }

        def Mesh "extra" (
            prepend references = @../assets/extra.usda@</Extra>
            prepend apiSchemas = ["MaterialBindingAPI"]
        )
        {
            rel material:binding = </World/Materials/nothing>
        }

        over "gone" (
            active = false
        )
        {
        }
    }

    over "Materials"
    {
        def Material "Mine"
        {
            token outputs:surface.connect = </World/Materials/Mine/Surface.outputs:surface>

            def Shader "Surface"
            {
                uniform token info:id = "UsdPreviewSurface"
                asset inputs:file = @../assets/color.png@
                color3f inputs:diffuseColor = (0.1, 0.2, 0.3)
                token outputs:surface
            }
        }
    }
}
"""
_MORE = """\
#usda 1.0
(
    defaultPrim = "World"
    kilogramsPerUnit = 1
    metersPerUnit = 1
    upAxis = "Z"
)
"""
_EXTRA = """\
#usda 1.0
(
    defaultPrim = "Extra"
    metersPerUnit = 0.01
    upAxis = "Y"
)

def Mesh "Extra" (
    variants = {
        string look = "red"
    }
    prepend variantSets = "look"
)
{
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    float3[] extent = [(0, 0, 0), (1, 1, 0)]
    variantSet "look" = {
        "red" {
            color3f[] primvars:displayColor = [(1, 0, 0)]
        }
    }
}
"""
_FOREIGN = """\
#usda 1.0
(
    defaultPrim = "Scene"
    metersPerUnit = 0.01
    upAxis = "Y"
    timeCodesPerSecond = 24
)

def Xform "Scene" (
    kind = "assembly"
    customData = {
        string note = "somebody's"
    }
)
{
    def SphereLight "Lamp"
    {
        float inputs:intensity = 500
        float inputs:radius = 0.3
        double3 xformOp:translate.timeSamples = {
            0: (0, 0, 0),
            10: (1, 2, 3),
        }
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }

    def Cube "Body" (
        prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"]
    )
    {
        double size = 0.2
        float physics:mass = 2
    }

    def Camera "eye"
    {
        float focalLength = 30
        token projection = "perspective"
    }

    def PointInstancer "many"
    {
        int[] protoIndices = [0, 0]
        point3f[] positions = [(0, 0, 0), (1, 0, 0)]
        rel prototypes = </Scene/many/proto>

        def Cube "proto" (
            prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]
        )
        {
            double size = 2
            float physics:mass = 1
        }
    }

    def "Extra" (
        prepend payload = @./extra.usda@
    )
    {
    }
}
"""


def _compose(folder: Path, text: str, out: str = "out", *, flat: bool = False) -> None:
    from openrooms_usd.composing import compose_room
    from openrooms_usd.usd.files.diagnostics import quiet

    (folder / "in").mkdir(exist_ok=True)
    (folder / "in/room.yaml").write_text(text)
    with quiet():
        compose_room(folder / "in/room.yaml", folder / out, flatten=flat)


def _plant_room(folder: Path) -> None:
    (folder / "in").mkdir()
    (folder / "in/room.yaml").write_text(_ROOM)
    (folder / "in/generated.yaml").write_text(_GENERATED)


def _plant_composed(folder: Path) -> None:
    """A composed room with edits, and files that these refer to."""
    _compose(folder, _ROOM)
    (folder / "out/layers/edits.usda").write_text(_EDITS)
    (folder / "out/layers/more.usda").write_text(_MORE)
    (folder / "out/assets").mkdir()
    (folder / "out/assets/extra.usda").write_text(_EXTRA)
    write_picture(folder / "out/assets/color.png", ramp())
    (folder / "out/keep.txt").write_text("somebody's own\n")


def _plant_saved(folder: Path) -> None:
    """A composed room, and what another program saved of it."""
    from pxr import UsdUtils

    from openrooms_usd.usd.files.diagnostics import quiet

    _compose(folder, COMPOSED.format(""), flat=True)
    saved = folder / "in/saved.usdc"
    shutil.move(folder / "out/scene.usdc", saved)
    with quiet():
        UsdUtils.CreateNewUsdzPackage(str(saved), str(saved.with_suffix(".usdz")))
    (folder / "in/saved.usda").write_text(_EDITS.replace("../assets", "."))
    (folder / "in/more.usda").write_text(_MORE)
    (folder / "in/extra.usda").write_text(_EXTRA)


def _plant_foreign(folder: Path) -> None:
    from pxr import Sdf, UsdUtils

    inner = folder / "in"
    inner.mkdir()
    (inner / "a.usda").write_text(_FOREIGN)
    (inner / "extra.usda").write_text(_EXTRA)
    Sdf.Layer.FindOrOpen(str(inner / "a.usda")).Export(str(inner / "b.usdc"))
    UsdUtils.CreateNewUsdzPackage(str(inner / "a.usda"), str(inner / "c.usdz"))


def _load(folder: Path) -> object:
    from openrooms_usd.description import load_room

    return load_room(folder / "in/room.yaml")


def _packaged(name: str, folder: Path) -> object:
    from openrooms_usd import package
    from openrooms_usd.usd.files.diagnostics import quiet

    with quiet():
        if name == "scene.usdc":
            package.flatten(folder / "out/scene.usda", folder / "out" / name)
        else:
            package.package(folder / "out/scene.usda", folder / "out" / name)
    return name


_COMPOSE = "compose {in}/room.yaml -o {out}"
_ADOPT = "edit import-changes {out}/scene.usda --from {in}/saved."
KINDS = (
    Kind(
        "room.yaml",
        _plant_room,
        ((150, _load), (3, _COMPOSE), (1, "compose {in}/generated.yaml -o {out}")),
        share=8,
    ),
    Kind(
        "usd.edits",
        _plant_composed,
        (
            (4, "validate {out}/scene.usda"),
            (2, "edit orphans {out}"),
            (2, "edit fix-units {out}"),
            (2, partial(_packaged, "scene.usdz")),
            (2, partial(_packaged, "scene.usdc")),
            (1, _COMPOSE),
        ),
        ("out/layers/edits.usda", "out/layers/more.usda", "out/assets/*"),
        share=8,
    ),
    Kind(
        "usd.scene",
        _plant_composed,
        (
            (3, "validate {out}/scene.usda"),
            (3, "edit import-changes {out}/scene.usda"),
            (2, "edit import-changes {out}/scene.usda --dry-run --json"),
            (1, _COMPOSE),
        ),
        ("out/scene.usda",),
        share=4,
    ),
    Kind(
        "usd.layers",
        _plant_composed,
        (
            (4, "validate {out}/scene.usda --json"),
            (2, "edit orphans {out} --json"),
            (1, partial(_packaged, "scene.usdz")),
            (1, _COMPOSE),
        ),
        ("out/layers/[!em]*.usda", "out/layers/materials.usda", "out/layers/**/*.usdc"),
        share=4,
    ),
    Kind(
        "usd.saved",
        _plant_saved,
        tuple((1, f"{_ADOPT}{ending}") for ending in ("usda", "usdc", "usdz")),
        ("in/*.usd*",),
        share=5,
    ),
    Kind(
        "usd.foreign",
        _plant_foreign,
        (
            *((3, f"validate {{in}}/{name}") for name in ("a.usda", "b.usdc", "c.usdz")),
            (2, "render {in}/a.usda -o {out} --renderer fake --channels radiance --spp 1"),
            (1, "convert {in}/a.usda {out}/a.urdf --format urdf"),
            (1, "convert {in}/a.usda {out}/a.xml --format mjcf"),
            (1, "convert {in}/b.usdc {out}/a.usda --format usdphysics"),
        ),
        share=6,
    ),
)
