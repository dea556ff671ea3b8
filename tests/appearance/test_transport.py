"""Light between surfaces, against closed forms of what arrives."""

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from openrooms_usd.appearance.directions import ELEVATIONS
from openrooms_usd.appearance.places import Places
from openrooms_usd.appearance.solving import radiosity
from openrooms_usd.appearance.transport import ROUGHNESSES, Gather, Transport, sample_transport
from openrooms_usd.rendering.opening import open_for_rendering
from openrooms_usd.rendering.scene.sources import sources_of
from openrooms_usd.usd.light.lights import Portal
from tests import small

Array = NDArray[np.float64]
SIDES = {
    "Bottom": ((0, 0, -1), "+Z"),
    "Top": ((0, 0, 1), "-Z"),
    "Back": ((0, 1, 0), "-Y"),
    "Front": ((0, -1, 0), "+Y"),
    "Right": ((1, 0, 0), "-X"),
    "Left": ((-1, 0, 0), "+X"),
}
SKY = slice(-len(ELEVATIONS), None)


def sampled(made: small.Stage, at: ArrayLike, normal: ArrayLike = (0, 0, 1)) -> Transport:
    """The operator for points of a stage that are seen from straight above."""
    context = open_for_rendering(made.stage)
    position = np.asarray(at, dtype=float)[:, None]
    normals = np.broadcast_to(np.asarray(normal, dtype=float), position.shape)
    places = Places(position, normals, normals)
    return sample_transport(context.scene, context.tracer, sources_of(context.scene), places)


def grid(many: int, half: float, z: float) -> Array:
    """Middles of the cells of a square."""
    step = (2.0 * np.arange(many) + 1.0 - many) / many * half
    x, y = np.meshgrid(step, step)
    return np.stack([x.ravel(), y.ravel(), np.full(x.size, z)], axis=-1)


def sums(gather: Gather) -> Array:
    return np.asarray(gather.direct.sum(axis=1) + gather.form.sum(axis=1))


def to_rectangle(x: Array, y: Array, half: float, away: float) -> Array:
    """The form factor from points to a square that faces them (Howell, B-4, four times)."""
    total = np.zeros_like(x)
    for a in (half + x, half - x):
        for b in (half + y, half - y):
            a_, b_ = a / away, b / away
            first = a_ / np.sqrt(1 + a_**2) * np.arctan(b_ / np.sqrt(1 + a_**2))
            second = b_ / np.sqrt(1 + b_**2) * np.arctan(a_ / np.sqrt(1 + b_**2))
            total += (first + second) / (2 * np.pi)
    return total


@pytest.fixture(scope="module")
def furnace() -> Transport:
    """A cube whose sides are lamps of one nit; places of its bottom."""
    made = small.Stage()
    for name, (center, facing) in SIDES.items():
        made.quad(f"/{name}", small.square(center, 1.0, facing), nits=1.0)
    return sampled(made, grid(6, 0.7, -1.0))


def test_a_closed_box_sends_all_light_back(furnace: Transport) -> None:
    assert furnace.diffuse.form.sum(axis=1) == pytest.approx(1.0)
    assert furnace.between.form.sum(axis=1) == pytest.approx(1.0)
    assert furnace.diffuse.direct.sum(axis=1) == pytest.approx(1.0, abs=0.05)
    assert furnace.diffuse.direct[:, SKY].max() == 0.0


@pytest.mark.parametrize("reflectance", [0.2, 0.5, 0.8])
def test_a_furnace_has_one_radiance(furnace: Transport, reflectance: float) -> None:
    """What is reflected of one nit everywhere is rho / (1 - rho), what arrives 1 / (1 - rho)."""
    base = np.full((furnace.part.max() + 1, 3), (reflectance - 0.04) / 0.96)
    reflected = radiosity(furnace, base, np.zeros(len(base)), 1).sum(axis=1)
    expected = reflectance / (1.0 - reflectance)
    assert reflected.mean() == pytest.approx(expected, rel=0.06)
    arriving = furnace.diffuse.direct.sum(axis=1) + furnace.diffuse.form @ reflected
    assert arriving == pytest.approx(1.0 + expected, rel=0.06)


