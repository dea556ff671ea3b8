"""Environment maps of pixels: even light, a lamp in its cell, and the irradiance of other code."""

from typing import Any

import numpy as np
import pytest
from pxr import Gf

from openrooms_usd.geometry.hemisphere import HEMISPHERE, irradiance, untiled
from tests import small
from tests.small import square

NITS = 1000.0


def integrator_of(lit: Any, grid: tuple[int, int] = (4, 3), depth: int = 8, **how: Any) -> Any:
    from orusd_mitsuba.tracer import MitsubaTracer
    from orusd_mitsuba.transport.hemispheres import HemisphereIntegrator

    tracer = MitsubaTracer(lit.scene, lit.built)
    camera = lit.camera(*grid)
    return HemisphereIntegrator(lit.scene, lit.built, lit.index, tracer, camera, grid, depth, **how)


def solid_angle(triangle: np.ndarray, at: np.ndarray) -> float:
    """Van Oosterom and Strackee 1983."""
    a, b, c = (v / np.linalg.norm(v) for v in triangle - at)
    return abs(2 * np.arctan2(np.dot(a, np.cross(b, c)), 1 + a @ b + b @ c + c @ a))


def facing_wall(lamp_at: tuple[float, float, float], size: float) -> Any:
    """A black wall at y = 3 that a camera at 0 faces, and a small lamp between that faces it."""
    room = small.Stage()
    black = room.material("/Black", base_color=(0.0, 0.0, 0.0))
    wall = square((0, 3, 0), 1, "-Y")
    room.quad("/Wall", wall, material=black)
    corners = square(lamp_at, size, "+Y")
    room.quad("/Lamp", corners, material=black, nits=NITS)
    room.camera((0, 0, 0), (0, 3, 0), fov=0.1, aspect=1.0)
    return room.stage, corners


def test_even_light_fills_every_cell(lit: Any) -> None:
    room = small.Stage()
    room.quad("/Card", square((0, 3, 0), 1, "-Y"))
    room.dome(radiance=NITS)
    room.camera((0, 0, 0), (0.3, 3, 0.2), fov=20.0)
    integrator = integrator_of(lit(room.stage))
    passes = np.stack([integrator(4, seed) for seed in range(8)])
    for plane in np.moveaxis(passes, 1, 0):
        grids = np.stack([untiled(picture) for picture in plane])
        over_points = grids.mean(axis=(0, 1, 2))
        np.testing.assert_allclose(over_points, NITS, rtol=0.1)
        assert over_points.mean() == pytest.approx(NITS, rel=2e-3)
        np.testing.assert_allclose(irradiance(grids.mean(axis=0)), np.pi * NITS, rtol=0.01)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("lamp_at", [(-0.62, 2.0, 0.35), (0.5, 2.45, 0.3), (0.1, 1.0, -0.3)])
def test_a_small_lamp_is_in_its_cell(lit: Any, lamp_at: tuple[float, float, float]) -> None:
    stage, corners = facing_wall(lamp_at, 0.01)
    picture = np.mean([integrator_of(lit(stage), (1, 1))(4, seed)[0] for seed in range(4)], axis=0)
    (cells,) = untiled(picture)[0]
    # Seen from the wall's middle: x is the camera's left, y its up, z towards the camera.
    to = np.array(lamp_at) - [0, 3, 0]
    left, up, out = -to[0], to[2], -to[1]
    theta, phi = np.arctan2(np.hypot(left, up), out), np.arctan2(up, left)
    row, column = int(theta / (np.pi / 32)), int((phi / (2 * np.pi) + 0.5) * 32)
    at = np.array([0.0, 3, 0])
    size = solid_angle(corners[[0, 1, 2]], at) + solid_angle(corners[[0, 2, 3]], at)
    share = NITS * size / HEMISPHERE.solid_angles[row]
    assert cells[row, column, 0] == pytest.approx(share, rel=0.03)
    cells[row, column] = 0.0
    assert not cells.any()


def test_light_from_behind_the_surface_does_not_arrive(lit: Any) -> None:
    stage, _ = facing_wall((0.4, 3.5, 0.3), 0.2)
    assert not integrator_of(lit(stage), (1, 1))(2, 0).any()


@pytest.mark.parametrize("behind", [True, False])
def test_where_normals_lean_light_from_behind_the_face_does_not_arrive(
    lit: Any, behind: bool
) -> None:
    """A normal that leans by 60 degrees has directions above it that are behind the surface."""
    room = small.Stage()
    black = room.material("/Black", base_color=(0.0, 0.0, 0.0))
    corners = square((0, 3, 0), 1, "-Y")
    wall = room.quad("/Wall", corners, material=black)
    wall.CreateNormalsAttr([Gf.Vec3f(0.866, -0.5, 0.0)] * 4)
    wall.SetNormalsInterpolation("vertex")
    lamp = square((2, 3.5 if behind else 2.5, 0), 0.2, "-X")
    room.quad("/Lamp", lamp, material=black, nits=NITS)
    room.camera((0, 0, 0), (0, 3, 0), fov=0.1, aspect=1.0)
    arriving = integrator_of(lit(room.stage), (1, 1))(8, 0)
    assert arriving.any() != behind


def test_parallel_light_falls_into_one_cell_with_all_that_it_brings(lit: Any) -> None:
    room = small.Stage()
    room.quad("/Wall", square((0, 3, 0), 1, "-Y"))
    room.light("Distant", "/Sun", 1.0, turn=(60.0, 0.0, 20.0), angle=0.0)
    room.camera((0, 0, 0), (0, 3, 0), fov=0.1, aspect=1.0)
    made = lit(room.stage)
    (cells,) = untiled(integrator_of(made, (1, 1))(1, 0)[0])[0]
    (sun_found,) = made.scene.suns
    lit_cells = np.argwhere(cells[..., 1] > 0)
    assert len(lit_cells) == 1
    row, _ = lit_cells[0]
    brought = cells[..., 1].sum() * HEMISPHERE.solid_angles[row]
    assert brought == pytest.approx(sun_found.irradiance[1], rel=1e-4)


def test_where_nothing_is_seen_nothing_arrives(lit: Any) -> None:
    room = small.Stage()
    room.quad("/Card", square((-0.5, 3, 0), (1, 0.5), "-Y"))
    room.dome(radiance=NITS)
    room.camera((0, 0, 0), (0, 3, 0), fov=30.0)
    grid = untiled(integrator_of(lit(room.stage))(1, 0)[1])
    assert grid[:, :2].any(axis=(2, 3, 4)).all()
    assert not grid[:, 2:].any()


def test_intrinsics_of_a_coarse_grid_see_the_same_corners(lit: Any) -> None:
    from orusd_mitsuba.transport.hemispheres import coarse

    room = small.room()
    room.camera((-0.5, -0.6, 0.1), (0.3, 0.2, -1.0), fov=40.0)
    camera = lit(room.stage).camera(640, 480)
    K = coarse(camera, (640, 480), (16, 12))
    for u, v in [(0.0, 0.0), (1.0, 1.0), (0.25, 0.75)]:
        fine = np.linalg.solve(camera.K, [640 * u, 480 * v, 1])
        np.testing.assert_allclose(np.linalg.solve(K, [16 * u, 12 * v, 1]), fine, atol=1e-12)
