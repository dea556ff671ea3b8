"""Single things strewn over a surface: pores, chips, scratches. They wrap around the edges."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Ints
from openrooms_usd.library.textures.base.family import TextureParams
from openrooms_usd.library.textures.base.noise import Field, standardized, white_spectrum
from openrooms_usd.library.textures.base.recipe import Index, displaced, noise


@dataclass(frozen=True)
class Strewn:
    """Things on a ground.

    Attributes:
        inside: (N, N) distance inside the edge of the thing here, metres; negative on the ground.
        index: (N, N) thing; 0 where there is none.
        count: How many there are, and the ground.
    """

    inside: Field
    index: Index
    count: int


def pits(
    order: TextureParams, share: float, radius: tuple[float, float], stretch: float = 1.0
) -> Strewn:
    """Round or oval holes of which the small ones are the most; they may overlap.

    Args:
        order: What is asked for.
        share: Share of the surface that they cover, about.
        radius: Range of their radii along t, metres.
        stretch: How much longer they are along s.
    """
    radii = _radii(order, share / stretch, radius)
    strewn = _ground(order, len(radii))
    for number, size in enumerate(radii, start=1):
        long = size * stretch * order.rng.uniform(0.6, 1.4) if stretch > 1.0 else size
        rows, columns, across, up = _window(order, long, size)
        inside = size * (1.0 - np.hypot(across / long, up / size))
        _laid_on(strewn, np.ix_(rows, columns), inside, number, crowded=True)
    return strewn


def chips(
    order: TextureParams, share: float, radius: tuple[float, float], sides: tuple[int, int] = (4, 7)
) -> Strewn:
    """Broken pieces with straight edges, side by side: one that would overlap is left out.

    Args:
        order: What is asked for.
        share: Share of the surface that would be covered if none were left out.
        radius: Range of their radii, metres.
        sides: Range of the number of their edges.
    """
    radii = np.sort(_radii(order, share, radius))[::-1]
    strewn = _ground(order, len(radii))
    for number, size in enumerate(radii, start=1):
        rows, columns, across, up = _window(order, 1.5 * size, 1.5 * size)
        inside = np.full(np.broadcast_shapes(across.shape, up.shape), np.inf)
        for angle, far in _edges(order.rng, int(order.rng.integers(sides[0], sides[1] + 1))):
            inside = np.minimum(inside, far * size - np.cos(angle) * across - np.sin(angle) * up)
        _laid_on(strewn, np.ix_(rows, columns), inside, number, crowded=False)
    return strewn


def lines(
    order: TextureParams,
    count: int,
    length: tuple[float, float],
    bend: float,
    angle: tuple[float, float],
) -> Field:
    """(N, N) how often fine straight or bent lines cross each texel, in widths of a texel.

    Args:
        order: What is asked for.
        count: Number of lines.
        length: Range of their lengths, metres.
        bend: Largest angle by which they turn from end to end, radians.
        angle: Range of their directions from s towards t, radians.
    """
    texels = order.resolution / order.size
    runs = order.rng.uniform(*length, count) * texels
    steps = np.maximum(2, np.ceil(runs)).astype(np.int64)
    owner = np.repeat(np.arange(count), steps)
    step = np.arange(len(owner)) - np.repeat(np.cumsum(steps) - steps, steps)
    share = step / steps[owner]
    turn = order.rng.uniform(-bend, bend, count)[owner]
    heading = order.rng.uniform(*angle, count)[owner] + turn * share / 2.0
    start = order.rng.uniform(0.0, order.resolution, (2, count))
    column = start[0][owner] + runs[owner] * share * np.cos(heading)
    row = start[1][owner] - runs[owner] * share * np.sin(heading)
    # A scratch is deepest in its middle.
    weight = order.rng.uniform(0.2, 1.0, count)[owner] * 4.0 * share * (1.0 - share)
    return _splat(order.resolution, row, column, weight)


def _splat(resolution: int, row: Field, column: Field, weight: Field) -> Field:
    """(N, N) points spread over the four texels around them."""
    top, left = np.floor(row), np.floor(column)
    down, right = row - top, column - left
    field = np.zeros(resolution * resolution)
    for below, share_t in ((0, 1.0 - down), (1, down)):
        for beside, share_s in ((0, 1.0 - right), (1, right)):
            r = (top.astype(np.int64) + below) % resolution
            c = (left.astype(np.int64) + beside) % resolution
            part = weight * share_t * share_s
            field += np.bincount(r * resolution + c, part, resolution * resolution)
    return field.reshape(resolution, resolution)


def _radii(order: TextureParams, share: float, radius: tuple[float, float]) -> Field:
    """Radii, spread evenly in their logarithm, of which the discs cover a share of the surface."""
    low, high = radius
    mean_square = (high**2 - low**2) / (2.0 * np.log(high / low))
    count = max(1, round(share * order.size**2 / (np.pi * mean_square)))
    return np.asarray(low * (high / low) ** order.rng.random(count))


def _edges(rng: np.random.Generator, sides: int) -> Iterator[tuple[float, float]]:
    """Directions of the sides of a polygon and how far they are, in radii."""
    angles = 2.0 * np.pi * (np.arange(sides) + rng.uniform(-0.3, 0.3, sides)) / sides
    angles = angles + rng.uniform(0.0, 2.0 * np.pi)
    return zip(angles.tolist(), rng.uniform(0.6, 1.1, sides).tolist(), strict=True)


def _ground(order: TextureParams, count: int) -> Strewn:
    shape = (order.resolution, order.resolution)
    return Strewn(np.full(shape, -np.inf), np.zeros(shape, np.int64), count + 1)


def _window(order: TextureParams, half_s: float, half_t: float) -> tuple[Ints, Ints, Field, Field]:
    """Rows and columns about a random place, and how far they are from it along s and t, metres."""
    texel = order.size / order.resolution
    centre = order.rng.uniform(0.0, order.size, 2)
    reach = [min(half + 2.0 * texel, order.size / 2 - texel) for half in (half_t, half_s)]
    rows, columns = (
        np.arange(int((at - far) // texel), int((at + far) // texel) + 1)
        for at, far in zip(centre, reach, strict=True)
    )
    across = (columns + 0.5) * texel - centre[1]
    up = centre[0] - (rows[:, None] + 0.5) * texel
    return rows % order.resolution, columns % order.resolution, across, up


def _laid_on(
    strewn: Strewn, place: tuple[Ints, ...], inside: Field, number: int, *, crowded: bool
) -> None:
    """Lay a thing on the ground; unless ``crowded``, only where it lies on no other."""
    here = strewn.inside[place]
    if not crowded and np.any((here > 0.0) & (inside > 0.0)):
        return
    over = inside > here
    strewn.inside[place] = np.where(over, inside, here)
    strewn.index[place] = np.where(over & (inside > 0.0), number, strewn.index[place])


_SIGMA_OF_WAVELENGTH: Final = 0.35


def fibres(
    rng: np.random.Generator,
    resolution: int,
    size: float,
    width: float,
    length: float,
    angle: float,
) -> Field:
    """(N, N) fibres of one direction, of mean 0 and standard deviation 1.

    Args:
        rng: Where the noise comes from.
        resolution: Texels along each side.
        size: Length of each side, metres.
        width: Of a fibre, metres.
        length: Of a fibre, metres.
        angle: From t towards s, radians.
    """
    frequency = np.fft.fftfreq(resolution, size / resolution)
    # Rows run against t.
    ft, fs = -frequency[:, None], np.abs(frequency[: resolution // 2 + 1])
    along = (ft * math.cos(angle) + fs * math.sin(angle)) * length
    across = (fs * math.cos(angle) - ft * math.sin(angle)) * width
    kernel = np.exp(-2.0 * (math.pi * _SIGMA_OF_WAVELENGTH) ** 2 * (along**2 + across**2))
    spectrum = white_spectrum(rng, resolution) * kernel
    return standardized(np.fft.irfft2(spectrum, s=(resolution, resolution)))


def matted(
    rng: np.random.Generator,
    resolution: int,
    size: float,
    width: float,
    length: float,
    layers: int,
    spread: float = math.pi,
) -> Field:
    """(N, N) fibres that lie over each other: the highest of layers of different directions.

    Args:
        rng: Where the noise comes from.
        resolution: Texels along each side.
        size: Length of each side, metres.
        width: Of a fibre, metres.
        length: Of a fibre, metres.
        layers: How many directions there are.
        spread: Range of the directions about t, radians.
    """
    top = np.full((resolution, resolution), -9.0)
    for layer in range(layers):
        angle = ((layer + rng.random()) / layers - 0.5) * spread
        np.maximum(top, fibres(rng, resolution, size, width, length, angle), out=top)
    return standardized(top)


# Large ones are stamped one by one: so many at most, later ones lie on top.
_MOST = 9000


@dataclass(frozen=True)
class Flakes:
    """Slivers, and where each texel lies on the one on top.

    Attributes:
        index: (N, N) sliver; 0 where there is none.
        count: How many there are, and the ground.
        across: (N, N) distance from its middle line, metres.
        along: (N, N) distance from its middle along it, metres.
        inside: (N, N) distance inside its edge, metres.
        level: (N, N) how high it lies, 0..1.
    """

    index: Index
    count: int
    across: Field
    along: Field
    inside: Field
    level: Field

    def each(self, values: Field) -> Field:
        """(N, N) a value for each sliver."""
        return np.asarray(values[self.index])

    def fibre(self, order: TextureParams, width: float, length: float) -> Field:
        """(N, N) fibres along each sliver, of mean 0 and standard deviation about 1."""
        field = noise(order, width, length)
        shift = order.rng.uniform(0.0, order.size, (2, self.count))
        texel = order.size / order.resolution
        column, row = np.arange(order.resolution), np.arange(order.resolution)[:, None]
        s = self.across + self.each(shift[0]) - column * texel
        return displaced(field, order, s, self.along + self.each(shift[1]) + row * texel)


def flakes(
    order: TextureParams,
    layers: float,
    length: tuple[float, float],
    width: tuple[float, float],
    spread: float,
) -> Flakes:
    """Slivers by chance, later ones on top.

    Args:
        order: What is asked for.
        layers: How often they cover the surface.
        length: Range of their lengths, metres.
        width: Range of their widths, metres.
        spread: Range of their directions to both sides of t, radians.
    """
    area = (sum(length) / 2) * (sum(width) / 2)
    count = min(_MOST, max(1, round(layers * order.size**2 / area)))
    shape = (order.resolution, order.resolution)
    pile = Flakes(np.zeros(shape, np.int64), count + 1, *(np.zeros(shape) for _ in range(4)))
    # The mean of two draws: most lie near t.
    angles = spread * (order.rng.random(count) + order.rng.random(count) - 1.0)
    halves = order.rng.uniform(*length, count) / 2, order.rng.uniform(*width, count) / 2
    places = order.rng.uniform(0.0, order.size, (2, count))
    for number in range(count):
        size = float(halves[0][number]), float(halves[1][number])
        middle = float(places[0][number]), float(places[1][number])
        _lay(order, pile, number + 1, middle, size, float(angles[number]))
    return pile


def _lay(
    order: TextureParams,
    pile: Flakes,
    number: int,
    middle: tuple[float, float],
    size: tuple[float, float],
    angle: float,
) -> None:
    """Lay one sliver of half length and half width ``size`` on the pile."""
    texel, sine, cosine = order.size / order.resolution, math.sin(angle), math.cos(angle)
    reach = abs(sine) * size[0] + abs(cosine) * size[1], abs(cosine) * size[0] + abs(sine) * size[1]
    columns, rows = (
        np.arange(int((at - far) // texel), int((at + far) // texel) + 1)
        for at, far in zip(middle, reach, strict=True)
    )
    columns, rows = columns[: order.resolution], rows[: order.resolution]
    s = (columns + 0.5) * texel - middle[0]
    t = middle[1] - ((rows + 0.5) * texel)[:, None]
    along, across = t * cosine + s * sine, s * cosine - t * sine
    # Ends are broken askew.
    inside = np.minimum(size[1] - np.abs(across), size[0] - np.abs(along + 0.4 * across))
    window = np.ix_(rows % order.resolution, columns % order.resolution)
    covers = inside > 0.0
    for field, value in (
        (pile.index, number),
        (pile.across, across),
        (pile.along, along),
        (pile.inside, inside),
        (pile.level, number / pile.count),
    ):
        field[window] = np.where(covers, value, field[window])
