"""Spherical harmonics against their formulas, quadrature and the irradiance that they give."""

import numpy as np
import pytest
from scipy.special import sph_harm_y

from openrooms_usd.geometry import spherical_harmonics as sh
from openrooms_usd.geometry.hemisphere import HEMISPHERE, PANORAMA, HemisphereGrid, irradiance

SPHERE = HemisphereGrid(48, 96, np.pi)


def unit(count: int, seed: int = 0) -> np.ndarray:
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def test_the_first_nine_are_those_of_the_engines() -> None:
    d = unit(50)
    x, y, z = d.T
    wanted = [
        0.282095 + 0 * x,
        0.488603 * y,
        0.488603 * z,
        0.488603 * x,
        1.092548 * x * y,
        1.092548 * y * z,
        0.315392 * (3 * z * z - 1),
        1.092548 * x * z,
        0.546274 * (x * x - y * y),
    ]
    np.testing.assert_allclose(sh.basis(d, 2), np.stack(wanted, axis=-1), atol=2e-6)


def test_higher_ones_are_scipys_without_the_phase() -> None:
    d = unit(50)
    theta, phi = np.arccos(d[:, 2]), np.arctan2(d[:, 1], d[:, 0])
    found = sh.basis(d, 4)
    for n in range(5):
        for m in range(-n, n + 1):
            value = sph_harm_y(n, abs(m), theta, phi) * (-1) ** m
            part = value.real if m >= 0 else value.imag
            wanted = part * (np.sqrt(2) if m else 1.0)
            np.testing.assert_allclose(found[:, n * n + n + m], wanted, atol=1e-12)


def test_cell_integrals_are_those_of_a_fine_quadrature() -> None:
    fine = HemisphereGrid(16 * 40, 32 * 40, np.pi / 2)
    values = sh.basis(fine.directions[:, :80], 4) * fine.solid_angles[:, None, None]
    blocks = values.reshape(16, 40, 2, 40, 25).sum(axis=(1, 3))
    exact = sh.cell_integrals(HEMISPHERE, 4).reshape(16, 32, 25)[:, :2]
    np.testing.assert_allclose(blocks, exact, atol=2e-6)


@pytest.mark.parametrize("order", [2, 4])
def test_light_of_no_higher_degree_is_found_exactly(order: int) -> None:
    wanted = np.random.default_rng(1).normal(size=((order + 1) ** 2, 3))
    sizes = np.repeat(SPHERE.solid_angles, SPHERE.columns)[:, None]
    means = (sh.cell_integrals(SPHERE, order) / sizes) @ wanted
    found = sh.project(means.reshape(48, 96, 3), SPHERE, order)
    np.testing.assert_allclose(found, wanted, atol=1e-12)


def test_turning_axes_keeps_the_light() -> None:
    local = np.random.default_rng(3).normal(size=(25, 3))
    world = sh.turned(local, PANORAMA)
    d = unit(40)
    np.testing.assert_allclose(
        sh.basis(d, 4) @ world, sh.basis(d @ PANORAMA.T, 4) @ local, atol=1e-12
    )


def test_irradiance_is_the_cosine_integral() -> None:
    coefficients = np.random.default_rng(4).normal(size=(25, 1))
    fine = HemisphereGrid(200, 400, np.pi)
    light = (sh.basis(fine.directions, 4) @ coefficients)[..., 0] * fine.solid_angles[:, None]
    for normal in unit(6, seed=9):
        wanted = (np.maximum(0, fine.directions @ normal) * light).sum()
        found = (sh.basis(normal, 4) @ sh.irradiance(coefficients))[0]
        assert found == pytest.approx(wanted, abs=2e-3)


def test_even_light_has_one_coefficient() -> None:
    found = sh.project(np.ones((48, 96, 1)), SPHERE, 3)[:, 0]
    assert found[0] == pytest.approx(np.sqrt(4 * np.pi))
    np.testing.assert_allclose(found[1:], 0, atol=1e-12)
    assert (sh.basis([0, 0, 1.0], 3) @ sh.irradiance(found[:, None]))[0] == pytest.approx(np.pi)


def test_a_hemisphere_gives_about_its_irradiance_at_the_normal() -> None:
    light = np.random.default_rng(5).random((7, 16, 32, 3))
    found = sh.irradiance(sh.project(light, HEMISPHERE, 4))
    at_normal = np.einsum("k,pkc->pc", sh.basis([0, 0, 1.0], 4), found)
    np.testing.assert_allclose(at_normal, irradiance(light), rtol=0.02)
