"""Stored textures: what files hold is what was made, physical and the same everywhere."""

import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.errors import InputError
from openrooms_usd.library import textures
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
