"""Clear panes: light goes straight through and is mirrored, as Fresnel's equations say."""

from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from tests import small
from tests.mitsuba.rendering import radiance, session_of, shown
from tests.small import square

IOR = 1.52
TINT = (0.98, 0.99, 0.95)


@pytest.fixture
def variant(vectorized: str) -> str:
    """The scalar backend has light by Mitsuba's own paths, which know no panes."""
    return "llvm"


def shares(cosine: float, tint: float, ior: float = IOR) -> tuple[float, float]:
    """What a pane mirrors and passes: all reflections between its faces, added up one by one."""
    inside = np.sqrt(1 - (1 - cosine**2) / ior**2)
    held = tint ** (1 / inside)
    mirrored = passed = 0.0
    for amplitude in (
        (cosine - ior * inside) / (cosine + ior * inside),
        (ior * cosine - inside) / (ior * cosine + inside),
    ):
        face = amplitude**2
        mirrored += face / 2
        inner = (1 - face) / 2
        for _ in range(60):
            inner *= held
            passed += inner * (1 - face)
            inner *= face * held
            mirrored += inner * (1 - face)
            inner *= face
    return mirrored, passed


def sheet(made: Any, path: str, corners: Any, tint: Any = TINT, *, closed: bool = False) -> None:
    """A pane: a sheet that is seen from both sides, or a thin solid."""
    glass = made.material(f"{path}_glass", pane=tint, ior=IOR)
    if not closed:
        made.quad(path, corners, material=glass).CreateDoubleSidedAttr(True)
        return
    made.box(path, 1.0, material=glass)
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    size, middle = np.maximum(high - low, 0.004), (low + high) / 2
    points = UsdGeom.Mesh(made.stage.GetPrimAtPath(path)).GetPointsAttr()
    points.Set([tuple((np.array(p) * size + middle).tolist()) for p in points.Get()])


def test_at_normal_incidence_eight_per_cent_are_mirrored(variant: str) -> None:
    import mitsuba as mi

    from orusd_mitsuba import variants

    mi.set_variant(variants.choose("auto").variant)
    from orusd_mitsuba.transport.panes import pane_shares

    for cosine in (1.0, 0.7, 0.3, 0.05):
        for tint in (1.0, 0.9):
            found = [
                part.numpy()[1].item()
                for part in pane_shares(mi.Float(cosine), mi.Float(IOR), mi.Color3f(tint))
            ]
            assert found == pytest.approx(shares(cosine, tint), rel=1e-4)
            assert sum(found) <= 1 + 1e-5
    assert shares(1.0, 1.0) == pytest.approx((0.0817, 0.9183), abs=1e-4)


def from_above(wall_z: float, pane: Any, *, closed: bool = False) -> Usd.Stage:
    """A camera 3 m over a pane; before it, or behind the camera, a wall that glows with 50 nits."""
    made = small.Stage()
    bright = made.material("/Bright", base_color=(0, 0, 0), emissive=(50, 50, 50))
    made.quad("/Wall", square((0, 0, wall_z), 9, "-Z" if wall_z > 3 else "+Z"), material=bright)
    sheet(made, "/Pane", pane, closed=closed)
    made.camera((0, 0, 3), (0, 0, 0), up=(0, 1, 0), fov=2)
    made.dome(radiance=0.0)
    return made.stage


MIRRORED, PASSED = (np.array([50 * shares(1.0, tint)[k] for tint in TINT]) for k in range(2))


@pytest.mark.parametrize("closed", [False, True])
def test_luminance_behind_a_pane_is_its_part(shoot: Any, variant: str, closed: bool) -> None:
    """And nothing is seen of the pane itself: depth and labels are those of what lies behind."""
    stage = from_above(0.0, square((0, 0, 1), 5), closed=closed)
    for asked in (("radiance", "depth"), ("radiance", "irradiance", "depth")):
        images = shoot(stage, *asked, samples=1, bounces=3).images
        found = images["radiance"].pixels
        np.testing.assert_allclose(found, np.broadcast_to(PASSED, found.shape), rtol=1e-3)
        np.testing.assert_allclose(images["depth"].pixels, 3.0, rtol=1e-5)


@pytest.mark.parametrize("channels", [(), ("irradiance",)])
def test_a_pane_mirrors_what_stands_before_it(shoot: Any, variant: str, channels: Any) -> None:
    """And nothing where it is not seen: behind it there is nothing."""
    stage = from_above(5.0, square((2.5, 0, 0), (2.5, 5)))
    images = shoot(stage, "radiance", "direct", *channels, samples=3, bounces=3).images
    for name in ("radiance", "direct"):
        left, right = np.split(images[name].pixels, 2, axis=1)
        assert not left.any()
        np.testing.assert_allclose(right, np.broadcast_to(MIRRORED, right.shape), rtol=1e-3)


