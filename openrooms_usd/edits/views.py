"""Cameras, lights and materials of a scene, as Python has them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pxr import UsdShade

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import luminance
from openrooms_usd.edits.scenefile import ByName, SceneFile
from openrooms_usd.rendering.scene.cameras import stage_resolution
from openrooms_usd.usd.cameras import Projection, list_cameras, read_camera
from openrooms_usd.usd.files.diagnostics import quiet
from openrooms_usd.usd.light.emitters import DistantLight, Light
from openrooms_usd.usd.light.lightsearch import read_lights
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.surfaces import Texture


@dataclass(frozen=True, eq=False)
class SceneCamera:
    """A camera of a scene.

    Attributes:
        name: Its name; renders take it.
        path: Its prim; renders take that, too.
        K: (3, 3) intrinsics in pixels; the centre of the top-left pixel is (0.5, 0.5).
        world_from_camera: (4, 4) from the OpenCV frame (x right, y down, z forward) to the world:
            Z up, metres.
        resolution: Width and height in pixels, of which ``K`` is.
        projection: ``pinhole``, ``orthographic`` or ``equirectangular``.
    """

    name: str
    path: str
    K: Array
    world_from_camera: Array
    resolution: tuple[int, int]
    projection: Projection


@dataclass(frozen=True, eq=False)
class SceneLight:
    """A light of a scene.

    Attributes:
        name: That of the piece of furniture that shines, else of the prim.
        path: The prim that emits.
        kind: ``mesh``, ``rect``, ``disk``, ``sphere``, ``cylinder``, ``distant`` or ``dome``.
        radiance: (3,) nits of each primary, scene-linear Rec.709; of a texture the factor; of a
            distant light its irradiance in lux.
        pose: (4, 4) world_from_light: Z up, metres.
    """

    name: str
    path: str
    kind: str
    radiance: Array
    pose: Array

    @property
    def luminance(self) -> float:
        """0.2126 R + 0.7152 G + 0.0722 B of ``radiance``; 0 of a light that is off."""
        return float(luminance(self.radiance))


@dataclass(frozen=True)
class SceneMaterial:
    """A material of a scene.

    Attributes:
        name: Its name.
        path: Its prim.
        base_color: (r, g, b), scene-linear Rec.709; None where it comes from a texture.
        roughness: Perceptual, 0 to 1; None where it comes from a texture.
        metallic: 0 to 1; None where it comes from a texture.
        textures: The picture of each input that has one, by the input's name.
    """

    name: str
    path: str
    base_color: tuple[float, float, float] | None
    roughness: float | None
    metallic: float | None
    textures: Mapping[str, str]


def material_of(material: UsdShade.Material) -> SceneMaterial:
    """A material of any stage, as far as it can be read."""
    surface, _ = read_preview_surface(material)
    said = {key: getattr(surface, key) for key in ("base_color", "roughness", "metallic")}
    plain = {k: None if isinstance(v, Texture) else v for k, v in said.items()}
    textures = {k: str(v.file) for k, v in vars(surface).items() if isinstance(v, Texture)}
    path = material.GetPath()
    return SceneMaterial(path.name, str(path), **plain, textures=textures)


def cameras_of(file: SceneFile) -> ByName[SceneCamera]:
    """The cameras of any scene, sorted by path."""
    stage = file.stage()
    size = stage_resolution(stage)

    def read(prim: Any) -> SceneCamera:
        seen, path = read_camera(prim, *size), prim.GetPath()
        return SceneCamera(
            path.name, str(path), seen.K, seen.world_from_camera, size, seen.projection
        )

    cameras = map(read, list_cameras(stage))
    return ByName("camera", file.path, {camera.path: camera for camera in cameras})


def lights_of(file: SceneFile) -> ByName[SceneLight]:
    """The lights of any scene, in the order of the stage."""
    with quiet():
        lights = [_light(light) for light in read_lights(file.stage())]
    return ByName("light", file.path, {light.path: light for light in lights})


def _light(light: Light) -> SceneLight:
    kind = type(light).__name__.removesuffix("Light").lower()
    power = light.irradiance if isinstance(light, DistantLight) else light.radiance
    inside = light.path.startswith(f"{names.FURNITURE}/")
    name = light.path.split("/")[3] if inside else light.path.rpartition("/")[2]
    return SceneLight(name, light.path, kind, power, light.world_from_light)
