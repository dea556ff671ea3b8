"""Clear panes: light goes straight through and is mirrored, as Fresnel's equations say."""

from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from openrooms_usd.usd.lights import define_mesh_light

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


@pytest.mark.parametrize("closed", [False, True])
def test_luminance_behind_a_pane_is_its_part(
    build: Any, shoot: Any, variant: str, closed: bool
) -> None:
    """And nothing is seen of the pane itself: depth and labels are those of what lies behind."""
    made = build()
    bright = made.material("/Bright", base_color=(0, 0, 0), emissive=(50, 50, 50))
    made.quad("/Wall", [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], material=bright)
    sheet(made, "/Pane", [(-5, -5, 1), (5, -5, 1), (5, 5, 1), (-5, 5, 1)], closed=closed)
    made.camera((0, 0, 3), (0, 0, 0), up=(0, 1, 0), fov=2)
    made.dome(radiance=0.0)
    expected = [50 * shares(1.0, tint)[1] for tint in TINT]
    for asked in (("radiance", "depth"), ("radiance", "irradiance", "depth")):
        view = shoot(made.stage, *asked, samples=1, bounces=3)
        np.testing.assert_allclose(
            view.images["radiance"].pixels, np.broadcast_to(expected, (24, 32, 3)), rtol=1e-3
        )
        np.testing.assert_allclose(view.images["depth"].pixels, 3.0, rtol=1e-5)


def test_a_pane_mirrors_what_stands_before_it(build: Any, shoot: Any, variant: str) -> None:
    made = build()
    bright = made.material("/Bright", base_color=(0, 0, 0), emissive=(50, 50, 50))
    # Behind the camera; behind the pane there is nothing.
    made.quad("/Wall", [(-9, 9, 5), (9, 9, 5), (9, -9, 5), (-9, -9, 5)], material=bright)
    sheet(made, "/Pane", [(-5, -5, 0), (5, -5, 0), (5, 5, 0), (-5, 5, 0)])
    made.camera((0, 0, 3), (0, 0, 0), up=(0, 1, 0), fov=2)
    made.dome(radiance=0.0)
    expected = [50 * shares(1.0, tint)[0] for tint in TINT]
    for asked in (("radiance", "direct"), ("radiance", "direct", "irradiance")):
        images = shoot(made.stage, *asked, samples=1, bounces=3).images
        for name in ("radiance", "direct"):
            np.testing.assert_allclose(images[name].pixels.mean(axis=(0, 1)), expected, rtol=1e-3)


def test_mirrored_light_is_where_the_pane_is_seen(build: Any, shoot: Any, variant: str) -> None:
    made = build()
    bright = made.material("/Bright", base_color=(0, 0, 0), emissive=(50, 50, 50))
    made.quad("/Wall", [(-9, 9, 5), (9, 9, 5), (9, -9, 5), (-9, -9, 5)], material=bright)
    sheet(made, "/Pane", [(0, -5, 0), (5, -5, 0), (5, 5, 0), (0, 5, 0)])
    made.camera((0, 0, 3), (0, 0, 0), up=(0, 1, 0), fov=2)
    made.dome(radiance=0.0)
    seen = shoot(made.stage, "radiance", samples=3, bounces=3).images["radiance"]
    left, right = np.split(seen.pixels, 2, axis=1)
    assert not left.any()
    expected = [50 * shares(1.0, tint)[0] for tint in TINT]
    np.testing.assert_allclose(right, np.broadcast_to(expected, right.shape), rtol=1e-3)


