"""What recipes of stone and metal share: draws, noises, soft edges, and the means asked for."""

from collections.abc import Sequence

import numpy as np

from openrooms_usd.arrays import Ints
from openrooms_usd.library.textures.base.family import Color, TextureParams
from openrooms_usd.library.textures.base.maps import ALBEDO_RANGE, ROUGHNESS_RANGE, Maps, with_mean
from openrooms_usd.library.textures.base.noise import (
    Field,
    smooth_noise,
    standardized,
    white_spectrum,
)

Index = Ints


def drawn_color(order: TextureParams, palette: tuple[Color, ...], spread: float = 0.1) -> Field:
    """(3,) a colour of a palette, a little lighter or darker; or the one asked for."""
    drawn = side_color(order, palette, spread)
    return drawn if order.color is None else np.array(order.color)


def side_color(order: TextureParams, palette: tuple[Color, ...], spread: float = 0.1) -> Field:
    """(3,) a colour between two of a palette, for parts that cannot be chosen: mortar, veins."""
    first, second = order.rng.integers(len(palette), size=2)
    share = order.rng.random()
    between = (1.0 - share) * np.array(palette[first]) + share * np.array(palette[second])
    return np.asarray(between * order.rng.uniform(1.0 - spread, 1.0 + spread))


def drawn_roughness(order: TextureParams, low: float, high: float) -> float:
    """A perceptual roughness in a range; or the one asked for."""
    drawn = order.rng.uniform(low, high)
    return drawn if order.roughness is None else order.roughness


def whole(size: float, unit: float, multiple: int = 1) -> int:
    """How many units a side of this size has: the nearest whole multiple, at least one.

    Units shrink or grow to fit: seven bricks of 225 mm on 1.5 m are 214 mm long.
    """
    return max(1, round(size / unit / multiple)) * multiple


def noise(order: TextureParams, length: float, along: float | None = None) -> Field:
    """Smooth noise with features ``length`` metres wide and ``along`` metres long (along t)."""
    lengths = (length, length if along is None else along)
    return smooth_noise(order.rng, order.resolution, order.size, lengths)


