"""A mistake in a description: where it stands and what is wrong, and all of them as one error."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

from openrooms_usd.errors import DescriptionError

Steps = tuple[str | int, ...]

# Users fix these first; ten thousand lines would not help them.
_MOST_SHOWN: Final = 50
_LONGEST_SHOWN: Final = 40
_LONGEST_LIST: Final = 4
_NESTED: Final = (dict, list)


class Place(NamedTuple):
    """A position in a text file, counted from 1; in line 0 for what stands in no file."""

    line: int
    column: int


@dataclass(frozen=True)
class Mistake:
    """One thing that is wrong.

    Attributes:
        place: Where it stands.
        path: Keys and list positions from the top of the description.
        text: What is wrong, what was found, what is allowed.
    """

    place: Place
    path: Steps
    text: str

    def __str__(self) -> str:
        return f"{written(self.path)}: {self.text}" if self.path else self.text


def written(path: Steps) -> str:
    """A path as people write it: ``furniture.objects[3].size[1]``."""
    text = "".join(
        f"[{step}]"
        if isinstance(step, int)
        else f".{step}"
        if step.isidentifier()
        else f"[{shown(step)}]"
        for step in path
    )
    return text.removeprefix(".")


def shown(value: Any) -> str:
    """What was found, short enough for a message."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list):
        scalars = len(value) <= _LONGEST_LIST and not any(isinstance(v, _NESTED) for v in value)
        return f"[{', '.join(map(shown, value))}]" if scalars else f"a list of {len(value)}"
    text = repr(value)
    cut = f"{text[:_LONGEST_SHOWN]}...{text[0] if isinstance(value, str) else ''}"
    return text if len(text) <= _LONGEST_SHOWN else f"{cut} ({len(str(value)):,} characters)"


class MistakesError(DescriptionError):
    """All mistakes of a description, in the order in which they stand in its file.

    Attributes:
        name: The description's file name.
        mistakes: They.
        given: The description's data, where they could be read.
    """

    def __init__(self, name: str, mistakes: Iterable[Mistake], given: Any = None) -> None:
        self.name, self.mistakes, self.given = name, tuple(mistakes), given
        super().__init__(_list_mistakes(name, self.mistakes), place=name)

    def __reduce__(self) -> tuple[Any, ...]:
        # Workers hand it over.
        return type(self), (self.name, self.mistakes)


class FieldsError(DescriptionError):
    """Fields ask for what cannot be made; a caller that knows the file adds their lines.

    Attributes:
        found: The path of each, and what is wrong there.
    """

    def __init__(self, *found: tuple[Steps, str]) -> None:
        self.found = found
        mistakes = [Mistake(Place(0, i), *row) for i, row in enumerate(found)]
        super().__init__(_list_mistakes("the room", mistakes), place="the room")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), self.found


def _list_mistakes(name: str, mistakes: Iterable[Mistake]) -> str:
    ordered = sorted(
        dict.fromkeys(mistakes), key=lambda mistake: (mistake.place, written(mistake.path))
    )
    lines = [f"{_where(name, mistake.place)}{mistake}" for mistake in ordered[:_MOST_SHOWN]]
    if len(ordered) > _MOST_SHOWN:
        lines.append(f"and {len(ordered) - _MOST_SHOWN:,} more")
    count = "1 mistake" if len(ordered) == 1 else f"{len(ordered):,} mistakes"
    return "\n  ".join([count, *lines])


def _where(name: str, place: Place) -> str:
    """How editors and terminals find a place; nothing where the path alone says it."""
    return f"{name}:{place.line}:{place.column}: " if place.line else ""
