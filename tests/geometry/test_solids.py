"""Solids against closed forms: volume, area, extent; closed, wound and mapped as promised."""

import numpy as np
import pytest

from openrooms_usd.geometry.curves import filleted, rectangle, signed_area
from openrooms_usd.geometry.mesh import Mesh
from openrooms_usd.geometry.normals import face_vectors
from openrooms_usd.geometry.solids import (
    box,
    cushion,
    cylinder,
    frustum,
    lathe,
    rounded_box,
    sphere,
)
from openrooms_usd.geometry.sweeps import extrude, sheet, tube
from openrooms_usd.geometry.topology import is_closed

L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3)]


def _bent_grid() -> np.ndarray:
    v, u = np.meshgrid(np.linspace(0, 0.5, 7), np.linspace(-0.2, 0.2, 9), indexing="ij")
    return np.stack([u, 0.3 * u**2 + 0.5 * v**2, v], axis=-1)


SOLIDS = {
    "box": box((1, 2, 3)),
    "rounded box": rounded_box((1, 2, 3), 0.1, segments=2),
    "thin rounded box": rounded_box((1, 2, 0.004), 0.1),
    "cushion": cushion((0.6, 0.7, 0.2)),
    "cylinder": cylinder(0.5, 2),
    "bevelled cylinder": cylinder(0.5, 2, bevel=0.05),
    "cone": frustum(0.5, 0, 1),
    "frustum": frustum(0.2, 0.5, 1, bevel=0.01),
    "sphere": sphere(1, squash=0.5),
    "ring": lathe([(1, 0), (1.1, 0), (0.6, 1), (0.5, 1)]),
    "extrusion": extrude(L_SHAPE, 1.5),
    "bevelled extrusion": extrude(filleted(L_SHAPE, 0.1, closed=True), 0.5, bevel=0.02),
    "tube": tube(filleted([(0, 0, 0), (1, 0, 0), (1, 1, 0.5)], 0.3), 0.05),
    "ring tube": tube(
        filleted([(0, 0, 0), (1, 0, 0), (1, 1, 0)], 0.2, closed=True), 0.05, closed=True
    ),
    "sheet": sheet(_bent_grid(), 0.01),
}


def _regular_polygon(sides: int, radius: float) -> float:
    return 0.5 * sides * radius**2 * np.sin(2 * np.pi / sides)


def _st_areas(mesh: Mesh) -> np.ndarray:
    flat = np.concatenate([mesh.st, np.zeros((len(mesh.st), 1))], axis=1)
    loose = Mesh(flat, mesh.counts, np.arange(len(flat), dtype=np.int32))
    return np.linalg.norm(face_vectors(loose), axis=1)


@pytest.mark.parametrize("name", SOLIDS)
def test_closed_with_outward_unit_normals(name: str) -> None:
    mesh = SOLIDS[name]
    assert is_closed(mesh)
    assert mesh.volume() > 0
    assert np.abs(np.linalg.norm(mesh.normals, axis=1) - 1).max() < 1e-6
    faces = np.repeat(face_vectors(mesh), mesh.counts, axis=0)
    facing = np.einsum("ij,ij->i", faces, mesh.normals) / np.linalg.norm(faces, axis=1)
    assert facing.min() > np.cos(np.radians(40))


@pytest.mark.parametrize("name", SOLIDS)
def test_texture_coordinates_are_metres(name: str) -> None:
    mesh = SOLIDS[name]
    ratio = _st_areas(mesh) / mesh.areas()
    assert np.quantile(ratio, 0.05) > 0.45
    assert ratio.max() < 1.6
    assert _st_areas(mesh).sum() == pytest.approx(mesh.areas().sum(), rel=0.4)


def test_box_has_the_volume_and_area_of_a_box() -> None:
    mesh = box((1, 2, 3), center=(5, 0, 0))
    assert mesh.volume() == pytest.approx(6)
    assert mesh.areas().sum() == pytest.approx(22)
    np.testing.assert_allclose(mesh.extent, [[4.5, -1, -1.5], [5.5, 1, 1.5]])


def test_rounded_box_approaches_steiners_formula() -> None:
    # Core box grown by a ball of radius r: V + A r + pi r^2 sum(edges) / 4 * 4 + 4/3 pi r^3.
    r, core = 0.1, np.array([0.8, 1.8, 2.8])
    a, b, c = core
    exact = (
        a * b * c
        + 2 * r * (a * b + b * c + c * a)
        + np.pi * r**2 * (a + b + c)
        + 4 / 3 * np.pi * r**3
    )
    coarse, fine = (abs(rounded_box(core + 2 * r, r, segments=n).volume() - exact) for n in (2, 8))
    assert fine < 1e-3 * exact
    assert fine < 0.1 * coarse


