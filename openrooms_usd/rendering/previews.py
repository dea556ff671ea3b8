"""Pictures of channels for people: 8-bit sRGB, one way of showing for every kind of number.

Values that are not finite are magenta, so that they are easy to see.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Bytes, Floats, Mask
from openrooms_usd.channels import definition
from openrooms_usd.colorimetry import srgb_from_linear
from openrooms_usd.description.rendering import PHOTOGRAPH, ToneName
from openrooms_usd.geometry.hemisphere import tiled, untiled
from openrooms_usd.rendering import color
from openrooms_usd.rendering.tone import Balance, Tone, fitted_tone

# Hemispheres across in the preview of a grid.
_COLUMNS: Final = 20


@dataclass(frozen=True)
class Preview:
    """A channel as people look at it.

    Attributes:
        pixels: (height, width, 3) or (height, width, 1), sRGB-encoded.
        shows: What its colours mean, such as ``0.41 m (bright) to 5.20 m (dark)``.
    """

    pixels: Bytes
    shows: str


def preview(
    name: str,
    pixels: Floats,
    exposure: float | None = None,
    tone: ToneName | Tone = PHOTOGRAPH,
    balance: Balance | None = None,
) -> Preview:
    """Make a picture of a channel.

    Args:
        name: The channel's name in the table.
        pixels: (height, width, components).
        exposure: What light is multiplied by; None fits it to the picture.
        tone: How light is shown; a name fits the rest to the picture.
        balance: The white balance of the tone; None fits it to the picture.
    """
    channel = definition(name)
    if channel.scope == "grid":
        pixels = _sparse(pixels)
    finite = np.asarray(np.isfinite(pixels).all(axis=-1))
    known = np.where(finite[..., None], pixels, np.float32(0))
    if channel.unit in _LIGHT:
        # A camera's exposure is for radiance.
        camera = exposure if channel.unit == "nit" else None
        shown = _light(known, camera, tone, balance)
    else:
        shown = _SHOWN[channel.unit, "".join(channel.components)](known)
    return shown if finite.all() else Preview(_marked(shown.pixels, ~finite), shown.shows)


def _sparse(tiles: Floats) -> Floats:
    """Every so many hemispheres of a grid, so that people see a few of them."""
    grid = untiled(tiles)
    step = max(1, grid.shape[1] // _COLUMNS)
    return tiled(grid[step // 2 :: step, step // 2 :: step])


def _marked(pixels: Bytes, bad: Mask) -> Bytes:
    colored = np.repeat(pixels, 3, axis=-1) if pixels.shape[-1] == 1 else pixels.copy()
    colored[bad] = color.NONFINITE
    return colored


def _light(
    pixels: Floats, exposure: float | None, tone: ToneName | Tone, balance: Balance | None
) -> Preview:
    if isinstance(tone, Tone):
        fitted, whose = tone, "given"
    else:
        fitted = fitted_tone(tone, pixels, exposure, balance)
        whose = "fitted" if exposure is None else "of the camera"
    picture = color.quantize(srgb_from_linear(fitted.shown(pixels)))
    return Preview(picture, f"{fitted.told()}, exposure {fitted.exposure:.3g} ({whose})")


def _length(pixels: Floats) -> Preview:
    lengths = pixels[..., 0]
    surface = lengths > 0
    near, far = np.percentile(lengths[surface], (0.5, 99.5)) if surface.any() else (0.0, 1.0)
    picture = color.quantize(color.ramp((lengths - near) / max(far - near, 1e-6)))
    picture[~surface] = 0
    return Preview(picture, f"{near:.2f} m (bright) to {far:.2f} m (dark)")


def _position(pixels: Floats) -> Preview:
    surface = (pixels != 0).any(axis=-1)
    seen = pixels[surface] if surface.any() else np.zeros((1, 3), np.float32)
    low, high = np.percentile(seen, (0.5, 99.5), axis=0)
    picture = color.quantize((pixels - low) / np.maximum(high - low, 1e-6))
    picture[~surface] = 0
    spans = (f"{a} {s:.2f} to {e:.2f} m" for a, s, e in zip("XYZ", low, high, strict=True))
    return Preview(picture, ", ".join(spans))


def _direction(pixels: Floats) -> Preview:
    picture = color.quantize(0.5 * (pixels + 1))
    picture[(pixels == 0).all(axis=-1)] = 0
    return Preview(picture, "0.5 (n + 1)")


def _reflectance(pixels: Floats) -> Preview:
    return Preview(color.quantize(srgb_from_linear(pixels)), "sRGB")


def _ratio(pixels: Floats) -> Preview:
    return Preview(color.quantize(pixels), "black 0, white 1")


def _flow(pixels: Floats) -> Preview:
    lengths = np.linalg.norm(pixels, axis=-1)
    most = max(float(np.percentile(lengths, 99)), 1e-6)
    share = np.clip(lengths / most, 0.0, 1.0)[..., None]
    turn = np.arctan2(pixels[..., 1], pixels[..., 0])[..., None]
    # Red to the right, and round the circle; black where nothing moves.
    hue = 0.5 + 0.5 * np.cos(turn - np.array([0.0, 2.0, 4.0]) * np.pi / 3.0)
    return Preview(color.quantize(share * hue), f"hue: where to, full at {most:.1f} px")


def _label(pixels: Floats) -> Preview:
    return Preview(color.palette(pixels[..., 0].astype(np.int64)), "a colour for every number")


_LIGHT: Final = frozenset({"nit", "lux"})
_Show = Callable[[Floats], Preview]
_SHOWN: Final[dict[tuple[str, str], _Show]] = {
    ("m", "Y"): _length,
    ("m", "XYZ"): _position,
    ("1", "XYZ"): _direction,
    ("1", "RGB"): _reflectance,
    ("1", "Y"): _ratio,
    ("id", "Y"): _label,
    ("px", "XY"): _flow,
}
