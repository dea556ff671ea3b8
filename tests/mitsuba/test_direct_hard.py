"""Direct light where estimators usually break: closed forms in single precision's worst places."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from pxr import UsdGeom, UsdLux

from openrooms_usd.usd.lights import Portal, connect_portals, define_mesh_light, define_portal

Array = NDArray[np.float64]
NITS = 100.0


def patch(build: Any, *, at: ArrayLike = (0.0, 0.0, 0.0), size: float = 0.002) -> Any:
    """A small white patch that faces up, filling the picture."""
    made = build()
    center = np.asarray(at, dtype=float)
    square = np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]) * size / 2
    made.quad("/Patch", center + square, material=made.material("/White", base_color=(1, 1, 1)))
    eye = center + np.array([0, 0, max(0.003, 0.3 * size)])
    made.camera(eye, center, up=(0, 1, 0), fov=20, aspect=1.0)
    return made


def lamp(made: Any, corners: ArrayLike, path: str = "/Lamp") -> UsdGeom.Mesh:
    mesh = made.quad(path, corners, material="/White")
    define_mesh_light(mesh.GetPrim(), nits=NITS)
    return mesh


def down(half_x: float, half_y: float, z: float, x: float = 0.0, y: float = 0.0) -> Array:
    """A rectangle that shines down."""
    return np.array([(x - half_x, y - half_y, z), (x - half_x, y + half_y, z),
                     (x + half_x, y + half_y, z), (x + half_x, y - half_y, z)])  # fmt: skip


def channels(lit: Any, made: Any, samples: int = 16) -> dict[str, Array]:
    """The means of the first light's green over the picture."""
    found = lit(made.stage).lights(samples)
    return {name: values[0, :, 1] for name, values in found.items()}


def test_a_lamp_that_fills_the_ceiling_gives_pi_l(build: Any, lit: Any) -> None:
    made = patch(build)
    lamp(made, down(2000.0, 2000.0, 0.5))
    found = channels(lit, made)
    np.testing.assert_allclose(found["direct_i"], np.pi * NITS, rtol=1e-4)
    assert (found["visibility_i"] == 1.0).all()


def test_what_is_sampled_does_not_explode_below_a_large_near_lamp(build: Any, lit: Any) -> None:
    made = patch(build)
    lamp(made, down(5.0, 5.0, 0.01))
    sampled = lit(made.stage).direct(16)[0, ..., 1]
    assert sampled.mean() == pytest.approx(np.pi * NITS, rel=0.02)
    assert sampled.max() < 1.5 * sampled.mean()


def test_a_lamp_that_stands_on_the_surface_gives_half(build: Any, lit: Any) -> None:
    # A wall that begins at the patch: seen from its foot it covers half of the hemisphere.
    made = patch(build)
    lamp(made, [(0.01, 500, 0), (0.01, -500, 0), (0.01, -500, 900), (0.01, 500, 900)])
    found = channels(lit, made, 64)
    np.testing.assert_allclose(found["unoccluded_i"], np.pi / 2 * NITS, rtol=0.02)
    assert (found["visibility_i"] == 1.0).all()


def test_a_point_sized_lamp_follows_the_inverse_square(build: Any, lit: Any) -> None:
    made = patch(build)
    lamp(made, down(5e-5, 5e-5, 2.0))
    found = channels(lit, made)
    np.testing.assert_allclose(found["direct_i"], NITS * 1e-8 / 4.0, rtol=2e-3)


def test_a_lamp_whose_back_is_turned_is_dark(build: Any, lit: Any) -> None:
    made = patch(build)
    lamp(made, down(0.5, 0.5, 1.0)[::-1])
    found = channels(lit, made)
    assert not any(values.any() for values in found.values())


def test_triangles_without_area_change_nothing(build: Any, lit: Any) -> None:
    expected = None
    for extra in ([], [[0, 0, 1, 1], [0, 2, 2, 0]]):
        made = patch(build)
        mesh = made.mesh("/Lamp", down(0.5, 0.5, 1.0), [[0, 1, 2, 3], *extra], material="/White")
        define_mesh_light(mesh.GetPrim(), nits=NITS)
        found = channels(lit, made, 8)["direct_i"]
        expected = found if expected is None else expected
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_far_from_the_origin_it_is_the_same(build: Any, lit: Any) -> None:
    # USD's points are in single precision there: the lamp is a quarter of a metre off the grid.
    values = []
    for x in (0.0, 1e5):
        made = patch(build, at=(x, 0.0, 0.0), size=0.5)
        lamp(made, down(0.5, 0.5, 1.0, x=x + 0.25))
        values.append(channels(lit, made)["direct_i"].mean())
    assert values[0] > 1.0
    assert values[1] == pytest.approx(values[0], rel=1e-3)


