"""Small things of a room: what may lie where by the records, and which variants a room has."""

from dataclasses import dataclass, field
from functools import cache

import numpy as np

from openrooms_usd.furniture import CATEGORIES, Size, category
from openrooms_usd.furniture.placements import Place, SurfacePlacement
from openrooms_usd.furniture.registry import BUILT
from openrooms_usd.generation.sizes import drawn_size
from openrooms_usd.library.styles.assignment.weights import drawn

Variant = tuple[Size, str]


@cache
def candidates(
    place: Place, room_type: str, clutter: int
) -> tuple[tuple[str, SurfacePlacement], ...]:
    """All that may lie at a place, with the row of its record that says so."""
    return tuple(
        (name, placement)
        for name in BUILT
        for placement in CATEGORIES[name].placements
        if place in placement.on
        and placement.clutter <= clutter
        and (not placement.rooms or room_type in placement.rooms)
    )


@dataclass
class ProductVariants:
    """The product variants of small things that a room has.

    Attributes:
        rng: Draws them.
    """

    rng: np.random.Generator
    _known: dict[tuple[str, tuple[str, ...]], list[Variant]] = field(default_factory=dict)

    def draw(
        self, name: str, placement: SurfacePlacement, most: Size | None = None
    ) -> Variant | None:
        """A variant of a category: one that the room has, or a new one while there are few.

        Args:
            name: The category.
            placement: What its record says of the place.
            most: Width, depth and height that it must fit in, metres.

        Returns:
            None where nothing of it fits.
        """
        spec = category(name)
        wanted = placement.styles or tuple(spec.styles)
        made = self._known.setdefault((name, wanted), [])
        limit = 1 if spec.one_variant_per_room else placement.max_variants
        fitting = [make for make in made if most is None or _fits(make[0], most)]
        if len(made) < limit and (not fitting or self.rng.random() > len(made) / limit):
            style = drawn(self.rng, {style: spec.styles[style].weight for style in wanted})
            usual = spec.styles[style].size or spec.size
            size = drawn_size(self.rng, name, usual, (None, None, None), 0.0)
            if spec.styles[style].suits(size) and (most is None or _fits(size, most)):
                made.append((size, style))
                return size, style
        return fitting[int(self.rng.integers(len(fitting)))] if fitting else None


def _fits(size: Size, most: Size) -> bool:
    """Whether it fits in, perhaps turned by a right angle."""
    width, depth, height = size
    room = sorted(most[:2])
    return height <= most[2] and min(width, depth) <= room[0] and max(width, depth) <= room[1]
