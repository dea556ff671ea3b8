"""Lights as KHR_lights_punctual: points, spots and suns, in candela and lux.

A lamp of some size becomes a point without size that is as bright from afar.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd.arrays import Array
from openrooms_usd.errors import StageError
from openrooms_usd.geometry.rotations import pose
from openrooms_usd.usd.cameras import FLIP, ORTHOGRAPHIC, PinholeCamera, list_cameras, read_camera
from openrooms_usd.usd.light.lightreader import ellipse_perimeter, ellipsoid_area
from openrooms_usd.usd.light.lights import (
    CylinderLight,
    DiskLight,
    DistantLight,
    DomeLight,
    Light,
    RectLight,
    SphereLight,
)
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.rendersettings import stage_resolution
from openrooms_usd.usd.shapes.meshes import PlacedMesh
from orusd_gltf.document import Document, Object, number, numbers

# Pixels by which an optical axis may miss the centre before it is reported.
_CENTRED_PX: Final = 1e-3
# What is nearer is not seen, where the stage says nothing that can be.
_NEAREST_M: Final = 0.01
# By parallel rays something has to be.
_FARTHEST_M: Final = 1000.0


def authored_stops(stage: Usd.Stage) -> float | None:
    """The exposure of the first camera that has one, stops."""
    for prim in list_cameras(stage):
        stops = UsdGeom.Camera(prim).GetExposureAttr()
        if stops.HasAuthoredValue() and math.isfinite(stops.Get(TIME)):
            return float(stops.Get(TIME))
    return None


def add_camera(document: Document, prim: Usd.Prim) -> tuple[int, Array, Object, str] | str:
    """Add a camera of a stage.

    Returns:
        Its number, (4, 4) its place in the world, what else is known of it (``exposure`` in stops,
        where it is authored), and what was lost in words; or why there is none.
    """
    width, height = stage_resolution(prim.GetStage())
    try:
        camera = read_camera(prim, width, height)
    except StageError as error:
        return error.message
    K = camera.K
    found = document.add("cameras", {"name": prim.GetName(), **_projection(camera, width, height)})
    off = np.abs(K[:2, 2] - [width / 2.0, height / 2.0]).max()
    lost = "its picture is off the optical axis; glTF centres it" if off > _CENTRED_PX else ""
    stops = UsdGeom.Camera(prim).GetExposureAttr()
    said = stops.Get(TIME) if stops.HasAuthoredValue() else math.nan
    known: Object = {"exposure": number(said)} if math.isfinite(said) else {}
    return found, camera.world_from_camera @ FLIP, known, lost


def _projection(camera: PinholeCamera, width: int, height: int) -> Object:
    (across, down), (near, far) = camera.K[[0, 1], [0, 1]], camera.clipping
    if camera.projection == ORTHOGRAPHIC:
        nearest = max(near, 0.0)
        seen = {
            "xmag": number(width / (2.0 * across)),
            "ymag": number(height / (2.0 * down)),
            "znear": number(nearest),
            "zfar": number(far if nearest < far < math.inf else _FARTHEST_M),
        }
        return {"type": "orthographic", "orthographic": seen}
    perspective = {
        "aspectRatio": number(width / height * down / across),
        "yfov": number(2.0 * math.atan(height / (2.0 * down))),
        "znear": number(near if 0.0 < near < math.inf else _NEAREST_M),
    }
    if perspective["znear"] < far < math.inf:
        # Without it nothing is too far.
        perspective["zfar"] = number(far)
    return {"type": "perspective", "perspective": perspective}


EXTENSION: Final = "KHR_lights_punctual"
# Candela or lux: all that single precision holds.
_BRIGHTEST: Final = 3e38
# Part of a mesh's area that faces one way where the mesh counts as a panel.
_PANEL_SHARE: Final = 0.98
# Of its frame: smaller ones have no direction.
_LEAST_VOLUME: Final = 1e-18
_HALF_TURN: Final = math.pi / 2

_NO_SIZE: Final = "its light comes from a point; its own shape is not seen"
_FROM_A_POINT: Final = "what it gives to the room comes from a point"
_COSINE: Final = "its light falls off towards the side as the viewer's spots do"
_SHARP: Final = "its angle is left out: shadows are sharp"
_SKY: Final = "glTF has no surroundings that give light"


@dataclass(frozen=True, eq=False)
class Lamp:
    """A light of the document.

    Attributes:
        number: Its number there.
        world: (4, 4) where it stands, in the world; it shines along -Z.
        losses: What could not be kept, in words.
    """

    number: int
    world: Array
    losses: tuple[str, ...] = ()


def add_light(document: Document, light: Light, name: str, brighter: float = 1.0) -> Lamp | str:
    """Add a light of a stage.

    Args:
        document: Receives it.
        light: The light.
        name: Its name there.
        brighter: What its candela or lux are multiplied by.

    Returns:
        The lamp, or why there is none.
    """
    M = light.world_from_light
    if isinstance(light, DomeLight):
        return _SKY
    if not abs(np.linalg.det(M[:3, :3])) >= _LEAST_VOLUME or not np.isfinite(M).all():
        return "its transform is singular"
    world = pose(_turned(M[:3, :3]), M[:3, 3])
    x, y, z = np.linalg.norm(M[:3, :3], axis=0).tolist()
    if isinstance(light, DistantLight):
        lost: tuple[str, ...] = (_SHARP,) if light.angle > 0 else ()
        return _added(document, name, "directional", light.irradiance * brighter, world, lost)
    if isinstance(light, RectLight | DiskLight):
        area = (
            light.width * light.height
            if isinstance(light, RectLight)
            else math.pi * (light.radius**2)
        )
        flat = float(np.linalg.norm(np.cross(M[:3, 0], M[:3, 1])))
        textured = isinstance(light, RectLight) and light.texture is not None
        lost = (_NO_SIZE, _COSINE, *(["its picture is left out"] if textured else []))
        return _added(document, name, "spot", light.radiance * area * flat * brighter, world, lost)
    if isinstance(light, SphereLight):
        area = ellipsoid_area(*(light.radius * np.array([x, y, z])))
    elif isinstance(light, CylinderLight):
        area = light.length * x * ellipse_perimeter(light.radius * y, light.radius * z)
    else:
        return "; ".join(light.losses)
    # What shines outwards from a convex surface shows a quarter of its area in the mean.
    return _added(
        document, name, "point", light.radiance * area / 4.0 * brighter, world, (_NO_SIZE,)
    )


def add_glow(document: Document, mesh: PlacedMesh, radiance: Array, name: str) -> Lamp:
    """Add what a mesh that emits gives to the room; a panel is a spot, all else a point."""
    corners = mesh.world_points()[mesh.mesh.triangles]
    a, b, c = np.moveaxis(corners, 1, 0)
    areas = np.cross(b - a, c - a) / 2.0 * (-1.0 if mesh.mirrored else 1.0)
    sizes = np.linalg.norm(areas, axis=1)
    area, facing = float(sizes.sum()), areas.sum(axis=0)
    centre = (corners.mean(axis=1) * sizes[:, None]).sum(axis=0) / area
    if np.linalg.norm(facing) < _PANEL_SHARE * area:
        world = pose(np.eye(3), centre)
        return _added(document, name, "point", radiance * area / 4.0, world, (_FROM_A_POINT,))
    world = pose(_looking(facing / np.linalg.norm(facing)), centre)
    return _added(document, name, "spot", radiance * area, world, (_FROM_A_POINT, _COSINE))


def _added(
    document: Document, name: str, kind: str, values: Array, world: Array, losses: tuple[str, ...]
) -> Lamp:
    """Candela or lux of each primary, as a colour of at most one and a factor."""
    values = np.clip(np.nan_to_num(values), 0.0, _BRIGHTEST)
    most = float(values.max())
    light: Object = {"name": name, "type": kind, "intensity": number(most)}
    if most > 0.0 and values.min() < most:
        light["color"] = numbers(values / most)
    if kind == "spot":
        light["spot"] = {"innerConeAngle": 0.0, "outerConeAngle": number(_HALF_TURN)}
    document.use(EXTENSION)
    return Lamp(document.add("lights", light), world, losses)


def _turned(linear: Array) -> Array:
    """The rotation whose -Z is where a light shines, without scales and mirrors."""
    return _looking(-linear[:, 2] / np.linalg.norm(linear[:, 2]))


def _looking(direction: Array) -> Array:
    """(3, 3) a rotation that takes -Z to a unit vector."""
    z = -direction
    side = np.eye(3)[int(np.abs(z).argmin())]
    x = np.cross(side, z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)
