"""Environments as latitude-longitude pictures in nits: their illuminance, and a sky of our own.

The first row is around the zenith. Columns run clockwise seen from above: the middle of the picture
looks along -Y, a quarter from the left along +X.

The bundled sky is written by::

    python -m openrooms_usd.library.surroundings.environments openrooms_usd/demo/sky.exr
"""

import math
import sys
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.arrays import Array, Floats
from openrooms_usd.colorimetry import luminance
from openrooms_usd.errors import InputError
from openrooms_usd.library.pictures import write_exr
from openrooms_usd.library.surroundings.sunlight import RGB_FROM_XYZ
from openrooms_usd.tables import read_table
from openrooms_usd.usd.shading.textures import color_space, read_texture

_TABLES: Final = read_table(__file__, "preetham.toml")
_PEREZ: Final = np.array(_TABLES["perez"])
_ZENITH: Final = np.array(_TABLES["zenith"])

# Scene-linear base colours of what stands and lies outside, and of sunlight.
_LAWN: Final = np.array([0.092, 0.112, 0.055])
_PATH: Final = np.array([0.24, 0.22, 0.19])
_LEAVES: Final = np.array([0.06, 0.08, 0.038])
_SUNLIGHT: Final = np.array([1.10, 0.99, 0.86])
# Height of the eye above the ground, metres, and where the trees stand.
_EYE_HEIGHT_M: Final = 1.6
_TREE_DISTANCE_M: Final = 35.0


def directions(height: int, rows: slice = slice(None)) -> Array:
    """(H, 2 H, 3) unit vectors, Z up, through the middle of each pixel of all or some rows."""
    latitude = math.pi * (0.5 - (np.arange(height)[rows] + 0.5) / height)
    longitude = math.pi * (1.0 - 2.0 * (np.arange(2 * height) + 0.5) / (2 * height))
    phi, lam = np.meshgrid(latitude, longitude, indexing="ij")
    return np.stack([np.cos(phi) * np.sin(lam), -np.cos(phi) * np.cos(lam), np.sin(phi)], axis=-1)


def horizontal_illuminance(pixels: NDArray[Any]) -> float:
    """Illuminance on a horizontal surface under the open sky, lux.

    The integral of luminance times cosine over the upper hemisphere; each row's share is exact, so
    that a constant sky of luminance L gives pi L.

    Args:
        pixels: (H, 2 H, 3) nits, scene-linear Rec.709.
    """
    height, width = pixels.shape[:2]
    edges = np.clip(math.pi * (0.5 - np.arange(height + 1) / height), 0.0, None)
    rows = 0.5 * np.abs(np.diff(np.sin(edges) ** 2)) * (2.0 * math.pi / width)
    return float(rows @ luminance(pixels).sum(axis=1))


def make_sky(
    *,
    height: int = 224,
    sun_elevation: float = 38.0,
    sun_azimuth: float = -52.0,
    sun_illuminance: float = 12_000.0,
    sun_spread: float = 2.5,
    turbidity: float = 3.5,
    seed: int = 0,
) -> Floats:
    """A clear day over a garden: the analytic sky of Preetham et al., a soft sun, trees and lawn.

    Args:
        height: Rows; there are twice as many columns.
        sun_elevation: Degrees above the horizon.
        sun_azimuth: Degrees counter-clockwise from +X, seen from above.
        sun_illuminance: What the sun adds on a surface that faces it, lux.
        sun_spread: Standard deviation of the sun's disk, degrees: wide, so that few samples find
            it and shadows stay soft.
        turbidity: Haze; 2 is very clear, 6 is hazy.
        seed: Draws trees and grass.

    Returns:
        (H, 2 H, 3) nits, scene-linear Rec.709.
    """
    rng = np.random.Generator(np.random.PCG64(seed))
    way = directions(height)
    elevation, azimuth = math.radians(sun_elevation), math.radians(sun_azimuth)
    sun = np.array(
        [
            math.cos(elevation) * math.cos(azimuth),
            math.cos(elevation) * math.sin(azimuth),
            math.sin(elevation),
        ]
    )
    sky = _sky(way, sun, turbidity) + _sun(way, sun, sun_illuminance, math.radians(sun_spread))
    lit = horizontal_illuminance(sky)
    land, cover = _land(way, rng, sun, lit)
    return (sky * (1.0 - cover) + land * cover).astype(np.float32)


