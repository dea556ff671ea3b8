"""The light cache gives what paths that are followed to their end give, for less noise."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering import light_store
from tests import small
from tests.mitsuba.rendering import passes, session_of, shown
from tests.mitsuba.rooms import little_room
from tests.mitsuba.test_hemispheres import integrator_of as hemispheres_of
from tests.small import square


def furnace(albedo: float) -> Any:
    """A closed box whose walls all emit 3 nits and reflect a part of what they get."""
    made = small.Stage()
    wall = made.material("/Wall", base_color=(albedo,) * 3, roughness=1.0, ior=1.0)
    made.box("/Walls", 2.0, inside=True, material=wall, nits=3.0)
    made.camera((-0.6, -0.9, 0.2), (0.3, 0.9, -0.4), fov=75)
    return made.stage


def test_a_box_that_emits_all_over_has_a_closed_form(few_surfels: None, lit: Any) -> None:
    """E = pi L (1 + a + a^2 + ...): with each number of scatterings one term more."""
    room = lit(furnace(0.6), "openrooms")
    irradiance = room.cache(bounces=5)._data.irradiance.sum(axis=2)
    for row, scatterings in enumerate((3, 2, 1, 0)):
        expected = np.pi * 3.0 * sum(0.6**n for n in range(scatterings + 1))
        assert irradiance[:, row].mean() == pytest.approx(expected, rel=0.01)
        np.testing.assert_allclose(irradiance[:, row], expected, rtol=0.2)


@pytest.mark.slow
def test_pixels_say_what_was_not_looked_up(
    few_surfels: None, lit: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing far from all corners, all of it by reference or where no ray is long enough."""
    from orusd_mitsuba.cache import room_light

    stage = little_room(ior=1.0)
    session = session_of(stage, bsdf="openrooms", variant="llvm")

    def traced(method: str) -> Any:
        how: Any = {"method": method, "measure_bias": False}
        return shown(session, "traced", "indirect", **how).images["traced"].pixels

    assert (traced("reference") == 1.0).all()
    found = traced("cache")
    assert found.shape == (18, 24, 1) and (found >= 0.0).all() and (found <= 1.0).all()
    assert np.quantile(found, 0.2) == 0.0 and 0.05 < found.mean() < 0.6
    monkeypatch.setattr(room_light, "NEAREST_PER_SIZE", 1e9)
    assert (traced("cache") == 1.0).all()