def test_light_samples_are_blocked_as_mitsuba_says(build: Any, variant: str) -> None:
    """But for panes; and those that nobody wants are none."""
    import drjit as dr
    import mitsuba as mi

    from openrooms_usd.render.scene.sources import sources_of
    from openrooms_usd.render.scene.translate import translate
    from orusd_mitsuba import variants
    from orusd_mitsuba.plugins.build import Builder
    from orusd_mitsuba.transport.light_index import LightIndex
    from orusd_mitsuba.transport.panes import Panes

    mi.set_variant(variants.choose("auto").variant)
    made = build()
    made.quad("/Board", [(-1, -1, 0.5), (0, -1, 0.5), (0, 1, 0.5), (-1, 1, 0.5)])
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
    made.quad("/Floor", [(-3, -3, -1), (3, -3, -1), (3, 3, -1), (-3, 3, -1)],
              material=made.material("/Even", base_color=(0,) * 3, emissive=(7,) * 3))  # fmt: skip
    made.dome(radiance=7.0)
    made.camera((-2, 0.2, 0.2), (0, 0, 0), fov=50)
    return made.stage  # type: ignore[no-any-return]


def test_no_light_is_lost_or_made(build: Any, shoot: Any, variant: str) -> None:
    """In a furnace clear panes cannot be seen, by any channel that does not count first hits."""
    stage = _furnace(build(), (1.0, 1.0, 1.0))
    for asked in (("radiance",), ("radiance", "irradiance")):
        found = shoot(stage, *asked, samples=64).images["radiance"].pixels
        # Where two panes are seen, one of both mirror images is looked for.
        np.testing.assert_allclose(found, 7.0, rtol=0.01)
    tinted = shoot(_furnace(build(), (0.9, 0.9, 0.9)), "radiance", samples=16).images["radiance"]
    assert tinted.pixels.max() <= 7.0 * (1 + 1e-4) and tinted.pixels.min() < 6.7


def _room(made: Any, *, pane: bool) -> Usd.Stage:
    """A grey room with a panel over a pane, and a window in which the room is mirrored."""
    grey = made.material("/Grey", base_color=(0.5, 0.45, 0.4))
    made.box("/Room", 2.0, inside=True, material=grey)
    panel = [(-0.4, -0.2, 0.9), (-0.4, 0.3, 0.9), (0.1, 0.3, 0.9), (0.1, -0.2, 0.9)]
    define_mesh_light(made.quad("/Panel", panel, material=grey).GetPrim(), nits=100.0)
    if pane:
        sheet(made, "/Shelf", [(-1, -1, 0.2), (1, -1, 0.2), (1, 1, 0.2), (-1, 1, 0.2)])
        sheet(made, "/Window", [(0.6, -1, -1), (0.6, 1, -1), (0.6, 1, 0.1), (0.6, -1, 0.1)])
    made.camera((-0.9, -0.9, -0.2), (0.3, 0.4, -0.5), fov=70)
    return made.stage  # type: ignore[no-any-return]


ALL = (
    "radiance", "emission", "direct", "indirect", "diffuse", "specular", "irradiance",
    "irradiance_direct", "radiance_i", "irradiance_i", "direct_i", "unoccluded_i", "visibility_i",
)  # fmt: skip


@pytest.mark.parametrize("method", ["reference", pytest.param("cache", marks=pytest.mark.slow)])
def test_identities_hold_behind_panes(build: Any, shoot: Any, variant: str, method: str) -> None:
    images = shoot(_room(build(), pane=True), *ALL, samples=16, method=method).images
    px = {name: image.pixels.astype(np.float64) for name, image in images.items()}

    def close(found: Any, expected: Any) -> None:
        np.testing.assert_allclose(found, expected, rtol=2e-4, atol=1e-3)

    close(px["emission"] + px["direct"] + px["indirect"], px["radiance"])
    close(sum(px[f"radiance_{n}"] for n in range(2)), px["radiance"])
    close(sum(px[f"direct_{n}"] for n in range(2)), px["irradiance_direct"])
    close(px["diffuse"] + px["specular"], px["direct"] + px["indirect"])
    assert (px["visibility_0"] <= 1.0).all() and (px["specular"] > -1e-3).all()


