"""Stored textures: what files hold is what was made, physical and the same everywhere."""

import hashlib
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from openrooms_usd.arrays import Array, Bytes
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.description import families
from openrooms_usd.description.substances import Substance
from openrooms_usd.errors import InputError
from openrooms_usd.library import textures
from openrooms_usd.library.styles.finishes import FINISHES
from openrooms_usd.library.textures import FAMILIES, TextureSet, catalogue, family_of, make
from openrooms_usd.library.textures.base.maps import Maps, encoded, normals
from openrooms_usd.library.textures.base.noise import band_noise, smooth_noise

SEVERAL = ("oak_planks", "herringbone_parquet", "roller_matt", "terrazzo", "denim", "rusted_iron")


def rng(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


def linear(encoded_bytes: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1, the way back."""
    v = encoded_bytes / 255.0
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def digest(made: textures.TextureSet) -> str:
    fields = (getattr(made, item) for item in textures.MAPS)
    return hashlib.sha256(b"".join(field.tobytes() for field in fields)).hexdigest()


@pytest.mark.one_in(6)
@pytest.mark.parametrize("name", SEVERAL)
def test_name_and_number_say_which(name: str) -> None:
    digests = [digest(textures.make(name, n, resolution=64)) for n in (4, 4, 5)]
    assert digests[0] == digests[1] != digests[2]


def test_families_draw_apart() -> None:
    """The same number of two families of one recipe does not draw the same chances."""
    made = [textures.make(name, 1, resolution=64) for name in ("ash_veneer", "zebrano")]
    green = [one.albedo[..., 1].ravel() for one in made]
    assert abs(np.corrcoef(*green)[0, 1]) < 0.5


@pytest.mark.parametrize("name", SEVERAL)
def test_a_colour_changes_nothing_but_the_colour(name: str) -> None:
    own = textures.make(name, 2, resolution=64)
    dyed = textures.make(name, 2, color=(0.2, 0.3, 0.15), roughness=0.6, resolution=64)
    np.testing.assert_array_equal(own.height, dyed.height)
    np.testing.assert_array_equal(own.normal, dyed.normal)
    np.testing.assert_allclose(linear(dyed.albedo).mean((0, 1)), (0.2, 0.3, 0.15), rtol=0.08)
    assert dyed.roughness.mean() / 255.0 == pytest.approx(0.6, abs=0.05)


@pytest.mark.slow
def test_files_are_equal_in_another_process(tmp_path: Path) -> None:
    program = (
        "import sys; from pathlib import Path\n"
        "from openrooms_usd.library import textures\n"
        "made = textures.make('twill', 9, resolution=64)\n"
        "textures.write_set(made, Path(sys.argv[1]), 'a')\n"
    )
    subprocess.run([sys.executable, "-c", program, str(tmp_path / "other")], check=True)
    files = textures.write_set(textures.make("twill", 9, resolution=64), tmp_path / "here", "a")
    assert [file.name for file in files] == [f"a_{item}.png" for item in textures.MAPS]
    for file in files:
        here = file.read_bytes()
        assert here == (tmp_path / "other" / file.name).read_bytes()
        assert b"tIME" not in here and b"DateTime" not in here
        # Data must not claim to be colours.
        assert (b"sRGB" in here) == ("albedo" in file.name)


def test_files_hold_what_was_made(tmp_path: Path) -> None:
    import OpenImageIO

    made = textures.make("rusted_iron", 0, resolution=64)
    for file, item in zip(textures.write_set(made, tmp_path, "a"), textures.MAPS, strict=True):
        stored = np.atleast_3d(getattr(made, item))
        buffer = OpenImageIO.ImageBuf(str(file))
        kind = OpenImageIO.UINT16 if item == "height" else OpenImageIO.UINT8
        np.testing.assert_array_equal(np.atleast_3d(buffer.get_pixels(kind)), stored)
    low, high = made.height_range
    said = buffer.spec().getattribute("ImageDescription")
    assert said == f"height: black {low:.4e} m, white {high:.4e} m"


def test_heights_are_metres() -> None:
    """What sixteen bits and the range say is the relief, about its mean, to half a step."""
    relief = 0.003 * smooth_noise(rng(0), 64, 1.0, (0.2, 0.2)) + 5.0
    made = encoded(Maps(np.full((64, 64, 3), 0.5), relief, np.full((64, 64), 0.5)), 1.0)
    low, high = made.height_range
    told = low + (high - low) * made.height / 65535.0
    np.testing.assert_allclose(told, relief - relief.mean(), atol=(high - low) / 65535.0)
    assert abs(told.mean()) < 1e-6


def test_stored_normals_are_those_of_the_stored_height() -> None:
    made = textures.make("cobblestone", 0, resolution=128)
    low, high = made.height_range
    told = normals(low + (high - low) * made.height / 65535.0, made.size / 128)
    np.testing.assert_allclose(made.normal / 255.0 * 2.0 - 1.0, told, atol=0.012)


def test_normals_of_a_known_relief() -> None:
    """h = A sin(2 pi s) + B cos(2 pi t), t upwards: n ~ (-dh/ds, -dh/dt, 1)."""
    n, size, A, B = 256, 0.5, 0.01, 0.02
    s = (np.arange(n) + 0.5) / n * size
    t = size - s
    k = 2 * np.pi / size
    height = A * np.sin(k * s)[None, :] + B * np.cos(k * t)[:, None]
    ds, dt = np.meshgrid(A * k * np.cos(k * s), -B * k * np.sin(k * t))
    expected = np.stack([-ds, -dt, np.ones_like(ds)], axis=-1)
    expected /= np.linalg.norm(expected, axis=-1, keepdims=True)
    np.testing.assert_allclose(normals(height, size / n), expected, atol=2e-4)


def test_slopes_are_physical() -> None:
    """Twice the size with the same relief is half as steep; so is the stored normal map."""
    field = smooth_noise(rng(0), 64, 1.0, (0.2, 0.2)) * 0.001
    steep, flat = normals(field, 1 / 64), normals(field, 2 / 64)
    slopes = [vector[..., 0] / vector[..., 2] for vector in (steep, flat)]
    np.testing.assert_allclose(slopes[0], 2.0 * slopes[1], atol=1e-12)


def test_srgb_encoding_is_inverted_by_its_definition() -> None:
    values = np.linspace(0.0, 1.0, 1001)
    np.testing.assert_allclose(linear(srgb_from_linear(values) * 255.0), values, atol=1e-6)


def test_noise_has_the_wavelength_that_is_asked_for() -> None:
    """The mean frequency of its power spectrum, by a plain Fourier transform."""
    size, n = 1.0, 256
    for wavelength in (0.05, 0.1):
        power = np.abs(np.fft.fft2(band_noise(rng(1), n, size, wavelength))) ** 2
        f = np.fft.fftfreq(n, size / n)
        radius = np.hypot(f[:, None], f[None, :])
        assert (power * radius).sum() / power.sum() * wavelength == pytest.approx(1.0, abs=0.15)


def test_flat_is_flat() -> None:
    flat = np.full((8, 8), 0.5)
    for metallic, brightest in ((0.0, 0.9), (1.0, 1.0)):
        made = encoded(Maps(np.full((8, 8, 3), 2.0), flat, flat, metallic), 1.0)
        assert np.unique(made.normal.reshape(-1, 3), axis=0).tolist() == [[128, 128, 255]]
        # Cut off at the brightest that is plausible.
        assert linear(made.albedo).max() == pytest.approx(brightest, abs=0.005)
        assert made.metallic.min() == made.metallic.max() == round(255 * metallic)


def test_unknown_names_are_refused() -> None:
    with pytest.raises(InputError, match="no material family 'oak_plank'") as caught:
        textures.make("oak_plank", 0)
    assert "oak_planks" in str(caught.value)
    assert textures.substance_of("oak_planks") == "wood"


LARGE_PATTERNS = {"damask", "houndstooth", "seersucker", "tartan", "ticking", "stitched_leather"}


def clouds(picture: Bytes, size: float, longest: float) -> Array:
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
    monkeypatch.setattr(catalogue, "_CLOUDS", {})
    new = make(name, 2, resolution=64).roughness.astype(np.float64)
    change = (used + 1.0) / (new + 1.0)
    assert abs(change.mean() - 1.0) < 0.02 and 0.02 < change.std() < 0.15
    neighbours = np.corrcoef(change.ravel(), np.roll(change, 1, axis=1).ravel())[0, 1]
    assert neighbours > 0.5


def test_every_family_says_how_often_it_is_laid() -> None:
    for kinds in FAMILIES.values():
        for name, family in kinds.items():
            assert family.laid in (1, 2, 4), name
            assert family.repeat == pytest.approx(family.size * family.laid)


NAMES = [name for families in FAMILIES.values() for name in families]
RESOLUTION = 128
LEARNT, ASKED = (0, 1), (2,)
# Of the picture's side: what is compared is relative to it, and the side itself.
# One step of eight bits, as a share of a middle brightness.
STEP = 0.01
BANDS = np.geomspace(1.0, RESOLUTION / 2, 13)
WEIGHTS = np.array([0.2126, 0.7152, 0.0722])


def statistics(made: TextureSet) -> Array:
    """(F,) what a material is like, whatever its colour."""
    light = np.log((made.albedo / 255.0) ** 2.2 @ WEIGHTS + 0.01)
    low, high = made.height_range
    relief = low + (high - low) * made.height / 65535.0
    gloss = made.roughness / 255.0
    fields = [light, relief, gloss]
    strengths = [
        np.log(light.std() + 1e-3),
        np.log(relief.std() + 1e-7),
        np.log(slopes(relief, made.size) + 1e-3),
        np.log(gloss.std() + 1e-3),
        np.log(chroma(made) + 1e-3),
    ]
    together = [correlation(a, b) for a, b in [(light, relief), (light, gloss), (relief, gloss)]]
    shapes = [shape for field in fields for shape in histogram(field)]
    spectra = [share for field in ((light, STEP), (relief, 1e-8)) for share in spectrum(*field)]
    return np.array([*strengths, *together, *shapes, *spectra, 3.0 * np.log(made.size)])


def slopes(relief: Array, size: float) -> float:
    texel = size / len(relief)
    return float(np.hypot(*np.gradient(relief, texel)).mean())


def chroma(made: TextureSet) -> float:
    """How much the hue varies: of ratios, so that a tint of the whole falls out."""
    ratios = np.log(made.albedo + 8.0)
    return float((ratios - ratios.mean(axis=-1, keepdims=True)).std(axis=(0, 1)).mean())


def correlation(a: Array, b: Array) -> float:
    return float(((a - a.mean()) * (b - b.mean())).mean() / (a.std() * b.std() + 1e-9))


def histogram(field: Array) -> tuple[float, float]:
    """Skewness and the logarithm of kurtosis."""
    z = (field - field.mean()) / (field.std() + 1e-9)
    return float(np.clip((z**3).mean(), -4, 4)), float(np.log((z**4).mean() + 0.1))


def spectrum(field: Array, floor: float) -> Array:
    """Logarithms of the shares of power in bands of frequency and in directions.

    Args:
        field: The field.
        floor: Standard deviation of what is no more than rounding.
    """
    total_floor = (floor * field.size) ** 2
    power = np.abs(np.fft.fft2(field - field.mean())) ** 2
    f = np.fft.fftfreq(len(field), 1.0 / len(field))
    radius, angle = np.hypot(f[:, None], f), np.arctan2(f[:, None], f) % np.pi
    band = np.digitize(radius, BANDS)
    sector = np.round(angle / np.pi * 8).astype(int) % 8
    # Lines of an exact lattice are told from the spread of a random one by their peak.
    total = power.sum() + total_floor
    peak = power.max() / total
    bands = np.bincount(band.ravel(), power.ravel(), len(BANDS) + 1)
    sectors = np.bincount(sector.ravel(), power.ravel(), 8)
    shares = np.concatenate([bands, sectors]) / total
    return np.concatenate([np.log10(shares + 3e-4), [2.0 * peak]])


@cache
def sample(name: str, number: int) -> Array:
    return statistics(make(name, number, resolution=RESOLUTION))


def told_apart(learnt: Array, asked: Array) -> list[tuple[int, int]]:
    """Pairs (is, taken for) of families of which a material is nearer to another family's mean.

    Args:
        learnt: (families, materials, F).
        asked: (families, materials, F) others of the same families.
    """
    means = learnt.mean(axis=1)
    within = np.sqrt(((learnt - means[:, None]) ** 2).mean(axis=(0, 1))) + 1e-3
    distances = (((asked[:, :, None] - means) / within) ** 2).sum(axis=-1)
    nearest = distances.argmin(axis=-1)
    return [(i, int(j)) for i, row in enumerate(nearest) for j in row if j != i]


def test_every_substance_has_twelve_families() -> None:
    assert set(FAMILIES) == set(get_args(Substance))
    assert {kind: len(families) for kind, families in FAMILIES.items() if len(families) < 12} == {}


def test_names_are_unique_words() -> None:
    assert len(set(NAMES)) == len(NAMES)
    assert all(name.isidentifier() and name == name.lower() for name in NAMES)


@pytest.mark.long
@pytest.mark.slow
def test_families_differ_in_structure() -> None:
    """Materials never seen are recognised among all families, by structure alone."""
    learnt = np.array([[sample(name, number) for number in LEARNT] for name in NAMES])
    asked = np.array([[sample(name, number) for number in ASKED] for name in NAMES])
    assert [(NAMES[a], NAMES[b]) for a, b in told_apart(learnt, asked)] == []


def test_a_recoloured_copy_is_found_out() -> None:
    """Other colours of the same recipe are not taken for another family."""
    dyed = np.array(
        [
            [
                statistics(make("oak_planks", n, color=(0.3, 0.1, 0.2), resolution=RESOLUTION))
                for n in LEARNT
            ]
        ]
    )
    own = np.array([[sample("oak_planks", n) for n in LEARNT]])
    other = np.array([[sample("vinyl_planks", n) for n in LEARNT]])
    apart, copied = np.abs(own - other).mean(), np.abs(own - dyed).mean()
    assert copied < 0.2 * apart
    # As a second family it would be taken for the first, and the test above would say so.
    asked = np.array([[sample("oak_planks", n) for n in ASKED]])
    both = np.concatenate([own, dyed]), np.concatenate([asked, asked])
    assert told_apart(*both) != []


def test_names_are_those_of_the_description() -> None:
    assert {kind: set(names) for kind, names in FAMILIES.items()} == {
        kind: set(names) for kind, names in families.FAMILIES.items()
    }
    assert set(get_args(families.Family)) == set(NAMES)
