"""Lights, authored in nits. `read_lights` reads those of any stage."""

import numpy as np
from pxr import Gf, Sdf, Usd, UsdLux

from openrooms_usd.colorimetry import luminance
from openrooms_usd.usd.emitters import (
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
from openrooms_usd.usd.lightsearch import read_lights
from openrooms_usd.usd.transforms import author_upright

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
