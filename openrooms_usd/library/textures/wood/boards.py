"""Pieces of wood side by side: staves, planks and parquets; whole numbers of them on each side.

Each texel knows its piece and its place on it, across the grain and along it, whatever way the
piece is laid.
"""

from dataclasses import dataclass

import numpy as np

from openrooms_usd.arrays import Mask
from openrooms_usd.library.textures.base import vocabulary as tx


@dataclass(frozen=True)
class Boards:
    """Which piece each texel belongs to, and where on it.

    Attributes:
        index: (N, N) piece.
        count: How many there are.
        across: (N, N) distance from the piece's middle line, metres.
        along: (N, N) place along its grain, metres.
        edge: (N, N) distance to the piece's nearest edge, metres; infinite where it has none.
        oblique: Whether the grain runs along neither s nor t.
    """

    index: tx.Index
    count: int
    across: tx.Field
    along: tx.Field
    edge: tx.Field
    oblique: bool = False

    def spread(self, order: tx.TextureParams, field: tx.Field) -> tx.Field:
        """A periodic field, grain along t, cut from another place for each piece."""
        return self.cut(order, field)[0]

    def cut(self, order: tx.TextureParams, *fields: tx.Field) -> list[tx.Field]:
        """Periodic fields, grain along t, all cut from another place for each piece."""
        resolution = order.resolution
        texels = resolution / order.size
        shift = np.floor(resolution * order.rng.random((2, self.count)))
        column = self.across * texels + shift[0][self.index]
        row = shift[1][self.index] - self.along * texels
        if not self.oblique:
            place = _flat(np.floor(row), np.floor(column), resolution)
            return [np.take(field, place) for field in fields]
        top, left = np.floor(row), np.floor(column)
        down, right = row - top, column - left
        corners = [
            (_flat(top + below, left + beside, resolution), weight_t * weight_s)
            for below, weight_t in ((0, 1.0 - down), (1, down))
            for beside, weight_s in ((0, 1.0 - right), (1, right))
        ]
        return [_blended(field, corners) for field in fields]

    def each(self, values: tx.Field) -> tx.Field:
        """(N, N) a value for each piece."""
        return np.asarray(values[self.index])

    def gap(self, order: tx.TextureParams, width: float) -> tx.Field:
        """(N, N) share of each texel that is the gap between pieces, ``width`` metres wide."""
        texel = order.size / order.resolution
        return np.clip((width / 2 + texel / 2 - self.edge) / texel, 0.0, 1.0)

    def bevel(self, width: float) -> tx.Field:
        """(N, N) 0 inside to 1 at the edge over ``width`` metres."""
        return np.clip(1.0 - self.edge / width, 0.0, 1.0)


def staves(order: tx.TextureParams, width: tuple[float, float], mirrored: bool = False) -> Boards:
    """Pieces that run through, edge to edge.

    Args:
        order: What is asked for.
        width: Range of their widths, metres.
        mirrored: Veneers of one width, each the mirror picture of its neighbour.
    """
    count = tx.whole(order.size, sum(width) / 2, 2 if mirrored else 1)
    widths = np.ones(count) if mirrored else order.rng.uniform(*width, count)
    widths = widths * (order.size / float(widths.sum()))
    place = _place(order)
    starts = np.cumsum(widths) - widths
    column = np.searchsorted(starts, place, side="right") - 1
    across = place - starts[column] - widths[column] / 2
    edge = widths[column] / 2 - np.abs(across)
    if mirrored:
        across = np.where(column % 2, -across, across)
    index = np.zeros_like(column) if mirrored else column
    shape = (order.resolution, order.resolution)
    return Boards(
        np.broadcast_to(index, shape),
        int(index.max()) + 1,
        np.broadcast_to(across, shape),
        np.broadcast_to(order.size - place[:, None], shape),
        np.broadcast_to(edge, shape),
    )


def planks(
    order: tx.TextureParams, width: tuple[float, float], length: tuple[float, float]
) -> Boards:
    """Rows of pieces with staggered ends.

    Args:
        order: What is asked for.
        width: Range of the rows' widths, metres; equal ends for one width.
        length: Range of the pieces' lengths, metres.
    """
    rows = tx.whole(order.size, sum(width) / 2)
    widths = order.rng.uniform(*width, rows)
    pieces = tx.whole(order.size, sum(length) / 2)
    lengths = [order.rng.uniform(*length, pieces) for _ in range(rows)]
    starts = np.cumsum(order.rng.uniform(0.22, 0.78, rows)) * (order.size / pieces)
    return _upright(
        tx.laid(
            order,
            widths * (order.size / float(widths.sum())),
            [own * (order.size / float(own.sum())) for own in lengths],
            starts,
        )
    )


def _upright(rows: tx.Laid) -> Boards:
    """Courses turned by a quarter: their pieces run along t."""
    edge = np.minimum(rows.side, rows.bed).T
    return Boards(rows.index.T, rows.count, rows.up.T, -rows.across.T, edge)


