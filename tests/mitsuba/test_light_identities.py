"""What the channels of one view say of each other: every sum, part and share, as users get them.

The two sides of each test come from passes that share neither code for what they add up nor random
numbers, but for the sums that are told to be exact.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pxr import Gf, Usd, UsdLux

from openrooms_usd.geometry.hemisphere import irradiance, irradiance_bound, untiled
from openrooms_usd.render import RenderRequest
from openrooms_usd.render.opened import open_with
from openrooms_usd.usd.lights import Portal, connect_portals, define_mesh_light, define_portal
from orusd_mitsuba import MitsubaRenderer

Array = NDArray[np.float64]
SIZE = (24, 18)
SEEDS = 12
LAMPS = ("/Ball", "/Panel")
WINDOW = "/Window"
RECEIVED = ("irradiance", "irradiance_direct", "irradiance_indirect", "irradiance_i")
STRAIGHT = ("direct_i", "unoccluded_i", "visibility_i")
SENT = ("radiance", "emission", "direct", "indirect", "radiance_i")
# Where the camera "/Near" looks: past the panel's board, the edge of the sun's patch, the box.
TARGETS = [(-0.3, 0.0, -1.0), (0.1, -0.1, -1.0), (-1.0, 0.1, -0.2), (0.35, 0.1, -0.5)]


def _window(made: Any, dome: UsdLux.DomeLight_1) -> None:
    world = np.eye(4)
    world[:3, :3] = np.array([[-1, 0, 0], [0, 0, 1], [0, 1, 0]]).T
    world[:3, 3] = [0.0, 1.0, 0.0]
    portal = define_portal(made.stage, Portal(WINDOW, world, 1.0, 1.0))
    connect_portals(dome.GetPrim(), [portal.GetPrim()])


def _walls(made: Any, material: str) -> None:
    """Two metres about the origin, with a hole of one metre in the wall at y = 1."""
    corners = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [0, 4, 6, 2], [1, 3, 7, 5]]
    made.mesh("/Walls", corners, np.array(faces)[:, ::-1], material=material)
    outer = [(-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1)]
    inner = [(x / 2, 1, z / 2) for x, _, z in outer]
    ring = [[i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i] for i in range(4)]
    made.mesh("/Front", [*outer, *inner], ring, material=material)


def furnished(build: Any, lit_by: tuple[str, ...] = (*LAMPS, WINDOW), **looks: Any) -> Usd.Stage:
    """A panel over a board, a coloured ball, a window with sky and sun, and a glossy box."""
    made = build()
    nits = {path: float(path in lit_by) for path in (*LAMPS, WINDOW)}
    wall = made.material("/Wall", **({"base_color": (0.7, 0.6, 0.5)} | looks))
    shiny = {"base_color": (0.2, 0.3, 0.6), "roughness": 0.3, "ior": 1.5} | looks
    _walls(made, wall)
    box = made.box("/Box", 0.5, material=made.material("/Shiny", **shiny))
    box.AddTranslateOp().Set(Gf.Vec3d(0.4, 0.2, -0.75))
    board = [(-0.8, -0.2, 0.3), (-0.1, -0.2, 0.3), (-0.1, 0.4, 0.3), (-0.8, 0.4, 0.3)]
    made.quad("/Board", board, material=wall)
    panel = [(-0.5, -0.1, 0.9), (-0.5, 0.2, 0.9), (-0.1, 0.2, 0.9), (-0.1, -0.1, 0.9)]
    prim = made.quad("/Panel", panel, material=wall).GetPrim()
    define_mesh_light(prim, nits=50.0 * nits["/Panel"])
    ball = UsdLux.SphereLight.Define(made.stage, "/Ball")
    ball.CreateRadiusAttr(0.1)
    ball.CreateIntensityAttr(60.0 * nits["/Ball"])
    ball.CreateColorAttr(Gf.Vec3f(1.0, 0.5, 0.2))
    ball.AddTranslateOp().Set(Gf.Vec3d(0.7, -0.3, 0.1))
    sun = UsdLux.DistantLight.Define(made.stage, "/Sun")
    sun.CreateIntensityAttr(30.0 * nits[WINDOW])
    sun.CreateAngleAttr(0.0)
    # It shines along (0, -0.77, -0.64): through the window, on the floor.
    sun.AddRotateXOp().Set(-50.0)
    _window(made, made.dome(radiance=20.0 * nits[WINDOW]))
    made.camera((-0.6, -0.9, 0.2), (0.3, 0.9, -0.4), fov=75)
    for number, target in enumerate(TARGETS):
        made.camera((-0.6, -0.9, 0.2), target, path=f"/Near_{number}", fov=0.5)
    return made.stage


@pytest.fixture(scope="module")
def session(build: Any, lit: Any) -> Any:
    del lit
    return open_with(MitsubaRenderer(), furnished(build))


Passes = dict[str, Array]


def render(session: Any, names: tuple[str, ...], seeds: range, **how: Any) -> Passes:
    """(seeds, height, width, 3) by name."""
    how = {"camera": "/Camera", "width": SIZE[0], "height": SIZE[1], "samples": 16} | how
    views = [session.render(RenderRequest(channels=names, seed=seed, **how)) for seed in seeds]
    return {
        name: np.stack([view.images[name].pixels for view in views]).astype(np.float64)
        for name in views[0].images
    }


@pytest.fixture(scope="module")
def found(session: Any) -> Passes:
    return render(session, (*SENT, *RECEIVED, *STRAIGHT), range(SEEDS))


def of_lights(passes: Passes, channel: str) -> list[Array]:
    """A channel of every light, by number."""
    stem = channel.removesuffix("i")
    return [passes[f"{stem}{n}"] for n in range(len(passes)) if f"{stem}{n}" in passes]


def blocks(pictures: Array) -> Array:
    """(..., 36) means of blocks of 6 by 6 pixels, of each colour."""
    *rest, height, width, _ = pictures.shape
    cut = pictures.reshape(*rest, height // 6, 6, width // 6, 6, 3)
    return cut.mean(axis=(-4, -2)).reshape(*rest, -1)


def distances(a: Array, b: Array) -> Array:
    """How far the means of two sets of independent passes are apart, in standard errors."""
    error = np.sqrt(a.var(axis=0, ddof=1) / len(a) + b.var(axis=0, ddof=1) / len(b))
    return np.asarray((a.mean(axis=0) - b.mean(axis=0)) / np.maximum(error, 1e-9))


def assert_alike(a: Array, b: Array, what: str = "") -> None:
    """The same means: of the picture, of blocks of pixels, and of pixels."""
    assert np.abs(distances(a.mean(axis=(1, 2)), b.mean(axis=(1, 2)))).max() < 5.0, what
    z = distances(blocks(a), blocks(b))
    assert np.abs(z).max() < 6.0 and np.mean(z**2) < 2.2, (what, np.abs(z).max(), np.mean(z**2))
    pixels = distances(a, b)
    assert np.mean(np.minimum(pixels, 5.0) ** 2) < 1.8, (what, np.mean(pixels**2))


def test_direct_light_of_all_lights_is_the_direct_part_of_irradiance(found: Passes) -> None:
    lights = of_lights(found, "direct_i")
    assert len(lights) == 4 and all(light.mean() > 0.1 for light in lights[:3])
    assert_alike(np.sum(lights, axis=0), found["irradiance_direct"])


def test_direct_light_of_each_light_is_its_irradiance_of_one_scattering(
    session: Any, found: Passes
) -> None:
    once = render(session, ("irradiance_i",), range(SEEDS), bounces=1)
    pairs = zip(of_lights(found, "direct_i"), of_lights(once, "irradiance_i"), strict=True)
    for number, (ours, theirs) in enumerate(pairs):
        assert_alike(ours, theirs, session.lights[number].path)


def test_lights_and_kinds_add_up_exactly(found: Passes) -> None:
    for whole, parts in (
        ("radiance", of_lights(found, "radiance_i")),
        ("radiance", [found[kind] for kind in ("emission", "direct", "indirect")]),
        ("irradiance", of_lights(found, "irradiance_i")),
        ("irradiance", [found["irradiance_direct"], found["irradiance_indirect"]]),
    ):
        assert all(part.min() >= 0.0 for part in parts)
        np.testing.assert_allclose(np.sum(parts, axis=0), found[whole], rtol=2e-5, atol=1e-6)


@pytest.fixture(scope="module")
def by_path(build: Any, lit: Any) -> Callable[..., Array]:
    """Radiance by Mitsuba's own integrator, on the processor alone, of some of the lights."""
    del lit

    def rendered(lit_by: tuple[str, ...]) -> Array:
        one = open_with(
            MitsubaRenderer(), furnished(build, lit_by), {"variant": "scalar", "bsdf": "preview"}
        )
        return render(one, ("radiance",), range(100, 100 + SEEDS), samples=32)["radiance"]

    return rendered


