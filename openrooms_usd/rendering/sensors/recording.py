"""The files that a sensor adds to a view; those of the truth are not touched."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.description.dataset import Sensor
from openrooms_usd.draws import generator
from openrooms_usd.errors import InputError
from openrooms_usd.imagefile import write_png
from openrooms_usd.rendering import color, exr
from openrooms_usd.rendering.contract import View
from openrooms_usd.rendering.denoise import DENOISED
from openrooms_usd.rendering.previews import preview
from openrooms_usd.rendering.sensors.lens import seen_through
from openrooms_usd.rendering.sensors.photons import counted, light_of
from openrooms_usd.rendering.sensors.structured_light import NEEDED, measured
from openrooms_usd.usd.cameras import exposure_of_ev100

Pixels = NDArray[np.float32]

PHOTOGRAPH: Final = "sensor"
DEPTH: Final = "sensor_depth"


def needed(sensor: Sensor) -> tuple[str, ...]:
    """The channels that views must have."""
    photographed = sensor.distortion or sensor.noise
    return (*(("radiance",) if photographed else ()), *(NEEDED if sensor.depth else ()))


def check_sensor(sensor: Sensor, channels: Sequence[str]) -> None:
    """See that views have what a sensor works with.

    Raises:
        InputError: A channel is not asked for.
    """
    if missing := [name for name in needed(sensor) if name not in channels]:
        raise InputError(
            f"the sensor works with {', '.join(missing)}, which no view has",
            place="sensor",
            remedy="add them to `channels`, or take `usual`",
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


def photographed(
    view: View, sensor: Sensor, exposure: float, *key: str
) -> tuple[Pixels, NDArray[np.bool_]]:
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


def _light(view: View) -> Pixels:
    """The radiance with as little noise of the renderer as there is."""
    image = view.images.get(DENOISED, view.images.get("radiance"))
    assert image is not None
    return image.pixels


def _files(name: str, what: str) -> dict[str, str]:
    return {what: f"{name}/{what}.exr", f"{what}_preview": f"{name}/{what}.png"}
