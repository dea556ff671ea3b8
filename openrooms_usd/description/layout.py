"""The ``layout`` section: the room's shell and what is cut into it."""

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Final, Literal, get_args

from pydantic import AfterValidator, Field, Tag

from openrooms_usd.description.generate import GeneratedLayout
from openrooms_usd.description.model import (
    CheckedModel,
    FoundMistake,
    Model,
    Number,
    PrimName,
    Whole,
    by_source,
    peek,
    peek_list,
    peek_text,
)
from openrooms_usd.description.naming import repeated_names, unique_names
from openrooms_usd.description.polygon import simple_polygon
from openrooms_usd.description.scanned import CapturedSection, ImportedSection
from openrooms_usd.description.trim import AnyCeiling, Ceiling, Cladding, Trim
from openrooms_usd.description.units import Angle, Length, PositiveLength
from openrooms_usd.names import PARTITION_THICKNESS, ROOM_HEIGHT

Point2 = Annotated[tuple[Length, Length], Field(description="x and y, metres")]


DoorStyle = Literal["panelled", "flush", "glazed"]
WindowStyle = Literal["casement", "grid", "sliding", "fixed"]
# Width, height and sill of openings of which the description gives none, metres.
USUAL_OPENINGS: Final = {
    "window": (1.2, 1.3, 0.9),
    "door": (0.9, 2.05, 0.0),
    "opening": (0.9, 2.05, 0.0),
}
STYLES: Final = {"door": get_args(DoorStyle), "window": get_args(WindowStyle)}


# What is said of a leaf that is shut, and built as leaves are where nothing is said.
_OF_LEAVES: Final = (None, 0, "left", "in")


class Partition(Model):
    """A wall that stands free in the room."""

    name: PrimName | None = None
    """Its prim name; by default partition and a number, such as partition_0."""
    line: tuple[Point2, Point2]
    """Both ends of its centre line. At walls, and where partitions meet, gaps of up to 15 cm are
    closed."""
    thickness: PositiveLength = Field(default=PARTITION_THICKNESS, ge=0.01, le=2)
    """Half of it to each side of the line."""
    height: PositiveLength | None = Field(default=None, ge=0.1, le=100)
    """By default up to the ceiling."""


class Opening(CheckedModel):
    """A window, a door or an open passage in one wall."""

    kind: Literal["window", "door", "opening"]
    """A door has a leaf, a window a frame with sashes, an opening has neither."""
    name: PrimName | None = None
    """Its prim name; by default its kind and a number, such as window_0."""
    wall: Whole | None = Field(default=None, ge=0)
    """The wall's number: wall i runs from corner i to corner i + 1."""
    partition: PrimName | None = None
    """In place of a wall: the name of the partition that it is cut into."""
    at: Length | None = None
    """Distance from the wall's start to the centre of the opening; the wall's centre by default."""
    width: PositiveLength | None = None
    """Default 1.2 m for windows, 0.9 m otherwise."""
    height: PositiveLength | None = None
    """Default 1.3 m for windows, 2.05 m otherwise."""
    sill: Length | None = Field(default=None, ge=0)
    """Height of the lower edge above the floor; default 0.9 m for windows, 0 otherwise."""
    open: Angle = Field(default=0.0, ge=0, le=180)
    """Opening angle of a door's leaf."""
    hinge: Literal["left", "right"] = "left"
    """The hinge side of a door, seen from inside the room; at a partition, seen from the side from
    which its line runs to the right."""
    swing: Literal["in", "out"] = "in"
    """Whether a door's leaf swings into the room or out of it; at a partition, to the side from
    which its line runs to the right, or to the other."""
    style: DoorStyle | WindowStyle | None = None
    """How it is built: by default doors are panelled and windows have casements."""

    beyond: Literal["outside", "hallway"] = "outside"
    """What lies behind it; a hallway is built if the opening is transparent or open."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """A style that belongs to another kind of opening; no wall, or two."""
        places = sum(peek(given, key) is not None for key in ("wall", "partition"))
        if places == 0:
            yield FoundMistake(
                (), "the key 'wall' is missing: the number of the wall that it is in"
            )
        elif places == 2:
            yield FoundMistake(
                ("partition",), "an opening is in a wall or in a partition, not in both"
            )
        kind, style = peek_text(given, "kind"), peek_text(given, "style")
        for key in ("open", "hinge", "swing"):
            if kind in ("window", "opening") and peek(given, key) not in _OF_LEAVES:
                what = "a window has no leaf" if kind == "window" else "an opening has no leaf"
                yield FoundMistake((key,), f"{what}; omit {key}, or make it a door")
        known = STYLES.get(kind or "", ())
        if style in {name for names in STYLES.values() for name in names} - {*known}:
            what = "an opening has no style" if not known else f"no {kind} is {style!r}"
            yield FoundMistake(
                ("style",), what + (f"; a {kind} is {_either(known)}" if known else "")
            )


class PolygonLayout(CheckedModel):
    """A room drawn by hand: a simple polygon, also concave and at any angle."""

    source: Literal["polygon"] = Field(default="polygon", alias="from")
    polygon: Annotated[tuple[Point2, ...], AfterValidator(simple_polygon)] = Field(
        default=((0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0)), min_length=3, max_length=10_000
    )
    """Inner corners in order, clockwise or not; the first is not repeated at the end."""
    height: PositiveLength = Field(default=ROOM_HEIGHT, ge=0.5, le=100)
    """Floor to ceiling."""
    wall_thickness: PositiveLength = Field(default=0.2, ge=0.01, le=2)
    """Thickness of the walls, outwards from the polygon."""
    partitions: tuple[Partition, ...] = ()
    """Inner walls."""
    openings: tuple[Opening, ...] = ()
    """Windows, doors and passages."""
    trim: Trim = Field(default_factory=Trim)
    """Skirting, cornices, casings and the like; by default none."""
    ceiling: AnyCeiling = Field(default_factory=Ceiling)
    """Beams or grids below the ceiling: a kind, or a mapping; by default none."""
    cladding: tuple[Cladding, ...] = ()
    """Tiles or boards on parts of the walls."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Names that repeat, and openings in walls that the room does not have."""
        openings, partitions = (peek_list(given, key) for key in ("openings", "partitions"))
        yield from _name_clashes(openings, partitions)
        claddings = peek_list(given, "cladding")
        yield from repeated_names([peek_text(c, "name") for c in claddings], "cladding", "cladding")
        whole = peek(given, "polygon") is None
        walls = len(cls.model_fields["polygon"].default if whole else peek_list(given, "polygon"))
        yield from _nowhere(given, walls)


