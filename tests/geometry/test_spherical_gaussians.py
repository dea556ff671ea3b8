"""Fits by spherical Gaussians: mixtures are found again, irradiance is kept."""

import os
import subprocess
import sys

import numpy as np
import pytest

from openrooms_usd.geometry import lobe_refinement
from openrooms_usd.geometry import spherical_gaussians as sg
from openrooms_usd.geometry.hemisphere import HEMISPHERE, irradiance, spherical
from openrooms_usd.geometry.lobe_pursuit import CELLS


def mixtures(points: int, lobes: int, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    made = np.zeros((points, lobes, 6), np.float32)
    made[..., 0] = rng.uniform(0.0, 1.3, (points, lobes))
    made[..., 1] = rng.uniform(-3.0, 3.0, (points, lobes))
    made[..., 2] = np.exp(rng.uniform(np.log(2.0), np.log(50.0), (points, lobes)))
    made[..., 3:] = rng.uniform(50.0, 1000.0, (points, lobes, 3))
    return made


def by_formula(lobes: np.ndarray) -> np.ndarray:
    light = np.zeros((16, 32, 3))
    for theta, phi, sharpness, *color in lobes.astype(float):
        axis = [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)]
        shape = np.exp(sharpness * (HEMISPHERE.directions @ axis - 1.0))
        light += shape[..., None] * color
    return light


def test_lobes_are_evaluated_by_the_formula() -> None:
    lobes = mixtures(2, 3)
    np.testing.assert_allclose(sg.evaluate(lobes)[1], by_formula(lobes[1]), rtol=1e-4)


def test_mixtures_of_few_lobes_are_found_again() -> None:
    light = np.stack([by_formula(lobes) for lobes in mixtures(12, 3)])
    error = sg.error(light, sg.fit(light))
    assert np.median(error) < 0.025
    assert error.max() < 0.05


def test_a_single_lobe_is_found_by_number() -> None:
    lobe = np.array([[[0.7, -2.0, 20.0, 100.0, 200.0, 50.0]]], np.float32)
    light = by_formula(lobe[0])[None]
    found = sg.fit(light, lobes=1)[0, 0]
    np.testing.assert_allclose(found, lobe[0, 0], rtol=2e-2)


def test_fits_keep_irradiance_and_their_bounds() -> None:
    rng = np.random.default_rng(7)
    light = rng.random((2, 3, 16, 32, 3)) ** 4 * 500.0
    light[0, 0, 3, 5] = 1e9  # the sun in a window
    light[1, 1] = 0.0  # where nothing is seen
    found = sg.fit(light)
    assert found.shape == (2, 3, 12, 6)
    assert np.isfinite(found).all()
    assert (found[..., 0] <= np.float32(np.pi / 2)).all()
    assert (found[..., 2:] >= 0.0).all()
    assert not found[1, 1, :, 3:].any()
    np.testing.assert_allclose(irradiance(sg.evaluate(found)), irradiance(light), rtol=1e-4)


def test_irradiance_is_brought_at_the_least_cost() -> None:
    """As by Lagrange's multiplier."""
    rng = np.random.default_rng(3)
    made = mixtures(8, 4, seed=2)
    axes = spherical(made[..., 0], made[..., 1]).astype(np.float32)
    shapes = np.exp(made[..., 2:3] * (axes @ CELLS.T - 1.0)).astype(float)
    light = np.swapaxes(shapes, 1, 2) @ made[..., 3:] / 100.0 + rng.random((8, 512, 3))
    root, room = np.full((8, 512), 0.1, np.float32), np.empty((8, 16, 512), np.float32)
    target = (0.1 * light).astype(np.float32)
    found = lobe_refinement._colored(
        axes, made[..., 2], np.zeros_like(axes), target, root, room, 400
    )
    each = irradiance(np.moveaxis(shapes.reshape(8, 4, 16, 32), 1, -1))
    wanted = irradiance(light.reshape(8, 16, 32, 3))
    colors = sg._carrying(found, wanted.astype(np.float32))
    for point in range(8):
        gram = shapes[point] @ shapes[point].T
        system = np.block([[gram, each[point, :, None]], [each[point, None], np.zeros((1, 1))]])
        right = np.concatenate([shapes[point] @ light[point], wanted[point, None]])
        best = np.linalg.solve(system, right)[:4]
        assert best.min() > 0.0
        np.testing.assert_allclose(colors[point], best, rtol=0.01)


def test_more_lobes_leave_less() -> None:
    light = np.stack([by_formula(lobes) for lobes in mixtures(6, 12, seed=3)])
    few, many = (np.median(sg.error(light, sg.fit(light, lobes=count))) for count in (2, 12))
    assert many < 0.3 * few
    assert many < 0.05


def test_each_point_is_fitted_by_itself() -> None:
    light = np.stack([by_formula(lobes) for lobes in mixtures(5, 3)])
    alone = np.concatenate([sg.fit(one[None]) for one in light])
    assert sg.error(light, alone) == pytest.approx(sg.error(light, sg.fit(light)), abs=5e-3)


@pytest.mark.slow
def test_any_number_of_threads_gives_equal_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    light = np.random.default_rng(1).random((150, 16, 32, 3)) ** 3
    found = []
    for threads in (1, 3):
        monkeypatch.setattr(sg.os, "cpu_count", lambda threads=threads: threads)
        found.append(sg.fit(light, lobes=4).tobytes())
    assert found[0] == found[1]


def test_any_number_of_threads_of_the_matrix_products_gives_equal_bits() -> None:
    code = (
        "import numpy as np, sys; from openrooms_usd.geometry import spherical_gaussians as sg;"
        "light = np.random.default_rng(1).random((70, 16, 32, 3)) ** 3;"
        "sys.stdout.buffer.write(sg.fit(light).tobytes())"
    )
    found = [
        subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"OPENBLAS_NUM_THREADS": threads},
            capture_output=True,
            check=True,
        ).stdout
        for threads in ("1", "2")
    ]
    assert found[0]
    assert found[0] == found[1]


def test_steps_leave_less_than_the_set_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps lower what is left, weighed as the fit weighs it."""
    light = np.stack([by_formula(lobes) for lobes in mixtures(20, 8, seed=5)])
    grey = light @ [0.2126, 0.7152, 0.0722]
    sizes = np.broadcast_to(HEMISPHERE.solid_angles[:, None], (16, 32))
    means = (grey * sizes).sum(axis=(1, 2), keepdims=True) / sizes.sum()
    weights = sizes / (grey / means + 1.0)

    def left() -> np.ndarray:
        off = ((sg.evaluate(sg.fit(light)) - light) ** 2).sum(axis=-1)
        return np.asarray((off * weights).sum(axis=(1, 2)))

    refined = left()
    monkeypatch.setattr(lobe_refinement, "_MAX_STEPS", 0)
    chosen = left()
    # The last scaling, to the irradiance of the cells, may cost a little.
    assert (refined < 1.01 * chosen).all()
    assert np.median(refined / chosen) < 0.3
