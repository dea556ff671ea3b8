"""What ``RenderSettings``, products and vars of a stage ask of pictures."""

import math
from collections.abc import Callable, Iterator
from typing import Any, Final

from pxr import Sdf, Usd, UsdGeom, UsdRender, Vt

from openrooms_usd import names
from openrooms_usd.usd.arrays import number_of, vector_of
from openrooms_usd.usd.places.frames import TIME

_POLICY: Final = "aspectRatioConformPolicy"
_RESOLUTION: Final = (640, 480)
_PURPOSES: Final = ("default", "render")
_WHOLE: Final = (0.0, 0.0, 1.0, 1.0)

# How wide the window becomes for a picture: by the aperture's width, and the width that fits the
# picture's shape to the aperture's height. What is not here keeps the aperture's width.
_CONFORM: Final[dict[str, Callable[[float, float], float]]] = {
    "expandAperture": max,
    "cropAperture": min,
    "adjustApertureWidth": lambda width, fitting: fitting,
}

# Channels by what renderers call them; names are compared in small letters.
_CHANNELS: Final = {
    **dict.fromkeys(("ci", "c", "color", "rgb", "rgba", "beauty", "radiance"), "radiance"),
    **dict.fromkeys(("z", "depth"), "depth"),
    **dict.fromkeys(("n", "nn", "normal", "normals"), "normal"),
    **dict.fromkeys(("p", "position"), "position"),
    **dict.fromkeys(("albedo", "base_color", "basecolor", "diffuse_albedo"), "base_color"),
    **dict.fromkeys(("a", "alpha", "coverage"), "valid"),
    **dict.fromkeys(("id", "instanceid", "instance", "primid"), "instance"),
}
# What must be asked for.
_EXTRA: Final = ("emission", "direct", "indirect", "diffuse", "specular", "irradiance")


def render_settings(stage: Usd.Stage) -> UsdRender.Settings | None:
    """The settings that a stage names, or those of our rooms; None without any."""
    found = UsdRender.Settings.GetStageRenderSettings(stage)
    found = found or UsdRender.Settings(stage.GetPrimAtPath(names.RENDER_SETTINGS))
    return found or None


def stage_resolution(stage: Usd.Stage) -> tuple[int, int]:
    """Width and height of a stage's pictures: what it asks for, or 640 x 480."""
    return asked_resolution(stage) or _RESOLUTION


def asked_resolution(stage: Usd.Stage) -> tuple[int, int] | None:
    """Width and height in pixels, by the first product that says, else the settings."""
    size = vector_of(_setting(stage, None, "resolution"), 2)
    return (int(size[0]), int(size[1])) if size is not None and size.min() >= 1.0 else None


def asked_cameras(stage: Usd.Stage) -> tuple[str, ...]:
    """Paths of the cameras that products name; none if no camera is chosen."""
    return tuple(dict.fromkeys(filter(None, map(_camera_of, _products(stage)))))


def asked_purposes(stage: Usd.Stage) -> tuple[str, ...]:
    """The purposes of prims that are drawn."""
    settings = render_settings(stage)
    asked = _tokens(settings.GetIncludedPurposesAttr()) if settings else ()
    return asked or _PURPOSES


def is_set(stage: Usd.Stage, camera: str | None, *flags: str) -> bool:
    """Whether any of these flags is true for pictures of a camera."""
    return any(bool(_setting(stage, camera, flag)) for flag in flags)


def conformed_aperture(camera: UsdGeom.Camera, width: int, height: int) -> float:
    """The horizontal aperture for a picture of square pixels, in the camera's own units.

    By ``aspectRatioConformPolicy`` where the stage has render settings; else the camera's own, and
    the vertical one follows the picture.
    """
    across, high = (
        number_of(attribute.Get(TIME)) or 0.0
        for attribute in (camera.GetHorizontalApertureAttr(), camera.GetVerticalApertureAttr())
    )
    prim = camera.GetPrim()
    policy = str(_setting(prim.GetStage(), str(prim.GetPath()), _POLICY))
    if policy not in _CONFORM or not (0.0 < high < math.inf and 0.0 < across < math.inf):
        return across
    return _CONFORM[policy](across, high * width / height)


def settings_losses(stage: Usd.Stage) -> Iterator[tuple[str, str]]:
    """(prim path, reason) of what the settings ask for and pictures do not have."""
    settings = render_settings(stage)
    if settings is None:
        return
    bound = _tokens(settings.GetMaterialBindingPurposesAttr())
    if bound and bound[0] not in ("full", ""):
        yield str(settings.GetPath()), f"materials bound for {bound[0]!r} are replaced by full ones"
    size = asked_resolution(stage)
    for one in (settings, *_products(stage)):
        path = str(one.GetPath())
        window = vector_of(one.GetDataWindowNDCAttr().Get(TIME), 4)
        if window is not None and tuple(window) != _WHOLE:
            yield path, "dataWindowNDC is left out: the whole picture is rendered"
        policy = one.GetAspectRatioConformPolicyAttr().Get(TIME)
        if one.GetPixelAspectRatioAttr().Get(TIME) != 1.0 or policy == "adjustPixelAspectRatio":
            yield path, "pixels are square"
        attribute = one.GetResolutionAttr()
        own = vector_of(attribute.Get(TIME), 2) if attribute.HasAuthoredValue() else None
        if own is not None and size and tuple(own) != size:
            yield path, f"all views have {size[0]}x{size[1]} pixels"
    for product in _products(stage):
        yield from _var_losses(product)


def _var_losses(product: UsdRender.Product) -> Iterator[tuple[str, str]]:
    stage = product.GetPrim().GetStage()
    for path in product.GetOrderedVarsRel().GetForwardedTargets():
        var = UsdRender.Var(stage.GetPrimAtPath(path))
        name = str(var.GetSourceNameAttr().Get(TIME) or path.name).lower() if var else ""
        if name in _EXTRA:
            yield str(path), f"it must be requested: --channels usual,{name}"
        elif name and name not in _CHANNELS:
            yield str(path), f"no channel has the name {name!r}"


def _products(stage: Usd.Stage) -> list[UsdRender.Product]:
    settings = render_settings(stage)
    targets = settings.GetProductsRel().GetForwardedTargets() if settings else []
    found = (UsdRender.Product(stage.GetPrimAtPath(path)) for path in targets)
    return [product for product in found if product]


def _camera_of(product: UsdRender.Product) -> str | None:
    """The camera that a product names, or its settings."""
    stage = product.GetPrim().GetStage()
    for one in (product, render_settings(stage)):
        targets: list[Sdf.Path] = one.GetCameraRel().GetForwardedTargets() if one else []
        if targets and UsdGeom.Camera(stage.GetPrimAtPath(targets[0])):
            return str(targets[0])
    return None


def _tokens(attribute: Usd.Attribute) -> tuple[str, ...]:
    """The words of an attribute; none where its value is of another type."""
    value = attribute.Get(TIME)
    return tuple(map(str, value)) if isinstance(value, Vt.TokenArray) else ()


def _setting(stage: Usd.Stage, camera: str | None, name: str) -> Any:
    """A setting for a camera's pictures, or for the first; None where there are no settings."""
    settings = render_settings(stage)
    if settings is None:
        return None
    for product in _products(stage):
        attribute = product.GetPrim().GetAttribute(name)
        if camera in (None, _camera_of(product)) and attribute.HasAuthoredValue():
            return attribute.Get(TIME)
    return settings.GetPrim().GetAttribute(name).Get(TIME)
