"""NURBS patches, points and tetrahedra as polygons."""

from typing import Final

import numpy as np
from pxr import Usd, UsdGeom
from scipy.sparse import csr_array, kron

from openrooms_usd.arrays import Array, Ints
from openrooms_usd.geometry import splines
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.usd.arrays import integers, numbers, vector_of
from openrooms_usd.usd.places.frames import TIME
from openrooms_usd.usd.shapes.tessellation import Drawn

# Of more points each is a twentyfold, of fewer that is refined once.
_MANY_POINTS: Final = 5_000


def read_patch(prim: Usd.Prim) -> Drawn:
    """The surface of a ``NurbsPatch``."""
    patch = UsdGeom.NurbsPatch(prim)
    points = numbers(patch.GetPointsAttr(), 3)
    try:
        u, v = (_side(prim, name) for name in "uv")
        # Points run along u first.
        weights = csr_array(kron(v, u))
        if weights.shape[1] != len(points):
            raise ValueError("uVertexCount and vVertexCount do not fit the number of points")
        own = numbers(patch.GetPointWeightsAttr())
        if len(own):
            if len(own) != len(points):
                raise ValueError("there are not as many pointWeights as points")
            weights = splines.rational(weights, own)
    except ValueError as reason:
        return Drawn(None, [str(reason)])
    if not np.isfinite(points).all():
        return Drawn(None, ["points hold NaN or infinity"])
    losses = ["it is drawn as flat pieces"]
    if len(integers(patch.GetTrimCurveCountsAttr())):
        losses.append("its trimming curves are not applied")
    sheet = _sheet(weights @ points, u.shape[0], v.shape[0])
    return Drawn(sheet, losses, lambda values, _: _each(values, len(points), weights))


def _each(values: Array, count: int, weights: csr_array | None = None) -> Array:
    """Values of points, or of what is made of them."""
    if len(values) not in (1, count):
        raise ValueError("the numbers of values and points differ")
    every = np.broadcast_to(values, (count, *values.shape[1:]))
    return np.asarray(every if weights is None else weights @ every)


def _side(prim: Usd.Prim, name: str) -> csr_array:
    count, order, knots, reach = (
        prim.GetAttribute(f"{name}{what}") for what in ("VertexCount", "Order", "Knots", "Range")
    )
    size, degree, values = _whole(count), _whole(order), numbers(knots)
    if size < 2 or len(values) != size + degree:
        raise ValueError("knots do not fit the count and the order of points")
    return splines.spans(values, degree, size, vector_of(reach.Get(TIME), 2))


def _whole(attribute: Usd.Attribute) -> int:
    value = attribute.Get(TIME)
    return value if isinstance(value, int) else 0


def _sheet(points: Array, columns: int, rows: int) -> Mesh:
    """A grid of quadrilaterals, smooth, with coordinates from 0 to 1."""
    number = np.arange(rows * columns).reshape(rows, columns)
    quads = np.stack(
        [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1
    ).reshape(-1, 4)
    at = points.reshape(rows, columns, 3)
    slopes = np.gradient(at, axis=1), np.gradient(at, axis=0)
    normals = np.cross(*slopes).reshape(-1, 3)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    whole = np.array([0.0, 0.0, 1.0])
    normals = np.where(lengths > 0.0, normals / np.maximum(lengths, 1e-300), whole)
    v, u = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, columns), indexing="ij")
    st = np.stack([u, v], axis=-1).reshape(-1, 2)
    indices = quads.reshape(-1)
    return Mesh(
        points,
        np.full(len(quads), 4, np.int32),
        indices.astype(np.int32),
        normals[indices].astype(np.float32),
        st[indices].astype(np.float32),
    )


def read_points(prim: Usd.Prim) -> Drawn:
    """A ball for each point of a ``Points``."""
    cloud = UsdGeom.Points(prim)
    points, widths = numbers(cloud.GetPointsAttr(), 3), numbers(cloud.GetWidthsAttr())
    losses = []
    if not len(widths):
        widths, losses = np.ones(1), ["it has no widths: 1 is used"]
    if len(widths) not in (1, len(points)):
        return Drawn(None, ["the numbers of widths and points differ"])
    kept = np.isfinite(points).all(axis=1) & (np.broadcast_to(widths, len(points)) > 0.0)
    if not kept.any():
        return Drawn(None, ["it has no points with a width"])
    radii = 0.5 * np.broadcast_to(widths, len(points))[kept]
    ball, faces = _ball(refined=len(points) <= _MANY_POINTS)
    places = points[kept][:, None] + radii[:, None, None] * ball
    first = np.arange(len(radii)) * len(ball)
    indices = (first[:, None, None] + faces).reshape(-1)
    normals = np.tile(ball / np.linalg.norm(ball, axis=1, keepdims=True), (len(radii), 1))
    counts = np.full(len(radii) * len(faces), 3, np.int32)
    losses.append(f"each point is drawn as a ball of {len(faces)} triangles")
    balls = Mesh(
        places.reshape(-1, 3), counts, indices.astype(np.int32), normals[indices].astype(np.float32)
    )
    return Drawn(balls, losses, lambda values, _: _each(values, len(points))[kept])


def _ball(*, refined: bool) -> tuple[Array, Ints]:
    """Corners and faces of a body of triangles that holds as much as the ball of radius 1."""
    from trimesh.creation import icosahedron

    solid = icosahedron()
    corners, faces = np.asarray(solid.vertices), np.asarray(solid.faces)
    if refined:
        edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        pairs, which = np.unique(edges, axis=0, return_inverse=True)
        middles = corners[pairs].sum(axis=1)
        middles /= np.linalg.norm(middles, axis=1, keepdims=True)
        ab, bc, ca = (which.reshape(-1, 3) + len(corners)).T
        a, b, c = faces.T
        rows = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        corners = np.concatenate([corners, middles])
        faces = np.concatenate([np.stack(row, axis=1) for row in rows])
    p, q, r = np.moveaxis(corners[faces], 1, 0)
    volume = np.einsum("ij,ij->", p, np.cross(q, r)) / 6.0
    return corners * (4.0 * np.pi / 3.0 / volume) ** (1.0 / 3.0), faces


def read_tetrahedra(prim: Usd.Prim) -> Drawn:
    """The surface of a ``TetMesh``."""
    body = UsdGeom.TetMesh(prim)
    points = numbers(body.GetPointsAttr(), 3)
    cells = integers(body.GetTetVertexIndicesAttr(), 4)
    faces = integers(body.GetSurfaceFaceVertexIndicesAttr(), 3)
    every = np.concatenate([cells.reshape(-1), faces.reshape(-1)])
    if not len(every) or every.min() < 0 or every.max() >= len(points):
        return Drawn(None, ["its indices refer to points that do not exist, or there are none"])
    if not np.isfinite(points).all():
        return Drawn(None, ["points hold NaN or infinity"])
    if not len(faces):
        faces = np.asarray(UsdGeom.TetMesh.ComputeSurfaceFaces(body, TIME), np.int64)
    indices = faces.reshape(-1).astype(np.int32)
    surface = Mesh(points, np.full(len(faces), 3, np.int32), indices)
    return Drawn(surface, [], lambda values, _: _each(values, len(points)))
