"""Lights, authored in nits. `read_lights` reads those of any stage."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux

from openrooms_usd.arrays import Array
from openrooms_usd.colorimetry import luminance
from openrooms_usd.usd.arrays import number_of
from openrooms_usd.usd.light.emitters import (
    CylinderLight,
    DiskLight,
    DistantLight,
    DomeLight,
    Light,
    MeshLight,
    RectLight,
    SphereLight,
    UnknownLight,
)
from openrooms_usd.usd.light.lightsearch import read_lights
from openrooms_usd.usd.places.frames import (
    TIME,
    author_matrix,
    author_upright,
    local_to_world,
    world_from_stage,
)

__all__ = [
    "CylinderLight",
    "DiskLight",
    "DistantLight",
    "DomeLight",
    "Light",
    "MeshLight",
    "RectLight",
    "SphereLight",
    "UnknownLight",
    "define_dome",
    "define_mesh_light",
    "read_lights",
]


def define_dome(
    stage: Usd.Stage,
    path: str | Sdf.Path,
    *,
    radiance: tuple[float, float, float] = (1.0, 1.0, 1.0),
    texture: str | None = None,
    rotation: float = 0.0,
) -> UsdLux.DomeLight:
    """Define the surroundings of a stage whose Z is up.

    A ``DomeLight``, whose pole is +Y, turned upright by the operation that UsdLux has for it:
    Blender 5 lays a ``DomeLight_1`` with its pole along +Z on its side.

    Args:
        stage: Where to define it; the edit target receives everything.
        path: The prim's path.
        radiance: Nits of each primary; with a texture, the factor of its pixels.
        texture: Asset path of a latitude-longitude picture; without rotation its middle looks
            along -Y, a quarter from the left along +X.
        rotation: Degrees about the vertical, counter-clockwise from above.
    """
    dome = UsdLux.DomeLight.Define(stage, path)
    intensity = float(luminance(np.array(radiance)))
    dome.CreateIntensityAttr(intensity)
    if intensity > 0:
        dome.CreateColorAttr(Gf.Vec3f(*(value / intensity for value in radiance)))
    if texture is not None:
        dome.CreateTextureFileAttr(texture)
        dome.CreateTextureFormatAttr(UsdLux.Tokens.latlong)
    author_upright(dome.GetPrim(), rotation)
    return dome


def define_mesh_light(
    prim: Usd.Prim,
    *,
    nits: float,
    kelvin: float | None = None,
    color: tuple[float, float, float] | None = None,
) -> None:
    """Make a mesh emit the same luminance everywhere.

    Args:
        prim: The mesh, or an over where it shall be.
        nits: Its luminance.
        kelvin: Colour temperature, which changes the hue and not the luminance; white when None.
        color: Its hue as a factor of each primary, in place of a temperature.
    """
    UsdLux.MeshLightAPI.Apply(prim)
    light = UsdLux.LightAPI(prim)
    light.CreateIntensityAttr(nits)
    light.CreateNormalizeAttr(False)
    # The schema's own default multiplies by the glow of the material, which is black here.
    light.CreateMaterialSyncModeAttr(UsdLux.Tokens.noMaterialResponse)
    if color is not None:
        light.CreateColorAttr(Gf.Vec3f(*color))
    if kelvin is not None:
        light.CreateEnableColorTemperatureAttr(True)
        light.CreateColorTemperatureAttr(kelvin)


@dataclass(frozen=True)
class Portal:
    """A rectangle that light from outside passes.

    Attributes:
        path: Its prim.
        world_from_portal: (4, 4) its frame in the world, metres: centre, x along its width, y along
            its height, z outwards (UsdLux: it transmits light along -Z). A rigid motion.
        width: Metres.
        height: Metres.
    """

    path: str
    world_from_portal: Array
    width: float
    height: float


def define_portal(stage: Usd.Stage, portal: Portal) -> UsdLux.PortalLight:
    """Define a ``PortalLight``, in a stage in metres with Z up."""
    light = UsdLux.PortalLight.Define(stage, portal.path)
    light.CreateWidthAttr(portal.width)
    light.CreateHeightAttr(portal.height)
    light.CreateExtentAttr(UsdGeom.Boundable.ComputeExtentFromPlugins(light, TIME))
    author_matrix(light.GetPrim(), portal.world_from_portal)
    return light


def connect_portals(dome: Usd.Prim, portals: Iterable[Usd.Prim]) -> None:
    """Tell a dome light which portals it shines through."""
    relationship = dome.CreateRelationship(UsdLux.Tokens.portals, custom=False)
    relationship.SetTargets([prim.GetPath() for prim in portals])


def read_portals(stage: Usd.Stage) -> tuple[Portal, ...]:
    """The portals of a stage, in world metres with Z up; ones without any area are left out."""
    found = []
    cache, to_world = UsdGeom.XformCache(TIME), world_from_stage(stage)
    for prim in stage.Traverse(Usd.TraverseInstanceProxies()):
        if prim.IsA(UsdLux.PortalLight):
            light = UsdLux.PortalLight(prim)
            world = to_world @ local_to_world(prim, cache)
            lengths = np.linalg.norm(world[:3, :3], axis=0)
            sides = (light.GetWidthAttr(), light.GetHeightAttr())
            size = lengths[:2] * [number_of(side.Get(TIME)) or 0.0 for side in sides]
            if np.isfinite(world).all() and min(size) > 0.0 and lengths[2] > 0.0:
                world[:3, :3] /= lengths
                found.append(Portal(str(prim.GetPath()), world, *size.tolist()))
    return tuple(found)
