"""Portal lights: openings through which a dome light is sampled."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pxr import Usd, UsdGeom, UsdLux

from openrooms_usd.usd.arrays import number_of
from openrooms_usd.usd.frames import TIME, local_to_world, world_from_stage
from openrooms_usd.usd.transforms import author_matrix


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
    world_from_portal: NDArray[np.float64]
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
