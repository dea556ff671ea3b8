"""Lights of a stage: shapes that emit, the surroundings, parallel light."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.vectors import unit
from openrooms_usd.rendering.scene.arrays import Environment, Sun
from openrooms_usd.rendering.scene.pictures import Picture, Value, load, within
from openrooms_usd.rendering.scene.surfaces import Surface
from openrooms_usd.rendering.scene.triangles import Triangles
from openrooms_usd.usd.light.lights import (
    CylinderLight,
    DiskLight,
    DistantLight,
    DomeLight,
    MeshLight,
    RectLight,
    SphereLight,
)
from openrooms_usd.usd.shading.surfaces import Texture
from openrooms_usd.usd.shading.textures import color_space, read_texture, report_line
from openrooms_usd.usd.shapes.meshes import FARTHEST_M

# Facets around a round light: even, so that its outline is symmetric.
_FACETS_AROUND: Final = 48
_FACETS_UP: Final = 24
# Of the determinant relative to the lengths of the axes, and square metres.
_SINGULAR: Final = 1e-9
_NO_AREA: Final = 1e-25
# Rows from which half a row is less than a tenth of a degree.
_ROWS_FINE_ENOUGH: Final = 1024


def sun(light: DistantLight) -> Sun:
    """Parallel light."""
    axis, angle = -light.world_from_light[:3, 2], min(max(light.angle, 0.0), 360.0)
    return Sun(axis / np.linalg.norm(axis), light.irradiance, angle, light.path)


def environment(light: DomeLight) -> tuple[Environment, tuple[str, ...]]:
    """The surroundings, and what was lost."""
    rotation = light.world_from_light[:3, :3]
    pixels, losses = _sky(light.texture)
    if 1 < len(pixels) < _ROWS_FINE_ENOUGH:
        pixels = _pole_to_pole(pixels)
    return Environment((pixels * light.radiance).astype(np.float32), rotation), losses


def _sky(file: str | None) -> tuple[Floats, tuple[str, ...]]:
    """(H, W, 3) linear pixels, one of them where there is no picture, and what was lost."""
    constant = np.ones((1, 1, 3), dtype=np.float32)
    if file is None:
        return constant, ()
    try:
        return _read_sky(file)
    except InputError as error:
        return constant, (report_line(error), "it is treated as constant")


def _pole_to_pole(pixels: Floats) -> Floats:
    """(2 H + 1, W, 3) the same sky with its first and last row at the poles.

    That is how a `Scene` has it, where everybody else has the rows' edges: between rows at the
    poles a renderer can interpolate everywhere, as Mitsuba's ``envmap`` does. Rows
    between the old ones make linear interpolation give what it gave before.
    """
    height = len(pixels)
    rows = np.empty((2 * height + 1, *pixels.shape[1:]), dtype=np.float32)
    rows[1::2] = pixels
    rows[2:-1:2] = (pixels[:-1] + pixels[1:]) / 2
    rows[0], rows[-1] = pixels[0].mean(axis=0), pixels[-1].mean(axis=0)
    return rows


def _read_sky(file: str) -> tuple[Floats, tuple[str, ...]]:
    stored = within(read_texture(file))
    rgb = stored[..., :3] if stored.shape[2] >= 3 else np.repeat(stored[..., :1], 3, axis=2)
    if color_space(file) == "sRGB":
        rgb = linear_from_srgb(rgb)
    wrong = ~np.isfinite(rgb) | (rgb < 0)
    if not wrong.any():
        return rgb, ()
    count = int(wrong.any(axis=2).sum())
    return np.where(wrong, np.float32(0), rgb), (
        f"{file}: {count} negative or infinite pixels replaced by 0",
    )


Shaped = RectLight | DiskLight | SphereLight | CylinderLight


def nothing(light: Shaped) -> str:
    """Why a light has no emitting surface; empty if it has one."""
    M = light.world_from_light[:3, :3]
    if not np.isfinite(M).all() or abs(np.linalg.det(M)) <= _SINGULAR * np.prod(
        np.linalg.norm(M, axis=0)
    ):
        return "its transform is singular"
    found = shape(light, 0)
    if not (np.abs(found.corners) < FARTHEST_M).all():
        return "its coordinates exceed the range of renderers"
    return "" if is_extended(found) else "it has no size"


def is_extended(triangles: Triangles) -> bool:
    """Whether triangles have any area, in the precision of renderers, which cannot emit without."""
    a, b, c = np.moveaxis(triangles.corners.astype(np.float32), 1, 0)
    with np.errstate(over="ignore", invalid="ignore"):
        return bool((np.linalg.norm(np.cross(b - a, c - a), axis=1) > _NO_AREA).any())


def shape(light: Shaped, piece: int) -> Triangles:
    """The emitting surface of a light in the world.

    Round lights are made of facets, and widened so that their area is that of the true shape.
    """
    points, rows, normals, st = _MAKERS[type(light)](light)
    M = light.world_from_light
    corners = (points @ M[:3, :3].T + M[:3, 3])[rows]
    turned = unit(normals[rows] @ np.linalg.inv(M[:3, :3]))
    found = Triangles(
        corners,
        turned.astype(np.float32),
        st[rows].astype(np.float32),
        np.full(len(rows), piece, dtype=np.int32),
    )
    return flipped(found) if np.linalg.det(M[:3, :3]) < 0 else found


def flipped(triangles: Triangles) -> Triangles:
    """The triangles with the other winding; their normals are kept."""
    return replace(
        triangles,
        corners=triangles.corners[:, ::-1],
        normals=triangles.normals[:, ::-1],
        st=triangles.st[:, ::-1],
    )


def radiance(light: Shaped) -> tuple[Value, tuple[str, ...]]:
    """What a light's surface emits, nits, and what was lost."""
    red, green, blue = map(float, light.radiance)
    if not isinstance(light, RectLight) or light.texture is None:
        return (red, green, blue), ()
    try:
        space = color_space(light.texture)
    except InputError as error:
        return (red, green, blue), (report_line(error), "its texture is replaced by white")
    texture = Texture(
        light.texture,
        color_space=space,
        scale=(red, green, blue, 1.0),
        wrap_s="clamp",
        wrap_t="clamp",
    )
    picture: Picture = load(texture, 3, (0.0, np.inf), np.eye(3))
    return picture, picture.losses


