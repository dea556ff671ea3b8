"""Small stages, built prim by prim."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from openrooms_usd.usd.materials import define_preview_surface
from openrooms_usd.usd.surfaces import PreviewSurface


class Build:
    """Authors a stage with plain USD calls, so that a test says what it needs and no more."""

    def __init__(self, *, up: str = "Z", metres: float = 1.0, path: Path | None = None) -> None:
        self.stage = Usd.Stage.CreateNew(str(path)) if path else Usd.Stage.CreateInMemory()
        UsdGeom.SetStageUpAxis(self.stage, up)
        UsdGeom.SetStageMetersPerUnit(self.stage, metres)

    def mesh(
        self,
        path: str,
        points: ArrayLike,
        faces: ArrayLike,
        *,
        material: str | None = None,
        st: ArrayLike | None = None,
    ) -> UsdGeom.Mesh:
        """A mesh of equal polygons; st are given per corner."""
        corners = np.asarray(faces)
        mesh = UsdGeom.Mesh.Define(self.stage, path)
        mesh.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in np.asarray(points)])
        mesh.CreateFaceVertexCountsAttr([corners.shape[1]] * len(corners))
        mesh.CreateFaceVertexIndicesAttr(corners.ravel().tolist())
        mesh.CreateSubdivisionSchemeAttr("none")
        if st is not None:
            primvar = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
                "st", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying"
            )
            primvar.Set([Gf.Vec2f(*map(float, c)) for c in np.asarray(st)])
        if material:
            self.bind(mesh.GetPrim(), material)
        return mesh

    def quad(self, path: str, corners: ArrayLike, **options: Any) -> UsdGeom.Mesh:
        """A rectangle whose st runs from (0, 0) at the first corner to (1, 1) at the third."""
        st = [(0, 0), (1, 0), (1, 1), (0, 1)]
        return self.mesh(path, corners, [[0, 1, 2, 3]], st=st, **options)

    def box(self, path: str, size: float, *, inside: bool = False, **options: Any) -> UsdGeom.Mesh:
        """A cube about the origin, seen from outside or from inside."""
        points = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
        faces = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3],
                          [0, 4, 6, 2], [1, 3, 7, 5]])  # fmt: skip
        faces = faces[:, ::-1] if inside else faces
        return self.mesh(path, np.array(points) * size / 2, faces, **options)

    def material(self, path: str, **inputs: Any) -> str:
        """A UsdPreviewSurface; without ``ior`` it is exactly Lambertian."""
        define_preview_surface(self.stage, path, PreviewSurface(**({"ior": 1.0} | inputs)))
        return path

    def bind(self, prim: Usd.Prim, material: str) -> None:
        bound = UsdShade.Material(self.stage.GetPrimAtPath(material))
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(bound)

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
        camera = UsdGeom.Camera.Define(self.stage, path)
        camera.CreateHorizontalApertureAttr(0.36)
        camera.CreateVerticalApertureAttr(0.36 / aspect)
        camera.CreateFocalLengthAttr(0.18 / float(np.tan(np.radians(fov) / 2)))
        view = Gf.Matrix4d().SetLookAt(*(Gf.Vec3d(*map(float, v)) for v in (eye, target, up)))
        camera.MakeMatrixXform().Set(view.GetInverse())
        return path

    def dome(self, path: str = "/Dome", radiance: float = 1.0) -> UsdLux.DomeLight_1:
        dome = UsdLux.DomeLight_1.Define(self.stage, path)
        dome.CreatePoleAxisAttr("Z")
        dome.CreateIntensityAttr(radiance)
        return dome
