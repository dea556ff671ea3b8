"""What a description asks for that cannot be made, found before any step runs: all at once."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

from pydantic import TypeAdapter, ValidationError

from openrooms_usd import furniture
from openrooms_usd.description import load_room
from openrooms_usd.description.diagnosis import located
from openrooms_usd.description.furniture import AlignedObject, LibraryObject
from openrooms_usd.description.layout import Layout, PolygonLayout
from openrooms_usd.description.mistakes import FieldsError, MistakesError, Steps
from openrooms_usd.description.room import Room, refused_fields
from openrooms_usd.errors import InputError
from openrooms_usd.library.styles.beams import BEAMS
from openrooms_usd.steps.base import input_file

# The keys of names of files, wherever they stand.
_FILES: Final = ("file", "scan")

Found = tuple[Steps, str]


def checked(description: Room | Path, base: Path | None) -> tuple[Room, Path]:
    """A room that can be made as far as its description tells, and where its files begin.

    Args:
        description: A room, or the file that describes it.
        base: Where the names of files begin; None for the folder of the description.

    Raises:
        InputError: The file cannot be read.
        DescriptionError: It has mistakes; the message lists all of them with their places.
    """
    try:
        room = description if isinstance(description, Room) else load_room(description)
    except MistakesError as error:
        if error.given is None:
            raise
        assert isinstance(description, Path)
        further = located(error.given, _impossible(error.given, base or description.parent))
        raise MistakesError(error.name, [*error.mistakes, *further]) from None
    source = base or room.folder or Path()
    if found := list(_impossible(room.as_dict(), source)):
        raise refused_fields(room, found)
    return room, source


def _impossible(given: Mapping[str, Any], source: Path) -> Iterator[Found]:
    """What is wrong in the parts of a description that are valid by themselves."""
    layout = _valid(Layout, given.get("layout") or {})
    if isinstance(layout, PolygonLayout):
        yield from _shell(layout)
    listed = given.get("furniture")
    for key in ("objects", "further"):
        rows = listed.get(key) if isinstance(listed, Mapping) else None
        for index, row in enumerate(rows if isinstance(rows, Sequence) else ()):
            item = _valid(AlignedObject, row)
            if isinstance(item, LibraryObject):
                yield from _piece(("furniture", key, index), item)
    for path, name in _named_files(given, ()):
        try:
            input_file(source, name, folders=True)
        except InputError as error:
            yield path, f"{error.place}: {error.message}; {error.remedy}"


def _shell(layout: PolygonLayout) -> Iterator[Found]:
    from openrooms_usd.steps.layout.step import described_plan

    try:
        described_plan(layout, [])
    except FieldsError as error:
        yield from error.found


def _piece(path: Steps, item: LibraryObject) -> Iterator[Found]:
    from openrooms_usd.steps.alignment.catalogue import asked

    size, order = asked(item)
    try:
        furniture.check(item.category, size, item.style, order)
    except InputError as error:
        yield (*path, str(error.place)), f"{error.message}; {error.remedy}"


def _named_files(given: Any, path: Steps) -> Iterator[tuple[Steps, str]]:
    """Every name of a file that is to be read."""
    rows: Any = given.items() if isinstance(given, Mapping) else ()
    if isinstance(given, Sequence) and not isinstance(given, str):
        rows = enumerate(given)
    for key, value in rows:
        here = (*path, key)
        named = key in _FILES or path[-1:] == ("annotations",) or here == ("furniture", "cad")
        shining = key == "profile" and path[-2:-1] == ("lamps",) and value not in BEAMS
        if (named or shining) and isinstance(value, str):
            yield here, value
        elif key != "options":
            yield from _named_files(value, here)


def _valid(kind: Any, given: Any) -> Any:
    """A part of a description; None where it is not valid."""
    try:
        return _adapter(kind).validate_python(given)
    except ValidationError:
        return None


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)
