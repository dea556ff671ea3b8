"""The files that a sensor adds to a view; those of the truth are not touched."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from openrooms_usd.arrays import Array, Floats, Ints, Mask
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.description.dataset import Distortion, Noise, Sensor
from openrooms_usd.draws import generator
from openrooms_usd.errors import InputError
from openrooms_usd.imagefile import write_png
from openrooms_usd.rendering import color, exr
from openrooms_usd.rendering.contract import View
from openrooms_usd.rendering.denoise import DENOISED
from openrooms_usd.rendering.previews import preview
from openrooms_usd.rendering.sensors.structured_light import NEEDED, measured
from openrooms_usd.usd.cameras import exposure_of_ev100

_STEPS: Final = 60
# Off by more, at depth 1, a place has no original: the lens folds its picture there.
_FOLDED: Final = 1e-7
# So many places between the middle and an original are looked at for a fold.
_ON_THE_WAY: Final = 16

PHOTOGRAPH: Final = "sensor"
DEPTH: Final = "sensor_depth"


def needed(sensor: Sensor) -> tuple[str, ...]:
    """The channels that views must have."""
    photographed = sensor.distortion or sensor.noise
    return (*(("radiance",) if photographed else ()), *(NEEDED if sensor.depth else ()))


def check_sensor(sensor: Sensor, channels: Sequence[str]) -> None:
    """Check that views have the channels that a sensor needs.

    Raises:
        InputError: A channel is not asked for.
    """
    if missing := [name for name in needed(sensor) if name not in channels]:
        raise InputError(
            f"the sensor needs {', '.join(missing)}, which no view has",
            place="sensor",
            remedy="add them to `channels`, or use `usual`",
        )


def record_sensor(
    target: Path, name: str, view: View, sensor: Sensor, entry: Mapping[str, Any], *key: str
) -> dict[str, Any]:
    """Write what a sensor makes of a view beside the truth.

    Args:
        target: The folder of its files.
        name: The view's name.
        view: What was rendered; it has the channels of `needed`.
        sensor: The sensor.
        entry: What the manifest says of the view.
        *key: Sets its noise apart from that of other views.

    Returns:
        The entry with its files, and with what was asked for under ``sensor``.

    Raises:
        OutputError: A file cannot be written.
    """
    told: dict[str, Any] = sensor.model_dump(mode="json", exclude_none=True)
    files = dict(entry["files"])
    if sensor.distortion or sensor.noise:
        exposure = _exposure(view, sensor)
        pixels, seen = photographed(view, sensor, exposure, *key)
        planes = {"radiance": pixels, "valid": seen[..., None].astype(np.float32)}
        exr.write_channels(target / f"{PHOTOGRAPH}.exr", planes)
        shown = srgb_from_linear(np.clip(pixels * np.float32(exposure), 0.0, 1.0))
        write_png(target / f"{PHOTOGRAPH}.png", color.quantize(shown))
        told |= {"exposure": exposure, "seen_share": float(seen.mean())}
        files |= _files(name, PHOTOGRAPH)
    if sensor.depth:
        rng = generator(sensor.seed, "sensor", "depth", *key)
        channels = {channel: view.images[channel].pixels for channel in NEEDED}
        depth = measured(channels, view.K, view.world_from_camera, sensor.depth, rng)
        exr.write_channels(target / f"{DEPTH}.exr", {"depth": depth})
        write_png(target / f"{DEPTH}.png", preview("depth", depth).pixels)
        files |= _files(name, DEPTH)
    return {**entry, "files": files, "sensor": told}


def photographed(view: View, sensor: Sensor, exposure: float, *key: str) -> tuple[Floats, Mask]:
    """A photograph of what a view sees, as radiance.

    Args:
        view: It has radiance.
        sensor: The sensor.
        exposure: What radiance in nits is multiplied by, so that 1 is white.
        *key: Sets its noise apart from that of other views.

    Returns:
        (height, width, 3) nits, and (height, width) where the view has what the lens shows.
    """
    pixels = _light(view)
    seen = np.ones(pixels.shape[:2], dtype=bool)
    if sensor.distortion:
        pixels, seen = seen_through(pixels, view.K, sensor.distortion)
    if sensor.noise:
        rng = generator(sensor.seed, "sensor", "noise", *key)
        numbers = counted(pixels * np.float32(exposure), sensor.noise, rng)
        light = light_of(numbers, sensor.noise) / np.float32(exposure)
        pixels = np.where(seen[..., None], light, np.float32(0.0)).astype(np.float32)
    return pixels, seen


def _exposure(view: View, sensor: Sensor) -> float:
    """As the sensor says, as the camera has it, or fitted to the picture."""
    if sensor.exposure_value is not None:
        return exposure_of_ev100(sensor.exposure_value)
    if view.exposure is not None:
        return view.exposure
    return float(color.fitted_exposure(_light(view)))


def _light(view: View) -> Floats:
    """The radiance with as little noise of the renderer as there is."""
    image = view.images.get(DENOISED, view.images.get("radiance"))
    assert image is not None
    return image.pixels


def _files(name: str, what: str) -> dict[str, str]:
    return {what: f"{name}/{what}.exr", f"{what}_preview": f"{name}/{what}.png"}


# The model of EMVA 1288 (Standard for characterization of image sensors, release 4.0, 2021, section
# 2). Electrons arrive one by one, so their number is Poisson distributed. Reading them out adds
# Gaussian noise; the gain converts them to numbers, which are rounded. Of a number with gain K
# and mean m above black the variance is K m + K^2 s^2 + 1/12, s the read noise: the photon
# transfer curve.


@dataclass(frozen=True)
class Readout:
    """How a sensor counts.

    Attributes:
        white: Electrons of a pixel that is white in the picture.
        gain: Numbers an electron.
        black: The number of no light: noise below it is kept.
        most: The greatest number.
    """

    white: float
    gain: float
    black: int
    most: int

    @classmethod
    def of(cls, noise: Noise) -> "Readout":
        """The readout of a sensor: at twice the ISO half as many electrons are white."""
        most = 2**noise.bits - 1
        black = round(noise.black * most)
        white = noise.full_well * 100.0 / noise.iso
        return cls(white, (most - black) / white, black, most)


def counted(light: Floats, noise: Noise, rng: np.random.Generator) -> Ints:
    """The numbers that a sensor reads.

    Args:
        light: (..., components) light of which 1 is white; each component by pixels of its own.
        noise: The sensor.
        rng: Draws the noise.
    """
    readout = Readout.of(noise)
    wanted = np.clip(np.nan_to_num(light.astype(np.float64)), 0.0, None) * readout.white
    # What is a hundred times too bright fills the well by any draw; more could not be drawn.
    electrons = rng.poisson(np.minimum(wanted, 100.0 * noise.full_well)).astype(np.float64)
    electrons = np.minimum(electrons, noise.full_well)
    electrons += noise.read_noise * rng.standard_normal(electrons.shape)
    numbers = np.rint(readout.black + readout.gain * electrons)
    return np.asarray(np.clip(numbers, 0, readout.most), dtype=np.int64)


def light_of(numbers: Ints, noise: Noise) -> Floats:
    """What the numbers say the light was, 1 white: less than 0 where noise was below black."""
    readout = Readout.of(noise)
    scale = readout.most - readout.black
    return ((numbers - readout.black) / scale).astype(np.float32)


# D. C. Brown, Close-range camera calibration, Photogrammetric Engineering 37(8), 1971. The order
# and the signs are those of OpenCV's ``calib3d``. With x, y the coordinates at depth 1 and r
# their length,
#     x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
#     y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
def distorted(points: Array, lens: Distortion) -> Array:
    """(..., 2) where a lens puts what a pinhole has at (..., 2) coordinates at depth 1."""
    x, y = points[..., 0], points[..., 1]
    r2 = x**2 + y**2
    radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))
    return np.stack(
        [
            x * radial + 2.0 * lens.p1 * x * y + lens.p2 * (r2 + 2.0 * x**2),
            y * radial + lens.p1 * (r2 + 2.0 * y**2) + 2.0 * lens.p2 * x * y,
        ],
        axis=-1,
    )


def undistorted(points: Array, lens: Distortion) -> Array:
    """The inverse of `distorted`, by Newton's method; NaN where nothing comes to lie there."""
    found = points.astype(np.float64).copy()
    with np.errstate(all="ignore"):
        for _ in range(_STEPS):
            step = _solved(_jacobian(found, lens), distorted(found, lens) - points)
            found -= step
            if not (np.abs(step) > _FOLDED**2).any():
                break
        good = np.abs(distorted(found, lens) - points).max(axis=-1) < _FOLDED
        # Beyond a fold lie other originals, which no lens shows; far out it may even unfold again.
        for share in np.linspace(0.0, 1.0, _ON_THE_WAY + 1)[1:]:
            a, b, d = _jacobian(share * found, lens)
            good &= (a * d - b**2 > 0.0) & (a + d > 0.0)
    return np.where(good[..., None], found, np.nan)


