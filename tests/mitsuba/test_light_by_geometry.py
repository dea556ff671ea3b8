"""Channels of light against geometry: closed forms, swapped roles, and the same light otherwise."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from pxr import UsdLux

from openrooms_usd.geometry.hemisphere import irradiance, irradiance_bound, untiled
from openrooms_usd.render import RenderRequest
from openrooms_usd.render.opened import open_with
from openrooms_usd.usd.lights import Portal, connect_portals, define_mesh_light, define_portal
from orusd_mitsuba import MitsubaRenderer
from tests.mitsuba.lamps import NITS, SIZE, Array, blocks, closed_room, down, lamp, view_of, z_of


def lambert(at: Array, normals: Array, corners: ArrayLike) -> Array:
    """(...) irradiance by an even polygon of radiance 1 above the horizon: Lambert 1760."""
    to = np.asarray(corners, dtype=np.float64) - at[..., None, :]
    last = np.roll(to, -1, axis=-2)
    cross = np.cross(to, last)
    sine = np.linalg.norm(cross, axis=-1)
    angle = np.arctan2(sine, (to * last).sum(axis=-1))
    share = (cross * normals[..., None, :]).sum(axis=-1) / np.maximum(sine, 1e-300)
    return np.abs((angle * share).sum(axis=-1)) / 2.0


def inner(normals: Array) -> NDArray[np.bool_]:
    """(H, W) pixels whose neighbours have the same normal, so that no edge crosses them."""
    same = np.ones(normals.shape[:2], dtype=bool)
    for axis in (0, 1):
        for step in (1, -1):
            same &= np.abs(np.roll(normals, step, axis) - normals).max(axis=-1) < 1e-3
    same[[0, -1]] = same[:, [0, -1]] = False
    return same


def round_lamp(kind: str) -> Any:
    def define(made: Any) -> None:
        light = getattr(UsdLux, f"{kind}Light").Define(made.stage, "/Lamp")
        light.CreateIntensityAttr(NITS)
        light.CreateRadiusAttr(0.15)
        light.AddTranslateOp().Set((0.3, 0.2, 0.6))

    return define


def glowing_cube(made: Any) -> None:
    mesh = made.box("/Lamp", 0.3, material="/Grey")
    mesh.AddTranslateOp().Set((0.3, 0.3, 0.1))
    define_mesh_light(mesh.GetPrim(), nits=NITS)


CONVEX = {
    "panel": lambda made: lamp(made, down(0.3, 0.9)),
    "cube": glowing_cube,
    **{kind: round_lamp(kind) for kind in ("Sphere", "Disk", "Cylinder")},
}


@pytest.mark.one_in(5)
@pytest.mark.parametrize("kind", CONVEX)
def test_alone_in_an_empty_convex_room_a_lamp_is_seen_whole(
    build: Any, lit: Any, kind: str
) -> None:
    made = closed_room(build)
    CONVEX[kind](made)
    found = view_of(made.stage, "visibility_i", "unoccluded_i", "direct_i", seeds=1, samples=64)
    reached = found["unoccluded_0"] > 0.0
    assert reached.mean() > 0.8
    seen = found["visibility_0"][reached]
    # Facets of a ball meet their neighbours' edges once in some 10^5 rays.
    assert seen.min() > 1.0 - 1e-4 and (seen == 1.0).mean() > 0.99
    np.testing.assert_allclose(found["direct_0"], found["unoccluded_0"], rtol=1e-4)


@pytest.mark.parametrize("half", [1e-4, 0.3, 1.0])
def test_a_point_a_panel_and_a_ceiling_that_glows_give_lamberts_sum(
    build: Any, lit: Any, half: float
) -> None:
    """The last touches all four walls."""
    made = closed_room(build)
    lamp(made, down(half, 0.9999))
    names = ("direct_i", "unoccluded_i", "visibility_i", "position", "normal_geometric", "valid")
    found = view_of(made.stage, *names, seeds=1, samples=64)
    at, normals = found["position"][0], found["normal_geometric"][0]
    where = inner(normals) & (at[..., 2] < 0.9)
    assert where.mean() > 0.4
    expected = NITS * lambert(at, normals, down(half, 0.9999))
    for name in ("direct_0", "unoccluded_0"):
        # The centre's value is not quite the pixel's.
        ratio = found[name][0, where, 1] / expected[where]
        assert ratio.mean() == pytest.approx(1.0, abs=4e-3)
        np.testing.assert_allclose(ratio, 1.0, atol=0.1)
    assert (found["visibility_0"][0, where] == 1.0).all()


def test_a_grazing_view_of_a_floor_with_a_lamp_that_stands_on_it(build: Any, lit: Any) -> None:
    """From two centimetres above; the pixels' means by rays of our own."""
    made = build()
    made.material("/Grey", base_color=(0.5,) * 3)
    made.quad("/Floor", [(-50, -50, 0), (50, -50, 0), (50, 50, 0), (-50, 50, 0)], material="/Grey")
    wall = np.array([(-0.6, 4, 0), (0.6, 4, 0), (0.6, 4, 1), (-0.6, 4, 1)])
    lamp(made, wall[::-1] if np.cross(*(wall[1:3] - wall[0]))[1] > 0 else wall)
    made.camera((0, 0, 0.02), (0, 1, 0.018), fov=8)
    session = open_with(MitsubaRenderer(), made.stage)
    names = ("direct_i", "irradiance_direct", "position")
    view = session.render(RenderRequest("/Camera", names, *SIZE, samples=256))
    fine = (np.arange(16) + 0.5) / 16
    u, v = np.meshgrid(np.arange(24)[:, None] + fine, np.arange(18)[:, None] + fine)
    rays = np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(view.K).T
    rays = rays @ view.world_from_camera[:3, :3].T
    at = view.world_from_camera[:3, 3] - rays * (0.02 / rays[..., 2:])
    reached = (rays[..., 2] < 0.0) & (at[..., 1] < 3.99)
    each = np.where(reached, NITS * lambert(at, np.array([0, 0, 1.0]), wall), 0.0)
    expected = each.reshape(18, 16, 24, 16).mean(axis=(1, 3))
    whole = reached.reshape(18, 16, 24, 16).all(axis=(1, 3))
    assert whole.sum() > 100
    for name, wide in (("direct_0", 0.1), ("irradiance_direct", 0.6)):
        ratio = view.images[name].pixels[whole, 1] / expected[whole]
        np.testing.assert_allclose(ratio, 1.0, atol=wide)
        assert abs(ratio.mean() - 1.0) < 4.0 * ratio.std() / np.sqrt(len(ratio)) + 1e-3, name