@pytest.mark.parametrize("sides", [8, 33])
def test_cylinder_and_frustum_are_those_of_their_polygon(sides: int) -> None:
    assert cylinder(0.5, 2, segments=sides).volume() == pytest.approx(
        2 * _regular_polygon(sides, 0.5)
    )
    a, b = _regular_polygon(sides, 0.5), _regular_polygon(sides, 0.2)
    assert frustum(0.5, 0.2, 3, segments=sides).volume() == pytest.approx(
        (a + b + np.sqrt(a * b)) * 3 / 3
    )


def test_ring_follows_pappus() -> None:
    # A square of side 0.2 about radius 1: the polygon's circumference replaces the circle's.
    mesh = lathe([(0.9, 0), (1.1, 0), (1.1, 0.2), (0.9, 0.2)], segments=48)
    exact = (_regular_polygon(48, 1.1) - _regular_polygon(48, 0.9)) * 0.2
    assert mesh.volume() == pytest.approx(exact)


def test_profile_may_run_either_way() -> None:
    profile = np.array([(0.0, 0.0), (0.5, 0.0), (0.4, 1.0), (0.0, 1.0)])
    assert lathe(profile).volume() == pytest.approx(lathe(profile[::-1]).volume())


def test_sphere_converges_to_the_ball() -> None:
    assert sphere(1, segments=96).volume() == pytest.approx(4 / 3 * np.pi, rel=3e-3)


def test_cushion_fills_its_box_and_bulges() -> None:
    mesh = cushion((0.6, 0.7, 0.2), center=(1, 2, 3))
    np.testing.assert_allclose(mesh.extent, [[0.7, 1.65, 2.9], [1.3, 2.35, 3.1]], atol=1e-9)
    top = mesh.points[mesh.points[:, 2] > 3.0]
    rim = top[np.abs(top[:, 0] - 1) > 0.24][:, 2].max()
    assert mesh.extent[1, 2] - rim > 0.01


@pytest.mark.parametrize("polygon", [L_SHAPE, L_SHAPE[::-1]])
def test_extrusion_of_a_concave_polygon(polygon: list[tuple[float, float]]) -> None:
    mesh = extrude(polygon, 1.5, base=2.0)
    assert mesh.volume() == pytest.approx(4 * 1.5)
    assert mesh.areas().sum() == pytest.approx(2 * 4 + 1.5 * 10)
    assert mesh.extent[:, 2].tolist() == [2.0, 3.5]


def test_bevel_only_takes_material_away_at_the_rims() -> None:
    outline = filleted(rectangle(1, 0.6), 0.1, closed=True, segments=8)
    bevel = 0.02
    removed = abs(signed_area(outline)) * 0.3 - extrude(outline, 0.3, bevel=bevel).volume()
    rim = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1).sum()
    # Both rims lose (1 - pi / 4) r^2, a little more for the straight pieces of the arc.
    assert removed == pytest.approx(2 * rim * (1 - np.pi / 4) * bevel**2, rel=0.25)


def test_mitred_tube_has_the_volume_of_its_axis() -> None:
    path = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 2)]
    assert tube(path, 0.1, segments=12).volume() == pytest.approx(4 * _regular_polygon(12, 0.1))


def test_flat_sheet_is_a_board() -> None:
    v, u = np.meshgrid(np.linspace(0, 2, 5), np.linspace(0, 1, 4), indexing="ij")
    mesh = sheet(np.stack([u, v, 0 * u], axis=-1), 0.1)
    assert mesh.volume() == pytest.approx(0.2)
    np.testing.assert_allclose(mesh.extent, [[0, 0, -0.1], [1, 2, 0]], atol=1e-12)


def test_fillet_touches_its_sides() -> None:
    line = filleted([(0, 0), (1, 0), (1, 1)], 0.2, segments=16)
    np.testing.assert_allclose(line[1], [0.8, 0], atol=1e-12)
    np.testing.assert_allclose(line[-2], [1, 0.2], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(line[1:-1] - [0.8, 0.2], axis=1), 0.2, atol=1e-12)


def test_fillets_shrink_where_sides_are_short() -> None:
    square = filleted(rectangle(0.1, 0.1), 5.0, closed=True)
    assert np.abs(square).max() <= 0.05 + 1e-12
    assert signed_area(square) > 0


def test_an_open_mesh_is_not_closed() -> None:
    mesh = box((1, 1, 1))
    assert not is_closed(Mesh(mesh.points, mesh.counts[:-1], mesh.indices[:-4]))
    assert not is_closed(Mesh(mesh.points, mesh.counts, np.roll(mesh.indices, 1)))
