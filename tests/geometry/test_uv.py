"""Coordinates in metres: projected where there are none, to scale where there are good ones."""

from dataclasses import replace

import numpy as np
import pytest

from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.solids import box, sphere
from openrooms_usd.geometry.uv import centred, cube_projection, metric
from openrooms_usd.geometry.uvquality import uv_quality


def _unwrapped_box(side: float) -> Mesh:
    """A cube whose six faces lie side by side in the unit square, as a modeller would do it."""
    mesh = cube_projection(box((side, side, side)))
    corner = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) / 3.0
    cells = np.array([[i % 3, i // 3] for i in range(6)]) / 3.0
    return replace(mesh, st=(corner + cells[:, None]).reshape(-1, 2).astype(np.float32))


@pytest.mark.parametrize("side", [1e-3, 0.7, 1e3])
def test_own_coordinates_are_kept_to_scale(side: float) -> None:
    own = _unwrapped_box(side)
    mesh, fault = metric(own)
    assert not fault
    assert mesh.st is not None and own.st is not None
    np.testing.assert_allclose(mesh.st, own.st * 3.0 * side, rtol=1e-5)
    assert uv_quality(mesh).density == pytest.approx(1.0, rel=1e-5)


def test_coordinates_that_are_already_metric_stay() -> None:
    mesh = cube_projection(box((1, 2, 3)))
    again, fault = metric(mesh)
    assert not fault
    np.testing.assert_allclose(again.st, mesh.st, atol=1e-6)  # type: ignore[arg-type]


@pytest.mark.parametrize("fill", [0.0, np.nan])
def test_useless_ones_are_replaced_with_a_reason(fill: float) -> None:
    mesh = sphere(1)
    bad = replace(mesh, st=np.full((len(mesh.indices), 2), fill, np.float32))
    mapped, fault = metric(bad)
    assert fault
    np.testing.assert_array_equal(mapped.st, cube_projection(mesh).st)  # type: ignore[arg-type]


def test_a_mesh_without_coordinates_gets_some_without_complaint() -> None:
    mesh, fault = metric(replace(sphere(1), st=None))
    assert mesh.st is not None and not fault


def test_faces_on_a_diagonal_keep_together_whatever_rounding_says() -> None:
    # A chamfer at 45 degrees in many quads whose normals differ by rounding.
    y = np.linspace(0.0, 1.0, 201)
    rng = np.random.default_rng(0)
    jitter = 1e-9 * rng.standard_normal((2, len(y)))
    low = np.stack([0 * y + jitter[0], y, 0 * y], axis=1)
    high = np.stack([0 * y - 0.1, y, 0 * y + 0.1 + jitter[1]], axis=1)
    i = np.arange(len(y) - 1)
    quads = np.stack([i, i + 1, i + 1 + len(y), i + len(y)], axis=1).reshape(-1)
    mesh = cube_projection(
        Mesh(np.concatenate([low, high]), np.full(200, 4, np.int32), quads.astype(np.int32))
    )
    assert mesh.st is not None
    st = mesh.st.reshape(-1, 4, 2)
    # Neighbours meet at the same coordinates: one projection for all.
    np.testing.assert_allclose(st[:-1, 1], st[1:, 0], atol=1e-6)
    np.testing.assert_allclose(st[:-1, 2], st[1:, 3], atol=1e-6)


@pytest.mark.slow
def test_a_million_triangles_some_of_them_degenerate() -> None:
    side = 708
    x, y = np.meshgrid(np.linspace(0, 1e3, side), np.linspace(0, 1e3, side), indexing="ij")
    points = np.stack([x, y, np.sin(x / 40.0) * np.cos(y / 30.0)], axis=-1).reshape(-1, 3)
    i = np.arange(side * side, dtype=np.int32).reshape(side, side)
    lower = np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:]], axis=-1).reshape(-1, 3)
    upper = np.stack([i[:-1, :-1], i[1:, 1:], i[:-1, 1:]], axis=-1).reshape(-1, 3)
    rows = np.concatenate([lower, upper, np.repeat(i[:400, :1], 3, axis=1)])
    assert len(rows) > 999_999
    mesh = cube_projection(Mesh(points, np.full(len(rows), 3, np.int32), rows.reshape(-1)))
    assert mesh.st is not None and np.isfinite(mesh.st).all()
    # All faces look up: the projection is the plan, and its area that of the plan.
    proper = slice(0, 3 * (len(lower) + len(upper)))
    plan = mesh.points[mesh.indices[proper], :2]
    np.testing.assert_allclose(mesh.st[proper], plan, rtol=1e-6)
    quality = uv_quality(mesh)
    assert quality.folded == 0.0
    assert quality.density == pytest.approx(np.sqrt(1e6 / mesh.areas().sum()), rel=1e-6)


def test_what_is_centred_is_cut_equally_at_its_edges() -> None:
    plate = Mesh(
        np.array([[1.0, 2.0, 0.0], [4.0, 2.0, 0.0], [4.0, 6.2, 0.0], [1.0, 6.2, 0.0]]),
        np.array([4], dtype=np.int32),
        np.arange(4, dtype=np.int32),
        st=np.array([[1, 2], [4, 2], [4, 6.2], [1, 6.2]], dtype=np.float32),
    )
    middle, risen = centred(plate), centred(plate, along=False)
    assert middle.st is not None and risen.st is not None
    np.testing.assert_allclose(middle.st.min(axis=0), -middle.st.max(axis=0), atol=1e-6)
    np.testing.assert_allclose(np.ptp(middle.st, axis=0), (3.0, 4.2), rtol=1e-6)
    assert risen.st[:, 1].min() == 0.0 and risen.st[:, 0].max() == pytest.approx(1.5)