def _sky(way: Array, sun: Array, turbidity: float) -> Array:
    """(H, W, 3) nits of the sky above the horizon, without the sun."""
    up = np.maximum(way[..., 2], 0.02)
    gamma = np.arccos(np.clip(way @ sun, -1.0, 1.0))
    zenith = math.acos(float(sun[2]))
    coefficients = _PEREZ @ np.array([turbidity, 1.0])
    shape = [
        _perez(c, up, gamma) / _perez(c, np.array(1.0), np.array(zenith)) for c in coefficients
    ]
    chi = (4.0 / 9.0 - turbidity / 120.0) * (math.pi - 2.0 * zenith)
    brightness = (4.0453 * turbidity - 4.9710) * math.tan(chi) - 0.2155 * turbidity + 2.4192
    powers = np.array([zenith**3, zenith**2, zenith, 1.0])
    white = np.array([turbidity**2, turbidity, 1.0]) @ _ZENITH @ powers
    Y = 1000.0 * brightness * shape[0]
    x, y = white[0] * shape[1], white[1] * shape[2]
    xyz = np.stack([x / y * Y, Y, (1.0 - x - y) / y * Y], axis=-1)
    return np.asarray(np.maximum(xyz @ RGB_FROM_XYZ.T, 0.0))


def _perez(c: Array, up: Array, gamma: Array) -> Array:
    """The sky's distribution by Perez et al. (1993)."""
    around = 1.0 + c[2] * np.exp(c[3] * gamma) + c[4] * np.cos(gamma) ** 2
    return np.asarray((1.0 + c[0] * np.exp(c[1] / up)) * around)


def _sun(way: Array, sun: Array, illuminance: float, spread: float) -> Array:
    """(H, W, 3) nits of a Gaussian disk that gives ``illuminance`` on what faces it."""
    gamma = np.arccos(np.clip(way @ sun, -1.0, 1.0))
    disk = np.exp(-0.5 * (gamma / spread) ** 2) / (2.0 * math.pi * spread**2)
    color = _SUNLIGHT / float(luminance(_SUNLIGHT))
    return np.asarray(illuminance * disk[..., None] * color)


def _land(
    way: Array, rng: np.random.Generator, sun: Array, illuminance: float
) -> tuple[Array, Array]:
    """(H, W, 3) nits of lawn, path and trees, and (H, W, 1) where they hide the sky."""
    elevation = np.arcsin(way[..., 2])
    width = way.shape[1]
    texel = math.pi / way.shape[0]
    tops = math.radians(4.0) + math.radians(7.0) * _ridge(rng, width, (3, 7, 16, 37, 80))
    cover = np.clip((tops - elevation) / texel + 0.5, 0.0, 1.0)
    ground = _ground(way, rng, illuminance)
    trees = _trees(way, rng, sun, elevation, illuminance)
    # Trees stand on the ground at some distance; their foot is a soft edge.
    foot = -math.atan(_EYE_HEIGHT_M / _TREE_DISTANCE_M)
    standing = np.clip((elevation - foot) / (1.5 * texel) + 0.5, 0.0, 1.0)[..., None]
    return ground * (1.0 - standing) + trees * standing, cover[..., None]


def _ridge(rng: np.random.Generator, width: int, waves: tuple[int, ...]) -> Array:
    """(W,) a periodic outline in 0..1, rougher with each wave number."""
    angle = 2.0 * math.pi * (np.arange(width) + 0.5) / width
    phases = rng.uniform(0.0, 2.0 * math.pi, len(waves))
    line = sum(
        np.sin(n * angle + p) * waves[0] ** 0.7 / n**0.7 for n, p in zip(waves, phases, strict=True)
    )
    line = np.asarray(line)
    return np.asarray((line - line.min()) / (line.max() - line.min()))


