"""What a robot's cameras see of a simulation: through any renderer, with ground truth.

The room is translated and opened once. Before each picture what has moved is moved in the arrays
that the renderer holds, so that only the picture itself takes time.
"""

import os
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.description.rendering import REFERENCE, RenderSettings
from openrooms_usd.engines import Simulation
from openrooms_usd.errors import MissingPackageError
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.pinhole import intrinsics
from openrooms_usd.geometry.triangulation import TriangleMesh
from openrooms_usd.physics.world import Body, World
from openrooms_usd.rendering.context import RenderContext
from openrooms_usd.rendering.contract import View
from openrooms_usd.rendering.denoise import Denoiser, load_denoiser
from openrooms_usd.rendering.friction import FRICTION, FrictionMap
from openrooms_usd.rendering.opening import load_renderer, open_for_rendering
from openrooms_usd.simulation.robots import CAMERA, COLORS
from openrooms_usd.simulation.settledlayer import choose_look
from openrooms_usd.simulation.settling import motions
from openrooms_usd.usd import semantics
from openrooms_usd.usd.cameras import PinholeCamera
from openrooms_usd.usd.files import layers
from openrooms_usd.usd.shading.materials import PreviewSurface, define_preview_surface
from openrooms_usd.usd.shapes.meshes import define_mesh

RGB: Final = "radiance"
RESOLUTION: Final = (160, 120)
SAMPLES: Final = 16
SEEN: Final = (RGB, "depth", "normal", "semantic")

_ROBOTS: Final = f"{names.WORLD}/Robots"
# A link's axes (forward, left, up) as columns of the camera's (right, down, forward).
_CAMERA_FROM_LINK: Final = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])


class RobotCameras:
    """Pictures of a room while it is simulated.

    Bodies without a prim, such as robots, are added to the stage in a layer in memory. The file is
    never touched.
    """

    def __init__(
        self,
        path: str | os.PathLike[str],
        world: World,
        settings: RenderSettings | None = None,
        *,
        look: str | None = None,
        **fields: Any,
    ) -> None:
        """Open a room.

        Args:
            path: The USD file that the world was read from.
            world: The room, with its robots.
            settings: What is asked for; `RESOLUTION` and `SAMPLES` by default.
            look: Choose this variant of every object that has it.
            **fields: What is asked for, by the names of the settings.

        Raises:
            InputError: The file is not USD, or no variant has that look.
        """
        settings = (settings or RenderSettings()).replace(**fields)
        self._resolution = settings.resolution or RESOLUTION
        self._settings = settings.replace(
            resolution=self._resolution,
            samples=settings.samples or SAMPLES,
            method=settings.method or REFERENCE,
        )
        load_renderer(self._settings)
        self._world = world
        self._denoiser = _denoiser()
        self._robots = Sdf.Layer.CreateAnonymous(".usda")
        layers.apply_metadata(self._robots)
        root = Sdf.Layer.CreateAnonymous(".usda")
        layers.apply_metadata(root)
        root.subLayerPaths = [self._robots.identifier, os.fspath(path)]
        self._stage = Usd.Stage.Open(root)
        if look is not None:
            choose_look(self._stage, look, Path(path))
        with Usd.EditContext(self._stage, self._robots):
            _define_robots(self._stage, (body for body in world.bodies if not body.path))

    def see(
        self,
        simulation: Simulation,
        cameras: Mapping[str, Array],
        channels: Iterable[str] = SEEN,
        *,
        fov_degrees: float = 70.0,
    ) -> dict[str, View]:
        """Render what cameras see now.

        Args:
            simulation: Of the world that was given.
            cameras: By name, (4, 4) from the OpenCV frame to the world, such as `robot_camera`.
            channels: What to render; also ``friction``. With the radiance comes its denoised
                version where a denoiser is installed: it is for people.
            fov_degrees: Horizontal field of view.

        Raises:
            RenderError: The renderer cannot do it.
        """
        wanted = tuple(channels)
        self._opened.move(dict(self._motions(simulation)))
        needed = FrictionMap.needs(wanted) if FRICTION in wanted else wanted
        denoiser = self._denoiser if RGB in wanted else None
        found = {}
        for name, pose in cameras.items():
            request = self._opened.request(_key(name), channels=needed, guides=denoiser is not None)
            view = self._opened.picture(self._pinhole(pose, fov_degrees), request)
            if denoiser is not None:
                view = denoiser.complete(view)
            if FRICTION in wanted:
                view = self._opened.friction.complete(view, (*view.images, FRICTION))
            found[name] = view
        return found

    @property
    def legend(self) -> Mapping[int, str]:
        """What the numbers of the channel ``semantic`` mean."""
        return self._opened.legend.semantic

    @cached_property
    def _opened(self) -> RenderContext:
        """The room with its robots, translated and opened once, when the first picture is asked."""
        return open_for_rendering(self._stage, self._settings)

    def _motions(self, simulation: Simulation) -> Iterator[tuple[str, Array]]:
        """By prim path, how everything has moved since the stage; robots since the origin."""
        yield from ((row.path, row.world_motion) for row in motions(self._world, simulation))
        for body in self._world.bodies:
            for link, pose in simulation.links(body.name).items() if not body.path else ():
                yield f"{_ROBOTS}/{body.name}/{link}", pose

    def _pinhole(self, world_from_camera: Array, fov_degrees: float) -> PinholeCamera:
        return PinholeCamera(intrinsics(fov_degrees, *self._resolution), world_from_camera)


def _key(name: str) -> str:
    """What a camera's random numbers depend on, beside the seed."""
    return f"{_ROBOTS}/{name}"


def _denoiser() -> Denoiser | None:
    try:
        return load_denoiser()
    except MissingPackageError:
        return None


def robot_camera(simulation: Simulation, body: str, link: str = CAMERA) -> Array:
    """(4, 4) world_from_camera, OpenCV axes, of a link that looks along its own +X."""
    pose = simulation.links(body)[link].copy()
    pose[:3, :3] = pose[:3, :3] @ _CAMERA_FROM_LINK.T
    return pose


def _define_robots(stage: Usd.Stage, robots: Iterable[Body]) -> None:
    UsdGeom.Scope.Define(stage, f"{_ROBOTS}/Materials")
    for path, color in COLORS.items():
        define_preview_surface(stage, path, PreviewSurface(base_color=color, roughness=0.4))
    for body in robots:
        root = UsdGeom.Xform.Define(stage, f"{_ROBOTS}/{body.name}")
        semantics.label(root.GetPrim(), body.category)
        for link in body.links:
            path = root.GetPath().AppendChild(link.name)
            UsdGeom.Xform.Define(stage, path)
            for visual in link.visuals:
                mesh = define_mesh(stage, path.AppendChild(visual.name), _polygons(visual.mesh))
                binding = UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim())
                binding.Bind(UsdShade.Material.Get(stage, visual.material))


def _polygons(mesh: TriangleMesh) -> Mesh:
    counts = np.full(len(mesh.triangles), 3, np.int32)
    normals = None if mesh.normals is None else mesh.normals.reshape(-1, 3)
    return Mesh(mesh.points, counts, mesh.triangles.ravel().astype(np.int32), normals)
