"""Flat slivers that lie over each other: strands and particles of boards. They wrap around."""

import math
from dataclasses import dataclass

import numpy as np

from openrooms_usd.library.textures.base.family import Order
from openrooms_usd.library.textures.base.noise import Field
from openrooms_usd.library.textures.base.recipe import Index, displaced, noise

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

    def fibre(self, order: Order, width: float, length: float) -> Field:
        """(N, N) fibres along each sliver, of mean 0 and standard deviation about 1."""
        field = noise(order, width, length)
        shift = order.rng.uniform(0.0, order.size, (2, self.count))
        texel = order.size / order.resolution
        column, row = np.arange(order.resolution), np.arange(order.resolution)[:, None]
        s = self.across + self.each(shift[0]) - column * texel
        return displaced(field, order, s, self.along + self.each(shift[1]) + row * texel)


def flakes(
    order: Order,
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
    order: Order,
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