class CapturedLayout(CapturedSection):
    """The shell of a captured room."""

    polygon: Annotated[tuple[Point2, ...], AfterValidator(simple_polygon)] | None = Field(
        default=None, min_length=3, max_length=10_000
    )
    """Drawn inner corners that replace the captured floor, in the frame of the composed room. Only
    the listed `openings` and `partitions` exist then."""
    wall_thickness: PositiveLength = Field(default=0.2, ge=0.01, le=2)
    """Thickness of the walls, outwards from the captured surfaces."""
    height: PositiveLength | None = Field(default=None, ge=0.5, le=100)
    """Floor to ceiling; by default as captured."""
    partitions: tuple[Partition, ...] = ()
    """Further inner walls beside the captured ones."""
    openings: tuple[Opening, ...] = ()
    """Further windows and doors beside the captured ones."""
    trim: Trim = Field(default_factory=Trim)
    """Skirting, cornices, casings and the like; by default none."""
    ceiling: AnyCeiling = Field(default_factory=Ceiling)
    """Beams or grids below the ceiling: a kind, or a mapping; by default none."""
    cladding: tuple[Cladding, ...] = ()
    """Tiles or boards on parts of the walls."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Names that repeat, and of drawn rooms openings in walls that they do not have."""
        yield from _name_clashes(*(peek_list(given, key) for key in ("openings", "partitions")))
        if peek(given, "polygon") is not None:
            yield from _nowhere(given, len(peek_list(given, "polygon")))


class RoomPlanLayout(CapturedLayout):
    """A room scanned with Apple RoomPlan."""

    source: Literal["roomplan"] = Field(alias="from")


class Scan2CadLayout(CapturedLayout):
    """The room of a Scan2CAD annotation: a polygon beside a ScanNet scan."""

    source: Literal["scan2cad"] = Field(alias="from")


class BoxesLayout(CapturedLayout):
    """The room around a plain list of boxes."""

    source: Literal["boxes"] = Field(alias="from")


Direction = Annotated[tuple[Number, Number, Number], Field(description="x, y and z")]


