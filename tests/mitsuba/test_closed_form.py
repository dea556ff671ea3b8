"""Irradiance of triangles in closed form, against catalogued factors and plain integration."""

from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array

UP = (0.0, 0.0, 1.0)


def by_dr(mi: ModuleType, corners: ArrayLike, at: Any, cosine: Any, horizon: Any = None) -> Array:
    """(N,) the function under test for triangles (N, 3, 3), points and normals (3,) or (N, 3)."""
    from orusd_mitsuba.direct.closed_form import factor

    triangles = np.asarray(corners, dtype=np.float64).reshape(-1, 3, 3)
    points = [mi.Point3f(triangles[:, i].T.astype(np.float32)) for i in range(3)]

    def vectors(values: Any) -> Any:
        wide = np.broadcast_to(np.asarray(values, dtype=np.float32), (len(triangles), 3))
        return mi.Vector3f(np.ascontiguousarray(wide.T))

    normals = vectors(cosine), vectors(cosine if horizon is None else horizon)
    found = factor(tuple(points), mi.Point3f(vectors(at)), *normals)
    return np.asarray(found.numpy(), dtype=np.float64)


def clipped(polygon: list[Array], normal: Array) -> list[Array]:
    """A convex polygon's part above a plane through 0 (Sutherland and Hodgman)."""
    kept = []
    for first, last in zip(polygon, [*polygon[1:], *polygon[:1]], strict=True):
        h0, h1 = float(first @ normal), float(last @ normal)
        if h0 > 0.0:
            kept.append(first)
        if (h0 > 0.0) != (h1 > 0.0):
            kept.append(first + (last - first) * h0 / (h0 - h1))
    return kept


def by_numpy(triangle: Array, at: Array, cosine: Array, horizon: Array) -> float:
    """The same in double precision: clipped as a polygon, then Lambert's sum by arc cosines."""
    a, b, c = triangle - at
    if np.cross(b - a, c - a) @ a >= 0.0:
        return 0.0
    polygon = clipped(clipped([a, b, c], horizon), cosine)
    unit = [v / np.linalg.norm(v) for v in polygon]
    total = 0.0
    for first, last in zip(unit, [*unit[1:], *unit[:1]], strict=True):
        cross = np.cross(last, first)
        if (length := np.linalg.norm(cross)) > 0.0:
            total += np.arccos(np.clip(first @ last, -1.0, 1.0)) * (cross @ cosine) / length
    return 0.5 * total


def test_it_is_lamberts_sum_of_the_clipped_triangle(mi: ModuleType) -> None:
    rng = np.random.default_rng(3)
    count = 2000
    triangles = rng.normal(size=(count, 3, 3)) * rng.choice([0.3, 1.0, 3.0], (count, 1, 1))
    triangles += [0.0, 0.0, 1.0]
    at = rng.normal(size=(count, 3)) * 0.7
    cosine, tilt = rng.normal(size=(2, count, 3))
    horizon = np.where(np.arange(count)[:, None] % 2, cosine, cosine + 0.5 * tilt)
    cosine /= np.linalg.norm(cosine, axis=1, keepdims=True)
    horizon /= np.linalg.norm(horizon, axis=1, keepdims=True)
    found = by_dr(mi, triangles, at, cosine, horizon)
    expected = np.array([*map(by_numpy, triangles, at, cosine, horizon)])
    assert (expected > 0.01).sum() > 400
    # Single precision, and where it looks small midpoints.
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=2e-5)


def rectangle(corner: ArrayLike, u: ArrayLike, v: ArrayLike) -> Array:
    """(2, 3, 3) triangles; its front is along u x v."""
    c, u, v = (np.asarray(x, dtype=np.float64) for x in (corner, u, v))
    return np.array([[c, c + u, c + u + v], [c, c + u + v, c + v]])


@pytest.mark.parametrize(("a", "b", "h"), [(1.0, 2.0, 0.5), (3.0, 0.2, 1.0), (40.0, 40.0, 0.5)])
def test_parallel_and_perpendicular_rectangles_have_their_catalogued_factors(
    mi: ModuleType, a: float, b: float, h: float
) -> None:
    # J. R. Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-3 and B-4.
    A, B = a / h, b / h
    parallel = (
        A / np.sqrt(1 + A**2) * np.arctan(B / np.sqrt(1 + A**2))
        + B / np.sqrt(1 + B**2) * np.arctan(A / np.sqrt(1 + B**2))
    ) / 2.0
    above = rectangle((0, 0, h), (0, b, 0), (a, 0, 0))
    assert by_dr(mi, above, (0, 0, 0), UP).sum() == pytest.approx(parallel, rel=1e-5)
    # The element lies in the plane of the rectangle's lower edge, b wide, a high, h away.
    Y, X = np.hypot(1.0, a / h), b / h
    upright = (np.arctan(X) - np.arctan(X / Y) / Y) / 2.0
    wall = rectangle((h, 0, 0), (0, 0, a), (0, b, 0))
    assert by_dr(mi, wall, (0, 0, 0), UP).sum() == pytest.approx(upright, rel=1e-5)


def test_what_is_below_the_horizon_does_not_count(mi: ModuleType) -> None:
    upper = rectangle((1, -1, 0), (0, 0, 2), (0, 2, 0))
    whole = rectangle((1, -1, -3), (0, 0, 5), (0, 2, 0))
    assert by_dr(mi, whole, (0, 0, 0), UP).sum() == pytest.approx(
        by_dr(mi, upper, (0, 0, 0), UP).sum(), rel=1e-5
    )
    assert by_dr(mi, whole, (0, 0, 0), (0, 0, -1)).sum() > 0.0


def test_all_that_is_above_the_horizon_gives_pi(mi: ModuleType) -> None:
    ceiling = rectangle((-1e4, -1e4, 0.01), (0, 2e4, 0), (2e4, 0, 0))
    assert by_dr(mi, ceiling, (0, 0, 0), UP).sum() == pytest.approx(np.pi, rel=1e-5)


def test_the_back_the_plane_and_nothing_give_nothing(mi: ModuleType) -> None:
    above = rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0))
    assert not by_dr(mi, above[:, ::-1], (0, 0, 0), UP).any()
    assert not by_dr(mi, above, (3.0, 0, 1), (0, 0, -1)).any()
    assert not by_dr(mi, above, (0, 0, 0), (0, 0, 0)).any()
    line = [[(0, 0, 1), (1, 0, 1), (2, 0, 1)], [(0, 0, 1), (0, 0, 1), (1, 1, 1)]]
    assert not by_dr(mi, line, (0, 0, 0), UP).any()


def test_a_small_triangle_is_a_point(mi: ModuleType) -> None:
    size = 10.0 ** -np.arange(1.0, 6.0)
    corners = np.array([[0, 0, 1], [0, 1, 1], [1, 0, 1]]) * [1, 1, 0] * size[:, None, None]
    corners[..., 2] = 1.0
    found = by_dr(mi, corners, (0.5, 0.3, 0.0), UP)
    squared = 1.0 + 0.5**2 + 0.3**2
    np.testing.assert_allclose(found[2:], (size**2 / 2.0 / squared**2)[2:], rtol=2e-2)
    exact = [by_numpy(c, np.array([0.5, 0.3, 0.0]), np.array(UP), np.array(UP)) for c in corners]
    np.testing.assert_allclose(found[:4], exact[:4], rtol=1e-3)
