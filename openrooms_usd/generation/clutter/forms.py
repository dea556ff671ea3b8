"""The forms of a room's things, each looked at once: shapes, levels, upper sides."""

from dataclasses import dataclass

from openrooms_usd.furniture import Size
from openrooms_usd.furniture.joinery.pieces import FitOptions
from openrooms_usd.generation.clutter.levels import Level, levels_of
from openrooms_usd.generation.clutter.resting import Relief, relief_of
from openrooms_usd.generation.items import Item
from openrooms_usd.generation.shapes import BuiltForm, Shapes


@dataclass
class LevelFinder:
    """Finds the levels of each distinct object once.

    Attributes:
        shapes: The real form of objects.
    """

    shapes: Shapes

    def __post_init__(self) -> None:
        self._known: dict[tuple[str, Size, str, FitOptions], tuple[Level, ...]] = {}
        self._reliefs: dict[tuple[str, Size, str, FitOptions], Relief] = {}

    def shape(self, item: Item) -> BuiltForm:
        """The form of an item."""
        return self.shapes.of(item.category, item.size, item.style, item.order)

    def levels(self, item: Item) -> tuple[Level, ...]:
        """The levels of an item, the lowest first."""
        key = (item.category, item.size, item.style, item.order)
        if key not in self._known:
            self._known[key] = levels_of(self.shape(item))
        return self._known[key]

    def relief(self, item: Item) -> Relief:
        """The upper side of an item."""
        key = (item.category, item.size, item.style, item.order)
        if key not in self._reliefs:
            self._reliefs[key] = relief_of(self.shape(item))
        return self._reliefs[key]
