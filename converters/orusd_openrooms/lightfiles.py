"""The files of the lights in a view: which channels each is made of, and how."""

from collections.abc import Callable
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from openrooms_usd import atomic
from openrooms_usd.arrays import Array, Floats, Mask
from openrooms_usd.colorimetry import LUMINANCE
from openrooms_usd.errors import writing
from openrooms_usd.geometry.raycast import RayCaster
from openrooms_usd.rendering.reading import RenderedView
from orusd_openrooms import images, lights
from orusd_openrooms.frame import Frame, Pixels
from orusd_openrooms.images import write_rgbe
from orusd_openrooms.layout import Place
from orusd_openrooms.lights import Light, Lobe, spread
from orusd_openrooms.pickles import write_pickled

# Sharper lobes are integrated over their own directions, others over the rectangle.
_SHARP_LOBE: Final = 8.0
_SIDE_POINTS: Final = 12  # points along a side of the rectangle
_SPHERE_DIRECTIONS: Final = 256
# Points farther apart are not joined, of a picture whose mean depth is 3 m; of nearer ones too.
_JOINED_M: Final = 0.12
_USUAL_DEPTH_M: Final = 3.0
_LEAST_DEPTH_M: Final = 1.0
_SIDE_SAMPLES: Final = 4  # of a pixel, along a side
# Shadow rays begin and end this much before what they lead to.
_CLEARANCE_M: Final = 1e-3
_LUMINANCE: Final = LUMINANCE.astype(np.float32)
# What the light of an opening's lobes is computed from.
_APPROXIMATED: Final = ("depth", "normal_camera")


def write_lights(place: Place, number: int, frame: Frame) -> None:
    """Write the files of all lights of a view; ``frame.missing`` has what it cannot give.

    Args:
        place: Where they go.
        number: Of the frame.
        frame: The view.

    Raises:
        OutputError: A file cannot be written.
    """
    for light in frame.lights:
        for name, made in _LIGHT.items():
            path = place.light(name, number, light.number)
            if path and made.concerns(light) and not frame.misses(name, made.needs):
                made.write(path, frame, light)
    seen = place.visibility(number)
    if seen and frame.lights and not frame.misses("visibility", ("mask_i",)):
        kinds = {"isVisLamp": False, "isVisWindow": True}
        write_pickled(seen, {name: _is_in_picture(frame, window) for name, window in kinds.items()})


def _is_in_picture(frame: Frame, window: bool) -> bool:
    """Whether a light of this kind is in the picture."""
    return any(
        bool(_mask(frame, light).any()) for light in frame.lights if light.is_window == window
    )


def _mask(frame: Frame, light: Light) -> Mask:
    found: Mask = frame.light("mask", light)[..., 0] > 0.5
    return found


class _MadeOfLight(NamedTuple):
    needs: tuple[str, ...]
    write: Callable[[Path, Frame, Light], None]
    concerns: Callable[[Light], bool] = lambda light: True


def _camera(frame: Frame) -> Array:
    return lights.camera_from_world(frame.view.world_from_camera)


def _write_box(path: Path, frame: Frame, light: Light) -> None:
    write_pickled(path, lights.box(light, _camera(frame), _mask(frame, light)))


def _write_mask(path: Path, frame: Frame, light: Light) -> None:
    images.write_picture(path, images.ratio(_mask(frame, light)[..., None]))


def _write_source(path: Path, frame: Frame, light: Light) -> None:
    write_pickled(path, lights.source(light, _camera(frame), _loss(frame, light)))


def _loss(frame: Frame, light: Light) -> float:
    """The mean absolute error of what an opening's lobes give, lux; 0 where it is not known."""
    needs = (*_APPROXIMATED, "unoccluded_i")
    if not light.is_window or frame.lacks(needs):
        return 0.0
    true = frame.coarse(frame.light("unoccluded", light))
    off = np.abs(_approximation(frame, light).astype(np.float64) - true)
    known = off[np.isfinite(off)]
    return float(known.mean()) if known.size else 0.0


def _write_single_source(path: Path, frame: Frame, light: Light) -> None:
    write_pickled(path, lights.single_source(light, _camera(frame)))


