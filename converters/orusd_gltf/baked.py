"""Lightmaps as pictures that need no light: what each surface shows of its colour under its light.

glTF's unlit materials have one picture. So base colour and irradiance are multiplied where the
lightmap has its places, at a finer step than its own.
"""

from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from pxr import Usd, UsdGeom

from openrooms_usd import names
from openrooms_usd.arrays import Array, Bytes, Floats
from openrooms_usd.colorimetry import luminance, srgb_from_linear
from openrooms_usd.errors import StageError
from openrooms_usd.rendering.bake.layer import ATLAS, IRRADIANCE, SCALE_OFFSET
from openrooms_usd.rendering.scene.pictures import evaluate
from openrooms_usd.rendering.scene.surfaces import Surface
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.shading.textures import read_texture
from openrooms_usd.usd.shapes.meshes import PlacedMesh
from orusd_gltf.document import Object, numbers
from orusd_gltf.geometry import Coordinates

# The coordinates of lightmaps.
LIGHTMAP: Final = Coordinates(names.BAKED_ST)

# Pixels to a side of a texel, and the longest side of a picture: textures stay sharp.
_MOST_PIXELS_A_TEXEL: Final = 8
_MOST_SIDE_PX: Final = 4096
# Places in a pixel: two, in opposite quarters.
_PLACES: Final = ((0.25, 0.75), (0.75, 0.25))
# Pixels that are looked at in one go.
_MOST_AT_ONCE: Final = 1 << 20
# What a picture is exposed to in the mean where no camera says: a little above middle grey.
_MEAN_GREY: Final = 0.22


@dataclass
class Atlas:
    """A lightmap and the picture that is made of it.

    Attributes:
        irradiance: (H, W, 3) lux of each primary, the first row at the bottom.
        scale: Pixels to a side of one of its texels.
    """

    irradiance: Floats
    scale: int
    color: Floats = field(init=False)
    weight: Floats = field(init=False)

    def __post_init__(self) -> None:
        height, width = (side * self.scale for side in self.irradiance.shape[:2])
        self.color = np.zeros((height, width, 3), np.float32)
        self.weight = np.zeros((height, width), np.float32)

    def paint(self, places: Array, st: Array, surface: Surface) -> None:
        """Add the base colour of triangles.

        Args:
            places: (M, 3, 2) of their corners in the atlas, 0 to 1.
            st: (M, 3, 2) the surface's texture coordinates there.
            surface: What they are made of.
        """
        height, width = self.weight.shape
        corners = places * (width, height)
        if not len(corners):
            return
        for place in _PLACES:
            found = [_inside(one - place, (width, height)) for one in corners]
            owners = np.repeat(np.arange(len(found)), [len(inner) for _, _, inner in found])
            x, y = (
                np.concatenate([np.zeros(0, int), *(f[axis] for f in found)]) for axis in (0, 1)
            )
            inner = np.concatenate([np.zeros((0, 3)), *(f[2] for f in found)])
            for first in range(0, len(owners), _MOST_AT_ONCE):
                now = slice(first, first + _MOST_AT_ONCE)
                where = np.einsum("nk,nkc->nc", inner[now], st[owners[now]])
                # Charts do not overlap: at their edges a pixel is a triangle's or its neighbour's.
                self.color[y[now], x[now]] += evaluate(surface.base_color, where, 3)
                self.weight[y[now], x[now]] += 1.0

    def radiance(self) -> Floats:
        """(h, w, 3) nits without gloss, the first row on top; beside charts as at their edge."""
        from scipy import ndimage

        known = self.weight > 0
        color = self.color / np.maximum(self.weight, 1.0)[..., None]
        if known.any() and not known.all():
            near = ndimage.distance_transform_edt(
                ~known, return_distances=False, return_indices=True
            )
            color = color[tuple(near)]
        light = self.irradiance
        for axis in (0, 1):
            light = _enlarged(light, self.scale, axis)
        return np.asarray(color * light / np.float32(np.pi), np.float32)[::-1]


def _inside(corners: Array, size: tuple[int, int]) -> tuple[Any, Any, Array]:
    """The whole places inside of a triangle: columns, rows, and (N, 3) barycentric coordinates."""
    low = np.maximum(np.ceil(corners.min(axis=0)).astype(int), 0)
    high = np.minimum(np.floor(corners.max(axis=0)).astype(int) + 1, size)
    (a, b), (c, d) = edges = corners[1:] - corners[0]
    area = a * d - b * c
    if (high <= low).any() or abs(area) < 1e-12:
        return np.zeros(0, int), np.zeros(0, int), np.zeros((0, 3))
    x, y = np.arange(low[0], high[0]), np.arange(low[1], high[1])[:, None]
    (from_x, from_y) = x - corners[0, 0], y - corners[0, 1]
    second = (from_x * edges[1, 1] - from_y * edges[1, 0]) / area
    third = (from_y * edges[0, 0] - from_x * edges[0, 1]) / area
    first = 1.0 - second - third
    rows, columns = np.nonzero((first >= 0.0) & (second >= 0.0) & (third >= 0.0))
    inner = np.stack([part[rows, columns] for part in (first, second, third)], axis=1)
    return columns + low[0], rows + low[1], inner


