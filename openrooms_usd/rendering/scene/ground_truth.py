"""Geometry, material and label channels of what the pixels' centres see."""

from collections.abc import Callable
from dataclasses import astuple, fields
from functools import cached_property
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Floats, Mask
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.rendering.scene.arrays import Patch, PixelLabels, Scene
from openrooms_usd.rendering.scene.first_hits import Hits
from openrooms_usd.rendering.scene.pictures import Value, evaluate
from openrooms_usd.rendering.scene.surfaces import Surface
from openrooms_usd.rendering.scene.triangles import Triangles
from openrooms_usd.usd.cameras import PinholeCamera

# OpenCV axes (right, down, forward) in OpenGL's (right, up, backward).
_OPENGL: Final = np.diag([1.0, -1.0, -1.0])
# The label channels, in the order of a piece's numbers.
_LABELS: Final = tuple(label.name for label in fields(PixelLabels))

# The sine between a normal and the view below which it names no side.
_NO_SIDE: Final = 1e-6


class GroundTruth:
    """The channels that one ray through each pixel's centre gives; each made when asked for.

    Args:
        scene: What is seen.
        camera: What sees it.
        hits: What its pixels' centres meet.
    """

    def __init__(self, scene: Scene, camera: PinholeCamera, hits: Hits) -> None:
        self._scene = scene
        self._camera = camera
        self._hits = hits

    def channel(self, name: str) -> Floats:
        """(height, width, components) of a channel of kind geometry, material or label."""
        if name in _LABELS:
            return self._hits.image(self._labels[:, _LABELS.index(name)])
        return self._hits.image(_CHANNELS[name](self))

    def _depth(self) -> Array:
        return self._hits.depth

    def _distance(self) -> Array:
        return np.asarray(self._hits.depth * np.linalg.norm(self._hits.directions, axis=1))

    def _position(self) -> Array:
        return self._hits.position

    def _valid(self) -> Array:
        return np.ones(len(self._hits.rows))

    def _normal_geometric(self) -> Array:
        return np.where(self._hits.front[:, None], self._hits.geometric, -self._hits.geometric)

    def _normal(self) -> Array:
        return self._shading

    def _normal_camera(self) -> Array:
        return self._shading @ self._camera.world_from_camera[:3, :3] @ _OPENGL

    def _base_color(self) -> Array:
        return self._by_surface(lambda surface: surface.base_color, 3)

    def _roughness(self) -> Array:
        return self._by_surface(lambda surface: surface.roughness, 1)

    def _metallic(self) -> Array:
        return self._by_surface(lambda surface: surface.metallic, 1)

    def _emission_mask(self) -> Array:
        radiance = self._by_patch(lambda patch: patch.radiance or 0.0, 3)
        return np.where(self._hits.front & (radiance.max(axis=1) > 0), 1.0, 0.0)

    @cached_property
    def _hit_triangles(self) -> Triangles:
        """The triangle of each hit."""
        return self._scene.triangles.rows(self._hits.rows)

    @cached_property
    def _labels(self) -> Array:
        pieces = [astuple(piece) for piece in self._scene.pieces]
        table = np.array(pieces, dtype=np.float64).reshape(-1, len(_LABELS))
        return table[self._hit_triangles.pieces]

    @cached_property
    def _shading(self) -> Array:
        """(R, 3) unit normals with the normal map, on the camera's side."""
        hits = self._hits
        corners = self._hit_triangles.normals.astype(np.float64)
        smooth = unit(np.einsum("ri,rij->rj", hits.weights, corners))
        outward = np.where(hits.front, 1.0, -1.0)[:, None]
        normals = outward * smooth
        for number in np.unique(hits.patches):
            picture = self._scene.patches[number].surface.normal
            if picture is not None:
                here = hits.patches == number
                relief = picture.lookup(hits.st[here])
                # Behind a surface its relief is the mirror image: only the height turns round.
                relief[:, 2:] *= outward[here]
                normals[here] = np.einsum("ri,rij->rj", relief, self._tangents(here, smooth[here]))
        return _facing(unit(normals), unit(hits.directions), self._normal_geometric())

    def _tangents(self, here: Mask, normals: Array) -> Array:
        """(R, 3, 3) rows: along u, across it, the normal; what normal maps are in."""
        met = self._hit_triangles.rows(here)
        a, b, c = np.moveaxis(met.corners, 1, 0)
        at, bt, ct = np.moveaxis(met.st.astype(np.float64), 1, 0)
        (u1, v1), (u2, v2) = (bt - at).T, (ct - at).T
        along = v2[:, None] * (b - a) - v1[:, None] * (c - a)
        along *= np.sign(u1 * v2 - v1 * u2)[:, None]
        along -= normals * np.einsum("ij,ij->i", normals, along)[:, None]
        along = unit(along)
        return np.stack([along, np.cross(normals, along), normals], axis=1)

    def _by_surface(self, value: Callable[[Surface], Value], channels: int) -> Array:
        return self._by_patch(lambda patch: value(patch.surface), channels)

    def _by_patch(self, value: Callable[[Patch], Value], channels: int) -> Array:
        hits = self._hits
        values = np.zeros((len(hits.rows), channels))
        for number in np.unique(hits.patches):
            here = hits.patches == number
            values[here] = evaluate(value(self._scene.patches[number]), hits.st[here], channels)
        return values


_CHANNELS: Final[dict[str, Callable[[GroundTruth], Array]]] = {
    "depth": GroundTruth._depth,
    "distance": GroundTruth._distance,
    "position": GroundTruth._position,
    "normal": GroundTruth._normal,
    "normal_geometric": GroundTruth._normal_geometric,
    "normal_camera": GroundTruth._normal_camera,
    "base_color": GroundTruth._base_color,
    "roughness": GroundTruth._roughness,
    "metallic": GroundTruth._metallic,
    "emission_mask": GroundTruth._emission_mask,
    "valid": GroundTruth._valid,
}


def _facing(normals: Array, directions: Array, flat: Array) -> Array:
    """Normals bent to the horizon where interpolation or relief turns them away from the camera.

    The surface's own, ``flat``, where they look straight away and say no side to bend to.
    """
    away = np.einsum("ij,ij->i", normals, directions)[:, None]
    bent = normals - np.maximum(away, 0.0) * directions
    straight = np.linalg.norm(bent, axis=1, keepdims=True) < _NO_SIDE
    return np.where(straight, flat, np.where(away > 0, unit(bent), normals))
