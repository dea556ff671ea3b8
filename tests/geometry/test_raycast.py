"""The ray caster against a brute-force Moeller-Trumbore in double precision."""

import sys

import numpy as np
import pytest

from openrooms_usd.arrays import Array
from openrooms_usd.errors import InputError, MissingPackageError
from openrooms_usd.geometry.raycast import RayCaster

BACKENDS = ("embree", "tree")


@pytest.fixture(params=BACKENDS)
def backend(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    if request.param == "embree":
        pytest.importorskip("embreex")
    else:
        pytest.importorskip("rtree")
        for module in ("embreex", "embreex.mesh_construction", "embreex.rtcore_scene"):
            monkeypatch.setitem(sys.modules, module, None)
    return str(request.param)


def brute_force(points: Array, triangles: Array, origins: Array, directions: Array) -> Array:
    """(R, M) distance along each unit ray to each triangle, inf where it misses."""
    a, b, c = np.moveaxis(points[triangles], 1, 0)
    first, second = b - a, c - a
    across = np.cross(directions[:, None], second[None])
    determinant = np.einsum("rmi,mi->rm", across, first)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / determinant
        away = origins[:, None] - a[None]
        u = np.einsum("rmi,rmi->rm", away, across) * inverse
        cross = np.cross(away, first[None])
        v = np.einsum("rmi,ri->rm", cross, directions) * inverse
        t = np.einsum("rmi,mi->rm", cross, second) * inverse
        inside = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
    return np.where(inside, t, np.inf)


def soup(seed: int, count: int = 60) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-2, 2, (count, 1, 3)) + rng.normal(0, 0.6, (count, 3, 3))
    return corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3)


def rays(seed: int, count: int = 400) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(count, 3))
    return rng.uniform(-4, 4, (count, 3)), directions / np.linalg.norm(
        directions, axis=1, keepdims=True
    )


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("offset", [0.0, 5.0e5])
def test_first_hit_is_the_nearest_by_brute_force(backend: str, seed: int, offset: float) -> None:
    points, triangles = soup(seed)
    origins, directions = rays(seed + 100)
    expected = brute_force(points, triangles, origins, directions)
    hits = RayCaster(points + offset, triangles).first_hit(origins + offset, 3.0 * directions)
    nearest = expected.min(axis=1)
    assert np.array_equal(hits.hit, np.isfinite(nearest))
    assert hits.hit.sum() > 40
    found = np.flatnonzero(hits.hit)
    np.testing.assert_array_equal(hits.triangle[found], expected.argmin(axis=1)[found])
    np.testing.assert_allclose(hits.distance[found], nearest[found], rtol=1e-6, atol=1e-6)
    if offset == 0.0:  # double precision, though the tracer works in single precision
        np.testing.assert_allclose(hits.distance[found], nearest[found], rtol=1e-9)


def test_occlusion_depends_on_the_reach(backend: str) -> None:
    points, triangles = soup(7)
    origins, directions = rays(8)
    caster = RayCaster(points, triangles)
    nearest = brute_force(points, triangles, origins, directions).min(axis=1)
    np.testing.assert_array_equal(caster.occluded(origins, directions), np.isfinite(nearest))
    for reach in (0.0, 0.5, 2.0):
        np.testing.assert_array_equal(
            caster.occluded(origins, 0.1 * directions, reach), nearest <= reach
        )
    np.testing.assert_array_equal(
        caster.occluded(origins, directions, nearest * 1.001), np.isfinite(nearest)
    )


def sphere(rings: int = 24, sectors: int = 48) -> tuple[Array, Array]:
    theta = np.pi * np.arange(1, rings) / rings
    phi = 2 * np.pi * np.arange(sectors) / sectors
    ring = np.stack(
        np.broadcast_arrays(
            np.sin(theta)[:, None] * np.cos(phi),
            np.sin(theta)[:, None] * np.sin(phi),
            np.cos(theta)[:, None],
        ),
        axis=-1,
    )
    points = np.concatenate([ring.reshape(-1, 3), [[0, 0, 1], [0, 0, -1]]])
    i, j = np.meshgrid(np.arange(rings - 2), np.arange(sectors), indexing="ij")
    a, b = i * sectors + j, i * sectors + (j + 1) % sectors
    c, d = a + sectors, b + sectors
    j = np.arange(sectors)
    top = np.stack([np.full(sectors, len(points) - 2), j, (j + 1) % sectors], axis=1)
    last = (rings - 2) * sectors
    bottom = np.stack([np.full(sectors, len(points) - 1), last + (j + 1) % sectors, last + j], 1)
    quads = [np.stack([a, c, b], -1).reshape(-1, 3), np.stack([b, c, d], -1).reshape(-1, 3)]
    return points, np.concatenate([*quads, top, bottom])


