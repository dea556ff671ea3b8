"""Procedural materials: they tile, keep to plausible values, and are the same everywhere."""

import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.errors import InputError
from openrooms_usd.library import textures
from openrooms_usd.library.textures import FAMILIES, TextureSet
from openrooms_usd.library.textures.maps import encoded, normals, srgb_from_linear
from openrooms_usd.library.textures.noise import band_noise, smooth_noise
from openrooms_usd.library.textures.wood import SPECIES

ALL = [(family, variant) for family, variants in FAMILIES.items() for variant in variants]
WEIGHTS = np.array([0.2126, 0.7152, 0.0722])
# Plausible mean luminous reflectances; floors and furniture take any wood.
REFLECTANCE = {"wood": (0.06, 0.5), "paint": (0.45, 0.85), "fabric": (0.05, 0.6)}


def rng(seed: int) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


def make(family: str, variant: str, seed: int = 0, **options: object) -> TextureSet:
    return textures.make(family, rng(seed), variant=variant, resolution=128, **options)  # type: ignore[arg-type]


def linear(encoded_bytes: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1, the way back."""
    v = encoded_bytes / 255.0
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize(("family", "variant"), ALL)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_values_are_plausible(family: str, variant: str, seed: int) -> None:
    made = make(family, variant, seed)
    albedo = linear(made.albedo)
    low, high = REFLECTANCE[family]
    assert low <= float((albedo @ WEIGHTS).mean()) <= high
    assert albedo.min() >= 0.019 and albedo.max() <= 0.91
    assert 0.2 <= made.roughness.mean() / 255.0 <= 1.0
    vectors = made.normal / 255.0 * 2.0 - 1.0
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=-1), 1.0, atol=0.02)
    assert vectors[..., 2].min() > 0.2
    np.testing.assert_allclose(vectors[..., :2].mean(axis=(0, 1)), 0.0, atol=0.01)


@pytest.mark.parametrize(("family", "variant"), ALL)
@pytest.mark.parametrize("picture", ["albedo", "normal", "roughness"])
def test_they_tile_without_a_seam(family: str, variant: str, picture: str) -> None:
    """Steps across the seam are like those between neighbours elsewhere, in both directions."""
    pixels = getattr(make(family, variant, 3), picture).astype(float)
    for axis in (0, 1):
        steps = np.abs(np.diff(pixels, axis=axis, append=np.take(pixels, [0], axis=axis)))
        means = np.moveaxis(steps, axis, 0).reshape(pixels.shape[axis], -1).mean(axis=1)
        inside, seam = means[:-1], means[-1]
        assert seam <= inside.max() * 1.05 + 0.25, (axis, seam, inside.max())


@pytest.mark.parametrize(("family", "variant"), ALL)
def test_what_is_given_is_kept(family: str, variant: str) -> None:
    color = (0.2, 0.3, 0.15)
    made = make(family, variant, color=color, roughness=0.6)
    np.testing.assert_allclose(linear(made.albedo).mean(axis=(0, 1)), color, rtol=0.06)
    assert made.roughness.mean() / 255.0 == pytest.approx(0.6, abs=0.05)


@pytest.mark.parametrize(("family", "variant"), ALL)
def test_the_same_seed_gives_the_same_bytes_and_another_gives_others(
    family: str, variant: str
) -> None:
    digests = [
        hashlib.sha256(made.albedo.tobytes() + made.normal.tobytes()).hexdigest()
        for made in (make(family, variant, seed) for seed in (4, 4, 5))
    ]
    assert digests[0] == digests[1] != digests[2]


def test_files_are_equal_in_another_process(tmp_path: Path) -> None:
    program = (
        "import sys; from pathlib import Path; import numpy as np\n"
        "from openrooms_usd.library import textures\n"
        "made = textures.make('fabric', np.random.Generator(np.random.PCG64(9)), resolution=64)\n"
        "textures.write_set(made, Path(sys.argv[1]), 'a')\n"
    )
    subprocess.run([sys.executable, "-c", program, str(tmp_path / "other")], check=True)
    made = textures.make("fabric", rng(9), resolution=64)
    textures.write_set(made, tmp_path / "here", "a")
    for name in ("a_albedo.png", "a_normal.png", "a_roughness.png"):
        here, other = (tmp_path / "here" / name).read_bytes(), tmp_path / "other" / name
        assert here == other.read_bytes()
        assert b"tIME" not in here and b"DateTime" not in here
        # Data must not claim to be colours.
        assert (b"sRGB" in here) == ("albedo" in name)


def test_files_hold_what_was_made(tmp_path: Path) -> None:
    from openrooms_usd.usd.textures import read_texture

    made = make("wood", "panel")
    textures.write_set(made, tmp_path, "a")
    for name in ("albedo", "normal", "roughness"):
        stored = np.atleast_3d(getattr(made, name))
        read = read_texture(str(tmp_path / f"a_{name}.png")) * 255.0
        np.testing.assert_allclose(read, stored, atol=1e-3)


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
    encoded_values = srgb_from_linear(values) * 255.0
    np.testing.assert_allclose(linear(encoded_values), values, atol=1e-6)


def test_noise_has_the_wavelength_that_is_asked_for() -> None:
    """The mean frequency of its power spectrum, by a plain Fourier transform."""
    size, n = 1.0, 256
    for wavelength in (0.05, 0.1):
        power = np.abs(np.fft.fft2(band_noise(rng(1), n, size, wavelength))) ** 2
        f = np.fft.fftfreq(n, size / n)
        radius = np.hypot(f[:, None], f[None, :])
        assert (power * radius).sum() / power.sum() * wavelength == pytest.approx(1.0, abs=0.15)


def test_grain_runs_along_t() -> None:
    pixels = linear(make("wood", "panel").albedo) @ WEIGHTS
    along_t, along_s = np.abs(np.diff(pixels, axis=0)).mean(), np.abs(np.diff(pixels)).mean()
    assert along_t < 0.5 * along_s


def test_a_cloth_has_a_whole_number_of_yarns() -> None:
    """The strongest frequency of the relief is a whole number of yarns of a plausible pitch."""
    made = textures.make("fabric", rng(0), variant="plain", resolution=512)
    slope = made.normal[..., 0].astype(float) - 127.5
    spectrum = np.abs(np.fft.rfft(slope.mean(axis=0)))
    yarns = int(np.argmax(spectrum[1:])) + 1
    assert made.size / yarns == pytest.approx(0.0019, abs=0.0004)
    # A part of a yarn at the seam would spread the line over its neighbours.
    assert max(spectrum[yarns - 1], spectrum[yarns + 1]) < 0.1 * spectrum[yarns]


def test_all_woods_are_drawn() -> None:
    colors = {tuple(np.round(make("wood", "panel", s).albedo.mean((0, 1)), -1)) for s in range(40)}
    assert len(colors) >= len(SPECIES)


def test_sizes_say_what_came_out() -> None:
    assert make("wood", "panel", physical_size=1.5).size == 1.5
    floor = make("wood", "floor", physical_size=1.5)
    assert floor.size == 3.0 and floor.albedo.shape == (256, 256, 3)
    assert make("fabric", "twill").size == 0.25


@pytest.mark.parametrize(("family", "variant"), ALL)
def test_the_smallest_resolution(family: str, variant: str) -> None:
    made = textures.make(family, rng(0), variant=variant, resolution=16, physical_size=20.0)
    assert made.albedo.dtype == np.uint8 and made.roughness.ndim == 2


def test_unknown_names_are_refused() -> None:
    with pytest.raises(InputError, match="no material family 'glass'"):
        textures.make("glass", rng(0))
    with pytest.raises(InputError, match="wood has no variant 'cork'"):
        textures.make("wood", rng(0), variant="cork")


def test_flat_is_flat() -> None:
    from openrooms_usd.library.textures.maps import Maps

    flat = np.full((8, 8), 0.5)
    made = encoded(Maps(np.full((8, 8, 3), 2.0), flat, flat), 1.0)
    assert np.unique(made.normal.reshape(-1, 3), axis=0).tolist() == [[128, 128, 255]]
    # Cut off at the brightest that is plausible.
    assert linear(made.albedo).max() == pytest.approx(0.9, abs=0.005)
