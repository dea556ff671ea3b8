"""The record of a category: what every part of the program asks about it, said once."""

from dataclasses import dataclass
from typing import Final, Literal, NamedTuple, TypeVar

from openrooms_usd.categories.makes import Row
from openrooms_usd.categories.schemes import Scheme

_T = TypeVar("_T")

Support = Literal["floor", "ceiling", "surface", "wall"]
UNLABELED: Final = "unlabeled"


@dataclass(frozen=True)
class Without:
    """What a record says in place of what its category has not, and why it has not."""

    reason: str


def given(said: _T | Without, usual: _T) -> _T:
    """What a record says; what is usual where its category has nothing of its own."""
    return usual if isinstance(said, Without) else said


class Classes(NamedTuple):
    """What a category is in the class lists of others; ``UNLABELED`` where one has none for it."""

    openrooms45: str
    nyu40: str
    ade20k: str
    coco: str


@dataclass(frozen=True)
class Losses:
    """What resists a joint's movement.

    Attributes:
        damping: N m s/rad of hinges, N s/m of rails.
        friction: N m or N that it takes to move it at all.
    """

    damping: float
    friction: float


@dataclass(frozen=True, kw_only=True)
class Category:
    """What a word means, whether or not the library can build it; nothing is left unsaid.

    Attributes:
        support: What carries it where nobody says: the floor, the ceiling, a wall, or the top of
            another object.
        also: What may carry it besides. What both stands and hangs is looked at in a scan; what
            only stands hangs nowhere, wherever it was measured.
        fixed: Whether it is built in, plumbed in, or part of the building, wherever it stands.
        words: Other words for it in captures, in plain form and apart by blanks: of RoomPlan, NYU40
            and SUN RGB-D, ScanNet's raw names, ShapeNet's synsets.
        classes: Its class in the lists of OpenRooms, NYU Depth V2, ADE20K and COCO.
        synsets: WordNet 3.0 offsets of the synsets that ShapeNetCore files it under.
        schemes: Which finishes its parts usually have, one of which is drawn.
        makes: How its parts are made; the first row that fits counts.
        hinges: What resists its hinges.
        yields: How far its collision shapes may be off because it gives way where it is touched,
            metres.
        photographed: How much a whole one is worth in a picture of a room, out of 5; None where
            its size decides.
    """

    support: Support | Without
    also: tuple[Support, ...]
    fixed: bool
    words: str | Without
    classes: Classes
    synsets: tuple[str, ...] | Without
    schemes: tuple[Scheme, ...] | Without
    makes: tuple[Row, ...] | Without
    hinges: Losses | Without
    yields: float | Without
    photographed: float | None = None


# What many categories are without.
NO_WORDS: Final = Without("captures call it by its own name")
BY_PARTS: Final = Without("its parts have the finishes of such parts")
NO_SYNSET: Final = Without("ShapeNetCore has no such models")
NO_ROWS: Final = Without("its parts are made as those of anything")
PLAIN_HINGES: Final = Without("what turns, if anything, turns as the door of a cupboard does")
RIGID: Final = Without("it does not give way")