def portal(path: str = "/Portal", x: float = 1.0) -> Portal:
    """2 by 2 m in the plane x = constant, its lower edge at z = 0."""
    world = np.eye(4)
    world[:3, :3] = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]]).T
    world[:3, 3] = (x, 0.0, 1.0)
    return Portal(path, world, 2.0, 2.0)


def sky(made: Any, *portals: Portal) -> None:
    prims = [define_portal(made.stage, each).GetPrim() for each in portals]
    connect_portals(made.dome(radiance=NITS).GetPrim(), prims)


def test_a_surface_in_the_plane_of_a_window_gets_nothing_from_it(build: Any, lit: Any) -> None:
    made = build()
    made.quad("/Patch", [(1, -0.1, -0.2), (1, -0.1, -0.1), (1, 0.1, -0.1), (1, 0.1, -0.2)],
              material=made.material("/White", base_color=(1, 1, 1)))  # fmt: skip
    made.camera((0.7, 0.0, -0.15), (1.0, 0.0, -0.15), fov=10, aspect=1.0)
    sky(made, portal())
    found = lit(made.stage).lights(16)
    assert not any(values[0].any() for values in found.values())
    assert np.isfinite(found["direct_i"]).all()


def test_behind_one_opening_another_counts_the_light_once(build: Any, lit: Any) -> None:
    made = patch(build)
    sky(made, portal("/Inner", 1.0), portal("/Outer", 1.5))
    found = lit(made.stage).lights(256)
    total = found["unoccluded_i"].sum(axis=0)[:, 1].mean()
    assert total == pytest.approx(np.pi * NITS, rel=0.02)
    alone = patch(build)
    sky(alone, portal("/Outer", 1.5))
    outer = lit(alone.stage).lights(256)["unoccluded_i"][0, :, 1].mean()
    assert found["unoccluded_i"][1, :, 1].mean() == pytest.approx(outer, rel=0.03)
    assert 0.0 < found["unoccluded_i"][0, :, 1].mean() < outer


def test_a_sun_is_filed_under_the_opening_that_it_comes_through(build: Any, lit: Any) -> None:
    made = patch(build)
    sky(made, portal())
    sun = UsdLux.DistantLight.Define(made.stage, "/Sun")
    sun.CreateIntensityAttr(1e9)
    sun.CreateAngleAttr(0.0)
    # It shines along (-1, 0, -1): in through the rectangle.
    sun.AddRotateYOp().Set(45.0)
    found = lit(made.stage).lights(16)
    expected = 1e9 * np.cos(np.pi / 4)
    np.testing.assert_allclose(found["direct_i"][0, :, 1], expected, rtol=1e-4)
    assert found["direct_i"][1].max() < np.pi * NITS * 1.5


def test_glass_lets_through_what_its_opacity_leaves(build: Any, lit: Any) -> None:
    made = patch(build)
    lamp(made, down(0.2, 0.2, 1.0))
    made.material("/Glass", base_color=(1, 1, 1), opacity=0.25)
    made.quad("/Pane", down(3.0, 3.0, 0.5), material="/Glass")
    found = channels(lit, made, 4)
    np.testing.assert_allclose(found["visibility_i"], 0.75, rtol=1e-5)


def test_half_a_lamp_behind_a_wall_is_half_seen(build: Any, lit: Any) -> None:
    made = patch(build)
    lamp(made, down(0.3, 0.3, 1.0))
    made.quad("/Wall", [(0, -2, 0.1), (0, 2, 0.1), (-4, 2, 0.1), (-4, -2, 0.1)], material="/White")
    found = channels(lit, made, 64)
    assert found["visibility_i"].mean() == pytest.approx(0.5, abs=0.01)
    ratio = found["direct_i"].mean() / found["unoccluded_i"].mean()
    assert ratio == pytest.approx(0.5, abs=0.01)


def test_fifty_lamps_are_each_found(build: Any, lit: Any) -> None:
    made = patch(build)
    for number in range(50):
        x, y = number % 10 - 4.5, number // 10 - 2.0
        lamp(made, down(0.1, 0.1, 1.5, x, y), f"/Lamp_{number}")
    found = lit(made.stage).lights(4, size=(4, 4))
    whole = found["unoccluded_i"][:50, :, 1].mean(axis=1)
    x, y = np.arange(50) % 10 - 4.5, np.arange(50) // 10 - 2.0
    expected = NITS * 0.04 * 1.5**2 / (x**2 + y**2 + 1.5**2) ** 2
    np.testing.assert_allclose(whole, expected, rtol=0.02)