@pytest.mark.slow
def test_the_scalar_backend_sees_the_same_picture(
    build: Any, by_path: Callable[..., Array]
) -> None:
    ours = open_with(MitsubaRenderer(), furnished(build), {"bsdf": "preview"})
    parts = render(ours, ("radiance_i",), range(SEEDS))
    theirs = by_path((*LAMPS, WINDOW))
    assert_alike(np.sum(of_lights(parts, "radiance_i"), axis=0), theirs)
    for light, image in zip(ours.lights, of_lights(parts, "radiance_i"), strict=True):
        if light.kind != "elsewhere":
            assert_alike(image, by_path((light.path,)), light.path)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("number", range(len(TARGETS)))
def test_cells_times_cosine_are_irradiance(session: Any, number: int) -> None:
    """Within what light may be off that is uneven in a cell, which horizon cells dominate."""
    how = {"camera": f"/Near_{number}", "width": 4, "height": 3, "samples": 64, "grid": (4, 3)}
    grids = render(session, ("environment", "environment_direct"), range(8), **how)
    pixels = render(session, ("irradiance", "irradiance_direct"), range(8), **how)
    for name in ("", "_direct"):
        cells = np.stack([untiled(g) for g in grids[f"environment{name}"].astype(np.float32)])
        ours = irradiance(cells).mean(axis=(1, 2))
        theirs = pixels[f"irradiance{name}"].mean(axis=(1, 2))
        bound = irradiance_bound(cells.mean(axis=0)).mean(axis=(0, 1))
        spread = np.sqrt((ours.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / 8)
        off = np.abs(ours.mean(axis=0) - theirs.mean(axis=0))
        assert (off <= bound + 4.0 * spread).all(), (name, off, bound, spread)
        # They say something: the bound is small beside what is bounded, and so is the noise.
        assert (bound + 4.0 * spread < 0.2 * ours.mean(axis=0)).all()


def test_visibility_is_a_share_of_what_is_not_hidden(found: Passes) -> None:
    parts = zip(*(of_lights(found, name) for name in STRAIGHT), strict=True)
    for direct, unoccluded, visibility in parts:
        assert visibility.min() >= 0.0 and visibility.max() <= 1.0
        assert (direct <= unoccluded * (1.0 + 1e-6)).all()
        assert not visibility[unoccluded == 0.0].any()
    for hidden in of_lights(found, "visibility_i")[:3]:
        # Every light is seen by some pixels, hidden from others, and between for some.
        assert ((hidden > 0.1) & (hidden < 0.9)).mean() > 0.01 < (hidden > 0.99).mean()


@pytest.mark.slow
def test_of_exactly_lambertian_surfaces_irradiance_tells_the_picture(build: Any, lit: Any) -> None:
    """White: pi (direct + indirect) = irradiance, though one follows the materials' BSDFs."""
    looks = {"base_color": (1.0, 1.0, 1.0), "roughness": 1.0, "ior": 1.0}
    made = open_with(MitsubaRenderer(), furnished(build, LAMPS, **looks))
    sent = render(made, ("direct", "indirect"), range(SEEDS), bounces=3)
    got = render(made, RECEIVED[:3], range(50, 50 + SEEDS), bounces=3)
    for kind in ("direct", "indirect"):
        assert_alike(np.pi * sent[kind], got[f"irradiance_{kind}"], kind)
