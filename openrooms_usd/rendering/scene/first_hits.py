"""What the pixels' centres see, in double precision, from the triangles that were found."""

import math
from dataclasses import dataclass, fields
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array, Floats, Mask
from openrooms_usd.rendering.scene.arrays import Scene
from openrooms_usd.rendering.scene.pictures import evaluate
from openrooms_usd.rendering.scene.rays import RayTracer, Rows
from openrooms_usd.usd.cameras import ORTHOGRAPHIC, PinholeCamera

# |cos| between ray and plane below which the plane cannot tell where the ray meets it.
_GRAZING_COSINE: Final = 1e-6
# How many clear surfaces a ray goes through at most, and the step behind each.
_MOST_CLEAR_LAYERS: Final = 64
_STEP_BEHIND: Final = 1e-5
# What is less opaque than this is seen through by geometry and labels.
_LEAST_OPACITY: Final = 0.5
# For the choice of the triangle alone, not for where it is met.
_ASIDE_PX: Final = np.array([1.0e-3, 0.7e-3])


@dataclass(frozen=True, eq=False)
class Hits:
    """Points on triangles, one for each pixel that sees something.

    Attributes:
        shape: (height, width) of the picture.
        pixels: (R,) flat index of each pixel.
        rows: (R,) row of ``scene.triangles``.
        patches: (R,) row of ``scene.patches``.
        directions: (R, 3) world directions of planar depth 1.
        depth: (R,) planar depth, metres.
        position: (R, 3) world, metres.
        weights: (R, 3) barycentric coordinates.
        st: (R, 2) the mesh's texture coordinates.
        geometric: (R, 3) unit normal of the triangle, on its front side.
    """

    shape: tuple[int, int]
    pixels: Rows
    rows: Rows
    patches: Rows
    directions: Array
    depth: Array
    position: Array
    weights: Array
    st: Array
    geometric: Array

    @property
    def front(self) -> Mask:
        """(R,) whether the front side is seen."""
        return np.asarray(np.einsum("ij,ij->i", self.geometric, self.directions) < 0)

    def chosen(self, which: Mask) -> "Hits":
        """Those of them for which (R,) ``which`` is true."""
        rows = {one.name: getattr(self, one.name) for one in fields(self) if one.name != "shape"}
        return Hits(self.shape, **{name: values[which] for name, values in rows.items()})

    def image(self, values: Array) -> Floats:
        """(height, width, C) the (R,) or (R, C) values in their pixels, 0 elsewhere."""
        columns = values if values.ndim == 2 else values[:, None]
        flat = np.zeros((self.shape[0] * self.shape[1], columns.shape[1]), dtype=np.float32)
        flat[self.pixels] = columns
        return flat.reshape(*self.shape, -1)


def first_hits(
    scene: Scene, tracer: RayTracer, camera: PinholeCamera, width: int, height: int
) -> Hits:
    """What the centre of each pixel sees between the camera's clipping planes.

    Surfaces that are less than half opaque at the point are seen through.
    """
    origins, directions = camera.rays(width, height)
    near, far = camera.clipping
    is_parallel = camera.projection == ORTHOGRAPHIC
    if near == 0.0 and not is_parallel:
        found = tracer.pixels(camera, width, height).ravel()
    else:
        starts = origins + near * directions
        found = tracer.rays(starts + _aside(camera) if is_parallel else starts, directions)
    hits = _through(scene, tracer, origins, directions, found, (height, width))
    return hits if math.isinf(far) else hits.chosen(hits.depth <= far)


def _aside(camera: PinholeCamera) -> Array:
    """(3,) metres beside the centres of an orthographic camera's pixels.

    Where models are symmetric, many parallel rays meet edges exactly, and tracers in single
    precision slip through between the two triangles.
    """
    return np.asarray(camera.world_from_camera[:3, :2] @ (_ASIDE_PX / camera.K[[0, 1], [0, 1]]))