def _grain(rng: np.random.Generator, shape: tuple[int, int], size: int) -> Array:
    """(H, W) blurred noise of mean 0, periodic in columns, features of ``size`` pixels."""
    noise = rng.random(shape) - 0.5
    for axis in (0, 1):
        for _ in range(3):
            steps = range(-size // 2, size // 2 + 1)
            noise = np.mean([np.roll(noise, step, axis=axis) for step in steps], axis=0)
    return noise / float(noise.std())


def _ground(way: Array, rng: np.random.Generator, illuminance: float) -> Array:
    """(H, W, 3) nits of a lawn with a terrace around the house."""
    down = np.maximum(-way[..., 2], 1e-3)
    distance = _EYE_HEIGHT_M * np.hypot(way[..., 0], way[..., 1]) / down
    terrace = np.clip((4.0 - distance) / 0.4, 0.0, 1.0)[..., None]
    patches = 1.0 + 0.12 * _grain(rng, (way.shape[0], way.shape[1]), 6)
    blades = 1.0 + 0.10 * _grain(rng, (way.shape[0], way.shape[1]), 1)
    # Seen flat, a lawn shows more of its sunlit tips.
    lawn = _LAWN * (patches * blades * (1.0 + 0.35 * np.exp(-down / 0.1)))[..., None]
    albedo = lawn * (1.0 - terrace) + _PATH * terrace
    return np.asarray(albedo * illuminance / math.pi)


def _trees(
    way: Array, rng: np.random.Generator, sun: Array, elevation: Array, illuminance: float
) -> Array:
    """(H, W, 3) nits of foliage: lit from above and from the sun's side, with haze."""
    clumps = _grain(rng, (way.shape[0], way.shape[1]), 4)
    leaves = _grain(rng, (way.shape[0], way.shape[1]), 1)
    facing = 0.5 - 0.5 * (way[..., :2] @ sun[:2])
    lit = np.clip(0.45 + 0.4 * facing + 0.18 * clumps + 0.12 * leaves, 0.08, None)
    rising = 0.6 + 2.0 * np.clip(elevation, 0.0, 0.3)
    foliage = _LEAVES * (lit * rising)[..., None] * illuminance / math.pi
    haze = 0.06 * illuminance / math.pi * np.array([0.75, 0.9, 1.1]) * 0.5
    return np.asarray(foliage + 0.5 * haze)


def _rounded(pixels: Floats, bits: int = 8) -> Floats:
    """Values to so many significant bits, which makes files small."""
    mantissa, exponent = np.frexp(pixels)
    return np.asarray(np.ldexp(np.rint(mantissa * 2**bits) / 2**bits, exponent), np.float32)


if __name__ == "__main__":
    write_exr(Path(sys.argv[1]), _rounded(make_sky()))


_LARGEST: Final = float(np.finfo(np.float32).max)


def read_panorama(path: str) -> Floats:
    """Read a latitude-longitude picture with linear pixels, such as HDR or EXR.

    Args:
        path: The picture.

    Returns:
        (H, 2 H, 3) finite, not negative.

    Raises:
        InputError: It cannot be read, is encoded for a display, has another shape, or a pixel is
            not valid radiance.
    """
    if color_space(path) == "sRGB":
        raise InputError(
            "pictures with 8 bits per channel are encoded for displays, and hold no radiance",
            place=path,
            remedy="give an HDR or EXR picture, with linear pixels",
        )
    pixels = read_texture(path)
    height, width, channels = pixels.shape
    if width != 2 * height:
        raise InputError(
            f"{width} x {height} pixels are not a latitude-longitude picture",
            place=path,
            remedy="give a panorama that is twice as wide as high",
        )
    if channels < 3:
        pixels = np.repeat(pixels[..., :1], 3, axis=2)
    pixels = np.ascontiguousarray(pixels[..., :3])
    _check_pixels(pixels, path)
    return pixels


def scaled_to_nits(
    pixels: Floats, path: str, *, illuminance: float | None, scale: float | None
) -> Floats:
    """Bring a panorama to nits.

    Args:
        pixels: (H, 2 H, 3) of `read_panorama`.
        path: Where it is from, for messages.
        illuminance: Horizontal illuminance that it shall give, lux.
        scale: Nits for one unit of its pixels, when no illuminance is given; 1 by default.

    Raises:
        InputError: It is black where the illuminance comes from, or becomes too bright to store.
    """
    factor = 1.0 if scale is None else scale
    if illuminance is not None:
        given = horizontal_illuminance(pixels)
        if given <= 0.0:
            raise InputError(
                "its upper half is black, so it cannot be scaled to an illuminance",
                place=path,
                remedy="remove illuminance, or give another picture",
            )
        factor = illuminance / given
    brightest = float(pixels.max()) * factor
    if brightest > _LARGEST:
        raise InputError(
            f"its brightest pixel would have {brightest:.3g} nits, which exceeds the range of "
            "floats",
            place=path,
            remedy="lower scale or illuminance",
        )
    return np.asarray(pixels * np.float64(factor), dtype=np.float32)


def _check_pixels(pixels: Floats, path: str) -> None:
    bad = ~np.isfinite(pixels) | (pixels < 0.0)
    if bad.any():
        row, column, channel = (int(i[0]) for i in np.nonzero(bad))
        raise InputError(
            f"pixel ({column}, {row}) has {'RGB'[channel]} = {pixels[row, column, channel]}, "
            f"which is not valid radiance ({int(bad.any(axis=-1).sum())} such pixels)",
            place=path,
            remedy="correct the picture: radiance must be finite and at least 0",
        )
