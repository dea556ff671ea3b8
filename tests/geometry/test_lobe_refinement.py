"""Lobes are wanted, and missed, by what the squared error says when it is computed outright."""

import numpy as np
import pytest

from openrooms_usd.geometry import lobe_pursuit, lobe_refinement
from openrooms_usd.geometry.hemisphere import spherical
from openrooms_usd.geometry.lobe_pursuit import CELLS, most_wanted, pursue

POINTS, COUNT = 4, 6
RNG = np.random.default_rng(11)
WEIGHTS = RNG.uniform(0.2, 2.0, (POINTS, 512)).astype(np.float32)
LIGHT = (RNG.random((POINTS, 512, 3)) ** 4).astype(np.float32)


def shapes_of(axes: np.ndarray, sharpness: np.ndarray) -> np.ndarray:
    return np.exp(sharpness[..., None].astype(float) * (axes.astype(float) @ CELLS.T - 1.0))


def started() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(2)
    theta, phi = rng.uniform(0.0, 1.4, (POINTS, COUNT)), rng.uniform(-3.0, 3.0, (POINTS, COUNT))
    return spherical(theta, phi).astype(np.float32), np.full((POINTS, COUNT), 9.0, np.float32)


def colored(axes: np.ndarray, sharpness: np.ndarray, light: np.ndarray) -> lobe_refinement.Lobes:
    root = np.sqrt(WEIGHTS)
    room = np.empty((POINTS, 4 * sharpness.shape[1], 512), np.float32)
    light = light * root[..., None]
    return lobe_refinement._colored(axes, sharpness, np.zeros_like(axes), light, root, room, 400)


def loss_of(light: np.ndarray, shapes: np.ndarray, colors: np.ndarray, point: int) -> float:
    off = (light[point] - shapes.T @ colors) ** 2
    return float((off * WEIGHTS[point, :, None]).sum())


def test_the_gram_matrix_gives_the_loss_of_what_is_left() -> None:
    lobes = colored(*started(), LIGHT)
    shapes = shapes_of(lobes.axes, lobes.sharpness)
    for point in range(POINTS):
        assert lobes.loss[point] == pytest.approx(
            loss_of(LIGHT, shapes[point], lobes.colors[point], point), rel=1e-4
        )


def wanted(left: np.ndarray, point: int) -> int:
    """Of the set, the lobe that alone leaves least with its best colour."""
    known, weights = lobe_pursuit._all_lobes(), WEIGHTS[point]
    over = []
    for shape in shapes_of(known.axes, known.sharpness):
        color = np.maximum(weights * shape @ left[point], 0.0) / (weights * shape**2).sum()
        over.append((weights[:, None] * (left[point] - shape[:, None] * color) ** 2).sum())
    return int(np.argmin(over))


def test_the_lobe_that_is_most_wanted_takes_most() -> None:
    known = lobe_pursuit._all_lobes()
    left = LIGHT**3 - 0.07
    axes, sharpness = most_wanted(left * WEIGHTS[..., None], WEIGHTS)
    best = [wanted(left, point) for point in range(POINTS)]
    np.testing.assert_array_equal(axes, known.axes[best])
    np.testing.assert_array_equal(sharpness, known.sharpness[best])


def test_lobes_of_the_set_are_chosen_again() -> None:
    known = lobe_pursuit._all_lobes()
    cells = [5, 70, 200, 450]
    light = known.shapes[cells] * 3.0
    axes, sharpness = pursue(light, WEIGHTS, 2)
    np.testing.assert_array_equal(axes[:, 0], known.axes[cells])
    np.testing.assert_array_equal(sharpness[:, 0], known.sharpness[cells])


def test_the_lobe_that_is_missed_least_gives_way() -> None:
    axes, sharpness = started()
    # Colours so large that none would be negative without the others.
    bright = RNG.uniform(2.0, 4.0, (POINTS, COUNT, 3))
    light = LIGHT + shapes_of(axes, sharpness).swapaxes(1, 2) @ bright
    lobes, root = colored(axes, sharpness, light.astype(np.float32)), np.sqrt(WEIGHTS)
    changed, _, colors = lobe_refinement._exchanged(lobes, light * root[..., None], root)
    for point in range(POINTS):
        without = []
        for number in range(COUNT):
            rest = np.delete(np.arange(COUNT), number)
            shapes = shapes_of(axes[point, rest], sharpness[point, rest])
            rows = np.sqrt(WEIGHTS[point])[:, None]
            best = np.linalg.lstsq(rows * shapes.T, rows * light[point], rcond=None)[0]
            without.append(loss_of(light, shapes, best, point))
        (number,) = np.flatnonzero((changed[point] != axes[point]).any(axis=1))
        assert number == int(np.argmin(without))
        left = light - shapes_of(axes, sharpness).swapaxes(1, 2) @ lobes.colors
        best = lobe_pursuit._all_lobes().axes[wanted(left, point)]
        np.testing.assert_array_equal(changed[point, number], best)
        assert not colors[point, number].any()


def test_an_exchange_finds_what_steps_cannot_reach() -> None:
    """Two lobes at one place, and light at two places that are far apart."""
    places = spherical([0.3, 1.2], [0.0, 3.0])
    light = np.exp(30.0 * (CELLS @ places.T - 1.0)).sum(axis=1).astype(np.float32)
    light = np.repeat(light[None, :, None], 3, axis=2)
    axes = spherical([[0.3, 0.31]], [[0.1, -0.1]]).astype(np.float32)
    sharpness = np.full((1, 2), 30.0, np.float32)
    room, weights = np.empty((1, 8, 512), np.float32), np.ones((1, 512), np.float32)
    found = lobe_refinement.refined(axes, sharpness, light, weights, room)
    assert found.loss[0] < 1e-3 * (light**2).sum()
    order = np.argsort(-found.axes[0, :, 2])
    np.testing.assert_allclose(found.axes[0, order], places, atol=0.02)


@pytest.mark.parametrize("sharpness", [16.0, 60.0, 128.0])
def test_no_product_of_lobes_is_denormal(sharpness: float) -> None:
    """Processors spend a hundred times as long on such numbers."""
    axes = spherical([[0.1, 1.5, 0.9]], [[0.0, 3.0, -1.0]]).astype(np.float32)
    light, root = np.full((1, 512, 3), 1e3, np.float32), np.full((1, 512), 1e-3, np.float32)
    room = np.empty((1, 12, 512), np.float32)
    widths = np.full((1, 3), sharpness, np.float32)
    fitted = lobe_refinement._colored(axes, widths, np.zeros_like(axes), light, root, room, 1)
    for values in (room, room[:, :3] ** 2, fitted.products, fitted.target):
        assert (np.abs(values[values != 0.0]) > np.finfo(np.float32).tiny).all()
