"""Lights are sampled by what they bring, and the choice changes no mean."""

from typing import Any

import numpy as np
import pytest

from openrooms_usd.rendering.scene.translate import translate
from openrooms_usd.usd.light.lights import Portal, define_portal
from orusd_mitsuba.plugins.light_weights import light_weights
from tests import small


def lamps(*, nits: tuple[float, float], sky: float, inlet: float) -> Any:
    room = small.Stage()
    for number, value in enumerate(nits):
        room.light(
            "Rect", f"/Lamp_{number}", value, at=(3.0 * number, 0.0, 0.0), width=2.0, height=0.5
        )
    room.dome(radiance=sky)
    if inlet:
        define_portal(room.stage, Portal("/Portal", np.eye(4), inlet, 1.0))
    return room.stage


def test_weights_follow_the_flux_and_leave_a_share_to_every_light() -> None:
    weights = light_weights(translate(lamps(nits=(100.0, 300.0), sky=50.0, inlet=4.0)))
    # pi L A of two lamps of 1 m2, and pi L of the sky through 4 m2.
    flux = np.pi * np.array([50.0 * 4.0, 100.0, 300.0])
    expected = 0.75 * flux / flux.sum() + 0.25 / 3
    assert [weights.sky, *weights.patches.values()] == pytest.approx(expected.tolist(), rel=1e-5)


def test_without_portals_the_sky_weighs_as_much_as_all_lamps() -> None:
    weights = light_weights(translate(lamps(nits=(1.0, 9.0), sky=5.0, inlet=0.0)))
    assert weights.sky == 2.0
    assert list(weights.patches.values()) == [1.0, 1.0]


def test_darkness_is_shared_evenly() -> None:
    weights = light_weights(translate(lamps(nits=(0.0, 0.0), sky=0.0, inlet=1.0)))
    assert np.isfinite([weights.sky, *weights.patches.values()]).all()
