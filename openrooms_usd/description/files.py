"""From a file or a text to a room or a dataset, and from a room back."""

from pathlib import Path
from typing import Final, TypeVar

import yaml
from pydantic import ValidationError

from openrooms_usd.description.dataset import Dataset
from openrooms_usd.description.diagnosis import diagnose
from openrooms_usd.description.former import rename_sections
from openrooms_usd.description.mistakes import Mistake, MistakesError
from openrooms_usd.description.model import Model
from openrooms_usd.description.reading import place_of, read_yaml
from openrooms_usd.description.room import Room, of_text
from openrooms_usd.description.scalars import FIRST, PLAIN
from openrooms_usd.errors import DescriptionError
from openrooms_usd.untrusted import MOST_BYTES, read_bytes

MAX_BYTES: Final = MOST_BYTES["description"]

Described = TypeVar("Described", bound=Model)


def load_room(path: Path) -> Room:
    """Read a description.

    Args:
        path: The YAML file.

    Returns:
        The room, with every default filled in.

    Raises:
        InputError: The file is missing or cannot be read.
        DescriptionError: It is not a valid description; the message lists every mistake.
    """
    remedy = "`orusd init DIR` writes a room to start from"
    text = read_bytes(path, "description", remedy=remedy)
    return parse_room(text, str(path), folder=path.parent)


def parse_room(text: str | bytes, name: str = "room.yaml", *, folder: Path | None = None) -> Room:
    """Read a description from text.

    Args:
        text: YAML; bytes are UTF-8, with or without a byte order mark.
        name: A file name for messages.
        folder: Where the names of files in it begin; None for the current folder.

    Returns:
        The room, with every default filled in.

    Raises:
        DescriptionError: It is not a valid description; the message lists every mistake.
    """
    room = _parsed(Room, text, name)
    return room if folder is None else room.located(folder)


def load_dataset(path: Path) -> Dataset:
    """Read a dataset.yaml.

    Args:
        path: The YAML file.

    Returns:
        The dataset, with every default filled in.

    Raises:
        InputError: The file is missing or cannot be read.
        DescriptionError: It is not a valid description; the message lists every mistake.
    """
    text = read_bytes(path, "description", remedy="docs/howto/datasets.md shows one to start from")
    return _parsed(Dataset, text, str(path)).located(path.parent)


def _parsed(model: type[Described], text: str | bytes, name: str) -> Described:
    """What a text describes; all its mistakes at once."""
    data, mistakes = read_yaml(_decoded(text, name), name)
    notes = rename_sections(data, name) if model is Room else ()
    try:
        found = model.model_validate(data)
    except ValidationError as error:
        places = {mistake.place for mistake in mistakes}
        further = (row for row in diagnose(error, data, model) if row.place not in places)
        raise MistakesError(name, [*mistakes, *further], data) from None
    if mistakes:
        raise MistakesError(name, mistakes, data)
    return of_text(found, name, data, notes) if isinstance(found, Room) else found


def dump_room(room: Room) -> str:
    """Write a room as YAML that `parse_room` reads back as the same room.

    What was not given when the room was made is left out.
    """
    text: str = yaml.dump(
        room.as_dict(),
        Dumper=_Dumper,
        sort_keys=False,
        allow_unicode=True,
        width=100,
        default_flow_style=None,
    )
    return text


class _Dumper(yaml.SafeDumper):
    """Quotes also what only YAML 1.2 would read as a number."""


_Dumper.add_implicit_resolver("tag:yaml.org,2002:float", PLAIN, list(FIRST))


def _decoded(text: str | bytes, name: str) -> str:
    data = text.encode("utf-8", "surrogatepass") if isinstance(text, str) else text
    if len(data) > MAX_BYTES:
        raise DescriptionError(
            f"the file is larger than {MAX_BYTES // 2**20} MiB",
            place=name,
            remedy="ten thousand objects need about 2 MiB; is this the right file?",
        )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        place = place_of(data[: error.start].decode(), error.start)
        raise MistakesError(
            name, [Mistake(place, (), f"the byte 0x{data[error.start]:02X} is not UTF-8 text")]
        ) from None
