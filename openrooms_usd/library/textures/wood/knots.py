"""Where branches were: knots and birds' eyes, which the grain flows around. They wrap around."""

from dataclasses import dataclass

import numpy as np

from openrooms_usd.library.textures.base.family import Order
from openrooms_usd.library.textures.base.noise import Field
from openrooms_usd.library.textures.wood.boards import Boards

# How far the grain feels a knot, in its radii across and along.
_REACH: tuple[float, float] = (3.0, 7.0)


@dataclass(frozen=True)
class Knots:
    """Knots of a surface.

    Attributes:
        lift: (N, N) by how much rings are moved around them, in radii of the knot.
        depth: (N, N) how far inside a knot, metres; negative around it.
    """

    lift: Field
    depth: Field


def knots(order: Order, boards: Boards, density: float, radius: tuple[float, float]) -> Knots:
    """Knots by chance; each stays on its own piece.

    Args:
        order: What is asked for.
        boards: The pieces.
        density: How many there are on a square metre.
        radius: Range of their radii, metres.
    """
    shape = (order.resolution, order.resolution)
    found = Knots(np.zeros(shape), np.full(shape, -1.0))
    for size in order.rng.uniform(*radius, round(density * order.size**2)):
        _grow(order, boards, found, float(size))
    return found


def _grow(order: Order, boards: Boards, found: Knots, size: float) -> None:
    texel = order.size / order.resolution
    middle = order.rng.uniform(0.0, order.size, 2)
    oval = order.rng.uniform(1.0, 1.5)
    reach = [min(far * size, order.size / 2 - texel) for far in _REACH]
    columns, rows = (
        np.arange(int((at - far) // texel), int((at + far) // texel) + 1)
        for at, far in zip(middle, reach, strict=True)
    )
    across = (columns + 0.5) * texel - middle[0]
    along = ((rows + 0.5) * texel - middle[1])[:, None] / oval
    window = np.ix_(rows % order.resolution, columns % order.resolution)
    own = boards.index[window] == boards.index[tuple((middle[::-1] / texel).astype(int))]
    # Fades out to nothing at the reach, so that the window leaves no edge.
    far = np.hypot(across / reach[0], along * oval / reach[1])
    fade = np.clip(1.0 - far, 0.0, 1.0)
    lift = size * np.exp(-((across / size) ** 2 + (along / (2.5 * size)) ** 2) / 2.0) * fade
    found.lift[window] += lift * own
    inside = np.where(own, size - np.hypot(across, along), -1.0)
    found.depth[window] = np.maximum(found.depth[window], inside)
