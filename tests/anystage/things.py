"""Random prims that there is something to draw of, or light, or a view: one maker a kind."""

import math
from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

Maker = Callable[[Usd.Stage, str, Random], Any]


def vectors(rows: ArrayLike) -> list[Gf.Vec3f]:
    return [Gf.Vec3f(*row) for row in np.asarray(rows, dtype=np.float64).tolist()]


def polygons(
    stage: Usd.Stage, path: str, points: ArrayLike, faces: list[list[int]], scheme: str = "none"
) -> UsdGeom.Mesh:
    """A mesh of any polygons."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(vectors(points))
    mesh.CreateFaceVertexCountsAttr([len(face) for face in faces])
    mesh.CreateFaceVertexIndicesAttr([corner for face in faces for corner in face])
    mesh.CreateSubdivisionSchemeAttr(scheme)
    return mesh


# Meshes of flat faces.


def prism(stage: Usd.Stage, path: str, rng: Random) -> UsdGeom.Mesh:
    """A prism over a regular polygon, or over a star, whose faces are concave."""
    star, sides = rng.random() < 0.5, rng.randint(3, 6)
    count = 2 * sides if star else sides
    turn = 2 * np.pi * np.arange(count) / count
    radius = np.where(np.arange(count) % 2, rng.uniform(0.3, 0.8), 1.0) if star else 1.0
    ring = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros(count)], axis=1)
    up = np.array([0.0, 0.0, 0.5])
    points = np.concatenate([ring - up, ring + up])
    sides_of = [[i, (i + 1) % count, count + (i + 1) % count, count + i] for i in range(count)]
    caps = [list(range(count))[::-1], list(range(count, 2 * count))]
    mesh = polygons(stage, path, points, [*sides_of, *caps])
    if rng.random() < 0.3:
        mesh.CreateOrientationAttr("leftHanded")
    if rng.random() < 0.3:
        mesh.CreateHoleIndicesAttr(sorted(rng.sample(range(count + 2), rng.randint(1, 3))))
    if rng.random() < 0.3:
        mesh.CreateDoubleSidedAttr(True)
    dress(mesh, rng)
    return mesh


def sheet(stage: Usd.Stage, path: str, rng: Random) -> UsdGeom.Mesh:
    """A flat grid of quadrangles and triangles, with points that no face needs."""
    columns, rows = rng.randint(1, 3), rng.randint(1, 2)
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    points = np.stack([x.ravel(), y.ravel(), 0.25 * x.ravel()], axis=1)
    faces: list[list[int]] = []
    for row in range(rows):
        for column in range(columns):
            a = row * (columns + 1) + column
            b, c, d = a + 1, a + columns + 2, a + columns + 1
            faces += [[a, b, c], [a, c, d]] if rng.random() < 0.4 else [[a, b, c, d]]
    mesh = polygons(stage, path, [*points, (9.0, 9.0, 9.0)], faces)
    dress(mesh, rng)
    return mesh


def degenerate(stage: Usd.Stage, path: str, rng: Random) -> UsdGeom.Mesh:
    """Sound faces among such as have no area, or less than three corners."""
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (0, 0, 0)]
    faces = [[0, 1, 2, 3], [0, 1, 4], [0, 5, 0], [1, 2], [3], [2, 2, 2, 2], [0, 2, 1]]
    rng.shuffle(faces)
    return polygons(stage, path, points, faces)


def nothing(stage: Usd.Stage, path: str, rng: Random) -> UsdGeom.Mesh:
    return polygons(stage, path, np.zeros((rng.choice((0, 3)), 3)), [])


def dress(mesh: UsdGeom.Mesh, rng: Random) -> None:
    """Normals, texture coordinates and colours of any interpolation, some indexed."""
    counts = mesh.GetFaceVertexCountsAttr().Get()
    numbers = {
        "constant": 1,
        "uniform": len(counts),
        "vertex": len(mesh.GetPointsAttr().Get()),
        "faceVarying": sum(counts),
    }
    api = UsdGeom.PrimvarsAPI(mesh)
    for name, kind in (
        ("st", Sdf.ValueTypeNames.TexCoord2fArray),
        ("displayColor", Sdf.ValueTypeNames.Color3fArray),
        ("normals", Sdf.ValueTypeNames.Normal3fArray),
    ):
        if rng.random() < 0.5:
            continue
        word = rng.choice([*numbers])
        primvar = api.CreatePrimvar(name, kind, word)
        width = 2 if name == "st" else 3
        values = np.random.default_rng(rng.getrandbits(32)).random((numbers[word] + 1, width))
        indexed = rng.random() < 0.3
        kept = values if indexed else values[:-1]
        primvar.Set(kind.type.pythonClass.FromNumpy(kept.astype(np.float32)))
        if indexed:
            primvar.SetIndices([rng.randint(0, numbers[word]) for _ in range(numbers[word])])


# Everything else that is drawn.


def cage(stage: Usd.Stage, path: str, rng: Random) -> UsdGeom.Mesh:
    """A box that is subdivided, with a crease now and then."""
    points = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    kind = rng.choice(("catmullClark", "bilinear", "loop"))
    mesh = polygons(stage, path, points, faces[rng.randint(0, 1) :], kind)
    if rng.random() < 0.5:
        mesh.CreateCreaseIndicesAttr([4, 5, 7])
        mesh.CreateCreaseLengthsAttr([3])
        mesh.CreateCreaseSharpnessesAttr([rng.choice((1.5, 10.0))])
    return mesh


def box(stage: Usd.Stage, path: str, rng: Random) -> UsdGeom.Cube:
    cube = UsdGeom.Cube.Define(stage, path)
    cube.CreateSizeAttr(rng.uniform(0.5, 2.0))
    return cube


def plane(stage: Usd.Stage, path: str, rng: Random) -> UsdGeom.Plane:
    made = UsdGeom.Plane.Define(stage, path)
    made.CreateAxisAttr(rng.choice("XYZ"))
    made.CreateWidthAttr(rng.uniform(0.5, 2.0))
    made.CreateLengthAttr(rng.uniform(0.5, 2.0))
    return made


def round_shape(stage: Usd.Stage, path: str, rng: Random) -> Usd.Prim:
    kinds = ("Sphere", "Cylinder", "Cylinder_1", "Capsule", "Capsule_1", "Cone")
    prim = stage.DefinePrim(path, rng.choice(kinds))
    for name in ("radius", "radiusTop", "radiusBottom", "height"):
        if prim.HasAttribute(name) and rng.random() < 0.7:
            prim.GetAttribute(name).Set(rng.uniform(0.1, 2.0))
    if prim.HasAttribute("axis"):
        prim.GetAttribute("axis").Set(rng.choice("XYZ"))
    return prim


def curves(stage: Usd.Stage, path: str, rng: Random) -> UsdGeom.BasisCurves:
    made = UsdGeom.BasisCurves.Define(stage, path)
    points = np.cumsum(np.random.default_rng(rng.getrandbits(32)).normal(size=(8, 3)), axis=0)
    made.CreatePointsAttr(vectors(points))
    made.CreateCurveVertexCountsAttr([4, 4])
    made.CreateTypeAttr(rng.choice(("linear", "cubic")))
    made.CreateBasisAttr(rng.choice(("bezier", "bspline", "catmullRom")))
    made.CreateWrapAttr(rng.choice(("nonperiodic", "pinned")))
    made.CreateWidthsAttr([rng.uniform(0.01, 0.3)])
    made.SetWidthsInterpolation("constant")
    return made


def points(stage: Usd.Stage, path: str, rng: Random) -> UsdGeom.Points:
    made = UsdGeom.Points.Define(stage, path)
    made.CreatePointsAttr(vectors(np.random.default_rng(rng.getrandbits(32)).normal(size=(3, 3))))
    made.CreateWidthsAttr([0.1, 0.2, 0.3])
    return made


def tetrahedron(stage: Usd.Stage, path: str, rng: Random) -> UsdGeom.TetMesh:
    made = UsdGeom.TetMesh.Define(stage, path)
    made.CreatePointsAttr(vectors([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, rng.uniform(0.5, 2))]))
    made.CreateTetVertexIndicesAttr([Gf.Vec4i(0, 1, 2, 3)])
    return made


# Lights and cameras.


def light(stage: Usd.Stage, path: str, rng: Random) -> Usd.Prim:
    kinds = ("RectLight", "DiskLight", "SphereLight", "CylinderLight", "DistantLight", "DomeLight")
    prim = stage.DefinePrim(path, rng.choice(kinds))
    api = UsdLux.LightAPI(prim)
    api.CreateIntensityAttr(rng.choice((0.0, 1.0, 250.0, 3e4)))
    api.CreateColorAttr(Gf.Vec3f(rng.random(), rng.random(), rng.random()))
    if rng.random() < 0.4:
        api.CreateNormalizeAttr(True)
    if rng.random() < 0.4:
        api.CreateExposureAttr(rng.uniform(-3, 3))
    if rng.random() < 0.3:
        api.CreateEnableColorTemperatureAttr(True)
        api.CreateColorTemperatureAttr(rng.uniform(1500, 9000))
    if rng.random() < 0.3:
        shaping = UsdLux.ShapingAPI.Apply(prim)
        shaping.CreateShapingConeAngleAttr(rng.uniform(5, 90))
        shaping.CreateShapingConeSoftnessAttr(rng.random())
    return prim


def camera(stage: Usd.Stage, path: str, rng: Random) -> UsdGeom.Camera:
    made = UsdGeom.Camera.Define(stage, path)
    made.CreateFocalLengthAttr(rng.uniform(10, 80))
    made.CreateHorizontalApertureAttr(rng.uniform(10, 40))
    if rng.random() < 0.3:
        made.CreateHorizontalApertureOffsetAttr(rng.uniform(-5, 5))
    return made


def material(stage: Usd.Stage, path: str, rng: Random) -> UsdShade.Material:
    made = UsdShade.Material.Define(stage, path)
    shader = UsdShade.Shader.Define(stage, f"{path}/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    color = Gf.Vec3f(rng.random(), rng.random(), rng.random())
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(color)
    for name, chance in (("roughness", 0.6), ("metallic", 0.3), ("opacity", 0.2), ("ior", 0.2)):
        if rng.random() < chance:
            value = rng.uniform(1.0, 2.0) if name == "ior" else rng.random()
            shader.CreateInput(name, Sdf.ValueTypeNames.Float).Set(value)
    if rng.random() < 0.2:
        shader.CreateInput("emissiveColor", Sdf.ValueTypeNames.Color3f).Set(10 * color)
    shader.CreateOutput("surface", Sdf.ValueTypeNames.Token)
    made.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")
    return made


def extent(rng: Random) -> float:
    """A factor of any order of magnitude from 1e-4 to 1e4."""
    return math.exp(rng.uniform(math.log(1e-4), math.log(1e4)))


# Faces of these are flat, and what stands where is exact.
FLAT: dict[Maker, int] = {
    prism: 6,
    sheet: 3,
    degenerate: 2,
    nothing: 1,
    box: 3,
    plane: 2,
    tetrahedron: 2,
}
ANY: dict[Maker, int] = {**FLAT, cage: 1, round_shape: 3, curves: 1, points: 1}