def test_no_ray_slips_between_the_triangles_of_a_closed_surface() -> None:
    pytest.importorskip("embreex")
    points, triangles = sphere()
    caster = RayCaster(points + 1000.0, triangles)
    middles = (points[triangles] + points[np.roll(triangles, 1, axis=1)]).reshape(-1, 3) / 2
    towards = np.concatenate([points, middles])  # exactly along vertices and edges
    hits = caster.first_hit(np.full(3, 1000.0), towards)
    assert hits.hit.all()
    # A ray at an edge may be given to either neighbour; their planes meet there.
    np.testing.assert_allclose(hits.distance, np.linalg.norm(towards, axis=1), rtol=1e-5)


def test_a_ray_from_very_far_away_keeps_its_precision(backend: str) -> None:
    points = np.array([[-1.0, -1, 0], [1, -1, 0], [0, 2, 0]])
    caster = RayCaster(points, [[0, 1, 2]])
    hits = caster.first_hit([0.0, 0.0, 1.0e7], [[0.0, 0, -1], [0, 0, 1], [1.0, 0, -1]])
    np.testing.assert_allclose(hits.distance, [1.0e7, np.inf, np.inf], rtol=1e-12)
    np.testing.assert_array_equal(
        caster.occluded([0.0, 0, 1.0e7], [[0.0, 0, -1]] * 2, [0.999e7, 1.001e7]), [False, True]
    )


def test_rays_from_very_far_away_meet_what_they_aim_at(backend: str) -> None:
    points, triangles = soup(3)
    rng = np.random.default_rng(4)
    weights = rng.dirichlet([3.0, 3.0, 3.0], len(triangles))
    targets = np.einsum("tc,tci->ti", weights, points[triangles])
    away = rng.normal(size=targets.shape)
    origins = targets + 1.0e6 * away / np.linalg.norm(away, axis=1, keepdims=True)
    caster = RayCaster(points, triangles)
    hits = caster.first_hit(origins, targets - origins)
    assert hits.hit.all()
    assert (hits.distance <= 1.0e6 + 1e-6).all()
    itself = hits.triangle == np.arange(len(triangles))
    assert itself.sum() > 20
    np.testing.assert_allclose(hits.distance[itself], 1.0e6, atol=1e-6)


def test_rays_without_a_direction_meet_nothing(backend: str) -> None:
    points = np.array([[-1.0, -1, 1], [1, -1, 1], [0, 2, 1]])
    caster = RayCaster(points, [[0, 1, 2]])
    directions = [[0.0, 0, 0], [np.nan, 0, 1], [0, 0, np.inf], [0, 0, 1e-300], [0, 0, 1e300]]
    hits = caster.first_hit(np.zeros(3), directions)
    np.testing.assert_array_equal(hits.triangle, [-1, -1, -1, 0, 0])
    np.testing.assert_allclose(hits.distance[3:], 1.0)
    np.testing.assert_array_equal(
        caster.occluded(np.zeros(3), directions), [False, False, False, True, True]
    )


def test_an_empty_scene_and_no_rays(backend: str) -> None:
    empty = RayCaster(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32))
    assert not empty.first_hit(np.zeros((2, 3)), np.ones((2, 3))).hit.any()
    assert not empty.occluded(np.zeros((2, 3)), np.ones((2, 3))).any()
    points, triangles = soup(1, 3)
    assert RayCaster(points, triangles).first_hit(np.zeros((0, 3)), np.zeros((0, 3))).hit.size == 0


def test_nonsense_is_refused() -> None:
    with pytest.raises(InputError, match="finite"):
        RayCaster([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    with pytest.raises(InputError, match="does not exist"):
        RayCaster([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 3]])


def test_without_any_tracer_the_error_names_the_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in ("embreex", "embreex.mesh_construction", "embreex.rtcore_scene", "rtree"):
        monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingPackageError, match="embreex"):
        RayCaster([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
