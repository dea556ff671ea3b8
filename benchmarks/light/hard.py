"""Rooms that are hard to light, each with the condition that makes it so."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdLux, UsdShade

from openrooms_usd.usd.light.lights import Portal, connect_portals, define_portal
from openrooms_usd.usd.shading.materials import define_preview_surface
from openrooms_usd.usd.shading.surfaces import PreviewSurface

Point = Sequence[float]
CAMERA: Final = "/Camera"
# Corners of a box about the origin, by bits: x, y, z.
_CORNERS: Final = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
# Its faces as seen from inside.
_FACES: Final = {
    "floor": (0, 1, 3, 2),
    "ceiling": (4, 6, 7, 5),
    "front": (0, 4, 5, 1),
    "back": (2, 3, 7, 6),
    "left": (0, 2, 6, 4),
    "right": (1, 5, 7, 3),
}


class Shell:
    """A room of 2 x 2 x 2 units about a point, and what stands in it."""

    def __init__(self, unit: float = 1.0, at: Point = (0.0, 0.0, 0.0)) -> None:
        self.stage = Usd.Stage.CreateInMemory()
        UsdGeom.SetStageUpAxis(self.stage, "Z")
        UsdGeom.SetStageMetersPerUnit(self.stage, 1.0)
        self._root = UsdGeom.Xform.Define(self.stage, "/World")
        self._root.AddTranslateOp().Set(Gf.Vec3d(*at))
        self._root.AddScaleOp().Set(Gf.Vec3f(unit))
        self._unit, self._at = unit, np.asarray(at)
        self._count = 0
        self._portals: list[Usd.Prim] = []

    def material(self, **inputs: Any) -> str:
        """A surface; Lambertian unless it says otherwise."""
        path = f"/Looks/Look_{self._next()}"
        define_preview_surface(self.stage, path, PreviewSurface(**({"ior": 1.0} | inputs)))
        return path

    def faces(self, points: Any, faces: Any, material: str) -> None:
        """A mesh of quadrangles."""
        rows = np.asarray(faces)
        mesh = UsdGeom.Mesh.Define(self.stage, f"/World/Mesh_{self._next()}")
        mesh.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in points])
        mesh.CreateFaceVertexCountsAttr([rows.shape[1]] * len(rows))
        mesh.CreateFaceVertexIndicesAttr(rows.ravel().tolist())
        mesh.CreateSubdivisionSchemeAttr("none")
        bound = UsdShade.Material(self.stage.GetPrimAtPath(material))
        UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(bound)

    def walls(self, material: str, *, without: Sequence[str] = (), inverted: bool = False) -> None:
        """The faces of the room."""
        rows = np.array([row for name, row in _FACES.items() if name not in without])
        self.faces(_CORNERS, rows[:, ::-1] if inverted else rows, material)

    def pierced(self, material: str, hole: Sequence[float], y: float = 1.0) -> None:
        """A wall at ``y`` with a hole: x and z from, x and z to."""
        x0, z0, x1, z1 = hole
        outer = [(-1, y, -1), (1, y, -1), (1, y, 1), (-1, y, 1)]
        inner = [(x0, y, z0), (x1, y, z0), (x1, y, z1), (x0, y, z1)]
        ring = [[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)]
        self.faces([*outer, *inner], ring, material)

    def box(self, center: Point, size: Point, material: str) -> None:
        """A box as seen from outside."""
        points = np.array(_CORNERS) * np.asarray(size) / 2 + np.asarray(center)
        self.faces(points, np.array(list(_FACES.values()))[:, ::-1], material)

    def lamp(self, center: Point, size: Point, nits: float, turn: float = 0.0) -> None:
        """A rectangle that shines down, or turned about y, degrees, to -x."""
        light = UsdLux.RectLight.Define(self.stage, f"/World/Lamp_{self._next():03}")
        light.CreateIntensityAttr(nits)
        light.CreateWidthAttr(size[0])
        light.CreateHeightAttr(size[1])
        light.AddTranslateOp().Set(Gf.Vec3d(*map(float, center)))
        light.AddRotateYOp().Set(turn)

    def window(self, hole: Sequence[float], y: float = 1.0) -> None:
        """A portal in a wall at ``y`` that looks along +Y: x and z from, x and z to."""
        x0, z0, x1, z1 = hole
        world = np.eye(4)
        world[:3, :3] = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0]]).T
        world[:3, 3] = self._unit * np.array([(x0 + x1) / 2, y, (z0 + z1) / 2]) + self._at
        size = self._unit * np.array([x1 - x0, z1 - z0])
        portal = Portal(f"/Portals/Portal_{self._next()}", world, *map(float, size))
        self._portals.append(define_portal(self.stage, portal).GetPrim())

    def sky(self, nits: float = 1.0, sun: float = 0.0, folder: Path | None = None) -> None:
        """The surroundings, with a sun thirty degrees up that shines in along -Y."""
        dome = UsdLux.DomeLight_1.Define(self.stage, "/Dome")
        dome.CreatePoleAxisAttr("Z")
        dome.CreateIntensityAttr(nits)
        if sun and folder is not None:
            dome.CreateTextureFileAttr(_sky_file(folder, sun))
        connect_portals(dome.GetPrim(), self._portals)

    def camera(self, eye: Point, target: Point, fov: float = 75.0) -> Usd.Stage:
        """The view, and with it the stage."""
        camera = UsdGeom.Camera.Define(self.stage, f"/World{CAMERA}")
        camera.CreateHorizontalApertureAttr(0.36)
        camera.CreateVerticalApertureAttr(0.27)
        camera.CreateFocalLengthAttr(0.18 / float(np.tan(np.radians(fov) / 2)))
        ways = (Gf.Vec3d(*map(float, v)) for v in (eye, target, (0, 0, 1)))
        camera.MakeMatrixXform().Set(Gf.Matrix4d().SetLookAt(*ways).GetInverse())
        return self.stage

    def _next(self) -> int:
        self._count += 1
        return self._count


def _sky_file(folder: Path, sun: float) -> str:
    """A panorama, one unit bright but for its sun, a pixel of 0.35 degrees."""
    import OpenImageIO

    height, width = 512, 1024
    pixels = np.ones((height, width, 3), dtype=np.float32)
    # The left edge is +Y, where the windows are.
    pixels[height // 3, 0] = sun
    path = folder / f"sky_{sun:g}.exr"
    file: Any = OpenImageIO.ImageOutput.create(str(path))
    file.open(str(path), OpenImageIO.ImageSpec(width, height, 3, "float"))
    file.write_image(pixels)
    file.close()
    return str(path)


EYE: Final = (-0.7, -0.85, 0.3)
TARGET: Final = (0.3, 0.9, -0.5)
_HOLE: Final = (-0.5, -0.3, 0.5, 0.6)


def lamp_room(
    *,
    unit: float = 1.0,
    at: Point = (0, 0, 0),
    size: Point = (0.4, 0.3),
    z: float = 0.9,
    nits: float = 50.0,
    color: float = 0.6,
    **walls: Any,
) -> Shell:
    """Walls, a box, and a lamp that shines down."""
    shell = Shell(unit, at)
    grey = shell.material(base_color=(color,) * 3)
    shell.walls(grey, **walls)
    shell.box((0.4, 0.3, -0.75), (0.5, 0.5, 0.5), shell.material(base_color=(0.6, 0.3, 0.2)))
    shell.lamp((-0.2, 0.1, z), size, nits)
    return shell


def window_room(
    folder: Path,
    holes: Sequence[Sequence[float]] = (_HOLE,),
    *,
    sun: float = 0.0,
    floor: dict[str, Any] | None = None,
    lamp: float = 0.0,
) -> Shell:
    """Walls with a window in the back one and the sky behind it."""
    shell = Shell()
    grey = shell.material(base_color=(0.6,) * 3)
    shell.walls(grey, without=("back", "floor"))
    ground = shell.material(**floor) if floor else grey
    shell.faces(_CORNERS, [_FACES["floor"]], ground)
    # The wall is cut into strips, one for each window.
    edges = [-1.0, *((a[2] + b[0]) / 2 for a, b in pairwise(holes)), 1.0]
    for (x0, z0, x1, z1), west, east in zip(holes, edges, edges[1:], strict=False):
        outer = [(west, 1, -1), (east, 1, -1), (east, 1, 1), (west, 1, 1)]
        inner = [(x0, 1, z0), (x1, 1, z0), (x1, 1, z1), (x0, 1, z1)]
        ring = [[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)]
        shell.faces([*outer, *inner], ring, grey)
        shell.window((x0, z0, x1, z1))
    if lamp:
        shell.lamp((0.0, 0.0, 0.9), (0.4, 0.3), lamp)
    shell.sky(20.0, sun, folder)
    return shell


def _through(folder: Path, *holes: Sequence[float]) -> Usd.Stage:
    """Light from the window gets to the camera by holes in partitions, one behind the other."""
    shell = window_room(folder)
    grey = shell.material(base_color=(0.6,) * 3)
    for number, hole in enumerate(holes):
        shell.pierced(grey, hole, 0.5 - 0.5 * number)
    return shell.camera((-0.7, -0.85, 0.3), (0.3, 0.2, -0.3))


def _sofa(folder: Path) -> Usd.Stage:
    shell = lamp_room()
    shell.box((-0.6, -0.7, 0.0), (0.7, 0.5, 1.9), shell.material(base_color=(0.5, 0.1, 0.1)))
    return shell.camera((-0.6, -0.7, 0.0), TARGET)


def _twice(folder: Path) -> Usd.Stage:
    shell = lamp_room()
    shell.walls(shell.material(base_color=(0.6,) * 3))
    return shell.camera(EYE, TARGET)


def _flat(folder: Path) -> Usd.Stage:
    shell = lamp_room()
    points = [*_CORNERS, (0, 0, 0), (0, 0, 0), (0.5, 0, 0), (0.2, 0, 0)]
    shell.faces(points, [[8, 9, 10], [8, 11, 10], [8, 8, 8]], shell.material(emissive=(5.0,) * 3))
    return shell.camera(EYE, TARGET)


def many(count: int) -> Usd.Stage:
    """A room with so many lamps of five strengths under its ceiling."""
    shell = lamp_room(nits=0.0)
    side = int(np.ceil(np.sqrt(count)))
    for n in range(count):
        x, y = (2 * (n % side) + 1) / side - 1, (2 * (n // side) + 1) / side - 1
        shell.lamp((0.95 * x, 0.95 * y, 0.9), (0.05, 0.05), 200.0 * (1 + n % 5))
    return shell.camera(EYE, TARGET)


@dataclass(frozen=True)
class Case:
    """A room that is hard to light.

    Attributes:
        condition: What makes it so.
        build: Gives the stage; pictures go into the folder.
        bounces: At most this many scatterings.
    """

    condition: str
    build: Callable[[Path], Usd.Stage]
    bounces: int = 7


def _seen(shell: Shell, eye: Point = EYE, target: Point = TARGET) -> Usd.Stage:
    return shell.camera(eye, target)


CASES: Final[dict[str, Case]] = {
    "plain": Case("2 m, one lamp", lambda f: _seen(lamp_room())),
    "point lamp": Case("1 mm wide", lambda f: _seen(lamp_room(size=(1e-3, 1e-3), nits=6e6))),
    "ceiling lamp": Case("all of it", lambda f: _seen(lamp_room(size=(2, 2), z=0.99, nits=2.0))),
    "lamp at the wall": Case(
        "an edge in the wall", lambda f: _seen(lamp_room(size=(1.6, 0.3), z=0.5, nits=20.0))
    ),
    "window's plane": Case(
        "the wall around it", lambda f: _seen(window_room(f), (0.0, -0.2, 0.0), (0.8, 1.0, 0.1))
    ),
    "grazing": Case(
        "1 cm above the floor", lambda f: _seen(lamp_room(), (-0.9, -0.9, -0.99), (1, 1, -0.992))
    ),
    "mirror": Case(
        "roughness 0, a patch of sun",
        lambda f: _seen(
            window_room(
                f, sun=1e6, floor={"base_color": (0.4, 0.4, 0.4), "roughness": 0.0, "ior": 1.5}
            )
        ),
    ),
    "door ajar": Case("a gap of 5 cm", lambda f: _through(f, (0.6, -0.99, 0.65, 0.6))),
    "two openings": Case(
        "one behind the other",
        lambda f: _through(f, (-0.4, -0.6, 0.4, 0.6), (-0.2, -0.8, 0.6, 0.5)),
    ),
    "slit": Case("1 cm wide", lambda f: _through(f, (0.2, -0.9, 0.21, 0.9))),
    "50 lamps": Case("of five strengths", lambda f: many(50)),
    "three windows": Case(
        "0.55 x 1.6 m each",
        lambda f: _seen(
            window_room(f, [(x, -0.8, x + 0.55, 0.8) for x in (-0.95, -0.27, 0.4)], sun=1e6)
        ),
    ),
    "sun and lamp": Case("1e9 against 1 nit", lambda f: _seen(window_room(f, sun=5e7, lamp=1.0))),
    "black": Case("albedo 0", lambda f: _seen(lamp_room(color=0.0))),
    "white": Case("albedo 0.95, 50 bounces", lambda f: _seen(lamp_room(color=0.95)), 50),
    "5 cm": Case("scaled", lambda f: _small(0.025)),
    "200 m": Case("scaled", lambda f: _small(100.0)),
    "far away": Case("1e5 m", lambda f: _small(1.0, (1e5, -1e5, 0.0))),
    "coincident": Case("walls twice", _twice),
    "zero area": Case("triangles, emitting", _flat),
    "inverted": Case("normals outwards", lambda f: _seen(lamp_room(inverted=True))),
    "inside a sofa": Case("no light at all", _sofa),
}


def _small(unit: float, at: Point = (0, 0, 0)) -> Usd.Stage:
    return lamp_room(unit=unit, at=at).camera(EYE, TARGET)