def _write_shadow(path: Path, frame: Frame, light: Light) -> None:
    """The visibility of a coarse pixel: the mean of its pixels', each by the light that it bars."""
    free = frame.light("unoccluded", light)
    seen = frame.light("visibility", light) * free
    sums = frame.coarse(np.stack([seen @ _LUMINANCE, free @ _LUMINANCE], axis=-1))
    lit = np.where(sums[..., 1:] > 0, sums[..., 1:], 1.0)
    images.write_picture(path, images.ratio(sums[..., :1] / lit))


def _write_depth_shadow(path: Path, frame: Frame, light: Light) -> None:
    rows, columns = frame.grid
    mask = frame.coarse(_mask(frame, light)[..., None].astype(np.float32))[..., 0] > 0.0
    scale = np.array([columns / frame.view.width, rows / frame.view.height, 1.0])
    points = frame.coarse(_camera_points(frame.view)).astype(np.float64)
    K = scale[:, None] * frame.view.K
    share = depth_shadow(light, _camera(frame), points, K, mask)
    with atomic.replacing(path) as beside, writing(path):
        np.save(beside, share.astype(np.float32), allow_pickle=False)


def _write_approximation(path: Path, frame: Frame, light: Light) -> None:
    write_rgbe(path, _approximation(frame, light))


def _approximation(frame: Frame, light: Light) -> Pixels:
    """What an opening's lobes give at the points of the grid, computed once."""
    if light.number not in frame.approximations:
        points = frame.coarse(_camera_points(frame.view))
        normals = frame.coarse(frame.view.pixels["normal_camera"])
        found = approximate(light, _camera(frame), points, normals)
        frame.approximations[light.number] = found
    return frame.approximations[light.number]


def _camera_points(view: RenderedView) -> Pixels:
    """(height, width, 3) what every pixel sees; right, up, backward, metres."""
    columns, rows = np.meshgrid(np.arange(view.width) + 0.5, np.arange(view.height) + 0.5)
    rays = np.stack([columns, rows, np.ones_like(rows)], axis=-1) @ np.linalg.inv(view.K).T
    found: Pixels = (rays * [1.0, -1.0, -1.0] * view.pixels["depth"]).astype(np.float32)
    return found


def _shading(channel: str) -> _MadeOfLight:
    return _MadeOfLight(
        (f"{channel}_i",),
        lambda path, f, light: write_rgbe(path, f.coarse(f.light(channel, light))),
    )


_LIGHT: Final[dict[str, _MadeOfLight]] = {
    "box": _MadeOfLight(("mask_i",), _write_box),
    "mask": _MadeOfLight(("mask_i",), _write_mask),
    "imShadow": _MadeOfLight(("visibility_i", "unoccluded_i"), _write_shadow),
    "depthShadow": _MadeOfLight(("depth", "mask_i"), _write_depth_shadow),
    "imDS": _shading("direct"),
    "imDSNoOcclu": _shading("unoccluded"),
    "imDSNoOccluApprox": _MadeOfLight(
        _APPROXIMATED, _write_approximation, lambda light: light.is_window
    ),
    "light": _MadeOfLight((), _write_single_source),
    "lightSrc": _MadeOfLight((), _write_source),
    "lightSrcNoOcclu": _MadeOfLight((), _write_source),
}


