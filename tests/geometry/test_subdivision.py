"""Subdivision against B-splines, against itself refined on and on, and by its symmetries."""

from itertools import product

import numpy as np
import pytest
from scipy.interpolate import BSpline

from openrooms_usd.arrays import Ints
from openrooms_usd.geometry.cages import Cage
from openrooms_usd.geometry.subdivision import limit, refine, smooth_normals

BOX = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], float)
SIDES = np.array(
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
)
TETRAHEDRON = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def polygons(faces: Ints, sharp: float = 0.0) -> Cage:
    """Faces of equal corners whose edges are all as sharp."""
    indices = faces.reshape(-1)
    zeros = np.zeros(indices.max() + 1)
    return Cage(np.full(len(faces), faces.shape[1]), indices, np.full(indices.shape, sharp), zeros)


def grid(side: int) -> Ints:
    first = np.array([j * side + i for j in range(side - 1) for i in range(side - 1)])
    return first[:, None] + [0, 1, side + 1, side]


def test_a_regular_grid_is_a_bicubic_b_spline() -> None:
    side, levels = 6, 2
    height = np.random.default_rng(2).normal(size=(side, side))
    points = np.array([[i, j, height[j, i]] for j in range(side) for i in range(side)])
    fine = refine(polygons(grid(side)), "catmullClark", levels)
    found = limit(fine.cage, "catmullClark") @ fine.weights @ points
    # Inside, where no boundary is near, x and y are the parameters themselves.
    inner = found[((found[:, :2] > 0.999) & (found[:, :2] < side - 1.999)).all(axis=1)]
    assert len(inner) == ((side - 3) * 2**levels + 1) ** 2
    knots = np.arange(-2.0, side + 2.0)
    row = BSpline(knots, np.eye(side), 3)
    expected = np.einsum("nj,ji,ni->n", row(inner[:, 1]), height, row(inner[:, 0]))
    assert np.abs(inner[:, 2] - expected).max() < 1e-12


def test_a_boundary_is_a_cubic_b_spline() -> None:
    side = 7
    row = np.sin(2.0 * np.arange(side))
    points = np.array([[i, j, row[i] * (j == 0)] for j in range(side) for i in range(side)])
    fine = refine(polygons(grid(side)), "catmullClark", 3)
    found = limit(fine.cage, "catmullClark") @ fine.weights @ points
    edge = found[(found[:, 1] < 1e-9) & (found[:, 0] > 0.999) & (found[:, 0] < side - 1.999)]
    assert len(edge) == 8 * (side - 3) + 1
    curve = BSpline(np.arange(-2.0, side + 2.0), row, 3)
    assert np.abs(edge[:, 2] - curve(edge[:, 0])).max() < 1e-12


@pytest.mark.parametrize(
    ("scheme", "faces"), [("catmullClark", SIDES), ("loop", TETRAHEDRON)], ids=str
)
@pytest.mark.parametrize("sharp", [0.0, 0.6, 1.7])
def test_refinement_tends_to_the_limit(scheme: str, faces: Ints, sharp: float) -> None:
    cage = polygons(faces, sharp)
    points = np.random.default_rng(3).normal(size=(len(cage.corners), 3))
    expected = limit(cage, scheme) @ points
    errors = []
    for levels in (3, 4, 5):
        fine = refine(cage, scheme, levels)
        errors.append(np.abs((fine.weights @ points)[: len(points)] - expected).max())
    # A quarter each time, by the second derivative.
    assert errors[2] < 0.3 * errors[1] < 0.1 * errors[0] < 0.1


def test_what_is_sharp_for_ever_stays_where_it_is() -> None:
    fine = refine(polygons(SIDES, np.inf), "catmullClark", 3)
    found = limit(fine.cage, "catmullClark") @ fine.weights @ BOX
    assert np.abs(np.abs(found).max(axis=1) - 1.0).max() < 1e-12
    assert len(found) == 6 * 64 + 2


def test_sharpness_of_one_is_one_sharp_step() -> None:
    once = refine(polygons(SIDES, np.inf), "catmullClark", 1)
    smooth = Cage(
        once.cage.counts, once.cage.indices, 0.0 * once.weights.sum() + np.zeros(96), np.zeros(26)
    )
    then = refine(smooth, "catmullClark", 2)
    expected = then.weights @ once.weights @ BOX
    found = refine(polygons(SIDES, 1.0), "catmullClark", 3).weights @ BOX
    assert np.abs(found - expected).max() < 1e-12


@pytest.mark.parametrize("scheme", ["catmullClark", "loop", "bilinear"])
def test_weights_are_a_mean_whatever_is_sharp(scheme: str) -> None:
    random = np.random.default_rng(4)
    faces = TETRAHEDRON if scheme == "loop" else SIDES
    cage = polygons(faces)
    sharp = random.choice([0.0, 0.3, 1.0, 2.6, np.inf], cage.indices.size)
    points = random.choice([0.0, 1.5, np.inf], len(cage.corners))
    cage = Cage(cage.counts, cage.indices, sharp, points)
    fine = refine(cage, scheme, 2)
    for weights in (fine.weights, limit(fine.cage, scheme)):
        assert np.abs(weights.sum(axis=1) - 1.0).max() < 1e-12
    assert len(fine.cage.counts) == (16 if scheme == "loop" else 4 * 4) * len(faces)
    assert (np.bincount(fine.faces) == len(fine.faces) // len(faces)).all()


def test_normals_of_a_smooth_box_point_outwards_and_break_at_creases() -> None:
    fine = refine(polygons(SIDES), "catmullClark", 2)
    points = limit(fine.cage, "catmullClark") @ fine.weights @ BOX
    normals = smooth_normals(fine.cage, points)
    at = points[fine.cage.indices]
    at /= np.linalg.norm(at, axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", normals, at).min() > 0.97
    # One normal a point, whichever face shows it.
    for row in range(len(points)):
        assert np.ptp(normals[fine.cage.indices == row], axis=0).max() < 1e-12
    box = refine(polygons(SIDES, np.inf), "catmullClark", 1)
    flat = smooth_normals(box.cage, box.weights @ BOX)
    assert (np.abs(flat).max(axis=1) > 1.0 - 1e-12).all()


def test_the_other_side_of_an_edge_may_run_the_same_way() -> None:
    """A strip that is glued with a twist has no outside; it is refined all the same."""
    ring = [[2 * k, 2 * k + 1, 2 * k + 3, 2 * k + 2] for k in range(5)]
    twisted = np.array([*ring, [10, 11, 0, 1]])
    fine = refine(polygons(twisted), "catmullClark", 2)
    points = fine.weights @ np.random.default_rng(5).normal(size=(12, 3))
    assert np.isfinite(smooth_normals(fine.cage, points)).all()


def test_corners_come_in_an_order_of_their_own() -> None:
    """So values of corners are refined as polygons of their own."""
    cage = polygons(SIDES)
    apart = Cage(cage.counts, np.arange(24), cage.creases, np.zeros(24))
    for scheme, linear in product(["catmullClark", "bilinear"], [True]):
        one, other = refine(cage, scheme, 2, linear=linear), refine(apart, scheme, 2, linear=linear)
        assert (one.faces == other.faces).all()
        values = (other.weights @ BOX[cage.indices])[other.cage.indices]
        assert np.abs((one.weights @ BOX)[one.cage.indices] - values).max() < 1e-12
