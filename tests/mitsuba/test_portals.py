"""Daylight through portals: a proper density, and the same light with fewer samples."""

from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from pxr import UsdLux

from openrooms_usd.arrays import Array
from openrooms_usd.usd.light.lights import read_portals
from tests import small
from tests.mitsuba.statistics import lambert
from tests.small import square

NITS = 1000.0
# A window in the wall y = 1 of a room about the origin: x and z from, x and z to.
WINDOW = (-0.5, -0.2, 0.7, 0.6)


def window_room(*, portals: bool) -> Any:
    """A black room with a white patch on the floor, lit by a window alone."""
    room = small.room(hole=WINDOW, base_color=(0.0, 0.0, 0.0))
    white = room.material("/White", base_color=(1.0, 1.0, 1.0))
    room.quad("/Patch", square((0, 0, -0.99), 0.02), material=white)
    room.camera((0, 0, 0), (0, 0, -0.99), up=(0, 1, 0), fov=1.0, aspect=1.0)
    room.dome(radiance=NITS, portals=(small.window(WINDOW),) if portals else ())
    return room.stage


@pytest.mark.parametrize("portals", [False, True])
def test_a_window_gives_the_irradiance_of_its_rectangle(shoot: Any, portals: bool) -> None:
    how = {"width": 16, "height": 16, "samples": 256, "bounces": 1}
    view = shoot(window_room(portals=portals), "radiance", **how)
    window = square((0.1, 1, 0.2), (0.4, 0.6), "-Y")
    expected = NITS / np.pi * float(lambert((0, 0, -0.99), (0, 0, 1), window))
    pixels = view.images["radiance"].pixels
    spread = pixels.mean(axis=-1).std() / np.sqrt(pixels[..., 0].size)
    assert abs(pixels.mean() - expected) < 4 * spread + 1e-3 * expected


def test_portals_lower_the_error(open_stage: Any, shoot: Any, variant: str) -> None:
    if variant == "scalar":
        pytest.skip("scalar variants sample the sky alone")
    errors = [
        shoot(window_room(portals=portals), "radiance", samples=64, bounces=1)
        .images["radiance"]
        .error
        for portals in (False, True)
    ]
    assert errors[1] < 0.25 * errors[0]


def emitter(mi: ModuleType) -> Any:
    from orusd_mitsuba.plugins.portal_environment import through_portals

    sky = np.ones((8, 16, 3), dtype=np.float32)
    sky[:3, 4:6] = 30.0
    inner = mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(sky)})
    second = small.window(WINDOW, 1.4, "/Other")
    second.world_from_portal[0, 3] += 0.9
    made = through_portals(inner, (small.window(WINDOW), second), np.zeros(3), 2.0, 1.0)
    scene = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}, "sky": inner})
    return made, inner, scene


def interaction(mi: ModuleType, at: ArrayLike, count: int) -> Any:
    import drjit as dr

    it = dr.zeros(mi.SurfaceInteraction3f, count)
    it.p = mi.Point3f(*np.asarray(at, dtype=float).tolist())
    return it


PLACES = [(0.0, 0.0, 0.0), (0.1, 0.9, 0.1), (0.6, 0.98, -0.9), (0.2, 1.2, 0.1), (0.0, 3.0, 0.0)]


def sphere_grid(rows: int) -> tuple[Array, float]:
    z = (np.arange(rows) + 0.5) / rows * 2 - 1
    phi = (np.arange(2 * rows) + 0.5) / rows * np.pi
    z, phi = (grid.ravel() for grid in np.meshgrid(z, phi, indexing="ij"))
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z]), 4 * np.pi / len(z)


@pytest.mark.parametrize("at", PLACES)
def test_the_density_integrates_to_one(mi: ModuleType, at: ArrayLike) -> None:
    import drjit as dr

    made, _, scene = emitter(mi)
    directions, cell = sphere_grid(1200)
    ds = dr.zeros(mi.DirectionSample3f, directions.shape[1])
    ds.d = mi.Vector3f(directions.astype(np.float32))
    pdf = made.pdf_direction(interaction(mi, at, directions.shape[1]), ds, True).numpy()
    assert pdf.astype(np.float64).sum() * cell == pytest.approx(1.0, abs=0.01)
    del scene


@pytest.mark.parametrize("at", PLACES)
def test_samples_estimate_the_integral_of_the_sky(mi: ModuleType, at: ArrayLike) -> None:
    import drjit as dr

    made, inner, scene = emitter(mi)
    count = 1 << 20
    rng = np.random.default_rng(5)
    sample = mi.Point2f(rng.random((2, count)).astype(np.float32))
    ds, weight = made.sample_direction(interaction(mi, at, count), sample, True)
    values = weight.numpy()[0].astype(np.float64)
    directions, cell = sphere_grid(600)
    si = dr.zeros(mi.SurfaceInteraction3f, directions.shape[1])
    si.wi = mi.Vector3f((-directions).astype(np.float32))
    expected = inner.eval(si, True).numpy()[0].astype(np.float64).sum() * cell
    assert abs(values.mean() - expected) < 5 * values.std() / np.sqrt(count) + 2e-3 * expected
    again = made.pdf_direction(interaction(mi, at, count), ds, True).numpy()
    np.testing.assert_allclose(ds.pdf.numpy(), again, rtol=1e-5)
    del scene


def test_a_portal_is_read_as_it_was_defined_in_metres() -> None:
    room = small.Stage(up="Y", metres=0.01)
    light = UsdLux.PortalLight.Define(room.stage, "/P")
    light.CreateWidthAttr(150.0)
    light.CreateHeightAttr(50.0)
    light.AddTranslateOp().Set((100.0, 200.0, 300.0))
    light.AddScaleOp().Set((2.0, 1.0, 1.0))
    (portal,) = read_portals(room.stage)
    assert (portal.path, portal.width, portal.height) == ("/P", 3.0, 0.5)
    # Y up to Z up: (x, y, z) -> (x, -z, y); a portal's z is outwards.
    np.testing.assert_allclose(portal.world_from_portal[:3, 3], [1, -3, 2])
    np.testing.assert_allclose(portal.world_from_portal[:3, 2], [0, -1, 0], atol=1e-12)