def seen_through(pixels: Floats, K: Array, lens: Distortion) -> tuple[Floats, Mask]:
    """A pinhole's picture as a camera with the same K and a lens has it.

    Args:
        pixels: (height, width, components), means between which there is something.
        K: (3, 3) intrinsics, pixels.
        lens: The lens.

    Returns:
        The picture, by bilinear interpolation, and (height, width) where the pinhole saw what the
        lens shows; 0 elsewhere.
    """
    height, width = pixels.shape[:2]
    column, row = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    f, c = np.array([K[0, 0], K[1, 1]]), K[:2, 2]
    place = undistorted((np.stack([column, row], axis=-1) - c) / f, lens) * f + c
    inside = ((place >= 0.0) & (place <= (width, height))).all(axis=-1)
    x, y = np.moveaxis(np.where(inside[..., None], place, 0.5) - 0.5, -1, 0)
    # Where nothing moves, pixels stay what they are to the last bit.
    x, y = (np.where(np.abs(v - np.rint(v)) < 1e-9, np.rint(v), v) for v in (x, y))
    left, top = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    found = np.zeros(pixels.shape)
    for i, across in ((0, 1.0 - (x - left)), (1, x - left)):
        for j, down in ((0, 1.0 - (y - top)), (1, y - top)):
            at = np.clip(top + j, 0, height - 1), np.clip(left + i, 0, width - 1)
            found += (across * down)[..., None] * pixels[at]
    return np.where(inside[..., None], found, 0.0).astype(np.float32), inside


def _jacobian(points: Array, lens: Distortion) -> tuple[Array, Array, Array]:
    """dx'/dx, dx'/dy (which is dy'/dx, too) and dy'/dy."""
    x, y = points[..., 0], points[..., 1]
    r2 = x**2 + y**2
    radial = 1.0 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3))
    slope = 2.0 * (lens.k1 + r2 * (2.0 * lens.k2 + r2 * 3.0 * lens.k3))
    return (
        radial + x**2 * slope + 2.0 * lens.p1 * y + 6.0 * lens.p2 * x,
        x * y * slope + 2.0 * lens.p1 * x + 2.0 * lens.p2 * y,
        radial + y**2 * slope + 6.0 * lens.p1 * y + 2.0 * lens.p2 * x,
    )


def _solved(jacobian: tuple[Array, Array, Array], off: Array) -> Array:
    a, b, d = jacobian
    u, v = off[..., 0], off[..., 1]
    return np.asarray(np.stack([d * u - b * v, a * v - b * u], axis=-1) / (a * d - b**2)[..., None])
