"""The record of a category: what every part of the program asks about it, said once.

A record says only what is special about its category; everything else has a default. It is written
in the words of `construction`, `placements` and `schemes`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal, NamedTuple, TypeAlias

from openrooms_usd.furniture.construction import Row
from openrooms_usd.furniture.joinery.pieces import Size, Style
from openrooms_usd.furniture.placements import Place, SurfacePlacement
from openrooms_usd.furniture.schemes import Scheme

Support = Literal["floor", "ceiling", "surface", "wall"]
UNLABELED: Final = "unlabeled"

# Limits that follow from the usual size.
_BY_SIZE: Final[Size] = (0.0, 0.0, 0.0)
Variation: TypeAlias = tuple[float, float, float]
USUAL: Final[Variation] = (0.1, 0.06, 0.04)
STANDARD: Final[Variation] = (0.0, 0.0, 0.0)
"""Of what is made to fit a standard, or the hand."""
WIDE: Final[Variation] = (0.3, 0.25, 0.25)
MADE_TO_MEASURE: Final[Variation] = (0.2, 0.1, 0.1)


class Classes(NamedTuple):
    """What a category is in the class lists of others; ``UNLABELED`` where one has none for it."""

    openrooms45: str = UNLABELED
    nyu40: str = "otherprop"
    ade20k: str = UNLABELED
    coco: str = UNLABELED


@dataclass(frozen=True)
class JointDamping:
    """What resists a joint's movement.

    Attributes:
        damping: N m s/rad of hinges, N s/m of rails.
        friction: N m or N that it takes to move it at all.
    """

    damping: float
    friction: float


@dataclass(frozen=True, kw_only=True)
class Category:
    """What a word means, whether or not the library can build it.

    Attributes:
        support: Default support: the floor, the ceiling, a wall, or the top of another object.
            None: unknown before it is seen.
        alternative_supports: What may carry it besides. What both stands and hangs is looked at in
            a scan; what only stands hangs nowhere, wherever it was measured.
        fixed: Whether it is built in, plumbed in, or part of the building, wherever it stands.
        words: Other words for it in captures, in plain form and apart by blanks: of RoomPlan, NYU40
            and SUN RGB-D, ScanNet's raw names, ShapeNet's synsets.
        classes: Its class in the lists of OpenRooms, NYU Depth V2, ADE20K and COCO.
        synsets: WordNet 3.0 offsets of the synsets that ShapeNetCore files it under.
        schemes: Which finishes its parts usually have, one of which is drawn; by default those of
            such parts of anything.
        construction: How its parts are made; the first row that fits counts, then those of
            anything.
        joint_damping: What resists its hinges; None for that of a cupboard's door.
        collision_softness: How far its collision shapes may be off because it gives way where it
            is touched, metres.
        lies_under: Whether it is a layer, such as a rug, that gives way below what has the same
            support.
        view_importance: How much a whole one is worth in a picture of a room, out of 5; None where
            its size decides.
    """

    support: Support | None = None
    alternative_supports: tuple[Support, ...] = ()
    fixed: bool = False
    words: str = ""
    classes: Classes = field(default_factory=Classes)
    synsets: tuple[str, ...] = ()
    schemes: tuple[Scheme, ...] = ()
    construction: tuple[Row, ...] = ()
    joint_damping: JointDamping | None = None
    collision_softness: float = 0.0
    lies_under: bool = False
    view_importance: float | None = None


@dataclass(frozen=True, kw_only=True)
class BuiltCategory(Category):
    """What the library knows of a category that it builds.

    Attributes:
        description: One sentence for people.
        size: Its usual width, depth and height, metres.
        styles: The ways to build it.
        min_size: Below these sides it is not built but shrunk, metres; by default half its size.
        max_size: Above these sides it is not built but stretched, metres; by default twice it.
        size_variation: How much its width, depth and height vary about the usual ones, as shares.
        round: Whether it is as deep as it is wide, where its usual size is.
        one_variant_per_room: Whether a room has one make of it: people buy them together, and
            assets are shared.
        max_per_room: How many a room has, those of groups of furniture among them, before no more
            are laid or hung; None: any number.
        support: Default support.
        mount_height: Height of its base above the floor where it hangs on a wall, metres.
        lumen: Default luminous flux of its part ``light_bulb``; 0: it is not a lamp.
        mass_range: Kilograms of products of such sizes, lightest and heaviest, as their makers ship
            them; styles that are another kind of thing have their own. None where it is built in
            and never weighed. Chairs are of wood or with thin cushions, a wing chair has a beech
            frame. A bed includes its mattress (30 to 40 kg) and bedding, shelves include their
            books (a metre of books has 20 to 25 kg). Storage of 16 mm boards has 10 to 13 kg for
            each square metre of front. A cabinet of files is of sheet steel. An oven has 25 to 40
            kg for each cavity. A slate bed alone is 200 kg. A pot includes soil.
        on_worktop_probability: On how many of a kitchen's counters it stands, as a share.
        placements: Where it lies about when people live in a room; by default nowhere: it stands
            where groups of furniture have it.
        offers_surfaces: What people use its surfaces for: its top, its boards, its seat. By default
            nothing lies on it.
    """

    description: str
    size: Size
    styles: Mapping[str, Style]
    min_size: Size = _BY_SIZE
    max_size: Size = _BY_SIZE
    size_variation: Variation = USUAL
    round: bool = False
    one_variant_per_room: bool = False
    max_per_room: int | None = None
    support: Support = "floor"
    mount_height: float = 0.0
    lumen: float = 0.0
    mass_range: tuple[float, float] | None = None
    on_worktop_probability: float = 0.0
    placements: tuple[SurfacePlacement, ...] = ()
    offers_surfaces: tuple[Place, ...] = ()

    def __post_init__(self) -> None:
        width, depth, height = self.size
        for key, share in (("min_size", 0.5), ("max_size", 2.0)):
            if getattr(self, key) == _BY_SIZE:
                object.__setattr__(self, key, (share * width, share * depth, share * height))

    @property
    def emits(self) -> bool:
        """Whether it is a lamp."""
        return self.lumen > 0.0

    def mass_range_of(self, style: str) -> tuple[float, float] | None:
        """Kilograms of products of one style, lightest and heaviest; None: never weighed."""
        return self.styles[style].mass_range or self.mass_range
