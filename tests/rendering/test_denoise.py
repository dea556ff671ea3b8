"""Denoised radiance: beside the raw one, of the same scale, and never what is no number."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.channels import CHANNELS
from openrooms_usd.description.rendering import RenderSettings
from openrooms_usd.errors import InputError, MissingPackageError, RenderError
from openrooms_usd.rendering import exr, render_stage
from openrooms_usd.rendering.denoise import DENOISED, Denoiser, load_denoiser
from openrooms_usd.rendering.reading import read_render

SIZE = (64, 96)
GUIDE_SEED = 17
"""Of the guides that the renderer of these tests gives."""


@pytest.fixture(scope="module")
def denoiser() -> Denoiser:
    return load_denoiser()


def clean(level: float = 100.0) -> np.ndarray:
    """A picture with an edge and a slope."""
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]]
    left = columns < SIZE[1] // 2
    light = np.where(left, 1.0, 0.3) * (0.6 + 0.4 * rows / SIZE[0])
    return (level * light[..., None] * np.array([1.0, 0.8, 0.6])).astype(np.float32)


def noisy(level: float = 100.0, seed: int = 3) -> np.ndarray:
    noise = np.random.default_rng(seed).exponential(1.0, (*SIZE, 1))
    return (clean(level) * noise).astype(np.float32)


def guides() -> dict[str, np.ndarray]:
    color = np.full((*SIZE, 3), 0.5, np.float32)
    normal = np.zeros((*SIZE, 3), np.float32)
    normal[..., 2] = 1.0
    return {"base_color": color, "normal": normal}


def error(pixels: np.ndarray) -> float:
    return float(((pixels - clean()) ** 2).mean() / (clean() ** 2).mean())


def test_noise_goes_and_the_mean_stays(denoiser: Denoiser) -> None:
    found = denoiser.denoise(noisy(), guides())
    assert found.dtype == np.float32 and found.shape == (*SIZE, 3)
    assert error(found) < 0.03 * error(noisy())
    assert found.mean() == pytest.approx(clean().mean(), rel=0.05)


@pytest.mark.parametrize("factor", [2.0**-30, 1e-6, 3.7, 2.0**20])
def test_brightness_is_only_a_factor(denoiser: Denoiser, factor: float) -> None:
    """From a night without moon to the sun's own disk."""
    reference = denoiser.denoise(noisy(), guides())
    scaled = denoiser.denoise((noisy() * np.float32(factor)).astype(np.float32), guides())
    tolerance = 0.0 if np.log2(factor) == round(np.log2(factor)) else 2e-3
    np.testing.assert_allclose(scaled / np.float32(factor), reference, rtol=tolerance)


def test_an_even_picture_stays_even(denoiser: Denoiser) -> None:
    found = denoiser.denoise(np.full((*SIZE, 3), 123.4, np.float32), guides())
    np.testing.assert_allclose(found, 123.4, rtol=0.005)


def test_a_single_pixel_is_a_picture(denoiser: Denoiser) -> None:
    one = {name: pixels[:1, :1] for name, pixels in guides().items()}
    found = denoiser.denoise(np.full((1, 1, 3), 5.0, np.float32), one)
    np.testing.assert_allclose(found, 5.0, rtol=0.005)


def test_what_is_no_number_does_not_spread(denoiser: Denoiser) -> None:
    pixels = noisy()
    pixels[5, 5] = np.nan
    pixels[40, 60] = np.inf
    pixels[20, 30] = -5.0
    found = denoiser.denoise(pixels, guides())
    assert np.isfinite(found).all() and (found >= 0).all()
    assert error(found) < 0.05 * error(noisy())


def test_a_black_picture_stays_black(denoiser: Denoiser) -> None:
    assert not denoiser.denoise(np.zeros((*SIZE, 3), np.float32), guides()).any()


