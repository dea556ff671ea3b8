"""The light cache gives what paths that are followed to their end give, for less noise."""

from typing import Any

import numpy as np
import pytest

from openrooms_usd.render import light_store
from tests.mitsuba.test_transport import integrator_of, little_room, passes


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few surfels, filled by few paths, and no file."""
    from orusd_mitsuba.cache import filling, population

    monkeypatch.setattr(light_store, "places", lambda scene: ())
    monkeypatch.setattr(filling, "_SURFELS", 600)
    monkeypatch.setattr(population, "_CANDIDATES", 1 << 14)
    monkeypatch.setattr(population, "_WALKERS", 1 << 13)


def furnace(build: Any, albedo: float) -> Any:
    """A closed box whose walls all emit 3 nits and reflect a part of what they get."""
    from pxr import UsdLux

    made = build()
    wall = made.material("/Wall", base_color=(albedo,) * 3, roughness=1.0, ior=1.0)
    corners = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    prim = made.mesh("/Walls", corners, faces, material=wall).GetPrim()
    UsdLux.MeshLightAPI.Apply(prim)
    light = UsdLux.LightAPI(prim)
    light.CreateIntensityAttr(3.0)
    light.CreateMaterialSyncModeAttr("independent")
    made.camera((-0.6, -0.9, 0.2), (0.3, 0.9, -0.4), fov=75)
    return made.stage


def test_a_box_that_emits_all_over_has_a_closed_form(small: None, build: Any, lit: Any) -> None:
    """E = pi L (1 + a + a^2 + ...): with each number of scatterings one term more."""
    room = lit(furnace(build, 0.6), "openrooms")
    irradiance = room.cache(bounces=5)._data.irradiance.sum(axis=2)
    for row, scatterings in enumerate((3, 2, 1, 0)):
        expected = np.pi * 3.0 * sum(0.6**n for n in range(scatterings + 1))
        assert irradiance[:, row].mean() == pytest.approx(expected, rel=0.01)
        np.testing.assert_allclose(irradiance[:, row], expected, rtol=0.2)


@pytest.mark.slow
@pytest.mark.parametrize("white", [False, True])
def test_it_agrees_with_paths_to_the_end(build: Any, lit: Any, white: bool) -> None:
    """In the mean over the picture, by kind and by light, and with far less noise."""
    room = lit(little_room(build, ior=1.5), "openrooms")
    how = {"first": room.first} if white else {}
    reference = passes(integrator_of(room, **how), count=24)
    cached = passes(integrator_of(room, paths=room.cache().paths(by_light=True), **how), count=24)
    a, b = (x.mean(axis=(2, 3, 4)) for x in (reference, cached))
    error = np.sqrt((a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / len(a))
    bias = b.mean(axis=0) - a.mean(axis=0)
    assert (np.abs(bias) <= 4.0 * error + 0.02 * a.mean(axis=0) + 1e-5 * a.sum()).all()
    noise = [x[:, 2].var(axis=0).mean() for x in (reference, cached)]
    assert noise[1] < 0.5 * noise[0]


@pytest.mark.slow
def test_equal_rooms_get_equal_bytes(small: None, build: Any, lit: Any) -> None:
    one, other = (lit(little_room(build, ior=1.5), "openrooms").cache()._data for _ in range(2))
    np.testing.assert_array_equal(one.table.entries, other.table.entries)
    np.testing.assert_array_equal(one.irradiance, other.irradiance)
