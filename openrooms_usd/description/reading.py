"""room.yaml as plain data: a small, safe part of YAML 1.2 that knows where everything stands.

The data is built from the parser's events, so nothing is constructed that a tag asks for, nothing
recurses, and a hostile file is refused as soon as it passes a limit. Mappings with text keys,
lists, text, numbers, true, false and null are all there is. Anchors work as long as what they
stand for, written out, stays within the limits.
"""

from typing import Any, Final, NoReturn

import yaml

from openrooms_usd.description.mistakes import Mistake, MistakesError, Place, Steps, shown
from openrooms_usd.description.scalars import plain, short_tag, tag_fits, tagged

# What libyaml (or its Python twin) says, and what a person needs to hear; the first match counts.
_TEXTS: Final = (
    ("could not find expected ':'", "a key needs a colon and a space after it"),
    ("unexpected end of stream", "the text that was opened with a quote here is not closed"),
    ("',' or ']'", "the list that was opened with [ in line {opened} lacks a comma or its ]"),
    ("',' or '}'", "the mapping that was opened with {{ in line {opened} lacks a comma or its }}"),
    ("cannot start any token", "{character} is not allowed here; quote the text"),
    ("mapping values are not allowed", "a colon does not fit here: check the indentation"),
    ("'-' indicator", "this line does not fit those above it: check the indentation"),
    ("did not find expected key", "this line does not fit those above it: check the indentation"),
    ("<block end>", "this line does not fit those above it: check the indentation"),
    ("undefined tag handle", "tags are not allowed"),
    ("unknown escape character", "after a backslash in double quotes only \\n, \\t and so on"),
    ("<document start>", "text after the end of the description is not allowed"),
    ("node content", "a value is missing, or the text ends too early"),
)
_TAB: Final = "tabs are not allowed for indentation; use spaces"
MAX_DEPTH: Final = 32
MAX_VALUES: Final = 1_000_000
_LOADER: Final = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class Mapping(dict[str, Any]):
    """A mapping that knows where it, its keys and its values stand."""

    __slots__ = ("keys_at", "pending", "place", "refused", "values_at")

    def __init__(self, place: Place) -> None:
        super().__init__()
        self.place = place
        self.keys_at: dict[str, Place] = {}
        self.values_at: dict[str, Place] = {}
        self.pending: str | None = None
        self.refused = False

    def take(self, value: Any, place: Place) -> None:
        """Put a value under the key that was read last, unless that key was refused."""
        assert self.pending is not None
        if not self.refused:
            self[self.pending] = value
            self.values_at[self.pending] = place
        self.pending = None


class Sequence(list[Any]):
    """A list that knows where it and its items stand."""

    __slots__ = ("place", "values_at")

    def __init__(self, place: Place) -> None:
        super().__init__()
        self.place = place
        self.values_at: list[Place] = []

    def take(self, value: Any, place: Place) -> None:
        """Append an item."""
        self.append(value)
        self.values_at.append(place)


def read_yaml(text: str, name: str) -> tuple[Mapping, list[Mistake]]:
    """Read a description's text.

    Args:
        text: The whole file.
        name: Its name, for messages.

    Returns:
        The data, and the mistakes that did not stop the reading, such as duplicate keys.

    Raises:
        DescriptionError: It is not valid YAML, not a single mapping, or exceeds a limit.
    """
    reader = _Reader(name)
    try:
        for event in yaml.parse(text, Loader=_LOADER):
            reader.read(event)
    except yaml.YAMLError as error:
        reader.stop(*explain(error, text))
    return reader.document(), reader.mistakes


class _Open:
    """A mapping or list that is being read.

    Attributes:
        data: What was read of it so far.
        anchor: The name by which it can be repeated.
        began: How many values had been read before it.
        height: How many levels of mappings and lists it holds so far.
    """

    __slots__ = ("anchor", "began", "data", "height")

    def __init__(self, data: Mapping | Sequence, anchor: str | None, began: int) -> None:
        self.data = data
        self.anchor = anchor
        self.began = began
        self.height = 1


