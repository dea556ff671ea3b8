"""What is printed on things, by rules: covers of books, fronts of boxes, labels, pages.

Colours lie on their ground as sheets of a third of a millimetre, as in `wall_board`. All is drawn
in the plane z = 0, seen from above, its lower left corner in the origin.
"""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from openrooms_usd.furniture.joinery.pieces import Parts, numbered
from openrooms_usd.geometry.mesh import Mesh, joined
from openrooms_usd.geometry.solids import box, cylinder

# How far a print stands out, and how deep it reaches into its ground, metres.
_PROUD: Final = 0.00025
_SUNK: Final = 0.0006


@dataclass
class Print:
    """Sheets of colour on a rectangle.

    Attributes:
        size: Width and height, metres.
        fields: Areas of colours of their own.
        titles: Bars in the place of large letters.
        lines: Bars in the place of lines of small letters.
    """

    size: tuple[float, float]
    fields: list[Mesh] = field(default_factory=list)
    titles: list[Mesh] = field(default_factory=list)
    lines: list[Mesh] = field(default_factory=list)

    def bar(self, low: tuple[float, float], high: tuple[float, float], level: int = 0) -> Mesh:
        """A rectangle between two corners in shares of the print; higher levels lie above."""
        w, h = self.size
        proud = _PROUD * (1 + level)
        size = ((high[0] - low[0]) * w, (high[1] - low[1]) * h, proud + _SUNK)
        middle = (0.5 * (low[0] + high[0]) * w, 0.5 * (low[1] + high[1]) * h)
        return box(size, (*middle, 0.5 * (proud - _SUNK)))

    def disc(self, at: tuple[float, float], radius: float, level: int = 0) -> Mesh:
        """A disc about a point in shares of the print, its radius in shares of the lesser side."""
        w, h = self.size
        return cylinder(
            radius * min(w, h),
            _PROUD * (1 + level) + _SUNK,
            segments=20,
            base=(at[0] * w, at[1] * h, -_SUNK),
        )

    def parts(self, matrix: np.ndarray) -> Parts:
        """The print as parts, brought to where it belongs by a (4, 4) matrix."""
        placed = numbered("field", [mesh.transformed(matrix) for mesh in self.fields])
        for name, meshes in (("title", self.titles), ("text", self.lines)):
            if meshes:
                placed[name] = joined(meshes).transformed(matrix)
        return placed


def _words(
    page: Print,
    low: float,
    high: float,
    y: float,
    tall: float,
    rng: np.random.Generator,
    level: int,
) -> list[Mesh]:
    """A line of words between two shares of the width, as bars with gaps."""
    found, x = [], low
    while x < high - 0.03:
        end = min(high, x + float(rng.uniform(0.06, 0.2)))
        found.append(page.bar((x, y), (end, y + tall), level))
        x = end + 0.03
    return found


def label_lines(
    page: Print,
    span: tuple[float, float, float, float],
    count: int,
    rng: np.random.Generator,
    level: int = 0,
) -> list[Mesh]:
    """Lines of small letters in a part of the print: left, right, low, high, in shares."""
    left, right, low, high = span
    step = (high - low) / count
    ends = rng.uniform(0.75, 1.0, count)
    ends[-1] = 0.5
    return [
        page.bar(
            (left, high - (i + 0.7) * step),
            (left + (right - left) * float(ends[i]), high - (i + 0.3) * step),
            level,
        )
        for i in range(count)
    ]


def printed_cover(width: float, height: float, rng: np.random.Generator) -> Print:
    """A cover: a title, an image of a few shapes, the name of its maker."""
    page = Print((width, height))
    kind = int(rng.integers(4))
    if kind == 0:  # a band across, the title in it
        y = float(rng.uniform(0.45, 0.65))
        page.fields.append(page.bar((0.0, y), (1.0, y + 0.24)))
        page.titles += _words(page, 0.12, 0.88, y + 0.09, 0.07, rng, 1)
    elif kind == 1:  # discs over a low field
        page.fields.append(page.bar((0.0, 0.0), (1.0, 0.42)))
        x = float(rng.uniform(0.35, 0.65))
        page.fields.append(page.disc((x, 0.42), 0.26, 1))
        page.titles += _words(page, 0.1, 0.9, 0.8, 0.08, rng, 0)
    elif kind == 2:  # a picture in a margin
        page.fields.append(page.bar((0.1, 0.12), (0.9, 0.62)))
        page.fields.append(page.bar((0.1, 0.12), (0.9, 0.12 + float(rng.uniform(0.15, 0.3))), 1))
        page.titles += _words(page, 0.1, 0.9, 0.8, 0.07, rng, 0)
        page.titles += _words(page, 0.1, 0.6, 0.69, 0.05, rng, 0)
    else:  # stripes
        edges = np.sort(rng.uniform(0.05, 0.6, 4))
        page.fields.append(page.bar((0.0, float(edges[0])), (1.0, float(edges[1]) + 0.03)))
        page.fields.append(page.bar((0.0, float(edges[2]) + 0.05), (1.0, float(edges[3]) + 0.09)))
        page.titles += _words(page, 0.12, 0.88, 0.78, 0.1, rng, 0)
    page.lines += _words(page, 0.3, 0.7, 0.05, 0.02, rng, 1)
    return page