class ScanLayout(CapturedLayout):
    """A room that is found in a point cloud or a mesh."""

    source: Literal["scan"] = Field(alias="from")
    file: str = Field(alias="scan", min_length=1)
    """The scan, relative to this description."""
    importer: str = Field(default="scan", min_length=1)
    """Its importer: `scan` for PLY, PCD, OBJ, GLB, LAS, E57 and the like, or another importer of
    points, as `orusd import --help` lists them."""
    unit: Literal["auto", "m", "dm", "cm", "mm", "in", "ft", "km"] | PositiveLength = "auto"
    """The unit of the coordinates, or its length. `auto` assumes metres unless the scan shows
    otherwise, and reports it."""
    up: Direction | None = None
    """Approximate up direction in the scan's frame; by default that of the file format, unless the
    scan shows otherwise."""
    simplicity: PositiveLength = Field(default=0.1, le=10)
    """Cost of a corner, in length of missing wall; larger ones give simpler rooms."""
    partial: bool = False
    """Accept a scan of a small part of the room, such as one view; unseen walls are guessed."""
    room: Annotated[Whole, Field(ge=0)] | Literal["all"] = 0
    """Which of several rooms becomes the layout: 0 is the largest and best seen one (area times the
    part of its walls that was scanned). `all` joins it with the rooms wall to wall with it, or
    with each other, to a flat. The report has all."""
    storey: Whole | None = Field(default=None, ge=0)
    """Which of several storeys, 0 is the lowest; by default the one with the largest floor."""

    @property
    def reader(self) -> str:
        """The name of the importer."""
        return self.importer

    @property
    def asked(self) -> dict[str, str]:
        """All that is asked of the importer."""
        if self.importer != "scan":
            return self.options
        up = {"up": ",".join(map(repr, self.up))} if self.up else {}
        return {"unit": str(self.unit), **up, **self.options}


class ImportedLayout(ImportedSection, CapturedLayout):
    """A room that an installed importer reads."""


Layout = Annotated[
    Annotated[PolygonLayout, Tag("polygon")]
    | Annotated[GeneratedLayout, Tag("generate")]
    | Annotated[RoomPlanLayout, Tag("roomplan")]
    | Annotated[Scan2CadLayout, Tag("scan2cad")]
    | Annotated[BoxesLayout, Tag("boxes")]
    | Annotated[ScanLayout, Tag("scan")]
    | Annotated[ImportedLayout, Tag("capture")],
    by_source("polygon"),
]


def named_openings(openings: Sequence[Opening]) -> list[tuple[str, Opening]]:
    """Give every opening its name: its own, or its kind and a number.

    Args:
        openings: The openings of the description, in order.

    Returns:
        The openings in order, each with its prim name.
    """
    names = unique_names((opening.name, opening.kind) for opening in openings)
    return list(zip(names, openings, strict=True))


def named_partitions(partitions: Sequence[Partition]) -> list[tuple[str, Partition]]:
    """Give every partition its name: its own, or a number.

    Args:
        partitions: The partitions of the description, in order.

    Returns:
        The partitions in order, each with its prim name.
    """
    names = unique_names((partition.name, "partition") for partition in partitions)
    return list(zip(names, partitions, strict=True))


def _either(words: Sequence[str]) -> str:
    return f"{', '.join(words[:-1])} or {words[-1]}"


def _name_clashes(openings: Sequence[Any], partitions: Sequence[Any]) -> Iterator[FoundMistake]:
    for rows, key in ((openings, "openings"), (partitions, "partitions")):
        given = [peek_text(row, "name") for row in rows]
        yield from repeated_names(given, key, key[:-1])


def _nowhere(given: Any, walls: int) -> Iterator[FoundMistake]:
    """Openings and cladding of walls and partitions that a drawn room does not have."""
    partitions = peek_list(given, "partitions")
    known = set(unique_names((peek_text(p, "name"), "partition") for p in partitions))
    missing = f"the polygon has the walls 0 to {walls - 1}"
    for index, opening in enumerate(peek_list(given, "openings")):
        wall = peek(opening, "wall")
        if type(wall) is int and wall >= walls >= 3:
            yield FoundMistake(("openings", index, "wall"), f"there is no wall {wall}: {missing}")
        name = peek_text(opening, "partition")
        if name is not None and name not in known:
            has = f"only {', '.join(sorted(known))}" if known else "the layout has none"
            yield FoundMistake(
                ("openings", index, "partition"), f"there is no partition {name!r}: {has}"
            )
    for index, one in enumerate(peek_list(given, "cladding")):
        for place, wall in enumerate(peek_list(one, "walls")):
            if type(wall) is int and wall >= walls >= 3:
                yield FoundMistake(
                    ("cladding", index, "walls", place), f"there is no wall {wall}: {missing}"
                )