def hits_along(
    scene: Scene, tracer: RayTracer, eye: Array, directions: Array, shape: tuple[int, int]
) -> Hits:
    """What rays from one point meet, each in the place of a pixel.

    Args:
        scene: What is seen.
        tracer: Finds its triangles.
        eye: (3,) world, metres.
        directions: (height x width, 3) of any length, which depths are in multiples of; a ray
            without a direction meets nothing.
        shape: Height and width.
    """
    rows = np.full(len(directions), -1, dtype=np.int64)
    cast = np.flatnonzero(directions.any(axis=1))
    rows[cast] = tracer.rays(np.broadcast_to(eye, (len(cast), 3)), directions[cast])
    return _through(scene, tracer, np.broadcast_to(eye, directions.shape), directions, rows, shape)


def _through(
    scene: Scene,
    tracer: RayTracer,
    origins: Array,
    directions: Array,
    found: Rows,
    shape: tuple[int, int],
) -> Hits:
    """The hits on triangles that were found, or behind them where these are seen through."""
    for _ in range(_MOST_CLEAR_LAYERS):
        hits = _hits(scene, origins, shape, found, directions)
        clear = _clear(scene, hits)
        if not clear.any():
            break
        behind = hits.position[clear] + _STEP_BEHIND * hits.directions[clear]
        found[hits.pixels[clear]] = tracer.rays(behind, hits.directions[clear])
    return hits


def _hits(
    scene: Scene, origins: Array, shape: tuple[int, int], found: Rows, directions: Array
) -> Hits:
    pixels = np.flatnonzero(found >= 0)
    rows, ahead, eye = found[pixels], directions[pixels], origins[pixels]
    met = scene.triangles.rows(rows)
    depth, weights, normals = _meet(met.corners, eye, ahead)
    return Hits(
        shape,
        pixels,
        rows,
        np.searchsorted(scene.offsets, rows, side="right") - 1,
        ahead,
        depth,
        eye + depth[:, None] * ahead,
        weights,
        np.einsum("ri,rij->rj", weights, met.st.astype(np.float64)),
        normals,
    )


def _meet(corners: Array, eye: Array, directions: Array) -> tuple[Array, Array, Array]:
    """Depth, barycentric coordinates and unit normals where rays meet the planes of triangles."""
    a, b, c = np.moveaxis(corners - eye[:, None], 1, 0)
    normals = np.cross(b - a, c - a)
    areas = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.where(areas > 0, areas, 1.0)
    slopes = np.einsum("ij,ij->i", normals, directions)
    edge_on = np.abs(slopes) < _GRAZING_COSINE * np.linalg.norm(directions, axis=1)
    # Seen edge-on, the triangle's middle has to do.
    heights = np.einsum("ij,ij->i", normals, a)
    middle = np.einsum("ij,ij->i", (a + b + c) / 3, directions)
    middle /= np.einsum("ij,ij->i", directions, directions)
    depth = np.where(edge_on, middle, heights / np.where(edge_on, 1.0, slopes))
    points = depth[:, None] * directions
    double_area = np.where(areas[:, 0] > 0, areas[:, 0], 1.0)
    second = np.einsum("ij,ij->i", np.cross(points - a, c - a), normals) / double_area
    third = np.einsum("ij,ij->i", np.cross(b - a, points - a), normals) / double_area
    # Rays were traced in single precision: they may pass a little beside an edge.
    weights = np.clip(np.column_stack([1 - second - third, second, third]), 0.0, 1.0)
    return depth, weights / weights.sum(axis=1, keepdims=True), normals


def _clear(scene: Scene, hits: Hits) -> Mask:
    clear = np.zeros(len(hits.rows), dtype=bool)
    for number in np.unique(hits.patches):
        surface = scene.patches[number].surface
        opacity, here = surface.opacity, hits.patches == number
        if surface.one_sided:
            clear[here] = ~hits.front[here]
        elif opacity != 1.0:
            clear[here] = evaluate(opacity, hits.st[here], 1)[:, 0] < _LEAST_OPACITY
    return clear
