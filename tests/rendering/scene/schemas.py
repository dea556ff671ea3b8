"""A small stage for every schema of OpenUSD: one prim of it, and what it needs to be seen.

Beside it are a ground, a body, a camera and a material, so that all that changes anything does.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.imagefile import write_png
from tests.usd.test_moments import puppet

GROUND, OTHER = "/World/Lit/Ground", "/World/Other"
MATERIAL, SECOND = "/World/Material", "/World/Second"
SURFACE, CAMERA, SETTINGS = f"{MATERIAL}/Surface", "/World/Camera", "/World/Settings"
RIG = "/World/Rig"

Change = Callable[[Usd.Prim], object]


def to(name: str, value: Any, kind: Sdf.ValueTypeName | None = None) -> Change:
    """A change that sets an attribute."""

    def change(prim: Usd.Prim) -> None:
        found = prim.GetAttribute(name)
        assert (found or prim.CreateAttribute(name, kind, custom=False)).Set(value)

    return change


def at(time: float, name: str, value: Any) -> Change:
    return lambda prim: prim.GetAttribute(name).Set(value, time)


def refer(name: str, *paths: str) -> Change:
    """A change that sets a relationship."""
    return lambda prim: prim.CreateRelationship(name, custom=False).SetTargets(list(paths))


def several(*changes: Change) -> Change:
    def change(prim: Usd.Prim) -> None:
        for one in changes:
            one(prim)

    return change


def elsewhere(path: str, *changes: Change) -> Change:
    """Changes of another prim of the stage."""
    return lambda prim: several(*changes)(prim.GetStage().GetPrimAtPath(path))


def bind(prim: Usd.Prim, material: str = MATERIAL) -> None:
    bound = UsdShade.Material(prim.GetStage().GetPrimAtPath(material))
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(bound)


def unbind(prim: Usd.Prim) -> None:
    UsdShade.MaterialBindingAPI(prim).UnbindAllBindings()


def shaded(name: str, value: Any, kind: Sdf.ValueTypeName = Sdf.ValueTypeNames.Float) -> Change:
    """A change of an input of the material's surface."""
    return elsewhere(SURFACE, to(f"inputs:{name}", value, kind))


def _material(stage: Usd.Stage, path: str, color: tuple[float, float, float]) -> None:
    made = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(color)
    output = shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    made.CreateSurfaceOutput().ConnectToSource(output)


def _parent(prim: Usd.Prim) -> None:
    bind(prim.GetStage().DefinePrim(prim.GetPath().AppendChild("Child"), "Cube"))


def _product(prim: Usd.Prim) -> None:
    settings = prim.GetStage().DefinePrim(SETTINGS, "RenderSettings")
    prim.GetStage().SetMetadata("renderSettingsPrimPath", SETTINGS)
    refer("products", str(prim.GetPath()))(settings)


def _settings(prim: Usd.Prim) -> None:
    prim.GetStage().SetMetadata("renderSettingsPrimPath", str(prim.GetPath()))
    prim.GetStage().DefinePrim("/World/Product", "RenderProduct")
    refer("products", "/World/Product")(prim)


POINTS = [(0, 0, 0), (2, 0, 0), (2, 2, 0.5), (0, 2, 0)]
ROW = [(float(x), x % 2, 0) for x in range(7)]
GRID = [(float(x), float(y), x * y / 9 + x * x) for y in range(4) for x in range(4)]
KNOTS = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]

