"""Direct light of each lamp and opening, in closed form where estimators usually break."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

from openrooms_usd.arrays import Array
from openrooms_usd.usd.light.lights import Portal
from tests import small
from tests.small import square

NITS = 100.0


def patch(*, at: ArrayLike = (0.0, 0.0, 0.0), size: float = 0.002) -> small.Stage:
    """A small white patch that faces up, filling the picture."""
    made = small.Stage()
    center = np.asarray(at, dtype=float)
    made.material("/White", base_color=(1, 1, 1))
    made.quad("/Patch", square(center, size / 2), material="/White")
    eye = center + np.array([0, 0, max(0.003, 0.3 * size)])
    made.camera(eye, center, up=(0, 1, 0), fov=20, aspect=1.0)
    return made


def lamp(made: small.Stage, corners: ArrayLike, path: str = "/Lamp") -> None:
    made.quad(path, corners, material="/White", nits=NITS)


def channels(lit: Any, made: small.Stage, samples: int = 16) -> dict[str, Array]:
    """The means of the first light's green over the picture."""
    found = lit(made.stage).lights(samples)
    return {name: values[0, :, 1] for name, values in found.items()}


def test_a_sphere_gives_pi_l_r_squared_over_d_squared(lit: Any) -> None:
    made = patch(size=0.02)
    made.light("Sphere", "/Ball", NITS, at=(0.6, 0.0, 0.8), radius=0.25)
    found = channels(lit, made, 64)["unoccluded_i"]
    expected = np.pi * NITS * 0.25**2 * 0.8
    spread = found.std() / np.sqrt(len(found))
    # The facets have the area of the sphere, not its outline.
    assert abs(found.mean() - expected) < 4.0 * spread + 2e-3 * expected


@pytest.mark.parametrize("samples", [1, 5])
def test_visibility_is_a_share_and_zero_where_nothing_could_come(lit: Any, samples: int) -> None:
    """Also of lamps that are as bright as the sun, and darker than a candle."""
    made = small.room(4.0)
    made.box("/Table", 0.5, material="/Grey")
    made.quad("/Panel", square((0.5, 0.4, 1.9), 0.3, "-Z"), material="/Grey", nits=1e9)
    made.light("Sphere", "/Ball", 1e-3, at=(0.9, 1.4, 0.1), radius=0.1)
    made.camera((0.2, -0.3, 0.3), (1.0, 1.0, -0.6), fov=80, aspect=1.0)
    scene = lit(made.stage)
    found = scene.lights(samples)
    seen, whole = found["visibility_i"], found["unoccluded_i"]
    assert seen.min() == 0.0 and seen.max() <= 1.0
    assert (seen[whole == 0.0] == 0.0).all()
    assert (found["direct_i"] <= whole).all()
    # Equal seeds give equal bits, and others do not.
    first, again, other = (scene.direct(samples, seed) for seed in (5, 5, 6))
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_what_comes_past_all_openings_is_elsewhere(lit: Any) -> None:
    """An open field under an even sky receives pi L in all; a table takes its part away."""
    made = small.Stage()
    made.quad(
        "/Floor", square((0, 0, -2), 8), material=made.material("/White", base_color=(1,) * 3)
    )
    made.box("/Table", 0.9, material="/White")
    made.camera((0.2, -1.5, 1.5), (0.0, 0.6, -2.0), fov=60, aspect=1.0)
    made.dome(radiance=NITS, portals=(small.window((-0.5, -0.2, 0.7, 0.6), y=2.0),))
    found = lit(made.stage).lights(64)
    whole, arriving = (found[n].sum(axis=0)[:, 1] for n in ("unoccluded_i", "direct_i"))
    assert whole[whole > 0.0].mean() == pytest.approx(NITS * np.pi, rel=0.02)
    assert 0.5 * whole.mean() < arriving.mean() < whole.mean()


def test_a_lamp_that_fills_the_ceiling_gives_pi_l(lit: Any) -> None:
    made = patch()
    lamp(made, square((0, 0, 0.5), 2000, "-Z"))
    found = channels(lit, made)
    np.testing.assert_allclose(found["direct_i"], np.pi * NITS, rtol=1e-4)
    assert (found["visibility_i"] == 1.0).all()


def test_what_is_sampled_does_not_explode_below_a_large_near_lamp(lit: Any) -> None:
    made = patch()
    lamp(made, square((0, 0, 0.01), 5, "-Z"))
    sampled = lit(made.stage).direct(16)[0, ..., 1]
    assert sampled.mean() == pytest.approx(np.pi * NITS, rel=0.02)
    assert sampled.max() < 1.5 * sampled.mean()


def test_a_lamp_that_stands_on_the_surface_gives_half(lit: Any) -> None:
    # A wall that begins at the patch: seen from its foot it covers half of the hemisphere.
    made = patch()
    lamp(made, square((0.01, 0, 450), (500, 450), "-X"))
    found = channels(lit, made, 64)
    np.testing.assert_allclose(found["unoccluded_i"], np.pi / 2 * NITS, rtol=0.02)
    assert (found["visibility_i"] == 1.0).all()


def test_a_point_sized_lamp_follows_the_inverse_square(lit: Any) -> None:
    made = patch()
    lamp(made, square((0, 0, 2), 5e-5, "-Z"))
    found = channels(lit, made)
    np.testing.assert_allclose(found["direct_i"], NITS * 1e-8 / 4.0, rtol=2e-3)