def test_lobes_in_a_furnace_gather_their_albedo(furnace: Transport) -> None:
    for roughness, both in zip(ROUGHNESSES, furnace.glossy, strict=True):
        direct = sum(part.direct.sum(axis=1) for part in both)
        form = sum(part.form.sum(axis=1) for part in both)
        assert direct.mean() == pytest.approx(form.mean(), abs=0.02), roughness
        assert form.max() <= 1.0 + 1e-9


def test_a_square_lamp_lights_a_square_plate() -> None:
    """The mean is the form factor of equal parallel squares, one side apart: 0.19982."""
    made = small.Stage()
    made.quad("/Lamp", small.square((0, 0, 1), 0.5, "-Z"), nits=1.0)
    made.quad("/Plate", small.square((0, 0, 0), 0.5))
    at = grid(12, 0.5, 0.0)
    found = sampled(made, at).diffuse.direct[:, 0]
    assert found == pytest.approx(to_rectangle(at[:, 0], at[:, 1], 0.5, 1.0), rel=4e-3)
    assert found.mean() == pytest.approx(0.19982, rel=5e-3)


def test_the_back_of_a_lamp_is_dark() -> None:
    made = small.Stage()
    made.quad("/Lamp", small.square((0, 0, 1), 0.5, "+Z"), nits=1.0)
    made.quad("/Plate", small.square((0, 0, 0), 0.5))
    assert sampled(made, grid(3, 0.5, 0.0)).diffuse.direct[:, 0].max() == 0.0


def test_what_stands_between_takes_its_share() -> None:
    """Each of the points below sees half of the lamp past the edge of a board."""
    made = small.Stage()
    made.quad("/Lamp", small.square((0, 0, 2), 0.5, "-Z"), nits=1.0)
    made.quad("/Plate", small.square((0, 0, 0), 0.5))
    made.quad("/Board", small.square((1, 0, 1), 1.0, "+Z"))
    y = np.linspace(-0.3, 0.3, 40)
    at = np.stack([np.zeros(40), y, np.zeros(40)], axis=-1)
    found = sampled(made, at).diffuse.direct[:, 0]
    half = 0.5 * to_rectangle(at[:, 0], at[:, 1], 0.5, 2.0)
    assert found.mean() == pytest.approx(half.mean(), rel=0.05)


def test_the_light_of_a_portal_is_what_rays_leave() -> None:
    """An even sky and walls of its radiance are one furnace, whatever the window is."""
    made = small.room(hole=(-0.5, -0.5, 0.5, 0.5))
    out = np.array([[-1, 0, 0, 0], [0, 0, 1, 1], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)
    made.dome(radiance=1.0, portals=(Portal("/Window", out, 1.0, 1.0),))
    found = sampled(made, grid(8, 0.7, -1.0))
    assert sums(found.diffuse).mean() == pytest.approx(1.0, abs=0.01)
    assert sums(found.diffuse) == pytest.approx(1.0, abs=0.1)
    assert sums(found.between).mean() == pytest.approx(1.0, abs=0.03)
    sky = found.diffuse.direct[:, SKY]
    assert sky.sum(axis=1).min() > 0.0
    assert sky[:, :2].max() == 0.0  # from the floor nothing below the horizon is seen


def test_the_same_seed_gives_the_same_operator() -> None:
    made = small.room(hole=(-0.5, -0.5, 0.5, 0.5))
    made.dome(radiance=1.0)
    made.quad("/Lamp", small.square((0, 0, 0.9), 0.2, "-Z"), nits=1.0)
    first, again = (sampled(made, grid(3, 0.7, -1.0)) for _ in range(2))
    assert np.array_equal(first.diffuse.direct, again.diffuse.direct)
    assert np.array_equal(first.between.direct, again.between.direct)
    assert (first.between.form != again.between.form).nnz == 0
