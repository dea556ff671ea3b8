"""Distant lights of an angular size: what they bring, and how soft the edges of shadows are."""

import math
from typing import Any

import numpy as np
import pytest

from tests import small
from tests.mitsuba.rendering import session_of, shown

ANGLE, HEIGHT = 8.0, 1.0
# How far from under the edge of a shadow its last light falls.
REACH = HEIGHT * math.tan(math.radians(ANGLE / 2.0))


def stage(place: float, angle: float, *, shadow: bool = True) -> Any:
    """A white patch under the edge of a board, which is over all that has x above 0."""
    made = small.patch((place, 0, 0), 0.002)
    if shadow:
        black = made.material("/Black", base_color=(0.0,) * 3)
        made.quad("/Board", small.square((4.5, 0, HEIGHT), (4.5, 9)), material=black)
    made.light("Distant", "/Sun", math.pi, angle=angle, normalize=True)
    return made.stage


def view(made: Any, *names: str) -> dict[str, float]:
    session = session_of(made)
    assert [*session.report.losses()] == []
    images = shown(session, *names, width=8, height=8, samples=256, bounces=1).images
    return {name: float(one.pixels[..., 1].mean(dtype=np.float64)) for name, one in images.items()}


@pytest.mark.parametrize("place", [-1.2, -0.5, 0.0, 0.5, 1.2])
def test_the_edge_of_a_shadow_is_as_soft_as_the_disk_is_wide(lit: Any, place: float) -> None:
    """The part of a disk that a straight edge leaves: (acos u - u sqrt(1 - u^2)) / pi."""
    u = min(1.0, max(-1.0, place))
    expected = (math.acos(u) - u * math.sqrt(1.0 - u * u)) / math.pi
    found = view(stage(place * REACH, ANGLE), "radiance")
    assert found["radiance"] == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("angle", [0.0, 0.53, 90.0, 180.0])
def test_normalized_light_is_lux_whatever_its_angle(lit: Any, angle: float) -> None:
    found = view(stage(0.0, angle, shadow=False), "radiance")
    assert found["radiance"] == pytest.approx(1.0, rel=0.01)


@pytest.mark.slow
def test_all_passes_have_the_same_edge(lit: Any) -> None:
    made = stage(0.5 * REACH, ANGLE)
    expected = math.pi * (math.acos(0.5) - 0.5 * math.sqrt(0.75)) / math.pi
    straight = view(made, "direct_i", "unoccluded_i")
    whole = view(made, "radiance", "irradiance", "direct_i", "unoccluded_i")
    for found in (
        straight["direct_0"],
        whole["direct_0"],
        whole["irradiance"],
        math.pi * whole["radiance"],
    ):
        assert found == pytest.approx(expected, rel=0.02)
    for found in (straight["unoccluded_0"], whole["unoccluded_0"]):
        assert found == pytest.approx(math.pi, rel=0.01)


def test_a_backend_of_single_numbers_has_sharp_shadows_and_says_so() -> None:
    made = stage(0.0, ANGLE)
    session = session_of(made, variant="scalar")
    told = [("/Sun", "approximated", "its angle is left out: shadows are sharp")]
    assert [*session.report.losses()] == told
