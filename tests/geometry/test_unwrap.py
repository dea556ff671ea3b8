"""The second set: nothing overlaps (counted pixel by pixel), nothing is stretched far."""

import numpy as np
import pytest

from openrooms_usd.geometry import unwrap
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box, rounded_box, sphere
from openrooms_usd.geometry.unwrap import Layout, laid_out
from openrooms_usd.geometry.uvquality import uv_quality

pytest.importorskip("xatlas", reason="xatlas has no wheel for this Python")

SIZE = 512


def _coverage(st: np.ndarray) -> np.ndarray:
    """(SIZE, SIZE) how many triangles hold each pixel's centre, by three half-planes."""
    counts = np.zeros((SIZE, SIZE), int)
    for a, b, c in st.reshape(-1, 3, 2).astype(float) * SIZE:
        low = np.floor(np.minimum(np.minimum(a, b), c)).astype(int).clip(0)
        high = np.ceil(np.maximum(np.maximum(a, b), c)).astype(int) + 1
        y, x = np.mgrid[low[1] : min(high[1], SIZE), low[0] : min(high[0], SIZE)] + 0.5
        sides = [
            (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])
            for p, q in ((a, b), (b, c), (c, a))
        ]
        inside = np.all([s > 1e-6 for s in sides], axis=0)
        inside |= np.all([s < -1e-6 for s in sides], axis=0)
        counts[low[1] : low[1] + len(y), low[0] : low[0] + y.shape[1]] += inside
    return counts


SHAPES = {
    "box": box((1, 2, 0.1)),
    "ball": sphere(0.4, segments=24),
    "tiny": sphere(1e-3, segments=20),
    "huge": sphere(1e3, segments=20),
    "apart": joined([rounded_box((1, 1, 1), 0.1), sphere(0.2, segments=12).moved((3, 0, 0))]),
}


def test_the_same_mesh_has_the_same_layout() -> None:
    first, second = (_layout(SHAPES["apart"], 40)[1] for _ in range(2))
    assert first.places.tobytes() == second.places.tobytes()


def _layout(mesh: Mesh, density: float) -> tuple[np.ndarray, Layout]:
    """The corners of its triangles, and where they lie."""
    corners, faces = mesh.triangles()
    rows = mesh.indices[corners]
    return corners, laid_out(mesh.points, rows, faces, texels_per_metre=density)


@pytest.mark.parametrize("name", SHAPES)
def test_layouts_are_as_large_as_the_surface_and_keep_polygons_whole(name: str) -> None:
    mesh, density = SHAPES[name], {"tiny": 4e4, "huge": 4e-2}.get(name, 40.0)
    corners, layout = _layout(mesh, density)
    assert (layout.places >= 0.5).all() and (layout.places <= np.array(layout.size) - 0.5).all()
    counts = _coverage(layout.places / SIZE)
    assert counts.max() == 1
    assert (counts == 1).sum() == pytest.approx(mesh.areas().sum() * density**2, rel=0.1)
    threes, flat = np.full(len(corners), 3, np.int32), mesh.indices[corners].reshape(-1)
    quality = uv_quality(Mesh(mesh.points, threes, flat, st=layout.places.reshape(-1, 2)))
    assert quality.stretch < 1.1 and quality.folded == 0.0
    of_corner: dict[int, np.ndarray] = {}
    for corner, place in zip(corners.ravel(), layout.places.reshape(-1, 2), strict=True):
        np.testing.assert_allclose(of_corner.setdefault(corner, place), place, atol=0.02)


def test_a_polygon_that_is_cut_becomes_a_chart_of_its_own() -> None:
    """Two triangles at a right angle are one bent quad: they are laid side by side, not apart."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.2], [0, 1, 0.0]])
    triangles, faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32), np.zeros(2, np.int32)
    size, places = unwrap._flat(points[triangles], faces, 10.0, 2)
    np.testing.assert_allclose(places[0, [0, 2]], places[1, [0, 1]])
    assert (places >= 1.0).all() and (places <= np.array(size) - 1.0).all()
    places[0] += 5.0
    assert unwrap._cut(faces, triangles.astype(np.int64), places).tolist() == [0]
