"""Tones of pictures against closed forms: what is kept, what is balanced, what is never cut."""

from typing import get_args

import numpy as np
import pytest

from openrooms_usd.colorimetry import LUMINANCE, luminance
from openrooms_usd.description.rendering import ToneName
from openrooms_usd.rendering.color import MIDDLE_GREY, film
from openrooms_usd.rendering.previews import preview
from openrooms_usd.rendering.tone import Tone, fitted_tone, white_balance

# What a room of usual colours reflects, and lamps of 2700 K, linear Rec.709.
USUAL = np.array([1.05, 1.0, 0.93])
WARM = np.array([1.935, 0.804, 0.192])


def blocks(luminances: np.ndarray, hue: np.ndarray = USUAL) -> np.ndarray:
    """Every value as 8x8 pixels of one hue."""
    return np.kron(luminances, np.ones((8, 8)))[..., None] * (hue / (hue @ LUMINANCE))


def room(window_stops: float, hue: np.ndarray = USUAL) -> np.ndarray:
    """Walls about middle grey, and a twentieth of the picture so many stops brighter."""
    values = np.exp(np.random.default_rng(1).normal(0.0, 0.7, (20, 20)))
    values[0] *= 2.0**window_stops
    return blocks(values, hue)


def test_the_plain_tone_is_srgb_cut_at_one() -> None:
    linear = np.array([[[0.25, 0.5, 0.75], [1.5, -0.1, 3.0]]])
    np.testing.assert_allclose(
        Tone("srgb", 1.0).shown(linear), [[[0.25, 0.5, 0.75], [1.0, 0.0, 1.0]]], atol=1e-6
    )
    np.testing.assert_allclose(Tone("film", 2.0).shown(linear), film(2.0 * linear), rtol=1e-5)


def test_a_photograph_keeps_black_white_and_middle_grey_and_rises() -> None:
    grey = np.repeat(MIDDLE_GREY * 2 ** np.linspace(-9, 6.4, 300)[:, None], 3, axis=1)
    for slope in (1.0, 0.5):
        shown = Tone("photograph", 1.0, slope=slope).shown(grey)
        assert (np.diff(shown[:, 0]) > 0).all()
        assert np.ptp(shown, axis=1).max() < 1e-5
    middle = Tone("photograph", 1.0).shown(np.full((1, 3), MIDDLE_GREY))
    assert middle == pytest.approx(MIDDLE_GREY, rel=2e-3)
    ends = Tone("photograph", 1.0).shown(np.array([[0.0, 0, 0], [1e9, 1e9, 1e9]]))
    assert ends[0].max() < 1e-6
    assert ends[1].min() > 0.99


@pytest.mark.parametrize("stops", [6.0, 7.5])
def test_windows_keep_their_detail(stops: float) -> None:
    picture = room(stops)
    tone = fitted_tone("photograph", picture)
    shown = preview("radiance", picture.astype(np.float32)).pixels
    window = shown[:8].reshape(-1, 3)
    assert (window.min(axis=1) >= 250).mean() < 0.1
    assert np.ptp(window[:, 1]) > 8
    assert tone.slope < 0.7
    plain = preview("radiance", picture.astype(np.float32), tone="srgb").pixels[:8]
    assert (plain == 255).all()
    # The room is not dull for it: at most 0.4 stops darker.
    assert tone.exposure > 2.0**-0.41 * fitted_tone("film", picture).exposure


def test_a_room_without_bright_windows_is_left_alone() -> None:
    tone = fitted_tone("photograph", room(0.0))
    assert tone.slope == 1.0
    assert tone.balance == pytest.approx((1.0, 1.0, 1.0), abs=1e-6)
    assert tone.exposure == pytest.approx(fitted_tone("film", room(0.0)).exposure, rel=1e-6)


def test_a_picture_with_much_shade_is_not_dark_in_the_mean() -> None:
    picture = room(5.0).astype(np.float32)
    picture[96:] *= 0.1
    before = fitted_tone("photograph", picture, fitted_tone("film", picture).exposure)
    shown = preview("radiance", picture).pixels.astype(np.float64)
    assert (shown @ LUMINANCE).mean() / 255.0 > 0.44
    assert fitted_tone("photograph", picture).exposure <= 2.0**0.61 * before.exposure


def test_lamps_look_warm_and_not_orange() -> None:
    picture = room(0.0, USUAL * WARM)
    factors = np.array(white_balance(picture))
    seen = WARM * factors
    assert seen[0] > 1.1 * seen[1] > 1.1 * seen[2]
    assert seen[2] / seen[0] > 3.0 * WARM[2] / WARM[0]
    # The picture is about as bright as before: the light is, and what it falls on is a hue of it.
    assert luminance(picture * factors).mean() == pytest.approx(luminance(picture).mean(), rel=0.03)


def test_green_walls_stay_green() -> None:
    factors = white_balance(room(0.0, USUAL * [0.6, 1.0, 0.6]))
    assert factors[0] == pytest.approx(1.0, abs=0.12)
    assert factors[2] == pytest.approx(1.0, abs=0.12)


def test_what_is_asked_for_is_kept_and_told() -> None:
    picture = room(7.0).astype(np.float32)
    tone = fitted_tone("photograph", picture, 0.125, (1.2, 1.0, 0.8))
    assert (tone.exposure, tone.balance) == (0.125, (1.2, 1.0, 0.8))
    for name in get_args(ToneName):
        assert "exposure 0.125 (of the camera)" in preview("radiance", picture, 0.125, name).shows
    shown = preview("radiance", picture, tone=tone)
    assert "white balance 1.2 1 0.8" in shown.shows
    # One tone for many pictures: what is alike looks alike, whatever else is in them.
    other = picture.copy()
    other[:80] *= 9.0
    np.testing.assert_array_equal(
        preview("radiance", other, tone=tone).pixels[80:], shown.pixels[80:]
    )


def test_grey_stays_grey() -> None:
    assert white_balance(room(0.0, np.ones(3))) == (1.0, 1.0, 1.0)


def test_nothing_lit_is_black() -> None:
    dark = np.zeros((9, 9, 3), np.float32)
    assert white_balance(dark) == (1.0, 1.0, 1.0)
    for name in get_args(ToneName):
        assert not preview("radiance", dark, tone=name).pixels.any()


def test_things_before_nothing_have_the_exposure_of_things_before_a_wall() -> None:
    """An outline is half black, and noise leaves single pixels without light."""
    random = np.random.default_rng(3)
    thing = 0.001 * random.uniform(0.5, 2.0, (120, 160, 1)) * np.ones(3)
    thing[random.uniform(size=(120, 160)) < 0.1] = 0.0
    rows, columns = np.mgrid[:120, :160]
    outside = (rows - 60) ** 2 + (columns - 80) ** 2 > 30**2
    alone = np.where(outside[..., None], 0.0, thing).astype(np.float32)
    whole = fitted_tone("photograph", thing.astype(np.float32))
    assert fitted_tone("photograph", alone).exposure == pytest.approx(whole.exposure, rel=0.1)
    # Where nothing is lit for more than a part, what there is counts.
    specks = np.where(random.uniform(size=(120, 160, 1)) < 0.02, 1.0, 0.0) * np.ones(3)
    assert 0.5 < fitted_tone("film", specks.astype(np.float32)).exposure < 50.0
