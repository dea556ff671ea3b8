"""Sensors: distortion by OpenCV's formulas, noise by its moments, depth by what was published."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from openrooms_usd.description.dataset import DepthCamera, Distortion, Noise, Sensor
from openrooms_usd.errors import InputError
from openrooms_usd.geometry.pinhole import intrinsics
from openrooms_usd.rendering import Image, View, exr
from openrooms_usd.rendering.sensors.recording import (
    Readout,
    check_sensor,
    counted,
    distorted,
    light_of,
    photographed,
    record_sensor,
    seen_through,
    undistorted,
)
from openrooms_usd.rendering.sensors.structured_light import in_steps, measured

WIDTH, HEIGHT = 64, 48
K = intrinsics(60.0, WIDTH, HEIGHT)
LENS = Distortion(k1=-0.25, k2=0.08, p1=0.002, p2=-0.003, k3=-0.01)


def opencv(x: float, y: float) -> tuple[float, float]:
    """As its documentation writes it, number by number."""
    r = (x * x + y * y) ** 0.5
    radial = 1 + LENS.k1 * r**2 + LENS.k2 * r**4 + LENS.k3 * r**6
    return (
        x * radial + 2 * LENS.p1 * x * y + LENS.p2 * (r**2 + 2 * x**2),
        y * radial + LENS.p1 * (r**2 + 2 * y**2) + 2 * LENS.p2 * x * y,
    )


def test_points_go_where_opencv_says_and_back() -> None:
    points = np.random.default_rng(1).uniform(-0.7, 0.7, (200, 2))
    expected = np.array([opencv(x, y) for x, y in points])
    np.testing.assert_allclose(distorted(points, LENS), expected, atol=1e-15)
    np.testing.assert_allclose(undistorted(expected, LENS), points, atol=1e-9)
    # r (1 - r^2) has its greatest value at r = 0.577: nothing comes to lie beyond.
    fold = Distortion(k1=-1.0)
    assert np.isnan(undistorted(np.array([[0.4, 0.0]]), fold)).all()
    assert not np.isnan(undistorted(np.array([[0.38, 0.0]]), fold)).any()
    # r (1 - r^2 + 0.3 r^4) folds at r = 0.65, where it is 0.41, and comes up to that again at 1.5.
    again = Distortion(k1=-1.0, k2=0.3)
    radius = np.sqrt((3.0 - 3.0**0.5) / 3.0)
    most = radius * (1.0 - radius**2 + 0.3 * radius**4)
    shown = undistorted(np.array([[0.99 * most, 0.0], [1.01 * most, 0.0], [0.0, 0.6]]), again)
    assert 0.0 < shown[0, 0] < radius and np.isnan(shown[1:]).all()


@pytest.mark.parametrize("lens", [LENS, Distortion(k1=0.2)])
def test_a_lens_shows_each_place_where_opencv_puts_it(lens: Distortion) -> None:
    column, row = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
    # A picture of its own coordinates: bilinear interpolation gives them back exactly.
    picture = np.dstack([column, row, np.ones_like(row)]).astype(np.float32)
    found, seen = seen_through(picture, K, lens)
    inner = seen & (found[..., 2] > 0.5) & (found[..., 0] > 1) & (found[..., 0] < WIDTH - 1)
    inner &= (found[..., 1] > 1) & (found[..., 1] < HEIGHT - 1)
    assert inner.mean() > 0.6
    source = (found[inner][:, :2] - K[:2, 2]) / K[0, 0]
    back = distorted(source.astype(np.float64), lens) * K[0, 0] + K[:2, 2]
    np.testing.assert_allclose(back, np.column_stack([column[inner], row[inner]]), atol=2e-4)
    # Barrels show more than the pinhole saw, in the corners; cushions do not.
    assert seen[0, 0] == (lens.k1 > 0)


def test_without_distortion_all_bits_stay() -> None:
    picture = np.random.default_rng(2).random((HEIGHT, WIDTH, 3)).astype(np.float32)
    found, seen = seen_through(picture, K, Distortion())
    np.testing.assert_array_equal(found, picture)
    assert seen.all()


@pytest.mark.parametrize("iso", [100.0, 1600.0])
def test_the_photon_transfer_curve(iso: float) -> None:
    noise = Noise(iso=iso, full_well=9000, read_noise=2.0, bits=12)
    readout = Readout.of(noise)
    assert readout.white == 9000 * 100 / iso
    rng, count = np.random.default_rng(3), 200_000
    for light in (0.0, 0.02, 0.2, 0.7):
        numbers = counted(np.full((count, 1), light, np.float32), noise, rng)
        electrons = light * readout.white
        mean = readout.black + readout.gain * electrons
        variance = readout.gain**2 * (electrons + 2.0**2) + 1 / 12
        assert numbers.mean() == pytest.approx(mean, abs=5 * (variance / count) ** 0.5)
        assert numbers.var() == pytest.approx(variance, rel=0.02)
    # Above white the numbers end; without noise they are the light, but for their steps.
    assert counted(np.full((9, 1), 5.0, np.float32), noise, rng).max() == 2**12 - 1
    quiet = Noise(full_well=1e7, read_noise=0, bits=16, iso=100)
    light = np.linspace(0, 0.9, 50, dtype=np.float32)[:, None]
    np.testing.assert_allclose(light_of(counted(light, quiet, rng), quiet), light, atol=2e-3)


def test_a_sensor_counts_to_white() -> None:
    # Below ISO 100 the well would be full of less light than is white: highlights would be grey.
    with pytest.raises(ValueError, match="greater than or equal to 100"):
        Noise(iso=50)
    small = Noise(iso=100, full_well=10, read_noise=0)
    glaring = counted(np.full((100_000, 1), 1e3, np.float32), small, np.random.default_rng(1))
    assert (glaring == 2**12 - 1).all()


def plane(depth: float, slant: float = 0.0, size: tuple[int, int] = (120, 160)) -> dict:
    """What a camera sees of a large wall that is turned about its vertical."""
    normal = np.array([np.sin(slant), 0.0, -np.cos(slant)])
    return {
        "depth": np.full((*size, 1), depth, np.float32),
        "normal_geometric": np.tile(normal, (*size, 1)).astype(np.float32),
        "base_color": np.full((*size, 3), 0.5, np.float32),
        "roughness": np.full((*size, 1), 0.6, np.float32),
        "metallic": np.zeros((*size, 1), np.float32),
    }


def wall(camera: DepthCamera, channels: dict, K: np.ndarray = K) -> np.ndarray:
    rng = np.random.default_rng(0)
    return measured(channels, K, np.eye(4), camera, rng)[..., 0].astype(np.float64)


# All pixels look along the axis.
FAR = np.diag([1e5, 1e5, 1.0])
# The middle of the picture of the camera that was measured.
FINE = np.array([[585.0, 0, 80], [0, 585, 60], [0, 0, 1]])


@pytest.mark.parametrize("depth", [0.8, 1.5, 3.0, 4.2])
@pytest.mark.parametrize("degrees", [0.0, 30.0, 60.0])
def test_depth_is_as_noisy_as_was_published(depth: float, degrees: float) -> None:
    """Of a wall: its slope does not count again by the noise across the axis."""
    channels = plane(depth, np.radians(degrees))
    normal = channels["normal_geometric"][0, 0].astype(np.float64)
    column, row = np.meshgrid(np.arange(160) + 0.5, np.arange(120) + 0.5)
    rays = np.dstack([(column - 80) / 585, (row - 60) / 585, np.ones_like(row)])
    truth = depth * normal[2] / (rays @ normal)
    channels["depth"] = truth[..., None].astype(np.float32)
    camera = DepthCamera(steps=False, missing=False, range=(0.1, 9.0))
    t = np.arccos(np.clip(np.abs(rays @ normal) / np.linalg.norm(rays, axis=-1), 0.0, 1.0))
    sigma = 0.0012 + 0.0019 * (truth - 0.4) ** 2
    sigma += 0.0001 / truth**0.5 * (t / (np.pi / 2 - t)) ** 2
    off = (wall(camera, channels, FINE) - truth) / sigma
    assert off.std() == pytest.approx(1.0, rel=0.03)
    assert off.mean() == pytest.approx(0.0, abs=5 / off.size**0.5)


def test_edges_wander_as_was_published() -> None:
    channels = plane(1.0)
    channels["depth"][:, 80:] = 2.0
    fine = np.diag([10.0, 10.0, 1.0]) @ K
    camera = DepthCamera(noise=1.0, steps=False, missing=False)
    found = measured(channels, fine, np.eye(4), camera, np.random.default_rng(4))[..., 0] > 1.5
    # A pixel this far from the edge shows what lies over it with the normal distribution's tail.
    sigma = 0.8 * fine[0, 0] / 585.0
    wrong = found[:, :80].mean(axis=0)[::-1]
    away = np.arange(80) + 0.5
    from scipy.stats import norm

    np.testing.assert_allclose(wrong[:8], norm.sf(away[:8] / sigma), atol=0.12)
    assert wrong[int(4 * sigma) + 1 :].max() == 0.0


def test_disparity_comes_in_steps() -> None:
    depth = np.linspace(0.5, 5.0, 40_000)
    steps = np.unique(in_steps(depth))
    middle = 0.5 * (steps[1:] + steps[:-1])
    np.testing.assert_allclose(np.diff(steps), 2.85e-3 * middle**2, rtol=1e-3)
    np.testing.assert_allclose(in_steps(depth), depth, atol=2.85e-3 * 25 / 2 + 1e-3)
    assert in_steps(np.array([0.0])) == 0.0


def test_without_noise_depth_is_the_truth() -> None:
    quiet = DepthCamera(noise=0.0, steps=False, missing=False, range=(0.1, 9.0))
    channels = plane(2.0)
    channels["depth"] += np.random.default_rng(5).random((120, 160, 1)).astype(np.float32)
    np.testing.assert_array_equal(wall(quiet, channels), channels["depth"][..., 0])


def test_what_returns_no_light_has_no_depth() -> None:
    quiet = DepthCamera(noise=0.0, steps=False)
    assert (wall(quiet, plane(2.0)) == 2.0).all()
    assert not wall(quiet, plane(2.0, np.radians(85.0)), FAR).any()
    assert not wall(quiet, plane(6.0)).any() and not wall(quiet, plane(0.4)).any()
    dark = plane(2.0) | {"base_color": np.full((120, 160, 3), 0.01, np.float32)}
    assert not wall(quiet, dark).any()
    mirror = plane(2.0) | {
        "metallic": np.ones((120, 160, 1), np.float32),
        "roughness": np.full((120, 160, 1), 0.05, np.float32),
    }
    assert not wall(quiet, mirror).any()


def test_the_projector_casts_a_shadow_left_of_things() -> None:
    channels = plane(3.0)
    channels["depth"][:, 80:110] = 1.0
    found = wall(DepthCamera(noise=0.0, steps=False, range=(0.1, 9.0)), channels)
    # Its width is the difference of the disparities, f b (1 / 1 - 1 / 3).
    wide = K[0, 0] * 0.075 * (1.0 - 1.0 / 3.0)
    lost = np.flatnonzero(found[50] == 0.0)
    assert abs(len(lost) - wide) <= 1.0 and lost.max() == 79


def test_a_thin_thing_casts_a_thin_shadow_away_from_itself() -> None:
    """A pole of three columns: the projector sees the wall past both of its sides."""
    channels = plane(3.0)
    channels["depth"][:, 120:123] = 1.0
    found = wall(DepthCamera(noise=0.0, steps=False), channels, FINE)
    lost = np.flatnonzero(found[50] == 0.0)
    # 585 x 0.075 (1 / 1 - 1 / 3) columns further left.
    assert set(lost) >= {91, 92, 93} and len(lost) <= 4 and lost.max() < 95


def test_a_slanted_wall_has_no_shadow_of_its_own() -> None:
    column = np.arange(160) + 0.5
    for degrees in (-70.0, 70.0):
        channels = plane(1.0, np.radians(degrees))
        normal = channels["normal_geometric"][0, 0].astype(np.float64)
        across = 0.9 * normal[2] / ((column - 80) / 585 * normal[0] + normal[2])
        channels["depth"] = np.tile(across[None, :, None], (120, 1, 1)).astype(np.float32)
        assert (wall(DepthCamera(noise=0.0, steps=False), channels, FINE) > 0.0).all()


def view() -> View:
    rng = np.random.default_rng(6)
    size = (HEIGHT, WIDTH)
    pixels = {"radiance": rng.random((*size, 3)) * 300, **plane(2.0, size=size)}
    images = {name: Image(p.astype(np.float32), 4, 0.0, 0.1) for name, p in pixels.items()}
    return View("/c", WIDTH, HEIGHT, K, np.eye(4), 1 / 300, images)


def test_equal_seeds_give_equal_files_and_the_truth_stays(tmp_path: Path) -> None:
    sensor = Sensor(distortion=LENS, noise=Noise(), depth=DepthCamera())
    shot = view()
    before = {name: image.pixels.copy() for name, image in shot.images.items()}
    entries = []
    for folder, key in (("a", "room/view_0"), ("b", "room/view_0"), ("c", "room/view_1")):
        (tmp_path / folder).mkdir()
        entry = {"files": {"radiance": "view_0/radiance.exr"}}
        entries.append(record_sensor(tmp_path / folder, "view_0", shot, sensor, entry, key))
    a, b, c = (
        {path.name: path.read_bytes() for path in sorted((tmp_path / name).iterdir())}
        for name in "abc"
    )
    assert a == b and entries[0] == entries[1]
    assert set(a) == {"sensor.exr", "sensor.png", "sensor_depth.exr", "sensor_depth.png"}
    assert all(a[name] != c[name] for name in a)
    assert entries[0]["files"].keys() > {"radiance", "sensor", "sensor_depth"}
    assert entries[0]["sensor"]["noise"]["iso"] == 400.0
    read = exr.read_channels(tmp_path / "a" / "sensor.exr")
    assert set(read) == {"radiance", "valid"}
    for name, pixels in before.items():
        np.testing.assert_array_equal(shot.images[name].pixels, pixels)


def test_a_photograph_is_of_the_same_light() -> None:
    shot = view()
    pixels, seen = photographed(shot, Sensor(noise=Noise(iso=100)), 1 / 300, "a")
    truth = shot.images["radiance"].pixels
    assert seen.all() and pixels.mean() == pytest.approx(truth.mean(), rel=1e-3)
    assert 0.002 < np.abs(pixels - truth).mean() / truth.mean() < 0.02


def test_the_exposure_is_the_sensors_the_cameras_or_fitted(tmp_path: Path) -> None:
    shot = view()
    for number, (given, camera, wanted) in enumerate(
        [(8.0, 1 / 300, 1 / (1.2 * 2**8)), (None, 1 / 300, 1 / 300), (None, None, None)]
    ):
        (tmp_path / str(number)).mkdir()
        sensor = Sensor(noise=Noise(), exposure_value=given)
        seen = replace(shot, exposure=camera)
        told = record_sensor(tmp_path / str(number), "a", seen, sensor, {"files": {}}, "a")
        found = told["sensor"]["exposure"]
        # Middle grey and a little more is what a fitted picture is like.
        mean = found * shot.images["radiance"].pixels.mean()
        assert found == pytest.approx(wanted) if wanted else 0.1 < mean < 0.5


def test_a_photograph_is_of_the_denoised_light_where_there_is_some() -> None:
    shot = view()
    clean = replace(shot.images["radiance"], pixels=np.full((HEIGHT, WIDTH, 3), 100.0, np.float32))
    shot = replace(shot, images={**shot.images, "denoised": clean})
    pixels, _ = photographed(shot, Sensor(distortion=Distortion()), 1 / 300, "a")
    np.testing.assert_array_equal(pixels, clean.pixels)


def test_a_sensor_says_what_it_misses() -> None:
    with pytest.raises(InputError, match="needs radiance, normal_geometric"):
        sensor = Sensor(noise=Noise(), depth=DepthCamera())
        check_sensor(sensor, ["depth", "base_color", "roughness", "metallic"])
    with pytest.raises(ValueError, match="a sensor needs"):
        Sensor.model_validate({"seed": 3})


def test_a_floor_is_measured_as_far_as_it_is_not_grazed() -> None:
    # 1.4 m below a level camera: its normal is always across the axis, not across the sight.
    _, row = np.meshgrid(np.arange(WIDTH) + 0.5, np.arange(HEIGHT) + 0.5)
    down = (row - K[1, 2]) / K[1, 1]
    depth = np.where(down > 0.0, 1.4 / np.maximum(down, 1e-9), 0.0)[..., None]
    normal = np.tile([0.0, -1.0, 0.0], (HEIGHT, WIDTH, 1))
    floor = plane(1.0, size=(HEIGHT, WIDTH)) | {
        "depth": depth.astype(np.float32),
        "normal_geometric": normal.astype(np.float32),
    }
    found = wall(DepthCamera(noise=0.0, steps=False, baseline=1e-3), floor)
    assert ((found > 0.0) == ((depth[..., 0] > 0.0) & (depth[..., 0] <= 5.0))).all()
