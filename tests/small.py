"""Small stages, said in a few lines.

made = small.room(hole=(-0.5, -0.5, 0.5, 0.5))        # a grey cube from inside, with a window
made.box("/Box", 0.5, at=(0.4, 0.2, -0.7), material=made.material("/Shiny", roughness=0.3))
made.quad("/Lamp", small.square((0, 0, 0.9), 0.3, "-Z"), nits=40.0)
made.light("Sphere", "/Ball", 60.0, at=(0.7, -0.3, 0.1), radius=0.1)
made.camera((-0.6, -0.9, 0.2), (0.3, 0.9, -0.4), fov=75)
render(made.stage)
"""

from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from openrooms_usd.arrays import Array
from openrooms_usd.usd.light.lights import Portal, connect_portals, define_mesh_light, define_portal
from openrooms_usd.usd.shading.materials import define_preview_surface
from openrooms_usd.usd.shading.surfaces import PreviewSurface

# Corners of a cube, and its sides as they are seen from outside; the last is at +Y.
CUBE = np.array([(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], dtype=float)
SIDES = np.array(
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5], [2, 6, 7, 3]]
)


class Stage:
    """Authors a stage with plain USD calls, so that a test says what it needs and no more."""

    def __init__(self, *, up: str = "Z", metres: float = 1.0, path: Path | None = None) -> None:
        self.stage = Usd.Stage.CreateNew(str(path)) if path else Usd.Stage.CreateInMemory()
        UsdGeom.SetStageUpAxis(self.stage, up)
        UsdGeom.SetStageMetersPerUnit(self.stage, metres)

    @classmethod
    def of(cls, stage: Usd.Stage) -> Self:
        """To add to a stage that is there."""
        made = cls.__new__(cls)
        made.stage = stage
        return made

    def mesh(
        self,
        path: str,
        points: ArrayLike,
        faces: ArrayLike,
        *,
        at: ArrayLike | None = None,
        material: str | None = None,
        nits: float | None = None,
        kelvin: float | None = None,
        st: ArrayLike | None = None,
    ) -> UsdGeom.Mesh:
        """A mesh of equal polygons, a lamp where it has nits; st are given per corner."""
        corners = np.asarray(faces)
        mesh = UsdGeom.Mesh.Define(self.stage, path)
        mesh.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in np.asarray(points)])
        mesh.CreateFaceVertexCountsAttr([corners.shape[1]] * len(corners))
        mesh.CreateFaceVertexIndicesAttr(corners.ravel().tolist())
        mesh.CreateSubdivisionSchemeAttr("none")
        if st is not None:
            kind = Sdf.ValueTypeNames.TexCoord2fArray
            primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", kind, "faceVarying")
            primvar.Set([Gf.Vec2f(*map(float, c)) for c in np.asarray(st)])
        if at is not None:
            mesh.AddTranslateOp().Set(Gf.Vec3d(*map(float, np.asarray(at))))
        if material:
            self.bind(mesh.GetPrim(), material)
        if nits is not None:
            define_mesh_light(mesh.GetPrim(), nits=nits, kelvin=kelvin)
        return mesh

    def quad(self, path: str, corners: ArrayLike, **options: Any) -> UsdGeom.Mesh:
        """A rectangle whose st runs from (0, 0) at the first corner to (1, 1) at the third."""
        st = [(0, 0), (1, 0), (1, 1), (0, 1)]
        return self.mesh(path, corners, [[0, 1, 2, 3]], **({"st": st} | options))

    def box(self, path: str, size: float, *, inside: bool = False, **options: Any) -> UsdGeom.Mesh:
        """A cube about the origin, seen from outside or from inside."""
        faces = SIDES[:, ::-1] if inside else SIDES
        return self.mesh(path, CUBE * size / 2, faces, **options)

    def material(self, path: str, **inputs: Any) -> str:
        """A UsdPreviewSurface; without ``ior`` it is exactly Lambertian."""
        define_preview_surface(self.stage, path, PreviewSurface(**({"ior": 1.0} | inputs)))
        return path

    def bind(self, prim: Usd.Prim, material: str) -> None:
        bound = UsdShade.Material(self.stage.GetPrimAtPath(material))
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(bound)

    def light(
        self,
        kind: str,
        path: str = "/Light",
        nits: float = 1.0,
        *,
        at: ArrayLike | None = None,
        turn: tuple[float, float, float] | None = None,
        **inputs: Any,
    ) -> Any:
        """A light of UsdLux, which shines along its -Z; ``a__b`` is its input ``a:b``."""
        light = getattr(UsdLux, f"{kind}Light").Define(self.stage, path)
        light.CreateIntensityAttr(nits)
        if at is not None:
            light.AddTranslateOp().Set(Gf.Vec3d(*map(float, np.asarray(at))))
        if turn is not None:
            light.AddRotateXYZOp().Set(Gf.Vec3f(*turn))
        if any(name.startswith("shaping__") for name in inputs):
            UsdLux.ShapingAPI.Apply(light.GetPrim())
        for name, value in inputs.items():
            light.GetPrim().GetAttribute(f"inputs:{name.replace('__', ':')}").Set(value)
        return light

    def dome(
        self, path: str = "/Dome", radiance: float = 1.0, *, portals: tuple[Portal, ...] = ()
    ) -> UsdLux.DomeLight_1:
        """The sky, which may come in by portals alone."""
        dome = UsdLux.DomeLight_1.Define(self.stage, path)
        dome.CreatePoleAxisAttr("Z")
        dome.CreateIntensityAttr(radiance)
        if portals:
            prims = [define_portal(self.stage, portal).GetPrim() for portal in portals]
            connect_portals(dome.GetPrim(), prims)
        return dome

    def camera(
        self,
        eye: ArrayLike,
        target: ArrayLike,
        *,
        path: str = "/Camera",
        up: ArrayLike = (0, 0, 1),
        fov: float = 60.0,
        aspect: float = 4 / 3,
    ) -> str:
        """A pinhole of an opening angle from left to right, in degrees."""
        camera = UsdGeom.Camera.Define(self.stage, path)
        camera.CreateHorizontalApertureAttr(0.36)
        camera.CreateVerticalApertureAttr(0.36 / aspect)
        camera.CreateFocalLengthAttr(0.18 / float(np.tan(np.radians(fov) / 2)))
        view = Gf.Matrix4d().SetLookAt(*(Gf.Vec3d(*map(float, v)) for v in (eye, target, up)))
        camera.MakeMatrixXform().Set(view.GetInverse())
        return path

    def save(self, path: Path) -> Path:
        """A file of the stage as it is now."""
        self.stage.GetRootLayer().Export(str(path))
        return path


