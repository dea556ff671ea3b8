"""Former names of sections of a room.yaml: they stay valid, and a note gives the present one."""

from typing import Any

from openrooms_usd.description.mistakes import Mistake, MistakesError, Place
from openrooms_usd.description.reading import Mapping
from openrooms_usd.names import FORMER_SECTIONS


def rename_sections(data: dict[str, Any], name: str) -> tuple[str, ...]:
    """Give the sections of a description their present names, in place.

    Args:
        data: The description.
        name: Of its file, for messages.

    Returns:
        A note for each former name.

    Raises:
        DescriptionError: A section is there under both names.
    """
    notes = []
    for former, present in FORMER_SECTIONS.items():
        if former not in data:
            continue
        if present in data:
            raise MistakesError(name, [_both(data, former, present)])
        data[present] = data.pop(former)
        if isinstance(data, Mapping):
            for places in (data.keys_at, data.values_at):
                places[present] = places.pop(former)
        notes.append(note_of(former))
    return tuple(notes)


def note_of(former: str) -> str:
    """The note for users who wrote the former name of a section."""
    return f"`{former}` is called `{FORMER_SECTIONS[former]}` now"


def name_in(data: dict[str, Any], section: str) -> str:
    """The name by which a description has a section: the former one only where it is there."""
    former = (old for old, new in FORMER_SECTIONS.items() if new == section and old in data)
    return next(former, section)


def _both(data: dict[str, Any], former: str, present: str) -> Mistake:
    place, line = Place(0, 0), ""
    if isinstance(data, Mapping):
        place, other = data.keys_at[former], data.keys_at[present]
        line = f" in line {other.line}" if other.line else ""
    text = f"the former name of `{present}`, which is given too{line}; merge the two sections"
    return Mistake(place, (former,), text)