def fractal(
    order: TextureParams, longest: float, hurst: float, along: float | None = None
) -> Field:
    """Self-affine noise, such as of broken stone, of mean 0 and standard deviation 1.

    Its amplitude falls with the frequency f as f^-(1 + hurst) (Mandelbrot, The Fractal Geometry of
    Nature, 1982), and is flat for features longer than the longest.

    Args:
        order: What is asked for.
        longest: Size of its largest features along s, metres.
        hurst: 0 for very rough, 1 for smooth.
        along: Size of its largest features along t; as along s by default.
    """
    count = order.resolution
    frequency = np.fft.fftfreq(count, order.size / count)
    along_t = (frequency * (longest if along is None else along)) ** 2
    along_s = (frequency[: count // 2 + 1] * longest) ** 2
    filtered = (1.0 + along_t[:, None] + along_s) ** (-(1.0 + hurst) / 2.0)
    spectrum = white_spectrum(order.rng, count) * filtered
    spectrum[0, 0] = 0.0
    return standardized(np.fft.irfft2(spectrum, s=(count, count)))


def shifted_per_piece(order: TextureParams, field: Field, index: Index, count: int) -> Field:
    """A periodic field, moved by another amount on each of ``count`` pieces."""
    resolution = len(field)
    shifts = np.floor(resolution * order.rng.random((2, count))).astype(np.int64)
    rows, columns = np.ogrid[:resolution, :resolution]
    row = (rows + shifts[0][index]) % resolution
    column = (columns + shifts[1][index]) % resolution
    return np.asarray(field[row, column])


def displaced(field: Field, order: TextureParams, along_s: Field, along_t: Field) -> Field:
    """A periodic field read beside each texel, ``along_s`` and ``along_t`` metres away."""
    resolution = len(field)
    rows, columns = np.ogrid[:resolution, :resolution]
    row = rows - along_t * (resolution / order.size)
    column = columns + along_s * (resolution / order.size)
    top, left = np.floor(row), np.floor(column)
    down, right = row - top, column - left
    r0, c0 = top.astype(np.int64) % resolution, left.astype(np.int64) % resolution
    r1, c1 = (r0 + 1) % resolution, (c0 + 1) % resolution
    upper = field[r0, c0] * (1.0 - right) + field[r0, c1] * right
    lower = field[r1, c0] * (1.0 - right) + field[r1, c1] * right
    return np.asarray(upper * (1.0 - down) + lower * down)


def covered(order: TextureParams, inside: Field) -> Field:
    """Share of each texel that lies inside, from the distance inside an edge, metres."""
    texel = order.size / order.resolution
    return np.clip(0.5 + inside / texel, 0.0, 1.0)


def mixed(share: Field, inside: Field, outside: Field) -> Field:
    """(N, N, 3) one colour field where ``share`` is 1, another where it is 0."""
    return np.asarray(outside + share[..., None] * (inside - outside))


def finished(
    order: TextureParams,
    albedo: Field,
    height: Field,
    roughness: Field | float,
    metallic: Field | float = 0.0,
) -> Maps:
    """The maps, with the mean base colour and roughness that were asked for."""
    rough = np.broadcast_to(np.asarray(roughness, float), height.shape)
    if order.roughness is not None:
        rough = rough + (order.roughness - rough.mean())
    if order.color is not None:
        albedo = with_mean(albedo, np.array(order.color))
    return Maps(albedo, height, np.clip(rough, *ROUGHNESS_RANGE), metallic)


def shaded(
    order: TextureParams, color: Field, shade: Field, height: Field, rough: tuple[float, float]
) -> Maps:
    """The maps of a colour times (N, N) brightness, its roughness drawn from a range."""
    albedo = color * shade[..., None]
    return finished(order, albedo, height, drawn_roughness(order, *rough))


def dyed(
    order: TextureParams,
    shade: Field,
    height: Field,
    rough: tuple[float, float],
    wear: Field,
    usual: tuple[Color, ...],
) -> Maps:
    """A material of one colour all through.

    Args:
        order: What is asked for.
        shade: (N, N) brightness.
        height: (N, N) metres.
        rough: Range of its mean roughness.
        wear: (N, N) where it is rougher than its mean, and by how much.
        usual: Its usual mean colours.
    """
    return Maps(
        albedo=tinted(np.maximum(shade, 0.05), mean_color(order, usual)),
        height=height,
        roughness=around(drawn_roughness(order, *rough), wear),
    )


def mean_color(order: TextureParams, colors: Sequence[Color], spread: float = 0.15) -> Field:
    """(3,) the colour that is asked for, or one of some that are usual, a little varied.

    Args:
        order: What is asked for.
        colors: Usual mean colours, scene-linear Rec.709.
        spread: How much lighter or darker a drawn one may be.
    """
    drawn = colors[int(order.rng.integers(len(colors)))]
    varied = np.array(drawn) * order.rng.uniform(1.0 - spread, 1.0 + spread)
    return varied if order.color is None else np.array(order.color)


def tinted(pattern: Field, mean: Field | None = None) -> Field:
    """(N, N, 3) albedo with a pattern's contrasts and the given mean.

    What is nearly white or black has little contrast left: between bright threads the light
    bounces until it fills the hollows. So contrasts shrink to fit the range of albedo.

    Args:
        pattern: (N, N) or (N, N, 3) positive brightness.
        mean: (3,) mean colour; None: the pattern's own, which must then have three channels.
    """
    own = pattern.mean(axis=(0, 1))
    low, high = ALBEDO_RANGE
    wanted = np.clip(own if mean is None else mean, low, high)
    channels = pattern / own - 1.0
    if pattern.ndim == 2:
        channels = channels[..., None]
    above = max(float(np.max(wanted * channels.max(axis=(0, 1)) / (high - wanted + 1e-9))), 1.0)
    # Of the brightest channel: if another comes below the range, it is not seen.
    below = -float(channels.min(axis=(0, 1)).max()) / max(1.0 - low / float(wanted.max()), 1e-9)
    return np.asarray(np.clip(wanted + channels * (wanted / max(above, below)), low, high))


def around(mean: float, variation: Field) -> Field:
    """Roughness that varies about its mean, within what is physical."""
    return np.asarray(np.clip(mean + variation - variation.mean(), *ROUGHNESS_RANGE))