def depth_shadow(light: Light, camera: Array, points: Array, K: Array, mask: Mask) -> Array:
    """The share of a light that reaches each pixel past all that the picture shows.

    Args:
        light: A lamp, whose box shines on all sides, or an opening.
        camera: (4, 4) from the world to the camera's right, up, backward.
        points: (rows, columns, 3) in that frame, metres; the origin where there is no surface.
        K: (3, 3) intrinsics for pictures of this size.
        mask: (rows, columns) where the picture shows the light itself, which casts no shadow.

    Returns:
        (rows, columns) -1 to 1: the mean over the pixel, in which what meets nothing counts -1.
    """
    rows, columns = mask.shape
    sheet = _sheet(points, mask)
    rng = np.random.default_rng(light.number)
    total = np.zeros(rows * columns)
    for part in range(_SIDE_SAMPLES**2):
        jitter = np.array(divmod(part, _SIDE_SAMPLES)) + rng.random((rows * columns, 2))
        ways = _rays(K, rows, columns, jitter / _SIDE_SAMPLES)
        found = sheet.first_hit(np.zeros(3), ways)
        total += np.where(found.hit, 0.0, -1.0)
        ways = ways[found.hit] / np.linalg.norm(ways[found.hit], axis=1, keepdims=True)
        places = ways * found.distance[found.hit, None]
        normals = sheet.normals[found.triangle[found.hit]]
        facing = normals * -np.sign((normals * ways).sum(axis=1, keepdims=True))
        path = _places(light, camera, rng.random((len(places), 3))) - places
        length = np.linalg.norm(path, axis=1)
        lit = (path * facing).sum(axis=1) >= 0.0
        begin = places + path * (_CLEARANCE_M / np.maximum(length, _CLEARANCE_M))[:, None]
        lit[lit] = ~sheet.occluded(begin[lit], path[lit], length[lit] - 2.0 * _CLEARANCE_M)
        total[found.hit] += lit
    share = (total / _SIDE_SAMPLES**2).reshape(rows, columns)
    # What shows a window is one, not a surface; so it is known.
    return np.minimum(share + mask, 1.0) if light.is_window else share


def _sheet(points: Array, mask: Mask) -> RayCaster:
    """The triangles between near points: two of each square, by the diagonal that fits."""
    # A pixel may hold any number.
    points = np.where(np.isfinite(points).all(axis=-1, keepdims=True), points, 0.0)
    depth = -points[..., 2]
    joined = _JOINED_M * max(float(depth.mean()), _LEAST_DEPTH_M) / _USUAL_DEPTH_M
    known = (depth > 0.0) & ~mask
    numbers = np.arange(mask.size).reshape(mask.shape)
    corners = [numbers[:-1, :-1], numbers[:-1, 1:], numbers[1:, :-1], numbers[1:, 1:]]
    flat = points.reshape(-1, 3)

    def near(a: int, b: int) -> Mask:
        limit = joined * (np.sqrt(2.0) if a + b == 3 else 1.0)
        return np.asarray(np.linalg.norm(flat[corners[a]] - flat[corners[b]], axis=-1) < limit)

    falling, rising = near(0, 3), near(1, 2) & ~near(0, 3)
    choices = {(0, 3, 1): falling, (0, 2, 3): falling, (0, 2, 1): rising, (2, 3, 1): rising}
    found = []
    for triangle, diagonal in choices.items():
        kept = diagonal.copy()
        for a, b in zip(triangle, (*triangle[1:], triangle[0]), strict=True):
            kept &= near(a, b) & known.ravel()[corners[a]]
        found.append(np.stack([corners[corner][kept] for corner in triangle], axis=-1))
    return RayCaster(flat, np.concatenate(found))


def _rays(K: Array, rows: int, columns: int, jitter: Array) -> Array:
    """(rows * columns, 3) right, up, backward through a place of each pixel."""
    y, x = np.divmod(np.arange(rows * columns), columns)
    pixels = np.stack([x + jitter[:, 1], y + jitter[:, 0], np.ones(len(x))], axis=-1)
    return np.asarray(pixels @ np.linalg.inv(K).T * [1.0, -1.0, -1.0])


def _places(light: Light, camera: Array, draws: Array) -> Array:
    """(N, 3) points of an opening's rectangle, or of the faces of a lamp's box, by their areas."""
    size = light.size
    areas = np.array([size[1] * size[2], size[2] * size[0], size[0] * size[1]])
    if light.is_window or not areas.any():
        areas = (size == size.min()) & (np.arange(3) == np.argmin(size))
    ends = np.cumsum(np.repeat(areas / areas.sum(), 2))
    face = np.minimum(np.searchsorted(ends, draws[:, 0], side="right"), 5)
    local = np.empty_like(draws)
    axis = face // 2
    rows = np.arange(len(draws))
    local[rows, (axis + 1) % 3], local[rows, (axis + 2) % 3] = draws[:, 1] - 0.5, draws[:, 2] - 0.5
    local[rows, axis] = face % 2 - 0.5
    world = light.center + (local * size) @ light.axes.T
    return np.asarray(world @ camera[:3, :3].T + camera[:3, 3])


