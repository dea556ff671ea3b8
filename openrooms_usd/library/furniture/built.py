"""The record of a category that the library builds: what its builders and the generator know."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

from openrooms_usd.categories.record import Category, Support, Without
from openrooms_usd.library.furniture.joinery import Size, Style
from openrooms_usd.library.furniture.lying import Lies, Place

Spread: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class BuiltCategory(Category):
    """What the library knows of a category that it builds.

    Attributes:
        description: One sentence for people.
        size: Its usual width, depth and height, metres.
        least: Below these sides it is not built but shrunk, metres.
        most: Above these sides it is not built but stretched, metres.
        styles: The ways to build it.
        spread: How much its width, depth and height vary about the usual ones, as shares.
        round: Whether it is as deep as it is wide, where its usual size is.
        alike: Whether a room has one make of it: people buy them together, and assets are shared.
        support: What carries it where nobody says.
        level: Height of its base above the floor where it hangs on a wall, metres.
        lumen: The luminous flux of its part ``light_bulb``, where nobody says.
        weighs: Kilograms of products of such sizes, lightest and heaviest, as their makers ship
            them; by style where one is another kind of thing, ``ANY`` for the others. Chairs are of
            wood or with thin cushions, a wing chair has a beech frame; a bed is with its mattress
            (30 to 40 kg) and bedding, shelves are with their books (a metre of books has 20 to
            25 kg); storage of 16 mm boards has 10 to 13 kg for each square metre of front; a
            cabinet of files is of sheet steel; an oven has 25 to 40 kg for each cavity; a slate bed
            alone is 200 kg; a pot is with soil.
        worktop: On how many of a kitchen's counters it stands, as a share.
        lies: Where it lies about when people live in a room; by default nowhere: it stands where
            groups of furniture have it.
        carries: What people use its surfaces for: its top, its boards, its seat. By default
            nothing lies on it.
    """

    description: str
    size: Size
    least: Size
    most: Size
    styles: Mapping[str, Style]
    spread: Spread
    round: bool
    alike: bool
    support: Support
    level: float | Without
    lumen: float | Without
    weighs: Mapping[str, tuple[float, float]] | Without
    worktop: float | Without
    lies: tuple[Lies, ...] = ()
    carries: tuple[Place, ...] = ()

    @property
    def emits(self) -> bool:
        """Whether it is a lamp."""
        return not isinstance(self.lumen, Without)


USUAL: Final[Spread] = (0.1, 0.06, 0.04)
STANDARD: Final[Spread] = (0.0, 0.0, 0.0)
"""Of what is made to fit a standard, or the hand."""
WIDE: Final[Spread] = (0.3, 0.25, 0.25)
MADE_TO_MEASURE: Final[Spread] = (0.2, 0.1, 0.1)

# What many categories are without.
HANGS_NOT: Final = Without("it hangs on no wall")
NO_LAMP: Final = Without("it gives no light")
NEVER_WEIGHED: Final = Without("it is built in, and nobody weighs it as one thing")
NO_APPLIANCE: Final = Without("it is no appliance that stands ready on worktops")
