"""The ``furniture`` section: which objects stand where."""

from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Sequence
from typing import Annotated, Any, Final, Literal, NamedTuple, TypeVar

from pydantic import Field, Tag

from openrooms_usd.description.categories import LibraryCategory
from openrooms_usd.description.generate import GeneratedFurniture
from openrooms_usd.description.model import (
    CheckedModel,
    FoundMistake,
    Model,
    PrimName,
    by_source,
    peek,
    peek_list,
    peek_text,
)
from openrooms_usd.description.naming import repeated_names, unique_names
from openrooms_usd.description.scanned import (
    CapturedSection,
    ImportedSection,
    ScannedObject,
    unsupported,
)
from openrooms_usd.description.units import Angle, Length, PositiveLength
from openrooms_usd.spelling import did_you_mean

Size = Annotated[
    tuple[PositiveLength, PositiveLength, PositiveLength],
    Field(description="width, depth and height, metres"),
]

# Guesses for ten thousand unknown names would take minutes and help no reader.
_MOST_HINTS: Final = 50

Cutout = Annotated[
    tuple[Length, Length, PositiveLength, PositiveLength],
    Field(description="x and y of its centre in the object's frame, width and depth, metres"),
]

_CIRCLE: Final = "depends on itself; one object must stand on the floor"


# What carries an object, beside another object.
SURFACES: Final = ("floor", "ceiling", "wall")


class _Link(NamedTuple):
    """A key that names another object.

    Attributes:
        refusal: What an object cannot do with itself.
        between: What stands between two names in messages.
        surfaces: What else the key may name.
    """

    refusal: str
    between: str
    surfaces: tuple[str, ...]

    @property
    def allowed(self) -> str:
        """All that the key may name, in words."""
        others = f"{', '.join(self.surfaces)} or " if self.surfaces else ""
        return f"{others}the name of another object"


_LINKS: Final = {
    "on": _Link("cannot stand on itself", "on", SURFACES),
    "relative_to": _Link("cannot be relative to itself", "relative to", ()),
}


class PlacedObject(Model):
    """What every object has: a name, a category and a place."""

    name: PrimName | None = None
    """Its prim name; by default its category and its position among them, such as chair_2."""
    category: PrimName
    """What it is, such as chair."""
    at: tuple[Length, ...] = Field(min_length=2, max_length=3)
    """x, y and, unless the support defines it, z of the centre of its base. With relative_to, x and
    y start at that object."""
    yaw: Angle = 0.0
    """Rotation about the vertical, counter-clockwise from above; at 0 the front looks along -Y."""
    tilt: tuple[Angle, Angle] = (0.0, 0.0)
    """Rotation before yaw: forward (about its x axis), then to its right (about its y axis);
    negative angles backward and to its left. If the support defines z, its lowest point lies
    there."""
    on: str | None = None
    """What carries it: floor, ceiling, wall (the nearest one, with its back to it) or another
    object's name; by default as its category does."""
    relative_to: str | None = None
    """Another object's name: x, y and yaw are in its frame, x to its right and y to its back."""


class LibraryObject(PlacedObject):
    """An object made by the parametric library."""

    source: Literal["library"] = Field(default="library", alias="from")
    category: LibraryCategory
    """What it is."""
    size: Size | None = None
    """Its box; by default as the category usually is."""
    style: str | None = None
    """One of the category's styles; by default drawn by the seed."""
    fronts: Literal["slab", "shaker", "handleless"] | None = None
    """Style of the doors and drawers of a kitchen unit; by default drawn by the seed."""
    cutouts: tuple[Cutout, ...] = ()
    """Cut-outs of a worktop, such as for a sink or hob."""


class FileObject(PlacedObject):
    """An object from the user's own OBJ, GLB, PLY, STL, URDF or USD file."""

    source: Literal["file"] = Field(default="file", alias="from")
    file: str = Field(min_length=1)
    """The mesh file, relative to this description."""
    size: Size | None = None
    """The box to fit it into; by default its own size."""
    up: Literal["Y", "Z"] | None = None
    """The file's up axis. By default as USD and URDF state it, otherwise Y (OBJ, GLB) or Z (PLY,
    STL), unless its category's usual sizes suggest the other."""
    front: Literal["+X", "-X", "+Y", "-Y"] | None = None
    """Direction of its front after the up axis is turned to Z. By default -Y; for URDF the side to
    which doors and drawers open."""
    unit: PositiveLength | None = None
    """The length of one unit of the file. By default as USD and URDF state it, otherwise 1 m,
    unless its category's usual sizes suggest another."""


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
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Names that repeat, and supports that do not exist or go round in a circle."""
        objects = peek_list(given, "objects")
        yield from _name_clashes(objects)
        yield from _unsupported(objects)


class CapturedFurniture(CapturedSection):
    """The objects of a captured room: its CAD models, and its boxes filled from the library."""

    objects: tuple[AlignedObject, ...] = ()
    """Further objects beside the captured ones."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Names that repeat; a support may be a captured object, which is not known here."""
        yield from _name_clashes(peek_list(given, "objects"))


class RoomPlanFurniture(CapturedFurniture):
    """The boxes of an Apple RoomPlan scan, filled from the library."""

    source: Literal["roomplan"] = Field(alias="from")


class Scan2CadFurniture(CapturedFurniture):
    """The CAD models of a Scan2CAD annotation."""

    source: Literal["scan2cad"] = Field(alias="from")


