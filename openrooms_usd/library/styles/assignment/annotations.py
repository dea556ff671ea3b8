"""What people noted about the materials of a model's parts, in OpenRooms' two formats.

``ann.txt`` lies beside one model. Lines that begin with ``#`` are headers; a number there is the
count of parts, as is the file ``matNum.txt`` beside it. ``!`` in the first line says that the model
is bad. All others are ``part category category ...``: the number of a part, counted from 0, and
the numbers of `CATEGORIES` that it may be made of; 9 says that the part is a lamp.

``annoMatParts.txt`` is for a category of PartNet, which its first line names. The others are
``part name: category, category``, with names of categories; nothing after the colon leaves the part
open.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from openrooms_usd import untrusted
from openrooms_usd.description.substances import Substance
from openrooms_usd.errors import InputError
from openrooms_usd.library.styles.assignment.kinds import kind_of
from openrooms_usd.spelling import did_you_mean

# By their numbers in ann.txt.
CATEGORIES: Final[tuple[Substance, ...]] = (
    "wood",
    "plastic",
    "rough_stone",
    "specular_stone",
    "paint",
    "leather",
    "metal",
    "fabric",
    "rubber",
)
AREA_LIGHT: Final = 9
PART_COUNT: Final = "matNum.txt"
_NUMBER: Final = re.compile(r"[0-9]{1,9}", re.ASCII)
_NUMBERED: Final = re.compile(r"(?:^|_)part_?([0-9]{1,9})$", re.IGNORECASE)


@dataclass(frozen=True)
class Annotation:
    """What the parts of a model may be made of.

    Attributes:
        numbered: Substances of the parts that are known by their number.
        named: Substances of the parts that are known by their kind.
        lamps: The numbers of the parts that shine.
        bad: Whether the annotator took the model for bad.
    """

    numbered: Mapping[int, tuple[Substance, ...]] = field(default_factory=dict)
    named: Mapping[str, tuple[Substance, ...]] = field(default_factory=dict)
    lamps: frozenset[int] = frozenset()
    bad: bool = False

    def substances(self, part: str) -> tuple[Substance, ...]:
        """What a part may be made of, by its name; empty if not annotated.

        Args:
            part: ``part3`` is the part number 3, as OpenRooms' meshes name their materials.
        """
        number = _number(part)
        return self.numbered.get(number, ()) or self.named.get(kind_of(part), ())

    def is_lamp(self, part: str) -> bool:
        """Whether a part shines, by its name."""
        return _number(part) in self.lamps


def _number(part: str) -> int:
    found = _NUMBERED.search(part)
    return int(found[1]) if found else -1


def files_of(path: Path) -> list[Path]:
    """The annotation and, where there is one, the count of parts beside it."""
    return [path, *filter(Path.is_file, [path.with_name(PART_COUNT)])]


def read_annotation(path: Path) -> Annotation:
    """Read either format; which it is shows in its lines.

    Args:
        path: ``ann.txt`` or ``annoMatParts.txt``, under any name.

    Raises:
        InputError: It cannot be read, or a line has neither format.
    """
    lines = list(_lines(path))
    if not lines:
        raise InputError("the annotation is empty", place=path, remedy="write one again")
    if lines[0][1].startswith("!"):
        return Annotation(bad=True)
    if any(":" in text for _, text in lines):
        return Annotation(named=dict(_named(path, lines)))
    return _numbered(path, lines)


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    text = untrusted.read_text(path, remedy="check the path and the file")
    stripped = ((number, line.strip()) for number, line in enumerate(text.splitlines(), 1))
    return ((number, line) for number, line in stripped if line)


def _numbered(path: Path, lines: list[tuple[int, str]]) -> Annotation:
    count, numbered, lamps = _count(path, lines), {}, set()
    for line, text in lines:
        if text.startswith("#"):
            continue
        part, categories = _row(path, line, text)
        if count is not None and part >= count:
            continue
        if AREA_LIGHT in categories:
            lamps.add(part)
        else:
            numbered[part] = tuple(CATEGORIES[category] for category in categories)
    return Annotation(numbered, lamps=frozenset(lamps))


def _count(path: Path, lines: list[tuple[int, str]]) -> int | None:
    """How many parts the model has: later parts of the list are no longer there."""
    beside = path.with_name(PART_COUNT)
    headers = [text.lstrip("# ") for _, text in lines if text.startswith("#")]
    if beside.is_file():
        headers = [text for _, text in _lines(beside)]
    return next((int(text) for text in headers if _NUMBER.fullmatch(text)), None)


def _row(path: Path, line: int, text: str) -> tuple[int, list[int]]:
    words = text.split()
    if len(words) < 2 or not all(_NUMBER.fullmatch(word) for word in words):
        raise InputError(
            f"expected the number of a part and of its categories, found {text[:60]!r}",
            place=f"{path}:{line}",
            remedy="write lines such as: 0 6 4",
        )
    part, *categories = (int(word) for word in words)
    if wrong := [category for category in categories if category > AREA_LIGHT]:
        known = ", ".join(f"{number} {name}" for number, name in enumerate(CATEGORIES))
        raise InputError(
            f"there is no category {wrong[0]}",
            place=f"{path}:{line}",
            remedy=f"there are: {known}, {AREA_LIGHT} area light",
        )
    return part, categories


def _named(path: Path, lines: list[tuple[int, str]]) -> Iterator[tuple[str, tuple[Substance, ...]]]:
    for line, text in lines:
        name, colon, rest = text.partition(":")
        if not colon and line == lines[0][0]:
            continue  # the category of PartNet
        if not colon:
            raise InputError(
                f"expected a part and its categories, found {text[:60]!r}",
                place=f"{path}:{line}",
                remedy="write lines such as: chair_leg: wood, metal",
            )
        words = [word.strip() for word in rest.split(",") if word.strip()]
        found = tuple(_substance(path, line, word) for word in words)
        if found:
            yield kind_of(name), found


def _substance(path: Path, line: int, word: str) -> Substance:
    for substance in CATEGORIES:
        if substance == word:
            return substance
    raise InputError(
        f"there is no category {word[:60]!r}{did_you_mean(word, CATEGORIES)}",
        place=f"{path}:{line}",
        remedy=f"there are: {', '.join(CATEGORIES)}",
    )
