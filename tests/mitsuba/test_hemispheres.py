"""Environment maps of pixels: even light, a lamp in its cell, and the irradiance of other code."""

from typing import Any

import numpy as np
import pytest
from pxr import Gf, UsdLux

from openrooms_usd.geometry.hemisphere import HEMISPHERE, irradiance, irradiance_bound, untiled
from openrooms_usd.usd.lights import define_mesh_light

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


def facing_wall(build: Any, lamp_at: tuple[float, float, float], size: float) -> Any:
    """A black wall at y = 3 that a camera at 0 faces, and a small lamp between that faces it."""
    room = build()
    black = room.material("/Black", base_color=(0.0, 0.0, 0.0))
    wall = [(-1, 3, -1), (1, 3, -1), (1, 3, 1), (-1, 3, 1)]
    room.quad("/Wall", wall, material=black)
    x, y, z = lamp_at
    corners = [(x - size, y, z - size), (x - size, y, z + size), (x + size, y, z + size),
               (x + size, y, z - size)]  # fmt: skip
    define_mesh_light(room.quad("/Lamp", corners, material=black).GetPrim(), nits=NITS)
    room.camera((0, 0, 0), (0, 3, 0), fov=0.1, aspect=1.0)
    return room.stage, np.array(corners, dtype=float)


def test_even_light_fills_every_cell(build: Any, lit: Any) -> None:
    room = build()
    room.quad("/Card", [(-1, 3, -1), (1, 3, -1), (1, 3, 1), (-1, 3, 1)])
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
def test_a_small_lamp_is_in_its_cell(
    build: Any, lit: Any, lamp_at: tuple[float, float, float]
) -> None:
    stage, corners = facing_wall(build, lamp_at, 0.01)
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


def test_light_from_behind_the_surface_does_not_arrive(build: Any, lit: Any) -> None:
    stage, _ = facing_wall(build, (0.4, 3.5, 0.3), 0.2)
    assert not integrator_of(lit(stage), (1, 1))(2, 0).any()


@pytest.mark.parametrize("behind", [True, False])
def test_where_normals_lean_light_from_behind_the_face_does_not_arrive(
    build: Any, lit: Any, behind: bool
) -> None:
    """A normal that leans by 60 degrees has directions above it that are behind the surface."""
    room = build()
    black = room.material("/Black", base_color=(0.0, 0.0, 0.0))
    corners = [(-1, 3, -1), (1, 3, -1), (1, 3, 1), (-1, 3, 1)]
    wall = room.quad("/Wall", corners, material=black)
    wall.CreateNormalsAttr([Gf.Vec3f(0.866, -0.5, 0.0)] * 4)
    wall.SetNormalsInterpolation("vertex")
    x, y = 2.0, 3.5 if behind else 2.5
    lamp = [(x, y - 0.2, -0.2), (x, y - 0.2, 0.2), (x, y + 0.2, 0.2), (x, y + 0.2, -0.2)]
    define_mesh_light(room.quad("/Lamp", lamp, material=black).GetPrim(), nits=NITS)
    room.camera((0, 0, 0), (0, 3, 0), fov=0.1, aspect=1.0)
    arriving = integrator_of(lit(room.stage), (1, 1))(8, 0)
    assert arriving.any() != behind


def convex_room(build: Any) -> Any:
    """A grey room with a lamp on its ceiling and a parallel beam that its open front lets in."""
    room = build()
    grey = room.material("/Grey", base_color=(0.6, 0.5, 0.4))
    room.box("/Room", 2.0, inside=True, material=grey)
    lamp = [(-0.2, -0.1, 0.98), (-0.2, 0.3, 0.98), (0.2, 0.3, 0.98), (0.2, -0.1, 0.98)]
    define_mesh_light(room.quad("/Lamp", lamp, material=grey).GetPrim(), nits=NITS)
    return room