def emission(surface: Surface, light: MeshLight | None) -> Value | None:
    """What a mesh emits: by its light where it is one, by its material where not."""
    if light is None:
        return surface.emission
    red, green, blue = map(float, light.radiance)
    if not light.tinted or not isinstance(surface.emission, Picture):
        return red, green, blue
    glow = surface.emission
    return Picture((glow.pixels * light.radiance).astype(np.float32), glow.wrap, glow.uv)


Parts = tuple[Array, Any, Array, Array]  # points, triangles, normals, st


def _rect(light: RectLight) -> Parts:
    square = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]], dtype=np.float64)
    points = np.column_stack([square / 2 * [light.width, light.height], np.zeros(4)])
    st = np.array([[0, 1], [0, 0], [1, 0], [1, 1]], dtype=np.float64)
    return points, np.array([[0, 1, 2], [0, 2, 3]]), _below(4), st


def _disk(light: DiskLight) -> Parts:
    ring = _circle() * light.radius * _widening()
    points = np.concatenate([np.zeros((1, 3)), np.column_stack([ring, np.zeros(_FACETS_AROUND)])])
    near = np.arange(_FACETS_AROUND)
    far = (near + 1) % _FACETS_AROUND
    rows = np.column_stack([np.zeros_like(near), far + 1, near + 1])
    return points, rows, _below(len(points)), np.zeros((len(points), 2))


def _sphere(light: SphereLight) -> Parts:
    polar = np.linspace(0, np.pi, _FACETS_UP + 1)
    ring = _circle()
    unit = np.stack(
        [np.column_stack([ring * np.sin(t), np.full(_FACETS_AROUND, np.cos(t))]) for t in polar]
    )
    rows = _grid(_FACETS_UP + 1, _FACETS_AROUND)
    points = unit.reshape(-1, 3)
    rows = rows[_areas(points, rows) > 1e-9]
    widened = points * light.radius * np.sqrt(4 * np.pi / _areas(points, rows).sum())
    return widened, rows, points, np.zeros((len(points), 2))


def _cylinder(light: CylinderLight) -> Parts:
    ring = _circle()
    # Perimeter, not area, of the polygon is that of the circle: the side is what emits.
    radius = light.radius * np.pi / (_FACETS_AROUND * np.sin(np.pi / _FACETS_AROUND))
    ends = [
        np.column_stack([np.full(_FACETS_AROUND, x * light.length / 2), ring * radius])
        for x in (1, -1)
    ]
    normals = np.column_stack([np.zeros(_FACETS_AROUND), ring])
    rows = _grid(2, _FACETS_AROUND)
    return np.concatenate(ends), rows, np.tile(normals, (2, 1)), np.zeros((2 * _FACETS_AROUND, 2))


_MAKERS: Final[dict[type, Callable[[Any], Parts]]] = {
    RectLight: _rect,
    DiskLight: _disk,
    SphereLight: _sphere,
    CylinderLight: _cylinder,
}


def _circle() -> Array:
    angles = 2 * np.pi * np.arange(_FACETS_AROUND) / _FACETS_AROUND
    return np.column_stack([np.cos(angles), np.sin(angles)])


def _widening() -> float:
    """What a polygon's radius grows by to have the area of its circle."""
    return float(np.sqrt(2 * np.pi / (_FACETS_AROUND * np.sin(2 * np.pi / _FACETS_AROUND))))


def _below(count: int) -> Array:
    return np.tile([0.0, 0.0, -1.0], (count, 1))


def _grid(rings: int, around: int) -> Any:
    """Triangles between rings of points, seen from outside where the rings go down."""
    upper = (np.arange(rings - 1)[:, None] * around + np.arange(around)).ravel()
    after = (np.arange(rings - 1)[:, None] * around + (np.arange(around) + 1) % around).ravel()
    lower, beyond = upper + around, after + around
    return np.concatenate(
        [np.column_stack([upper, lower, beyond]), np.column_stack([upper, beyond, after])]
    )


def _areas(points: Array, rows: Any) -> Array:
    a, b, c = np.moveaxis(points[rows], 1, 0)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)
