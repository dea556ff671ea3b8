"""Surfaces and lights as Mitsuba plugin descriptions, `Picture` where a texture stands."""

from dataclasses import replace
from typing import Any

import numpy as np

from openrooms_usd.rendering.scene.arrays import Sun
from openrooms_usd.rendering.scene.pictures import Picture, Value
from openrooms_usd.rendering.scene.surfaces import Surface, mean_luminance
from openrooms_usd.usd.shading.surfaces import f0_of

Description = dict[str, Any]


def describe_bsdf(surface: Surface, *, by_formula: bool = False) -> Description:
    """The BSDF of a surface: nested dictionaries of plugins, numbers and pictures.

    Without any specular lobe it is exactly Lambertian. OpenRooms' model is our own plugin
    (`orusd_mitsuba.plugins.openrooms_bsdf`).

    Args:
        surface: What it shows.
        by_formula: Whether a UsdPreviewSurface is our own plugin (`preview_bsdf`), too. Else that
            of Mitsuba stands for it that is nearest.
    """
    if surface.pane is not None:
        return _pane(surface.ior, surface.pane)
    bsdf = _by_model(surface, by_formula)
    if surface.opacity == 1.0:
        return bsdf
    return {"type": "mask", "opacity": surface.opacity, "bsdf": bsdf}


def _pane(ior: float, tint: tuple[float, float, float]) -> Description:
    """A clear pane for Mitsuba's own integrators: what passes is tinted alike at every angle."""
    tinted = describe_color(tint)
    return {"type": "thindielectric", "int_ior": ior, "specular_transmittance": tinted}


def _by_model(surface: Surface, by_formula: bool) -> Description:
    if surface.f0 is not None:
        return _openrooms(surface)
    return (
        _cloth(surface, by_formula) if surface.transmission > 0.0 else _opaque(surface, by_formula)
    )


def _openrooms(surface: Surface) -> Description:
    described = {
        "type": "openrooms",
        "base_color": describe_color(surface.base_color),
        "roughness": surface.roughness,
        "metallic": surface.metallic,
        "f0": surface.f0,
        "transmission": transmitted(surface),
    }
    return described if surface.normal is None else described | {"normal": stored(surface.normal)}


def transmitted(surface: Surface) -> float:
    """What passes, in multiples of the base colour."""
    if surface.transmission <= 0.0:
        return 0.0
    return surface.transmission / mean_luminance(surface.base_color)


def _opaque(surface: Surface, by_formula: bool) -> Description:
    if by_formula and not surface.is_diffuse:
        return _preview(surface)
    bsdf = _lobes(surface)
    if surface.normal is not None:
        bsdf = {"type": "normalmap", "normalmap": stored(surface.normal), "bsdf": bsdf}
    return {"type": "twosided", "bsdf": bsdf}


def _preview(surface: Surface) -> Description:
    described = {
        "type": "usd_preview",
        "base_color": describe_color(surface.base_color),
        "roughness": surface.roughness,
        "metallic": surface.metallic,
        "f0": f0_of(surface.ior),
        "clearcoat": surface.clearcoat,
        "clearcoat_roughness": surface.clearcoat_roughness,
    }
    if surface.specular is not None:
        described["specular"] = describe_color(surface.specular)
    if surface.normal is not None:
        described["normal"] = stored(surface.normal)
    return described


def _cloth(surface: Surface, by_formula: bool) -> Description:
    """A sheet that reflects its base colour and transmits a part in the same hue.

    A mixture of both in proportion to their luminance: each side then has the colour of the sum,
    and the diffuse parts are exactly Lambertian.
    """
    reflected = mean_luminance(surface.base_color)
    both = (reflected + surface.transmission) / reflected
    mixed = replace(surface, base_color=_times(surface.base_color, both), transmission=0.0)
    through = {
        "type": "principledthin",
        "base_color": describe_color(mixed.base_color),
        "diff_trans": 2.0,
    }
    share = surface.transmission / (reflected + surface.transmission)
    return {"type": "blendbsdf", "weight": share, "a": _opaque(mixed, by_formula), "b": through}


def _times(color: Value, factor: float) -> Value:
    if isinstance(color, Picture):
        return Picture((color.pixels * factor).astype(color.pixels.dtype), color.wrap, color.uv)
    red, green, blue = (np.array(color) * factor).tolist()
    return red, green, blue


def describe_color(value: Value) -> Any:
    """A constant or textured value as a plugin."""
    if isinstance(value, tuple):
        return {"type": "rgb", "value": list(value)}
    return value


def describe_area(radiance: Value, weight: float) -> Description:
    """A mesh's emission, and how often it is sampled."""
    return {"type": "area", "radiance": describe_color(radiance), "sampling_weight": weight}


def describe_sun(sun: Sun, weight: float) -> Description:
    """Parallel light."""
    return {
        "type": "directional",
        "direction": sun.direction.tolist(),
        "irradiance": {"type": "rgb", "value": sun.irradiance.tolist()},
        "sampling_weight": weight,
    }


def _lobes(surface: Surface) -> Description:
    """What of Mitsuba's is nearest to the formula; its diffuse part and its coat are Disney's."""
    if surface.is_diffuse:
        return {"type": "diffuse", "reflectance": describe_color(surface.base_color)}
    lobes = {
        "type": "principled",
        "base_color": describe_color(surface.base_color),
        "roughness": surface.roughness,
        "metallic": surface.metallic,
        "eta": max(surface.dielectric, 1.001),
    }
    if surface.clearcoat > 0.0:
        # Its lobe is as wide as GGX of that roughness, between 0.1 and 0.001.
        gloss = min(max((0.1 - surface.clearcoat_roughness**2) / 0.099, 0.0), 1.0)
        lobes |= {"clearcoat": surface.clearcoat, "clearcoat_gloss": gloss}
    return lobes


def stored(normal: Picture) -> Picture:
    """Normals as ``normalmap`` reads them, in 0..1."""
    return Picture((normal.pixels + np.float16(1)) * np.float16(0.5), normal.wrap, normal.uv)
