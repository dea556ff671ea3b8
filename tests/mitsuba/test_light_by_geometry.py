"""Channels of light against geometry: closed forms, swapped roles, and the same light otherwise."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from openrooms_usd.arrays import Array, Mask
from openrooms_usd.geometry.hemisphere import irradiance, irradiance_bound, untiled
from tests import small
from tests.mitsuba.rendering import Pictures, pictures, session_of, shown
from tests.mitsuba.rooms import closed_room
from tests.mitsuba.statistics import blocks, lambert, z_of
from tests.small import square

pytestmark = pytest.mark.usefixtures("vectorized")

NITS = 40.0
DOWN = square((0, 0, 0.9), 0.3, "-Z")


def view_of(made: small.Stage, *names: str, seeds: int = 8, **how: Any) -> Pictures:
    return pictures(session_of(made.stage), names, range(seeds), **how)


def open_space() -> small.Stage:
    made = small.Stage()
    made.material("/Grey", base_color=(0.5,) * 3)
    return made


def lamp(made: small.Stage, corners: Array) -> None:
    made.quad("/Lamp", corners, material="/Grey", nits=NITS)


def cube(made: small.Stage, turned: float = 0.0) -> None:
    mesh = made.box("/Lamp", 0.3, at=(0.3, 0.3, 0.1), material="/Grey", nits=NITS)
    mesh.AddRotateXYZOp().Set((turned, turned / 2, turned / 3))


def inner(normals: Array) -> Mask:
    """(H, W) pixels whose neighbours have the same normal, so that no edge crosses them."""
    same = np.ones(normals.shape[:2], dtype=bool)
    for axis in (0, 1):
        for step in (1, -1):
            same &= np.abs(np.roll(normals, step, axis) - normals).max(axis=-1) < 1e-3
    same[[0, -1]] = same[:, [0, -1]] = False
    return same


def of_kind(kind: str) -> Callable[[small.Stage], object]:
    return lambda made: made.light(kind, "/Lamp", NITS, at=(0.3, 0.2, 0.6), radius=0.15)


CONVEX: dict[str, Callable[[small.Stage], object]] = {
    "panel": lambda made: lamp(made, DOWN),
    "cube": cube,
    **{kind: of_kind(kind) for kind in ("Sphere", "Disk", "Cylinder")},
}


@pytest.mark.one_in(5)
@pytest.mark.parametrize("kind", CONVEX)
def test_alone_in_an_empty_convex_room_a_lamp_is_seen_whole(kind: str) -> None:
    made = closed_room()
    CONVEX[kind](made)
    found = view_of(made, "visibility_i", "unoccluded_i", "direct_i", seeds=1, samples=64)
    reached = found["unoccluded_0"] > 0.0
    assert reached.mean() > 0.8
    seen = found["visibility_0"][reached]
    # Facets of a ball meet their neighbours' edges once in some 10^5 rays.
    assert seen.min() > 1.0 - 1e-4 and (seen == 1.0).mean() > 0.99
    np.testing.assert_allclose(found["direct_0"], found["unoccluded_0"], rtol=1e-4)


@pytest.mark.parametrize("turned", [0.0, 37.0])
def test_a_convex_lamp_does_not_shine_on_itself(turned: float) -> None:
    made = closed_room()
    cube(made, turned)
    made.camera((-0.4, -0.4, 0.4), (0.3, 0.3, 0.1), fov=12)
    channels = ("unoccluded_i", "direct_i", "visibility_i", "irradiance_direct")
    found = view_of(made, *channels, "mask_i", seeds=1)
    assert (found.pop("mask_0") == 1.0).all()
    for name in ("unoccluded_0", "direct_0", "visibility_0", "irradiance_direct"):
        assert found[name].max() < 1e-9 * NITS, name


@pytest.mark.parametrize("half", [1e-4, 0.3, 1.0])
def test_a_point_a_panel_and_a_ceiling_that_glows_give_lamberts_sum(half: float) -> None:
    """The last touches all four walls."""
    made, corners = closed_room(), square((0, 0, 0.9999), half, "-Z")
    lamp(made, corners)
    names = ("direct_i", "unoccluded_i", "visibility_i", "position", "normal_geometric", "valid")
    found = view_of(made, *names, seeds=1, samples=64)
    at, normals = found["position"][0], found["normal_geometric"][0]
    where = inner(normals) & (at[..., 2] < 0.9)
    assert where.mean() > 0.4
    expected = NITS * lambert(at, normals, corners)
    for name in ("direct_0", "unoccluded_0"):
        # The centre's value is not quite the pixel's.
        ratio = found[name][0, where, 1] / expected[where]
        assert ratio.mean() == pytest.approx(1.0, abs=4e-3)
        np.testing.assert_allclose(ratio, 1.0, atol=0.1)
    assert (found["visibility_0"][0, where] == 1.0).all()


def test_a_grazing_view_of_a_floor_with_a_lamp_that_stands_on_it() -> None:
    """From two centimetres above; the pixels' means by rays of our own."""
    made, wall = open_space(), square((0, 4, 0.5), (0.5, 0.6), "-Y")
    made.quad("/Floor", square((0, 0, 0), 50), material="/Grey")
    lamp(made, wall)
    made.camera((0, 0, 0.02), (0, 1, 0.018), fov=8)
    names = ("direct_i", "irradiance_direct", "position")
    view = shown(session_of(made.stage), *names, samples=256)
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


