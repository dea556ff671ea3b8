"""Cameras, lights and materials of a scene, as Python has them."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import numpy as np
from pxr import Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.arrays import Array
from openrooms_usd.channels import CLASS_CHANNELS
from openrooms_usd.colorimetry import luminance
from openrooms_usd.edits.scenefile import ByName, SceneFile
from openrooms_usd.usd.arrays import array_of
from openrooms_usd.usd.cameras import Projection, list_cameras, read_camera
from openrooms_usd.usd.files.diagnostics import quiet
from openrooms_usd.usd.light.emitters import DistantLight, Light
from openrooms_usd.usd.light.lightsearch import read_lights
from openrooms_usd.usd.places.frames import TIME, local_to_world, world_from_stage
from openrooms_usd.usd.rendersettings import stage_resolution
from openrooms_usd.usd.shading.materialreader import read_preview_surface
from openrooms_usd.usd.shading.surfaces import Texture

# A USD file that is read as it is now, and what it holds by name.


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


# What is seen of a prim of any scene: its surfaces, their box, and the objects they are of.

_PROXIES: Final = Usd.TraverseInstanceProxies()
_DRAWN: Final = (UsdGeom.Tokens.default_, UsdGeom.Tokens.render)
_LABELS: Final = frozenset(
    f"SemanticsLabelsAPI:{kind}" for kind in (names.CATEGORY, *CLASS_CHANNELS)
)


def owners_of(root: Usd.Prim) -> list[Usd.Prim]:
    """The objects that the surfaces below a prim are parts of, each once."""
    found = {owner.GetPath(): owner for owner in map(_owner, surfaces_of(root))}
    return list(found.values())


def _owner(prim: Usd.Prim) -> Usd.Prim:
    chain = [prim]
    while not chain[-1].GetParent().IsPseudoRoot():
        chain.append(chain[-1].GetParent())
    labelled = (one for one in chain if not _LABELS.isdisjoint(one.GetAppliedSchemas()))
    return next(labelled, None) or next(filter(Usd.Prim.IsComponent, chain), prim)


def surfaces_of(root: Usd.Prim) -> list[Usd.Prim]:
    """What is drawn of a prim and all below it; of point instancers the whole."""
    found = []
    walk = iter(Usd.PrimRange(root, _PROXIES))
    for prim in walk:
        shown = UsdGeom.Imageable(prim)
        if shown and shown.GetVisibilityAttr().Get(TIME) == UsdGeom.Tokens.invisible:
            walk.PruneChildren()
        elif prim.IsA(UsdGeom.PointInstancer):
            walk.PruneChildren()
            found.append(prim)
        elif prim.IsA(UsdGeom.Gprim) and shown.ComputePurpose() in _DRAWN:
            found.append(prim)
    return found


def points_of(root: Usd.Prim) -> Array:
    """(N, 3) points of the world, metres, in whose box all that is seen of a prim lies."""
    cache, boxes = UsdGeom.XformCache(TIME), UsdGeom.BBoxCache(TIME, list(_DRAWN))
    world = world_from_stage(root.GetStage())
    placed = partial(_placed, world=world, cache=cache, boxes=boxes)
    return np.concatenate([np.zeros((0, 3)), *map(placed, surfaces_of(root))])


def _placed(
    prim: Usd.Prim, world: Array, cache: UsdGeom.XformCache, boxes: UsdGeom.BBoxCache
) -> Array:
    """(N, 3) points of one surface in the world: of a mesh its own, of others their box."""
    points = np.zeros((0, 3))
    if prim.IsA(UsdGeom.PointBased) and not prim.IsA(UsdGeom.Curves):
        points = array_of(UsdGeom.PointBased(prim).GetPointsAttr().Get(TIME), np.float64, 3)
    if not len(points):
        box = boxes.ComputeUntransformedBound(prim).ComputeAlignedRange()
        points = (
            np.zeros((0, 3))
            if box.IsEmpty()
            else np.array([list(box.GetCorner(i)) for i in range(8)])
        )
    M = world @ local_to_world(prim, cache)
    return np.asarray(points @ M[:3, :3].T + M[:3, 3])


def extent_of(points: Array) -> Array:
    """(2, 3) least and greatest coordinates of (N, 3) points; not a number of none."""
    if not len(points):
        return np.full((2, 3), np.nan)
    return np.stack([points.min(axis=0), points.max(axis=0)])
