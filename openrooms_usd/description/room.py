"""The whole description: a name, a room type, a seed, and one section a stage."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeVar

from pydantic import Field, PrivateAttr, ValidationError

from openrooms_usd.description import reading
from openrooms_usd.description.cameras import AnyCameras, Cameras
from openrooms_usd.description.former import rename_sections
from openrooms_usd.description.furniture import Furniture, ObjectList, object_names
from openrooms_usd.description.layout import Layout, PolygonLayout
from openrooms_usd.description.lights import Lights
from openrooms_usd.description.materials import Materials
from openrooms_usd.description.mistakes import MistakesError, Steps
from openrooms_usd.description.model import CheckedModel, FoundMistake, Whole, peek, peek_list
from openrooms_usd.description.physics import Physics
from openrooms_usd.description.styles import InteriorStyle
from openrooms_usd.spelling import did_you_mean

RoomType = Literal[
    "apartment",
    "bathroom",
    "bedroom",
    "hotel",
    "bookstore",
    "library",
    "classroom",
    "closet",
    "computer_cluster",
    "conference_room",
    "copy_room",
    "mail_room",
    "dining_room",
    "game_room",
    "gym",
    "hallway",
    "kitchen",
    "laundry_room",
    "lounge",
    "living_room",
    "lobby",
    "office",
    "stairs",
    "storage",
    "basement",
    "garage",
    "misc",
]


@dataclass(frozen=True)
class _Text:
    """Where a room was read from, which makes it no other room.

    Attributes:
        name: Of the file.
        data: Its data, with their places; None for a room that stands in no file.
        notes: What users should know of how it is written.
    """

    name: str = field(compare=False)
    data: reading.Mapping | None = field(default=None, compare=False)
    notes: tuple[str, ...] = field(default=(), compare=False)


class Room(CheckedModel):
    """A room, as room.yaml describes it."""

    name: Annotated[str, Field(min_length=1, max_length=128)] = "room"
    """The room's name, for people: any text."""
    room: RoomType = "misc"
    """The room type; chooses defaults."""
    seed: Whole = Field(default=0, ge=0, lt=2**63)
    """Seed of all random choices."""
    style: InteriorStyle | None = None
    """Style of furniture, materials and colours; by default each is drawn independently."""
    clutter: int = Field(default=0, ge=0, le=3)
    """Amount of clutter on the furniture of a drawn or generated room, listed furniture too: 0 only
    listed objects, 1 tidy, 2 lived in, 3 messy."""
    layout: Layout = Field(default_factory=PolygonLayout)
    """The room's shell."""
    furniture: Furniture = Field(default_factory=ObjectList)
    """The objects in it."""
    materials: Materials = Field(default_factory=Materials)
    """Materials of the room and its objects."""
    lights: Lights = Field(default_factory=Lights)
    """The environment and the lamps."""
    cameras: AnyCameras = Field(default_factory=Cameras)
    """Cameras."""
    physics: Physics | None = None
    """Mass, collision shapes and motion of objects."""

    _folder: Path | None = PrivateAttr(default=None)
    _text: _Text = PrivateAttr(default_factory=lambda: _Text("the room"))

    if not TYPE_CHECKING:  # Type checkers see the fields instead.

        def __init__(self, /, **sections: Any) -> None:
            """Check the sections.

            Raises:
                DescriptionError: Something is wrong; the message lists every mistake.
            """
            notes = rename_sections(sections, "the room")
            try:
                super().__init__(**sections)
            except ValidationError as error:
                from openrooms_usd.description.data import refused

                raise refused(error, sections, type(self)) from None
            self._text = replace(self._text, notes=notes)

        # So that pydantic checks data without calling this: what reads files says the lines.
        __init__.__pydantic_base_init__ = True

    @property
    def alignment(self) -> Furniture:
        """The former name of `furniture`."""
        return self.furniture

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on how it is written, such as on former names."""
        return self._text.notes

    @property
    def folder(self) -> Path | None:
        """Where the names of files in it begin; None for the current folder."""
        return self._folder

    def located(self, folder: Path | None) -> Self:
        """The same room, whose names of files begin in a folder; None: in the current one."""
        room = self.model_copy()
        room._folder = folder
        return room

    def as_dict(self) -> dict[str, Any]:
        """The given fields, as plain data that makes the same room again."""
        return self.model_dump(mode="json", by_alias=True, exclude_unset=True)

    def __repr__(self) -> str:
        return f"Room({self.room!r}, name={self.name!r}, seed={self.seed}: {self._holds()})"

    __str__ = __repr__

    def _holds(self) -> str:
        """What stands in it, in a few words."""
        objects = getattr(self.furniture, "objects", None)
        found = _source(self.furniture) if objects is None else f"{len(objects)} objects"
        return f"layout from {_source(self.layout)}, {found}"

    @classmethod
    def disagreements(cls, given: Any) -> Iterator[FoundMistake]:
        """Lamps and materials for objects, and cameras of a capture, that do not exist.

        Captured and generated objects have other names, so only listed objects are checked.
        """
        yield from _cameras_of_nothing(given)
        yield from _drawn_into_captures(given)
        furniture = peek(given, "furniture")
        generated = furniture is None and _source(peek(given, "layout")) == "generate"
        if generated or (_source(furniture) or "objects") != "objects":
            return
        names = object_names(peek_list(furniture, "objects"))
        for section, key in (
            ("lights", "lamps"),
            ("materials", "overrides"),
            ("physics", "objects"),
        ):
            entries = peek(peek(given, section), key)
            if names is None or not isinstance(entries, dict):
                continue
            for name in entries.keys() - set(names):
                hint = did_you_mean(str(name), names)
                yield FoundMistake((section, key, name), f"no object is named {name!r}{hint}")


AnyRoom = TypeVar("AnyRoom", bound=Room)


def of_text(
    room: AnyRoom, name: str, data: reading.Mapping | None, notes: tuple[str, ...]
) -> AnyRoom:
    """The same room, which knows the name, the data and the notes of what it was read from."""
    same = room.model_copy()
    same._text = _Text(name, data, notes)
    return same


def refused_fields(room: Room, found: Iterable[tuple[Steps, str]]) -> MistakesError:
    """The error for fields of a room that ask for what cannot be made.

    Args:
        room: As it was described.
        found: The path of each, and what is wrong there.
    """
    from openrooms_usd.description.data import placed
    from openrooms_usd.description.diagnosis import located

    text = room._text
    data = placed(room.as_dict()) if text.data is None else text.data
    return MistakesError(text.name, located(data, found))


def room_of(data: Mapping[str, Any]) -> Room:
    """Make a room of plain data, as a ``room.yaml`` would hold it.

    Args:
        data: The sections by their keys; also with tuples, and with numbers and arrays of numpy.

    Returns:
        The room, with every default filled in.

    Raises:
        DescriptionError: It is not a valid description; the message lists every mistake by its path
            in the data.
    """
    from openrooms_usd.description.data import placed, refused

    sections = placed(data)
    notes = rename_sections(sections, "the room")
    try:
        return of_text(Room.model_validate(sections), "the room", None, notes)
    except ValidationError as error:
        raise refused(error, sections, Room) from None


def _source(section: Any) -> Any:
    return peek(section, "from") or peek(section, "source")


def _drawn_into_captures(given: Any) -> Iterator[FoundMistake]:
    """Furniture and small things that are to be drawn for a room that was captured."""
    layout, furniture = (_source(peek(given, key)) for key in ("layout", "furniture"))
    captured = layout not in (None, "polygon", "generate")
    if captured and furniture == "generate":
        yield FoundMistake(
            ("furniture", "from"),
            "furniture is generated for rooms that are drawn or generated, not for captured ones; "
            "give the polygon of the room in layout, or list the objects",
        )
    if peek(given, "clutter") in (1, 2, 3) and (
        captured or furniture not in (None, "objects", "generate")
    ):
        yield FoundMistake(
            ("clutter",),
            "clutter is available for drawn and generated rooms, not for captured ones; omit "
            "clutter, or draw the room by a polygon and list its objects",
        )


def _cameras_of_nothing(given: Any) -> Iterator[FoundMistake]:
    """Cameras from a capture in a room that comes from none."""
    named = [("layout", "file"), ("layout", "scan"), ("furniture", "file")]
    if any(peek(peek(given, section), key) for section, key in named):
        return
    cameras = peek(given, "cameras")
    views = [(("cameras", "views", i), v) for i, v in enumerate(peek_list(cameras, "views"))]
    # A section that is one view repeats itself as its only one.
    for path, view in [(("cameras",), cameras)] if _source(cameras) == "capture" else views:
        if _source(view) == "capture":
            text = (
                "the room does not come from a capture: neither its layout nor its furniture does"
            )
            yield FoundMistake((*path, "from"), text)
