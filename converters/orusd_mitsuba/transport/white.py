"""The first surface made white, so that what it sends to the camera tells what it receives.

A Lambertian surface of reflectance 1 sends radiance E / pi. It keeps the normal map, which turns
the horizon that irradiance is relative to, and the opacity, which says what the camera sees at all.
"""

from collections.abc import Callable
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.surfaces import Surface
from orusd_mitsuba.plugins.build import Builder
from orusd_mitsuba.transport.light_index import registered


def whitened(surface: Surface) -> Surface:
    """The surface with nothing but a white Lambertian lobe."""
    return Surface(
        base_color=(1.0, 1.0, 1.0),
        roughness=1.0,
        ior=1.0,
        opacity=surface.opacity,
        normal=surface.normal,
        primvar=surface.primvar,
        uv=surface.uv,
        one_sided=surface.one_sided,
    )


def white_first(scene: Scene, built: Any, builder: Builder) -> Callable[[Any], Any]:
    """A function from interactions to the white BSDFs of their shapes.

    Args:
        scene: The arrays.
        built: The Mitsuba scene, its shapes in the order of the scene's patches.
        builder: What made it: textures are shared.
    """
    known: dict[tuple[int, int, bool], Any] = {}
    # The builder knows surfaces by their identity, which must not be given to another.
    kept: list[Surface] = []
    shapes = [int(registered(mi.ShapePtr(shape))[0]) for shape in built.shapes()]
    table = np.zeros(max(shapes, default=0) + 1, dtype=np.uint32)
    for shape, patch in zip(shapes, scene.patches, strict=True):
        surface = patch.surface
        key = id(surface.normal), id(surface.opacity), surface.one_sided
        if key not in known:
            kept.append(whitened(surface))
            known[key] = builder.bsdf(kept[-1])
        table[shape] = registered(mi.BSDFPtr(known[key]))[0]
    numbers = mi.UInt32(table)

    def first(si: Any) -> Any:
        shape: Any = dr.reinterpret_array(mi.UInt32, si.shape)
        number = dr.gather(mi.UInt32, numbers, shape, si.is_valid())
        return dr.reinterpret_array(mi.BSDFPtr, number)

    # The registry does not keep what it knows alive.
    first.kept = known, kept  # type: ignore[attr-defined]
    return first
