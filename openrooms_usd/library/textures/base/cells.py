"""Cells about sites: crystals, pebbles, dimples, hexagons. They tile without a seam.

A site lies in every field of a grid, so the nearest ones of a texel lie in the nine fields around
it (S. Worley, A Cellular Texture Basis Function, SIGGRAPH 1996).
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base.family import TextureParams
from openrooms_usd.library.textures.base.noise import Field
from openrooms_usd.library.textures.base.recipe import Index, whole

# Sites no farther than this from their field's middle, in fields: beyond, nine are too few.
_MAX_JITTER: Final = 0.4
_ROUND: Final = tuple((row, column) for row in (-1, 0, 1) for column in (-1, 0, 1))


@dataclass(frozen=True)
class Cells:
    """Which cell each texel belongs to, and where in it.

    Attributes:
        index: (N, N) cell.
        count: How many there are.
        across: (N, N) distance from the site along s, metres.
        up: (N, N) distance from the site along t, metres.
        edge: (N, N) distance to the line half way to the second nearest site, metres.
        gap: (N, N) distance of the two sites, metres.
    """

    index: Index
    count: int
    across: Field
    up: Field
    edge: Field
    gap: Field

    @property
    def facet(self) -> Field:
        """(N, N) 0 on the edges and rising in planes from them, m2: continuous, unlike ``edge``."""
        return self.edge * self.gap

    @property
    def radius(self) -> Field:
        """(N, N) distance from the site, metres."""
        return np.hypot(self.across, self.up)


def scattered_cells(
    order: TextureParams, width: float, jitter: float = 1.0, warp: tuple[Field, Field] | None = None
) -> Cells:
    """Irregular cells.

    Args:
        order: What is asked for.
        width: Mean width of a cell, metres.
        jitter: How irregular they are, 0 for squares, 1 for the most.
        warp: (N, N) how far a texel is moved along s and t before it looks for its site, metres:
            small against the width, it makes edges uneven.
    """
    count = whole(order.size, width)
    offsets = _MAX_JITTER * jitter * order.rng.uniform(-1.0, 1.0, (2, count, count))
    return _cells(order, offsets, warp)


def hexagons(order: TextureParams, width: float, warp: tuple[Field, Field] | None = None) -> Cells:
    """Regular hexagons with a corner up, in rows shifted by half.

    Args:
        order: What is asked for.
        width: Distance of two parallel sides with a joint, metres; rounded to whole numbers of
            columns and of pairs of rows, so that they are up to a few per cent off regular.
        warp: As of `scattered_cells`.
    """
    columns = whole(order.size, width)
    rows = whole(order.size, width * np.sqrt(0.75), 2)
    offsets = np.zeros((2, rows, columns))
    offsets[0] = np.where(np.arange(rows) % 2, 0.25, -0.25)[:, None]
    return _cells(order, offsets, warp)


def _cells(order: TextureParams, offsets: Field, warp: tuple[Field, Field] | None) -> Cells:
    """Cells of one site in each field of a grid, ``offsets`` (2, R, C) from its middle."""
    shape = (order.resolution, order.resolution)
    moved_s, moved_t = warp or (0.0, 0.0)
    grid = _Grid(order, offsets)
    nearest, second = np.full(shape, np.inf), np.full(shape, np.inf)
    first_at, second_at = np.zeros(shape, np.intp), np.zeros(shape, np.intp)
    for number in range(len(_ROUND)):
        across, down = grid.to_site(number)
        distance = (across + moved_s) ** 2 + (down - moved_t) ** 2
        closer = distance < nearest
        second_at = np.where(closer, first_at, np.where(distance < second, number, second_at))
        first_at = np.where(closer, number, first_at)
        second = np.where(closer, nearest, np.minimum(second, distance))
        nearest = np.minimum(nearest, distance)
    index, site_s, site_t = grid.site(first_at)
    _, other_s, other_t = grid.site(second_at)
    gap = np.hypot(other_s - site_s, other_t - site_t)
    across, up = grid.place_s - site_s + moved_s, site_t - grid.place_t + moved_t
    return Cells(index, offsets[0].size, across, up, (second - nearest) / (2.0 * gap), gap)


class _Grid:
    """A grid of fields with a site in each, and the texels on it; metres, t downwards."""

    def __init__(self, order: TextureParams, offsets: Field) -> None:
        self.rows, self.columns = offsets.shape[1:]
        self.pitch_s, self.pitch_t = order.size / self.columns, order.size / self.rows
        self.offset_s, self.offset_t = offsets[0] * self.pitch_s, offsets[1] * self.pitch_t
        place = (np.arange(order.resolution) + 0.5) * (order.size / order.resolution)
        self.place_s, self.place_t = place, place[:, None]
        self.column = np.floor(place / self.pitch_s).astype(np.intp)
        self.row = np.floor(place / self.pitch_t).astype(np.intp)

    def to_site(self, number: int) -> tuple[Field, Field]:
        """(N, N) from the site of one of the nine fields around to the texel, along s and down."""
        below, right = _ROUND[number]
        row, column = self.row + below, self.column + right
        field = np.ix_(row % self.rows, column % self.columns)
        across = self.place_s - (column + 0.5) * self.pitch_s
        down = self.place_t - (row[:, None] + 0.5) * self.pitch_t
        return across - self.offset_s[field], down - self.offset_t[field]

    def site(self, number: Index) -> tuple[Index, Field, Field]:
        """(N, N) which site it is, and its place along s and down."""
        below, right = np.array(_ROUND).T
        row, column = self.row[:, None] + below[number], self.column + right[number]
        index = row % self.rows * self.columns + column % self.columns
        site_s = (column + 0.5) * self.pitch_s + self.offset_s.ravel()[index]
        site_t = (row + 0.5) * self.pitch_t + self.offset_t.ravel()[index]
        return index, site_s, site_t


def scales(order: TextureParams, width: float) -> Cells:
    """Discs in rows half their width apart, each row shifted by half and laid over the one below.

    A point belongs to the topmost disc that covers it; three rows reach every point. The lower edge
    of each piece is its own arc, the upper ones are the arcs of the two pieces above.

    Args:
        order: What is asked for.
        width: Width of a scale with its joint, metres; rounded to whole numbers of columns and
            pairs of rows.

    Returns:
        The scales; their site is the middle of the disc, their edge the nearest arc.
    """
    columns = whole(order.size, width)
    rows = whole(order.size, width / 2, 2)
    pitch_s, pitch_t = order.size / columns, order.size / rows
    radius = pitch_s / 2
    texel = order.size / order.resolution
    place = np.asarray((np.arange(order.resolution) + 0.5) * texel, np.float64)
    top_row = np.floor(place / pitch_t).astype(np.int64)[:, None] - 1
    # Squeezed or stretched with the rows, so that the arcs still meet.
    squeeze = radius / pitch_t

    found = np.zeros((order.resolution, order.resolution), dtype=bool)
    index: Index = np.zeros(found.shape, np.int64)
    across, up = np.zeros(found.shape), np.zeros(found.shape)
    edge = np.full(found.shape, np.inf)
    for down in range(3):
        row = top_row + down
        column, beside = _nearest(place, row, pitch_s)
        above = ((row + 0.5) * pitch_t - place[:, None]) * squeeze
        arc = radius - np.hypot(beside, above)
        mine = ~found & (arc >= 0.0) if down < 2 else ~found
        index = np.where(mine, row % rows * columns + column % columns, index)
        across, up = np.where(mine, beside, across), np.where(mine, above, up)
        edge = np.where(found, edge, np.minimum(edge, np.abs(arc)))
        found = found | mine
    return Cells(index, rows * columns, across, up, edge, np.full_like(edge, pitch_s))


def _nearest(place: Field, row: Index, pitch: float) -> tuple[Index, Field]:
    """Number of the disc of a row next to each place along s, and the distance from its middle."""
    shift = 0.25 + 0.5 * (row % 2)
    column = np.floor(place / pitch - shift + 0.5).astype(np.int64)
    return column, place - (column + shift) * pitch
