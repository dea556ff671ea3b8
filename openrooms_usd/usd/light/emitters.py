"""Lights as plain data: radiance in nits, frames in the world, Z up, metres.

Radiance is scene-linear Rec.709 in nits: ``0.2126 R + 0.7152 G + 0.0722 B`` is luminance, cd/m2.
"""

import math
from dataclasses import dataclass, field

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.usd.light.profiles import Shaping
from openrooms_usd.usd.places import frames
from openrooms_usd.usd.shapes.tessellation import tessellate


@dataclass(frozen=True, eq=False)
class Light:
    """What every light has.

    Attributes:
        path: Its prim.
        radiance: (3,) nits of each primary; factor of the texture where there is one.
        world_from_light: (4, 4) for columns, from its local frame to the world, Z up, metres.
        losses: One sentence for each unsupported feature.
        shaping: What its radiance is multiplied with by direction; None: it is even.
        response: Factors of what it does on diffuse and on specular surfaces: not physical.
        source: The prim that says it, of what a point instancer scatters; else empty.
        unseen: Whether it lights without being seen, as points and lines do.
    """

    path: str
    radiance: Array
    world_from_light: Array
    losses: tuple[str, ...]
    shaping: Shaping | None = field(default=None, kw_only=True)
    response: tuple[float, float] = field(default=(1.0, 1.0), kw_only=True)
    source: str = field(default="", kw_only=True)
    unseen: bool = field(default=False, kw_only=True)

    @property
    def prim(self) -> str:
        """The prim that says what it is."""
        return self.source or self.path


@dataclass(frozen=True, eq=False)
class DomeLight(Light):
    """The surroundings at infinity.

    The local frame is that of OpenEXR's latitude-longitude maps: +Y is the picture's upper edge,
    its middle looks along +Z, a quarter from the left along +X. ``world_from_light`` has the pole
    axis of the prim worked in, and no scale.

    Attributes:
        texture: The picture in latitude-longitude layout, None for a constant dome.
    """

    texture: str | None


@dataclass(frozen=True, eq=False)
class MeshLight(Light):
    """A mesh that emits from its front sides.

    Attributes:
        tinted: Whether its radiance is a factor of the picture that its material emits.
    """

    tinted: bool = False


@dataclass(frozen=True, eq=False)
class RectLight(Light):
    """A rectangle in the local XY plane that emits along -Z.

    The picture's upper left corner lies at (+x, +y): upright for someone who faces the light.
    """

    width: float
    height: float
    texture: str | None


@dataclass(frozen=True, eq=False)
class DiskLight(Light):
    """A disk in the local XY plane that emits along -Z."""

    radius: float


@dataclass(frozen=True, eq=False)
class SphereLight(Light):
    """A sphere that emits outwards."""

    radius: float


@dataclass(frozen=True, eq=False)
class CylinderLight(Light):
    """A cylinder about the local X axis that emits outwards; its ends do not."""

    radius: float
    length: float


@dataclass(frozen=True, eq=False)
class DistantLight(Light):
    """A disk at infinity that shines along the local -Z.

    Attributes:
        angle: Its angular diameter, degrees.
        irradiance: (3,) lux of each primary on a surface that faces it.
    """

    angle: float
    irradiance: Array


@dataclass(frozen=True, eq=False)
class UnknownLight(Light):
    """A light of a kind that is not read; its losses say which."""


def nits_from_lumen(lumen: float, area: float) -> float:
    """Luminance of a surface that emits evenly and like Lambert: ``L = flux / (pi area)``.

    Args:
        lumen: Luminous flux.
        area: Emitting area, square metres, above 0.
    """
    return lumen / (math.pi * area)


def world_from_prim(prim: Usd.Prim) -> Array:
    """(4, 4) from a prim's frame to the world, Z up and metres, for columns."""
    local = frames.local_to_world(prim, UsdGeom.XformCache(Usd.TimeCode.EarliestTime()))
    return frames.world_from_stage(prim.GetStage()) @ local


def world_area(prim: Usd.Prim) -> float:
    """The area of a mesh or an intrinsic shape in the world, square metres.

    0 where it has no sound faces, and of curves and points.
    """
    mesh = _world_mesh(prim)
    return 0.0 if mesh is None else float(mesh.areas().sum())


def flux_share(prim: Usd.Prim, shaping: Shaping | None) -> float:
    """What the flux of a mesh is multiplied with by a shaping; 1 without one."""
    mesh = _world_mesh(prim)
    if shaping is None or mesh is None:
        return 1.0
    corners = mesh.points[mesh.indices[mesh.triangles()[0]]]
    crosses = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(crosses, axis=1)
    normals = crosses / np.where(doubled > 0.0, doubled, 1.0)[:, None]
    return shaping.mean_over(normals, 0.5 * doubled)


def _world_mesh(prim: Usd.Prim) -> Mesh | None:
    if not prim.IsA(UsdGeom.Mesh):
        shape = tessellate(prim)
        return None if shape is None else shape.transformed(world_from_prim(prim))
    mesh = UsdGeom.Mesh(prim)
    attributes = (
        mesh.GetPointsAttr(),
        mesh.GetFaceVertexCountsAttr(),
        mesh.GetFaceVertexIndicesAttr(),
    )
    values = [attribute.Get(Usd.TimeCode.EarliestTime()) for attribute in attributes]
    if not all(values):
        return None
    points, counts, indices = map(np.array, values)
    if counts.min() < 0 or counts.sum() != len(indices):
        return None
    if indices.min() < 0 or indices.max() >= len(points):
        return None
    local = Mesh(points.astype(np.float64), counts.astype(np.int32), indices.astype(np.int32))
    return local.transformed(world_from_prim(prim))