def square(center: ArrayLike, half: float | tuple[float, float], facing: str = "+Z") -> Array:
    """(4, 3) corners of a rectangle across an axis, counter-clockwise as the axis looks back.

    Two halves are along the axes that follow in the cycle X, Y, Z.
    """
    a, b = np.broadcast_to(np.asarray(half, dtype=float), 2)
    axis = "XYZ".index(facing[1])
    turns = [(-a, -b), (a, -b), (a, b), (-a, b)]
    corners = np.zeros((4, 3))
    corners[:, [(axis + 1) % 3, (axis + 2) % 3]] = turns if facing[0] == "+" else turns[::-1]
    return corners + np.asarray(center, dtype=float)


def patch(at: tuple[float, float, float] = (0, 0, 0), half: float = 0.01) -> Stage:
    """A white Lambertian square that faces up, and a camera that sees nothing else."""
    made = Stage()
    made.material("/White", base_color=(1.0, 1.0, 1.0))
    made.quad("/Patch", square(at, half), material="/White")
    x, y, z = at
    away = 30.0 * half
    made.camera((x, y - away, z + away), at, fov=1.2, aspect=1.0)
    return made


def room(
    size: float = 2.0, *, hole: tuple[float, float, float, float] | None = None, **looks: Any
) -> Stage:
    """A grey cube about the origin, seen from inside, of the material ``/Grey``.

    Args:
        size: The length of its edges.
        hole: x and z from, x and z to, of an opening in its side at +Y.
        looks: Inputs of its material.
    """
    made, half = Stage(), size / 2
    grey = made.material("/Grey", **({"base_color": (0.5, 0.5, 0.5)} | looks))
    if hole is None:
        made.box("/Room", size, inside=True, material=grey)
        return made
    made.mesh("/Room", CUBE * half, SIDES[:5, ::-1], material=grey)
    x0, z0, x1, z1 = hole
    outer = [(-half, half, -half), (half, half, -half), (half, half, half), (-half, half, half)]
    inner = [(x0, half, z0), (x1, half, z0), (x1, half, z1), (x0, half, z1)]
    ring = [[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)]
    made.mesh("/Front", [*outer, *inner], ring, material=grey)
    return made


def window(
    hole: tuple[float, float, float, float] = (-0.5, -0.5, 0.5, 0.5),
    y: float = 1.0,
    path: str = "/Window",
) -> Portal:
    """The portal of the hole of a `room`: it looks out along +Y."""
    x0, z0, x1, z1 = hole
    world = np.eye(4)
    world[:3, :3] = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0]]).T
    world[:3, 3] = (x0 + x1) / 2, y, (z0 + z1) / 2
    return Portal(path, world, x1 - x0, z1 - z0)
