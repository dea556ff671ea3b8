"""What the columns of a table of points mean: by the words of its heading, or by their values."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from openrooms_usd.arrays import Array
from orusd_scans.formats.rows import ANY, COMMENTS, Layout
from orusd_scans.scanned import broken

_PLACE: Final = ("x", "y", "z")
_NORMAL: Final = ("nx", "ny", "nz")
_COLOR: Final = ("red", "green", "blue")
# Spellings of names, as patterns of what `_plain` gives.
_SPELLINGS: Final = (
    (r"(?:(?:p|pos|position|point|coord|coordinate)_?)?([xyz])(?:_?coord(?:inate)?)?", r"\1"),
    (r"(?:n|normals?|norm)_?([xyz])", r"n\1"),
    (r"(?:colou?r_?)?r(?:ed)?_?f?", "red"),
    (r"(?:colou?r_?)?g(?:reen)?_?f?", "green"),
    (r"(?:colou?r_?)?b(?:lue)?_?f?", "blue"),
    (r"easting", "x"),
    (r"northing", "y"),
    (r"elevation|altitude", "z"),
)
_UNITS: Final = {
    **{unit: unit for unit in ("m", "dm", "cm", "mm", "in", "ft", "km")},
    **{"meter": "m", "meters": "m", "metre": "m", "metres": "m"},
    **{"millimeter": "mm", "millimeters": "mm", "millimetre": "mm", "millimetres": "mm"},
    **{"centimeter": "cm", "centimeters": "cm", "centimetre": "cm", "centimetres": "cm"},
    **{"inch": "in", "inches": "in", "foot": "ft", "feet": "ft"},
}
_UNIT: Final = re.compile(rf"(.+?)[\s_/]*[\[({{]?\s*({'|'.join(_UNITS)})\s*[\])}}]?")
_BRACKETS: Final = re.compile(r"\s*[\[({][^\])}]*[\])}]")
# What leads to a list of names.
_LEAD: Final = re.compile(r"^[\w ]+:\s+")
# What begins a list that goes on to the end of the line: COLMAP's points3D.txt.
_OPEN: Final = "track"
# Between words: a separator that is in no brackets.
_WORD: Final = r'(?:"[^"]*"|[^\s\[\](){}]+)(?:\s*[\[({][^\])}]*[\])}])?'
# Words of sentences, which no column is called.
_PROSE: Final = frozenset(
    "the of and are is as in on at with by for from each per given this that to one was".split()
)
_UNIT_NORMAL_TOLERANCE: Final = 1e-2
_NYU40: Final = 40
_MOST_COLOR: Final = 65535
# What columns without names may be, the likeliest first, by their number.
_USUAL: Final[dict[int, tuple[tuple[str, ...], ...]]] = {
    3: ((),),
    4: (("intensity",),),
    6: (_NORMAL, _COLOR),
    7: ((*_NORMAL, "label"), (*_COLOR, "label"), ("intensity", *_COLOR)),
    8: ((*_COLOR, "label", "instance"), ("intensity", *_COLOR, "label")),
    9: ((*_COLOR, *_NORMAL), (*_NORMAL, *_COLOR)),
    10: ((*_COLOR, *_NORMAL, "label"), (*_NORMAL, *_COLOR, "label")),
}


@dataclass(frozen=True)
class Heading:
    """The columns of a table.

    Attributes:
        names: Of each, in lower case.
        unit: Of the coordinates, where it is said.
        more: Whether lines go on after these columns.
    """

    names: tuple[str, ...]
    unit: str | None = None
    more: bool = False


def heading_of(lines: Sequence[str], layout: Layout, width: int, path: Path) -> Heading | None:
    """What the lines before the first row say of the columns; None where they say nothing.

    Args:
        lines: Comments among them.
        layout: How the rows are written.
        width: How many numbers a row has.
        path: The file, for messages.

    Raises:
        InputError: A line names other columns than are there.
    """
    found = [one for line in lines if (one := _heading(line, layout, width)) is not None]
    if found:
        last = found[-1]
        if layout.separator == "," and width == 2 * len(last.names):
            raise broken(
                path,
                f"{len(last.names)} columns are named, but lines have {width} between commas",
                "write decimal points, or semicolons between the columns",
            )
        if len(last.names) > width and not last.more:
            raise broken(
                path,
                f"{len(last.names)} columns are named, but lines have {width}",
                "correct its line of names",
            )
        extra = range(len(last.names) + 1, width + 1)
        more = () if last.more else tuple(f"column {number}" for number in extra)
        return Heading((*last.names, *more), last.unit, last.more)
    words = layout.fields(lines[-1]) if lines else []
    if len(words) == width and not lines[-1].lstrip().startswith(COMMENTS):
        named = ", ".join(words)[:200]
        raise broken(
            path, f"its columns are named {named}: x, y and z are missing", "name these so"
        )
    return None


def _heading(line: str, layout: Layout, width: int) -> Heading | None:
    text = _LEAD.sub("", line.strip().lstrip(" \t".join(COMMENTS)))
    several = [one for words in _splits(text, layout) if (one := _named(words)) is not None]
    if line.lstrip().startswith(COMMENTS):  # perhaps words that mention x, y and z
        several = [
            one for one in several if one.more or one.names[:3] == _PLACE or len(one.names) <= width
        ]
    fitting = [one for one in several if len(one.names) == width]
    return next(iter(fitting + several), None)


def _splits(text: str, layout: Layout) -> Iterator[list[str]]:
    """The words of a heading, by the separator of the rows or any other."""
    for separator in dict.fromkeys((layout.separator, *ANY)):
        if separator and separator in text and separator != ANY:
            words = re.split(rf"{separator}(?![^(\[{{]*[)\]}}])", text)
            while not words[-1].strip():
                words.pop()
            yield words
    yield re.findall(_WORD, text)


def _named(words: Sequence[str]) -> Heading | None:
    names, units = list[str](), set[str | None]()
    for word in words:
        name, unit = _plain(word)
        if name in _PROSE:
            return None
        if name in _PLACE:
            units.add(unit)
        if name.startswith(_OPEN):
            return Heading(tuple(names), more=True) if {*_PLACE} <= {*names} else None
        names.append(name or f"column {len(names) + 1}")
    if not {*_PLACE} <= {*names}:
        return None
    return Heading(tuple(names), units.pop() if len(units) == 1 else None)


def _plain(word: str) -> tuple[str, str | None]:
    """A name without its brackets, as it is known, and the unit that these say."""
    text = word.strip().strip("\"'").strip().lower()
    if (match := _UNIT.fullmatch(text)) and (name := _spelt(match[1])) in _PLACE:
        return name, _UNITS[match[2]]
    return _spelt(_BRACKETS.sub("", text)) or text, None


def _spelt(text: str) -> str:
    text = re.sub(r"[\s.\-]+", "_", text.strip())
    for pattern, name in _SPELLINGS:
        if match := re.fullmatch(pattern, text):
            return match.expand(name)
    return text


def guessed(values: Array, notes: list[str], *, intensity_first: bool) -> Heading:
    """What columns without names are, by their values.

    Args:
        values: (N, C) the table.
        notes: Receives a sentence about what is not sure.
        intensity_first: Whether an intensity is likelier before a colour, as in PTS files.
    """
    width = values.shape[1]
    sound = values[np.isfinite(values).all(axis=1)]
    usual = _USUAL.get(width, ())
    if intensity_first:
        usual = tuple(sorted(usual, key=lambda names: names[:1] != ("intensity",)))
    for names in usual:
        if _fit(names, sound[:, 3:]):
            if width not in (3, 6):
                notes.append(
                    f"the columns have no names: they are read as x, y, z, {', '.join(names)} "
                    "(add a first line of names to change that)"
                )
            return Heading((*_PLACE, *names))
    return Heading((*_PLACE, *(f"column {number}" for number in range(4, width + 1))))


def _fit(names: Sequence[str], values: Array) -> bool:
    """Whether columns may be what they are called."""
    at = {name: values[:, i] for i, name in enumerate(names)}
    fits = True
    if "nx" in at:
        lengths = np.linalg.norm([at[name] for name in _NORMAL], axis=0)
        fits = bool((np.abs(lengths - 1.0) < _UNIT_NORMAL_TOLERANCE).all())
    if "red" in at:
        color = np.array([at[name] for name in _COLOR])
        fits &= bool(((color >= 0.0) & (color <= _MOST_COLOR)).all())
    for name in ("label", "instance"):
        if name in at:
            # A colour's blue is whole, too, but hardly ever this dark everywhere.
            number = at[name]
            is_class = (number <= _NYU40).all() or (number.max(initial=0.0) > 255.0)
            fits &= bool((number % 1.0 == 0.0).all() and (is_class or name != "label"))
    return fits