HOLE = np.array([(-0.5, 1, -0.4), (0.5, 1, -0.4), (0.5, 1, 0.6), (-0.5, 1, 0.6)])


def room_with_a_hole(build: Any, *, sky: bool) -> Any:
    """Before it the sky with a portal, or a black panel of the sky's radiance, wide and close."""
    made = build()
    grey = made.material("/Grey", base_color=(0.6, 0.5, 0.4))
    corners = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5]]
    made.mesh("/Walls", corners, np.array(faces)[:, ::-1], material=grey)
    outer = [(-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1)]
    ring = [[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)]
    made.mesh("/Front", [*outer, *HOLE], ring, material=grey)
    made.box("/Box", 0.6, material=grey).AddTranslateOp().Set((0.2, 0.0, -0.6999))
    made.camera((-0.8, -0.9, 0.5), (0.3, 0.7, -0.5), fov=85)
    if sky:
        world = np.eye(4)
        world[:3, :3] = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0]]).T
        world[:3, 3] = HOLE.mean(axis=0)
        portal = define_portal(made.stage, Portal("/Hole", world, 1.0, 1.0))
        connect_portals(made.dome(radiance=NITS).GetPrim(), [portal.GetPrim()])
        return made
    made.material("/Black", base_color=(0, 0, 0))
    middle = HOLE.mean(axis=0)
    # Nearer than a thousandth of a ray's length to its end nothing counts as in its way.
    wide = middle + (HOLE - middle) * 2.0 + [0, 0.02, 0]
    define_mesh_light(made.quad("/Pane", wide, material="/Black").GetPrim(), nits=NITS)
    return made


