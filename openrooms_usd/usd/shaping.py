"""`UsdLux.ShapingAPI` of a light: the IES profile that its radiance follows."""

from pathlib import Path
from typing import Final

from pxr import Sdf, Usd, UsdLux

from openrooms_usd.errors import InputError
from openrooms_usd.usd.emitters import (
    CylinderLight,
    DiskLight,
    Light,
    MeshLight,
    RectLight,
    SphereLight,
)
from openrooms_usd.usd.profiles import Shaping, read_profile, shaping

_SURFACES: Final = (MeshLight, RectLight, DiskLight, SphereLight, CylinderLight)
_WHEN: Final = Usd.TimeCode.EarliestTime()


def read_shaping(prim: Usd.Prim, light: Light) -> tuple[Shaping | None, tuple[str, ...]]:
    """What a light's profile makes of it, and what was lost.

    Args:
        prim: The light.
        light: The same as plain data.
    """
    api = UsdLux.ShapingAPI(prim)
    asset = api.GetShapingIesFileAttr().Get(_WHEN) if api.GetShapingIesFileAttr() else None
    if asset is None or not asset.path:
        return None, ()
    if not isinstance(light, _SURFACES):
        return None, ("inputs:shaping:ies:file: the light does not follow its IES profile",)
    if not asset.resolvedPath:
        return None, (f"its IES profile {asset.path} is missing",)
    try:
        profile = read_profile(Path(asset.resolvedPath))
    except InputError as error:
        return None, (f"{asset.path}: {error.message}; it shines evenly",)
    normalize = bool(_value(api.GetShapingIesNormalizeAttr(), False))
    scale = float(_value(api.GetShapingIesAngleScaleAttr(), 0.0))
    found = shaping(profile, light.world_from_light, normalize=normalize, scale=scale)
    return found, ()


def define_shaping(prim: Usd.Prim, file: str) -> None:
    """Let a light follow an IES profile, which changes where its light goes.

    Args:
        prim: The light, or an over where it shall be.
        file: Asset path of the profile.
    """
    api = UsdLux.ShapingAPI.Apply(prim)
    api.CreateShapingIesFileAttr(Sdf.AssetPath(file))
    api.CreateShapingIesNormalizeAttr(True)


def _value(attribute: Usd.Attribute, default: float | bool) -> float | bool:
    value = attribute.Get(_WHEN) if attribute else None
    return default if value is None else value
