"""Small stages, built prim by prim, and sessions of every backend that works here."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO
import pytest
from numpy.typing import ArrayLike, NDArray
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade

from openrooms_usd.render import RenderRequest, View
from openrooms_usd.render.opened import open_with
from openrooms_usd.usd.lights import define_mesh_light
from openrooms_usd.usd.materials import define_preview_surface
from openrooms_usd.usd.surfaces import PreviewSurface
from orusd_mitsuba import MitsubaRenderer, variants

Open = Callable[[Usd.Stage], Any]


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


@pytest.fixture(scope="session")
def build() -> type[Build]:
    return Build


@pytest.fixture(scope="session")
def half_hidden() -> Callable[..., Usd.Stage]:
    """A stage with two lamps, one of which is hidden from a part of what is seen."""
    return _half_hidden


def _half_hidden(**looks: Any) -> Usd.Stage:
    """A grey room with a panel over a board, and a ball."""
    made = Build()
    made.box("/Room", 2.0, inside=True, material=made.material(
        "/Grey", **({"base_color": (0.5,) * 3} | looks)))  # fmt: skip
    board = [(x, y, -0.5) for x, y in ((-0.6, -0.3), (0.1, -0.3), (0.1, 0.4), (-0.6, 0.4))]
    made.quad("/Board", board, material="/Grey")
    panel = [(-0.4, -0.2, 0.9), (-0.4, 0.3, 0.9), (0.1, 0.3, 0.9), (0.1, -0.2, 0.9)]
    define_mesh_light(made.quad("/Panel", panel, material="/Grey").GetPrim(), nits=100.0)
    ball = UsdLux.SphereLight.Define(made.stage, "/Ball")
    ball.CreateRadiusAttr(0.2)
    ball.CreateIntensityAttr(100.0)
    ball.AddTranslateOp().Set((0.6, 0.5, -0.2))
    made.camera((-0.9, -0.9, 0.0), (0.3, 0.4, -0.5), fov=70)
    return made.stage


@pytest.fixture(params=["scalar", "llvm"])
def variant(request: pytest.FixtureRequest) -> str:
    """Each backend; those that do not work on this machine are skipped."""
    # The faster one chooses the library, which must happen before Mitsuba is imported.
    if variants.choose("auto").variant == "scalar_rgb" and request.param != "scalar":
        pytest.skip(f"no usable {request.param}: {variants.diagnose()[request.param]}")
    return str(request.param)


@pytest.fixture
def open_stage(variant: str) -> Open:
    return lambda stage: open_with(MitsubaRenderer(), stage, {"variant": variant})


@pytest.fixture
def shoot(open_stage: Open) -> Callable[..., View]:
    """Render one camera of a stage: 32 by 24 pixels unless it says otherwise."""

    def render(
        stage: Usd.Stage, *channels: str, camera: str | None = "/Camera", **how: Any
    ) -> View:
        size = {"width": 32, "height": 24}
        how = size | ({} if {"error", "seconds"} & set(how) else {"samples": 1}) | how
        return open_stage(stage).render(RenderRequest(camera, channels, **how))  # type: ignore[no-any-return]

    return render


@pytest.fixture
def save_picture() -> Callable[[Path, NDArray[Any]], str]:
    """Write (H, W, C) pixels, top row first, to a file whose type its suffix says."""

    def save(path: Path, pixels: NDArray[Any]) -> str:
        height, width, channels = pixels.shape
        kind = "float" if pixels.dtype == np.float32 else "uint8"
        file: Any = OpenImageIO.ImageOutput.create(str(path))
        assert file.open(str(path), OpenImageIO.ImageSpec(width, height, channels, kind))
        assert file.write_image(np.ascontiguousarray(pixels))
        file.close()
        return str(path)

    return save


class Lit:
    """A stage with all that the films of light need, for the fastest backend here."""

    def __init__(self, stage: Usd.Stage) -> None:
        import mitsuba as mi

        mi.set_variant(variants.choose("auto").variant)
        from openrooms_usd.render.scene.sources import sources_of
        from openrooms_usd.render.scene.translate import translate
        from orusd_mitsuba.plugins.build import Builder
        from orusd_mitsuba.transport.light_index import LightIndex
        from orusd_mitsuba.transport.white import white_first

        self.stage = stage
        self.scene = translate(stage)
        builder = Builder(self.scene.origin)
        self.built = builder.scene(self.scene)
        self.sources = sources_of(self.scene)
        self.filing = LightIndex(self.sources, self.built, self.scene.origin)
        self.first = white_first(self.scene, self.built, builder)
        self._builder = builder

    def camera(self, width: int, height: int, path: str = "/Camera") -> Any:
        from openrooms_usd.usd.cameras import read_camera

        return read_camera(self.stage.GetPrimAtPath(path), width, height)

    def direct(
        self, samples: int, seed: int = 0, size: tuple[int, int] = (16, 16)
    ) -> NDArray[np.float32]:
        """(4 L, height, width, 3) of `DirectIntegrator`."""
        from orusd_mitsuba.direct.integrator import DirectIntegrator

        film = DirectIntegrator(self.scene, self.built, self.sources, self.filing, self.first,
                          self.camera(*size), *size)  # fmt: skip
        return film(samples, seed)

    def lights(self, samples: int, seed: int = 0, size: tuple[int, int] = (16, 16)) -> Any:
        """The channels that `finish` makes of it, without the picture's axes."""
        from orusd_mitsuba.direct.control_variate import finish

        found = finish(self.direct(samples, seed, size))
        return {name: values.reshape(len(self.sources), -1, 3) for name, values in found.items()}


@pytest.fixture(scope="session")
def lit() -> type[Lit]:
    """Skips where no vectorized backend works."""
    if variants.choose("auto").variant == "scalar_rgb":
        pytest.skip("no vectorized backend works here")
    return Lit
