"""Cloth and hides do not repeat every few centimetres, and use has left marks in their gloss."""

import numpy as np
import pytest
from numpy.typing import NDArray

from openrooms_usd.library.finishes import FINISHES
from openrooms_usd.library.textures import FAMILIES, family_of, make
from openrooms_usd.library.textures.base import expanse

LARGE_PATTERNS = {"damask", "houndstooth", "seersucker", "tartan", "ticking", "stitched_leather"}


def clouds(picture: NDArray[np.uint8], size: float, longest: float) -> NDArray[np.float64]:
    """The long waves of a picture's brightness, by a filter in the frequency domain."""
    spectrum = np.fft.fft2(picture.astype(np.float64).mean(axis=2))
    frequency = np.fft.fftfreq(len(picture), size / len(picture))
    spectrum[np.hypot(*np.meshgrid(frequency, frequency)) > 3.0 / longest] = 0.0
    spectrum[0, 0] = 0.0
    return np.real(np.fft.ifft2(spectrum))


def likeness(name: str, *, lay: bool) -> float:
    """How much the clouds of a cloth are those of the same cloth one small picture farther on."""
    family = family_of(name)
    if lay:
        picture = make(name, 3, resolution=128, size=family.repeat).albedo
    else:
        small = make(name, 3, resolution=128 // family.laid).albedo
        picture = np.tile(small, (family.laid, family.laid, 1))
    waves = clouds(picture, family.repeat, family.size)
    shifted = np.roll(waves, 128 // family.laid, axis=1)
    return float(np.corrcoef(waves.ravel(), shifted.ravel())[0, 1])


@pytest.mark.parametrize("name", ["velvet", "linen", "cut_carpet", "corduroy", "suede"])
def test_clouds_do_not_come_again_with_the_small_picture(name: str) -> None:
    assert likeness(name, lay=False) > 0.999
    assert likeness(name, lay=True) < 0.35


def test_cloth_and_hide_repeat_after_thirty_centimetres_at_least() -> None:
    short = {
        name
        for finish in ("upholstery", "hide", "drape", "linen", "carpet")
        for name in FINISHES[finish].families
        if family_of(name).repeat < 0.3
    }
    assert short <= LARGE_PATTERNS | {"satin"}


def test_a_laid_cloth_keeps_the_means_that_were_asked_for() -> None:
    made = make("twill", 1, color=(0.2, 0.1, 0.05), resolution=64, size=family_of("twill").repeat)
    linear = (made.albedo / 255.0) ** 2.2
    assert np.allclose(linear.mean(axis=(0, 1)), (0.2, 0.1, 0.05), rtol=0.08)


@pytest.mark.parametrize("name", ["polished_metal", "high_gloss_lacquer", "quartered_oak"])
def test_use_changes_gloss_mildly_over_centimetres(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    used = make(name, 2, resolution=64).roughness.astype(np.float64)
    monkeypatch.setattr(expanse, "_CLOUDS", {})
    new = make(name, 2, resolution=64).roughness.astype(np.float64)
    change = (used + 1.0) / (new + 1.0)
    assert abs(change.mean() - 1.0) < 0.02 and 0.02 < change.std() < 0.15
    neighbours = np.corrcoef(change.ravel(), np.roll(change, 1, axis=1).ravel())[0, 1]
    assert neighbours > 0.5


def test_every_family_says_how_often_it_is_laid() -> None:
    for families in FAMILIES.values():
        for name, family in families.items():
            assert family.laid in (1, 2, 4), name
            assert family.repeat == pytest.approx(family.size * family.laid)
