"""The mean base colour and roughness of a surface, from which friction is predicted."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.colorimetry import linear_from_srgb
from openrooms_usd.usd.shading.surfaces import PreviewSurface, Texture
from openrooms_usd.usd.shading.textures import read_codes, read_texture

Color = tuple[float, float, float]
Field = NDArray[np.floating]

# Texels along each side that are looked at where not all of them must be.
_SAMPLED_TEXELS: Final = 256
# Values of a picture of 8 bits.
_CODES: Final = 256


@dataclass(frozen=True)
class Appearance:
    """What a surface's pictures come to.

    Attributes:
        albedo: Mean base colour, scene-linear Rec.709.
        roughness: Mean perceptual roughness.
        brightest: Greatest value of each primary.
        roughest: Greatest roughness.
    """

    albedo: Color
    roughness: float
    brightest: Color
    roughest: float

    def times(self, color: Color, roughness: float) -> "Appearance":
        """What it is when it is brighter, tinted or rougher, and still nowhere above one."""
        albedo, brightest = (
            _color(np.multiply(values, color)) for values in (self.albedo, self.brightest)
        )
        rougher = (self.roughness * roughness, self.roughest * roughness)
        return Appearance(albedo, rougher[0], brightest, rougher[1])


def appearance_of(surface: PreviewSurface) -> Appearance:
    """Look at the base colour and the roughness of a surface whose files are absolute.

    Raises:
        InputError: A picture cannot be read.
    """
    mean, greatest = _extent(surface.base_color)
    (roughness, *_), (roughest, *_) = _extent(surface.roughness)
    return Appearance(_color(mean), float(roughness), _color(greatest), float(roughest))


def _extent(value: Texture | Color | float) -> tuple[Field, Field]:
    """(3,) or (1,) mean and greatest of what an input says."""
    codes = read_codes(value.file) if isinstance(value, Texture) else None
    if codes is None or not isinstance(value, Texture):
        shown = _values(value)
        shown = shown.reshape(-1, 3 if shown.shape[-1:] == (3,) else 1)
        return shown.mean(axis=0, dtype=np.float64), shown.max(axis=0)
    # 256 codes stand for all values there are; so these are decoded, and their texels counted.
    every = np.arange(_CODES, dtype=np.float32)[:, None] * np.float32(1.0 / (_CODES - 1))
    shown = _shown(every, value).reshape(_CODES, -1)
    used = [0, 1, 2] if codes.shape[-1] >= 3 else [0, 0, 0]
    used = [used["rgb".find(name)] for name in value.channel]
    counts = np.stack([np.bincount(codes[..., k].ravel(), minlength=_CODES) for k in used], axis=1)
    mean = (counts * shown).sum(axis=0, dtype=np.float64) / codes[..., 0].size
    return mean, np.where(counts > 0, shown, 0.0).max(axis=0)


def texels(surface: PreviewSurface) -> tuple[Field, Field]:
    """Base colours and roughnesses at places that lie evenly over a surface's pictures.

    Args:
        surface: Its files are absolute; its pictures cover the same square.

    Returns:
        (P, 3) and (P,).

    Raises:
        InputError: A picture cannot be read.
    """
    return (
        _values(surface.base_color, evenly=True).reshape(-1, 3),
        _values(surface.roughness, evenly=True).reshape(-1),
    )


def _evenly(picture: Field) -> Field:
    """Fixed numbers of rows and columns, at the middles of a grid."""
    rows, columns = (
        ((np.arange(_SAMPLED_TEXELS) + 0.5) * size / _SAMPLED_TEXELS).astype(np.int64)
        for size in picture.shape[:2]
    )
    found: Field = picture[rows][:, columns]
    return found


def _values(value: Texture | Color | float, *, evenly: bool = False) -> Field:
    """(..., 3) or (...,) what an input says, all over or at places that lie evenly on it."""
    if not isinstance(value, Texture):
        return np.asarray(value, dtype=np.float32)
    stored = read_texture(value.file)
    return _shown(_evenly(stored) if evenly else stored, value)


def _shown(stored: Field, value: Texture) -> Field:
    """(..., 3) or (...,) what a picture's stored values stand for."""
    pixels = stored[..., :3] if stored.shape[-1] >= 3 else np.repeat(stored[..., :1], 3, axis=-1)
    decoded = linear_from_srgb(pixels) if value.color_space == "sRGB" else pixels
    shown: Field = np.clip(decoded * value.scale[:3] + value.bias[:3], 0.0, 1.0)
    # An alpha that drives something is rare enough to be read as blue.
    which = ["rgb".find(name) for name in value.channel]
    return shown[..., which if len(which) > 1 else which[0]]


def _color(values: Field) -> Color:
    red, green, blue = (float(value) for value in values)
    return red, green, blue
