"""The studio: exhibits in a row on a neutral ground or wall, softboxes around, a camera for each.

Assets and looks come from the ordinary stages. Small things stand near the origin, so that single
precision serves all of them.
"""

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

from openrooms_usd import names
from openrooms_usd.arrays import Array, Floats
from openrooms_usd.composing import compose_room
from openrooms_usd.geometry.rotations import pose
from openrooms_usd.geometry.solids import box
from openrooms_usd.library.pictures import write_exr
from openrooms_usd.library.surroundings.environments import directions
from openrooms_usd.showroom.exhibits import Exhibit
from openrooms_usd.usd.cameras import define_camera
from openrooms_usd.usd.files.layers import apply_metadata
from openrooms_usd.usd.light.lights import define_dome, define_mesh_light
from openrooms_usd.usd.places.frames import author_placement
from openrooms_usd.usd.semantics import read_label
from openrooms_usd.usd.shading.materials import PreviewSurface, define_preview_surface
from openrooms_usd.usd.shapes.meshes import define_mesh

# What previews multiply luminance by: a white sheet in the studio comes out a little below white.
EXPOSURE: Final = 1.0 / 850.0
_BACKDROP: Final = (0.3, 0.3, 0.296)
_BULB_NITS, _BULB_KELVIN = 5200.0, 3000.0
_AZIMUTH_DEG: Final = 32.0
# Flat things are seen more from above, degrees.
_ELEVATIONS_DEG: Final = (16.0, 42.0)
_FOV_DEG: Final = 24.0
# Between the two rows and the origin, metres, so that neither is seen behind the other.
_ROW_GAP_M: Final = 1.0
# Free room beside an exhibit, in parts of its size.
_GAP_SHARE: Final = 1.1
_STEPS: Final = ("layout", "alignment", "materials")


@dataclass(frozen=True)
class _Spot:
    """Where an exhibit stands: the middle of its base, metres."""

    x: float
    z: float
    exhibit: Exhibit


def build(exhibits: Sequence[Exhibit], seed: int, folder: Path) -> Usd.Stage:
    """Compose the exhibits and arrange them.

    Args:
        exhibits: What is shown; each gets the camera `camera_of`.
        seed: Draws details and looks.
        folder: An empty folder for everything that the stage refers to.

    Raises:
        OutputError: The folder cannot be written.
    """
    description = folder / "room.yaml"
    description.write_text(json.dumps(_description(exhibits, seed)), encoding="utf-8")
    for step in _STEPS:
        compose_room(description, folder / "composed", only=step)
    layer = Sdf.Layer.CreateNew(str(folder / "studio.usda"))
    apply_metadata(layer)
    layer.subLayerPaths = ["./composed/scene.usda"]
    stage = Usd.Stage.Open(layer)
    stage.OverridePrim(names.ROOM).SetActive(False)
    spots = list(_arranged(exhibits))
    for spot in spots:
        _place(stage, spot)
    _define_backdrop(stage, spots)
    write_exr(folder / "softboxes.exr", softboxes())
    define_dome(stage, names.ENVIRONMENT, texture="./softboxes.exr")
    return stage


def camera_of(exhibit: Exhibit) -> str:
    """The prim path of an exhibit's camera."""
    return f"{names.CAMERAS}/{exhibit.name}"


def triangles_of(stage: Usd.Stage, exhibit: Exhibit) -> int:
    """How many triangles an exhibit has."""
    root = stage.GetPrimAtPath(f"{names.FURNITURE}/{exhibit.name}")
    counts = (
        np.asarray(UsdGeom.Mesh(prim).GetFaceVertexCountsAttr().Get())
        for prim in Usd.PrimRange(root, Usd.TraverseInstanceProxies())
        if prim.IsA(UsdGeom.Mesh)
    )
    return int(sum((count - 2).sum() for count in counts))


def _description(exhibits: Sequence[Exhibit], seed: int) -> dict[str, object]:
    objects = [
        {
            "name": item.name,
            "category": item.category,
            "style": item.style,
            "size": item.size,
            "at": [0, 0, 0],
            "on": "floor",
        }
        for item in exhibits
    ]
    return {"seed": seed, "furniture": {"objects": objects}, "materials": {"resolution": 256}}


def _arranged(exhibits: Sequence[Exhibit]) -> Iterator[_Spot]:
    """Those for the floor to the right of the origin, those for the wall to the left."""
    for side in (1.0, -1.0):
        x = _ROW_GAP_M
        there = (item for item in exhibits if (item.support == "wall") == (side < 0.0))
        for item in sorted(there, key=lambda item: (max(item.size), item.name)):
            room = _GAP_SHARE * max(item.size)
            x += room + 0.5 * item.size[0]
            yield _Spot(side * x, _level(item), item)
            x += room + 0.5 * item.size[0]


