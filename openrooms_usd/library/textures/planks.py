"""Planks side by side: glued panels, and floors with staggered joints. They run along t."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from openrooms_usd.library.textures.noise import Field

Index = NDArray[np.int64]


@dataclass(frozen=True)
class Planks:
    """Which plank each texel belongs to, and where on it.

    Attributes:
        index: (N, N) plank.
        count: How many there are.
        across: (N, N) distance from the plank's middle line, metres.
        edge: (N, N) distance to the plank's nearest edge, metres.
    """

    index: Index
    count: int
    across: Field
    edge: Field


def panel(rng: np.random.Generator, resolution: int, size: float) -> Planks:
    """Staves of one length, glued edge to edge."""
    count = max(1, round(size / rng.uniform(0.11, 0.17)))
    return _columns(_widths(rng, count, size), resolution, size, joints=None)


def floor(rng: np.random.Generator, resolution: int, size: float) -> Planks:
    """Floorboards of one width, each row staggered against the next."""
    count = max(2, round(size / rng.uniform(0.12, 0.19)))
    lengths = max(1, round(size / 1.1))
    offsets = _staggered(rng, count, lengths)
    joints = (offsets[:, None] + np.arange(lengths)) / lengths % 1.0
    return _columns(np.full(count, size / count), resolution, size, joints=np.sort(joints * size))


def _widths(rng: np.random.Generator, count: int, size: float) -> Field:
    widths = rng.uniform(0.75, 1.25, count)
    return widths * (size / float(widths.sum()))


def _staggered(rng: np.random.Generator, count: int, lengths: int) -> Field:
    """(count,) offsets in 0..1 that differ by at least a fifth from row to row."""
    steps = rng.uniform(0.22, 0.78, count)
    return np.cumsum(steps) % 1.0


def _columns(widths: Field, resolution: int, size: float, joints: Field | None) -> Planks:
    """Columns of planks along t; ``joints`` (columns, joints a column) are their ends, metres."""
    texel = size / resolution
    place = (np.arange(resolution) + 0.5) * texel
    starts = np.cumsum(widths) - widths
    column = np.searchsorted(starts, place, side="right") - 1
    across = place - starts[column] - widths[column] / 2
    edge = np.broadcast_to(widths[column] / 2 - np.abs(across), (resolution, resolution))
    index = np.broadcast_to(column, (resolution, resolution))
    if joints is not None:
        gap = np.abs(place[:, None, None] - joints[column])
        edge = np.minimum(edge, np.minimum(gap, size - gap).min(axis=-1))
        row = (place[:, None, None] >= joints[column]).sum(axis=-1) % joints.shape[1]
        index = index * joints.shape[1] + row
    count = int(index.max()) + 1
    return Planks(index, count, np.broadcast_to(across, index.shape), edge)
