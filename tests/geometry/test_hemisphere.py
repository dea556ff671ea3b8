"""Cells of direction: sizes, frames, cosine integrals and what bounds them."""

import numpy as np
import pytest

from openrooms_usd.geometry.hemisphere import (
    HEMISPHERE,
    PANORAMA,
    HemisphereGrid,
    cosine_weights,
    irradiance,
    irradiance_bound,
    surface_frames,
    tiled,
    untiled,
)
from openrooms_usd.library.surroundings import environments

RIGHT, UP, FORWARD = np.eye(3)[0], np.array([0.0, 0, 1]), np.array([0.0, 1, 0])


def test_cells_cover_the_hemisphere_and_the_sphere() -> None:
    assert HEMISPHERE.solid_angles.sum() * 32 == pytest.approx(2 * np.pi, rel=1e-14)
    assert HemisphereGrid(64, 128, np.pi).solid_angles.sum() * 128 == pytest.approx(
        4 * np.pi, rel=1e-14
    )
    # The released tables' sin theta pi^2 / (16 32) is the same but for the size of a cell.
    theta = (np.arange(16) + 0.5) / 16 * np.pi / 2
    np.testing.assert_allclose(HEMISPHERE.solid_angles, np.sin(theta) * np.pi**2 / 512, rtol=2e-3)


def test_directions_are_those_of_the_definition() -> None:
    for row, column in [(0, 0), (3, 17), (15, 31)]:
        theta, phi = (row + 0.5) / 16 * np.pi / 2, ((column + 0.5) / 32 - 0.5) * 2 * np.pi
        wanted = [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
        np.testing.assert_allclose(HEMISPHERE.directions[row, column], wanted, atol=1e-15)


def test_a_surface_that_faces_the_camera_has_x_to_the_left_and_y_up() -> None:
    ((x, y, n),) = surface_frames(-FORWARD[None], UP, FORWARD)
    np.testing.assert_allclose([x, y, n], [-RIGHT, UP, -FORWARD], atol=1e-15)
    assert np.linalg.det([x, y, n]) == pytest.approx(-1.0)


def test_a_floor_under_a_level_camera_is_the_limit_of_cameras_that_look_down() -> None:
    down = 1e-3
    tilted = np.array([0, np.cos(down), -np.sin(down)]), np.array([0, np.sin(down), np.cos(down)])
    normal = np.array([[0.0, 0, 1], [0, 0, -1]])
    level = surface_frames(normal, UP, FORWARD)
    np.testing.assert_allclose(surface_frames(normal, tilted[1], tilted[0]), level, atol=1e-6)
    np.testing.assert_allclose(level @ np.swapaxes(level, 1, 2), [np.eye(3)] * 2, atol=1e-15)


def test_even_light_gives_pi_times_its_radiance() -> None:
    light = np.broadcast_to([1.0, 20.0, 300.0], (2, 16, 32, 3))
    np.testing.assert_allclose(irradiance(light), np.pi * light[:, 0, 0], rtol=1e-14)


def test_no_light_within_the_cells_is_beyond_the_bound_and_beams_reach_it() -> None:
    rng = np.random.default_rng(2)
    beams = 4000
    z, phi = rng.random(beams), rng.uniform(-np.pi, np.pi, beams)
    power = rng.random(beams) ** 8
    # The true irradiance of beams, and the cells' means.
    rows = np.minimum((np.arccos(z) * 32 / np.pi).astype(int), 15)
    columns = np.minimum(((phi / (2 * np.pi) + 0.5) * 32).astype(int), 31)
    for some in (slice(0, 3), slice(0, 40), slice(0, beams)):
        cells = np.zeros((16, 32, 1))
        np.add.at(cells, (rows[some], columns[some], 0), power[some])
        cells /= HEMISPHERE.solid_angles[:, None, None]
        off = abs(irradiance(cells)[0] - power[some] @ z[some])
        assert off <= irradiance_bound(cells)[0]
    edge = np.zeros((16, 32, 1))
    edge[15, 4] = 7.0 / HEMISPHERE.solid_angles[15]
    assert irradiance(edge)[0] - irradiance_bound(edge)[0] == pytest.approx(0.0, abs=1e-12)
    assert (irradiance(edge) + irradiance_bound(edge))[0] == pytest.approx(
        7.0 * np.sin(np.pi / 32), rel=1e-12
    )


def test_tiles_are_the_released_layout() -> None:
    grid = np.random.default_rng(0).random((3, 4, 16, 32, 3)).astype(np.float32)
    picture = tiled(grid)
    assert picture[2 * 16 + 5, 3 * 32 + 7].tolist() == grid[2, 3, 5, 7].tolist()
    # How the released loaders take it apart.
    np.testing.assert_array_equal(picture.reshape(3, 16, 4, 32, 3).transpose(0, 2, 1, 3, 4), grid)
    np.testing.assert_array_equal(untiled(picture), grid)


def test_panoramas_are_laid_out_as_skies_are() -> None:
    ours = HemisphereGrid(32, 64, np.pi).directions @ PANORAMA
    np.testing.assert_allclose(ours, environments.directions(32), atol=1e-12)


def test_cosine_weights_of_a_panorama() -> None:
    cells = HemisphereGrid(128, 256, np.pi)
    for normal in ([0, 0, 1.0], [0.6, 0, 0.8], [0, -1.0, 0]):
        assert cosine_weights(cells, normal).sum() == pytest.approx(np.pi, rel=1e-3)