def test_light_samples_are_blocked_as_mitsuba_says(variant: str) -> None:
    """But for panes; and those that nobody wants are none."""
    import drjit as dr
    import mitsuba as mi

    from openrooms_usd.rendering.scene.sources import sources_of
    from openrooms_usd.rendering.scene.translate import translate
    from orusd_mitsuba import variants
    from orusd_mitsuba.plugins.build import Builder
    from orusd_mitsuba.transport.light_index import LightIndex
    from orusd_mitsuba.transport.panes import Panes

    mi.set_variant(variants.choose("auto").variant)
    made = small.Stage()
    made.quad("/Board", square((-0.5, 0, 0.5), (0.5, 1)))
    scene = translate(_room(made, pane=True))
    built = Builder(scene.origin).scene(scene)
    index = LightIndex(sources_of(scene), built, scene.origin, Panes(scene))
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(3, 4096)
    way = mi.warp.square_to_uniform_sphere(sampler.next_2d())
    si = built.ray_intersect(mi.Ray3f(mi.Point3f((-scene.origin).tolist()), way))
    number = sampler.next_2d()
    _, expected = built.sample_emitter_direction(si, number, True, si.is_valid())
    to, found = built.sample_emitter_direction(si, number, False, si.is_valid())
    lit = si.is_valid() & (to.pdf != 0.0)
    expected *= index.through(si.spawn_ray_to(to.p), lit)
    blocked = dr.any(found != 0.0) & ~dr.any(expected != 0.0)
    assert 0 < dr.count(blocked)[0] < dr.count(lit)[0]
    found *= index.unblocked(si, to, lit & (number.x < 0.5))
    wanted = dr.select(number.x < 0.5, expected, 0.0)
    np.testing.assert_array_equal(found.numpy(), wanted.numpy())


def _furnace(made: Any, tint: Any) -> Usd.Stage:
    """Panes in even light from everywhere."""
    for number, x in enumerate((-0.4, 0.3)):
        corners = [(x, -1, -1), (x + 0.3, 1, -1), (x + 0.3, 1, 1), (x, -1, 1)]
        sheet(made, f"/Pane_{number}", corners, tint, closed=bool(number))
    made.quad(
        "/Floor",
        square((0, 0, -1), 3),
        material=made.material("/Even", base_color=(0,) * 3, emissive=(7,) * 3),
    )
    made.dome(radiance=7.0)
    made.camera((-2, 0.2, 0.2), (0, 0, 0), fov=50)
    return made.stage  # type: ignore[no-any-return]


def test_no_light_is_lost_or_made(shoot: Any, variant: str) -> None:
    """In a furnace clear panes cannot be seen, by any channel that does not count first hits."""
    stage = _furnace(small.Stage(), (1.0, 1.0, 1.0))
    for asked in (("radiance",), ("radiance", "irradiance")):
        found = shoot(stage, *asked, samples=64).images["radiance"].pixels
        # Where two panes are seen, one of both mirror images is looked for.
        np.testing.assert_allclose(found, 7.0, rtol=0.01)
    tinted = shoot(_furnace(small.Stage(), (0.9, 0.9, 0.9)), "radiance", samples=16).images[
        "radiance"
    ]
    assert tinted.pixels.max() <= 7.0 * (1 + 1e-4) and tinted.pixels.min() < 6.7


def _room(made: Any, *, pane: bool) -> Usd.Stage:
    """A grey room with a panel over a pane, and a window in which the room is mirrored."""
    grey = made.material("/Grey", base_color=(0.5, 0.45, 0.4))
    made.box("/Room", 2.0, inside=True, material=grey)
    panel = square((-0.15, 0.05, 0.9), 0.25, "-Z")
    made.quad("/Panel", panel, material=grey, nits=100.0)
    if pane:
        sheet(made, "/Shelf", square((0, 0, 0.2), 1))
        sheet(made, "/Window", square((0.6, 0, -0.45), (1, 0.55), "+X"))
    made.camera((-0.9, -0.9, -0.2), (0.3, 0.4, -0.5), fov=70)
    return made.stage  # type: ignore[no-any-return]


ALL = tuple(
    (
        "radiance emission direct indirect diffuse specular irradiance irradiance_direct "
        "radiance_i irradiance_i direct_i unoccluded_i visibility_i"
    ).split()
)


@pytest.mark.parametrize("method", ["reference", pytest.param("cache", marks=pytest.mark.slow)])
def test_identities_hold_behind_panes(shoot: Any, variant: str, method: str) -> None:
    images = shoot(_room(small.Stage(), pane=True), *ALL, samples=16, method=method).images
    px = {name: image.pixels.astype(np.float64) for name, image in images.items()}

    def close(found: Any, expected: Any) -> None:
        np.testing.assert_allclose(found, expected, rtol=2e-4, atol=1e-3)

    close(px["emission"] + px["direct"] + px["indirect"], px["radiance"])
    close(sum(px[f"radiance_{n}"] for n in range(2)), px["radiance"])
    close(sum(px[f"direct_{n}"] for n in range(2)), px["irradiance_direct"])
    close(px["diffuse"] + px["specular"], px["direct"] + px["indirect"])
    assert (px["visibility_0"] <= 1.0).all() and (px["specular"] > -1e-3).all()