@pytest.mark.slow
def test_sky_through_a_rectangle_is_an_aperture_before_a_panel(build: Any, lit: Any) -> None:
    names = ("direct_i", "irradiance_i", "radiance_i", "unoccluded_i")
    seen = ("position", "normal_geometric")
    sky = view_of(room_with_a_hole(build, sky=True).stage, *names, *seen)
    panel = view_of(room_with_a_hole(build, sky=False).stage, *names, samples=32)
    at, normals = sky["position"][0], sky["normal_geometric"][0]
    # The panel receives light too, which the sky does not.
    both = (inner(normals) & normals.any(axis=-1))[..., None]
    for name in ("direct_0", "irradiance_0", "radiance_0"):
        z = z_of(blocks(both * sky[name]), blocks(both * panel[name]))
        assert np.abs(z).max() < 6.0 and np.mean(z**2) < 3.0, name
    # Third, by the closed form of the hole where all of it is above the horizon.
    above = np.einsum("hwcx,hwx->hwc", HOLE - at[..., None, :], normals)
    where = inner(normals) & (above.min(axis=-1) > 0.01) & (at[..., 1] < 0.99)
    expected = NITS * lambert(at, normals, HOLE)[where]
    ours = sky["unoccluded_0"][:, where, 1].mean(axis=0)
    assert where.sum() > 60
    assert np.mean(ours / expected) == pytest.approx(1.0, abs=0.01)
    np.testing.assert_allclose(ours, expected, rtol=0.2)
    # What lies in its plane gets nothing from it.
    beside = inner(normals) & (np.abs(at[..., 1] - 1.0) < 1e-4)
    assert beside.sum() > 10
    assert not any(sky[f"{name}_0"][:, beside].any() for name in ("direct", "unoccluded"))


def test_irradiance_is_about_the_shading_normal_in_every_pass(build: Any, lit: Any) -> None:
    """A floor whose normals lean by 35 degrees, by four estimators and the closed form."""
    made = build()
    made.material("/Grey", base_color=(0.5,) * 3)
    floor = made.quad("/Floor", down(0.05, 0.0)[::-1], material="/Grey")
    normal = np.array([np.sin(np.radians(35)), 0.0, np.cos(np.radians(35))])
    floor.CreateNormalsAttr([tuple(normal)] * 4)
    floor.SetNormalsInterpolation("vertex")
    panel = down(0.3, 0.6, 0.8, 0.1)
    lamp(made, panel)
    made.camera((0, -0.3, 0.3), (0, 0, 0), fov=2)
    names = ("unoccluded_i", "direct_i", "irradiance_direct", "environment_direct")
    found = view_of(made.stage, *names, width=4, height=3, grid=(4, 3), samples=128)
    expected = NITS * lambert(np.zeros(3), normal, panel)
    flat = NITS * lambert(np.zeros(3), np.array([0.0, 0.0, 1.0]), panel)
    assert expected > 1.15 * flat
    for name in ("unoccluded_0", "direct_0", "irradiance_direct"):
        assert found[name].mean() == pytest.approx(expected, rel=0.01), name
    cells = untiled(found["environment_direct"].mean(axis=0).astype(np.float32))
    bound = irradiance_bound(cells).mean()
    assert bound < 0.1 * expected
    assert abs(irradiance(cells).mean() - expected) < bound + 0.01 * expected