def test_light_that_a_pane_passes_is_that_part_of_it(build: Any, shoot: Any, variant: str) -> None:
    """Of straight light on the floor: of each direction, so between those of the least and most."""
    images = shoot(_room(build(), pane=True), "direct_i", "unoccluded_i", "visibility_i", "normal",
                   "position", samples=64).images  # fmt: skip
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
def test_methods_and_passes_agree_behind_panes(build: Any, shoot: Any, variant: str) -> None:
    stage = _room(build(), pane=True)
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
def test_hemispheres_see_panes_by_every_method(build: Any, shoot: Any, variant: str) -> None:
    """What hemispheres hold, times cosines, is the irradiance."""
    stage = _room(build(), pane=True)
    for method in ("reference", "cache"):
        images = shoot(stage, "environment", "irradiance", samples=256, grid=(4, 3), width=4,
                       height=3, method=method).images  # fmt: skip
        cells = images["environment"].pixels.reshape(3, 16, 4, 32, 3).swapaxes(1, 2)
        edges = np.radians(np.linspace(0.0, 90.0, 17))
        weight = (np.sin(edges[1:]) ** 2 - np.sin(edges[:-1]) ** 2) * np.pi / 32
        lux = np.einsum("yxrcd,r->yxd", cells.astype(np.float64), weight)
        assert lux.mean() == pytest.approx(images["irradiance"].pixels.mean(), rel=0.04)


@pytest.mark.parametrize("closed", [False, True])
def test_panes_are_read_and_move(build: Any, shoot: Any, variant: str, closed: bool) -> None:
    """A sash that is opened takes its pane along, and what is looked at is not dimmed any more."""
    from openrooms_usd.render import RenderRequest
    from orusd_mitsuba import MitsubaRenderer
    from tests.opening import open_with

    made = build()
    bright = made.material("/Bright", base_color=(0, 0, 0), emissive=(50, 50, 50))
    made.quad("/Wall", [(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], material=bright)
    sheet(made, "/Pane", [(-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)], closed=closed)
    made.camera((0, 0, 3), (0, 0, 0), up=(0, 1, 0), fov=2)
    opened = open_with(MitsubaRenderer(), made.stage)
    request = RenderRequest("/Camera", ("radiance",), 4, 3, samples=1)
    before = opened.render(request).images["radiance"].pixels
    aside = np.eye(4)
    aside[0, 3] = 4.0
    opened.move({"/Pane": aside})
    after = opened.render(request).images["radiance"].pixels
    np.testing.assert_allclose(before[..., 1] / after[..., 1], shares(1.0, TINT[1])[1], rtol=1e-3)


def test_a_pane_survives_usd(build: Any) -> None:
    from pxr import UsdShade

    from openrooms_usd.usd.materialreader import read_preview_surface

    made = build()
    path = made.material("/Glass", pane=TINT, ior=IOR, roughness=0.0)
    found, losses = read_preview_surface(UsdShade.Material(made.stage.GetPrimAtPath(path)))
    assert found.pane == pytest.approx(TINT) and found.ior == pytest.approx(IOR) and not losses
    # To who does not know panes it is almost clear.
    assert found.opacity < 0.2


def test_the_scalar_backend_denoises_what_is_behind_panes(build: Any) -> None:
    """Guides of a denoiser are the core's there: none of the vectorized transport is asked."""
    from openrooms_usd.render import RenderRequest
    from openrooms_usd.render.contract import GUIDES
    from orusd_mitsuba import MitsubaRenderer
    from tests.opening import open_with

    made = build()
    made.box("/Room", 2.0, inside=True, material=made.material("/Grey", base_color=(0.5,) * 3))
    sheet(made, "/Pane", [(-0.9, 0.0, -0.9), (0.9, 0.0, -0.9), (0.9, 0.0, 0.9), (-0.9, 0.0, 0.9)])
    made.camera((0.0, -0.9, 0.0), (0.0, 0.9, 0.0), fov=60)
    made.dome()
    opened = open_with(MitsubaRenderer(), made.stage, {"variant": "scalar"})
    request = RenderRequest("/Camera", ("radiance",), 16, 12, samples=1, guides=True)
    view = opened.render(request)
    assert set(view.guides) == set(GUIDES)
    np.testing.assert_allclose(view.guides["base_color"], 0.5, atol=1e-3)