class BoxesFurniture(CapturedFurniture):
    """A plain list of boxes, filled from the library."""

    source: Literal["boxes"] = Field(alias="from")


class ScanFurniture(CheckedModel):
    """The furniture of a scan, whose layout is found in it too."""

    source: Literal["scan"] = Field(alias="from")
    cad: str | None = None
    """A folder of meshes, relative to this description, with an optional index.json. By default the
    library builds the furniture."""
    objects: tuple[ScannedObject, ...] | None = None
    """Known properties of objects; by default every labelled instance of the scan is used."""
    unresolved: Literal["leave_out", "keep"] = "leave_out"
    """How to treat objects that still overlap others or walls, or float, after moving them by up to
    30 cm."""
    unlabelled: Literal["furnish", "boxes", "leave_out"] = "furnish"
    """How to treat a scan without labels. Furniture is found and, where its shape is clear, named;
    or only boxes of its size replace it; or it is left out."""
    segmenter: str | None = None
    """The segmenter of the scan: the built-in `shapes`, or an installed one, as `orusd doctor`
    lists them. By default the scan's labels, or else `shapes`."""
    further: tuple[AlignedObject, ...] = ()
    """Further objects that the scan does not show, such as a lamp."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Instances and names that repeat, and supports that do not exist."""
        further = peek_list(given, "further")
        names = [peek_text(thing, "name") for thing in further]
        yield from repeated_names(names, "further", "object")
        seen: set[object] = set()
        for index, thing in enumerate(peek_list(given, "objects")):
            number = peek(thing, "instance")
            if type(number) is int and number in seen:
                yield FoundMistake(
                    ("objects", index, "instance"), f"the instance {number} is listed twice"
                )
            seen.add(number if type(number) is int else None)
        yield from unsupported(peek_list(given, "objects"))


class ImportedFurniture(ImportedSection, CapturedFurniture):
    """The objects that an installed importer reads."""


Furniture = Annotated[
    Annotated[ObjectList, Tag("objects")]
    | Annotated[GeneratedFurniture, Tag("generate")]
    | Annotated[RoomPlanFurniture, Tag("roomplan")]
    | Annotated[Scan2CadFurniture, Tag("scan2cad")]
    | Annotated[BoxesFurniture, Tag("boxes")]
    | Annotated[ScanFurniture, Tag("scan")]
    | Annotated[ImportedFurniture, Tag("capture")],
    by_source("objects"),
]

AnyPlaced = TypeVar("AnyPlaced", bound=PlacedObject)


def named_objects(objects: Sequence[AnyPlaced]) -> list[tuple[str, AnyPlaced]]:
    """Give every object its name: its own, or its category and a number.

    Args:
        objects: The objects of the description, in order.

    Returns:
        The objects in order, each with its prim name.
    """
    names = unique_names((thing.name, thing.category) for thing in objects)
    return list(zip(names, objects, strict=True))


def object_names(objects: Sequence[Any]) -> list[str] | None:
    """The names of objects that may be faulty; None where one of them cannot be named."""
    wanted = [(peek_text(thing, "name"), peek_text(thing, "category")) for thing in objects]
    named = [(name, category or "") for name, category in wanted if name or category]
    return unique_names(named) if len(named) == len(wanted) else None


def _name_clashes(objects: Sequence[Any]) -> Iterator[FoundMistake]:
    given = [peek_text(thing, "name") for thing in objects]
    yield from repeated_names(given, "objects", "object")
    for index, name in enumerate(given):
        if name in SURFACES:
            yield FoundMistake(
                ("objects", index, "name"), f"{name!r} is a reserved name; choose another one"
            )


def _unsupported(objects: Sequence[Any]) -> Iterator[FoundMistake]:
    names = object_names(objects)
    if names is None:
        return
    known = set(names)
    rows = [
        (index, key, name, other)
        for index, (name, thing) in enumerate(zip(names, objects, strict=True))
        for key in _LINKS
        if (other := peek_text(thing, key)) is not None
    ]
    circular = _circular({(name, other) for _, _, name, other in rows})
    unknown = 0
    for index, key, name, other in rows:
        link = _LINKS[key]
        if other == name:
            yield FoundMistake(("objects", index, key), f"{name!r} {link.refusal}")
        elif other not in known and other not in link.surfaces:
            unknown += 1
            near = [*known, *link.surfaces] if unknown <= _MOST_HINTS else ()
            hint = did_you_mean(other, near)
            text = f"no object is named {other!r}{hint}; allowed: {link.allowed}"
            yield FoundMistake(("objects", index, key), text)
        elif name in circular and other in circular:
            yield FoundMistake(
                ("objects", index, key), f"{name!r} {link.between} {other!r} {_CIRCLE}"
            )


def _circular(links: Collection[tuple[str, str]]) -> set[str]:
    """The names on circles of links, and those between two circles."""
    return _endless(links) & _endless([(other, name) for name, other in links])


def _endless(links: Collection[tuple[str, str]]) -> set[str]:
    """The names from which one can go on for ever: the others are taken away from the ends."""
    ways = Counter(name for name, _ in links)
    sources: defaultdict[str, list[str]] = defaultdict(list)
    for name, other in links:
        sources[other].append(name)
    ends = [other for other in sources if not ways[other]]
    while ends:
        for name in sources[ends.pop()]:
            ways[name] -= 1
            if not ways[name]:
                ends.append(name)
    return {name for name, left in ways.items() if left}