class _Reader:
    """Builds the data from the parser's events, without recursion."""

    def __init__(self, name: str) -> None:
        self.mistakes: list[Mistake] = []
        self._name = name
        self._documents = 0
        self._root: Any = None
        self._open: list[_Open] = []
        self._values = 0
        # By anchor: the value, how many values it holds written out, and how many levels.
        self._anchors: dict[str, tuple[Any, int, int]] = {}

    def read(self, event: Any) -> None:
        """Take the next event."""
        kind = type(event)
        if kind is yaml.ScalarEvent:
            self._scalar(event)
        elif kind is yaml.MappingStartEvent:
            self._begin(event, Mapping(_place(event)), "map")
        elif kind is yaml.SequenceStartEvent:
            self._begin(event, Sequence(_place(event)), "seq")
        elif kind is yaml.MappingEndEvent or kind is yaml.SequenceEndEvent:
            self._end()
        elif kind is yaml.AliasEvent:
            self._repeat(event)
        elif kind is yaml.DocumentStartEvent:
            self._documents += 1
            if self._documents > 1:
                self.stop(_place(event), "a second document begins; a file holds one room")

    def document(self) -> Mapping:
        """The whole data, once all events were read."""
        if self._root is None:
            self.stop(Place(1, 1), "the description is empty; `orusd init DIR` writes one")
        if not isinstance(self._root, Mapping):
            self.stop(Place(1, 1), f"expected keys such as `layout:`, found {shown(self._root)}")
        return self._root

    def stop(self, place: Place, text: str) -> NoReturn:
        """Give up: what follows could not be understood."""
        raise MistakesError(self._name, [*self.mistakes, Mistake(place, self._here(), text)])

    def _here(self) -> Steps:
        """The path of what is read at the moment."""
        pending = (
            len(level.data) if isinstance(level.data, Sequence) else level.data.pending
            for level in self._open
        )
        return tuple(step for step in pending if step is not None)

    def _count(self, place: Place, values: int = 1) -> None:
        self._values += values
        if self._values > MAX_VALUES:
            self.stop(place, f"more than {MAX_VALUES:,} values, anchors written out")

    def _put(self, value: Any, place: Place) -> None:
        """Hand a finished value to what it stands in."""
        if not self._open:
            self._root = value
            return
        data = self._open[-1].data
        if isinstance(data, Mapping) and data.pending is None:
            self.stop(place, "a key must be text")
        data.take(value, place)

    def _scalar(self, event: Any) -> None:
        place = _place(event)
        self._count(place)
        value = event.value
        try:
            if event.tag is not None:
                value = tagged(event.tag, value)
            elif event.implicit[0]:
                value = plain(value)
        except ValueError as error:
            self.mistakes.append(Mistake(place, self._here(), str(error)))
        if event.anchor is not None:
            self._anchors[event.anchor] = (value, 1, 0)
        data = self._open[-1].data if self._open else None
        if isinstance(data, Mapping) and data.pending is None:
            self._key(data, event.value, value, place)
        else:
            self._put(value, place)

    def _key(self, data: Mapping, text: str, value: Any, place: Place) -> None:
        said = None
        if text == "<<":
            said = "merge keys are not supported; write it out"
        elif not isinstance(value, str):
            said = "a key must be text; put it in quotes"
        elif text in data:
            said = f"duplicate key, first given in line {data.keys_at[text].line}"
        if said is not None:
            self.mistakes.append(Mistake(place, (*self._here(), text), said))
        else:
            data.keys_at[text] = place
        data.pending, data.refused = text, said is not None

    def _begin(self, event: Any, data: Mapping | Sequence, collection: str) -> None:
        self._count(data.place)
        if event.tag is not None and not tag_fits(event.tag, collection):
            text = f"tags are not allowed, found {short_tag(event.tag)}"
            self.mistakes.append(Mistake(data.place, self._here(), text))
        if (
            self._open
            and isinstance(above := self._open[-1].data, Mapping)
            and above.pending is None
        ):
            self.stop(data.place, "a key must be text, found a mapping or a list")
        if len(self._open) >= MAX_DEPTH:
            self.stop(data.place, f"nested more than {MAX_DEPTH} levels deep")
        if event.anchor is not None:
            self._anchors.pop(event.anchor, None)
        self._open.append(_Open(data, event.anchor, self._values - 1))

    def _end(self) -> None:
        level = self._open.pop()
        if level.anchor is not None:
            written_out = self._values - level.began
            self._anchors[level.anchor] = (level.data, written_out, level.height)
        if self._open:
            self._open[-1].height = max(self._open[-1].height, level.height + 1)
        self._put(level.data, level.data.place)

    def _repeat(self, event: Any) -> None:
        place = _place(event)
        if any(level.anchor == event.anchor for level in self._open):
            self.stop(place, f"*{event.anchor} contains itself")
        if event.anchor not in self._anchors:
            self.stop(place, f"the anchor &{event.anchor} is not defined above")
        value, values, height = self._anchors[event.anchor]
        self._count(place, values)
        if len(self._open) + height > MAX_DEPTH:
            self.stop(place, f"nested more than {MAX_DEPTH} levels deep, anchors written out")
        if self._open:
            self._open[-1].height = max(self._open[-1].height, height + 1)
        self._put(value, place)


def _place(event: Any) -> Place:
    mark = event.start_mark
    return Place(mark.line + 1, mark.column + 1)


def explain(error: yaml.YAMLError, text: str) -> tuple[Place, str]:
    """Say where and why a text is not valid YAML.

    Args:
        error: What the parser raised.
        text: What it was parsing.
    """
    if isinstance(error, yaml.reader.ReaderError):
        position = text.find(chr(error.character))  # libyaml counts bytes, its twin characters
        found = f"the character U+{error.character:04X}"
        return place_of(text, max(position, 0)), f"{found} is not allowed in a text file"
    if not isinstance(error, yaml.MarkedYAMLError) or error.problem_mark is None:
        return Place(1, 1), f"this is not valid YAML: {error}"
    problem = error.problem or "syntax error"
    at, opened = error.problem_mark, error.context_mark or error.problem_mark
    character = _character(text, at.line, at.column)
    said = next((ours for theirs, ours in _TEXTS if theirs in problem), f"no YAML: {problem}")
    said = _TAB if character == "\t" else said
    shown = at if character else opened  # at the file's end, what was not closed says more
    end = text.rstrip()
    return (
        min(Place(shown.line + 1, shown.column + 1), place_of(end, max(len(end) - 1, 0))),
        said.format(opened=opened.line + 1, character=repr(character)),
    )


def _character(text: str, line: int, column: int) -> str:
    """The character at a mark; nothing at the end of a line or of the text."""
    lines = text.split("\n", line + 1)
    return lines[line][column : column + 1] if line < len(lines) else ""


def place_of(text: str, position: int) -> Place:
    """The line and column of a character."""
    before = text[:position]
    return Place(before.count("\n") + 1, position - before.rfind("\n"))
