"""What the YAML parser's complaints mean, in words for people."""

from typing import Final

import yaml

from openrooms_usd.description.mistakes import Place

# What libyaml (or its Python twin) says, and what a person needs to hear; the first match counts.
_TEXTS: Final = (
    ("could not find expected ':'", "a key needs a colon and a space after it"),
    ("unexpected end of stream", "the text that was opened with a quote here is not closed"),
    ("',' or ']'", "the list that was opened with [ in line {opened} lacks a comma or its ]"),
    ("',' or '}'", "the mapping that was opened with {{ in line {opened} lacks a comma or its }}"),
    ("cannot start any token", "{character} cannot stand here; quote the text"),
    ("mapping values are not allowed", "a colon does not fit here: check the indentation"),
    ("'-' indicator", "this line does not fit those above it: check the indentation"),
    ("did not find expected key", "this line does not fit those above it: check the indentation"),
    ("<block end>", "this line does not fit those above it: check the indentation"),
    ("undefined tag handle", "tags are not allowed"),
    ("unknown escape character", "after a backslash in double quotes only \\n, \\t and so on"),
    ("<document start>", "nothing may follow the end of the description"),
    ("node content", "a value is missing, or the text ends too early"),
)
_TAB: Final = "a tab cannot indent; use spaces"


def explain(error: yaml.YAMLError, text: str) -> tuple[Place, str]:
    """Say where a text is no YAML, and why.

    Args:
        error: What the parser raised.
        text: What it was parsing.
    """
    if isinstance(error, yaml.reader.ReaderError):
        position = text.find(chr(error.character))  # libyaml counts bytes, its twin characters
        found = f"the character U+{error.character:04X}"
        return place_of(text, max(position, 0)), f"{found} has no place in a text file"
    if not isinstance(error, yaml.MarkedYAMLError) or error.problem_mark is None:
        return Place(1, 1), f"this is no YAML: {error}"
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