def test_a_lamp_whose_back_is_turned_is_dark(lit: Any) -> None:
    made = patch()
    lamp(made, square((0, 0, 1), 0.5))
    found = channels(lit, made)
    assert not any(values.any() for values in found.values())


def test_triangles_without_area_change_nothing(lit: Any) -> None:
    expected = None
    for extra in ([], [[0, 0, 1, 1], [0, 2, 2, 0]]):
        made = patch()
        corners, faces = square((0, 0, 1), 0.5, "-Z"), [[0, 1, 2, 3], *extra]
        made.mesh("/Lamp", corners, faces, material="/White", nits=NITS)
        found = channels(lit, made, 8)["direct_i"]
        expected = found if expected is None else expected
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_far_from_the_origin_it_is_the_same(lit: Any) -> None:
    # USD's points are in single precision there: the lamp is a quarter of a metre off the grid.
    values = []
    for x in (0.0, 1e5):
        made = patch(at=(x, 0.0, 0.0), size=0.5)
        lamp(made, square((x + 0.25, 0, 1), 0.5, "-Z"))
        values.append(channels(lit, made)["direct_i"].mean())
    assert values[0] > 1.0
    assert values[1] == pytest.approx(values[0], rel=1e-3)


def portal(path: str = "/Portal", x: float = 1.0) -> Portal:
    """2 by 2 m in the plane x = constant, its lower edge at z = 0."""
    world = np.eye(4)
    world[:3, :3] = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]).T
    world[:3, 3] = (x, 0.0, 1.0)
    return Portal(path, world, 2.0, 2.0)


def test_a_surface_in_the_plane_of_a_window_gets_nothing_from_it(lit: Any) -> None:
    made = small.Stage()
    made.quad(
        "/Patch",
        square((1, 0, -0.15), (0.1, 0.05), "-X"),
        material=made.material("/White", base_color=(1, 1, 1)),
    )
    made.camera((0.7, 0.0, -0.15), (1.0, 0.0, -0.15), fov=10, aspect=1.0)
    made.dome(radiance=NITS, portals=(portal(),))
    found = lit(made.stage).lights(16)
    assert not any(values[0].any() for values in found.values())
    assert np.isfinite(found["direct_i"]).all()


def test_behind_one_opening_another_counts_the_light_once(lit: Any) -> None:
    made = patch()
    made.dome(radiance=NITS, portals=(portal("/Inner", 1.0), portal("/Outer", 1.5)))
    found = lit(made.stage).lights(256)
    total = found["unoccluded_i"].sum(axis=0)[:, 1].mean()
    assert total == pytest.approx(np.pi * NITS, rel=0.02)
    alone = patch()
    alone.dome(radiance=NITS, portals=(portal("/Outer", 1.5),))
    outer = lit(alone.stage).lights(256)["unoccluded_i"][0, :, 1].mean()
    assert found["unoccluded_i"][1, :, 1].mean() == pytest.approx(outer, rel=0.03)
    assert 0.0 < found["unoccluded_i"][0, :, 1].mean() < outer


def test_a_sun_is_filed_under_the_opening_that_it_comes_through(lit: Any) -> None:
    made = patch()
    made.dome(radiance=NITS, portals=(portal(),))
    # It shines along (-1, 0, -1): in through the rectangle.
    made.light("Distant", "/Sun", 1e9, turn=(0, 45.0, 0), angle=0.0)
    found = lit(made.stage).lights(16)
    expected = 1e9 * np.cos(np.pi / 4)
    np.testing.assert_allclose(found["direct_i"][0, :, 1], expected, rtol=1e-4)
    assert found["direct_i"][1].max() < np.pi * NITS * 1.5


def test_glass_lets_through_what_its_opacity_leaves(lit: Any) -> None:
    made = patch()
    lamp(made, square((0, 0, 1), 0.2, "-Z"))
    made.material("/Glass", base_color=(1, 1, 1), opacity=0.25)
    made.quad("/Pane", square((0, 0, 0.5), 3, "-Z"), material="/Glass")
    found = channels(lit, made, 4)
    np.testing.assert_allclose(found["visibility_i"], 0.75, rtol=1e-5)


def test_half_a_lamp_behind_a_wall_is_half_seen(lit: Any) -> None:
    made = patch()
    lamp(made, square((0, 0, 1), 0.3, "-Z"))
    made.quad("/Wall", square((-2, 0, 0.1), 2), material="/White")
    found = channels(lit, made, 64)
    assert found["visibility_i"].mean() == pytest.approx(0.5, abs=0.01)
    ratio = found["direct_i"].mean() / found["unoccluded_i"].mean()
    assert ratio == pytest.approx(0.5, abs=0.01)


def test_fifty_lamps_are_each_found(lit: Any) -> None:
    made = patch()
    for number in range(50):
        x, y = number % 10 - 4.5, number // 10 - 2.0
        lamp(made, square((x, y, 1.5), 0.1, "-Z"), f"/Lamp_{number}")
    found = lit(made.stage).lights(4, size=(4, 4))
    whole = found["unoccluded_i"][:50, :, 1].mean(axis=1)
    x, y = np.arange(50) % 10 - 4.5, np.arange(50) // 10 - 2.0
    expected = NITS * 0.04 * 1.5**2 / (x**2 + y**2 + 1.5**2) ** 2
    np.testing.assert_allclose(whole, expected, rtol=0.02)
