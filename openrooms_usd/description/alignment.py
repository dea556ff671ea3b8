"""The ``alignment`` section: which objects stand where."""

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Final, Literal, TypeVar

from pydantic import Field, Tag

from openrooms_usd.description.model import (
    CheckedModel,
    Found,
    Model,
    PrimName,
    by_source,
    peek_list,
    peek_text,
)
from openrooms_usd.description.naming import repeated_names, unique_names
from openrooms_usd.description.nearest import did_you_mean
from openrooms_usd.description.units import Angle, Length, PositiveLength

Size = Annotated[
    tuple[PositiveLength, PositiveLength, PositiveLength],
    Field(description="width, depth and height, metres"),
]

LibraryCategory = Literal[
    "cabinet", "ceiling_lamp", "chair", "floor_lamp", "sofa", "table", "table_lamp"
]
"""What the parametric library can make."""

# A guess for each of ten thousand unknown names would take minutes, and nobody would read them.
_MOST_HINTS: Final = 50

_ALLOWED: Final = "; allowed: floor, ceiling or the name of another object"
_CIRCLE: Final = "goes round in a circle; something must stand on the floor"

# What carries an object, beside another object.
SURFACES: Final = ("floor", "ceiling")


class Placed(Model):
    """What every object has: a name, a category and a place."""

    name: PrimName | None = None
    """Its prim name; by default its category and its position among them, such as chair_2."""
    category: PrimName
    """What it is, such as chair."""
    at: tuple[Length, ...] = Field(min_length=2, max_length=3)
    """x, y and, where it does not follow from the support, z of the middle of its base."""
    yaw: Angle = 0.0
    """Rotation about the vertical, counter-clockwise from above; at 0 the front looks along -Y."""
    on: str | None = None
    """What carries it: floor, ceiling or another object's name; by default as its category does."""


class LibraryObject(Placed):
    """An object made by the parametric library."""

    source: Literal["library"] = Field(default="library", alias="from")
    category: LibraryCategory
    """What it is."""
    size: Size | None = None
    """Its box; by default as the category usually is."""
    style: str | None = None
    """One of the category's styles; by default drawn by the seed."""


class FileObject(Placed):
    """An object from the user's own OBJ, GLB, PLY or USD file."""

    source: Literal["file"] = Field(default="file", alias="from")
    file: str = Field(min_length=1)
    """The mesh file, relative to this description."""
    size: Size | None = None
    """The box to fit it into; by default its own size."""
    up: Literal["Y", "Z"] | None = None
    """The file's up axis; by default as the format has it (OBJ, GLB: Y; PLY: Z; USD: as stated)."""
    front: Literal["+X", "-X", "+Y", "-Y"] = "-Y"
    """Where its front looks after the up axis is turned to Z."""
    unit: PositiveLength | None = None
    """The length of one unit of the file; by default 1 m (USD: as the file states)."""


AlignedObject = Annotated[
    Annotated[LibraryObject, Tag("library")] | Annotated[FileObject, Tag("file")],
    by_source("library", file="file"),
]


class ObjectList(CheckedModel):
    """Objects listed one by one."""

    source: Literal["objects"] = Field(default="objects", alias="from")
    objects: tuple[AlignedObject, ...] = ()
    """The objects."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[Found]:
        """Names that repeat, and supports that do not exist or go round in a circle."""
        objects = peek_list(given, "objects")
        yield from _name_clashes(objects)
        yield from _unsupported(objects)


class RoomPlanAlignment(CheckedModel):
    """The boxes of an Apple RoomPlan scan, filled from the library."""

    source: Literal["roomplan"] = Field(alias="from")
    file: str = Field(min_length=1)
    """The exported CapturedRoom JSON, relative to this description."""
    objects: tuple[AlignedObject, ...] = ()
    """Further objects beside the captured ones."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[Found]:
        """Names that repeat; a support may be a captured object, which is not known here."""
        yield from _name_clashes(peek_list(given, "objects"))


Alignment = Annotated[
    Annotated[ObjectList, Tag("objects")] | Annotated[RoomPlanAlignment, Tag("roomplan")],
    by_source("objects"),
]

AnyPlaced = TypeVar("AnyPlaced", bound=Placed)


def named_objects(
    objects: Sequence[AnyPlaced], captured: Sequence[str] = ()
) -> list[tuple[str, AnyPlaced]]:
    """Give every object its name: its own, or its category and a number.

    Args:
        objects: The objects of the description, in order.
        captured: The categories of captured objects, which are counted first.

    Returns:
        The objects in order, each with its prim name.
    """
    wanted: list[tuple[str | None, str]] = [(None, category) for category in captured]
    wanted += [(thing.name, thing.category) for thing in objects]
    return list(zip(unique_names(wanted)[len(captured) :], objects, strict=True))


def object_names(objects: Sequence[Any]) -> list[str] | None:
    """The names of objects that may be faulty; None where one of them cannot be named."""
    wanted = [(peek_text(thing, "name"), peek_text(thing, "category")) for thing in objects]
    named = [(name, category or "") for name, category in wanted if name or category]
    return unique_names(named) if len(named) == len(wanted) else None


def _name_clashes(objects: Sequence[Any]) -> Iterator[Found]:
    given = [peek_text(thing, "name") for thing in objects]
    yield from repeated_names(given, "objects", "object")
    for index, name in enumerate(given):
        if name in SURFACES:
            yield Found(
                ("objects", index, "name"), f"{name!r} is the room's own; choose another name"
            )


def _unsupported(objects: Sequence[Any]) -> Iterator[Found]:
    names = object_names(objects)
    if names is None:
        return
    rows = [
        (index, name, support)
        for index, (name, thing) in enumerate(zip(names, objects, strict=True))
        if (support := peek_text(thing, "on")) is not None
    ]
    known = {*names, *SURFACES}
    circular = _circular({name: support for _, name, support in rows})
    unknown = 0
    for index, name, support in rows:
        if support == name:
            yield Found(("objects", index, "on"), f"{name!r} cannot stand on itself")
        elif support not in known:
            unknown += 1
            hint = did_you_mean(support, known) if unknown <= _MOST_HINTS else ""
            yield Found(("objects", index, "on"), f"no object is named {support!r}{hint}{_ALLOWED}")
        elif name in circular:
            yield Found(("objects", index, "on"), f"{name!r} on {support!r} {_CIRCLE}")


def _circular(supports: dict[str, str]) -> set[str]:
    """The names that carry themselves, in one walk along each chain."""
    done: set[str] = set()
    circular: set[str] = set()
    for start in supports:
        chain: dict[str, int] = {}
        name = start
        while name in supports and name not in done and name not in chain:
            chain[name] = len(chain)
            name = supports[name]
        if name in chain:
            circular.update(list(chain)[chain[name] :])
        done.update(chain)
    return circular