@pytest.mark.parametrize(
    "target",
    [
        (0.3, 0.2, -1.0),
        pytest.param((0.99, 0.1, 0.2), marks=pytest.mark.slow),
        pytest.param((0.9, 0.95, 0.9), marks=pytest.mark.slow),
    ],
)
def test_cells_times_cosine_are_irradiance(
    build: Any, lit: Any, target: tuple[float, float, float]
) -> None:
    from orusd_mitsuba.transport.path_integrator import PathIntegrator

    room = convex_room(build)
    room.camera((-0.5, -0.6, 0.1), target, fov=0.05, aspect=1.0)
    made = lit(room.stage)
    integrator = integrator_of(made, (1, 1))
    white = PathIntegrator(
        made.built, made.index, made.camera(4, 4), 4, 4, made.scene.origin, 8, by_light=False,
        first=made.first,
    )  # fmt: skip
    ours = np.array([[irradiance(untiled(p))[0, 0] for p in integrator(8, s)] for s in range(8)])
    theirs = np.pi * np.array([white(128, 90 + s).mean(axis=(1, 2)) for s in range(8)])
    theirs = np.stack([theirs[:, 1], theirs[:, 1] + theirs[:, 2]], axis=1)
    bound = np.array([irradiance_bound(untiled(p))[0, 0] for p in integrator(8, 20)])
    spread = np.sqrt((ours.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / 8)
    off = np.abs(ours.mean(axis=0) - theirs.mean(axis=0))
    assert (off <= bound + 4.0 * spread).all(), (ours.mean(axis=0), theirs.mean(axis=0), bound)
    # The bound says something, and light does arrive by way of the walls.
    assert (bound < 0.2 * ours.mean(axis=0)).all()
    assert (ours.mean(axis=0)[1] > 1.1 * ours.mean(axis=0)[0]).all()


def test_parallel_light_falls_into_one_cell_with_all_that_it_brings(build: Any, lit: Any) -> None:
    room = build()
    room.quad("/Wall", [(-1, 3, -1), (1, 3, -1), (1, 3, 1), (-1, 3, 1)])
    sun = UsdLux.DistantLight.Define(room.stage, "/Sun")
    sun.CreateIntensityAttr(1.0)
    sun.CreateAngleAttr(0.0)
    sun.AddRotateXYZOp().Set((60.0, 0.0, 20.0))
    room.camera((0, 0, 0), (0, 3, 0), fov=0.1, aspect=1.0)
    made = lit(room.stage)
    (cells,) = untiled(integrator_of(made, (1, 1))(1, 0)[0])[0]
    (sun_found,) = made.scene.suns
    lit_cells = np.argwhere(cells[..., 1] > 0)
    assert len(lit_cells) == 1
    row, _ = lit_cells[0]
    brought = cells[..., 1].sum() * HEMISPHERE.solid_angles[row]
    assert brought == pytest.approx(sun_found.irradiance[1], rel=1e-4)


def test_equal_seeds_give_equal_bits_and_others_do_not(build: Any, lit: Any) -> None:
    room = convex_room(build)
    room.camera((-0.5, -0.6, 0.1), (0.3, 0.2, -1.0), fov=40.0)
    integrator = integrator_of(lit(room.stage))
    assert integrator.size == (3 * 16, 4 * 32)
    assert integrator(2, 5).tobytes() == integrator(2, 5).tobytes()
    assert integrator(2, 5).tobytes() != integrator(2, 6).tobytes()


def test_where_nothing_is_seen_nothing_arrives(build: Any, lit: Any) -> None:
    room = build()
    room.quad("/Card", [(-1, 3, -1), (0, 3, -1), (0, 3, 1), (-1, 3, 1)])
    room.dome(radiance=NITS)
    room.camera((0, 0, 0), (0, 3, 0), fov=30.0)
    grid = untiled(integrator_of(lit(room.stage))(1, 0)[1])
    assert grid[:, :2].any(axis=(2, 3, 4)).all()
    assert not grid[:, 2:].any()


def test_intrinsics_of_a_coarse_grid_see_the_same_corners(build: Any, lit: Any) -> None:
    from orusd_mitsuba.transport.hemispheres import coarse

    room = convex_room(build)
    room.camera((-0.5, -0.6, 0.1), (0.3, 0.2, -1.0), fov=40.0)
    camera = lit(room.stage).camera(640, 480)
    K = coarse(camera, (640, 480), (16, 12))
    for u, v in [(0.0, 0.0), (1.0, 1.0), (0.25, 0.75)]:
        fine = np.linalg.solve(camera.K, [640 * u, 480 * v, 1])
        np.testing.assert_allclose(np.linalg.solve(K, [16 * u, 12 * v, 1]), fine, atol=1e-12)
