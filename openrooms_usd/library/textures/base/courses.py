"""Masonry and tiles laid in courses: rows of pieces with joints between, whole on every side."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from openrooms_usd.library.textures.base.family import TextureParams
from openrooms_usd.library.textures.base.noise import Field
from openrooms_usd.library.textures.base.recipe import Index, whole


@dataclass(frozen=True)
class Laid:
    """Which piece each texel belongs to, and where on it.

    Attributes:
        index: (N, N) piece.
        count: How many there are.
        course: (N, N) row of pieces that it lies in, from the upper edge.
        across: (N, N) distance from the piece's middle along s, metres.
        up: (N, N) distance from the piece's middle along t, metres.
        side: (N, N) distance to the middle of the joint at its nearer side, metres.
        bed: (N, N) distance to the middle of the joint above or below it, metres.
    """

    index: Index
    count: int
    course: Index
    across: Field
    up: Field
    side: Field
    bed: Field

    def inside(self, joint: float, radius: float = 0.0, wobble: Field | float = 0.0) -> Field:
        """(N, N) distance inside the piece's edge, metres; negative in the joint.

        Args:
            joint: Width of the joint, metres.
            radius: Radius of the piece's corners, metres.
            wobble: How much wider the piece is here, metres.
        """
        side, bed = self.side - joint / 2 + wobble, self.bed - joint / 2 + wobble
        corner = np.hypot(np.maximum(radius - side, 0.0), np.maximum(radius - bed, 0.0))
        return np.where(corner > 0.0, radius - corner, np.minimum(side, bed))


def laid(
    order: TextureParams, heights: Field, lengths: Sequence[Field], starts: Sequence[float] | Field
) -> Laid:
    """Courses of given heights, each with its own pieces.

    Args:
        order: What is asked for.
        heights: (C,) of the courses from the upper edge, metres; they add up to the size.
        lengths: For each course the lengths of its pieces, metres; they add up to the size.
        starts: (C,) where the first piece of each course begins, metres.
    """
    resolution, size = order.resolution, order.size
    place = np.asarray((np.arange(resolution) + 0.5) * (size / resolution), np.float64)
    course, down, half_height = _pieces(place, heights)
    rows = [
        _pieces((place - start) % size, own) for own, start in zip(lengths, starts, strict=True)
    ]
    firsts = np.cumsum([0] + [len(own) for own in lengths])
    index = np.array([row[0] for row in rows]) + firsts[:-1, None]
    across = np.array([row[1] for row in rows])
    side = np.array([row[2] for row in rows]) - np.abs(across)
    shape = (resolution, resolution)
    return Laid(
        index=index[course],
        count=int(firsts[-1]),
        course=np.broadcast_to(course[:, None], shape),
        across=across[course],
        up=np.broadcast_to(-down[:, None], shape),
        side=side[course],
        bed=np.broadcast_to((half_height - np.abs(down))[:, None], shape),
    )


def bond(
    order: TextureParams, piece: tuple[float, float], shift: float = 0.0, repeat: int = 1
) -> Laid:
    """Equal pieces, each course shifted against the one above.

    Args:
        order: What is asked for.
        piece: Length along s and height along t with a joint, metres; rounded to whole numbers of
            pieces on each side.
        shift: Shift from course to course, in pieces.
        repeat: After how many courses the shift comes to whole pieces.
    """
    columns = whole(order.size, piece[0])
    rows = whole(order.size, piece[1], repeat)
    lengths = np.full(columns, order.size / columns)
    starts = [(shift * row % 1.0) * lengths[0] for row in range(rows)]
    return laid(order, np.full(rows, order.size / rows), [lengths] * rows, starts)


def random_courses(
    order: TextureParams, height: tuple[float, float], length: tuple[float, float]
) -> Laid:
    """Courses of unequal heights with pieces of unequal lengths, joints staggered by chance.

    Args:
        order: What is asked for.
        height: Range of the courses' heights with a joint, metres.
        length: Range of the pieces' lengths with a joint, metres.
    """
    heights = _parts(order, height)
    lengths = [_parts(order, length) for _ in heights]
    starts = order.rng.uniform(0.0, order.size, len(heights))
    return laid(order, heights, lengths, starts)


def _parts(order: TextureParams, span: tuple[float, float]) -> Field:
    """Random lengths in a range, scaled so that they add up to the size."""
    count = whole(order.size, sum(span) / 2)
    parts = order.rng.uniform(*span, count)
    return parts * (order.size / float(parts.sum()))


def _pieces(place: Field, lengths: Field) -> tuple[Index, Field, Field]:
    """Number, distance from the middle and half length of the piece at each place."""
    ends = np.cumsum(lengths)
    number = np.minimum(np.searchsorted(ends, place, side="right"), len(lengths) - 1)
    half = lengths[number] / 2
    return number, place - (ends[number] - half), half
