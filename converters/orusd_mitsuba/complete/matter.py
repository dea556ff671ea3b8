"""What every surface of a scene is made of at points, whatever model it reflects by."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.surfaces import Surface
from orusd_mitsuba.plugins.build import Builder
from orusd_mitsuba.plugins.material_table import MaterialTable, fits
from orusd_mitsuba.plugins.openrooms_bsdf import DEFAULT_F0, Matter
from orusd_mitsuba.transport.light_index import registered


class SceneMatter:
    """Looks up base colour, relief and the rest of OpenRooms' inputs for arrays of points.

    Args:
        scene: The arrays.
        built: The Mitsuba scene, its shapes in the order of the scene's patches.
        builder: What made it: pictures and tables are shared.

    Attributes:
        matte: Of each registered shape whether it has Lambert's reflection and no more; None where
            none is so.
        others: The same, whether neither that nor OpenRooms' model is what it reflects by.
    """

    def __init__(self, scene: Scene, built: Any, builder: Builder) -> None:
        shapes = list(built.shapes())
        surfaces = [patch.surface for patch in scene.patches]
        as_openrooms = {id(surface): _as_openrooms(surface) for surface in surfaces}
        tabulated = [fits(as_openrooms[id(surface)]) for surface in surfaces]
        self._table = builder.table
        if self._table is None or not all(map(fits, surfaces)):
            self._table = _table(shapes, [as_openrooms[id(s)] for s in surfaces], tabulated)
        odd = {id(s): s for s, found in zip(surfaces, tabulated, strict=True) if not found}
        # Few: one after the other.
        self._odd = [
            (_marked(shapes, [s is one for s in surfaces]), builder.bsdf(as_openrooms[key]).source)
            for key, one in odd.items()
        ]
        self._kept = as_openrooms
        matte = [surface.f0 is None and _is_matte(surface) for surface in surfaces]
        others = [surface.f0 is None and not _is_matte(surface) for surface in surfaces]
        self.matte = _marked(shapes, matte) if any(matte) else None
        self.others = _marked(shapes, others) if any(others) else None

    def __call__(self, si: Any, active: Any) -> Matter:
        """The matter at surface interactions."""
        found = _black() if self._table is None else self._table(si, active)
        for marked, source in self._odd:
            here = active & looked_up(marked, si, active)
            found = _chosen(here, source(si, here), found)
        return found


def looked_up(marked: Any, si: Any, active: Any) -> Any:
    """What a table by registered shape says of interactions."""
    shape: Any = dr.reinterpret_array(mi.UInt32, si.shape)
    return dr.gather(mi.Bool, marked, shape, active & si.is_valid())


def _is_matte(surface: Surface) -> bool:
    return surface.is_diffuse and surface.transmission == 0.0


def _as_openrooms(surface: Surface) -> Surface:
    if surface.f0 is not None and not surface.lets_through:
        return surface
    f0 = DEFAULT_F0 if surface.f0 is None else surface.f0
    return replace(surface, f0=f0, opacity=1.0, one_sided=False)


def _table(
    shapes: Sequence[Any], surfaces: Sequence[Surface], tabulated: Sequence[bool]
) -> MaterialTable | None:
    chosen = [n for n, found in enumerate(tabulated) if found]
    if not chosen:
        return None
    rows = list({id(surfaces[n]): surfaces[n] for n in chosen}.values())
    number = {id(surface): row for row, surface in enumerate(rows)}
    table = MaterialTable(rows)
    table.bind([shapes[n] for n in chosen], [number[id(surfaces[n])] for n in chosen])
    return table


def _marked(shapes: Sequence[Any], flags: Sequence[bool]) -> Any:
    """A table of booleans by registered shape."""
    numbers = [int(registered(mi.ShapePtr(shape))[0]) for shape in shapes]
    table = np.zeros(max(numbers, default=0) + 1, dtype=bool)
    table[numbers] = flags
    return mi.Bool(table)


def _black() -> Matter:
    zero = mi.Float(0.0)
    return Matter(mi.Color3f(0.0), mi.Float(1.0), zero, zero, zero, mi.Vector3f(0.0, 0.0, 1.0))


def _chosen(where: Any, a: Matter, b: Matter) -> Matter:
    names = ("base_color", "roughness", "metallic", "f0", "transmission", "relief")
    return Matter(**{n: dr.select(where, getattr(a, n), getattr(b, n)) for n in names})
