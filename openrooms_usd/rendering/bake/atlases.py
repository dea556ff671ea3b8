"""Every unit laid out in texels, and placed in one of a few pictures."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from openrooms_usd.errors import InputError
from openrooms_usd.geometry.unwrap import Layout, laid_out, shelved
from openrooms_usd.rendering.bake.units import Unit

PADDING_TEXELS: Final = 2
"""Kept free between charts, so that each has a border of its own for bilinear look-ups."""

# How often the texels are made larger until all of them fit.
_TRIES: Final = 8
_MARGIN: Final = 1.02


@dataclass(frozen=True, eq=False)
class Placement:
    """A unit's rectangle in an atlas.

    Attributes:
        unit: What it shows.
        layout: The unit's triangles in its rectangle: those of its members that are lit, in order.
        atlas: Number of the picture.
        corner: Of the rectangle, texels from the lower left of the picture.
    """

    unit: Unit
    layout: Layout
    atlas: int
    corner: tuple[int, int]


@dataclass(frozen=True, eq=False)
class Atlases:
    """All units in pictures.

    Attributes:
        placements: Of each unit.
        sizes: Width and height of each picture, texels.
        texel_m: Side of a texel on the surfaces, metres: what was asked for, or more.
    """

    placements: tuple[Placement, ...]
    sizes: tuple[tuple[int, int], ...]
    texel_m: float

    @property
    def texels(self) -> int:
        """Of all pictures."""
        return sum(width * height for width, height in self.sizes)


def placed(units: Sequence[Unit], *, texel_m: float, side: int, most: int) -> Atlases:
    """Lay out units and place them; texels grow until they are few enough.

    Args:
        units: What shall be placed.
        texel_m: Side of a texel on the surfaces, metres.
        side: Of a picture at most, texels.
        most: Texels of all pictures together at most.

    Raises:
        InputError: However large texels are, there are too many.
        MissingPackageError: xatlas is not installed.
    """
    for _ in range(_TRIES):
        layouts = _layouts(units, texel_m)
        sizes = np.array([layouts[unit.prototype].size for unit in units], np.int64).reshape(-1, 2)
        too_wide = float(sizes.max(initial=0)) / side
        too_many = float(sizes.prod(axis=1).sum()) / most
        if max(too_wide, too_many) <= 1.0:
            found = _pages(units, layouts, sizes, side, texel_m)
            if found.texels <= most:
                return found
            too_many = found.texels / most
        texel_m *= _MARGIN * max(1.0, too_wide, too_many**0.5)
    raise InputError(
        f"{len(units)} surfaces do not fit into {most:,} texels",
        place="lightmaps",
        remedy="allow more texels",
    )


def _layouts(units: Sequence[Unit], texel_m: float) -> dict[str, Layout]:
    """By prototype, as large as its first instance is."""
    found: dict[str, Layout] = {}
    for unit in units:
        if unit.prototype in found:
            continue
        points, triangles, faces = [], [], []
        rows = polygons = 0
        for member in unit.members:
            own = member.mesh.mesh
            points.append(member.mesh.world_points())
            triangles.append(own.triangles[member.lit] + rows)
            faces.append(own.faces[member.lit] + polygons)
            rows, polygons = rows + len(own.points), polygons + int(own.faces.max()) + 1
        found[unit.prototype] = laid_out(
            np.concatenate(points),
            np.concatenate(triangles),
            np.concatenate(faces),
            texels_per_metre=1.0 / texel_m,
            padding=PADDING_TEXELS,
        )
    return found


def _pages(
    units: Sequence[Unit], layouts: dict[str, Layout], sizes: np.ndarray, side: int, texel_m: float
) -> Atlases:
    """Units into pictures of bounded size, each as full as shelves are."""
    area = int(sizes.prod(axis=1).sum())
    width = max(min(side, int(1.05 * area**0.5) + 1), int(sizes[:, 0].max(initial=1)))
    left = np.arange(len(units))
    where: dict[int, tuple[int, tuple[int, int]]] = {}
    pages: list[tuple[int, int]] = []
    while len(left):
        corners, _ = shelved(sizes[left], width)
        ends = corners[:, 1] + sizes[left, 1]
        fits = ends <= side
        for row, corner in zip(left[fits].tolist(), corners[fits].tolist(), strict=True):
            where[row] = len(pages), (corner[0], corner[1])
        right = corners[fits, 0] + sizes[left[fits], 0]
        pages.append((int(right.max()), int(ends[fits].max())))
        left = left[~fits]
    placements = (
        Placement(unit, layouts[unit.prototype], *where[row]) for row, unit in enumerate(units)
    )
    return Atlases(tuple(placements), tuple(pages), texel_m)
