"""Paths, kind by kind and light by light: what theory says, whatever they are cut into."""

from typing import Any

import numpy as np
import pytest

from tests import small
from tests.mitsuba.rendering import passes
from tests.mitsuba.rooms import little_room
from tests.mitsuba.statistics import assert_alike


@pytest.mark.slow
def test_a_light_that_is_off_is_dark_and_changes_no_other(lit: Any) -> None:
    both, one = (passes(lit(little_room(lamp=nits)).paths(size=(24, 18))) for nits in (50.0, 0.0))
    # After the three kinds: the lamp, the window, the rest.
    assert_alike(both[:, 4], one[:, 4])
    assert one[:, 3].max() == 0.0 and both[:, 3].max() > 0.0


@pytest.mark.slow
def test_bands_and_passes_agree_within_their_noise(
    lit: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from orusd_mitsuba.transport import bands

    room = lit(little_room())
    whole = passes(room.paths(size=(24, 18)))
    monkeypatch.setattr(bands, "_PATHS_IN_FLIGHT", 24 * 5)
    banded = room.paths(size=(24, 18))
    assert banded.most == 1
    many = passes(banded, count=48, samples=4, seed=700)
    assert_alike(whole[:, 3:].sum(axis=1), many[:, :3].sum(axis=1))


@pytest.mark.parametrize(("albedo", "bounces"), [(0.0, 7), (0.6, 7), (1.0, 7), (0.95, 50)])
def test_a_glowing_room_adds_one_power_of_the_albedo_for_each_bounce(
    lit: Any, albedo: float, bounces: int
) -> None:
    """A furnace: emission 1, direct a, indirect a^2 + ... + a^bounces."""
    made = small.room(4.0, base_color=(albedo,) * 3, emissive=(1.0, 1.0, 1.0))
    made.camera((0.3, -0.5, 0.2), (1, 1, 0.1))
    found = passes(lit(made.stage).paths(bounces + 1, by_light=False), 4, 16)
    powers = albedo ** np.arange(bounces + 1)
    expected = [powers[0], powers[1], powers[2:].sum()]
    means = found.mean(axis=(0, 2, 3, 4))
    pixels = found.mean(axis=-1)
    error = pixels.std(axis=(0, 2, 3)) / np.sqrt(pixels[:, 0].size)
    assert (np.abs(means - expected) <= 4.5 * error + 2e-4 * np.array(expected)).all()