HOLE = (-0.5, -0.4, 0.5, 0.6)
PANE = square((0, 1, 0.1), 0.5, "-Y")


def room_with_a_hole(*, sky: bool) -> small.Stage:
    """Before it the sky with a portal, or a black panel of the sky's radiance, wide and close."""
    made = small.room(hole=HOLE, base_color=(0.6, 0.5, 0.4))
    made.box("/Box", 0.6, at=(0.2, 0.0, -0.6999), material="/Grey")
    made.camera((-0.8, -0.9, 0.5), (0.3, 0.7, -0.5), fov=85)
    if sky:
        made.dome(radiance=NITS, portals=(small.window(HOLE),))
    else:
        # Nearer than a thousandth of a ray's length to its end nothing counts as in its way.
        black = made.material("/Black", base_color=(0, 0, 0))
        made.quad("/Pane", square((0, 1.02, 0.1), 1.0, "-Y"), material=black, nits=NITS)
    return made


@pytest.mark.slow
def test_sky_through_a_rectangle_is_an_aperture_before_a_panel() -> None:
    names = ("direct_i", "irradiance_i", "radiance_i", "unoccluded_i")
    sky = view_of(room_with_a_hole(sky=True), *names, "position", "normal_geometric")
    panel = view_of(room_with_a_hole(sky=False), *names, samples=32)
    at, normals = sky["position"][0], sky["normal_geometric"][0]
    # The panel receives light too, which the sky does not.
    both = (inner(normals) & normals.any(axis=-1))[..., None]
    for name in ("direct_0", "irradiance_0", "radiance_0"):
        z = z_of(blocks(both * sky[name]), blocks(both * panel[name]))
        assert np.abs(z).max() < 6.0 and np.mean(z**2) < 3.0, name
    # Third, by the closed form of the hole where all of it is above the horizon.
    above = np.einsum("hwcx,hwx->hwc", PANE - at[..., None, :], normals)
    where = inner(normals) & (above.min(axis=-1) > 0.01) & (at[..., 1] < 0.99)
    expected = NITS * lambert(at, normals, PANE)[where]
    ours = sky["unoccluded_0"][:, where, 1].mean(axis=0)
    assert where.sum() > 60
    assert np.mean(ours / expected) == pytest.approx(1.0, abs=0.01)
    np.testing.assert_allclose(ours, expected, rtol=0.2)
    # What lies in its plane gets nothing from it.
    beside = inner(normals) & (np.abs(at[..., 1] - 1.0) < 1e-4)
    assert beside.sum() > 10
    assert not any(sky[f"{name}_0"][:, beside].any() for name in ("direct", "unoccluded"))