def _enlarged(pixels: Floats, scale: int, axis: int) -> Floats:
    """Pixels ``scale`` times as many along an axis, linear between their centres."""
    count = pixels.shape[axis]
    place = np.clip((np.arange(count * scale) + 0.5) / scale - 0.5, 0.0, count - 1.0)
    low = np.minimum(place.astype(int), max(count - 2, 0))
    share = (place - low).astype(np.float32).reshape(-1, *[1] * (pixels.ndim - 1 - axis))
    high = np.minimum(low + 1, count - 1)
    mixed = pixels.take(low, axis) * (1 - share) + pixels.take(high, axis) * share
    return np.asarray(mixed, dtype=np.float32)


class BakedLight:
    """The lightmaps of a stage.

    Args:
        stage: The stage.
        exposure: What nits are multiplied by; None for what shows the mean as middle grey.

    Raises:
        StageError: It has none.
    """

    def __init__(self, stage: Usd.Stage, exposure: float | None) -> None:
        self.atlases = {str(prim.GetPath()): _read_atlas(prim) for prim in list_atlases(stage)}
        self._exposure = exposure

    def places(self, mesh: PlacedMesh) -> tuple[str, Array] | None:
        """The atlas of a mesh and (M, 3, 2) where its triangles are in it; None without one."""
        found = place_of(mesh)
        if found is None or found[0] not in self.atlases:
            return None
        name, scale_offset = found
        return name, mesh.mesh.uvs[names.BAKED_ST] * scale_offset[:2] + scale_offset[2:]

    def pictures(self) -> dict[str, Bytes]:
        """(H, W, 3) codes of each atlas in sRGB, exposed, the first row on top."""
        radiance = {name: atlas.radiance() for name, atlas in self.atlases.items()}
        if self._exposure is None:
            lit = [values[values.sum(axis=2) > 0] for values in radiance.values()]
            mean = float(luminance(np.concatenate(lit).mean(axis=0))) if any(map(len, lit)) else 0.0
            self._exposure = _MEAN_GREY / mean if mean > 0.0 else 1.0
        return {name: self.shown(values) for name, values in radiance.items()}

    def shown(self, radiance: Floats) -> Bytes:
        """Nits as codes in sRGB."""
        exposed = np.clip(radiance * (self._exposure or 1.0), 0.0, 1.0)
        return np.round(srgb_from_linear(exposed) * 255.0).astype(np.uint8)

    @property
    def exposure(self) -> float:
        """What nits are multiplied by."""
        return self._exposure or 1.0


def list_atlases(stage: Usd.Stage) -> list[Usd.Prim]:
    """The lightmaps of a stage.

    Raises:
        StageError: It has none.
    """
    found = [x for x in stage.Traverse() if x.GetAttribute(IRRADIANCE).HasAuthoredValue()]
    if not found:
        raise StageError(
            "the stage has no lightmaps",
            place=stage.GetRootLayer().realPath,
            remedy="bake them (orusd bake SCENE -o LIT), and convert LIT/baked.usda",
        )
    return found


def place_of(mesh: PlacedMesh) -> tuple[str, Array] | None:
    """The path of a mesh's atlas, and (4,) scale and offset of its ``st1`` there; or None."""
    found = UsdGeom.PrimvarsAPI(mesh.prim).FindPrimvarWithInheritance(SCALE_OFFSET)
    name = _atlas_of(mesh.prim)
    if names.BAKED_ST not in mesh.mesh.uvs or not found or not name:
        return None
    return name, np.array(found.Get(TIME), dtype=np.float64)


def area_of(atlas: str, scale_offset: Array) -> Object:
    """What a node says of its place in a lightmap.

    ``area`` is (scale u, scale v, offset u, offset v) of the primitives' coordinates, in glTF's
    way: v grows downwards from the upper edge of the picture.
    """
    scale_s, scale_t, offset_s, offset_t = scale_offset.tolist()
    return {"atlas": atlas, "area": numbers([scale_s, scale_t, offset_s, 1 - scale_t - offset_t])}


def _read_atlas(prim: Usd.Prim) -> Atlas:
    asset = prim.GetAttribute(IRRADIANCE).Get(TIME)
    pixels = read_texture(str(asset.resolvedPath or asset.path))[..., :3]
    longest = max(pixels.shape[:2])
    scale = max(1, min(_MOST_PIXELS_A_TEXEL, _MOST_SIDE_PX // longest))
    return Atlas(np.nan_to_num(pixels[::-1]).astype(np.float32), scale)


def _atlas_of(prim: Usd.Prim) -> str:
    """The atlas that a prim, or what it is below, is in."""
    while prim and not prim.IsPseudoRoot():
        targets = prim.GetRelationship(ATLAS).GetTargets()
        if targets:
            return str(targets[0])
        prim = prim.GetParent()
    return ""
