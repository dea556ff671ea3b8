"""Rows of books: standing in runs, leaning at their ends, lying in piles."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.rotations import about_y, pose
from openrooms_usd.geometry.solids import box
from openrooms_usd.geometry.sweeps import extrude

COVER: Final = 0.0025
# Print stands so far before spines, metres, and lies between these shares of their height.
_INK_M: Final = 0.0002
_SPINES: Final[tuple[tuple[tuple[float, float], ...], ...]] = (
    ((0.09, 0.1), (0.88, 0.89)),
    ((0.62, 0.84),),
    ((0.06, 0.075), (0.7, 0.86), (0.915, 0.93)),
    ((0.3, 0.72),),
    (),
)
# So many bindings are told apart; books of one are one mesh.
BINDINGS: Final = 7


@dataclass(frozen=True)
class Book:
    """A book and how it is placed.

    Attributes:
        size: Thickness, depth and height, metres.
        binding: Which of the `BINDINGS` it has.
        pose: (4, 4) from its own frame, the left corner of its spine in the origin.
    """

    size: tuple[float, float, float]
    binding: int
    pose: Array

    def cover(self) -> Mesh:
        """Boards and spine: a U seen from above, the spine at the front."""
        t, d, h = self.size
        c, bend = COVER, min(0.004, 0.25 * self.size[0])
        outline = [
            (0.0, d),
            (0.0, bend),
            (bend, 0.0),
            (t - bend, 0.0),
            (t, bend),
            (t, d),
            (t - c, d),
            (t - c, c + bend),
            (c, c + bend),
            (c, d),
        ]
        return extrude(outline, h).transformed(self.pose)

    def bands(self) -> list[Mesh]:
        """What is printed on the spine: a title between two rules, or a title alone; or nothing."""
        t, _, h = self.size
        # Books of equal make are printed alike.
        kind = (self.binding + round(1000 * t)) % 5
        places = _SPINES[kind]
        thick = max(t - 0.007, 0.4 * t)
        return [
            box((thick, 2 * _INK_M, (b - a) * h), (0.5 * t, 0.0, 0.5 * (a + b) * h)).transformed(
                self.pose
            )
            for a, b in places
        ]

    def pages(self) -> Mesh:
        """The block of paper between the boards, a little smaller than they are."""
        t, d, h = self.size
        size = (t - 2 * COVER + 0.0004, d - 0.012, h - 0.008)
        block = box(size, (0.5 * t, 0.5 * d + 0.003, 0.5 * h))
        return block.transformed(self.pose)


def _leaning(x: float, y: float, z: float, tilt: float) -> Array:
    """Turned about the depth axis so that its top comes to the left."""
    return pose(about_y(-tilt), (x, y, z))


def _lying(x: float, y: float, z: float) -> Array:
    """On its side, the spine still to the front: height runs along X, thickness upwards."""
    return pose([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]], (x, y, z))


@dataclass
class Shelf:
    """A compartment being filled from the left.

    Attributes:
        low: Its least corner, metres: left, front edge, upper side of its board.
        size: Its free width, depth and height, metres.
    """

    low: tuple[float, float, float]
    size: tuple[float, float, float]

    def filled(self, rng: np.random.Generator, fullness: float) -> list[Book]:
        """Books for about ``fullness`` of its width."""
        books: list[Book] = []
        x = float(rng.uniform(0.0, 0.02))
        while x < self.size[0] - 0.03:
            kind = rng.uniform()
            if kind > fullness:
                x += float(rng.uniform(0.03, 0.16))
                continue
            group = list(self._pile(x, rng) if kind > 0.86 * fullness else self._run(x, rng))
            if not group:
                break
            books += group
            right = max(float(book.cover().extent[1, 0]) for book in group)
            x = right - self.low[0] + float(rng.uniform(0.002, 0.012))
        return books

    def _drawn(self, rng: np.random.Generator, tall: float) -> tuple[float, float, float]:
        thickness = float(np.clip(rng.lognormal(np.log(0.027), 0.4), 0.012, 0.062))
        height = min(tall * float(rng.uniform(0.86, 1.0)), self.size[2] - 0.012)
        depth = min(float(rng.uniform(0.64, 0.78)) * height, self.size[1] - 0.012)
        return thickness, depth, height

    def _place(self, depth: float, rng: np.random.Generator) -> float:
        """How far the spine stands behind the front edge of the shelf."""
        free = self.size[1] - depth - 0.006
        return self.low[1] + min(free, float(rng.uniform(0.006, 0.03)))

    def _run(self, x: float, rng: np.random.Generator) -> Iterator[Book]:
        """Books of like height side by side, the last one sometimes leaning on the others."""
        tall = float(rng.uniform(0.19, 0.31))
        count = int(rng.integers(4, 12))
        series = int(rng.integers(BINDINGS)) if rng.uniform() < 0.25 else None
        left, _, base = self.low
        height = 0.0
        for i in range(count):
            size = self._drawn(rng, tall)
            binding = int(rng.integers(BINDINGS)) if series is None else series
            y = self._place(size[1], rng)
            tilt = float(rng.uniform(0.1, 0.28))
            if i == count - 1 and i > 0 and rng.uniform() < 0.7:
                size = (size[0], size[1], min(size[2], height))
                foot = size[2] * np.sin(tilt)
                if x + foot + size[0] > self.size[0]:
                    return
                if size[2] * np.cos(tilt) + size[0] * np.sin(tilt) < self.size[2] - 0.004:
                    yield Book(size, binding, _leaning(left + x + foot, y, base, tilt))
                return
            if x + size[0] > self.size[0]:
                return
            yield Book(size, binding, pose(np.eye(3), (left + x, y, base)))
            x += size[0] + 0.0006
            height = size[2]

    def _pile(self, x: float, rng: np.random.Generator) -> Iterator[Book]:
        """A few books on top of each other, larger ones below."""
        left, _, base = self.low
        long = float(rng.uniform(0.22, 0.3))
        z = 0.0
        for _ in range(int(rng.integers(2, 6))):
            thickness, depth, _ = self._drawn(rng, long)
            depth = min(0.72 * long, self.size[1] - 0.012)
            if x + long > self.size[0] or z + thickness > self.size[2] - 0.01:
                return
            y = self._place(depth, rng)
            pose = _lying(left + x, y, base + z)
            yield Book((thickness, depth, long), int(rng.integers(BINDINGS)), pose)
            z += thickness + 0.0004
            long *= float(rng.uniform(0.88, 0.99))


def bound(books: list[Book]) -> tuple[list[Mesh], list[Mesh], list[Mesh]]:
    """Books as meshes.

    Returns:
        The covers, one mesh for each binding in use; the pages of all in one mesh, if any; what is
        printed on spines, in one mesh for dark and one for light print, if any.
    """
    used = sorted({book.binding for book in books})
    covers = [joined([b.cover() for b in books if b.binding == binding]) for binding in used]
    pages = [joined([book.pages() for book in books])] if books else []
    inks = [
        [band for book in books if book.binding % 2 == ink for band in book.bands()]
        for ink in (0, 1)
    ]
    return covers, pages, [joined(bands) for bands in inks if bands]