@pytest.mark.slow
def test_the_number_of_threads_changes_no_byte(denoiser: Denoiser) -> None:
    pixels = noisy()
    script = (
        "import os, sys; import numpy as np\n"
        "os.sched_setaffinity(0, {sorted(os.sched_getaffinity(0))[0]})\n"
        "from openrooms_usd.rendering.denoise import load_denoiser\n"
        f"height, width = {SIZE}\n"
        "read = lambda: np.frombuffer(sys.stdin.buffer.read(12 * height * width), np.float32)\n"
        "radiance, color, normal = (read().reshape(height, width, 3) for _ in range(3))\n"
        "guides = {'base_color': color, 'normal': normal}\n"
        "found = load_denoiser().denoise(radiance, guides)\n"
        "sys.stdout.buffer.write(found.tobytes())\n"
    )
    if not hasattr(os, "sched_setaffinity"):
        pytest.skip("a process cannot be kept on one core here")
    given = b"".join(np.ascontiguousarray(p).tobytes() for p in (pixels, *guides().values()))
    done = subprocess.run([sys.executable, "-c", script], input=given, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()
    assert done.stdout == denoiser.denoise(pixels, guides()).tobytes()


def test_the_raw_radiance_is_kept_beside_it(renderer, scene, tmp_path, numbers) -> None:
    channels = ["radiance", "depth"]
    render_stage(scene, tmp_path / "raw", RenderSettings(channels=channels), cameras=["left"])
    summary = render_stage(
        scene, tmp_path / "out", RenderSettings(channels=channels, denoise=True), cameras=["left"]
    )
    view = tmp_path / "out" / "left"
    names = {path.name for path in view.iterdir()}
    assert names == {
        "channels.exr",
        "radiance.exr",
        "denoised.exr",
        "radiance.png",
        "denoised.png",
        "depth.png",
    }
    raw = (tmp_path / "raw" / "left" / "radiance.exr").read_bytes()
    assert (view / "radiance.exr").read_bytes() == raw
    stored = exr.read_channels(view / "channels.exr")
    assert set(stored) == {"radiance", "depth", DENOISED}
    guides = {name: numbers(name, 30, 40, GUIDE_SEED) for name in ("base_color", "normal")}
    expected = load_denoiser().denoise(numbers("radiance", 30, 40, 0), guides)
    np.testing.assert_array_equal(stored[DENOISED], expected)
    said = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert said["denoiser"]["package"] == "pyoidn" and said["denoiser"]["version"]
    assert said["denoiser"]["guides"] == ["base_color", "normal"]
    assert said["channels"][DENOISED]["meaning"] == CHANNELS[DENOISED].meaning
    assert said["views"]["left"]["files"][DENOISED] == "left/denoised.exr"
    assert said["views"]["left"]["channels"][DENOISED]["estimated_error"] is None
    assert DENOISED in summary.timing["views"]["left"]["channels"]


def test_all_light_is_denoised_on_request(renderer, scene, tmp_path) -> None:
    channels = ["radiance", "irradiance", "depth"]
    render_stage(
        scene,
        tmp_path / "out",
        RenderSettings(channels=channels, denoise_light=True),
        cameras=["left"],
    )
    view = read_render(tmp_path / "out").views["left"]
    assert set(view.pixels) == {*channels, DENOISED}
    assert set(view.denoised) == {*view.entry.denoised} == {"irradiance"}
    raw, clean = (pixels["irradiance"] for pixels in (view.pixels, view.denoised))
    assert clean.std() < raw.std()
    said = view.entry.denoised["irradiance"]
    assert said.bias == pytest.approx(clean.mean() / raw.mean() - 1, abs=1e-5)
    assert view.entry.files["denoised_channels"] == "left/denoised_channels.exr"


def test_it_is_off_unless_asked_for(renderer, scene, tmp_path) -> None:
    render_stage(scene, tmp_path / "out", cameras=["left"])
    said = json.loads((tmp_path / "out" / "manifest.json").read_text())
    assert "denoiser" not in said and DENOISED not in said["channels"]
    assert not (tmp_path / "out" / "left" / "denoised.exr").exists()


def test_only_radiance_can_be_denoised(renderer, scene, tmp_path) -> None:
    with pytest.raises(InputError, match="only the channel 'radiance' can be denoised"):
        render_stage(scene, tmp_path / "out", RenderSettings(channels=["depth"], denoise=True))
    with pytest.raises(InputError, match="computed from others") as caught:
        render_stage(scene, tmp_path / "out", RenderSettings(channels=[DENOISED]))
    assert "--denoise" in str(caught.value)
    assert not (tmp_path / "out").exists()


def test_without_the_package_it_says_what_to_install(
    renderer, scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyoidn", None)
    with pytest.raises(MissingPackageError, match="pyoidn") as caught:
        render_stage(scene, tmp_path / "out", RenderSettings(denoise=True))
    assert "pip install openrooms-usd[denoise]" in str(caught.value)
    assert not (tmp_path / "out").exists()
    assert renderer.opened == 0


def test_a_denoiser_that_fails_ends_without_a_traceback(
    renderer, scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*pictures: object, **options: object) -> None:
        raise RuntimeError("out of memory")

    monkeypatch.setattr(load_denoiser().package, "denoise", fail)
    with pytest.raises(RenderError, match="Open Image Denoise failed: out of memory"):
        render_stage(scene, tmp_path / "out", RenderSettings(denoise=True), cameras=["left"])
    assert not (tmp_path / "out").exists()