def blocks(order: tx.TextureParams, side: float, fingers: int = 1) -> Boards:
    """Squares of parallel fingers, each turned by a quarter against its neighbours.

    Args:
        order: What is asked for.
        side: Of a square, metres.
        fingers: How many pieces make a square.
    """
    count = tx.whole(order.size, side, 2)
    place = _place(order) / order.size * count
    cell = np.floor(place).astype(np.int64)
    s = (place - cell)[None, :] + np.zeros((order.resolution, 1))
    t = 1.0 - s.T
    turned = (cell[:, None] + cell[None, :]) % 2 == 1
    over, on = np.where(turned, t, s), np.where(turned, s, t)
    finger = np.minimum(np.floor(over * fingers), fingers - 1).astype(np.int64)
    across = over - (finger + 0.5) / fingers
    edge = np.minimum(0.5 / fingers - np.abs(across), 0.5 - np.abs(on - 0.5))
    index = (cell[:, None] * count + cell[None, :]) * fingers + finger
    unit = order.size / count
    return Boards(index, count * count * fingers, across * unit, on * unit, edge * unit)


def herringbone(order: tx.TextureParams, width: float, ratio: int) -> Boards:
    """Pieces at right angles whose ends butt against sides, at 45 degrees to the walls.

    Args:
        order: What is asked for.
        width: Of a piece, metres; rounded so that the pattern repeats on each side.
        ratio: How many times longer than wide a piece is.
    """
    repeats = tx.whole(order.size, width * ratio * np.sqrt(2.0))
    unit = order.size / (repeats * ratio * np.sqrt(2.0))
    place = _place(order)
    s, t = place[None, :], place[::-1, None]
    x, y = (s + t) / (np.sqrt(2.0) * unit), (s - t) / (np.sqrt(2.0) * unit)
    i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    step = (i - j) % (2 * ratio)
    lies = step < ratio
    offset = np.where(lies, step, 2 * ratio - 1 - step)
    fraction_x, fraction_y = x - i, y - j
    across = np.where(lies, fraction_y, fraction_x) - 0.5
    along = offset + np.where(lies, fraction_x, fraction_y)
    edge = np.minimum(0.5 - np.abs(across), ratio / 2 - np.abs(along - ratio / 2))
    start = np.where(lies, i - offset, i), np.where(lies, j, j - offset)
    index = _numbered(start, lies, repeats * ratio)
    return Boards(index, int(index.max()) + 1, across * unit, along * unit, edge * unit, True)


def _numbered(start: tuple[tx.Index, tx.Index], lies: Mask, turn: int) -> tx.Index:
    """(N, N) the same number for a piece and its copy on the other side of the picture.

    A side of the picture moves pieces by (turn, turn) or by (turn, -turn).
    """
    total, difference = (start[0] + start[1]) % (2 * turn), (start[0] - start[1]) % (2 * turn)
    key = (total * 2 * turn + difference) * 2 + lies
    return np.unique(key, return_inverse=True)[1].reshape(key.shape)


def chevron(order: tx.TextureParams, column: float, pitch: float, slope: float = 1.0) -> Boards:
    """Columns of parallelograms whose ends meet in straight lines along t.

    Args:
        order: What is asked for.
        column: Width of a column, metres.
        pitch: Height of a piece along t, metres.
        slope: By how much a piece rises along t over what it runs along s.
    """
    columns, rows = tx.whole(order.size, column, 2), tx.whole(order.size, pitch)
    width, high = order.size / columns, order.size / rows
    place = _place(order)
    number = np.floor(place / width).astype(np.int64)
    run = place - number * width
    run = np.where(number % 2, width - run, run)
    lift = (place[::-1, None] - slope * run) / high
    row = np.floor(lift).astype(np.int64)
    share = 1.0 / np.hypot(1.0, slope)
    across = (lift - row - 0.5) * high * share
    along = np.broadcast_to(run / share, across.shape) + across * slope
    edge = np.minimum(0.5 * high * share - np.abs(across), np.minimum(run, width - run))
    index = number * rows + row % rows
    return Boards(index, columns * rows, across, along, edge, True)


def _flat(row: tx.Field, column: tx.Field, resolution: int) -> tx.Index:
    """Places in a periodic field as numbers of its texels."""
    rows, columns = row.astype(np.int64) % resolution, column.astype(np.int64) % resolution
    return rows * resolution + columns


def _blended(field: tx.Field, corners: list[tuple[tx.Index, tx.Field]]) -> tx.Field:
    blend = np.zeros_like(field)
    for place, weight in corners:
        blend += weight * np.take(field, place)
    return blend


def _place(order: tx.TextureParams) -> tx.Field:
    """(N,) places of the texels' centres, metres."""
    return np.asarray((np.arange(order.resolution) + 0.5) * (order.size / order.resolution))
