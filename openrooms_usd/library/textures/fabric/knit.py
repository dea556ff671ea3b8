"""Knitted fabrics: loops in columns (wales, along t) and rows (courses)."""

from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np

from openrooms_usd.library.textures.base import lattice
from openrooms_usd.library.textures.base import vocabulary as tx
from openrooms_usd.library.textures.fabric.dyes import COLORS, NATURALS

# Height of a loop, in wales, and courses a wale's width holds.
_LOOP_HEIGHT_WALES: Final = 0.42
_COURSES_PER_WALE: Final = 1.25
# Wales of a cable, of its ground with it, and courses from one crossing of strands to the next.
_CABLE_WALES: Final = 6
_REPEAT_WALES: Final = 10
_CROSSING_COURSES: Final = 8


def _plain_side(across: tx.Field, along: tx.Field) -> tx.Field:
    """Height 0..1 of the face: each loop's two legs lean apart, so that columns of V appear.

    Args:
        across: Place in wales.
        along: Place in courses, broadcast against ``across``.
    """
    half = lattice.offset(2.0 * across)
    lean = 0.9 * np.abs(lattice.offset(across))
    leg = lattice.offset(along - lean)
    return np.asarray((1.0 - 0.75 * half**2) * (1.0 - 0.6 * leg**2))


def _purl_side(across: tx.Field, along: tx.Field) -> tx.Field:
    """Height 0..1 of the back: rows of arcs."""
    arc = lattice.offset(along + 0.18 * np.cos(2.0 * np.pi * across))
    return np.asarray((1.0 - 0.8 * arc**2) * (0.75 + 0.25 * np.cos(4.0 * np.pi * across)))


def _rib(across: tx.Field, along: tx.Field) -> tx.Field:
    """Two wales of the face, two of the back, which draws in and lies deeper."""
    place = across / 4.0
    raised = np.clip(0.5 + 2.2 * np.cos(2.0 * np.pi * (place - 0.25)), 0.0, 1.0)
    face = _plain_side(across, along) + 1.1
    return np.asarray(raised * face + (1.0 - raised) * 0.8 * _purl_side(across, along))


def _cable(across: tx.Field, along: tx.Field) -> tx.Field:
    """Ropes of two strands that cross over each other, on a ground of the back."""
    place = across % _REPEAT_WALES - _REPEAT_WALES / 2
    turn = np.pi * along / _CROSSING_COURSES
    height = 0.7 * _purl_side(across, along)
    for strand in (0.0, 0.5):
        angle = turn + 2.0 * np.pi * strand
        aside = place - 0.25 * _CABLE_WALES * np.cos(angle)
        round_off = 1.0 - (aside / (0.27 * _CABLE_WALES)) ** 2
        # What lies aside is level; in the middle one strand is over the other.
        loops = 0.75 * _plain_side(aside + 0.5, along)
        rope = loops + 1.4 * np.sqrt(np.maximum(round_off, 0.0)) + 0.9 * np.sin(angle) + 0.3
        height = np.maximum(height, np.where(round_off > 0.0, rope, 0.0))
    return np.asarray(height)


def _make(
    stitch: Callable[[tx.Field, tx.Field], tx.Field],
    wale: tuple[float, float],
    repeat: tuple[int, int],
    depth: float,
    order: tx.Order,
) -> tx.Maps:
    """A knitted fabric with whole repeats of wales and courses.

    Args:
        stitch: Height of a place in wales and courses.
        wale: Range of a wale's width, metres.
        repeat: Wales and courses after which the fabric repeats.
        depth: What a height of one is, in wales.
        order: What is asked for.
    """
    n, rng = order.resolution, order.rng
    mean = tx.mean_color(order, COLORS + NATURALS)
    pitch = float(rng.uniform(*wale))
    wales = lattice.whole(order, pitch, repeat[0])
    courses = lattice.whole(order, pitch / _COURSES_PER_WALE, repeat[1])
    uneven = 0.10 * tx.noise(order, 6.0 * pitch) + 0.05 * tx.noise(order, 1.2 * pitch)
    # Courses rise against the rows.
    height = stitch(lattice.phase(n, wales), -lattice.phase(n, courses)[:, None] + uneven)
    hairs = tx.noise(order, 0.3 * pitch)
    low = float(height.min())
    share = (height - low) / max(float(height.max()) - low, 1e-9)
    shade = (0.35 + 0.65 * np.sqrt(share)) * (1.0 + 0.08 * hairs)
    unit = depth * lattice.spacing(order, pitch, wales)
    return tx.Maps(
        albedo=tx.tinted(np.maximum(shade, 0.05), mean),
        height=unit * (height + 0.05 * hairs) + 0.15 * pitch * tx.noise(order, 0.05),
        roughness=tx.around(tx.drawn_roughness(order, 0.84, 0.94), -0.06 * share),
    )


KNITTED: Final[dict[str, tx.Family]] = {
    name: tx.Family(
        lattice.resolved(partial(_make, stitch, wale, repeat, _LOOP_HEIGHT_WALES), 0.5 * wale[0]),
        size,
        frozenset({"textile", "furniture"}),
        grain=True,
        laid=4 if size < 0.15 else 2,
    )
    for name, stitch, wale, repeat, size in (
        ("jersey_knit", _plain_side, (0.0013, 0.0016), (1, 1), 0.1),
        ("rib_knit", _rib, (0.0022, 0.0027), (4, 1), 0.16),
        ("cable_knit", _cable, (0.0036, 0.0042), (_REPEAT_WALES, 2 * _CROSSING_COURSES), 0.24),
    )
}
