"""Scallops that overlap like the scales of a fish."""

import numpy as np

from openrooms_usd.library.textures.base.cells import Cells
from openrooms_usd.library.textures.base.family import Order
from openrooms_usd.library.textures.base.noise import Field
from openrooms_usd.library.textures.base.recipe import Index, whole


def scales(order: Order, width: float) -> Cells:
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