def _agree(reference: Any, cached: Any, share: float = 0.02) -> None:
    """Means of the picture by kind and by light agree, but for noise and a share."""
    a, b = (x.mean(axis=(2, 3, 4)) for x in (reference, cached))
    error = np.sqrt((a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / len(a))
    bias = b.mean(axis=0) - a.mean(axis=0)
    assert (np.abs(bias) <= 4.0 * error + share * a.mean(axis=0) + 1e-5 * a.sum()).all()


@pytest.mark.slow
@pytest.mark.parametrize("white", [False, True])
def test_it_agrees_with_paths_to_the_end(lit: Any, white: bool) -> None:
    """In the mean over the picture, by kind and by light, and with far less noise."""
    room = lit(little_room(ior=1.5), "openrooms")
    how = {"first": room.first} if white else {}
    reference = passes(room.paths(**how), count=24)
    cached = passes(room.paths(paths=room.cache().paths(by_light=True), **how), count=24)
    _agree(reference, cached)
    noise = [x[:, 2].var(axis=0).mean() for x in (reference, cached)]
    assert noise[1] < 0.5 * noise[0]


@pytest.mark.slow
def test_equal_rooms_get_equal_bytes(few_surfels: None, lit: Any) -> None:
    one, other = (lit(little_room(ior=1.5), "openrooms").cache()._data for _ in range(2))
    np.testing.assert_array_equal(one.table.entries, other.table.entries)
    np.testing.assert_array_equal(one.irradiance, other.irradiance)


@pytest.mark.slow
@pytest.mark.parametrize("bounces", [2, 3, 12])
def test_it_counts_scatterings_exactly(lit: Any, bounces: int) -> None:
    """One more or less is some percent of the light in a bright room."""
    room = lit(little_room(ior=1.5), "openrooms")
    reference = passes(room.paths(bounces + 1), count=16)
    paths = room.cache(bounces).paths(by_light=True)
    cached = passes(room.paths(bounces + 1, paths=paths), count=16)
    _agree(reference, cached)


def _curtained(*behind_m: float) -> Any:
    """The little room with a cloth before its window, and as much more behind it."""
    made = small.Stage.of(little_room(ior=1.5))
    made.material("/Cloth", base_color=(0.4, 0.4, 0.4), ior=1.5, transmission=0.3)
    for number, y in enumerate((0.8, *(0.8 + behind for behind in behind_m))):
        made.quad(f"/Curtain_{number}", square((0, y, 0), 0.8, "+Y"), material="/Cloth")
    return made.stage


@pytest.mark.slow
def test_light_goes_through_sheets(lit: Any) -> None:
    """What arrives at their other side is looked up where it is seen from this one."""
    _agrees_behind(lit(_curtained(), "openrooms"))


@pytest.mark.long
@pytest.mark.slow
def test_light_goes_through_sheets_that_nearly_touch(lit: Any) -> None:
    """What arrives between them is not what arrives behind both; steps here are of 0.16 mm."""
    _agrees_behind(lit(_curtained(0.00024), "openrooms"))


def _agrees_behind(room: Any) -> None:
    assert any(patch.surface.transmission > 0.0 for patch in room.scene.patches)
    reference = passes(room.paths(), count=24)
    cached = passes(room.paths(paths=room.cache().paths(by_light=True)), count=24)
    _agree(reference, cached, 0.03)


@pytest.mark.slow
def test_environment_maps_look_it_up(lit: Any) -> None:
    """Rays that are only looked up, and those that are followed apart, make the same mean."""
    room = lit(_curtained(), "openrooms")
    reference, cached = (
        np.stack([integrator(2, seed) for seed in range(12)]).mean(axis=(2, 3, 4))
        for integrator in (
            hemispheres_of(room),
            hemispheres_of(room, arrival=room.cache().arriving()),
        )
    )
    error = np.sqrt((reference.var(axis=0, ddof=1) + cached.var(axis=0, ddof=1)) / 12)
    bias = cached.mean(axis=0) - reference.mean(axis=0)
    assert (np.abs(bias) <= 4.0 * error + 0.02 * reference.mean(axis=0)).all()


@pytest.mark.slow
def test_hemispheres_in_a_box_that_emits_all_over(few_surfels: None, lit: Any) -> None:
    """L straight, and L (1 + a + a^2 + ...) in all, in every cell: light samples and directions
    share the straight light, and nothing is counted twice."""
    room = lit(furnace(0.6), "openrooms")
    integrator = hemispheres_of(room, grid=(8, 6), arrival=room.cache(bounces=5).arriving())
    straight, every = np.stack([integrator(2, seed) for seed in range(3)]).mean(axis=(0, 4))
    assert straight.mean() == pytest.approx(3.0, rel=0.01)
    expected = 3.0 * sum(0.6**n for n in range(5))
    assert every.mean() == pytest.approx(expected, rel=0.015)
    # Everywhere, not only in the mean.
    blocks = every.reshape(6, 16, 8, 32).mean(axis=(1, 3))
    np.testing.assert_allclose(blocks, expected, rtol=0.1)


@pytest.mark.slow
def test_hemispheres_that_look_it_up_have_equal_bits(few_surfels: None, lit: Any) -> None:
    """For one thread and for several."""
    import drjit as dr

    room = lit(_curtained(), "openrooms")
    integrator = hemispheres_of(room, grid=(8, 6), arrival=room.cache().arriving())
    found = []
    before = dr.thread_count()
    try:
        for threads in (1, 2, 4):
            dr.set_thread_count(threads)
            found.append(integrator(2, 5).tobytes())
    finally:
        dr.set_thread_count(before)
    assert found[0] == found[1] == found[2]


@pytest.mark.slow
def test_the_file_holds_it(
    few_surfels: None, lit: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is read is what was filled; what is not sound is filled again."""
    from orusd_mitsuba.cache import room_light

    monkeypatch.setattr(light_store, "places", lambda scene: (tmp_path,))
    room = lit(little_room(ior=1.5), "openrooms")
    filled = room.cache()._data
    (kept,) = tmp_path.iterdir()
    arrays = light_store.load(kept.stem, (tmp_path,))
    assert arrays is not None
    read = room_light._data_of(arrays, filled.irradiance.shape[1], room.index.count)
    assert read is not None
    np.testing.assert_array_equal(read.irradiance, filled.irradiance)
    for name, wrong in {
        "irradiance": arrays["irradiance"][:, :-1],
        "entries": arrays["entries"][:-1],
        "behind": arrays["behind"] + np.uint32(len(filled.behind)),
        "probes": np.array([0]),
        "size_m": np.array([-1.0]),
    }.items():
        spoilt = {**arrays, name: wrong}
        shape = filled.irradiance.shape[1], room.index.count
        assert room_light._data_of(spoilt, *shape) is None, name


def test_a_room_without_light_has_an_empty_cache(few_surfels: None, lit: Any) -> None:
    made = small.room()
    made.camera((-0.9, -0.9, 0.0), (0.3, 0.4, -0.5), fov=70)
    room = lit(made.stage)
    light = room.cache()
    assert not light._data.irradiance.any()
    assert not room.paths(size=(8, 6), paths=light.paths(by_light=True))(2, 0).any()
