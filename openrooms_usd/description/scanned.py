"""What a description may know of an object in a scan: which CAD, and roughly where."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Annotated, Any, Final, Literal

from pydantic import Discriminator, Field, Tag

from openrooms_usd.description.model import (
    CheckedModel,
    FoundMistake,
    Model,
    Number,
    Whole,
    peek,
    peek_list,
)
from openrooms_usd.description.units import FarLength, PositiveLength

# Scans may lie in the coordinates of a country.
Position = Annotated[
    tuple[FarLength, FarLength, FarLength], Field(description="x, y and z, metres")
]
Turn = Annotated[
    tuple[Number, Number, Number, Number], Field(description="a quaternion: w, x, y, z")
]
Scales = Annotated[
    tuple[
        Annotated[Number, Field(gt=0)],
        Annotated[Number, Field(gt=0)],
        Annotated[Number, Field(gt=0)],
    ],
    Field(description="along the axes of the CAD"),
]


Support = Annotated[
    Annotated[Literal["floor", "wall", "ceiling"], Tag("word")]
    | Annotated[Whole, Field(ge=1), Tag("instance")],
    Discriminator(lambda given: "instance" if type(given) is int else "word"),
]


class ScannedPose(Model):
    """A first guess: p = R diag(scale) p_cad + translation, in the scan's own frame, metres."""

    translation: Position
    rotation_wxyz: Turn = (1.0, 0.0, 0.0, 0.0)
    scale: Scales = (1.0, 1.0, 1.0)


class ScannedBox(Model):
    """A box around an object, in the scan's own frame; its heading is known to a quarter turn."""

    center: Position
    size: tuple[PositiveLength, PositiveLength, PositiveLength]
    """Along its own axes."""
    rotation_wxyz: Turn = (1.0, 0.0, 0.0, 0.0)


class ScannedObject(CheckedModel):
    """What is known of one object of the scan."""

    instance: Whole = Field(ge=1)
    """Its number in the scan, or any number if the scan has none."""
    category: str | None = None
    """What it is; by default its label."""
    cad: str | None = None
    """The id of its CAD; by default the best fit."""
    pose: ScannedPose | None = None
    """Approximate pose of the CAD."""
    box: ScannedBox | None = None
    """Approximate box of the object."""
    support: Support | None = None
    """What carries it: floor, wall, ceiling, or the instance that it stands on; by default the
    detected one."""

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """A rotation of length 0, and both a pose and a box."""
        for key in ("pose", "box"):
            turn = peek_list(peek(given, key), "rotation_wxyz")
            if turn and not any(turn):
                yield FoundMistake(
                    (key, "rotation_wxyz"), "a quaternion of length 0 is not a rotation"
                )
        if peek(given, "pose") is not None and peek(given, "box") is not None:
            yield FoundMistake(("box",), "give a pose or a box, not both")


def unsupported(objects: Sequence[Any]) -> Iterator[FoundMistake]:
    """Supports that are not hinted instances, and supports that depend on themselves.

    Args:
        objects: Hints as they were given.
    """
    carriers = {
        number: peek(thing, "support")
        for thing in objects
        if type(number := peek(thing, "instance")) is int
    }
    for index, thing in enumerate(objects):
        place, under = ("objects", index, "support"), peek(thing, "support")
        if type(under) is not int:
            continue
        if under > 0 and under not in carriers:
            yield FoundMistake(place, f"no object of this list has the instance {under}")
        elif _returns(peek(thing, "instance"), carriers):
            yield FoundMistake(place, "depends on itself; one object must stand on the floor")


def _returns(number: Any, carriers: Mapping[int, Any]) -> bool:
    """Whether what carries an instance, and what carries that, and so on, is the instance again."""
    under = carriers.get(number)
    for _ in carriers:
        if under == number or type(under) is not int:
            break
        under = carriers.get(under)
    return type(under) is int and under == number


# What the sections that come from a capture have in common: the file, and how to read it.

# The importers that a section names by `from` alone.
CAPTURES: Final = ("roomplan", "scan2cad", "boxes")

Option = Annotated[str, Field(max_length=4096)]


class CapturedSection(CheckedModel):
    """A section that an importer fills from a foreign file."""

    source: str = Field(alias="from")
    file: str = Field(min_length=1)
    """The captured file, relative to this description."""
    options: dict[str, Option] = Field(default_factory=dict)
    """Options of the importer, as `orusd import KIND --help` lists them; paths are relative to this
    description."""

    @property
    def reader(self) -> str:
        """The name of the importer."""
        return self.source

    @property
    def asked(self) -> dict[str, str]:
        """All that is asked of the importer."""
        return self.options


class ImportedSection(CapturedSection):
    """A section that an importer of some installed package fills."""

    source: Literal["capture"] = Field(alias="from")
    importer: str = Field(min_length=1)
    """The importer's name, as `orusd import --help` lists it."""

    @property
    def reader(self) -> str:
        """The name of the importer."""
        return self.importer