def test_irradiance_is_about_the_shading_normal_in_every_pass() -> None:
    """A floor whose normals lean by 35 degrees, by four estimators and the closed form."""
    made, panel = open_space(), square((0.8, 0.1, 0.6), 0.3, "-Z")
    floor = made.quad("/Floor", square((0, 0, 0), 0.05), material="/Grey")
    normal = np.array([np.sin(np.radians(35)), 0.0, np.cos(np.radians(35))])
    floor.CreateNormalsAttr([tuple(normal)] * 4)
    floor.SetNormalsInterpolation("vertex")
    lamp(made, panel)
    made.camera((0, -0.3, 0.3), (0, 0, 0), fov=2)
    names = ("unoccluded_i", "direct_i", "irradiance_direct", "environment_direct")
    found = view_of(made, *names, width=4, height=3, grid=(4, 3), samples=128)
    expected = float(NITS * lambert(np.zeros(3), normal, panel))
    assert expected > 1.15 * NITS * lambert(np.zeros(3), np.array([0.0, 0.0, 1.0]), panel)
    for name in ("unoccluded_0", "direct_0", "irradiance_direct"):
        assert found[name].mean() == pytest.approx(expected, rel=0.01), name
    cells = untiled(found["environment_direct"].mean(axis=0).astype(np.float32))
    bound = irradiance_bound(cells).mean()
    assert bound < 0.1 * expected
    assert abs(irradiance(cells).mean() - expected) < bound + 0.01 * expected


@pytest.mark.slow
def test_what_stands_between_is_left_out_of_unoccluded_light() -> None:
    """unoccluded_i is what path tracing finds once the board is gone."""

    def picture(*names: str, board: bool) -> Pictures:
        made = open_space()
        made.quad("/Floor", square((0, 0, 0), 3), material="/Grey")
        lamp(made, square((0.2, 0, 1.5), 0.4, "-Z"))
        made.box("/Cube", 0.2, at=(-0.5, 0.3, 1.1), material="/Grey", nits=5 * NITS)
        if board:
            made.quad("/Board", square((0.1, 0.1, 0.7), 0.3, "-Z"), material="/Grey")
        made.camera((0, -0.6, 0.6), (0, 0.1, 0), fov=60)
        return view_of(made, *names, bounces=1)

    hidden = picture("unoccluded_i", "direct_i", board=True)
    free = picture("irradiance_i", board=False)
    for number in range(2):
        theirs = blocks(free[f"irradiance_{number}"])
        z = z_of(blocks(hidden[f"unoccluded_{number}"]), theirs)
        assert np.abs(z).max() < 6.0 and np.mean(z**2) < 2.5
        assert hidden[f"direct_{number}"].mean() < 0.95 * theirs.mean()


def test_a_lamp_and_a_patch_are_reciprocal() -> None:
    """The flux from one to the other is the same both ways, past what stands between."""
    ends = [((0.0, 0.0, -1.0), (0.4, 0.3), "+Z"), ((0.3, 0.5, 0.8), (0.2, 0.15), "-Z")]
    flux: dict[str, list[Array]] = {"direct_0": [], "irradiance_direct": [], "unoccluded_0": []}
    for (patch, half, facing), other in (ends, ends[::-1]):
        made = open_space()
        made.quad("/Patch", square(patch, half, facing), material="/Grey")
        lamp(made, square(*other))
        made.quad("/Board", square((0.05, 0.25, 0), 0.25))
        # The picture is exactly the patch.
        far = np.array([0, 0, 0.3 if facing == "+Z" else -0.3])
        fov = 2.0 * np.degrees(np.arctan(half[0] / 0.3))
        made.camera(patch + far, patch, up=(0, 1, 0), fov=float(fov), aspect=half[0] / half[1])
        found = view_of(made, "direct_i", "unoccluded_i", "irradiance_direct", samples=64)
        for name, fluxes in flux.items():
            fluxes.append(4 * half[0] * half[1] * found[name].mean(axis=(1, 2))[:, 1])
    for name, (there, back) in flux.items():
        assert abs(z_of(there, back)) < 5.0, (name, there.mean(), back.mean())
        assert there.mean() == pytest.approx(back.mean(), rel=0.01), name
    assert flux["direct_0"][0].mean() < 0.9 * flux["unoccluded_0"][0].mean()
    mixed = flux["irradiance_direct"][1].mean()
    assert flux["direct_0"][0].mean() == pytest.approx(mixed, rel=0.01)