# What a prim of a type needs; others need nothing.
BASES: dict[str, Change] = {
    "Mesh": several(
        to("points", [*POINTS, (1, 3, 1)]),
        to("faceVertexCounts", [4, 3]),
        to("faceVertexIndices", [0, 1, 2, 3, 3, 2, 4]),
        to("subdivisionScheme", "none"),
    ),
    "BasisCurves": several(
        to("points", ROW),
        to("curveVertexCounts", [7]),
        to("widths", [0.1]),
        lambda prim: UsdGeom.Curves(prim).SetWidthsInterpolation("constant"),
    ),
    "HermiteCurves": several(
        to("points", ROW[:4]),
        to("tangents", [(1, 0, 0)] * 4),
        to("curveVertexCounts", [4]),
        to("widths", [0.1] * 4),
    ),
    "NurbsCurves": several(
        to("points", ROW[:5]),
        to("curveVertexCounts", [5]),
        to("order", [4]),
        to("knots", [0, 0, 0, 0, 1, 2, 2, 2, 2]),
        to("widths", [0.1] * 5),
    ),
    "NurbsPatch": several(
        to("points", GRID),
        to("uVertexCount", 4),
        to("vVertexCount", 4),
        to("uOrder", 4),
        to("vOrder", 4),
        to("uKnots", KNOTS),
        to("vKnots", KNOTS),
    ),
    "Points": several(to("points", ROW[:3]), to("widths", [0.1] * 3)),
    "TetMesh": several(
        to("points", [*POINTS[:3], (1, 1, 2)]), to("tetVertexIndices", [(0, 1, 2, 3)])
    ),
    "PointInstancer": several(
        refer("prototypes", GROUND, OTHER),
        to("protoIndices", [0, 1]),
        to("positions", [(0, 0, 1), (4, 0, 1)]),
    ),
    "GeomSubset": several(
        to("indices", [0]), to("familyName", "materialBind"), lambda prim: bind(prim, SECOND)
    ),
    **dict.fromkeys(("Xform", "Scope"), _parent),
    "RenderSettings": _settings,
    "RenderProduct": _product,
    "RenderVar": several(
        lambda prim: _product(prim.GetStage().DefinePrim("/World/Product", "RenderProduct")),
        elsewhere("/World/Product", refer("orderedVars", "/World/It")),
    ),
}
# Where a prim is that is not at /World/It.
PLACES = {
    "GeomSubset": "/World/Faces/It",
    "Material": MATERIAL,
    "Shader": SURFACE,
    "NodeDefAPI": SURFACE,
    "RiMaterialAPI": MATERIAL,
    "SkelRoot": RIG,
    "Skeleton": f"{RIG}/Skeleton",
    "SkelAnimation": f"{RIG}/Animation",
    "BlendShape": f"{RIG}/Mesh/Smile",
    "SkelBindingAPI": f"{RIG}/Mesh",
}
# What something is applied to, where that is no cube.
HOSTS = {
    "ShapingAPI": "SphereLight",
    "ShadowAPI": "SphereLight",
    "MeshLightAPI": "Mesh",
    "VolumeLightAPI": "Volume",
    "BackPlateAPI": "Camera",
}
DRAWN = tuple(
    (
        "Mesh Cube Sphere Cylinder Cylinder_1 Cone Capsule Capsule_1 Plane BasisCurves "
        "HermiteCurves NurbsCurves NurbsPatch Points TetMesh PointInstancer"
    ).split()
)


def small(schema: str) -> tuple[Usd.Stage, Usd.Prim]:
    """A stage, and its prim that is of a type or has an API applied."""
    stage = puppet(RIG)
    stage.DefinePrim(GROUND, "Plane")
    stage.DefinePrim(OTHER, "Cube").GetAttribute("size").Set(0.5)
    faces = stage.DefinePrim("/World/Faces", "Mesh")
    BASES["Mesh"](faces)
    _material(stage, MATERIAL, (0.6, 0.3, 0.2))
    _material(stage, SECOND, (0.1, 0.8, 0.4))
    for path in (GROUND, OTHER, faces.GetPath()):
        bind(stage.GetPrimAtPath(path))
    stage.DefinePrim(CAMERA, "Camera")
    is_api = bool(Usd.SchemaRegistry().FindAppliedAPIPrimDefinition(schema))
    host = HOSTS.get(schema, "Cube") if is_api else schema
    path = PLACES.get(schema, "/World/It")
    prim = stage.GetPrimAtPath(path) or stage.DefinePrim(path, host)
    BASES.get(host, lambda prim: None)(prim)
    if is_api:
        prim.ApplyAPI(schema, *instance_of(schema))
    if host in DRAWN:
        bind(prim)
    return stage, prim


def instance_of(api: str) -> tuple[str, ...]:
    """The name of an instance, of what may be applied several times."""
    if not Usd.SchemaRegistry.IsMultipleApplyAPISchema(api):
        return ()
    return (names.CATEGORY,) if api == "SemanticsLabelsAPI" else ("one",)


LAMP = """IESNA:LM-63-2002
[TEST] 1
TILT=NONE
1 1000 1 3 1 1 2 0 0 0
1 1 9
0 45 90
0
9 3 1
"""


def write_files(folder: Path) -> None:
    """What stages may refer to: ``one.png``, ``other.png`` and ``other.ies``."""
    pixels = np.arange(4 * 8 * 3, dtype=np.uint8).reshape(4, 8, 3) * 2 + 20
    write_png(folder / "one.png", pixels)
    write_png(folder / "other.png", pixels[::-1])
    (folder / "other.ies").write_text(LAMP)