def test_light_that_a_pane_passes_is_that_part_of_it(shoot: Any, variant: str) -> None:
    """Of straight light on the floor: of each direction, so between those of the least and most."""
    images = shoot(
        _room(small.Stage(), pane=True),
        "direct_i",
        "unoccluded_i",
        "visibility_i",
        "normal",
        "position",
        samples=64,
    ).images
    seen, whole = images["direct_0"].pixels, images["unoccluded_0"].pixels
    at, up = images["position"].pixels, images["normal"].pixels[..., 2] > 0.99
    # Right below the panel, where only the shelf is in between.
    below = up & (np.abs(at[..., 0] + 0.15) < 0.5) & (np.abs(at[..., 1]) < 0.6)
    assert below.sum() > 10
    for channel, tint in enumerate(TINT):
        part = seen[below][:, channel] / whole[below][:, channel]
        assert part.max() < shares(1.0, tint)[1] + 1e-3
        assert part.min() > shares(0.8, tint)[1] - 1e-3


@pytest.mark.slow
def test_methods_and_passes_agree_behind_panes(shoot: Any, variant: str) -> None:
    stage = _room(small.Stage(), pane=True)
    how = {"samples": 512, "width": 16, "height": 12}
    truth = shoot(stage, "radiance", **how).images["radiance"].pixels.astype(np.float64)
    others = (
        shoot(stage, "radiance", "irradiance", **how),
        shoot(stage, "radiance", method="cache", **how),
        shoot(stage, "radiance", "irradiance", method="cache", **how),
    )
    for limit, other in zip((0.01, 0.02, 0.02), others, strict=True):
        found = other.images["radiance"].pixels
        assert found.mean() == pytest.approx(truth.mean(), rel=limit)
        assert np.abs(found - truth).mean() < 0.05 * truth.mean()


@pytest.mark.slow
def test_hemispheres_see_panes_by_every_method(shoot: Any, variant: str) -> None:
    """What hemispheres hold, times cosines, is the irradiance."""
    stage = _room(small.Stage(), pane=True)
    for method in ("reference", "cache"):
        images = shoot(
            stage,
            "environment",
            "irradiance",
            samples=256,
            grid=(4, 3),
            width=4,
            height=3,
            method=method,
        ).images
        cells = images["environment"].pixels.reshape(3, 16, 4, 32, 3).swapaxes(1, 2)
        edges = np.radians(np.linspace(0.0, 90.0, 17))
        weight = (np.sin(edges[1:]) ** 2 - np.sin(edges[:-1]) ** 2) * np.pi / 32
        lux = np.einsum("yxrcd,r->yxd", cells.astype(np.float64), weight)
        assert lux.mean() == pytest.approx(images["irradiance"].pixels.mean(), rel=0.04)


@pytest.mark.parametrize("closed", [False, True])
def test_panes_are_read_and_move(shoot: Any, variant: str, closed: bool) -> None:
    """A sash that is opened takes its pane along, and what is looked at is not dimmed any more."""
    opened = session_of(from_above(0.0, square((0, 0, 1), 1), closed=closed))
    before = radiance(opened, width=4, height=3, samples=1)
    aside = np.eye(4)
    aside[0, 3] = 4.0
    opened.move({"/Pane": aside})
    after = radiance(opened, width=4, height=3, samples=1)
    np.testing.assert_allclose(before[..., 1] / after[..., 1], shares(1.0, TINT[1])[1], rtol=1e-3)


def test_a_pane_survives_usd() -> None:
    from pxr import UsdShade

    from openrooms_usd.usd.shading.materialreader import read_preview_surface

    made = small.Stage()
    path = made.material("/Glass", pane=TINT, ior=IOR, roughness=0.0)
    found, losses = read_preview_surface(UsdShade.Material(made.stage.GetPrimAtPath(path)))
    assert found.pane == pytest.approx(TINT) and found.ior == pytest.approx(IOR) and not losses
    # To who does not know panes it is almost clear.
    assert found.opacity < 0.2


def test_the_scalar_backend_denoises_what_is_behind_panes() -> None:
    """Guides of a denoiser are the core's there: none of the vectorized transport is asked."""
    from openrooms_usd.rendering.contract import GUIDES

    made = small.Stage()
    made.box("/Room", 2.0, inside=True, material=made.material("/Grey", base_color=(0.5,) * 3))
    sheet(made, "/Pane", square((0, 0, 0), 0.9, "-Y"))
    made.camera((0.0, -0.9, 0.0), (0.0, 0.9, 0.0), fov=60)
    made.dome()
    opened = session_of(made.stage, variant="scalar")
    view = shown(opened, "radiance", width=16, height=12, samples=1, guides=True)
    assert set(view.guides) == set(GUIDES)
    np.testing.assert_allclose(view.guides["base_color"], 0.5, atol=1e-3)