def _level(item: Exhibit) -> float:
    if item.support == "ceiling":
        return 0.35 * item.size[2]
    return item.level if item.support == "wall" else 0.0


def _place(stage: Usd.Stage, spot: _Spot) -> None:
    """Put an exhibit on its spot, light its bulbs, and point a camera at it."""
    item = spot.exhibit
    root = stage.OverridePrim(f"{names.FURNITURE}/{item.name}")
    back = -0.5 * item.size[1] if item.support == "wall" else 0.0
    author_placement(root, Gf.Vec3d(spot.x, back, spot.z), 0.0)
    for prim in Usd.PrimRange(root):
        if read_label(prim, names.PART) == names.LIGHT_BULB:
            define_mesh_light(prim, nits=_BULB_NITS, kelvin=_BULB_KELVIN)
    middle = np.array([spot.x, back, spot.z + 0.5 * item.size[2]])
    define_camera(
        stage,
        camera_of(item),
        world_from_camera=_looking_at(middle, item),
        fov_degrees=_FOV_DEG,
        resolution=(1, 1),
        exposure=EXPOSURE,
    )


def _looking_at(middle: Array, item: Exhibit) -> Array:
    """A pose from the right of the front and above from which a box just fills the picture."""
    size = item.size
    flat = 0.0 if item.support == "ceiling" else max(0.0, 1.0 - size[2] / min(size[:2]))
    degrees = _ELEVATIONS_DEG[0] + (_ELEVATIONS_DEG[1] - _ELEVATIONS_DEG[0]) * flat
    azimuth, elevation = math.radians(_AZIMUTH_DEG), math.radians(degrees)
    forward = np.array(
        [
            -math.sin(azimuth) * math.cos(elevation),
            math.cos(azimuth) * math.cos(elevation),
            -math.sin(elevation),
        ]
    )
    right = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
    rotation = np.stack([right, np.cross(forward, right), forward], axis=1)
    signs = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3), axis=-1).reshape(-1, 3)
    seen = (signs * size) @ rotation
    # Each corner bounds the distance: |right or down| <= slope (distance + forward).
    slope = 0.9 * math.tan(math.radians(0.5 * _FOV_DEG))
    distance = float((np.abs(seen[:, :2]).max(axis=1) / slope - seen[:, 2]).max())
    return pose(rotation, middle - distance * forward)


def _define_backdrop(stage: Usd.Stage, spots: Sequence[_Spot]) -> None:
    """The ground, and the wall behind what hangs."""
    grey = PreviewSurface(base_color=_BACKDROP, roughness=0.7)
    scope = UsdGeom.Scope.Define(stage, f"{names.WORLD}/Backdrop").GetPath()
    material = define_preview_surface(stage, scope.AppendChild("grey"), grey)
    reach = 60.0 + max((abs(spot.x) for spot in spots), default=0.0)
    boards = {"ground": box((2.0 * reach, 2.0 * reach, 0.1), (0.0, 0.0, -0.05))}
    hung = [spot.x for spot in spots if spot.x < 0.0]
    if hung:
        width = 40.0 - min(hung)
        boards["wall"] = box((width, 0.1, 12.0), (-0.5 * width, 0.05, 6.0))
    for name, mesh in boards.items():
        prim = define_mesh(stage, scope.AppendChild(name), mesh).GetPrim()
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material)


def softboxes() -> Floats:
    """(128, 256, 3) nits: a grey tent, a large key light at the right and a strip at the left."""
    way = directions(128)
    tent = 150.0 + 250.0 * np.clip(way[..., 2], 0.0, 1.0)
    tent = tent + _softbox(way, 62.0, 48.0, (24.0, 20.0), 9000.0)
    tent = tent + _softbox(way, -70.0, 28.0, (9.0, 26.0), 2600.0)
    return np.repeat(tent[..., None], 3, axis=-1).astype(np.float32)


def _softbox(
    way: Array, azimuth: float, elevation: float, half: tuple[float, float], nits: float
) -> Array:
    """A rectangle of light with soft edges; degrees, the azimuth to the right of the front."""
    east = np.degrees(np.arctan2(way[..., 0], -way[..., 1])) - azimuth
    up = np.degrees(np.arcsin(way[..., 2])) - elevation
    inside = np.ones(way.shape[:2])
    for offset, extent in ((east, half[0]), (up, half[1])):
        inside *= np.clip((extent - np.abs(offset)) / 6.0 + 0.5, 0.0, 1.0)
    return np.asarray(nits * inside)