def approximate(light: Light, camera: Array, points: Floats, normals: Floats) -> Floats:
    """Irradiance by the lobes of an opening through its rectangle, without occlusion.

    Args:
        light: An opening.
        camera: (4, 4) from the world to the camera's right, up, backward.
        points: (rows, columns, 3) in that frame, metres; the origin where there is no surface.
        normals: (rows, columns, 3) in that frame; the length does not matter, 0 means no surface.

    Returns:
        (rows, columns, 3) lux.
    """
    flat = points.reshape(-1, 3).astype(np.float64)
    lengths = np.linalg.norm(normals, axis=-1, keepdims=True)
    facing = (normals / np.maximum(lengths, 1e-6)).reshape(-1, 3).astype(np.float64)
    flat = (flat - camera[:3, 3]) @ camera[:3, :3]
    facing = facing @ camera[:3, :3]
    result = np.zeros_like(flat)
    for lobe in light.lobes.values() if light.on else ():
        through = _along_lobe if lobe.sharpness > _SHARP_LOBE else _over_rectangle
        result += through(light, lobe, flat, facing)[:, None] * lobe.intensity
    return result.reshape(points.shape).astype(np.float32)


def _rectangle(light: Light) -> tuple[Array, Array, Array]:
    """Two half edges, and the normal: the box's shortest axis."""
    normal, *edges = np.argsort(light.size)
    first, second = (0.5 * light.size[i] * light.axes[:, i] for i in edges)
    return first, second, light.axes[:, normal]


def _over_rectangle(light: Light, lobe: Lobe, points: Array, normals: Array) -> Array:
    """The integral over the rectangle by the midpoints of its parts."""
    first, second, normal = _rectangle(light)
    places = (np.arange(_SIDE_POINTS) + 0.5) / _SIDE_POINTS * 2.0 - 1.0
    area = 4.0 * np.linalg.norm(first) * np.linalg.norm(second) / _SIDE_POINTS**2
    total = np.zeros(len(points))
    for u in places:
        for v in places:
            way = light.center + u * first + v * second - points
            square = np.maximum((way**2).sum(axis=1), 1e-12)
            way = way / np.sqrt(square)[:, None]
            light_in = np.exp(lobe.sharpness * (way @ lobe.axis - 1.0))
            total += (
                light_in
                * np.maximum((way * normals).sum(axis=1), 0.0)
                * np.abs(way @ normal)
                / square
            )
    return total * area


def _along_lobe(light: Light, lobe: Lobe, points: Array, normals: Array) -> Array:
    """The integral over the lobe's directions, spread evenly by their weight."""
    first, second, normal = _rectangle(light)
    total = np.zeros(len(points))
    for way in _directions(lobe):
        slope = way @ normal
        if abs(slope) < 1e-9:
            continue
        distance = ((light.center - points) @ normal) / slope
        offset = points + distance[:, None] * way - light.center
        inside = (distance > 0) & (np.abs(offset @ first) <= first @ first)
        inside &= np.abs(offset @ second) <= second @ second
        total += inside * np.maximum(normals @ way, 0.0)
    return total * spread(lobe.sharpness) / _SPHERE_DIRECTIONS


def _directions(lobe: Lobe) -> Array:
    """(N, 3) unit vectors, as dense as the lobe is bright: a spiral by the golden angle."""
    share = (np.arange(_SPHERE_DIRECTIONS) + 0.5) / _SPHERE_DIRECTIONS
    cosine = 1.0 + np.log1p(share * np.expm1(-2.0 * lobe.sharpness)) / lobe.sharpness
    sine = np.sqrt(np.maximum(0.0, 1.0 - cosine**2))
    turn = np.arange(_SPHERE_DIRECTIONS) * np.pi * (3.0 - np.sqrt(5.0))
    side = np.cross(lobe.axis, np.eye(3)[np.argmin(np.abs(lobe.axis))])
    side = side / np.linalg.norm(side)
    other = np.cross(lobe.axis, side)
    ring = np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * other
    result: Array = cosine[:, None] * lobe.axis + sine[:, None] * ring
    return result
